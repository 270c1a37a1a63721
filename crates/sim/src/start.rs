//! State at time zero: settled on the ground, or raw.
//!
//! Both engines start from the same state. The settled start is a solution of the equations of
//! motion in `mechanics`: a static equilibrium on the ground, by Newton's method.

use crate::error::{NoRest, PlantError};
use crate::mechanics::{Forces, Kinematics, Mechanics, State};
use crate::setup::{PlantSetup, StartKind};
use crate::truth::BarTruth;
use nalgebra::{Matrix4, SMatrix, SVector, Vector4};
use robhaz_model::{Bar, Vec2};
use robhaz_terrain::Terrain;

/// State at time zero, the same for both engines. Wheel spins count from here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Start {
    /// Coordinates and rates.
    pub state: State,
    /// Integrals of the speed errors, rad.
    pub integrals: [f64; 3],
    /// Pose and rates of each bar in this state, in the order of [`Bar::ALL`].
    pub bars: [BarTruth; 4],
}

impl Start {
    /// The state that the setup asks for.
    ///
    /// # Errors
    /// [`PlantError::RawStart`], [`PlantError::Stance`] and [`PlantError::NoRest`].
    pub fn new(setup: &PlantSetup) -> Result<Self, PlantError> {
        match setup.engine.start {
            StartKind::Raw => raw(setup),
            StartKind::Settled => settled(setup).map_err(|why| {
                // If the robot cannot stand on level ground either, the robot is the reason.
                let stance = setup.robot.check_stance().err();
                stance.map_or(PlantError::NoRest { why }, PlantError::Stance)
            }),
        }
    }

    /// The nominal pose at rest, lowered by the penetration under the mean wheel load, on any
    /// ground.
    pub fn nominal(setup: &PlantSetup) -> Self {
        let geometry = &setup.robot.geometry;
        let lowered = Vec2::new(0.0, -setup.contact.mean_penetration(&setup.robot));
        Self {
            state: State {
                q: geometry.pins.q + lowered,
                ..State::default()
            },
            integrals: [0.0; 3],
            bars: Bar::ALL.map(|bar| BarTruth {
                position: geometry.cg(bar) + lowered,
                ..BarTruth::default()
            }),
        }
    }
}

/// The nominal pose, if each wheel has contact and is at most 1.5 times as deep as under the mean
/// wheel load.
fn raw(setup: &PlantSetup) -> Result<Start, PlantError> {
    let start = Start::nominal(setup);
    let (rest, radius) = (
        setup.contact.mean_penetration(&setup.robot),
        setup.robot.geometry.wheel_radius,
    );
    for (i, axle) in setup.robot.geometry.axles.iter().enumerate() {
        let nearest = setup.terrain.nearest(axle - Vec2::new(0.0, rest));
        let depth = nearest.map_or(f64::NEG_INFINITY, |contact| radius - contact.distance);
        // In this form a NaN is an error, too.
        if !(depth > 0.0 && depth < 1.5 * rest) {
            let wheel = i + 1;
            return Err(PlantError::RawStart { wheel, depth, rest });
        }
    }
    Ok(start)
}

/// Unknowns of the equilibrium: position of Q (m), angles of links 1 and 2 (rad), creep speed of
/// the middle wheel (m/s), motor torques (N m).
type Unknowns = SVector<f64, 8>;

/// Largest number of steps of Newton's method; about ten are needed.
const MOST_STEPS: usize = 50;
/// Shift of an unknown in a difference quotient, m, rad, m/s, N m. In a position it changes N by
/// 0.2 mN.
const SHIFT: f64 = 1e-9;
/// Newton's method has converged when no unknown changes by more. In a position it is 0.2 uN of N.
const CONVERGED: f64 = 1e-12;
/// Singular values below this count as zero. Those of a robot on ground with friction are above
/// 1e-3.
const SINGULAR: f64 = 1e-9;
/// Largest acceleration at rest, m/s^2 and rad/s^2: 0.01 mN on 14 kg.
const AT_REST: f64 = 1e-6;

/// Static equilibrium near the nominal pose, with the middle wheel at its nominal x.
///
/// # Errors
/// [`NoRest`]
fn settled(setup: &PlantSetup) -> Result<Start, NoRest> {
    let mut equilibrium = Equilibrium {
        setup,
        mechanics: Mechanics::new(setup),
    };
    let pose = pose_on_ground(setup).ok_or(NoRest::Pose)?;
    equilibrium.solve(&pose)
}

/// The pose near the nominal one in which each wheel has the mean penetration, by Newton's method
/// on the distances from the ground.
fn pose_on_ground(setup: &PlantSetup) -> Option<State> {
    let robot = &setup.robot;
    let goal = robot.geometry.wheel_radius - setup.contact.mean_penetration(&setup.robot);
    let mut state = Start::nominal(setup).state;
    for _ in 0..MOST_STEPS {
        let kinematics = Kinematics::new(robot, &state).ok()?;
        let (rows, distances) = tangents(&setup.terrain, &kinematics)?;
        let [front, middle, rear] = distances.map(|distance| goal - distance);
        let ahead = robot.geometry.axles[1].x - kinematics.axle(1).x;
        let right = Vector4::new(front, middle, rear, ahead);
        let mut matrix = rows;
        let x_of_the_middle = kinematics.axle_row(1, Vec2::x());
        matrix.set_row(3, &x_of_the_middle.transpose());
        let step = matrix.lu().solve(&right)?;
        state.q += Vec2::new(step[0], step[1]);
        state.angles[0] += step[2];
        state.angles[1] += step[3];
        if step.amax() < 1e-6 {
            return Some(state);
        }
    }
    None
}

/// Rows of a Jacobian, and the distances of the wheels' centres from the ground, m. The product of
/// rows 1 to 3 with the four rates is the speed of each wheel away from the ground, that of row 4
/// the speed of the middle wheel along the ground, m/s.
fn tangents(terrain: &Terrain, kinematics: &Kinematics) -> Option<(Matrix4<f64>, [f64; 3])> {
    let (mut rows, mut distances) = (Matrix4::zeros(), [0.0; 3]);
    for (i, distance) in distances.iter_mut().enumerate() {
        let nearest = terrain.nearest(kinematics.axle(i))?;
        let row = kinematics.axle_row(i, nearest.normal());
        rows.set_row(i, &row.transpose());
        *distance = nearest.distance;
        if i == 1 {
            let row = kinematics.axle_row(i, nearest.tangent);
            rows.set_row(3, &row.transpose());
        }
    }
    Some((rows, distances))
}

/// The equations of equilibrium.
struct Equilibrium<'a> {
    setup: &'a PlantSetup,
    mechanics: Mechanics,
}

impl Equilibrium<'_> {
    /// Newton's method from a pose near the solution.
    fn solve(&mut self, pose: &State) -> Result<Start, NoRest> {
        let [a, b] = pose.angles;
        let mut z = Unknowns::from([pose.q.x, pose.q.y, a, b, 0.0, 0.0, 0.0, 0.0]);
        for _ in 0..MOST_STEPS {
            let (here, _) = self.evaluate(&z)?;
            let mut jacobian = SMatrix::<f64, 8, 8>::zeros();
            for column in 0..8 {
                let mut moved = z;
                moved[column] += SHIFT;
                let slope = (self.evaluate(&moved)?.0 - here) / SHIFT;
                jacobian.set_column(column, &slope);
            }
            // Without friction the creep speed is arbitrary; the pseudo-inverse chooses the
            // smallest solution.
            let step = jacobian.svd(true, true).solve(&here, SINGULAR);
            let step = step.map_err(|_| NoRest::Equilibrium)?;
            z -= step;
            if step.amax() < CONVERGED {
                self.check_rest(&z)?;
                let (kinematics, integrals) = self.kinematics(&z)?;
                return Ok(Start {
                    state: kinematics.state,
                    integrals,
                    bars: Bar::ALL.map(|bar| kinematics.bar(bar)),
                });
            }
        }
        Err(NoRest::Equilibrium)
    }

    /// Checks that nothing accelerates and that each wheel has one contact.
    fn check_rest(&mut self, z: &Unknowns) -> Result<(), NoRest> {
        let (residual, forces) = self.evaluate(z)?;
        for (i, ground) in forces.ground.iter().enumerate() {
            let (wheel, contacts) = (i + 1, ground.contacts);
            if !(ground.normal_force > 0.0 && contacts == 1) {
                return Err(NoRest::Contacts { wheel, contacts });
            }
        }
        match residual.amax() < AT_REST {
            true => Ok(()),
            false => Err(NoRest::Equilibrium),
        }
    }

    /// The residual, which is zero in equilibrium, and the forces. The residual contains the
    /// distance of the middle wheel from its nominal x (m) and the accelerations of Q (m/s^2),
    /// links and wheels (rad/s^2).
    fn evaluate(&mut self, z: &Unknowns) -> Result<(Unknowns, Forces), NoRest> {
        let (kinematics, _) = self.kinematics(z)?;
        let mut forces = Forces::default();
        let solved = forces.solve(&mut self.mechanics, &kinematics, [z[5], z[6], z[7]]);
        solved.map_err(|_| NoRest::Equilibrium)?;
        let x = kinematics.axle(1).x - self.setup.robot.geometry.axles[1].x;
        let [a, b, c, d] = forces.accelerations.into();
        let [front, middle, rear] = forces.omega_rates.into();
        let residual = Unknowns::from([x, a, b, c, d, front, middle, rear]);
        Ok((residual, forces))
    }

    /// The state that belongs to the unknowns, and the integrals of the control. The wheels keep
    /// their penetration while the robot creeps; the torques of the control come from its integral
    /// or, without integral gain, from a speed error.
    fn kinematics(&self, z: &Unknowns) -> Result<(Kinematics, [f64; 3]), NoRest> {
        let mut state = self.pose(z).ok_or(NoRest::Equilibrium)?;
        let drive = &self.setup.drive;
        let mut integrals = [0.0; 3];
        for i in 0..3 {
            let torque = z[5 + i];
            if drive.ki > 0.0 {
                integrals[i] = torque / drive.ki;
            } else if drive.kp > 0.0 {
                state.omega[i] = -torque / drive.kp;
            }
            // A control without gains exerts no torque.
            let limit = match drive.ki > 0.0 || drive.kp > 0.0 {
                true => drive.torque_limit,
                false => AT_REST,
            };
            if torque.abs() > limit {
                let wheel = i + 1;
                return Err(NoRest::Motor {
                    wheel,
                    torque,
                    limit,
                });
            }
        }
        let kinematics = Kinematics::new(&self.setup.robot, &state);
        let kinematics = kinematics.map_err(|_| NoRest::Equilibrium)?;
        Ok((kinematics, integrals))
    }

    /// Pose and rates that belong to the unknowns, with all wheel spins at zero.
    fn pose(&self, z: &Unknowns) -> Option<State> {
        let mut state = State {
            q: Vec2::new(z[0], z[1]),
            angles: [z[2], z[3]],
            ..State::default()
        };
        let kinematics = Kinematics::new(&self.setup.robot, &state).ok()?;
        let (rows, _) = tangents(&self.setup.terrain, &kinematics)?;
        state.rates = rows.lu().solve(&Vector4::new(0.0, 0.0, 0.0, z[4]))?;
        Some(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_model::StanceError;
    use robhaz_terrain::{Heights, Interpolation, Profile};

    fn slope(slope: f64) -> Profile {
        let points = [-5.0, 5.0].map(|x| Vec2::new(x, slope * x)).to_vec();
        Profile::Heights(Heights::new(points, Interpolation::Corners))
    }

    fn refusal(setup: &PlantSetup) -> Option<PlantError> {
        Start::new(setup).err()
    }

    /// Each start that fails states its reason.
    #[test]
    fn a_start_that_fails_says_why() {
        assert_eq!(refusal(&PlantSetup::on(Profile::Flat)), None);

        let mut weak = PlantSetup::on(slope(0.2));
        assert_eq!(refusal(&weak), None);
        weak.drive.torque_limit = 0.1;
        let found = refusal(&weak);
        assert!(
            matches!(found, Some(PlantError::NoRest { why: NoRest::Motor { limit, .. } }) if limit < 0.11),
            "{found:?}"
        );

        let mut slippery = PlantSetup::on(slope(0.2));
        slippery.friction.mu_s = 0.1;
        slippery.friction.mu_d = 0.1;
        let found = refusal(&slippery);
        assert!(
            matches!(found, Some(PlantError::NoRest { .. })),
            "{found:?}"
        );

        let mut tipping = PlantSetup::on(Profile::Flat);
        tipping.robot.geometry.body_cg.x = 1.0;
        let found = refusal(&tipping);
        assert!(
            matches!(
                found,
                Some(PlantError::Stance(StanceError::TipsForward { .. }))
            ),
            "{found:?}"
        );

        let mut hollow = PlantSetup::on(slope(0.2));
        hollow.engine.start = StartKind::Raw;
        let found = refusal(&hollow)
            .map(|why| why.to_string())
            .unwrap_or_default();
        assert!(found.contains("must be level"), "{found}");
    }
}
