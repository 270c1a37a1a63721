//! Delays between the gyroscope and the inclinometer of a link.

use crate::check::changes::{CERTAIN, Changes, FORWARD, LEAST_CHANGE, SPAN};
use crate::check::delay::{self, Allowed, delay};
use crate::check::readings::Readings;
use crate::check::recording::Recording;
use crate::check::report::Finding;
use crate::check::signal::{derivative, rms, smooth};
use robhaz_model::Carrier;

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
pub fn findings(log: &Readings<'_>) -> [Finding; 2] {
    let acceleration = (log.stated.budget.specific_force).then(|| acceleration(log));
    let changes = Changes::of(&log.recording, acceleration.as_deref(), &[]);
    [0, 1].map(|k| delay_of(&log.recording, &changes, k))
}

/// Part of the inclinations that is the acceleration of the robot, rad, for inclinometers that
/// measure the specific force: that of Q. 0 near the ends of the log, where it is not known.
fn acceleration(log: &Readings<'_>) -> Vec<f64> {
    let width = log.recording.steps(0.5 * FORWARD);
    let acceleration = derivative(&speed_of_q(log, width), width, log.recording.dt);
    let over_g = |a: &f64| {
        if a.is_finite() {
            a / log.stated.robot.gravity
        } else {
            0.0
        }
    };
    acceleration.iter().map(over_g).collect()
}

/// Horizontal speed of Q, m/s, averaged over `2 width` samples: the link with two wheels rolls
/// along its own direction, with the absolute spin of its wheels, and turns Q about the middle of
/// its axles.
fn speed_of_q(log: &Readings<'_>, width: usize) -> Vec<f64> {
    let (recording, geometry) = (&log.recording, &log.stated.robot.geometry);
    let carriers = geometry.carriers.map(Carrier::index);
    let link = usize::from(carriers.iter().sum::<usize>() > 1);
    let of_link = [&recording.inclination[link], &recording.rate[link]];
    let [inclination, rate] = of_link.map(|x| smooth(x, width));
    let on_link = (0..3).filter(|i| carriers[*i] == link);
    let height = on_link.map(|i| geometry.axles[i].y).sum::<f64>() / 2.0;
    let (radius, arm) = (geometry.wheel_radius, geometry.pins.q.y - height);
    let spins = log.motion.middle_spin.iter().zip(&rate).zip(&inclination);
    let speed = |((spin, rate), inclination): ((&f64, &f64), &f64)| {
        (radius * (spin - rate) - arm * rate) * inclination.cos()
    };
    spins.map(speed).collect()
}

fn delay_of(recording: &Recording, changes: &Changes, k: usize) -> Finding {
    let channel = format!("inclinometer {} after gyro {}", k + 1, k + 1);
    let allowed = Allowed {
        early: GYRO_DELAY + MARGIN + 0.5 * recording.slowest,
        late: INCLINOMETER_LAG + MARGIN + 0.5 * recording.slowest,
        explained: CERTAIN,
    };
    let (inclination, rate) = (&changes.inclination[k], &changes.rate[k]);
    let [longest, memory] = [LONGEST_DELAY, SPAN].map(|time| recording.steps(time));
    // All samples: those that fit best without a delay would hide it.
    let found = (rms(rate) > LEAST_CHANGE)
        .then(|| delay(inclination, &[rate], longest, memory, recording.dt, allowed))
        .flatten()
        .filter(|delay| delay.explained > EXPLAINED);
    let unknown = [
        "no common motion",
        "drive over an obstacle that turns the links by a few degrees",
    ];
    delay::finding(&channel, found, &allowed, unknown, |is_late, offset| {
        let late = if is_late { "its" } else { "the gyro's" };
        format!(
            "{late} readings arrive late: state offset = {offset:.4} of its channel, or read it directly"
        )
    })
}
