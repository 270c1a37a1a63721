//! The scene against the stability limits of the steps of `rapier`, which the engine divides into [`MOST_PARTS`] parts at
//! most.

use crate::conflict::{Conflict, Value, named, valued};
use crate::quantity::short;
use crate::scene::Scene;
use robhaz_sim::drive::FRICTION_SPEED;
use robhaz_sim::friction::FrictionKind;
use robhaz_sim::rapier::MOST_PARTS;
use robhaz_sim::stability::{
    largest_integral_gain, largest_slope, longest_step_for_contact, longest_step_for_friction,
    longest_step_for_stiffness, rolling_is_stiffer,
};

impl Scene {
    /// Why the forces of this scene are too stiff for the steps of `rapier`, whether it is the engine of the scene or not;
    /// `None` if they are not.
    pub fn too_stiff_for_rapier(&self) -> Option<String> {
        conflicts(self).first().map(Conflict::message)
    }
}

/// The limits of `rapier` that a scene exceeds: contact, friction, drive. Beyond them the forces oscillate without any
/// other sign of the error.
pub(crate) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    let robot = &scene.robot.robot;
    let limits = [
        (
            vec![valued("contact.damping", scene.contact.damping)],
            f64::from(MOST_PARTS) * longest_step_for_contact(&scene.contact, robot),
            "39 times the wheel's mass over the damping",
        ),
        (
            vec![valued("contact.stiffness", scene.contact.stiffness)],
            longest_step_for_stiffness(&scene.contact, robot),
            "two over the natural frequency of the wheel on the contact",
        ),
        friction(scene),
    ];
    let beyond = |(mut keys, longest, why): (Vec<Value>, f64, &str)| {
        keys.push(step(scene));
        (scene.engine.step > longest).then(|| Conflict {
            keys,
            rule: format!(
                "engine.step at most {} s, {why}; or engine.kind = \"direct\"",
                floor(longest)
            ),
        })
    };
    let mut found: Vec<Conflict> = limits.into_iter().filter_map(beyond).collect();
    found.extend(drive(scene));
    found
}

fn step(scene: &Scene) -> Value {
    valued("engine.step", scene.engine.step)
}

/// The keys that make friction or rolling resistance stiff, the longest step (s), and the reason.
fn friction(scene: &Scene) -> (Vec<Value>, f64, &'static str) {
    let (law, rolling, robot) = (&scene.friction, &scene.rolling, &scene.robot.robot);
    // The engine cuts its steps where the friction needs it. With the law for implicit engines all steps would need it.
    let parts = match law.kind {
        FrictionKind::Adams | FrictionKind::Brush => f64::from(MOST_PARTS),
        FrictionKind::Rigid => 1.0,
    };
    let longest =
        parts * longest_step_for_friction(law, rolling, robot, 2.0 * robot.mean_wheel_load());
    if rolling_is_stiffer(law, rolling, robot) {
        let key = valued("contact.rolling_resistance", rolling.coefficient);
        let why = "the moment's slope at standstill against wheel and rotor";
        return (vec![key], longest, why);
    }
    let v_s = valued("contact.v_s", law.v_s);
    let kind = named("contact.friction", law.kind.name());
    let keys = match law.kind {
        FrictionKind::Adams => vec![v_s],
        FrictionKind::Rigid => vec![kind, v_s],
        FrictionKind::Brush => {
            let stiffness = valued("contact.slip_stiffness", law.slip_stiffness);
            vec![kind, stiffness]
        }
    };
    let why = "the friction's slope at zero slip against wheel and robot";
    (keys, longest, why)
}

/// The step against the slope of the torque over the wheel speed, and against the integral gain.
fn drive(scene: &Scene) -> Vec<Conflict> {
    let (drive, mass) = (&scene.drive, &scene.robot.robot.mass);
    let part = scene.engine.step / f64::from(MOST_PARTS);
    let Some(greatest) = largest_slope(&scene.robot.robot, part) else {
        return vec![Conflict {
            keys: vec![
                valued("robot.mass.wheel_inertia", mass.wheel_inertia),
                valued("robot.mass.rotor_inertia", mass.rotor_inertia),
            ],
            rule: "inertias of wheels and rotors small against those of the links; or engine.kind = \"direct\""
                .to_owned(),
        }];
    };
    let mut found = Vec::new();
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
        found.push(Conflict {
            keys: vec![valued(key.0, key.1), step(scene)],
            rule: format!(
                "engine.step at most {longest} s{instead}, the drive's slope against wheel, rotor and links; \
                 or engine.kind = \"direct\""
            ),
        });
    }
    let most = largest_integral_gain(drive, part);
    if drive.ki > most {
        found.push(Conflict {
            keys: vec![valued("drive.ki", drive.ki), step(scene)],
            rule: format!(
                "drive.ki at most {}, what drive.kp and the losses damp at this step; or engine.kind = \"direct\"",
                floor(most)
            ),
        });
    }
    found
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
}
