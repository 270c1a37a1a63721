//! Error messages: every problem of a scene on one line, with file, line, key, what was found and what is allowed.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use miette::Diagnostic;
use robhaz_scene::{Scene, SceneError};
use std::path::Path;

fn error(text: &str) -> SceneError {
    match Scene::parse(text, "x.toml", Path::new(""), &[]) {
        Err(error) => error,
        Ok(_) => panic!("no error in: {text}"),
    }
}

fn lines(text: &str) -> Vec<String> {
    error(text).problems().map(ToString::to_string).collect()
}

/// The text has this one problem.
#[track_caller]
fn one(text: &str, expected: &str) {
    assert_eq!(lines(text), [expected]);
}

#[test]
fn out_of_range() {
    one(
        "[drive]\n\n# Nm\ntorque_limit = -3\n",
        "x.toml:4: drive.torque_limit: found -3, allowed: a number above 0 and at most 1e6, in N m",
    );
    one(
        "engine.step = '2 ms'",
        "x.toml:1: engine.step: found '2 ms', allowed: a number above 0 and at most 0.001, in s",
    );
    for bad in ["inf", "nan", "-inf", "1e999"] {
        let lines = lines(&format!("drive.speed = {bad}"));
        assert!(lines[0].contains(&format!("found {bad}, allowed: a number of at least -10")));
    }
}

#[test]
fn wrong_unit() {
    one(
        "[drive]\nspeed = \"20 kg\"",
        "x.toml:2: drive.speed: found \"20 kg\" with the unit kg, allowed units: m/s, cm/s, mm/s, km/h",
    );
    one(
        "[contact]\nmu_s = \"0.8 m\"",
        "x.toml:2: contact.mu_s: found \"0.8 m\" with the unit m, \
         allowed: a number of at least 0 and at most 10, without a unit",
    );
    let lines = lines("[contact]\nstiffness = \"150 N/mm^2.1\"\nv_s = \"0.02\"\nv_d = \"fast\"");
    assert!(lines[0].ends_with("with the unit N/mm^2.1, allowed units: N/m^n"));
    assert!(lines[1].contains("found \"0.02\", a text without a unit, allowed: a number above 0"));
    assert!(lines[2].contains("found \"fast\", allowed: a number above 0"));
    assert!(lines[2].ends_with("in m/s, or a text with a unit (m/s, cm/s, mm/s, km/h)"));
}

#[test]
fn wrong_type() {
    one(
        "drive.kp = true",
        "x.toml:1: drive.kp: found true (a boolean), allowed: a number of at least 0 and at most 1e6, \
         in N m s, or a text with a unit (N m s, mN m s)",
    );
    one("drive = 3", "x.toml:1: drive: found 3, allowed: a table");
    one(
        "terrain = 'flat'",
        "x.toml:1: terrain: found 'flat', allowed: a table",
    );
    one(
        "robot = 'A'",
        "x.toml:1: robot: found 'A', allowed: a table",
    );
    one(
        "[estimator]\nname = 'true-mass'",
        "x.toml:1: estimator: found [estimator] (a table), \
         allowed: an array of tables, each headed [[estimator]]",
    );
    for bad in ["-1", "1.0", "'1'", "18446744073709551616", "1979-05-27"] {
        let lines = lines(&format!("seed = {bad}"));
        assert!(lines[0].contains("allowed: a whole number of at least 0 and below 2^64"));
    }
    for good in ["0", "18446744073709551615", "0xff", "1_000"] {
        Scene::parse(&format!("seed = {good}"), "x.toml", Path::new(""), &[]).unwrap();
    }
}

#[test]
fn unknown_keys_and_sections() {
    one(
        "[drive]\nkp = 3\ntorqe_limit = 3",
        "x.toml:3: drive.torqe_limit: unknown key, allowed: speed, kp, ki, torque_limit, tracking_time, \
         viscous_damping, gear_friction, start_time, ramp_time, kind, estimator, friction_test, scaling; did you mean torque_limit?",
    );
    one(
        "[drives]\nkp = 3",
        "x.toml:1: drives: unknown key, allowed: name, seed, robot, terrain, estimator, contact, drive, sensors, \
         model_error, engine, record; did you mean drive?",
    );
    let found = lines("mu_s = 3\n[[estimator]]\nname = 'true-mass'\npole = 3");
    assert!(
        found[0].ends_with("; mu_s belongs to [contact]"),
        "{}",
        found[0]
    );
    assert!(
        found[1].starts_with("x.toml:4: estimator[0].pole: unknown key, allowed: name, label,")
    );
}

#[test]
fn wrong_words() {
    one(
        "engine.kind = 'rapper'",
        "x.toml:1: engine.kind: found 'rapper', allowed: \"rapier\", \"direct\"; did you mean \"rapier\"?",
    );
    one(
        "sensors.grade = 3",
        "x.toml:1: sensors.grade: found 3, allowed: \"ideal\", \"typical\", \"poor\"",
    );
}

#[test]
fn keys_of_another_kind_of_terrain() {
    one(
        "[terrain]\nkind = \"flat\"\nheight = 0.1",
        "x.toml:3: terrain.height: found height, allowed: with kind = \"flat\": kind, stretch; \
         height belongs to kind = \"cosbump\"",
    );
    one(
        "[terrain]\nbumps = []",
        "x.toml:2: terrain.bumps: found bumps, allowed: with kind = \"smooth\": kind, stretch; \
         bumps belongs to kind = \"bumps\"",
    );
    one(
        "[terrain]\nkind = 'bumps'",
        "x.toml:1: terrain.bumps: missing, and it has no default; \
         allowed: an array of 1 to 1000 tables {height, centre, width}",
    );
    let found = lines(
        "[terrain]\nkind = 'bumps'\nbumps = [{height = 1, centre = 2}, {height = 1, centre = 2, width = 0}]",
    );
    assert!(
        found[0].starts_with("x.toml:3: terrain.bumps[0].width: missing, and it has no default")
    );
    assert!(found[1].starts_with(
        "x.toml:3: terrain.bumps[1].width: found 0, allowed: a number of at least 0.005"
    ));
}

/// The nominal robot is checked like the simulated one.
#[test]
fn an_invalid_nominal_robot_is_refused() {
    let with = |seed: u32| lines(&format!("seed = {seed}\n[model_error]\nlink_masses = 1"));
    // Each of three masses is negative in 16 % of the draws.
    let found = (0..20).map(with).find(|found| !found.is_empty());
    let found = found.expect("a seed that draws a negative mass");
    let expected = "the nominal masses that [model_error] draws are not valid: links[";
    assert!(
        found[0].starts_with("x.toml:2: model_error: with seed ") && found[0].contains(expected),
        "{found:?}"
    );
}

#[test]
fn rules_over_several_keys() {
    one(
        "[contact]\nmu_d = 0.9",
        "x.toml:2: contact.mu_d: found contact.mu_d = 0.9 and contact.mu_s = 0.8, \
         allowed: contact.mu_d not above contact.mu_s",
    );
    one(
        "contact.v_s = '10 cm/s'",
        "x.toml:1: contact.v_s: found contact.v_s = 0.1 and contact.v_d = 0.1, \
         allowed: contact.v_s below contact.v_d",
    );
    one(
        "record.duration = 1",
        "x.toml:1: record.duration: found record.compare_from = 2 and record.duration = 1, \
         allowed: record.compare_from below record.duration",
    );
    one(
        "sensors.rate = 1500",
        "x.toml:1: sensors.rate: found sensors.rate = 1500 and record.rate = 1000, \
         allowed: sensors.rate a whole multiple of record.rate",
    );
    one(
        "sensors.jitter = '1 ms'",
        "x.toml:1: sensors.jitter: found sensors.jitter = 0.001 and sensors.rate = 1000, \
         allowed: sensors.jitter at most 3e-4 s, 0.3 of the time between samples",
    );
    one(
        "[[estimator]]\nname = 'true-mass'\nparity = 'on'",
        "x.toml:3: estimator[0].parity: found 'on', allowed: \"off\" unless filters = \"kalman\"",
    );
    // The Kalman filters have no observer pole: another one than the default would have no effect.
    one(
        "[[estimator]]\nname = 'best'\nobserver_pole = 30",
        "x.toml:3: estimator[0].observer_pole: found 30, allowed: 50 unless filters = \"paper\"",
    );
    assert!(
        Scene::parse(
            "[[estimator]]\nname = 'best'\nobserver_pole = 50",
            "x.toml",
            Path::new(""),
            &[]
        )
        .is_ok()
    );
    // An explicit drive overshoots in each step where its slope is too great, whichever part makes it.
    for (key, value, longest, most) in [
        ("kp", "1000", "5.66e-5", "453"),
        ("viscous_damping", "600", "9.36e-5", "448"),
        ("gear_friction", "20", "2.82e-5", "4.48"),
    ] {
        one(
            &format!("drive.{key} = {value}"),
            &format!(
                "x.toml:1: drive.{key}: found drive.{key} = {value} and engine.step = 1.25e-4, \
                 allowed: engine.step at most {longest} s or drive.{key} at most {most}, \
                 the drive's slope against wheel, rotor and links; or engine.kind = \"direct\""
            ),
        );
    }
    // Nor may the integral be faster than the slope damps it.
    one(
        "drive.ki = 1e5",
        "x.toml:1: drive.ki: found drive.ki = 100000 and engine.step = 1.25e-4, \
         allowed: drive.ki at most 16400, what drive.kp and the losses damp at this step; \
         or engine.kind = \"direct\"",
    );
    let found = lines("record.duration = 2.00005");
    assert!(
        found[0].contains("allowed: a whole number of records"),
        "{}",
        found[0]
    );
    let found = lines("record.duration = 1e6");
    assert!(
        found[0].contains("allowed: at most 1e8 records"),
        "{}",
        found[0]
    );
    // Beyond twice the time constant of a bare wheel on the damping an explicit contact force diverges in silence.
    assert_eq!(
        lines("contact.damping = 5e4"),
        [
            "x.toml:1: contact.damping: found contact.damping = 50000 and engine.step = 1.25e-4, \
            allowed: engine.step at most 6e-5 s, twice the wheel's mass over the damping; or engine.kind = \"direct\""
        ]
    );
    let found = lines("contact.v_s = '0.5 mm/s'");
    assert!(found[0].contains("engine.step at most 9.07"), "{found:?}");
    let found = lines("engine.step = 1e-12");
    assert!(
        found[0].contains("allowed: at most 1e11 steps"),
        "{}",
        found[0]
    );
}

/// The friction laws that are too stiff for the steps of `rapier` are refused with the key, the limit and the remedies;
/// `direct` takes them. Keys of another law are refused.
#[test]
fn stiff_friction_is_refused_with_its_limit() {
    one(
        "contact.friction = 'rigid'",
        "x.toml:1: contact.friction: found contact.friction = \"rigid\" and contact.v_s = 0.001 and \
         engine.step = 1.25e-4, allowed: engine.step at most 2.26e-5 s, the friction's slope at zero slip against \
         wheel and robot; or engine.kind = \"direct\"",
    );
    one(
        "[contact]\nfriction = 'brush'",
        "x.toml:2: contact.friction: found contact.friction = \"brush\" and contact.slip_stiffness = 20 and \
         engine.step = 1.25e-4, allowed: engine.step at most 1.08e-4 s, the friction's slope at zero slip against \
         wheel and robot; or engine.kind = \"direct\"",
    );
    one(
        "engine.step = 1e-3\n[contact]\ndamping = 0\nrolling_resistance = 1",
        "x.toml:4: contact.rolling_resistance: found contact.rolling_resistance = 1 and engine.step = 0.001, \
         allowed: engine.step at most 5.55e-4 s, the moment's slope at standstill against wheel and rotor; \
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

/// Scalings of the set speed: wheels and times that do not exist, and times of one wheel that overlap.
/// A control needs an estimator that the scene has, one set speed, and gains that its samples bear.
#[test]
fn wrong_controls_are_refused() {
    one(
        "drive.kind = 'shred'",
        "x.toml:1: drive.kind: found 'shred', allowed: \"speed\", \"shared\", \"friction-test\"; did you mean \"shared\"?",
    );
    one(
        "estimator = []\ndrive.kind = 'shared'",
        "x.toml:2: drive.kind: found 'shared', allowed: \"speed\" without one of the estimators \"no-angles\", \"best\"; \
         or drive.estimator: one of the scene's estimators, which has none",
    );
    one(
        "drive.estimator = 'bset'",
        "x.toml:1: drive.estimator: found 'bset', allowed: \"paper-body\", \"paper-wheels\", \"true-mass\", \"best\", \
         \"no-angles\"; did you mean \"best\"?",
    );
    one(
        "[drive]\nkind = 'shared'\n[[drive.scaling]]\nwheels = [1]\nfrom = 1\nto = 5\nfactor = 2",
        "x.toml:3: drive.scaling: found drive.scaling = 1 and drive.kind = \"shared\", allowed: no [[drive.scaling]]: \
         one speed control has one set speed for all wheels",
    );
    one(
        "[drive]\nkind = 'shared'\nkp = 10.2",
        "x.toml:3: drive.kp: found drive.kp = 10.2 and sensors.rate = 1000 and drive.kind = \"shared\", \
         allowed: drive.kp at most 10.11, what the inertia of a wheel in the air bears at this rate",
    );
    one(
        "[drive]\nkind = 'shared'\nki = 200",
        "x.toml:3: drive.ki: found drive.ki = 200 and sensors.rate = 1000 and drive.kind = \"shared\", \
         allowed: drive.ki at most 192.3, what drive.kp damps at this rate",
    );
}

/// The control gets the estimator without contact angles, else `best`, else the one that is named.
#[test]
fn a_control_finds_its_estimator() {
    let estimator = |text: &str| {
        let scene = Scene::parse(text, "x.toml", Path::new(""), &[]).unwrap();
        let index = scene.control_estimator();
        index.map(|k| scene.estimators[k].name.clone())
    };
    assert_eq!(estimator(""), None);
    assert_eq!(estimator("drive.estimator = 'best'"), None);
    let found = estimator("drive.kind = 'shared'");
    assert_eq!(found.as_deref(), Some("no-angles"));
    let found = estimator("drive.kind = 'shared'\n[[estimator]]\nname = 'best'");
    assert_eq!(found.as_deref(), Some("best"));
    let found = estimator("[drive]\nkind = 'shared'\nestimator = 'true-mass'");
    assert_eq!(found.as_deref(), Some("true-mass"));
}

#[test]
fn wrong_scalings_are_refused() {
    let scaling = |keys: &str| format!("[[drive.scaling]]\n{keys}\n");
    let times = "from = 1\nto = 2\nfactor = 0";
    one(
        &scaling(&format!("wheels = [4]\n{times}")),
        "x.toml:2: drive.scaling[0].wheels[0]: found 4, allowed: a wheel: 1 front, 2 middle, 3 rear",
    );
    one(
        &scaling(&format!("wheels = [1, 1]\n{times}")),
        "x.toml:2: drive.scaling[0].wheels[1]: found 1, allowed: each wheel once",
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

/// The longest step is that of the robot and ground at hand: the damping's limit grows with the wheel's mass, and
/// undamped ground has a limit from its stiffness.
#[test]
fn the_longest_step_belongs_to_the_robot() {
    let limits = |overrides: &[&str]| -> Vec<String> {
        let sets: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
        match Scene::parse("", "x.toml", Path::new(""), &sets) {
            Ok(_) => Vec::new(),
            Err(error) => error.problems().map(|p| p.message().to_owned()).collect(),
        }
    };
    let found = limits(&["engine.step=2e-4"]);
    assert!(
        matches!(&found[..], [one] if one.contains("engine.step at most 1.5e-4 s, twice")),
        "{found:?}"
    );
    // Wheels of 3 kg instead of 1.5 kg: 0.3 ms.
    let heavy = "robot.mass.wheel=3";
    assert_eq!(limits(&[heavy, "engine.step=2.9e-4"]), [""; 0]);
    let found = limits(&[heavy, "engine.step=3.1e-4"]);
    assert!(
        matches!(&found[..], [one] if one.contains("engine.step at most 3e-4 s, twice")),
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

/// Counts are whole numbers.
#[test]
fn counts_are_whole_numbers() {
    one(
        "[terrain]\nkind = 'stairs'\ncount = 2.5\n",
        "x.toml:3: terrain.count: found 2.5, allowed: a whole number of at least 1 and at most 1000",
    );
}

/// A limit in a message is one that is allowed, however small: never 0.
#[test]
fn a_limit_is_never_rounded_to_zero() {
    let sets = ["robot.mass.wheel=3e-9".to_owned()];
    let error = Scene::parse("", "x.toml", Path::new(""), &sets).expect_err("a wheel too light");
    let line = error
        .problems()
        .map(ToString::to_string)
        .find(|line| line.contains("twice the wheel's mass over the damping"))
        .expect("the limit");
    let (_, limit) = line.split_once("engine.step at most ").expect("a limit");
    let limit: f64 = limit
        .split(' ')
        .next()
        .expect("a number")
        .parse()
        .expect("a number");
    // 2 x 3e-9 kg / 2e4 N s/m, rounded down to three digits.
    assert!((2.99e-13..=3e-13).contains(&limit), "{line}");
}

/// Numbers too large for a double are out of range, with a unit and without.
#[test]
fn numbers_too_large_are_out_of_range() {
    for bad in ["1e400 m/s", "1e400", "-1e999 km/h"] {
        let found = lines(&format!("drive.speed = '{bad}'"));
        let expected = format!("drive.speed: found '{bad}', allowed: a number of at least -10");
        assert!(found[0].contains(&expected), "{found:?}");
    }
}

/// A robot that cannot stand is refused with the real reason, at its key, with the allowed values.
#[test]
fn robots_that_cannot_stand() {
    let found = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        let error = Scene::parse("", "x.toml", Path::new(""), &sets)
            .expect_err("a robot that cannot stand");
        let lines: Vec<String> = error.problems().map(ToString::to_string).collect();
        assert_eq!(lines.len(), 1, "{lines:?}");
        lines[0].clone()
    };
    for (set, expected) in [
        (
            "robot.geometry.axles=[[0.15, 0.1], [0, 0.1], [-0.3, 0.1]]",
            "robot.geometry.axles: the front and the middle wheel overlap: their axles are 0.1500 m apart; allowed: at least twice \
             the wheel radius, 0.2000 m",
        ),
        (
            "robot.geometry.pins.q=[-0.05, -0.02]",
            "robot.geometry.pins.q: pin Q is not above the ground: its y is -0.02 m; allowed: above 0, where the wheels stand",
        ),
        (
            "robot.geometry.body_cg=[0.03, -0.1]",
            "robot.geometry.body_cg: the centre of mass of body is not above the ground: its y is -0.1 m; allowed: above 0",
        ),
        (
            "robot.geometry.body_cg=[1.0, 0.3]",
            "robot.geometry.body_cg: the robot tips forward: its centre of mass is 42 mm ahead of the front wheel (axle at \
             x = 0.3 m); allowed: between the axles of the rear and the front wheel",
        ),
        (
            "robot.geometry.body_cg=[-0.9, 0.3]",
            "robot.geometry.body_cg: the robot tips backward: its centre of mass is",
        ),
        (
            "robot.geometry.body_cg=[0.6, 0.3]",
            "robot.geometry.body_cg: the linkage folds: on level ground the static normal force of the",
        ),
    ] {
        let line = found(&[set]);
        println!("{line}");
        assert!(
            line.starts_with(&format!("--set {set}: {expected}")),
            "{line}"
        );
    }
    // In a file: its name and line.
    let dir = tempfile::tempdir().expect("a folder");
    let text =
        include_str!("../../../robots/geometry-a.toml").replace("[0.03, 0.30]", "[1.0, 0.30]");
    std::fs::write(dir.path().join("front.toml"), &text).expect("written");
    let error = Scene::parse("robot.geometry = 'front.toml'", "x.toml", dir.path(), &[]);
    let line = error.expect_err("a robot that cannot stand").to_string();
    let number = 1 + text
        .lines()
        .position(|l| l.starts_with("body_cg"))
        .expect("the key");
    let place = format!("front.toml:{number}: body_cg: the robot tips forward");
    assert!(line.contains(&place), "{line}");
}

#[test]
fn estimators() {
    let found = lines("[[estimator]]\nname = 'paper-body'\n[[estimator]]\nname = 'paper-body'");
    assert_eq!(
        found,
        [
            "x.toml:4: estimator[1].label: found 'paper-body', allowed: a label that estimator[0] does not have"
        ]
    );
    let found = lines(
        "[[estimator]]\nlabel = 'a'\n[[estimator]]\nname = 'paper'\n[[estimator]]\nname = 'true-mass'\nlabel = '../x'",
    );
    assert_eq!(found.len(), 3);
    assert!(found[0].starts_with("x.toml:1: estimator[0].name: missing"));
    assert!(
        found[1]
            .starts_with("x.toml:4: estimator[1].name: found 'paper', allowed: \"paper-body\",")
    );
    assert!(
        found[2]
            .starts_with("x.toml:7: estimator[2].label: found '../x', allowed: a text of 1 to 64")
    );
}

#[test]
fn robots() {
    one(
        "robot.geometry = 'a'",
        "x.toml:1: robot.geometry: found 'a', allowed: \"A\", \"B\", the path of a geometry file ending in .toml, \
         or a table with the keys of such a file; did you mean \"A\"?",
    );
    let found = lines("[robot]\nmass = 'no/such.toml'");
    assert!(found[0].starts_with(
        "x.toml:2: robot.mass: found 'no/such.toml', but no/such.toml cannot be read: "
    ));
    assert!(found[0].contains("; allowed: \"caption\", \"text\", the path of a mass file"));
    let found = lines("[robot.mass]\nbody = 0\nlinks = [1, 2]\nwheel = 1");
    assert!(found.iter().any(|l| l.starts_with("x.toml:2: robot.mass.body: found 0, allowed: a number above 0")));
    assert!(found.iter().any(|l| l.starts_with(
        "x.toml:3: robot.mass.links: found [1, 2] (an array), allowed: [a, b, c], each"
    )));
    assert!(
        found
            .iter()
            .any(|l| l.starts_with("x.toml:1: robot.mass.rotor_inertia: missing"))
    );
    assert_eq!(found.len(), 6);
}

/// Problems that `Geometry::check` finds are reported at their line in the robot's file.
#[test]
fn impossible_geometries() {
    let good = include_str!("../../../robots/geometry-a.toml");
    let dir = tempfile::tempdir().unwrap();
    let check = |from: &str, to: &str, key: &str, message: &str| {
        let text = good.replace(from, to);
        assert_ne!(text, good);
        let line = 1 + text[..text.find(to).unwrap()].matches('\n').count();
        std::fs::write(dir.path().join("bad.toml"), text).unwrap();
        let scene = Scene::parse("robot.geometry = 'bad.toml'", "x.toml", dir.path(), &[]);
        let found = scene.unwrap_err().to_string();
        let start = format!("{}:{line}: {key}: ", dir.path().join("bad.toml").display());
        assert!(found.starts_with(&start), "{found}");
        assert!(found.contains(message), "{found}");
    };
    check(
        "p = [0.15, 0.22]",
        "p = [-0.25, 0.2]",
        "pins.p",
        "pin P lies on the line",
    );
    check(
        "\"link2\", \"link2\"]",
        "\"link1\", \"link1\"]",
        "carriers",
        "link2 carries no wheel",
    );
    check(
        "[0.0, 0.10], [-0.30",
        "[-0.3, 0.10], [-0.30",
        "axles",
        "front, middle, rear",
    );
    check(
        "wheel_radius = 0.10",
        "axes = 3\nwheel_radius = 0.10",
        "axes",
        "did you mean axles?",
    );
    check(
        "\"35 deg\"",
        "\"-35 deg\"",
        "stop.upper",
        "allowed: a number above 0",
    );
    check(
        "[0.0, 0.10], [-0.30, 0.10]]",
        "[0.0, 0.10], [-0.30, 0.11]]",
        "axles",
        "stand on y = 0",
    );
}

#[test]
fn syntax_errors_come_together_with_the_rest() {
    one(
        "[drive]\nkp = 1\nkp = 2",
        "x.toml:3: TOML does not allow this: duplicate key; found: kp = 2",
    );
    assert_eq!(
        lines("[drive]\nspeed = 30 cm/s\n[drive]\nki = -1\n[contact]\nmu_s = 20"),
        [
            "x.toml:2: TOML does not allow this: string values must be quoted, expected literal string; \
             found: speed = 30 cm/s",
            "x.toml:3: TOML does not allow this: duplicate key; found: [drive]",
            "x.toml:4: drive.ki: found -1, allowed: a number of at least 0 and at most 1e6, in N m",
            "x.toml:6: contact.mu_s: found 20, allowed: a number of at least 0 and at most 10",
        ]
    );
    // What follows a line that breaks the structure is not guessed at.
    let found = lines("[contact]\nmu_s = 20\n[drive\nkp = 3\n");
    assert_eq!(found.len(), 2);
    assert!(found[0].starts_with("x.toml:2: contact.mu_s: found 20"));
    assert!(found[1].starts_with("x.toml:3: TOML does not allow this: unclosed table"));
}

#[test]
fn unreadable_files() {
    let error = Scene::load(Path::new("no/such.toml"), &[]).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("no/such.toml: cannot be read: ")
    );
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("binary.toml");
    std::fs::write(&file, [0xff, 0xfe, 0x00]).unwrap();
    let error = Scene::load(&file, &[]).unwrap_err();
    assert!(error.to_string().contains("UTF-8"));
}

#[test]
fn the_report_shows_the_place_of_every_problem() {
    let error = error("[drive]\nkp = -1\nki = -2\nkx = 3");
    assert_eq!(error.problems().count(), 3);
    assert!(
        error
            .to_string()
            .starts_with("x.toml:2: drive.kp: found -1")
    );
    assert!(error.to_string().ends_with("(and 2 more problems)"));
    assert!(error.source_code().is_some());
    assert_eq!(error.related().unwrap().count(), 2);
    for (problem, (line, key)) in error.problems().zip([(2, "kp"), (3, "ki"), (4, "kx")]) {
        assert_eq!((problem.file(), problem.line()), ("x.toml", Some(line)));
        assert_eq!(problem.key(), format!("drive.{key}"));
        let label = problem.labels().unwrap().next().unwrap();
        assert!(label.len() == 2);
    }
}

/// No text makes the reader panic.
#[test]
fn odd_files_make_errors_and_no_panic() {
    for text in [
        "\u{0}",
        "=",
        "[",
        "[[",
        "]]",
        "'",
        "\"\"\"",
        "a.b.c",
        "é = 'ü",
        "[[drive]]\nkp=1",
        "[[robot]]",
        "robot.geometry = []",
        "robot.geometry = [[[[]]]]",
        "robot.geometry = {}",
        "terrain.bumps = 3",
        "terrain = {kind = 'bumps', bumps = 3}",
        "terrain = {kind = 'bumps', bumps = [3]}",
        "estimator = 3",
        "estimator = [3]",
        "estimator = [[]]",
        "name = ''",
        "name = 'A'",
        "drive.kp = 'é m'",
        "drive.kp = ''",
        "robot.geometry = {axles = [1, [1], [1, 2, 3]]}",
        "robot.geometry = {carriers = ['a', 1, 'link1']}",
        "robot.geometry = ''",
        "robot.geometry = '.toml'",
        "robot.geometry = '/.toml'",
    ] {
        assert!(
            error(text)
                .problems()
                .all(|p| !p.to_string().contains('\n')),
            "{text}"
        );
    }
}

#[test]
fn points_of_the_ground() {
    one(
        "[terrain]\nkind = 'heights'\npoints = [[0, 0], [1, 0.1],\n [1, 0.2]]",
        "x.toml:4: terrain.points[2]: found [1, 0.2] (an array), allowed: x above that of the point before, 1 m",
    );
    one(
        "[terrain]\nkind = 'heights'",
        "x.toml:1: terrain: found neither of file and points, allowed: one of them",
    );
    let folder = tempfile::tempdir().unwrap();
    let read = |csv: &str| {
        std::fs::write(folder.path().join("a.csv"), csv).unwrap();
        let text = "terrain = {kind = 'heights', file = 'a.csv'}";
        let scene = Scene::parse(text, "x.toml", folder.path(), &[]);
        scene.map_err(|e| {
            let lines: Vec<_> = e.problems().map(ToString::to_string).collect();
            let folder = format!("{}/", folder.path().display());
            lines.join("\n").replace(&folder, "")
        })
    };
    assert!(read("x,y\r\n# a comment\r\n0,0\r\n\r\n1.5, 2e-2\r\n").is_ok());
    let found = read("x, y\n0, 0\n1, high\n2\n").map(|_| ()).unwrap_err();
    let number =
        "allowed: a number with a decimal point or comma, from -1000 m to 1000 m (separator comma)";
    assert_eq!(
        found,
        format!(
            "a.csv:3: terrain.file: found \"high\" in column \"y\", {number}\n\
             a.csv:4: terrain.file: found nothing in column \"y\", {number}"
        )
    );
    let found = read("0,0\n0,1\n").map(|_| ()).unwrap_err();
    assert_eq!(
        found,
        "a.csv:2: terrain.file: found x = 0 m, allowed: x above that of the point before, 0 m; or sort = \"on\""
    );
}

#[test]
fn stretches_of_the_ground() {
    let stretch = |from: f64, to: f64, mu_s: f64, mu_d: f64| {
        format!("[[terrain.stretch]]\nfrom = {from}\nto = {to}\nmu_s = {mu_s}\nmu_d = {mu_d}\n")
    };
    one(
        &(stretch(0.0, 2.0, 0.5, 0.5) + &stretch(1.0, 3.0, 0.5, 0.5)),
        "x.toml:7: terrain.stretch[1].from: found 1, allowed: not below the end of the stretch before, 2 m",
    );
    one(
        &stretch(2.0, 2.0, 0.5, 0.5),
        "x.toml:3: terrain.stretch[0].to: found 2, allowed: above from, 2 m",
    );
    one(
        &stretch(1.0, 2.0, 0.5, 0.6),
        "x.toml:5: terrain.stretch[0].mu_d: found 0.6, allowed: not above mu_s, 0.5",
    );
    assert!(lines("[[terrain.stretch]]\nfrom = 1")[0].contains("terrain.stretch[0].to: missing"));
}

#[test]
fn parts_of_the_ground() {
    let parts = |parts: &str| format!("[terrain]\nkind = 'parts'\n{parts}");
    let part = |keys: &str| format!("[[terrain.part]]\n{keys}\n");
    one(
        &parts(&(part("kind = 'step'\nstart = 2") + &part("kind = 'step'\nstart = 1"))),
        "x.toml:1: terrain: found [terrain] (a table), \
         allowed: part 1 starts at 1 m, before the end of the part before, 2 m",
    );
    one(
        &parts(&part("kind = 'step'\nrise = 0.1")),
        "x.toml:5: terrain.part[0].rise: found rise, allowed: with kind = \"step\": kind, start, kerb; \
         rise belongs to kind = \"stairs\"",
    );
    for (wrong, path) in [
        ("kind = 'flat'", "kind"),
        ("kind = 'parts'", "kind"),
        ("stretch = 1", "stretch"),
    ] {
        let lines = lines(&parts(&part(wrong)));
        assert!(
            lines[0].starts_with(&format!("x.toml:4: terrain.part[0].{path}: ")),
            "{lines:?}"
        );
    }
    assert!(lines(&parts(""))[0].contains("terrain.part: missing"));
}
