//! Energy: what the robot holds, and a watch over it that none is made from nothing.

use crate::plant::{Instant, PlantError};
use crate::truth::Truth;
use robhaz_model::{Bar, GRAVITY, Robot};

/// Kinetic and potential energy of bars, wheels and rotors, J; heights count from y = 0.
pub fn mechanical_energy(robot: &Robot, truth: &Truth) -> f64 {
    let mass = &robot.mass;
    let mut energy = 0.0;
    for bar in Bar::ALL {
        let (m, inertia) = mass.of(bar);
        let b = truth.bar(bar);
        energy += 0.5 * m * b.velocity.norm_squared() + 0.5 * inertia * b.rate * b.rate;
        energy += m * GRAVITY * b.position.y;
    }
    for (i, wheel) in truth.wheels.iter().enumerate() {
        let link = truth.bar(robot.geometry.carriers[i].bar());
        energy += 0.5 * mass.wheel * truth.wheel_velocity(robot, i).norm_squared();
        energy += mass.wheel * GRAVITY * wheel.position.y;
        // The disc turns absolutely, the rotor relative to the link.
        energy += 0.5 * mass.wheel_inertia * (wheel.omega - link.rate).powi(2);
        energy += 0.5 * mass.rotor_inertia * wheel.omega * wheel.omega;
    }
    energy
}

/// Watches over what a run holds beyond what its motors have given.
///
/// Gear, friction, contacts and stops only take energy or give back what they have stored, whatever their laws' numbers.
/// So mechanical energy, and that in the springs of contacts and stops, less the motors' work, can only fall; where it rises,
/// the integration makes energy, and the forces are not those of the laws. This needs no sum over the losses: it
/// holds however far apart the records are, and on edges too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watch {
    /// The least there has been, J.
    least: f64,
    /// How far it may rise, J.
    allowed: f64,
}

impl Watch {
    /// A rise allowed, of the weight on a wheel's radius: 14 mJ for the default robot, which would lift it by 0.1 mm.
    ///
    /// The shipped scenes show 0.3 uJ, 30 uJ at the loosest tolerance. But where the ground counts two places of a tight
    /// bend as one, a spring of some 8 mJ can come or go.
    const ALLOWED: f64 = 1e-3;

    pub fn new(robot: &Robot) -> Self {
        let weight = robot.mass.total() * GRAVITY;
        Self {
            least: f64::INFINITY,
            allowed: Self::ALLOWED * weight * robot.geometry.wheel_radius,
        }
    }

    /// Takes in one instant.
    ///
    /// # Errors
    /// [`PlantError::EnergyMade`].
    pub fn look(&mut self, robot: &Robot, instant: &Instant) -> Result<(), PlantError> {
        let truth = &instant.truth;
        let stop = robot
            .geometry
            .stop
            .energy(truth.links[0].angle - truth.links[1].angle);
        let held = mechanical_energy(robot, truth) + instant.contact_energy + stop;
        let own = held - instant.balance.motor_work;
        self.least = self.least.min(own);
        let made = own - self.least;
        if made > self.allowed {
            return Err(PlantError::EnergyMade {
                time: truth.time,
                made,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use super::*;
    use crate::balance::Balance;
    use crate::contact::ContactLaw;
    use crate::friction::FrictionLaw;
    use crate::{EngineKind, Plant, PlantSetup, StartKind};
    use robhaz_terrain::{Profile, Terrain};

    fn setup(engine: EngineKind, profile: Profile) -> PlantSetup {
        PlantSetup {
            robot: Robot::default_a(),
            terrain: Terrain::new(profile),
            contact: ContactLaw::default(),
            friction: FrictionLaw::default(),
            stretches: Vec::new(),
            drive: Default::default(),
            start: StartKind::Settled,
            engine,
            step: 1.25e-4,
            tolerance: 1e-4,
            period: 1e-3,
            balance: false,
        }
    }

    /// The first error of a run, if there is one.
    fn run(setup: &PlantSetup, seconds: u32) -> Result<(), PlantError> {
        let mut plant = Plant::new(setup)?;
        (0..1000 * seconds).try_for_each(|_| plant.next_truth().map(|_| ()))
    }

    /// A step far beyond what the contact bears makes energy: the run stops and says so, 0.14 s after the drive starts.
    #[test]
    fn a_step_too_long_is_noticed() {
        let too_long = PlantSetup {
            step: 5e-4,
            ..setup(EngineKind::Rapier, Profile::smooth())
        };
        let found = run(&too_long, 4);
        println!("{found:?}");
        assert!(
            matches!(found, Err(PlantError::EnergyMade { .. })),
            "{found:?}"
        );
    }

    /// Kerbs, stairs and a constant c are hard on the integration, but make no energy; nor does a coarse period.
    #[test]
    fn correct_runs_pass() {
        for engine in EngineKind::ALL {
            for (profile, ramp) in [(Profile::step(), 1e-4), (Profile::stairs(), 0.0)] {
                let mut setup = setup(engine, profile);
                setup.contact.damping_ramp = ramp;
                setup.start = StartKind::Raw;
                assert_eq!(run(&setup, 6), Ok(()));
                setup.period = 0.1;
                let mut plant = Plant::new(&setup).unwrap();
                assert!((0..60).all(|_| plant.next_truth().is_ok()));
            }
        }
    }

    /// Energy balance in closed form: a rise beyond what is allowed is an error, whenever it was least.
    #[test]
    fn a_rise_is_an_error() {
        let robot = Robot::default_a();
        let mut watch = Watch::new(&robot);
        let at = |contact_energy: f64, motor_work: f64| Instant {
            contact_energy,
            balance: Balance {
                motor_work,
                ..Balance::default()
            },
            ..Instant::default()
        };
        // 14 kg x 9.81 m/s^2 x 0.1 m / 1000.
        assert!((watch.allowed - 0.013_734).abs() < 1e-12);
        assert_eq!(watch.look(&robot, &at(1.0, 0.0)), Ok(()));
        assert_eq!(watch.look(&robot, &at(1.5, 0.8)), Ok(()));
        assert_eq!(watch.look(&robot, &at(1.0, 0.29)), Ok(()));
        let made = watch.look(&robot, &at(1.0, 0.28));
        assert!(
            matches!(made, Err(PlantError::EnergyMade { made, .. }) if (made - 0.02).abs() < 1e-12)
        );
    }
}
