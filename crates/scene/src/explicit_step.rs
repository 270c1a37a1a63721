//! The scene against the stability limits of the steps of `rapier`, which the engine divides into
//! [`MOST_PARTS`] parts at most.

use crate::conflict::{Conflict, Value, conflict, named, valued};
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
    /// Why the forces of this scene are too stiff for the steps of `rapier`, whether it is the
    /// engine of the scene or not; `None` if they are not.
    pub fn too_stiff_for_rapier(&self) -> Option<String> {
        conflicts(self).first().map(Conflict::message)
    }
}

/// The limits of `rapier` that a scene exceeds: contact, friction, drive. Beyond them the forces
/// oscillate without any other sign of the error.
pub(crate) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    let (contact, robot) = (&scene.contact, &scene.robot.robot);
    let limits = [
        (
            vec![valued("contact.damping", contact.damping)],
            f64::from(MOST_PARTS) * longest_step_for_contact(contact, robot),
            "39 times the wheel's mass over the damping",
        ),
        (
            vec![valued("contact.stiffness", contact.stiffness)],
            longest_step_for_stiffness(contact, robot),
            "two over the natural frequency of the wheel on the contact",
        ),
        friction(scene),
    ];
    let exceeded = limits
        .into_iter()
        .filter(|limit| scene.engine.step > limit.1);
    let mut found: Vec<_> = exceeded
        .map(|(keys, longest, why)| {
            let rule = format!("engine.step at most {} s, {why}", floor(longest));
            beyond(scene, keys, rule)
        })
        .collect();
    found.extend(drive(scene));
    found
}

/// Keys whose values the step does not bear, and what is allowed beside the other engine.
fn beyond(scene: &Scene, mut keys: Vec<Value>, rule: String) -> Conflict {
    keys.push(valued("engine.step", scene.engine.step));
    conflict(keys, rule + "; or engine.kind = \"direct\"")
}

/// The keys that make friction or rolling resistance stiff, the longest step (s), and the reason.
fn friction(scene: &Scene) -> (Vec<Value>, f64, &'static str) {
    let (law, rolling, robot) = (&scene.friction, &scene.rolling, &scene.robot.robot);
    let (v_s, kind) = (
        valued("contact.v_s", law.v_s),
        named("contact.friction", law.kind.name()),
    );
    let slip_stiffness = valued("contact.slip_stiffness", law.slip_stiffness);
    // The engine cuts its steps where the friction needs it. With the law for implicit engines all
    // steps would need it.
    let (parts, keys) = match law.kind {
        FrictionKind::Adams => (f64::from(MOST_PARTS), vec![v_s]),
        FrictionKind::Brush => (f64::from(MOST_PARTS), vec![kind, slip_stiffness]),
        FrictionKind::Rigid => (1.0, vec![kind, v_s]),
    };
    let load = 2.0 * robot.mean_wheel_load();
    let longest = parts * longest_step_for_friction(law, rolling, robot, load);
    if rolling_is_stiffer(law, rolling, robot) {
        let key = valued("contact.rolling_resistance", rolling.coefficient);
        let why = "the moment's slope at standstill against wheel and rotor";
        return (vec![key], longest, why);
    }
    let why = "the friction's slope at zero slip against wheel and robot";
    (keys, longest, why)
}

/// The step against the slope of the torque over the wheel speed, and against the integral gain.
fn drive(scene: &Scene) -> Vec<Conflict> {
    let (drive, mass) = (&scene.drive, &scene.robot.robot.mass);
    let part = scene.engine.step / f64::from(MOST_PARTS);
    let Some(greatest) = largest_slope(&scene.robot.robot, part) else {
        let keys = [
            valued("robot.mass.wheel_inertia", mass.wheel_inertia),
            valued("robot.mass.rotor_inertia", mass.rotor_inertia),
        ];
        let rule = "inertias of wheels and rotors small against those of the links; or engine.kind = \"direct\"";
        return vec![conflict(keys, rule)];
    };
    let mut found = Vec::new();
    let slope = drive.slope();
    if slope > greatest {
        let slopes = [
            ("drive.gear_friction", drive.gear_friction, FRICTION_SPEED),
            ("drive.viscous_damping", drive.viscous_damping, 1.0),
            ("drive.kp", drive.kp, 1.0),
        ];
        let of = |(_, value, unit): &(_, f64, f64)| value / unit;
        let most = slopes.iter().max_by(|a, b| of(a).total_cmp(&of(b)));
        let most = most.unwrap_or(&slopes[0]);
        let left = greatest - (slope - of(most));
        let instead = match left > 0.0 {
            true => format!(" or {} at most {}", most.0, floor(left * most.2)),
            false => String::new(),
        };
        let longest = floor(scene.engine.step * greatest / slope);
        let rule = format!(
            "engine.step at most {longest} s{instead}, the drive's slope against wheel, rotor and links"
        );
        found.push(beyond(scene, vec![valued(most.0, most.1)], rule));
    }
    let most = largest_integral_gain(drive, part);
    if drive.ki > most {
        let rule = format!(
            "drive.ki at most {}, what drive.kp and the losses damp at this step",
            floor(most)
        );
        found.push(beyond(scene, vec![valued("drive.ki", drive.ki)], rule));
    }
    found
}

/// A limit in a message, rounded down to three digits, so that what a message allows is allowed; 0
/// for a limit that is not positive.
pub(crate) fn floor(limit: f64) -> String {
    // This comparison is false for NaN, which becomes 0 too.
    match limit > 0.0 {
        true => short(rounded_down(limit)),
        false => "0".to_owned(),
    }
}

/// A positive number rounded down to three digits.
fn rounded_down(value: f64) -> f64 {
    let digits = 2 - value.log10().floor() as i32;
    // Dividing by a power of ten rounds once; multiplying by its inverse would round twice.
    let scale = 10.0_f64.powi(digits.abs());
    match digits >= 0 {
        true => (value * scale).floor() / scale,
        false => (value / scale).floor() * scale,
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
