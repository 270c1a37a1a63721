//! Delays between the gyroscope and the inclinometer of a link.

use crate::check::changes::{CERTAIN, Changes, FORWARD, LEAST_CHANGE, SPAN};
use crate::check::delay::{self, Allowed, delay};
use crate::check::motion::Motion;
use crate::check::readings::Readings;
use crate::check::recording::Recording;
use crate::check::report::Finding;
use crate::check::signal::{derivative, rms, smooth};
use robhaz_model::{Carrier, Robot};

/// Share of the changes that the gyroscope must explain.
const EXPLAINED: f64 = 0.6;
/// Longest delay that is looked for, s.
const LONGEST_DELAY: f64 = 0.15;
/// Delay of an inclinometer that is its own lag, s: a low pass of 8 Hz has 20 ms.
const INCLINOMETER_LAG: f64 = 0.025;
/// Delay of a gyroscope behind the inclinometer that is a fault, s.
const GYRO_DELAY: f64 = 0.005;
/// Error of a delay by accelerations of the robot that the encoders do not show, s.
const MARGIN: f64 = 0.005;

/// The findings of both links, for right signs and units.
pub fn findings(log: &Readings<'_>) -> Vec<Finding> {
    let Readings {
        recording, motion, ..
    } = log;
    let acceleration =
        (log.budget.specific_force).then(|| acceleration(recording, motion, log.robot));
    let changes = Changes::of(recording, acceleration.as_deref(), &[]);
    let of_link = |k| delay_of(recording, &changes, k);
    (0..2).map(of_link).collect()
}

/// Part of the inclinations that is the acceleration of the robot, rad, for inclinometers that
/// measure the specific force: that of Q. 0 near the ends of the log, where it is not known.
fn acceleration(recording: &Recording, motion: &Motion, robot: &Robot) -> Vec<f64> {
    let width = recording.steps(0.5 * FORWARD);
    let speed = speed_of_q(recording, motion, robot, width);
    let mut acceleration = derivative(&speed, width, recording.dt);
    for value in &mut acceleration {
        *value = if value.is_finite() {
            *value / robot.gravity
        } else {
            0.0
        };
    }
    acceleration
}

/// Horizontal speed of Q, m/s, averaged over `2 width` samples: the link with two wheels rolls
/// along its own direction, with the absolute spin of its wheels, and turns Q about the middle of
/// its axles.
fn speed_of_q(recording: &Recording, motion: &Motion, robot: &Robot, width: usize) -> Vec<f64> {
    let geometry = &robot.geometry;
    let carriers = geometry.carriers.map(Carrier::index);
    let link = usize::from(carriers.iter().sum::<usize>() > 1);
    let (inclination, rate) = (
        smooth(&recording.inclination[link], width),
        smooth(&recording.rate[link], width),
    );
    let on_link = (0..3).filter(|i| carriers[*i] == link);
    let height = on_link.map(|i| geometry.axles[i].y).sum::<f64>() / 2.0;
    let (radius, arm) = (geometry.wheel_radius, geometry.pins.q.y - height);
    let spins = motion.middle_spin.iter();
    spins
        .zip(inclination.iter().zip(&rate))
        .map(|(spin, (inclination, rate))| {
            (radius * (spin - rate) - arm * rate) * inclination.cos()
        })
        .collect()
}

fn delay_of(recording: &Recording, changes: &Changes, k: usize) -> Finding {
    let channel = format!("inclinometer {} after gyro {}", k + 1, k + 1);
    let allowed = Allowed {
        early: GYRO_DELAY + MARGIN,
        late: INCLINOMETER_LAG + MARGIN,
        explained: CERTAIN,
    };
    let allowed = allowed.at_period(recording.slowest);
    // All samples: those that fit best without a delay would hide it.
    let found = Some(&changes.rate[k])
        .filter(|rate| rms(rate) > LEAST_CHANGE)
        .and_then(|rate| {
            delay(
                &changes.inclination[k],
                &[rate],
                recording.steps(LONGEST_DELAY),
                recording.steps(SPAN),
                recording.dt,
                allowed,
            )
        })
        .filter(|delay| delay.explained > EXPLAINED);
    let unknown = [
        "no common motion",
        "drive over an obstacle that turns the links by a few degrees",
    ];
    delay::finding(&channel, found, &allowed, unknown, |found| {
        let (late, offset) = if found.seconds > 0.0 {
            ("its", -found.seconds)
        } else {
            ("the gyro's", found.seconds)
        };
        format!(
            "{late} readings arrive late: state offset = {offset:.4} of its channel, or read it directly"
        )
    })
}
