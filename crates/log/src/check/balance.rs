//! The sum of the motor torques against the robot's weight and inertia: signs of torques and inclinometers.
//!
//! Wheels may pull against each other, but not in the sum. With the slopes gamma_i of the curve of the axles at the three
//! wheels, the middle spin speed omega, weight W and mass m,
//!
//! ```text
//! sum of tau = r W mean of sin(gamma_i) + (3 J + r^2 m) domega/dt + 3 B omega + friction and offsets
//! ```
//!
//! where J = J_wheel + J_rotor. All coefficients are known from the drawings. Wrong signs leave a larger remainder than
//! right ones.

use crate::check::course::{Course, STEP, fused};
use crate::check::ground::scale_of;
use crate::check::motion::Motion;
use crate::check::recording::Recording;
use crate::check::report::Finding;
use crate::check::signal::{derivative, median, rms, smooth, zip};
use robhaz_model::{GRAVITY, Robot};

/// Time over which torques are averaged, s.
const SMOOTHING: f64 = 0.05;
/// Distance over which the slope of the curve is averaged, m, to both sides.
const WIDTH: f64 = 0.02;
/// RMS of the expected sum, N m, that shows something; at least as much is common offset and friction.
const LEAST_EXPECTED: f64 = 0.15;
/// Remainder with other signs, over that with the signs of the log, that shows a fault.
const BETTER: f64 = 0.6;
/// Remainder over the expected sum of a balance that holds.
const HOLDS: f64 = 0.5;

const TEST: &str = "sign";
const CHANNEL: &str = "torques 1 to 3, inclinometers";

/// Signs of the three torques and of the inclinometers.
type Signs = ([f64; 3], f64);

/// The balance of a recording, where the robot drives.
struct Balance {
    /// Torques, averaged, N m.
    torques: [Vec<f64>; 3],
    /// r W times the mean of the sines of the slopes, N m.
    weight: Vec<f64>,
    /// Torques of inertia and damping, N m.
    motion: Vec<f64>,
}

impl Balance {
    /// The balance of a recording, for a nominal damping B in N m s.
    fn new(
        recording: &Recording,
        motion: &Motion,
        course: &Course<'_>,
        robot: &Robot,
        viscous_damping: f64,
    ) -> Self {
        let half = recording.steps(0.5 * SMOOTHING);
        let (mass, radius) = (&robot.mass, robot.geometry.wheel_radius);
        let total = robot.mean_wheel_load() * 3.0 / GRAVITY;
        let inertia = 3.0 * (mass.wheel_inertia + mass.rotor_inertia) + radius * radius * total;
        let acceleration = derivative(&motion.middle_spin, half, recording.dt);
        let damping = 3.0 * viscous_damping;
        let spin = motion.middle_spin.iter();
        let of_motion: Vec<f64> = spin
            .zip(&acceleration)
            .map(|(spin, acceleration)| inertia * acceleration + damping * spin)
            .collect();
        let slopes = slopes(course, recording.len());
        let weight: Vec<f64> = slopes
            .iter()
            .map(|s| radius * total * GRAVITY * s)
            .collect();
        Self {
            torques: recording
                .torque
                .each_ref()
                .map(|torque| motion.while_driving(robot, &smooth(torque, half))),
            weight,
            motion: of_motion,
        }
    }

    fn expected(&self, tilt: f64) -> Vec<f64> {
        zip(&self.weight, &self.motion, |w, m| tilt * w + m)
    }

    fn sum(&self, signs: &[f64; 3]) -> Vec<f64> {
        let [a, b, c] = &self.torques;
        let ab = zip(a, b, |a, b| signs[0] * a + signs[1] * b);
        zip(&ab, c, |ab, c| ab + signs[2] * c)
    }

    /// RMS of what the balance leaves for given signs, less its median, N m; magnitudes beyond five times the middle one
    /// do not count.
    fn remainder(&self, (torques, tilt): &Signs) -> Option<f64> {
        let left = zip(&self.sum(torques), &self.expected(*tilt), |a, b| a - b);
        let middle = median(left.iter().copied())?;
        let left: Vec<f64> = left.iter().map(|x| x - middle).collect();
        let limit = 5.0 * 1.48 * median(left.iter().map(|x| x.abs()))?;
        let kept: Vec<f64> = left.into_iter().filter(|x| x.abs() <= limit).collect();
        Some(rms(&kept))
    }
}

/// Mean over the wheels of the sines of the slopes under them, at each sample. The robot starts on level ground: from there
/// the front wheel draws the curve of the axles.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "steps of a path"
)]
fn slopes(course: &Course<'_>, samples: usize) -> Vec<f64> {
    let [front, _] = course.heights(&[(0, 1.0), (1, 1.0)]);
    // Slip makes the encoders' distances longer than those of the ground.
    let scale = scale_of(course);
    let ahead = (scale * course.spacing() / STEP).round() as usize;
    // The curve from the rear wheel's start on: element k is the place of the rear wheel at step k.
    let mut curve = vec![0.0; 2 * ahead];
    let level = front.iter().copied().find(|h| h.is_finite()).unwrap_or(0.0);
    for (k, height) in front.iter().enumerate() {
        let height = if height.is_finite() {
            height - level
        } else {
            0.0
        };
        curve.push(curve[k + ahead] + height);
    }
    let width = ((WIDTH / STEP) as usize).max(1);
    let slope = derivative(&curve, width, STEP / scale);
    let sine = |k: usize| slope.get(k).map_or(f64::NAN, |s| s / (1.0 + s * s).sqrt());
    let mut all = vec![f64::NAN; samples];
    for (k, range) in course.samples.windows(2).enumerate() {
        let mean = (sine(k) + sine(k + ahead) + sine(k + 2 * ahead)) / 3.0;
        all[range[0].0..range[1].0].fill(mean);
    }
    all
}

/// All findings.
pub fn findings(
    recording: &Recording,
    motion: &Motion,
    robot: &Robot,
    viscous_damping: f64,
) -> Vec<Finding> {
    let Some(course) = Course::new(motion, robot, &fused(recording)) else {
        let remedy = "none: this test needs equal distances between the axles";
        return vec![Finding::cannot_tell(
            TEST,
            CHANNEL,
            "no curve of the axles",
            remedy,
        )];
    };
    let balance = Balance::new(recording, motion, &course, robot, viscous_damping);
    vec![signs(&balance)]
}

fn signs(balance: &Balance) -> Finding {
    let identity: Signs = ([1.0; 3], 1.0);
    let expected = balance.expected(1.0);
    let middle = median(expected.iter().copied()).unwrap_or(0.0);
    let size = rms(&expected.iter().map(|x| x - middle).collect::<Vec<_>>());
    let own = balance.remainder(&identity);
    let Some(own) = own.filter(|_| size > LEAST_EXPECTED) else {
        let figure =
            format!("slopes and accelerations change the sum of the torques by {size:.2} N m only");
        let remedy = "drive over a slope or an obstacle, and start and stop";
        return Finding::cannot_tell(TEST, CHANNEL, figure, remedy);
    };
    let (best, least) = all_signs()
        .filter_map(|signs| Some((signs, balance.remainder(&signs)?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((identity, own));
    let figure = format!(
        "weight, inertia and damping should change the sum of the torques by {size:.2} N m RMS; unexplained are {own:.2}"
    );
    let with = |finding: Finding| {
        let finding = finding.with("expected", size, "N m");
        finding.with("unexplained", own, "N m")
    };
    if least < BETTER * own && least < HOLDS * size {
        let figure = format!("{figure}, with the signs below {least:.2}");
        return with(Finding::fault(TEST, CHANNEL, figure, remedy(&best)));
    }
    if own < HOLDS * size {
        return with(Finding::ok(TEST, CHANNEL, figure));
    }
    let remedy = "drive over a gentle slope: the robot's mass, or the scale of the torques, may be wrong too";
    Finding::cannot_tell(TEST, CHANNEL, figure, remedy)
}

fn all_signs() -> impl Iterator<Item = Signs> {
    (0..16_u32).map(|k| {
        let sign = |bit: u32| if k >> bit & 1 == 1 { -1.0 } else { 1.0 };
        ([sign(0), sign(1), sign(2)], sign(3))
    })
}

/// Which signs to change, in words.
fn remedy((torques, tilt): &Signs) -> String {
    let wrong: Vec<String> = (0..3)
        .filter(|i| torques[*i] < 0.0)
        .map(|i| format!("torque {}", i + 1))
        .collect();
    match (wrong.len(), *tilt < 0.0) {
        (3, true) => "the signs of all encoders are wrong: forward is positive".to_owned(),
        (3, false) => "the signs of all torques are wrong: driving forward is positive".to_owned(),
        (0, _) => "the signs of both inclinometers are wrong: nose up is positive".to_owned(),
        (_, false) => format!("change the sign of {}", wrong.join(" and ")),
        (_, true) => format!(
            "change the signs of {} and of both inclinometers",
            wrong.join(" and ")
        ),
    }
}
