//! From the states of both sides to the inputs of the nine rows, with their covariance; and what
//! errs in the rows beside the inputs.

use super::posture::bogie_index;
use super::solve::{CORNERING, INPUTS, InputCovariance, WholeForces, input};
use super::{
    JointMotion, Joints, Link, Rows, Vec3, WholeEquilibrium, WholeError, WholeMotion, WholePosture,
};
use crate::filters::motion::SLOPE;
use crate::methods::SideState;
use crate::settings::NoiseBudget;
use crate::statics::{CAUSES, DIRECT, LoadCovariance};
use nalgebra::SVector;
use robhaz_model::{Coupling, Vec2, WholeRover, perp};

/// What both sides' states say of the rover, SI.
#[derive(Clone, Copy, Debug)]
pub(super) struct SideInputs<'a> {
    states: [&'a SideState; 2],
    /// Index of the link that carries the bogie's wheels.
    bogie: usize,
    /// Sine and cosine of the inclination.
    along: [f64; 2],
    /// Inclination of the body, rad, nose up, and its standard deviation.
    pub inclination: f64,
    inclination_sigma: f64,
    /// Standard deviation of the angles of the bogies, rad.
    pub bogie_sigma: [f64; 2],
    pub joints: Joints,
    /// Whether each wheel is steered.
    pub steered: [bool; 6],
    /// [`Joints::inclinations`], rad.
    along_wheels: [f64; 6],
    coupling: JointMotion,
    pins: [JointMotion; 2],
    /// Pitch rate (rad/s) and acceleration (rad/s^2) of the body, nose up.
    pitch: JointMotion,
}

impl<'a> SideInputs<'a> {
    /// `coupled` are angle (rad) and rate (rad/s) of a rear bogie's roll; `roll` (rad) is that of the body,
    /// left side up.
    ///
    /// The body of a differential has the mean angle of both rockers, and half of their difference
    /// is the differential's.
    pub fn new(
        rover: &WholeRover,
        states: [&'a SideState; 2],
        coupled: (f64, f64),
        steering: [f64; 6],
        roll: f64,
    ) -> Result<Self, WholeError> {
        let bogie = bogie_index(rover)?;
        let [left, right] = states.map(|state| state.links);
        let (rocker_l, rocker_r) = if bogie == 0 {
            (left[1], right[1])
        } else {
            (left[0], right[0])
        };
        let half = |f: fn(f64, f64) -> f64| {
            core::array::from_fn::<f64, 3, _>(|k| 0.5 * f(rocker_l[k], rocker_r[k]))
        };
        let [inclination, pitch_rate, pitching] = half(|a, b| a + b);
        let motion = |[_, rate, acceleration]: [f64; 3]| JointMotion { rate, acceleration };
        let (coupling, angle) = match rover.coupling {
            Coupling::Differential => {
                let differential = half(|a, b| a - b);
                (motion(differential), differential[0])
            }
            Coupling::RearBogie => (
                JointMotion {
                    rate: coupled.1,
                    acceleration: 0.0,
                },
                coupled.0,
            ),
        };
        // Rear halves turn with the body in pitch.
        let parents = match rover.coupling {
            Coupling::Differential => [rocker_l, rocker_r],
            Coupling::RearBogie => [[inclination, pitch_rate, pitching]; 2],
        };
        let bogies = [left, right].map(|links| if bogie == 0 { links[0] } else { links[1] });
        let pin =
            |side: usize| core::array::from_fn::<f64, 3, _>(|k| bogies[side][k] - parents[side][k]);
        let pins = [pin(0), pin(1)];
        let [of_bogies, of_rockers] =
            [bogie, 1 - bogie].map(|link| states.map(|state| state.angle_sigma[link]));
        let joints = Joints {
            coupling: angle,
            pins: pins.map(|pin| pin[0]),
            steering,
        };
        Ok(Self {
            states,
            bogie,
            along: libm::sincos(inclination).into(),
            along_wheels: joints.inclinations([inclination, roll]),
            inclination,
            // Both are those of the one inclinometer.
            inclination_sigma: 0.5 * (of_rockers[0] + of_rockers[1]),
            bogie_sigma: of_bogies,
            joints,
            steered: [false; 6],
            coupling,
            pins: pins.map(motion),
            pitch: JointMotion {
                rate: pitch_rate,
                acceleration: pitching,
            },
        })
    }

    /// Contact angles against the body's x-y plane, rad.
    pub fn contact_angles(&self) -> [f64; 6] {
        core::array::from_fn(|i| self.states[i / 3].contact_angle[i % 3] - self.along_wheels[i])
    }

    /// Mean square of the contact angles about their mean, rad^2.
    pub fn roughness(&self) -> f64 {
        let angles = self.contact_angles();
        let mean = angles.iter().sum::<f64>() / 6.0;
        angles
            .iter()
            .map(|angle| (angle - mean) * (angle - mean))
            .sum::<f64>()
            / 6.0
    }

    /// Tractions, N.
    pub fn traction(&self) -> [f64; 6] {
        core::array::from_fn(|i| self.states[i / 3].traction[i % 3])
    }

    /// Coefficients of the rolling resistance of the wheels, signed as their spin, -.
    pub fn rolling_resistance(&self) -> [f64; 6] {
        let share = self.friction_share();
        core::array::from_fn(|i| share[i] * self.states[i / 3].rolling_resistance)
    }

    /// Smoothed signs of the spins, by which friction resists: -1 to 1.
    pub fn friction_share(&self) -> [f64; 6] {
        core::array::from_fn(|i| self.states[i / 3].friction_share[i % 3])
    }

    /// Slip speed of the wheels at T = N, m/s.
    pub fn creep(&self) -> [f64; 6] {
        core::array::from_fn(|i| self.states[i / 3].creep[i % 3])
    }

    /// Mean forward speed of both sides, m/s.
    pub fn speed(&self) -> f64 {
        0.5 * (self.states[0].velocity.x + self.states[1].velocity.x)
    }

    /// Motion of the rover in a posture, for the roll's angle (rad), rate (rad/s) and acceleration
    /// (rad/s^2), and the rate (rad/s) and acceleration (rad/s^2) of yaw.
    pub fn motion(
        &self,
        rover: &WholeRover,
        posture: &WholePosture,
        [roll, roll_rate, rolling]: [f64; 3],
        [yaw_rate, yawing]: [f64; 2],
    ) -> WholeMotion {
        let [sp, cp] = self.along;
        let (sr, cr) = libm::sincos(roll);
        let mut specific_force = Vec3::new(sp, cp * sr, cp * cr) * rover.side.gravity;
        let ahead = rover.ahead_of_middle();
        specific_force.x -= yaw_rate * yaw_rate * ahead;
        specific_force.y += self.speed() * yaw_rate + yawing * ahead;
        for (side, state) in self.states.into_iter().enumerate() {
            // Of Q, in the body's plane; less what the turning of its link adds.
            let a = state.acceleration;
            let of_q = Vec2::new(cp * a.x + sp * a.y, cp * a.y - sp * a.x);
            let arm = Vec2::new(posture.q[side].x, posture.q[side].z);
            let [_, rate, turning] = state.links[1 - self.bogie];
            let of_o = of_q - perp(arm) * turning + arm * (rate * rate);
            specific_force += Vec3::new(0.5 * of_o.x, 0.0, 0.5 * of_o.y);
        }
        WholeMotion {
            specific_force,
            rate: Vec3::new(roll_rate, -self.pitch.rate, yaw_rate),
            acceleration: Vec3::new(rolling, -self.pitch.acceleration, yawing),
            coupling: self.coupling,
            pins: self.pins,
            spin: core::array::from_fn(|i| {
                let [rate, acceleration] = self.states[i / 3].spin[i % 3];
                JointMotion { rate, acceleration }
            }),
        }
    }

    /// Covariance of the inputs, for the standard deviation of the roll, rad. The sides' errors are
    /// independent but for those of the body's attitude, which turn gravity and all contacts.
    pub fn covariance(&self, rover: &WholeRover, roll_sigma: f64) -> InputCovariance {
        let mut covariance = self.attitude(rover, roll_sigma);
        for (side, state) in self.states.into_iter().enumerate() {
            for (cause, row) in state.covariance.iter().enumerate() {
                for (other, entry) in row.iter().enumerate() {
                    for (a, by_a) in self.effect(side, cause) {
                        for (b, by_b) in self.effect(side, other) {
                            if let Some(sum) = covariance.get_mut((a, b)) {
                                *sum += by_a * by_b * entry;
                            }
                        }
                    }
                }
            }
        }
        covariance
    }

    /// Covariance of the part of the inputs' errors that is no state of the filters: of attitude and
    /// torque observers.
    pub fn noise(&self, rover: &WholeRover, roll_sigma: f64) -> InputCovariance {
        let mut covariance = self.attitude(rover, roll_sigma);
        for (side, state) in self.states.into_iter().enumerate() {
            for (i, sigma) in state.noise.iter().enumerate() {
                let k = input::TRACTION + 3 * side + i;
                if let Some(variance) = covariance.get_mut((k, k)) {
                    *variance += sigma * sigma;
                }
            }
        }
        covariance
    }

    /// The body's attitude errs with gravity and all contacts.
    fn attitude(&self, rover: &WholeRover, roll_sigma: f64) -> InputCovariance {
        let gravity = rover.side.gravity;
        let mut of_inclination = SVector::<f64, INPUTS>::zeros();
        of_inclination[0] = gravity * self.inclination_sigma;
        for angle in of_inclination.iter_mut().skip(input::CONTACT_ANGLE).take(6) {
            *angle = -self.inclination_sigma;
        }
        let mut covariance = of_inclination * of_inclination.transpose();
        let of_roll = gravity * roll_sigma;
        covariance[(1, 1)] += of_roll * of_roll;
        covariance
    }

    /// The inputs that acceleration x, y, contact angles, rolling resistance and tractions of a side
    /// change, with the derivatives: both sides' accelerations count by half.
    #[inline(always)]
    fn effect(&self, side: usize, cause: usize) -> [(usize, f64); 2] {
        let [sp, cp] = self.along;
        match cause {
            0 => [(0, 0.5 * cp), (2, -0.5 * sp)],
            1 => [(0, 0.5 * sp), (2, 0.5 * cp)],
            2..5 => [(input::CONTACT_ANGLE + 3 * side + cause - 2, 1.0), (0, 0.0)],
            5 => [(input::ROLLING_RESISTANCE + side, 1.0), (0, 0.0)],
            _ => [(input::TRACTION + 3 * side + cause - DIRECT, 1.0), (0, 0.0)],
        }
    }

    /// Derivatives by the uncertain inputs of each side's filters of what has these by the inputs of
    /// the rows.
    pub fn gradient(&self, by_inputs: &[f64; INPUTS]) -> [[f64; crate::state::INPUTS]; 2] {
        let of_side = |side: usize, state: &SideState| {
            let by_causes: [f64; CAUSES] = core::array::from_fn(|cause| {
                let mut sum = 0.0;
                for (k, derivative) in self.effect(side, cause) {
                    sum += by_inputs.get(k).map_or(0.0, |by| by * derivative);
                }
                sum
            });
            state.gradient(&by_causes)
        };
        let [left, right] = self.states;
        [of_side(0, left), of_side(1, right)]
    }
}

/// Normal forces at rest on level ground, N.
pub(super) fn level_loads(rover: &WholeRover) -> Result<[f64; 6], WholeError> {
    let posture = WholePosture::new(rover, &Joints::default())?;
    let motion = WholeMotion::at_rest(rover.side.gravity, 0.0, 0.0);
    let equations = WholeEquilibrium::new(rover, &posture, &motion, &[0.0; 6])?;
    let exact = InputCovariance::zeros();
    Ok(equations.solve(&[0.0; 6], &exact)?.normal)
}

/// Adds to the covariance of N what the load parameters of both sides err by. The covariance is that of one side. The
/// errors of both sides count as independent, except that the rover's total mass has the same relative error as a
/// side's; across, the centre of mass is known as well as along.
fn consider_loads(
    rover: &WholeRover,
    posture: &WholePosture,
    loads: &LoadCovariance,
    specific_force: Vec3,
    equations: &WholeEquilibrium,
    forces: &mut WholeForces,
) {
    let across = Vec3::y() * robhaz_model::sqrt(2.0 * loads.of_moment_along());
    let across = across.cross(&specific_force);
    forces.consider(&equations.of_load(Link::Body, Vec3::zeros(), Vec3::zeros(), across));
    let total = 0.5 * loads.rows()[0][0].max(0.0);
    forces.consider(&(equations.f * (robhaz_model::sqrt(total) / rover.side.mass.total())));
    let links = posture.bogie.iter().zip(&posture.rocker).zip(posture.q);
    for (side, ((bogie, rocker), q)) in links.enumerate() {
        let zero = Vec3::zeros();
        let moment =
            |link, turned: Vec3| equations.of_load(link, zero, zero, turned.cross(&specific_force));
        let [x, z] = [Vec3::x(), Vec3::z()];
        let of_bogie = [x, z].map(|axis| moment(Link::Bogie(side), bogie.turn * axis));
        // A side alone shows the sum of body and rocker.
        let of_rocker = [x, z].map(|axis| {
            let of_rocker = moment(Link::Rocker(side), rocker.turn * axis);
            (of_rocker + moment(Link::Body, axis)) * 0.5
        });
        let of_mass = equations.of_load(Link::Body, q, specific_force, zero);
        let ([x1, z1], [x2, z2]) = if matches!(bogie_index(rover), Ok(0)) {
            (of_bogie, of_rocker)
        } else {
            (of_rocker, of_bogie)
        };
        let [xb, zb] = of_rocker;
        forces.consider_parameters(&[of_mass, x1, z1, x2, z2, xb, zb], loads);
    }
}

/// Standard deviation of the angle of a bogie that is not read, rad: it turns with the ground under its wheels, by the
/// difference of two slopes.
/// Chosen.
pub(super) const UNREAD: f64 = core::f64::consts::SQRT_2 * SLOPE;

/// Adds to the covariance of N what no reading shows and lasts: places and masses of the parts, errors of the
/// steering, and rolling resistance as far as the torques do not show it; and what the bogies' angles err by.
pub(super) fn consider(
    rover: &WholeRover,
    posture: &WholePosture,
    inputs: &SideInputs<'_>,
    budget: &NoiseBudget,
    specific_force: Vec3,
    equations: &WholeEquilibrium,
    forces: &mut WholeForces,
) {
    let mass = &rover.side.mass;
    let body = 2.0 * mass.body;
    if budget.body_cg > 0.0 {
        // A force through a point that is off by the deviation along each axis.
        for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
            let moment = (axis * budget.body_cg).cross(&(specific_force * body));
            forces.consider(&equations.of_load(Link::Body, Vec3::zeros(), Vec3::zeros(), moment));
        }
    }
    let [m1, m2, _] = mass.links.map(|link| budget.link_mass * link);
    let (bogie, rocker) = if matches!(bogie_index(rover), Ok(0)) {
        (m1, m2)
    } else {
        (m2, m1)
    };
    for (link, at, mass) in [
        (Link::Body, posture.body_centre, budget.payload),
        (Link::Rocker(0), posture.rocker_centres[0], rocker),
        (Link::Rocker(1), posture.rocker_centres[1], rocker),
        (Link::Bogie(0), posture.bogie_centres[0], bogie),
        (Link::Bogie(1), posture.bogie_centres[1], bogie),
    ] {
        if mass > 0.0 {
            let force = specific_force * mass;
            forces.consider(&equations.of_load(link, at, force, Vec3::zeros()));
        }
    }
    let of_steering = CORNERING * budget.steering * equations.mean_load;
    for (column, is_steered) in equations.h_a.iter().zip(inputs.steered) {
        if is_steered {
            forces.consider(&(column * of_steering));
        }
    }
    let traction = inputs.traction();
    for (side, sigma) in inputs.bogie_sigma.into_iter().enumerate() {
        let turn = Vec3::y() * sigma.min(UNREAD);
        let mut rows = equations.of_turn(side, turn, &forces.normal, &traction);
        for (i, axle) in posture.axles.iter().enumerate() {
            if posture.links[i] == Link::Bogie(side) {
                let moved = turn.cross(&(axle - posture.q[side]));
                let moment = moved.cross(&(specific_force * mass.wheel));
                rows -= equations.of_load(Link::Bogie(side), Vec3::zeros(), Vec3::zeros(), moment);
            }
        }
        forces.consider(&rows);
    }
    if let Some(loads) = &budget.load_covariance {
        consider_loads(rover, posture, loads, specific_force, equations, forces);
    }
    for kind in 0..2 {
        let mut rows = Rows::zeros();
        for (i, n) in forces.normal.iter().enumerate() {
            // As if N acted ahead of the axle.
            let left = inputs.states[i / 3].rolling_left[kind][i % 3];
            rows += equations.of_shift(i, left * rover.side.geometry.wheel_radius, *n);
        }
        forces.consider(&rows);
    }
}
