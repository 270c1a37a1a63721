//! Errors of drive, control and friction, and the engine's step.

use super::{lines, one};
use robhaz_scene::Scene;
use std::path::Path;

/// The friction laws that are too stiff for the steps of `rapier` are refused with the key, the
/// limit and the remedies; `direct` takes them. Keys of another law are refused.
#[test]
fn stiff_friction_is_refused_with_its_limit() {
    one(
        "contact.friction = 'rigid'",
        "x.toml:1: contact.friction: found contact.friction = \"rigid\" and contact.v_s = 0.001 and \
         engine.step = 2e-4, allowed: engine.step at most 2.26e-5 s, the friction's slope at zero slip against \
         wheel and robot; or engine.kind = \"direct\"",
    );
    one(
        "[contact]\nfriction = 'brush'",
        "x.toml:2: contact.friction: found contact.friction = \"brush\" and contact.slip_stiffness = 20 and \
         engine.step = 2e-4, allowed: engine.step at most 1.77e-4 s, the friction's slope at zero slip against \
         wheel and robot; or engine.kind = \"direct\"",
    );
    one(
        "engine.step = 1e-3\n[contact]\ndamping = 0\nrolling_resistance = 1",
        "x.toml:4: contact.rolling_resistance: found contact.rolling_resistance = 1 and engine.step = 0.001, \
         allowed: engine.step at most 9.03e-4 s, the moment's slope at standstill against wheel and rotor; \
         or engine.kind = \"direct\"",
    );
    let direct = "engine.kind = 'direct'\n[contact]\n";
    for good in [
        "friction = 'rigid'",
        "friction = 'rigid'\nv_s = '0.2 mm/s'",
        "friction = 'brush'\nslip_stiffness = 50",
        "rolling_resistance = 1",
    ] {
        Scene::parse(&format!("{direct}{good}"), "x.toml", Path::new(""), &[]).unwrap();
    }
    for good in [
        "friction = 'brush'\nslip_stiffness = 17",
        "rolling_resistance = 0.05",
    ] {
        Scene::parse(&format!("[contact]\n{good}"), "x.toml", Path::new(""), &[]).unwrap();
    }
    one(
        &format!("{direct}friction = 'rigid'\nv_s = 0.02"),
        "x.toml:4: contact.v_s: found contact.v_s = 0.02 and contact.friction = \"rigid\", \
         allowed: contact.v_s of at least 2e-4 and at most 0.002 m/s with this law",
    );
    one(
        "[contact]\nslip_stiffness = 5",
        "x.toml:2: contact.slip_stiffness: found contact.slip_stiffness = 5 and contact.friction = \"adams\", \
         allowed: contact.slip_stiffness 20 unless contact.friction = \"brush\"",
    );
    one(
        "contact.friction = 'brusch'",
        "x.toml:1: contact.friction: found 'brusch', allowed: \"adams\", \"brush\", \"rigid\"; did you mean \"brush\"?",
    );
}

/// Scalings of the set speed: wheels and times that do not exist, and times of one wheel that
/// overlap. A control needs an estimator that the scene has, one set speed, and gains that its
/// samples bear.
#[test]
fn wrong_controls_are_refused() {
    one(
        "drive.kind = 'shred'",
        "x.toml:1: drive.kind: found 'shred', allowed: \"speed\", \"shared\", \"friction-test\"; did you mean \"shared\"?",
    );
    one(
        "estimator = []\ndrive.kind = 'shared'",
        "x.toml:2: drive.kind: found 'shared', allowed: \"speed\" without one of the estimators \"kalman-no-angles\", \"kalman\"; \
         or drive.estimator: one of the scene's estimators, which has none",
    );
    one(
        "drive.estimator = 'klaman'",
        "x.toml:1: drive.estimator: found 'klaman', allowed: \"paper-body\", \"paper-wheels\", \"true-mass\", \"kalman\", \
         \"kalman-no-angles\"; did you mean \"kalman\"?",
    );
    one(
        "[drive]\nkind = 'shared'\n[[drive.scaling]]\nwheels = [1]\nfrom = 1\nto = 5\nfactor = 2",
        "x.toml:3: drive.scaling: found drive.scaling = 1 and drive.kind = \"shared\", allowed: no [[drive.scaling]]: \
         one speed control has one set speed for all wheels",
    );
}

/// One speed control takes at most the gains that a wheel in the air bears at the rate of the
/// readings: 0.7 J/lag = 10.1 N m s and a quarter of it over the lag of robot A at 1 kHz. The drives
/// keep theirs.
#[test]
fn shared_gains_are_those_that_the_rate_bears() {
    let gains = |text: &str| {
        let scene = Scene::parse(text, "x.toml", Path::new(""), &[]).unwrap();
        let settings = scene.control_settings().unwrap();
        (settings.kp, settings.ki)
    };
    let (kp, ki) = gains("[drive]\nkind = 'shared'\nkp = 20\nki = 1000");
    assert!((kp - 0.7 * 0.0939 / 6.5e-3).abs() < 0.01 * kp, "{kp}");
    assert!((ki / kp - 0.25 / 6.5e-3).abs() < 1e-9, "{ki}");
    assert_eq!(
        gains("[drive]\nkind = 'shared'\nkp = 2\nki = 20"),
        (2.0, 20.0)
    );
    assert_eq!(gains("[drive]\nkp = 20\nki = 1000"), (20.0, 1000.0));
}

/// The control gets the estimator without contact angles, else `kalman`, else the one that is named.
#[test]
fn a_control_finds_its_estimator() {
    let estimator = |text: &str| {
        let scene = Scene::parse(text, "x.toml", Path::new(""), &[]).unwrap();
        let index = scene.control_estimator();
        index.map(|k| scene.estimators[k].name.clone())
    };
    assert_eq!(estimator(""), None);
    assert_eq!(estimator("drive.estimator = 'kalman'"), None);
    let found = estimator("drive.kind = 'shared'");
    assert_eq!(found.as_deref(), Some("kalman-no-angles"));
    let found = estimator("drive.kind = 'shared'\n[[estimator]]\nname = 'kalman'");
    assert_eq!(found.as_deref(), Some("kalman"));
    let found = estimator("[drive]\nkind = 'shared'\nestimator = 'true-mass'");
    assert_eq!(found.as_deref(), Some("true-mass"));
}

#[test]
fn wrong_scalings_are_refused() {
    let scaling = |keys: &str| format!("[[drive.scaling]]\n{keys}\n");
    let times = "from = 1\nto = 2\nfactor = 0";
    one(
        &scaling(&format!("wheels = [4]\n{times}")),
        "x.toml:2: drive.scaling[0].wheels: found [4] (an array), allowed: an array of 1 to 3 different wheels: \
         1 front, 2 middle, 3 rear",
    );
    one(
        &scaling(&format!("wheels = [1, 1]\n{times}")),
        "x.toml:2: drive.scaling[0].wheels: found [1, 1] (an array), allowed: an array of 1 to 3 different wheels: \
         1 front, 2 middle, 3 rear",
    );
    for bad in ["[]", "1", "'front'"] {
        let found = lines(&scaling(&format!("wheels = {bad}\n{times}")));
        let allowed = "allowed: an array of 1 to 3 different wheels: 1 front, 2 middle, 3 rear";
        assert!(found[0].ends_with(allowed), "{found:?}");
    }
    one(
        &scaling("wheels = [2]\nfrom = 2\nto = 2\nfactor = 0"),
        "x.toml:4: drive.scaling[0].to: found 2, allowed: above from, 2 s",
    );
    let first = scaling("wheels = [1, 2]\nfrom = 1\nto = 3\nfactor = 0");
    one(
        &(first.clone() + &scaling("wheels = [2, 3]\nfrom = 2.9\nto = 4\nfactor = 2")),
        "x.toml:8: drive.scaling[1].from: found 2.9, allowed: a time outside of that of drive.scaling[0], 1 to 3 s, \
         which has wheel 2 too",
    );
    for next in ["wheels = [3]\nfrom = 2", "wheels = [1]\nfrom = 3"] {
        let text = first.clone() + &scaling(&format!("{next}\nto = 4\nfactor = 2"));
        let scene = Scene::parse(&text, "x.toml", Path::new(""), &[]).unwrap();
        assert_eq!(scene.drive.scalings.len(), 2);
    }
    let found = lines(&scaling("wheels = [1]"));
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(
        found.iter().all(|line| line.contains("missing")),
        "{found:?}"
    );
}

/// Scalings that have no effect, or not all of it, are allowed, with a warning.
#[test]
fn scalings_without_effect_are_warned_of() {
    let warnings = |times: &str| {
        let text = format!("[[drive.scaling]]\nwheels = [1]\nfactor = 2\n{times}");
        let scene = Scene::parse(&text, "x.toml", Path::new(""), &[]);
        scene.unwrap().warnings()
    };
    assert_eq!(warnings("from = 2\nto = 3"), [""; 0]);
    let found = warnings("from = 20\nto = 30");
    let late = "drive.scaling[0] begins at 20 s, when the run has ended (20 s)";
    assert_eq!(found, [late]);
    let found = warnings("from = 2\nto = 2.5");
    let short = "drive.scaling[0] lasts 0.500 s, shorter than drive.ramp_time = 0.6 s: its factor is not reached";
    assert_eq!(found, [short]);
}

/// The longest step is that of the robot and ground at hand: the damping's limit grows with the
/// wheel's mass, and undamped ground has a limit from its stiffness.
#[test]
fn the_longest_step_belongs_to_the_robot() {
    let limits = |overrides: &[&str]| -> Vec<String> {
        let sets: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
        match Scene::parse("", "x.toml", Path::new(""), &sets) {
            Ok(_) => Vec::new(),
            Err(error) => error.problems.iter().map(|p| p.message.clone()).collect(),
        }
    };
    let stiff = "contact.damping=2e5";
    let found = limits(&[stiff, "engine.step=3e-4"]);
    assert!(
        matches!(&found[..], [one] if one.contains("engine.step at most 2.92e-4 s, 39 times")),
        "{found:?}"
    );
    // Wheels of 3 kg instead of 1.5 kg: 0.585 ms.
    let heavy = "robot.mass.wheel=3";
    assert_eq!(limits(&[stiff, heavy, "engine.step=5.8e-4"]), [""; 0]);
    let found = limits(&[stiff, heavy, "engine.step=6e-4"]);
    assert!(
        matches!(&found[..], [one] if one.contains("engine.step at most 5.85e-4 s, 39 times")),
        "{found:?}"
    );
    let undamped = ["contact.damping=0", "contact.stiffness=1e13"];
    let found = limits(&[&undamped[..], &["engine.step=8e-4"]].concat());
    assert!(
        found
            .iter()
            .any(|one| one.contains("two over the natural frequency")),
        "{found:?}"
    );
    assert_eq!(
        limits(&[&undamped[..], &["engine.step=2e-4"]].concat()),
        [""; 0]
    );
}
