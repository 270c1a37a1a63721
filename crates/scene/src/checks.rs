//! Rules that involve several keys.

use crate::error::Problem;
use crate::range::short;
use crate::reader::Reader;
use crate::scene::Scene;
use crate::sensors::MODEL_ERROR_PATH;
use crate::source::Node;
use robhaz_sim::EngineKind;
use robhaz_sim::drive::FRICTION_SPEED;
use robhaz_sim::rapier::MOST_PARTS;
use robhaz_sim::stability::{
    largest_integral_gain, largest_slope, longest_step_for_contact, longest_step_for_friction,
    longest_step_for_stiffness,
};

/// Largest number of records of a run.
const MOST_RECORDS: f64 = 1e8;
/// Largest number of integration steps of a run: days of computing.
const MOST_STEPS: f64 = 1e11;
/// Largest jitter in sampling periods: beyond it samples would change their order.
const MOST_JITTER: f64 = 0.3;
/// Relative rounding error allowed in a whole number.
const WHOLE: f64 = 1e-12;

/// A key and its value, for messages.
type Value<'a> = (&'a str, f64);

/// Checks the rules whose keys have no problem of their own.
pub(crate) fn check(reader: &mut Reader, root: &Node, scene: &Scene) {
    if reader.is_clean(&["contact."]) {
        friction(reader, root, scene);
    }
    if reader.is_clean(&["record."]) {
        record(reader, root, scene);
    }
    if reader.is_clean(&["record.", "sensors."]) {
        sensors(reader, root, scene);
    }
    if reader.is_clean(&["record.", "engine."]) {
        engine(reader, root, scene);
    }
    if reader.is_clean(&["robot.", "model_error."]) {
        model_error(reader, root, scene);
    }
    if reader.is_clean(&["contact.", "drive.", "engine.", "robot."]) {
        stability(reader, root, scene);
    }
}

fn friction(reader: &mut Reader, root: &Node, scene: &Scene) {
    let law = &scene.friction;
    if law.mu_d > law.mu_s {
        let keys = [("contact.mu_d", law.mu_d), ("contact.mu_s", law.mu_s)];
        conflict(reader, root, keys, "contact.mu_d not above contact.mu_s");
    }
    if law.v_s >= law.v_d {
        let keys = [("contact.v_s", law.v_s), ("contact.v_d", law.v_d)];
        conflict(reader, root, keys, "contact.v_s below contact.v_d");
    }
}

fn record(reader: &mut Reader, root: &Node, scene: &Scene) {
    let r = &scene.record;
    let (duration, rate) = (("record.duration", r.duration), ("record.rate", r.rate));
    if r.compare_from >= r.duration {
        let from = ("record.compare_from", r.compare_from);
        let rule = "record.compare_from below record.duration";
        conflict(reader, root, [from, duration], rule);
    }
    let count = r.duration * r.rate;
    if count > MOST_RECORDS {
        let rule = format!("at most {} records", short(MOST_RECORDS));
        conflict(reader, root, [rate, duration], &rule);
    } else if !is_whole(count) {
        let rule = "a whole number of records: record.duration times record.rate";
        conflict(reader, root, [duration, rate], rule);
    }
}

fn sensors(reader: &mut Reader, root: &Node, scene: &Scene) {
    if !is_whole(scene.sensors.rate / scene.record.rate) {
        let keys = [
            ("sensors.rate", scene.sensors.rate),
            ("record.rate", scene.record.rate),
        ];
        let rule = "sensors.rate a whole multiple of record.rate";
        conflict(reader, root, keys, rule);
    }
    let (jitter, rate) = (scene.sensors.spec.jitter, scene.sensors.rate);
    if jitter * rate > MOST_JITTER {
        let keys = [("sensors.jitter", jitter), ("sensors.rate", rate)];
        let rule = format!(
            "sensors.jitter at most {} s, {MOST_JITTER} of the time between samples",
            short(MOST_JITTER / rate)
        );
        conflict(reader, root, keys, &rule);
    }
}

/// The nominal robot must be a valid robot.
fn model_error(reader: &mut Reader, root: &Node, scene: &Scene) {
    if let Err(error) = scene.nominal_robot() {
        let origin = &root.get(MODEL_ERROR_PATH).unwrap_or(root).origin;
        let message = format!("with seed {} {error}; allowed: smaller errors", scene.seed);
        reader.push(Problem::at(origin, MODEL_ERROR_PATH, message).whole());
    }
}

fn engine(reader: &mut Reader, root: &Node, scene: &Scene) {
    if scene.record.duration / scene.engine.step > MOST_STEPS {
        let keys = [
            ("engine.step", scene.engine.step),
            ("record.duration", scene.record.duration),
        ];
        let rule = format!("at most {} steps", short(MOST_STEPS));
        conflict(reader, root, keys, &rule);
    }
}

/// The step of `rapier` against the stability limits of contact, friction and drive. Beyond them the forces oscillate
/// without any other sign of the error.
fn stability(reader: &mut Reader, root: &Node, scene: &Scene) {
    if scene.engine.kind != EngineKind::Rapier {
        return;
    }
    let robot = &scene.robot.robot;
    let step = ("engine.step", scene.engine.step);
    for (key, longest, why) in [
        (
            ("contact.damping", scene.contact.damping),
            longest_step_for_contact(&scene.contact, robot),
            "twice the wheel's mass over the damping",
        ),
        (
            ("contact.stiffness", scene.contact.stiffness),
            longest_step_for_stiffness(&scene.contact, robot),
            "two over the natural frequency of the wheel on the contact",
        ),
        (
            ("contact.v_s", scene.friction.v_s),
            // The engine cuts its steps where the friction needs it.
            f64::from(MOST_PARTS)
                * longest_step_for_friction(&scene.friction, robot, 2.0 * robot.mean_wheel_load()),
            "the friction's slope against wheel and robot",
        ),
    ] {
        if scene.engine.step > longest {
            let longest = floor(longest);
            let rule =
                format!("engine.step at most {longest} s, {why}; or engine.kind = \"direct\"");
            conflict(reader, root, [key, step], &rule);
        }
    }
    drive(reader, root, scene);
}

/// The step of `rapier` against the slope of the torque over the wheel speed, and against the integral gain.
fn drive(reader: &mut Reader, root: &Node, scene: &Scene) {
    let (drive, mass) = (&scene.drive, &scene.robot.robot.mass);
    let step = ("engine.step", scene.engine.step);
    let Some(greatest) = largest_slope(&scene.robot.robot, scene.engine.step) else {
        let keys = [
            ("robot.mass.wheel_inertia", mass.wheel_inertia),
            ("robot.mass.rotor_inertia", mass.rotor_inertia),
        ];
        let rule = "inertias of wheels and rotors small against those of the links; or engine.kind = \"direct\"";
        conflict(reader, root, keys, rule);
        return;
    };
    if drive.slope() > greatest {
        let slopes = [
            (("drive.kp", drive.kp), 1.0),
            (("drive.viscous_damping", drive.viscous_damping), 1.0),
            (("drive.gear_friction", drive.gear_friction), FRICTION_SPEED),
        ];
        let (key, unit) = slopes.into_iter().fold(slopes[0], |most, other| {
            if other.0.1 / other.1 > most.0.1 / most.1 {
                other
            } else {
                most
            }
        });
        let others = drive.slope() - key.1 / unit;
        let at_most = floor((greatest - others) * unit);
        let longest = floor(scene.engine.step * greatest / drive.slope());
        let instead = if greatest > others {
            format!(" or {} at most {at_most}", key.0)
        } else {
            String::new()
        };
        let rule = format!(
            "engine.step at most {longest} s{instead}, the drive's slope against wheel, rotor and links; \
             or engine.kind = \"direct\""
        );
        conflict(reader, root, [key, step], &rule);
    }
    let most = largest_integral_gain(drive, scene.engine.step);
    if drive.ki > most {
        let rule = format!(
            "drive.ki at most {}, what drive.kp and the losses damp at this step; or engine.kind = \"direct\"",
            floor(most)
        );
        conflict(reader, root, [("drive.ki", drive.ki), step], &rule);
    }
}

/// A limit in a message, rounded down to three digits; 0 for a limit that is not positive.
fn floor(limit: f64) -> String {
    // This comparison is false for NaN, which becomes 0 too.
    if limit > 0.0 {
        short(rounded_down(limit))
    } else {
        "0".to_owned()
    }
}

/// A positive number rounded down to three digits, so that what a message allows is allowed.
fn rounded_down(value: f64) -> f64 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a decimal exponent of a double is small"
    )]
    let digits = 2 - value.log10().floor() as i32;
    // Dividing by a power of ten rounds once; multiplying by its inverse would round twice.
    let scale = 10.0_f64.powi(digits.abs());
    if digits >= 0 {
        (value * scale).floor() / scale
    } else {
        (value / scale).floor() * scale
    }
}

/// Whether a number is 1, 2, 3 ... apart from rounding.
fn is_whole(value: f64) -> bool {
    value.round() >= 1.0 && (value - value.round()).abs() <= WHOLE * value
}

/// Reports a conflict at the key that an override set, else at the first key that is written; defaults have no
/// conflicts.
fn conflict(reader: &mut Reader, root: &Node, keys: [Value<'_>; 2], rule: &str) {
    let written = |key: &str| root.find(key).map(|n| n.origin.clone());
    let origins = keys.map(|(key, _)| (key, written(key)));
    let by_override = |(_, o): &&(_, Option<crate::source::Origin>)| {
        o.as_ref().is_some_and(crate::source::Origin::is_override)
    };
    let blamed = origins
        .iter()
        .find(by_override)
        .or_else(|| origins.iter().find(|(_, o)| o.is_some()));
    // Neither key is written: the cause is in the robot, so the report is for the whole file.
    let (key, origin) = match blamed {
        Some((key, Some(origin))) => (*key, origin),
        _ => (keys[0].0, &root.origin),
    };
    let found = keys.map(|(key, value)| format!("{key} = {}", short(value)));
    let message = format!("found {}, allowed: {rule}", found.join(" and "));
    reader.push(Problem::at(origin, key, message).whole());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Never above the number, and never zero, whatever its size.
    #[test]
    fn limits_are_rounded_down() {
        for (value, expected) in [
            (1.5e-4, 1.5e-4),
            (1.239e-5, 1.23e-5),
            (3e-10, 3e-10),
            (2.9999e-13, 2.99e-13),
            (0.999_99, 0.999),
            (12_345.0, 12_300.0),
        ] {
            let found = rounded_down(value);
            assert!(
                found <= value && (found - expected).abs() < 1e-12 * expected,
                "{found}"
            );
        }
    }

    #[test]
    fn whole_numbers_may_be_rounded() {
        assert!(is_whole(2.3 * 1000.0) && is_whole(1.0) && is_whole(0.1 * 3.0 * 10.0));
        assert!(!is_whole(0.0) && !is_whole(0.5) && !is_whole(1000.001) && !is_whole(1e-20));
    }
}
