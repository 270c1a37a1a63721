//! `robhaz path`: agreement with driving in the simulator, and the command.

use crate::support::{assert_contains, page_commands, robhaz, root, succeeded, text};
use rayon::prelude::*;
use robhaz_path::{DriveKind, Options, PathSetup, judge};
use robhaz_scene::Scene;
use robhaz_sim::Plant;
use std::path::Path;

const RAMP: &str = "[terrain]\nkind = \"ramp\"\nangle = \"15 deg\"\nstart = 0.5\nlength = 1.5\n";
const STEEP: &str = "[terrain]\nkind = \"ramp\"\nangle = \"22 deg\"\nstart = 0.5\nlength = 1.5\n";
const LOW_KERB: &str = "[terrain]\nkind = \"step\"\nkerb = 0.03\nstart = 0.5\n";
const KERB: &str = "[terrain]\nkind = \"step\"\nkerb = 0.05\nstart = 0.5\n";

/// A scene with the low-gain drive, slow enough for statics, and a friction coefficient.
fn scene(ground: &str, mu: f64) -> Scene {
    let set = [
        "drive.kp=10".to_owned(),
        "drive.ki=0".to_owned(),
        "drive.speed=0.1".to_owned(),
        "engine.kind=direct".to_owned(),
        format!("contact.mu_s={mu}"),
        format!("contact.mu_d={mu}"),
    ];
    Scene::parse(ground, "trial", Path::new(""), &set).unwrap()
}

fn needed(ground: &str, drive: DriveKind) -> f64 {
    let options = Options {
        drive,
        ..Options::default()
    };
    let setup = PathSetup::new(&scene(ground, 0.8), options).unwrap();
    judge(&setup).unwrap().needed_mu.unwrap()
}

/// x of the middle wheel at the end of 20 s, m.
fn driven(ground: &str, mu: f64) -> f64 {
    let mut plant = Plant::new(&scene(ground, mu).plant_setup()).unwrap();
    let mut x = 0.0;
    for _ in 0..20_000 {
        x = plant.next_truth().unwrap().wheels[1].position.x;
    }
    x
}

/// Acceptance: on ramps the simulated robot does not pass with less friction than the best
/// tractions need; on ramps and kerbs it passes with more than equal T/N need. 0.85 and 1.25 leave
/// room for what statics leaves out: momentum, unequal T/N, slip. A kerb of 30 mm it passes with
/// less than statics asks for (docs/paths.md).
#[test]
fn the_simulated_robot_passes_as_judged() {
    let grounds = [RAMP, STEEP, LOW_KERB, KERB];
    let runs: Vec<_> = grounds
        .par_iter()
        .map(|ground| {
            let best = 0.85 * needed(ground, DriveKind::Ideal);
            let equal = 1.25 * needed(ground, DriveKind::Shared);
            (best, driven(ground, best), equal, driven(ground, equal))
        })
        .collect();
    for (ground, (below, stuck, above, passed)) in grounds.iter().zip(runs) {
        println!("{below:.3}: {stuck:.3} m; {above:.3}: {passed:.3} m");
        // The rear wheel meets the kerb or the slope when the middle one is at 0.7 m; 20 s at 0.1
        // m/s are 1.9 m.
        if [RAMP, STEEP].contains(ground) {
            assert!(stuck < 0.9, "{ground}: {stuck} m with mu = {below}");
        }
        assert!(passed > 1.2, "{ground}: {passed} m with mu = {above}");
    }
}

/// Equivalence: on a slope of 15 deg with mu = 0.4 the speed control has the forces of the simulated
/// robot, though its front wheel slides. 1.5 N: inertia, penetration.
#[test]
fn the_forces_of_the_speed_control_are_those_of_the_simulation() {
    let set = ["contact.mu_s=0.4", "contact.mu_d=0.4", "engine.kind=direct"].map(str::to_owned);
    let scene = Scene::load(&root().join("scenes/ramp.toml"), &set).unwrap();
    let options = Options {
        drive: DriveKind::Speed,
        ..Options::default()
    };
    let report = judge(&PathSetup::new(&scene, options).unwrap()).unwrap();
    let mut plant = Plant::new(&scene.plant_setup()).unwrap();
    for x in [1.3, 1.35, 1.4] {
        let at = report.places.iter().find(|place| place.x() >= x).unwrap();
        let truth = loop {
            let truth = plant.next_truth().unwrap();
            if truth.wheels[1].position.x >= at.x() {
                break truth;
            }
        };
        let (n, t) = (at.normal_force.unwrap(), at.traction.unwrap());
        for i in 0..3 {
            let wheel = &truth.wheels[i];
            let differences = [n[i] - wheel.normal_force, t[i] - wheel.traction];
            assert!(
                differences.iter().all(|d| d.abs() < 1.5),
                "{x} {i}: {differences:?}"
            );
        }
        assert!((t[0] / n[0] - 0.4).abs() < 1e-6, "{x}: {n:?} {t:?}");
    }
}

/// The commands of docs/paths.md run, and leave the files that it names.
#[test]
fn the_documented_commands_run() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = root().join("scenes");
    let mut count = 0;
    for line in page_commands("paths.md") {
        let line = line.strip_prefix("cargo run --release -- ").unwrap();
        let words = line.split(' ').map(|w| match w.strip_prefix("scenes/") {
            Some(name) => scenes.join(name).display().to_string(),
            None => w.to_owned(),
        });
        let output = succeeded(robhaz(folder.path()).args(words));
        if line.ends_with("--json") {
            let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            for key in [
                "go",
                "probability",
                "needed_mu",
                "margin",
                "margin_x",
                "first_failure",
                "places",
            ] {
                assert!(report.get(key).is_some(), "{key}");
            }
        } else {
            assert!(text(&output.stdout).contains(": GO over"), "{line}");
        }
        count += 1;
    }
    assert_eq!(count, 3);
    for name in ["path.parquet", "figures/needed_friction.svg"] {
        assert!(
            folder.path().join("runs/path-smooth").join(name).is_file(),
            "{name}"
        );
    }
}

/// No-go has the exit code 1 and says where and why; files are replaced only with `--force`; bad
/// options are named.
#[test]
fn the_command_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let stairs = root().join("scenes/stairs.toml");
        let output = robhaz(folder.path())
            .arg("path")
            .arg(stairs)
            .args(["--set", "robot.geometry=A"])
            .args(arguments)
            .output();
        let output = output.unwrap();
        let code = output.status.code();
        (code, text(&output.stdout), text(&output.stderr))
    };
    let out = ["--out", "judged", "--format", "csv"];
    let (code, stdout, _) = run(&out);
    assert_eq!(code, Some(1));
    assert_contains(&stdout, "NO-GO at x = 0.9");
    let columns = std::fs::read_to_string(folder.path().join("judged/columns.csv")).unwrap();
    assert_contains(&columns, "path,needed_mu,1,");
    let (_, _, stderr) = run(&out);
    assert_contains(&stderr, "path.csv exists");
    assert_contains(&stderr, "--force");
    let (_, stdout, _) = run(&[out.as_slice(), &["--force"]].concat());
    assert_contains(&stdout, "NO-GO");
    for (arguments, expected) in [
        (["--mu", "-0.1"], "--mu) is -0.1"),
        (["--mu-sigma", "-1"], "--mu-sigma) is -1"),
        (["--distance", "-1"], "--distance) is -1"),
        (["--set", "terrain.kind=flat"], "there is no path ahead"),
    ] {
        let (code, _, stderr) = run(&arguments);
        assert_eq!(code, Some(1), "{arguments:?}");
        assert_contains(&stderr, expected);
    }
}
