//! Every key of robot, contact, drive, sensors, model errors and engine changes a run. A key that no
//! code reads is found here.

use crate::support::{Kept, keep};
use rayon::prelude::*;
use robhaz_run::{Frame, Run, RunDescription, RunEnd, Sink, SinkError};
use robhaz_scene::Scene;
use std::cell::Cell;

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
    // Wheels slide, the linkage is at its stops.
    &[
        "robot.geometry.stop.upper=0.00005",
        "robot.geometry.stop.lower=-0.00005",
        "record.duration=6",
        "engine.kind=direct",
        "engine.start=raw",
        "contact.mu_s=0.1",
        "contact.mu_d=0.05",
        "drive.start_time=0.5",
        "drive.ramp_time=0.05",
    ],
    &[
        "engine.kind=rapier",
        "sensors.grade=poor",
        "model_error.scales=1",
    ],
    &[
        "engine.kind=direct",
        "drive.kind=friction-test",
        "drive.friction_test.start=1.5",
        "sensors.grade=typical",
        "record.duration=20",
    ],
];

/// A scene as short as the keys allow; `None` for one that is refused.
fn short(overrides: &[&str], set: &str) -> Option<Scene> {
    let short = [
        "record.duration=2.5",
        "sensors.rate=200",
        "record.rate=200",
        "record.compare_from=1",
    ];
    let all = [&short[..], overrides, &[set]].concat();
    let all = all.into_iter().filter(|s| !s.is_empty());
    let all: Vec<String> = all.map(str::to_owned).collect();
    Scene::load(&crate::support::root().join("scenes/smooth.toml"), &all).ok()
}

/// Compares a run with a plain one, record by record.
struct Compared<'a> {
    plain: &'a Kept,
    records: Cell<usize>,
    differs: Cell<bool>,
}

impl Sink for &Compared<'_> {
    fn begin(&mut self, _run: &RunDescription) -> Result<(), SinkError> {
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let (k, plain) = (self.records.get(), self.plain);
        let is_same = frame.truth == plain.truth.get(k)
            && Some(frame.sensors) == plain.sensors.get(k)
            && frame.estimates.len() == plain.estimates.len()
            && (frame.estimates.iter().zip(&plain.estimates)).all(|(e, all)| Some(e) == all.get(k));
        self.records.set(k + 1);
        self.differs.set(self.differs.get() || !is_same);
        Ok(())
    }

    fn end(&mut self, _end: Option<&RunEnd>) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Whether a scene gives another truth, other readings or estimates than the plain one: its run
/// ends where it does.
fn differs(scene: &Scene, plain: &Kept) -> bool {
    let compared = Compared {
        plain,
        records: Cell::new(0),
        differs: Cell::new(false),
    };
    let stop = || compared.differs.get().then_some("differs");
    // A run that cannot go on tells nothing of itself.
    if let Ok(run) = Run::new(scene) {
        let _ = run.until(&mut [&mut &compared], &stop);
    }
    compared.differs.get()
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
    let scenes = SCENES.map(|sets| short(sets, "").expect("a scene"));
    let plain: Vec<Kept> = scenes.par_iter().map(keep).collect();
    // Not even a NaN differs.
    assert!((scenes.par_iter().zip(&plain)).all(|(scene, plain)| !differs(scene, plain)));
    let resolved: Vec<toml::Value> = scenes
        .iter()
        .map(|scene| toml::from_str(&scene.to_toml("")).unwrap())
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
                let set = |value: &String| short(sets, &format!("{}={value}", key.key));
                let mut others = others.iter().filter_map(set);
                others.any(|other| differs(&other, &plain[k]))
            })
        })
        .map(|key| key.key.as_str())
        .collect();
    assert!(without.is_empty(), "no code reads {without:?}");
}
