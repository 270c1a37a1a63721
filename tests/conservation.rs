//! Properties of the simulated forces that need no reference run: static loads, momentum, energy,
//! bounds, determinism.

use crate::support::{keep, scene, truth_of};
use robhaz_run::verify::{Run, agreement, energy, impulse_difference, momentum_error, verify};
use std::sync::OnceLock;

const ENGINES: [&str; 2] = ["engine.kind=rapier", "engine.kind=direct"];
/// Scenes on smooth ground and at corners.
const GROUNDS: [&str; 2] = ["smooth", "ditch"];

/// The whole runs of a scene of [`GROUNDS`] on both engines: several tests judge them.
fn whole_runs(ground: usize) -> &'static [Run; 2] {
    static RUNS: [OnceLock<[Run; 2]>; 2] = [const { OnceLock::new() }; 2];
    let run = |engine| Run::of(&scene(GROUNDS[ground], &[engine])).unwrap();
    RUNS[ground].get_or_init(|| ENGINES.map(run))
}

/// Closed form: static loads on level ground (the four-bar's statics by hand), and the penetration
/// of eq. (10) under them.
///
/// From a raw start, at 0.75 s: the slow mode of the contact (0.118 s) has reduced the initial
/// error of at most 2 N by exp(-6).
#[test]
fn static_loads_and_penetrations_on_level_ground() {
    for (geometry, expected) in [("A", [43.58, 48.05, 45.71]), ("B", [46.21, 45.65, 45.48])] {
        for engine in ENGINES {
            let overrides = [
                engine,
                "engine.start=raw",
                &format!("robot.geometry={geometry}"),
                "record.duration=0.75",
                "record.compare_from=0.5",
            ];
            let truth = truth_of(&scene("flat", &overrides)).unwrap();
            for (wheel, expected) in truth[750].wheels.iter().zip(expected) {
                let n = wheel.normal_force;
                assert!((n - expected).abs() < 0.015, "{geometry}, {engine}: {n}");
                let law = robhaz_sim::contact::ContactLaw::default();
                // 0.1 um of penetration is 0.02 N.
                let penetration = law.static_penetration(n);
                assert!((wheel.penetration - penetration).abs() < 1e-7);
            }
        }
    }
}

/// Closed form: a settled start is in equilibrium. N at the first record is the static load, to its
/// stated digits, and stays constant until the drive starts at 0.8 s.
#[test]
fn a_settled_start_stands_still() {
    for (geometry, expected) in [("A", [43.58, 48.05, 45.71]), ("B", [46.21, 45.65, 45.48])] {
        // A step of direct can reach beyond the drive's start; its dense output then has the error
        // of the tolerance.
        for (engine, bound) in ENGINES.into_iter().zip([1e-4, 1e-3]) {
            let overrides = [engine, &format!("robot.geometry={geometry}")];
            let truth = truth_of(&scene("flat", &overrides)).unwrap();
            let mut most = 0.0_f64;
            for (i, expected) in expected.into_iter().enumerate() {
                let first = truth[0].wheels[i].normal_force;
                assert!(
                    (first - expected).abs() < 0.005,
                    "{geometry}, {engine}: {first}"
                );
                for t in &truth[..=800] {
                    most = most.max((t.wheels[i].normal_force - first).abs());
                }
            }
            println!("{geometry}, {engine}: N changes by {most:.1e} N before the drive starts");
            assert!(most < bound, "{geometry}, {engine}: {most}");
        }
    }
}

/// Closed form: after a settled start on a slope the ground carries the weight, friction holds the
/// robot, and N stays constant while the motors hold. The robot creeps, because the friction law
/// has no stiction.
#[test]
fn a_settled_start_on_a_slope_is_in_equilibrium_but_for_creep() {
    let slope = 0.1_f64;
    let points = [[-5.0, -5.0 * slope], [5.0, 5.0 * slope]];
    let points = format!("terrain.points={points:?}");
    for (engine, bound) in ENGINES.into_iter().zip([1e-4, 1e-3]) {
        let overrides = [
            "terrain.kind=heights",
            "terrain.interpolation=corners",
            &points,
            engine,
        ];
        let truth = truth_of(&scene("flat", &overrides)).unwrap();
        let weight = 14.0 * robhaz_model::GRAVITY;
        let angle = slope.atan();
        let sum = |value: fn(&robhaz_sim::WheelTruth) -> f64| -> f64 {
            truth[0].wheels.iter().map(value).sum()
        };
        let (n, t) = (sum(|w| w.normal_force), sum(|w| w.traction));
        println!("{engine}: N {n:.6} N, T {t:.6} N");
        // Rapier's explicit step balances a creeping robot within 1e-6 of its weight.
        assert!((n - weight * angle.cos()).abs() < 1e-4, "{engine}: {n}");
        assert!((t - weight * angle.sin()).abs() < 1e-4, "{engine}: {t}");
        let mut most = 0.0_f64;
        for t in &truth[..=800] {
            for (now, first) in t.wheels.iter().zip(&truth[0].wheels) {
                most = most.max((now.normal_force - first.normal_force).abs());
            }
        }
        println!("{engine}: N changes by {most:.1e} N before the drive starts");
        assert!(most < bound, "{engine}: {most}");
        // T/N = 0.1 over the slope of the friction law at v = 0, 3 mu_s/(2 v_s) = 60 s/m, is a
        // creep of 1.7 mm/s.
        let crept = (truth[800].body.position - truth[0].body.position).norm();
        assert!((crept - 0.8 * 0.1 / 60.0).abs() < 1e-5, "{engine}: {crept}");
    }
}

/// Conservation: the impulse of the ground equals the change of momentum minus the impulse of
/// gravity, over the whole run and over parts of it, on smooth ground and at corners. The engines
/// integrate the impulse of the ground themselves.
#[test]
fn momentum_balances() {
    for (ground, name) in GROUNDS.into_iter().enumerate() {
        let robot = scene(name, &[]).robot.robot;
        for (engine, run) in ENGINES.into_iter().zip(whole_runs(ground)) {
            for (from, to) in [(0, 12_000), (500, 5000), (5000, 12_000)] {
                let error = momentum_error(&robot, &run.truth[from..=to], &run.balance[from..=to]);
                println!("{name}, {engine}, {from} to {to} ms: momentum {error:.1e}");
                // Ten times the measured error of direct; rapier has rounding errors only.
                assert!(error < 1e-7, "{name}, {engine}: {error}");
            }
        }
    }
}

/// Equivalence: on rolling ground the recorded N and T, integrated by the trapezoidal rule, give
/// the impulses that the engines integrate. So the recorded forces are those that act.
#[test]
fn recorded_forces_add_up_to_the_impulses() {
    for (engine, run) in ENGINES.into_iter().zip(whole_runs(0)) {
        let force = |w: &robhaz_sim::WheelTruth| {
            let (sin, cos) = w.contact_angle.sin_cos();
            robhaz_model::Vec2::new(cos, sin) * w.traction
                + robhaz_model::Vec2::new(-sin, cos) * w.normal_force
        };
        for i in 0..3 {
            let sum: robhaz_model::Vec2 = run
                .truth
                .windows(2)
                .map(|pair| {
                    let mean = 0.5 * (force(&pair[0].wheels[i]) + force(&pair[1].wheels[i]));
                    mean * (pair[1].time - pair[0].time)
                })
                .sum();
            let integral = run.balance.last().unwrap().impulse[i];
            let error = (sum - integral).norm() / integral.norm();
            println!("{engine}, wheel {}: {error:.1e}", i + 1);
            // Errors of the trapezoidal rule over records of 1 ms.
            assert!(error < 1e-5, "{engine}, wheel {}: {error}", i + 1);
        }
    }
}

/// Equivalence: the truth has the same bits with and without the integrals.
#[test]
fn balance_changes_no_bit_of_the_truth() {
    for engine in ENGINES {
        let scene = scene("step", &[engine, "record.duration=6"]);
        assert!(
            Run::of(&scene).unwrap().truth == keep(&scene).truth,
            "{engine}"
        );
    }
}

/// Determinism: two runs of the same scene give estimates of the same bits. That the truth repeats
/// on both engines is a check of `verify`, on all shipped scenes.
#[test]
fn runs_repeat_to_the_bit() {
    for name in ["smooth", "stairs"] {
        let scene = scene(name, &["record.duration=5"]);
        let [a, b] = [keep(&scene), keep(&scene)];
        assert!(a.truth == b.truth, "{name}");
        assert!(a.estimates == b.estimates, "{name}");
    }
}

/// Property: N is never negative, T never exceeds mu_s N and all values are finite, on smooth
/// ground and on stairs.
#[test]
fn forces_stay_within_their_laws() {
    let stairs = ENGINES.map(|engine| truth_of(&scene("stairs", &[engine])).unwrap());
    let smooth = whole_runs(0).iter().map(|run| &run.truth);
    for (name, truth) in smooth
        .map(|t| ("smooth", t))
        .chain(stairs.iter().map(|t| ("stairs", t)))
    {
        let mu_s = scene(name, &[]).friction.mu_s;
        for w in truth.iter().flat_map(|t| &t.wheels) {
            for c in w.contact_list.iter() {
                assert!(c.normal_force >= 0.0);
                assert!(c.traction.abs() <= mu_s * c.normal_force + 1e-12);
            }
            assert!(w.penetration.is_finite() && w.contact_angle.is_finite());
        }
    }
}

/// Conservation: the work of the motors equals the losses in gears, friction and contacts plus the
/// change of energy.
#[test]
fn energy_balances() {
    // Ten times the measured errors of rapier, whose step of 0.2 ms is of first order, and of
    // direct.
    let bounds = [[4e-5, 2e-7], [4e-3, 2e-6]];
    for (ground, (name, bounds)) in GROUNDS.into_iter().zip(bounds).enumerate() {
        let robot = scene(name, &[]).robot.robot;
        for ((engine, bound), run) in ENGINES.into_iter().zip(bounds).zip(whole_runs(ground)) {
            let energy = energy(&robot, &run.truth, &run.balance);
            let error = energy.relative_error;
            println!("{name}, {engine}: {energy:.4?}, left {error:.1e}");
            assert!(energy.motors > 10.0);
            assert!(error < bound, "{name}, {engine}: {error}");
        }
    }
}

/// Equivalence and conservation: with gear friction the engines agree as without it, and the
/// balance contains its loss.
#[test]
fn gear_friction_is_in_both_engines_and_in_the_balance() {
    let kept = ENGINES.map(|engine| {
        let overrides = [engine, "drive.gear_friction=0.5", "record.duration=8"];
        let scene = scene("smooth", &overrides);
        let robot = &scene.robot.robot;
        let mut run = Run::of(&scene).unwrap();
        let balance = energy(robot, &run.truth, &run.balance);
        let error = balance.relative_error;
        println!("{engine}: {balance:.4?}, left {error:.1e}");
        // Ten times the measured error of rapier.
        assert!(error < 1e-4, "{engine}: {error}");
        // Without the loss of friction, 0.5 N m at three wheels over 66 rad, the energy must not
        // balance.
        let viscous: f64 = run
            .truth
            .iter()
            .map(|t| {
                t.wheels
                    .iter()
                    .map(|w| 0.15 * w.omega * w.omega)
                    .sum::<f64>()
                    * 1e-3
            })
            .sum();
        run.balance.last_mut().unwrap().gear_loss = viscous;
        assert!(energy(robot, &run.truth, &run.balance).relative_error > 0.1);
        run.truth
    });
    let apart = agreement(&kept[0], &kept[1]);
    println!("{apart:?}");
    // The bounds of `robhaz verify`.
    assert!(apart.normal_force < 1e-3 && apart.apart < 1e-3, "{apart:?}");
}

/// Acceptance: no check of `robhaz verify` fails in the first 6 s of a shipped scene, in which the
/// front wheel passes the first obstacle: laws, balances, repetition, closed loops, and that the
/// engines agree.
#[test]
fn shipped_scenes_verify() {
    for entry in std::fs::read_dir(crate::support::root().join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        let scene = robhaz_scene::Scene::load(&path, &["record.duration=6".to_owned()]).unwrap();
        let verdicts = verify(&scene, &mut |_| (), &|| None).unwrap();
        for verdict in &verdicts {
            assert_ne!(verdict.passed, Some(false), "{}: {verdict:?}", scene.name);
        }
        let passed = verdicts.iter().filter(|v| v.passed == Some(true));
        assert!(passed.count() >= 8, "{}", scene.name);
    }
}

/// Acceptance: a robot at rest, a wheel that lifts and lands, and records of 20 ms pass every
/// check; the truth is correct. At 1 m/s the front wheel leaves the second bump of `smooth`.
#[test]
fn correct_runs_of_any_kind_verify() {
    for (sets, lifts) in [
        (["drive.speed=0", "record.duration=3"].as_slice(), false),
        (&["drive.speed=1", "record.duration=5"], true),
        (
            &[
                "drive.speed=1",
                "record.duration=5",
                "record.rate=50",
                "sensors.rate=50",
            ],
            true,
        ),
    ] {
        let scene = scene("smooth", sets);
        let in_the_air = |t: &robhaz_sim::Truth| t.wheels.iter().any(|w| w.contacts == 0);
        assert_eq!(truth_of(&scene).unwrap().iter().any(in_the_air), lifts);
        let verdicts = verify(&scene, &mut |_| (), &|| None).unwrap();
        for verdict in &verdicts {
            assert_eq!(verdict.passed, Some(true), "{sets:?}: {verdict:?}");
        }
        assert_eq!(verdicts.len(), 19);
    }
}

/// Acceptance: an engine that stops fails one check, with the reason; the other checks judge the
/// run up to the stop.
#[test]
fn a_run_that_stops_is_judged_up_to_there() {
    // The slope is too steep for this robot: it turns over with both engines.
    let scene = scene("ramp", &["terrain.angle=-60 deg"]);
    let verdicts = verify(&scene, &mut |_| (), &|| None).unwrap();
    let of = |check: &str| verdicts.iter().find(|v| v.check == check).unwrap();
    for engine in ["rapier", "direct"] {
        let end = of(&format!("{engine}: runs to its end"));
        assert_eq!(end.passed, Some(false));
        assert!(end.finding.contains("turned over"), "{end:?}");
        for check in ["momentum", "energy", "gap of the pins"] {
            let verdict = of(&format!("{engine}: {check}"));
            assert_eq!(verdict.passed, Some(true), "{verdict:?}");
        }
    }
    assert_eq!(of("the engines").passed, None);
}

/// Sensitivity: the measures detect an error of 0.1 % in one wheel's impulse, one of 1 % in the
/// motors' work, a shift by one millisecond, and NaN.
#[test]
fn wrong_forces_are_detected() {
    let scene = scene("smooth", &["engine.kind=direct", "record.duration=8"]);
    let robot = &scene.robot.robot;
    let Run { truth, balance, .. } = Run::of(&scene).unwrap();
    let momentum = momentum_error(robot, &truth, &balance);
    let energy_left = energy(robot, &truth, &balance).relative_error;
    assert!(
        momentum < 1e-6 && energy_left < 1e-5,
        "{momentum} {energy_left}"
    );

    let mut wrong = balance.clone();
    for b in &mut wrong {
        b.impulse[1] *= 1.001;
    }
    // 0.1 % of the load of one wheel is 0.03 % of the weight.
    assert!(momentum_error(robot, &truth, &wrong) > 1e-4);
    let found = impulse_difference(balance.last().unwrap(), wrong.last().unwrap());
    assert!((found - 1e-3).abs() < 1e-5, "{found}");

    let mut wrong = balance.clone();
    for b in &mut wrong {
        b.motor_work *= 1.01;
    }
    assert!(energy(robot, &truth, &wrong).relative_error > 5e-3);

    // NaN in the middle of the run counts, although the values at its end are correct.
    let mut wrong = balance.clone();
    wrong[4000].ground_work = f64::NAN;
    wrong[4000].impulse[2].x = f64::NAN;
    assert!(energy(robot, &truth, &wrong).relative_error.is_nan());
    assert!(momentum_error(robot, &truth, &wrong).is_nan());

    let late = agreement(&truth[..truth.len() - 1], &truth[1..]);
    assert!(late.normal_force > 1e-4, "{late:?}");
}
