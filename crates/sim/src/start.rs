//! Where a simulation starts: settled on its ground, or raw as the reference runs do.

use crate::direct::{Equations, Forces, Kinematics, State};
use crate::plant::{PlantError, PlantSetup};
use crate::truth::BarTruth;
use nalgebra::{Matrix4, SMatrix, SVector, Vector4};
use robhaz_model::{Bar, Vec2};
use robhaz_terrain::Terrain;

/// How the robot stands at time zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StartKind {
    /// In static equilibrium under its weight, the drive holding it: nothing changes until the drive starts.
    ///
    /// On a slope no friction law without true stiction holds a wheel: there the robot creeps, steadily.
    #[default]
    Settled,
    /// In the nominal pose, at rest, each wheel at the penetration of the mean wheel load: it still has to settle.
    Raw,
}

impl StartKind {
    /// All kinds, in their order.
    pub const ALL: [Self; 2] = [Self::Settled, Self::Raw];

    /// Name in scene files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Settled => "settled",
            Self::Raw => "raw",
        }
    }
}

/// Why a settled start finds no static equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoRest {
    /// There is no pose near the nominal one with all three wheels on the ground.
    #[error("no pose near the nominal one has all three wheels on the ground")]
    Pose,
    /// The equations of equilibrium have no solution near that pose.
    #[error("with all three wheels on the ground, neither friction nor the linkage holds it there")]
    Equilibrium,
    /// A motor cannot hold its wheel.
    #[error(
        "the motor of wheel {wheel} would have to hold {torque:.1} N m, and gives {limit:.1} N m at most"
    )]
    Motor {
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Torque in equilibrium, N m.
        torque: f64,
        /// Greatest torque of motor and control, N m.
        limit: f64,
    },
    /// A wheel hangs in the air, or touches at more than one place.
    #[error("wheel {wheel} would touch the ground at {contacts} places instead of one")]
    Contacts {
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// How many.
        contacts: u32,
    },
}

/// State at time zero, the same for every engine. All wheel spins count from here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Start {
    /// Positions and rates.
    pub state: State,
    /// Integrals of the speed errors, rad.
    pub integrals: [f64; 3],
    /// The same positions and rates bar by bar, in the order of [`Bar::ALL`].
    pub bars: [BarTruth; 4],
}

/// Unknowns of the equilibrium: x, y of Q (m), angles of links 1 and 2 (rad), the middle wheel's creep speed (m/s), motor torques (N m).
type Unknowns = SVector<f64, 8>;

/// Steps of Newton's method before it is given up; some ten are needed.
const MOST_STEPS: usize = 50;
/// Shift of an unknown for a difference quotient: 1 nm makes 0.2 mN of N.
const SHIFT: f64 = 1e-9;
/// Newton's method has converged where no unknown moves by more: 1 pm is 0.2 uN of N.
const CONVERGED: f64 = 1e-12;
/// Singular values below this are zero; those of a robot on ground with friction are above 1e-3.
const SINGULAR: f64 = 1e-9;
/// Accelerations left at rest, m/s^2 and rad/s^2: on 14 kg a hundredth of a millinewton.
const AT_REST: f64 = 1e-6;

impl Start {
    /// The state that the setup asks for.
    ///
    /// # Errors
    /// [`PlantError::Start`], [`PlantError::Stance`] and [`PlantError::NoRest`].
    pub fn new(setup: &PlantSetup) -> Result<Self, PlantError> {
        match setup.start {
            StartKind::Raw => raw(setup),
            StartKind::Settled => settled(setup).map_err(|why| {
                // A robot that would not even stand on level ground is at fault itself.
                let stance = setup.robot.check_stance().err();
                stance.map_or(PlantError::NoRest { why }, PlantError::Stance)
            }),
        }
    }

    /// The nominal pose, at rest, sunk by the static penetration of the mean wheel load, whatever the ground.
    fn nominal(setup: &PlantSetup) -> Self {
        let geometry = &setup.robot.geometry;
        let sunk = Vec2::new(0.0, -rest_depth(setup));
        Self {
            state: State {
                q: geometry.pins.q + sunk,
                ..State::default()
            },
            integrals: [0.0; 3],
            bars: Bar::ALL.map(|bar| BarTruth {
                position: geometry.cg(bar) + sunk,
                ..BarTruth::default()
            }),
        }
    }
}

/// Penetration under the mean wheel load, m.
fn rest_depth(setup: &PlantSetup) -> f64 {
    let load = setup.robot.mean_wheel_load();
    setup.contact.static_penetration(load)
}

/// The nominal pose, where each wheel touches and is no deeper than half as much again as under the mean load.
fn raw(setup: &PlantSetup) -> Result<Start, PlantError> {
    let start = Start::nominal(setup);
    let (rest, radius) = (rest_depth(setup), setup.robot.geometry.wheel_radius);
    for (i, axle) in setup.robot.geometry.axles.iter().enumerate() {
        let nearest = setup.terrain.nearest(axle - Vec2::new(0.0, rest));
        let depth = nearest.map_or(f64::NEG_INFINITY, |contact| radius - contact.distance);
        // Written so that a NaN fails too.
        if !(depth > 0.0 && depth < 1.5 * rest) {
            return Err(PlantError::Start {
                wheel: i + 1,
                depth,
                rest,
            });
        }
    }
    Ok(start)
}

/// Static equilibrium near the nominal pose, the middle wheel at its nominal x.
fn settled(setup: &PlantSetup) -> Result<Start, NoRest> {
    let mut balance = Balance {
        setup,
        equations: Equations::new(setup),
    };
    let pose = laid(setup).ok_or(NoRest::Pose)?;
    balance.solve(&pose)
}

/// The nominal pose laid on the ground by Newton's method on the distances alone: each wheel at the mean penetration.
fn laid(setup: &PlantSetup) -> Option<State> {
    let robot = &setup.robot;
    let goal = robot.geometry.wheel_radius - rest_depth(setup);
    let mut state = Start::nominal(setup).state;
    for _ in 0..MOST_STEPS {
        let kinematics = Kinematics::new(robot, &state).ok()?;
        let (rows, distances) = tangents(&setup.terrain, &kinematics, &state)?;
        let mut right = Vector4::zeros();
        for i in 0..3 {
            right[i] = goal - distances[i];
        }
        right[3] = robot.geometry.axles[1].x - kinematics.axle(1, &state).x;
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

/// Of each wheel the row that gives its speed off the ground from the four rates, last the middle wheel's along the ground; distances
/// of the centres from the ground, m.
fn tangents(
    terrain: &Terrain,
    kinematics: &Kinematics,
    state: &State,
) -> Option<(Matrix4<f64>, [f64; 3])> {
    let (mut rows, mut distances) = (Matrix4::zeros(), [0.0; 3]);
    for (i, distance) in distances.iter_mut().enumerate() {
        let nearest = terrain.nearest(kinematics.axle(i, state))?;
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
struct Balance<'a> {
    setup: &'a PlantSetup,
    equations: Equations,
}

impl Balance<'_> {
    /// Newton's method from a pose that is near.
    fn solve(&mut self, pose: &State) -> Result<Start, NoRest> {
        let [a, b] = pose.angles;
        let mut z = Unknowns::from([pose.q.x, pose.q.y, a, b, 0.0, 0.0, 0.0, 0.0]);
        for _ in 0..MOST_STEPS {
            let here = self.residual(&z)?;
            let mut jacobian = SMatrix::<f64, 8, 8>::zeros();
            for column in 0..8 {
                let mut moved = z;
                moved[column] += SHIFT;
                let slope = (self.residual(&moved)? - here) / SHIFT;
                jacobian.set_column(column, &slope);
            }
            // Without friction the creep speed does not matter: of all solutions the smallest.
            let step = jacobian.svd(true, true).solve(&here, SINGULAR);
            let step = step.map_err(|_| NoRest::Equilibrium)?;
            z -= step;
            if step.amax() < CONVERGED {
                self.check_rest(&z)?;
                return self.start(&z);
            }
        }
        Err(NoRest::Equilibrium)
    }

    /// Checks that all is at rest on three wheels, none in the air or wedged between two faces.
    fn check_rest(&mut self, z: &Unknowns) -> Result<(), NoRest> {
        let (residual, forces) = self.evaluate(z)?;
        for (i, ground) in forces.ground.iter().enumerate() {
            if !(ground.normal_force > 0.0 && ground.contacts == 1) {
                return Err(NoRest::Contacts {
                    wheel: i + 1,
                    contacts: ground.contacts,
                });
            }
        }
        if residual.amax() < AT_REST {
            Ok(())
        } else {
            Err(NoRest::Equilibrium)
        }
    }

    fn residual(&mut self, z: &Unknowns) -> Result<Unknowns, NoRest> {
        self.evaluate(z).map(|(residual, _)| residual)
    }

    /// What equilibrium makes zero: distance of the middle wheel from its place, m; accelerations of Q (m/s^2), links and wheels
    /// (rad/s^2); and the forces.
    fn evaluate(&mut self, z: &Unknowns) -> Result<(Unknowns, Forces), NoRest> {
        let start = self.start(z)?;
        let robot = &self.setup.robot;
        let kinematics = Kinematics::new(robot, &start.state).map_err(|_| NoRest::Equilibrium)?;
        let torques = [z[5], z[6], z[7]];
        let forces = self
            .equations
            .forces(&kinematics, &start.state, torques)
            .map_err(|_| NoRest::Equilibrium)?;
        let mut residual = Unknowns::zeros();
        residual[0] = kinematics.axle(1, &start.state).x - robot.geometry.axles[1].x;
        residual
            .fixed_rows_mut::<4>(1)
            .copy_from(&forces.accelerations);
        residual
            .fixed_rows_mut::<3>(5)
            .copy_from(&forces.omega_rates);
        Ok((residual, forces))
    }

    /// The state that belongs to the unknowns: wheels keep their penetration while the robot creeps, and the control gives
    /// its torques from its integral or, without one, from a speed error.
    fn start(&self, z: &Unknowns) -> Result<Start, NoRest> {
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
            // Beyond what motors and control can give there is no equilibrium.
            let limit = if drive.ki > 0.0 || drive.kp > 0.0 {
                drive.torque_limit
            } else {
                AT_REST
            };
            if torque.abs() > limit {
                return Err(NoRest::Motor {
                    wheel: i + 1,
                    torque,
                    limit,
                });
            }
        }
        let kinematics = Kinematics::new(&self.setup.robot, &state);
        let kinematics = kinematics.map_err(|_| NoRest::Equilibrium)?;
        Ok(Start {
            state,
            integrals,
            bars: Bar::ALL.map(|bar| kinematics.bar(bar, &state)),
        })
    }

    /// Pose and creep speed that belong to the unknowns, the wheels' spins at zero.
    fn pose(&self, z: &Unknowns) -> Option<State> {
        let mut state = State {
            q: Vec2::new(z[0], z[1]),
            angles: [z[2], z[3]],
            ..State::default()
        };
        let kinematics = Kinematics::new(&self.setup.robot, &state).ok()?;
        let (rows, _) = tangents(&self.setup.terrain, &kinematics, &state)?;
        state.rates = rows.lu().solve(&Vector4::new(0.0, 0.0, 0.0, z[4]))?;
        Some(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EngineKind, Plant};
    use robhaz_model::{Robot, StanceError};
    use robhaz_terrain::{Heights, Interpolation, Profile};

    fn setup(profile: Profile) -> PlantSetup {
        PlantSetup {
            robot: Robot::default_a(),
            terrain: Terrain::new(profile),
            contact: Default::default(),
            friction: Default::default(),
            stretches: Vec::new(),
            drive: Default::default(),
            start: StartKind::Settled,
            engine: EngineKind::Direct,
            step: 1.25e-4,
            tolerance: 1e-5,
            period: 1e-3,
            balance: false,
        }
    }

    fn slope(slope: f64) -> Profile {
        let points = [-5.0, 5.0].map(|x| Vec2::new(x, slope * x)).to_vec();
        Profile::Heights(Heights::new(points, Interpolation::Corners))
    }

    fn refusal(setup: &PlantSetup) -> Option<PlantError> {
        Plant::new(setup).err()
    }

    /// Each start that fails names its reason, before anything runs.
    #[test]
    fn a_start_that_fails_says_why() {
        assert_eq!(refusal(&setup(Profile::Flat)), None);

        let mut weak = setup(slope(0.2));
        assert_eq!(refusal(&weak), None);
        weak.drive.torque_limit = 0.1;
        let found = refusal(&weak);
        assert!(
            matches!(found, Some(PlantError::NoRest { why: NoRest::Motor { limit, .. } }) if limit < 0.11),
            "{found:?}"
        );

        let mut slippery = setup(slope(0.2));
        slippery.friction.mu_s = 0.1;
        slippery.friction.mu_d = 0.1;
        let found = refusal(&slippery);
        assert!(
            matches!(found, Some(PlantError::NoRest { .. })),
            "{found:?}"
        );

        let mut tipping = setup(Profile::Flat);
        tipping.robot.geometry.body_cg.x = 1.0;
        let found = refusal(&tipping);
        assert!(
            matches!(
                found,
                Some(PlantError::Stance(StanceError::TipsForward { .. }))
            ),
            "{found:?}"
        );

        let mut hollow = setup(slope(0.2));
        hollow.start = StartKind::Raw;
        let found = refusal(&hollow)
            .map(|why| why.to_string())
            .unwrap_or_default();
        assert!(
            found.contains("must be level") && !found.contains('['),
            "{found}"
        );
    }
}
