//! Every key of robot, contact, drive, sensors, model errors and engine changes a run. A key that no
//! code reads is found here.

use crate::support::{Kept, scene};
use rayon::prelude::*;
use robhaz_scene::Scene;

/// Sections whose keys change truth, readings or estimates.
const SECTIONS: [&str; 6] = [
    "robot.",
    "contact.",
    "drive.",
    "sensors.",
    "model_error.",
    "engine.",
];
/// Keys of these that change something else, or none alone: names; what the viewer and the clearance
/// use; what lies across, outside of the plane; steering, which a resolved scene has in its links;
/// items of lists; what other keys must go with.
const OTHERS: [&str; 10] = [
    ".name",
    "robot.geometry.outline.",
    "robot.across.",
    ".steering",
    "[]",
    "robot.geometry.wheel_radius",
    "robot.geometry.carriers",
    "robot.geometry.suspension.",
    "drive.estimator",
    "drive.friction_test.wheels",
];

/// Scenes in which the keys work. One is enough for each key.
const SCENES: [&[&str]; 4] = [
    // Drives at their limit.
    &[
        "engine.kind=direct",
        "contact.friction=brush",
        "contact.rolling_resistance=0.02",
        "drive.gear_friction=0.2",
        "drive.torque_limit=0.5",
        "sensors.grade=poor",
        "sensors.imu=body",
    ],
    &[
        "engine.kind=rapier",
        "sensors.grade=poor",
        "model_error.scales=1",
    ],
    // Wheels slide, the linkage is at its stops.
    &[
        "robot.geometry.stop.upper=0.00005",
        "robot.geometry.stop.lower=-0.00005",
        "record.duration=6",
        "engine.start=raw",
        "contact.mu_s=0.1",
        "contact.mu_d=0.05",
        "drive.start_time=0.5",
        "drive.ramp_time=0.05",
    ],
    &[
        "drive.kind=friction-test",
        "drive.friction_test.start=1.5",
        "sensors.grade=typical",
        "record.duration=20",
    ],
];

/// What a run gives; `None` for a scene that is refused.
fn run(overrides: &[&str], set: &str) -> Option<String> {
    let short = [
        "record.duration=2.5",
        "record.rate=200",
        "record.compare_from=1",
    ];
    let all: Vec<_> = [&short[..], overrides, &[set]].concat();
    let all: Vec<String> = all
        .into_iter()
        .filter(|s| !s.is_empty())
        .map(str::to_owned)
        .collect();
    let path = crate::support::root().join("scenes/smooth.toml");
    let scene = Scene::load(&path, &all).ok()?;
    let mut kept = Kept::default();
    robhaz_run::run(&scene, &mut [&mut kept]).ok()?;
    Some(format!(
        "{:?} {:?} {:?}",
        kept.truth, kept.sensors, kept.estimates
    ))
}

fn listed(items: &[toml::Value]) -> String {
    let items: Vec<_> = items.iter().map(toml::Value::to_string).collect();
    items.join(", ")
}

/// Other values of a key than `value`, as TOML.
fn others(value: &toml::Value, allowed: &str) -> Vec<String> {
    match value {
        toml::Value::String(word) => {
            let words = allowed
                .split(", ")
                .filter(|other| other.trim_matches('"') != word);
            words.map(str::to_owned).collect()
        }
        toml::Value::Float(number) => {
            let near = [0.9, 1.1, 2.0].map(|factor| factor * number);
            let values = near.into_iter().chain([0.01, 0.5, 1000.0]);
            values
                .filter(|v| v.to_bits() != number.to_bits())
                .map(|v| format!("{v:?}"))
                .collect()
        }
        // A change of the first number.
        toml::Value::Array(items) => {
            let first = items
                .first()
                .into_iter()
                .flat_map(|first| others(first, ""));
            let rest = &items[1..];
            first
                .map(|first| format!("[{first}, {}]", listed(rest)))
                .collect()
        }
        _ => Vec::new(),
    }
}

#[test]
fn every_key_changes_a_run() {
    let plain: Vec<_> = SCENES.par_iter().map(|sets| run(sets, "")).collect();
    let plain: Vec<_> = plain
        .into_iter()
        .map(|plain| plain.expect("a run"))
        .collect();
    let resolved: Vec<toml::Value> = SCENES
        .iter()
        .map(|sets| toml::from_str(&scene("smooth", sets).to_toml("")).unwrap())
        .collect();
    let keys = robhaz_scene::reference();
    let ours = keys.iter().filter(|key| {
        SECTIONS.iter().any(|section| key.key.starts_with(section))
            && !key.allowed.contains("table")
            && !OTHERS.iter().any(|other| key.key.contains(other))
    });
    let without: Vec<_> = ours
        .par_bridge()
        .filter(|key| {
            !SCENES.iter().enumerate().any(|(k, sets)| {
                let mut parts = key.key.split('.');
                let value = parts.try_fold(&resolved[k], |value, part| value.get(part));
                let others = value
                    .map(|value| others(value, &key.allowed))
                    .unwrap_or_default();
                let set = |value: &String| run(sets, &format!("{}={value}", key.key));
                others.iter().filter_map(set).any(|found| found != plain[k])
            })
        })
        .map(|key| key.key.as_str())
        .collect();
    assert!(without.is_empty(), "no code reads {without:?}");
}
