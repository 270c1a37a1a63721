//! Stability limits of the step of `rapier`: contact, friction and drive.
//!
//! `rapier` keeps all forces constant over a step. Only the normal forces anticipate their change
//! in the step: see `rapier/damping.rs`. Let a force oppose a velocity with the slope s (force per
//! velocity), and let p be the acceleration per force. A step dt then multiplies the velocity by
//! `1 - dt s p`. For `dt s p > 2` the velocity alternates in sign and grows until a limit of force
//! or torque bounds it.

use crate::contact::ContactLaw;
use crate::drive::{Drive, FRICTION_SPEED};
use crate::friction::FrictionLaw;
use crate::mechanics::{Carriers, Kinematics, State};
use nalgebra::{Matrix3, SMatrix};
use robhaz_model::Robot;

/// Allowed step as a share of the limit of stability, for friction and for drive. Their sum stays
/// below 1. With the friction at a share of 0.4 the error of N is below 0.01 %, at 0.6 twice that,
/// at 0.9 it is 16 %.
pub(crate) const STABLE_SHARE: f64 = 0.4;

/// Largest number of parts of a step. An impact on an edge takes all of them: at the default step a
/// part is 15 us, and a wheel is stopped in 75 us. Stiff laws take as many as they need.
pub const MOST_PARTS: u32 = 13;

/// Longest step, s, for the contact's damping c: three times the time constant m/c of a bare wheel
/// (mass m). 0.225 ms for the default robot.
///
/// An explicit force would be stable up to 2 m/c. That of `rapier` anticipates the change of dg/dt
/// with the load of the last two steps and the mass of a bare wheel; it is stable up to 5.9 m/c for
/// any larger mass that a contact moves, and up to 3.7 m/c if friction makes this mass seem smaller
/// by 1.14, the most that mu = 0.8 can.
pub fn longest_step_for_contact(contact: &ContactLaw, robot: &Robot) -> f64 {
    // All fields here and below: a new force that grows with a speed may need a limit here.
    let ContactLaw {
        stiffness: _,
        exponent: _,
        damping,
        // Softer.
        damping_ramp: _,
    } = contact;
    3.0 * robot.mass.wheel / damping
}

/// Longest step, s, at which a bare wheel (kg) on the contact's stiffness is stable under the mean
/// load: `2/omega`, with `omega^2 = k_t/m` and the tangent stiffness `k_t = dN/dg = n N/g` of eq.
/// (10). 6.0 ms for the default robot and ground.
pub fn longest_step_for_stiffness(contact: &ContactLaw, robot: &Robot) -> f64 {
    let load = robot.mean_wheel_load();
    let tangent_stiffness = contact.exponent * load / contact.static_penetration(load);
    2.0 * (robot.mass.wheel / tangent_stiffness).sqrt()
}

/// Longest step, s, for explicit friction and rolling resistance at a normal force `load` (N) of a
/// wheel: 0.4 of the limit of stability.
///
/// At zero slip the slope of T over the slip speed is N times [`FrictionLaw::steepest_slope`]:
/// `3 mu_s/(2 v_s)` in ADAMS's form, `C/v_0` in the brush model at standstill. It acts on the
/// inertia of wheel and rotor at the rim and on the robot's mass. The rolling resistance acts on
/// the same inertia with the slope `f_r r N/FRICTION_SPEED` over the spin. At twice the mean load,
/// which the course `smooth` reaches, the step is 0.45 ms with the default friction, 0.045 ms for
/// v_s = 2 mm/s, 0.023 ms for `rigid` with v_s = 1 mm/s and 0.014 ms for `brush` with C = 20.
pub fn longest_step_for_friction(friction: &FrictionLaw, robot: &Robot, load: f64) -> f64 {
    let mass = &robot.mass;
    let inertia = mass.wheel_inertia + mass.rotor_inertia;
    let slope = friction.steepest_slope() * load;
    let rim = robot.geometry.wheel_radius.powi(2) / inertia;
    // f_r r/FRICTION_SPEED for N = 1 N.
    let braking = friction.rolling * robot.geometry.wheel_radius / FRICTION_SPEED * load / inertia;
    STABLE_SHARE * 2.0 / (slope * (rim + 3.0 / mass.total()) + braking)
}

/// Whether the rolling resistance limits the step of [`longest_step_for_friction`] more than the
/// friction.
pub fn rolling_is_stiffer(friction: &FrictionLaw, robot: &Robot) -> bool {
    let free = FrictionLaw {
        rolling: 0.0,
        ..*friction
    };
    let longest = |law: &FrictionLaw| longest_step_for_friction(law, robot, 1.0);
    longest(&free) > 2.0 * longest(friction)
}

/// Largest slope of the torque over the wheel speed ([`Drive::slope`]), N m s, for an explicit step
/// (s): 0.4 of the limit of stability in the air. It is 283 N m s for the default robot and step.
/// On the ground, with the contact's damping, the error of N becomes visible at 800 N m s: 0.8 %.
///
/// `None` if no step is stable: `rapier` evaluates the reaction of wheels and rotors on the links
/// with the accelerations of the previous step, and with very light links this reaction grows from
/// step to step.
pub fn largest_slope(robot: &Robot, step: f64) -> Option<f64> {
    Some(STABLE_SHARE * 2.0 / (step * alternating_mobility(robot)?))
}

/// Largest integral gain Ki of a drive, N m, for an explicit step (s): 0.4 of the limit of
/// stability.
///
/// Explicit Euler on `J domega/dt = -(s omega + Ki I)`, `dI/dt = omega` with the slope s amplifies
/// a pair of complex poles if `step Ki > s`: the square of their modulus is
/// `1 - step s/J + step^2 Ki/J`.
pub fn largest_integral_gain(drive: &Drive, step: f64) -> f64 {
    STABLE_SHARE * drive.slope() / step
}

/// Largest acceleration of a wheel relative to its link over all combinations of drive torques with
/// a norm of 1 N m, 1/(kg m^2), if all torques change their signs in each step.
///
/// Let J = J_w + J_r, u the drive torques, a the accelerations of the links, b those of the
/// previous step, and S the matrix from wheels to links. In the scheme of `rapier`,
/// `M a = S ((J_w/J) u - (J_w J_r/J) S' b)` and `domega/dt = u/J - (J_r/J) S' b + S' a`. With
/// alternating signs `b = -a`, so
/// `domega/dt = (1/J + (1 + J_r/J) (J_w/J) S' (M - (J_w J_r/J) S S')^-1 S) u`. M is the mass matrix
/// in the nominal pose, in the air.
fn alternating_mobility(robot: &Robot) -> Option<f64> {
    let (geometry, mass) = (&robot.geometry, &robot.mass);
    let (jw, jr) = (mass.wheel_inertia, mass.rotor_inertia);
    let j = jw + jr;
    let nominal = State {
        q: geometry.pins.q,
        ..State::default()
    };
    let mut links = SMatrix::<f64, 4, 3>::zeros();
    for (i, carrier) in geometry.carriers.iter().enumerate() {
        links[(2 + carrier.index(), i)] = 1.0;
    }
    let kinematics = Kinematics::new(robot, &nominal).ok()?;
    // M - (J_w J_r/J) S S': the inertia of each gear with the opposite sign.
    let (matrix, _) = Carriers::new(robot, -jw * jr / j).without_ground(robot, &kinematics);
    let response = links.transpose() * matrix.factorised()?.solve_each(&links);
    let mobility = Matrix3::identity() / j + response * ((1.0 + jr / j) * jw / j);
    Some(mobility.symmetric_eigenvalues().max())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: a free wheel with PI control and explicit steps comes to rest below the limit
    /// of stability and not above. The limits are 2 J/s for the slope s, and s/step for the
    /// integral gain.
    #[test]
    fn the_limits_are_those_of_an_explicit_step() {
        const INERTIA: f64 = 0.1;
        let swing = |slope: f64, ki: f64, step: f64| {
            let (mut omega, mut integral) = (1e-4_f64, 0.0);
            for _ in 0..100_000 {
                let rate = -(slope * omega + ki * integral) / INERTIA;
                integral += step * omega;
                omega += step * rate;
            }
            // Amplitude of the oscillation, independent of its phase.
            omega.hypot(integral * (ki / INERTIA).sqrt())
        };
        let step = 1e-4;
        let stiff = 2.0 * INERTIA / step;
        assert!(swing(0.95 * stiff, 0.0, step) < 1e-3 && swing(1.05 * stiff, 0.0, step).is_nan());
        let drive = Drive {
            kp: 0.5,
            viscous_damping: 0.0,
            ..Drive::default()
        };
        let just = largest_integral_gain(&drive, step) / STABLE_SHARE;
        assert!((just - 5000.0).abs() < 1e-9);
        // In 10 s the amplitude changes by exp(-+2.5).
        assert!(swing(0.5, 0.9 * just, step) < 3e-5);
        assert!(swing(0.5, 1.1 * just, step) > 5e-4);
    }

    /// Closed form: a wheel on the undamped contact, explicit as `rapier` takes it, swings about
    /// its static penetration below the longest step and leaves it above.
    #[test]
    fn the_limit_of_the_stiffness_is_that_of_an_explicit_step() {
        let robot = Robot::default_a();
        let contact = ContactLaw {
            damping: 0.0,
            ..ContactLaw::default()
        };
        let load = robot.mean_wheel_load();
        let rest = contact.static_penetration(load);
        let limit = longest_step_for_stiffness(&contact, &robot);
        // A swing of 1e-6 of the penetration is linear; the largest of 2000 steps.
        let swing = |step: f64| {
            let (mut g, mut speed, mut largest) = (rest * (1.0 + 1e-6), 0.0, 0.0_f64);
            for _ in 0..2000 {
                speed += step * (load - contact.normal_force(g, 0.0)) / robot.mass.wheel;
                g += step * speed;
                largest = largest.max((g / rest - 1.0).abs());
            }
            largest
        };
        // Below the limit the amplitude is at most 1/sqrt(1 - 0.95^2) = 3.2 times the first one.
        assert!(swing(0.95 * limit) < 4e-6, "{}", swing(0.95 * limit));
        assert!(swing(1.05 * limit) > 1e-2, "{}", swing(1.05 * limit));
        // Eight times as much of everything but the load: k_t grows with k^(1/n).
        let stiffer = ContactLaw {
            stiffness: 8.0 * contact.stiffness,
            ..contact
        };
        let ratio = limit / longest_step_for_stiffness(&stiffer, &robot);
        assert!((ratio - 8.0_f64.powf(0.5 / contact.exponent)).abs() < 1e-12);
    }

    /// Closed form: with very heavy links the mobility is 1/J. Light links move as well, which
    /// lowers the limit; with very light links no step is stable.
    #[test]
    fn light_links_lower_the_limit() {
        let mut robot = Robot::default_a();
        let step = 2e-4;
        let j = robot.mass.wheel_inertia + robot.mass.rotor_inertia;
        let found = largest_slope(&robot, step).unwrap_or_default();
        assert!((found - 283.33).abs() < 0.01, "{found}");
        let rigid = 2.0 * STABLE_SHARE * j / step;
        assert!(found < rigid);
        let mass = robot.mass.clone();
        robot.mass.links = mass.links.map(|m| 1e6 * m);
        robot.mass.link_inertias = mass.link_inertias.map(|i| 1e6 * i);
        let found = largest_slope(&robot, step).unwrap_or_default();
        assert!((found - rigid).abs() < 1e-3 * rigid, "{found} {rigid}");
        robot.mass = mass;
        robot.mass.wheel_inertia = 1.0;
        robot.mass.rotor_inertia = 1.0;
        assert_eq!(largest_slope(&robot, step), None);
    }
}
