//! `--set key=value`: precedence, reachable keys, and error messages.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_estimator::{EstimatorSettings, Masses, Method};
use robhaz_model::{Geometry, MassSet};
use robhaz_scene::{FileError, Grade, ModelError, Scene, SensorChoice, SensorSpec};
use robhaz_sim::friction::{FrictionKind, FrictionLaw};
use robhaz_terrain::Profile;
use std::path::Path;

fn parse(text: &str, overrides: &[&str]) -> Result<Scene, FileError> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Scene::parse(text, "x.toml", Path::new(""), &overrides)
}

fn good(text: &str, overrides: &[&str]) -> Scene {
    parse(text, overrides).unwrap_or_else(|e| panic!("{e}"))
}

/// The overrides have this one problem.
#[track_caller]
fn one(text: &str, overrides: &[&str], expected: &str) {
    let error = parse(text, overrides).unwrap_err();
    let lines: Vec<_> = error.problems.iter().map(ToString::to_string).collect();
    assert_eq!(lines, [expected]);
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-15
}

#[test]
fn overrides_win_over_the_file_and_the_last_one_wins() {
    let text = "[drive]\nspeed = 0.1\nkp = 3";
    let scene = good(text, &["drive.speed=30 cm/s", "drive.ki = 0", "seed=7"]);
    assert!(
        close(scene.drive.speed, 0.3) && close(scene.drive.kp, 3.0) && close(scene.drive.ki, 0.0)
    );
    assert_eq!(scene.seed, 7);
    let scene = good(text, &["drive.speed=0.3", "drive.speed=\"0.4 m/s\""]);
    assert!(close(scene.drive.speed, 0.4));
    let scene = good(text, &["drive={speed=0.5}", "contact.damping_ramp=0"]);
    assert!(close(scene.drive.speed, 0.5) && close(scene.drive.kp, 5.0));
    assert!(close(scene.contact.damping_ramp, 0.0));
    assert_eq!(good("", &["name=fast"]).name, "fast");
}

#[test]
fn estimators_are_reached_by_index_written_or_not() {
    let scene = good(
        "",
        &["estimator.0.observer_pole=30", "estimator[2].label=mine"],
    );
    let pole = |scene: &Scene| match scene.estimators[0].settings.method {
        Method::Paper(method) => method.observer_pole,
        Method::Kalman(_) => f64::NAN,
    };
    assert!(close(pole(&scene), 30.0));
    assert_eq!(scene.estimators[2].name, "mine");
    assert_eq!(scene.estimators.len(), 5);
    let text = "[[estimator]]\nname = 'true-mass'";
    let scene = good(text, &["estimator.0.observer_pole=30 rad/s"]);
    assert_eq!(scene.estimators.len(), 1);
    assert_eq!(scene.estimators[0].settings.masses, Masses::True);
    let scene = good(text, &["estimator=[{name='paper-body'}]"]);
    assert_eq!(
        scene.estimators[0].settings,
        EstimatorSettings::paper_body()
    );
    assert_eq!(good(text, &["estimator=[]"]).estimators, []);
    one(
        text,
        &["estimator.1.observer_pole=30"],
        "--set estimator.1.observer_pole=30: estimator: found index 1, allowed: 0 to 0 (estimator has 1)",
    );
}

#[test]
fn robots_are_changed_in_whole_and_in_part() {
    let scene = good("", &["robot.mass=text", "robot.geometry=B"]);
    assert_eq!(scene.robot.robot.mass, MassSet::text());
    assert_eq!(scene.robot.mass_name, "text");
    assert_eq!(scene.robot.robot.geometry.pins, Geometry::b().pins);

    let scene = good(
        "robot.mass = 'text'",
        &[
            "robot.mass.body=6",
            "robot.geometry.pins.q=[-0.06, 0.14]",
            "robot.geometry.body_cg.0=4 cm",
        ],
    );
    let expected = MassSet {
        body: 6.0,
        ..MassSet::text()
    };
    assert_eq!(scene.robot.robot.mass, expected);
    assert_eq!(scene.robot.mass_name, "text, changed");
    assert_eq!(scene.robot.geometry_name, "A, changed");
    let geometry = &scene.robot.robot.geometry;
    assert!(close(geometry.pins.q.x, -0.06) && close(geometry.body_cg.x, 0.04));
    // Without link_cg the rule goes with the pins.
    assert_ne!(geometry.link_cg, Geometry::a().link_cg);
}

/// With another kind on the command line the file's keys of its own kind are ignored; keys of the
/// command line must fit.
#[test]
fn another_kind_of_terrain_drops_the_keys_of_the_old_one() {
    let text = "[terrain]\nkind = 'cosbump'\nheight = 0.03\nhalf_width = 0.2";
    assert_eq!(
        good(text, &["terrain.kind=flat"]).terrain.profile,
        Profile::Flat
    );
    assert_eq!(
        good(text, &["terrain.kind=smooth"]).terrain.profile,
        Profile::smooth()
    );
    let scene = good(text, &["terrain.kind=cosbump", "terrain.height='40 mm'"]);
    let Profile::CosBump(bump) = scene.terrain.profile else {
        panic!("{:?}", scene.terrain);
    };
    assert!(close(bump.height, 0.04) && close(bump.half_width, 0.2));
    let bumps = "terrain.bumps=[{height = 0.05, centre = 1, width = '20 cm'}]";
    assert_eq!(
        good(text, &["terrain.kind=bumps", bumps]).terrain.kind,
        "bumps"
    );
    one(
        text,
        &["terrain.kind=flat", "terrain.height=0.1"],
        "--set terrain.height=0.1: terrain.height: found terrain.height, allowed: with kind = \"flat\": kind, stretch; \
         height belongs to kind = \"cosbump\"",
    );
    // A key that no kind has is still unknown.
    assert!(parse("[terrain]\nhigh = 3", &["terrain.kind=flat"]).is_err());
}

#[test]
fn errors_name_the_override() {
    one(
        "",
        &["drive.kp=abc"],
        "--set drive.kp=abc: drive.kp: found abc, allowed: a number of at least 0 and at most 1e6, in N m s, \
         or a text with a unit (N m s, mN m s)",
    );
    one(
        "drive.kp = 3",
        &["drive.kq=3"],
        "--set drive.kq=3: drive.kq: unknown key, allowed: speed, kp, ki, torque_limit, tracking_time, \
         viscous_damping, gear_friction, start_time, ramp_time, kind, estimator, friction_test, scaling; did you mean kp?",
    );
    one(
        "record.compare_from = 1.5",
        &["record.duration=1"],
        "--set record.duration=1: record.duration: found record.compare_from = 1.5 and record.duration = 1, \
         allowed: record.compare_from below record.duration",
    );
    one(
        "drive.kp = 3",
        &["drive.kp.x=3"],
        "--set drive.kp.x=3: drive.kp: found the key x under what is a whole number, \
         allowed: keys of tables and indices of arrays",
    );
}

#[test]
fn malformed_overrides() {
    for bad in [
        "",
        "drive.kp",
        "=3",
        "drive..kp=3",
        "drive kp=3",
        "drive.kp[=3",
        ".=3",
    ] {
        one(
            "",
            &[bad],
            &format!(
                "--set {bad}: not an override, allowed: key=value with a dotted key, such as drive.kp=2 or \
                 estimator.0.observer_pole=30"
            ),
        );
    }
    for (key, parts) in [
        ("a.".repeat(60_000) + "a", 60_001),
        ("a".to_owned() + &"[0]".repeat(32), 33),
    ] {
        let expected = format!("--set {key}=1: found a key of {parts} parts, allowed: at most 32");
        one("", &[&format!("{key}=1")], &expected);
    }
    for bad in [
        "0=3",
        "drive.0=3",
        "estimator.x=3",
        "estimator.3.name=true-mass",
        "drive.kp=",
        "terrain.kind=",
    ] {
        let error = parse("", &[bad]).unwrap_err();
        assert!(
            error.to_string().starts_with(&format!("--set {bad}: ")),
            "{error}"
        );
    }
}

#[test]
fn problems_of_file_and_overrides_come_together() {
    let error = parse("drive.kp = -1", &["drive.ki=-1", "nonsense"]).unwrap_err();
    let files: Vec<_> = error
        .problems
        .iter()
        .map(|p| (p.file.clone(), p.line))
        .collect();
    assert_eq!(
        files,
        [
            ("x.toml".to_owned(), Some(1)),
            ("--set drive.ki=-1".to_owned(), None),
            ("--set nonsense".to_owned(), None),
        ]
    );
}

/// A rule that the robot's numbers break, though none of its own keys is written.
#[test]
fn a_wheel_too_light_for_the_step_is_refused() {
    let light = ["robot.mass.wheel=0.05", "robot.mass.wheel_inertia=4e-4"];
    let error = parse("", &light).unwrap_err();
    let line = error.to_string();
    assert!(line.contains("engine.step at most 9.75e-5 s"), "{line}");
    let [mass, inertia] = light;
    good("", &[mass, inertia, "engine.step=9.7e-5"]);
    good("", &[mass, inertia, "engine.kind=direct"]);
    // The implicit engine takes every gain.
    good(
        "engine.kind = 'direct'",
        &["drive.kp=1e6", "drive.ki=1e6", "drive.viscous_damping=1e3"],
    );
    // Stiff friction for which the engine cuts its steps.
    good("", &["contact.v_s=2 mm/s"]);
}

/// A grade sets all errors of the sensors and of the nominal damping; keys override single ones, in
/// any order.
#[test]
fn grades_are_changed_key_by_key() {
    for grade in Grade::ALL {
        let scene = good("", &[&format!("sensors.grade={}", grade.name())]);
        assert_eq!(scene.sensors, SensorChoice::of(grade));
        assert_eq!(scene.model_error, ModelError::of_grade(grade));
    }
    let text = "[sensors]\ntorque_noise = 0.5\ngrade = 'poor'\nrate_bias = '2 deg/s'\n[model_error]\npins = '2 mm'";
    let scene = good(text, &["sensors.jitter=0", "drive.gear_friction=0.5"]);
    let expected = SensorSpec {
        torque_noise: 0.5,
        rate_bias: 2.0_f64.to_radians(),
        jitter: 0.0,
        ..Grade::Poor.sensors()
    };
    assert_eq!(scene.sensors.spec, expected);
    let expected = ModelError {
        pins: 0.002,
        ..ModelError::of_grade(Grade::Poor)
    };
    assert_eq!(scene.model_error, expected);
    assert!(close(scene.drive.gear_friction, 0.5));
}

/// With a grade on the command line the file's errors are ignored, so that a resolved scene can be
/// run with other sensors; keys outside the grade stay.
#[test]
fn another_grade_drops_the_errors_of_the_old_one() {
    let text = "[sensors]\ngrade = 'typical'\ntorque_noise = 0.5\nrate = 2000\n[model_error]\npins = 0.002\nviscous_damping = 0.3";
    let scene = good(text, &["sensors.rate_noise=1", "sensors.grade=poor"]);
    let expected = SensorSpec {
        rate_noise: 1.0,
        ..Grade::Poor.sensors()
    };
    assert_eq!(scene.sensors.spec, expected);
    assert!(close(scene.sensors.rate, 2000.0));
    let expected = ModelError {
        pins: 0.002,
        ..ModelError::of_grade(Grade::Poor)
    };
    assert_eq!(scene.model_error, expected);

    let resolved = good("", &["sensors.grade=poor"]).to_toml("x");
    assert_eq!(good(&resolved, &["sensors.grade=ideal"]), good("", &[]));
}

/// With a friction law on the command line the file's keys of its own law are ignored, so that a
/// resolved scene can be run with another law; coefficients and v_d stay.
#[test]
fn another_law_drops_the_keys_of_the_old_one() {
    let text = "engine.kind = 'direct'\n[contact]\nfriction = 'brush'\nslip_stiffness = 5\nmu_s = 0.6\nmu_d = 0.5";
    let file = good(text, &[]).friction;
    assert_eq!(file.kind, FrictionKind::Brush);
    assert!(close(file.slip_stiffness, 5.0) && close(file.v_s, 0.02));
    let resolved = good(text, &[]).to_toml("x");
    for text in [text, resolved.as_str()] {
        let rigid = good(text, &["contact.friction=rigid"]).friction;
        let expected = FrictionLaw {
            mu_s: 0.6,
            mu_d: 0.5,
            ..FrictionLaw::of(FrictionKind::Rigid)
        };
        assert_eq!(rigid, expected);
        let sets = ["contact.friction=rigid", "contact.v_s=0.2 mm/s"];
        let softer = good(
            text,
            &["contact.friction=brush", "contact.slip_stiffness=50"],
        );
        assert!(close(good(text, &sets).friction.v_s, 2e-4));
        assert!(close(softer.friction.slip_stiffness, 50.0));
    }
}

/// A resolved scene, which has all keys of its law, takes every other law.
#[test]
fn every_law_can_be_chosen_for_a_resolved_scene() {
    for file in FrictionKind::ALL {
        let text = format!(
            "engine.kind = 'direct'\ncontact.friction = '{}'",
            file.name()
        );
        // Keys of the law alone have other values than the defaults.
        let own = match file {
            FrictionKind::Adams => "contact.v_s=0.03",
            FrictionKind::Brush => "contact.slip_stiffness=7",
            FrictionKind::Rigid => "contact.v_s=0.0005",
        };
        let resolved = good(&text, &[own]).to_toml("x");
        for chosen in FrictionKind::ALL {
            let set = format!("contact.friction={}", chosen.name());
            assert_eq!(good(&resolved, &[&set]).friction.kind, chosen);
        }
    }
}

/// Scalings are changed and added like the items of every list.
#[test]
fn scalings_are_changed_by_index() {
    let text = "[[drive.scaling]]\nwheels = [1, 3]\nfrom = 6\nto = 16\nfactor = 1.5";
    let sets = ["drive.scaling.0.factor=-1", "drive.scaling[0].to='9000 ms'"];
    let scaling = good(text, &sets).drive.scalings[0];
    assert_eq!(scaling.wheels, [true, false, true]);
    assert!(close(scaling.factor, -1.0) && close(scaling.to, 9.0) && close(scaling.from, 6.0));
    let whole = "drive.scaling=[{wheels=[2],from=1,to=2,factor=0}]";
    assert_eq!(good("", &[whole]).drive.scalings.len(), 1);
}
