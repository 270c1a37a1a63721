//! A run reports that the robot is stuck if it is, and only then.

use crate::support::{root, scene};
use robhaz_scene::Scene;
use robhaz_score::{Progress, ProgressMeter};
use robhaz_verify::truth_of;

fn progress(scene: &Scene) -> Progress {
    let mut meter = ProgressMeter::new(&scene.drive, scene.robot.robot.geometry.wheel_radius);
    for truth in truth_of(scene).unwrap() {
        meter.add(&truth);
    }
    meter.progress()
}

/// Acceptance: on the shipped stairs, at a kerb of 150 mm and on a ramp of 45 deg the robot is stuck from the time at
/// which its body last advanced, and every wheel slips for the rest of the run. Measured: 6.2, 7.0 and 6.7 s with both
/// engines.
#[test]
fn stairs_a_high_kerb_and_a_steep_ramp_stop_the_robot() {
    for engine in ["engine.kind=direct", "engine.kind=rapier"] {
        for (name, key, since) in [
            ("stairs", "seed=0", 6.2),
            ("step", "terrain.kerb=150 mm", 7.0),
            ("ramp", "terrain.angle=45 deg", 6.7),
        ] {
            let found = progress(&scene(name, &[engine, key, "record.duration=12"]));
            println!("{name}, {engine}: {found:?}");
            let stuck = found.stuck_since.unwrap_or_default();
            assert!((stuck - since).abs() < 0.2, "{name}, {engine}: {found:?}");
            assert!(found.distance < 0.9 && found.asked > 2.0, "{found:?}");
            for spinning in found.spinning {
                assert!(spinning > 12.0 - since - 0.5, "{name}, {engine}: {found:?}");
            }
        }
    }
}

/// Acceptance: in every other shipped scene the robot travels at least 90 % of the commanded distance, and no wheel
/// slips for longer than half a second. A robot is not stuck before its drive starts or at a set speed of zero.
#[test]
fn robots_that_travel_are_not_stuck() {
    let mut count = 0;
    for entry in std::fs::read_dir(root().join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if name == "stairs" {
            continue;
        }
        let found = progress(&scene(&name, &["engine.kind=direct"]));
        println!("{name}: {found:?}");
        assert_eq!(found.stuck_since, None, "{name}: {found:?}");
        assert!(found.distance > 0.9 * found.asked, "{name}: {found:?}");
        assert!(
            found.spinning.iter().all(|time| *time < 0.5),
            "{name}: {found:?}"
        );
        count += 1;
    }
    assert!(count >= 11, "{count}");
    for key in ["drive.speed=0", "drive.start_time=30"] {
        let found = progress(&scene("stairs", &["engine.kind=direct", key]));
        assert_eq!(
            (found.stuck_since, found.spinning),
            (None, [0.0; 3]),
            "{key}"
        );
    }
}
