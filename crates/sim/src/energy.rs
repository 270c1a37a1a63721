//! Mechanical energy, and a check that the integration does not create energy.

use crate::engine::Instant;
use crate::error::NoTruth;
use crate::truth::Truth;
use robhaz_model::{Bar, Robot};

/// Kinetic and potential energy of bars, wheels and rotors, J. The potential energy is zero at y =
/// 0.
pub fn mechanical_energy(robot: &Robot, truth: &Truth) -> f64 {
    let mass = &robot.mass;
    let mut energy = 0.0;
    for bar in Bar::ALL {
        let (m, inertia) = mass.of(bar);
        let b = truth.bar(bar);
        energy += 0.5 * m * b.velocity.norm_squared() + 0.5 * inertia * b.rate * b.rate;
        energy += m * robot.gravity * b.position.y;
    }
    for (i, wheel) in truth.wheels.iter().enumerate() {
        let link = truth.bar(robot.geometry.carriers[i].bar());
        energy += 0.5 * mass.wheel * truth.wheel_velocity(robot, i).norm_squared();
        energy += mass.wheel * robot.gravity * wheel.position.y;
        // The disc has its absolute spin, the rotor its spin relative to the link.
        energy += 0.5 * mass.wheel_inertia * (wheel.omega - link.rate).powi(2);
        energy += 0.5 * mass.rotor_inertia * wheel.omega * wheel.omega;
    }
    energy
}

/// Checks that a run is passive apart from its motors.
///
/// Gears, friction, contacts and stops dissipate energy or return what they have stored, with any
/// parameters of their laws. The mechanical energy plus the elastic energy of contacts and stops,
/// less the work of the motors, therefore cannot rise. A rise means that the integration is wrong.
/// The check needs no sum over the losses, so it is valid for any distance between records, and at
/// edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnergyWatch {
    /// Minimum since the start, J.
    minimum: f64,
    /// Allowed rise above the minimum, J.
    allowed: f64,
}

impl EnergyWatch {
    /// Allowed rise, as a share of weight times wheel radius: 14 mJ for the default robot, as much
    /// as lifts it by 0.1 mm.
    ///
    /// The shipped scenes show 0.3 uJ, and 30 uJ at the largest tolerance. The terrain may merge
    /// two nearest points in a tight bend into one contact; the elastic energy then jumps by up to
    /// about 8 mJ.
    const ALLOWED: f64 = 1e-3;

    pub fn new(robot: &Robot) -> Self {
        let weight = robot.mass.total() * robot.gravity;
        Self {
            minimum: f64::INFINITY,
            allowed: Self::ALLOWED * weight * robot.geometry.wheel_radius,
        }
    }

    /// Checks the next instant.
    ///
    /// # Errors
    /// [`NoTruth::EnergyMade`]
    pub fn check(&mut self, robot: &Robot, instant: &Instant) -> Result<(), NoTruth> {
        let truth = &instant.truth;
        let [a, b, _] = truth.links.map(|link| link.angle);
        let stop = robot.geometry.stop.energy(a - b);
        let stored = mechanical_energy(robot, truth) + instant.contact_energy + stop;
        let passive = stored - instant.balance.motor_work;
        self.minimum = self.minimum.min(passive);
        let made = passive - self.minimum;
        if made > self.allowed {
            return Err(NoTruth::EnergyMade { made });
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use super::*;
    use crate::engine::Balance;
    use crate::{EngineKind, Plant, PlantError, PlantSetup, StartKind};
    use robhaz_terrain::Profile;

    fn setup(engine: EngineKind, profile: Profile) -> PlantSetup {
        let mut setup = PlantSetup::on(profile);
        (setup.engine.kind, setup.engine.tolerance) = (engine, 1e-4);
        setup
    }

    /// The first error of a run, if any.
    fn run(setup: &PlantSetup, seconds: u32) -> Result<(), PlantError> {
        let mut plant = Plant::new(setup)?;
        (0..1000 * seconds).try_for_each(|_| plant.next_truth().map(|_| ()))
    }

    /// Sensitivity: a damping whose time constant m/c is 1.5 us, with parts of a step of 77 us,
    /// creates energy, and the run stops with this reason.
    #[test]
    fn a_step_too_long_is_noticed() {
        let mut too_long = setup(EngineKind::Rapier, Profile::smooth());
        (too_long.engine.step, too_long.contact.damping) = (1e-3, 1e6);
        let found = run(&too_long, 4);
        println!("{found:?}");
        assert!(
            matches!(
                found,
                Err(PlantError::NoTruth {
                    why: NoTruth::EnergyMade { .. },
                    ..
                })
            ),
            "{found:?}"
        );
    }

    /// Conservation: kerbs, stairs and a constant c create no energy, with periods of 1 ms and of
    /// 0.1 s.
    #[test]
    fn correct_runs_pass() {
        for engine in EngineKind::ALL {
            for (profile, ramp) in [
                (Profile::Stairs(robhaz_terrain::Stairs::step()), 1e-4),
                (Profile::Stairs(Default::default()), 0.0),
            ] {
                let mut setup = setup(engine, profile);
                setup.contact.damping_ramp = ramp;
                setup.engine.start = StartKind::Raw;
                assert_eq!(run(&setup, 6), Ok(()));
                setup.period = 0.1;
                let mut plant = Plant::new(&setup).unwrap();
                assert!((0..60).all(|_| plant.next_truth().is_ok()));
            }
        }
    }

    /// Closed form: a rise above the allowed one is an error, wherever the minimum was.
    #[test]
    fn a_rise_is_an_error() {
        let robot = Robot::default_a();
        let mut watch = EnergyWatch::new(&robot);
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
        assert_eq!(watch.check(&robot, &at(1.0, 0.0)), Ok(()));
        assert_eq!(watch.check(&robot, &at(1.5, 0.8)), Ok(()));
        assert_eq!(watch.check(&robot, &at(1.0, 0.29)), Ok(()));
        let made = watch.check(&robot, &at(1.0, 0.28));
        assert!(matches!(made, Err(NoTruth::EnergyMade { made }) if (made - 0.02).abs() < 1e-12));
    }
}
