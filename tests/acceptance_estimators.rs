//! Acceptance of `kalman`: its error, the consistency of its covariance, and its error relative to
//! the Cramer-Rao bound of one sample.
//!
//! With `--nocapture` each test prints its table. All runs use the engine direct. Figures are means
//! over ten seeds on the main scene and five elsewhere, and of one seed with ideal sensors, where
//! no error is random.

use crate::seeds::{SeedScores, floor, study};
use crate::support::scene;
use robhaz_run::Observers;
use robhaz_scene::{Grade, Scene};
use robhaz_study::{
    Consistency, CovarianceVerdict, Report, Study, TruthRun, Watch, compute_dataset, ladder,
};
use std::sync::OnceLock;

/// The scores of `kalman` on `smooth` over ten seeds, by drive and case: several tests judge them.
fn on_smooth() -> &'static [Vec<SeedScores>; 2] {
    static SCORES: OnceLock<[Vec<SeedScores>; 2]> = OnceLock::new();
    SCORES.get_or_init(|| DRIVES.map(|(_, drive)| scores("smooth", &[], drive, 10, |_| true)))
}

const SEEDS: [u64; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];
const DRIVES: [(&str, &[&str]); 2] = [("PI", &[]), ("soft", &["drive.kp=2", "drive.ki=0"])];

/// Sensor and model errors of increasing size, and the level of each: the NRMSE of N allowed on
/// `smooth`, %, with PI and low-gain drive.
const CASES: [(&str, &[&str], [f64; 2]); 6] = [
    // Errors of the method itself: the penetration's slope along the ground, the lag of the
    // observer.
    ("ideal", &["sensors.grade=ideal"], [0.5, 0.12]),
    // An independent implementation reaches 1.96 and 1.3 %.
    ("typical", &["sensors.grade=typical"], [2.0, 1.4]),
    // Gear friction that the nominal robot lacks must be estimated. The independent implementation:
    // 4.5 and 3.4 % without an estimate of the friction, 2.2 and 1.4 % with one.
    (
        "friction in the reading",
        &["sensors.grade=typical", "sensors.torque_friction=0.5"],
        [2.2, 1.5],
    ),
    // Friction in the plant gives the same readings, so the levels are the same.
    (
        "friction in the plant",
        &["sensors.grade=typical", "drive.gear_friction=0.5"],
        [2.2, 1.5],
    ),
    // No estimator estimates masses: an error of 10 % in the link masses is 2 % of N. The
    // independent implementation reaches 3.2 and 2.7 %.
    (
        "+ CAD errors",
        &[
            "sensors.grade=typical",
            "sensors.torque_friction=0.5",
            "model_error.body_cg='10 mm'",
            "model_error.link_masses=0.1",
            "model_error.pins='2 mm'",
        ],
        [3.2, 2.7],
    ),
    // No level was specified: a third above the measured 2.2 and 1.8 %.
    ("poor", &["sensors.grade=poor"], [2.9, 2.4]),
];

fn with_kalman(name: &str, overrides: &[&[&str]]) -> Scene {
    let best = ["engine.kind=direct", "estimator=[{name='kalman'}]"];
    scene(name, &[&best, overrides.concat().as_slice()].concat())
}

/// The first `seeds` seeds, or one if no error is random.
fn seeds_of(scene: &Scene, seeds: usize) -> &'static [u64] {
    let random = scene.sensors.spec != Grade::Ideal.sensors();
    &SEEDS[..if random { seeds } else { 1 }]
}

/// The scores of the scene's first estimator.
fn measure(scene: &Scene, truth: &TruthRun, seeds: usize) -> SeedScores {
    let summaries = study(scene, truth, seeds_of(scene, seeds)).unwrap();
    summaries.into_iter().next().unwrap()
}

/// Prints one row of the table. Returns the NRMSE of N, %, and the consistency, both over the
/// samples without two contacts.
///
/// On rolling ground no wheel has two contacts. At corners the impacts, kilonewtons for less than a
/// millisecond, make nearly all of the error at two contacts: whether a sample contains a peak
/// decides on it, not the estimator.
fn print_row(what: &str, scores: &SeedScores, level: f64) -> (f64, Consistency) {
    let judged = scores.at_one_contact();
    let (nrmse, stated) = (judged.nrmse().unwrap(), judged.stated().unwrap());
    let consistency = judged.consistency().unwrap();
    println!(
        "{what:42} N {:.3} +- {:.3} % (level {level:.2}; with two contacts {:.2} %)  T {:.2} N  stated {:.3} %  coverage {:.1} %  NEES {:.2}  NIS {:.2}  {}",
        100.0 * nrmse.mean,
        100.0 * nrmse.standard_error.unwrap_or(0.0),
        100.0 * scores.nrmse().unwrap().mean,
        judged.traction_rmse().unwrap().mean,
        100.0 * stated.mean,
        100.0 * consistency.coverage.mean,
        consistency.nees.mean,
        consistency.nis.unwrap().mean,
        consistency.verdict().name(),
    );
    (100.0 * nrmse.mean, consistency)
}

/// Asserts that the covariance of `kalman` holds: NEES and NIS are not above the 95 % bounds of
/// chi-squared, the NEES is at least 0.5 (the stated sigma is at most 2.5 times too large: it
/// covers harder and softer wheels than the simulated ones, and a rolling resistance, which these
/// have not), and the coverage is at least 85 %. It should be 95.4 %, but errors are correlated
/// over a run, so that a few runs give it to several percent only.
fn assert_consistent(what: &str, case: &str, consistency: &Consistency) {
    let coverage = consistency.coverage.mean;
    assert!(coverage >= 0.85, "{what}: {coverage}");
    if case == "ideal" {
        // No error is random, so there is no verdict. The errors of the method must lie within the
        // stated covariance.
        let nees = consistency.nees.mean;
        assert_eq!(consistency.verdict(), CovarianceVerdict::NotJudged);
        assert!(nees <= Consistency::COMPONENTS, "{what}: NEES {nees}");
        return;
    }
    let holds = |verdict| {
        matches!(
            verdict,
            CovarianceVerdict::Consistent | CovarianceVerdict::Cautious
        )
    };
    let (nees, nis) = (&consistency.nees, &consistency.nis);
    assert!(holds(consistency.verdict()), "{what}: {nees:?}");
    assert!(nees.mean >= 0.5, "{what}: {nees:?}");
    let parity = consistency.parity_verdict();
    assert!(parity.is_some_and(holds), "{what}: {nis:?}");
}

/// The scores of the included cases with a drive. All sensors read one truth, except where a case
/// changes the drive.
fn scores(
    name: &str,
    overrides: &[&str],
    drive: &[&str],
    seeds: usize,
    included: impl Fn(&str) -> bool,
) -> Vec<SeedScores> {
    let alike = TruthRun::of(&with_kalman(name, &[overrides, drive])).unwrap();
    let cases = CASES.iter().filter(|(case, ..)| included(case));
    let of = |(_, keys, _): &(&str, &[&str], [f64; 2])| {
        let scene = with_kalman(name, &[overrides, drive, keys]);
        let truth = match keys.iter().any(|key| key.starts_with("drive.")) {
            true => TruthRun::of(&scene).unwrap(),
            false => alike.clone(),
        };
        measure(&scene, &truth, seeds)
    };
    cases.map(of).collect()
}

/// Asserts that `kalman` stays within `factor` times the levels of the included cases, with a
/// consistent covariance.
fn assert_levels(
    what: &str,
    scores: [&[SeedScores]; 2],
    factor: f64,
    included: impl Fn(usize, &str) -> bool,
) {
    for (d, (drive, _)) in DRIVES.into_iter().enumerate() {
        let cases: Vec<_> = CASES
            .iter()
            .filter(|(case, ..)| included(d, case))
            .collect();
        assert_eq!(cases.len(), scores[d].len());
        for ((case, _, levels), scores) in cases.into_iter().zip(scores[d]) {
            let what = format!("{what} {drive} {case}");
            let level = factor * levels[d];
            let (nrmse, consistency) = print_row(&what, scores, level);
            assert!(nrmse <= level, "{what}: {nrmse} % above {level} %");
            assert_consistent(&what, case, &consistency);
        }
    }
}

/// The same over five seeds elsewhere, the fewest that give a verdict on the covariance: within 1.3
/// times the levels.
fn assert_levels_elsewhere(
    name: &str,
    overrides: &[&str],
    included: impl Fn(usize, &str) -> bool + Copy,
) {
    let of = |d: usize| scores(name, overrides, DRIVES[d].1, 5, |case| included(d, case));
    let (pi, soft) = (of(0), of(1));
    let what = format!("{name} {}", overrides.join(" "));
    assert_levels(&what, [&pi, &soft], 1.3, included);
}

/// Acceptance on the main scene: every case is within its level, with a consistent covariance.
#[test]
fn kalman_meets_its_levels_on_smooth_ground() {
    let [pi, soft] = on_smooth();
    assert_levels("smooth", [pi, soft], 1.0, |_, _| true);
}

/// With model errors and the low-gain drive, where the error is close to its level, the model
/// errors dominate: alone, with ideal sensors, they cost 2.0 % over these seeds. Together with
/// sensors and friction, the error is at most 1.3 times the root of the sum of squares of both
/// alone. The factor allows for sensor errors that model errors make harder to estimate, and for
/// the work of the torques: it shows a part of the error of the masses (2.4 % without it) where the
/// sensors are ideal, and hardly any where they are not.
#[test]
fn model_errors_dominate_the_error_that_is_left() {
    let truth = TruthRun::of(&with_kalman("smooth", &[DRIVES[1].1])).unwrap();
    let [_, _, _, _, (_, keys, _), _] = CASES;
    let scene = with_kalman("smooth", &[DRIVES[1].1, &keys[2..]]);
    let alone = study(&scene, &truth, &SEEDS).unwrap();
    let [_, _, friction, _, all, _] = on_smooth()[1].as_slice() else {
        panic!("six cases")
    };
    let error = |scores: &SeedScores| 100.0 * scores.nrmse().unwrap().mean;
    let (model, friction, all) = (error(&alone[0]), error(friction), error(all));
    println!(
        "model errors alone {model:.3} %, sensors and friction alone {friction:.3} %, both {all:.3} %"
    );
    assert!(model > 1.5, "{model}");
    assert!(all <= 1.3 * model.hypot(friction), "{all}");
}

/// Acceptance: one tuning serves all scenes. On other terrain and with geometry B, `kalman` is within
/// 1.3 times the levels. Every case has both drives, and every ground two cases in turn.
#[test]
fn kalman_meets_its_levels_on_other_terrain_and_geometry() {
    let grounds: [(&str, &[&str]); 5] = [
        ("cosbump", &[]),
        ("sine", &[]),
        ("flat", &[]),
        ("rough", &[]),
        ("smooth", &["robot.geometry=B"]),
    ];
    // Friction as on `smooth`, where the one in the plant and the one in the reading are
    // equivalent, is part of the CAD errors.
    let cases = ["ideal", "typical", "+ CAD errors", "poor"];
    for (ground, (name, overrides)) in grounds.into_iter().enumerate() {
        assert_levels_elsewhere(name, overrides, |drive, case| {
            let place = cases.iter().position(|c| *c == case);
            place.is_some_and(|place| (ground + 2 * drive + place).is_multiple_of(4))
        });
    }
}

/// Acceptance: one tuning serves all speeds. At 0.3 m/s, where the wheels of the PI drive slide for
/// part of the way, at 0.1 and at 0.05 m/s, where contact angles that err by degrees must not count for the speed,
/// `kalman` is within 1.3 times the levels, with a consistent covariance.
#[test]
fn kalman_meets_its_levels_at_other_speeds() {
    let speeds = [
        ("drive.speed=0.3", ["typical", "poor"]),
        // The slower, the less viscous damping beside the friction of the gears.
        ("drive.speed=0.1", ["friction in the reading", "poor"]),
        ("drive.speed=0.05", ["typical", "poor"]),
    ];
    for (speed, cases) in speeds {
        assert_levels_elsewhere("smooth", &[speed], |_, case| cases.contains(&case));
    }
}

/// Acceptance on the ramp, whose concave corner causes impacts: within 1.3 times the levels, and
/// its covariance holds. Friction is part of the CAD errors.
#[test]
fn kalman_meets_its_levels_on_the_ramp() {
    assert_levels_elsewhere("ramp", &[], |_, case| !case.starts_with("friction"));
}

/// At corners the errors of `kalman` are several percent, more than on rolling ground, but the
/// coverage stays above 90 %. A wheel that touches riser and tread for seconds does not roll along
/// the contact angle that is given to the estimator.
#[test]
fn at_corners_errors_are_larger_but_mostly_covered() {
    for (drive, drive_keys) in DRIVES {
        // A third above the greatest measured errors, 3.2, 3.2 and 8.4 %.
        for (name, most) in [("step", 4.2), ("ditch", 4.2), ("stairs", 11.0)] {
            // On the stairs this robot is stuck, with a wheel on two contacts for seconds.
            let keys = ["sensors.grade=typical", "robot.geometry=A"];
            let scene = with_kalman(name, &[drive_keys, &keys]);
            // Measured: 93 to 98 %; without unmodelled loads and down-weighting 41 to 90 %.
            is_covered(&scene, &format!("{name} {drive} typical"), most);
        }
    }
}

/// The tuning does not depend on one friction law: with a tenth and with twice the default's creep,
/// the error of `kalman` is less than twice as large, and the coverage is at least 90 %.
#[test]
fn creep_other_than_the_defaults_is_tolerated() {
    // Less than twice the 0.83 and 0.61 % of the default's creep.
    for ((drive, drive_keys), most) in DRIVES.into_iter().zip([1.65, 1.2]) {
        for v_s in ["contact.v_s=0.002", "contact.v_s=0.04"] {
            let scene = with_kalman("smooth", &[drive_keys, &["sensors.grade=typical", v_s]]);
            is_covered(&scene, &format!("smooth {drive} typical {v_s}"), most);
        }
    }
}

/// The error over five seeds is at most so many percent, and the coverage at least 90 %.
fn is_covered(scene: &Scene, what: &str, most: f64) {
    let truth = TruthRun::of(scene).unwrap();
    let (nrmse, consistency) = print_row(what, &measure(scene, &truth, 5), most);
    assert!(nrmse <= most, "{what}: {nrmse} %");
    let coverage = consistency.coverage.mean;
    assert!(coverage >= 0.9, "{what}: {coverage}");
}

/// A robot that stands for 20 s has no information on the friction of gears that do not turn. The
/// estimate of the friction stays zero and its standard deviation that of the prior, except for the
/// first milliseconds, before the speeds are known.
#[test]
fn gear_friction_is_not_estimated_at_standstill() {
    for name in ["flat", "smooth"] {
        let scene = with_kalman(name, &[&["sensors.grade=typical", "drive.start_time=60"]]);
        let truth = TruthRun::of(&scene).unwrap();
        for seed in &SEEDS[..5] {
            let scene = Scene {
                seed: *seed,
                ..scene.clone()
            };
            let mut observers = Observers::new(&scene).unwrap();
            let mut last = None;
            for sample in truth.samples() {
                last = observers.observe(sample).1[0].as_ref().ok().copied();
            }
            let (found, sigma) = last.unwrap().kalman.unwrap().reading_errors.gear_friction;
            let prior = scene.noise_budget().unwrap().gear_friction;
            assert!(sigma > 0.99 * prior, "{name}, seed {seed}: {sigma}");
            assert!(found.abs() < 0.01, "{name}, seed {seed}: {found} ± {sigma}");
        }
    }
}

/// Reference: with errors of T of 1 N and of contact angles of 2 deg, an independent implementation
/// gives a Cramer-Rao bound of 1.9 % for the PI drive and 1.3 % for the low-gain drive. Both agree
/// to the stated digits.
#[test]
fn the_cramer_rao_bound_is_that_of_the_independent_implementation() {
    for ((drive, drive_keys), expected) in DRIVES.into_iter().zip([0.019, 0.013]) {
        // 0.1 N m on a radius of 0.1 m.
        let errors = [
            "sensors.torque_noise=0.1",
            "sensors.contact_angle_error='2 deg'",
        ];
        let scene = with_kalman("smooth", &[drive_keys, &errors]);
        let truth = TruthRun::of(&scene).unwrap();
        let found = floor(&scene, &truth).unwrap();
        println!("{drive}: bound {:.3} %", 100.0 * found);
        assert!((found - expected).abs() <= 0.0005, "{drive}: {found}");
    }
}

/// `whitening` uses one sample, except that its observer averages the white noise of the torque:
/// its error is within 1.2 times the Cramer-Rao bound of one sample, and not below the bound
/// without that noise. `kalman` estimates offsets and angle errors over time: its error is below half
/// of the bound.
#[test]
fn whitening_reaches_the_bound_of_one_sample_and_kalman_beats_it() {
    for (d, (drive, drive_keys)) in DRIVES.into_iter().enumerate() {
        let mut scene = with_kalman("smooth", &[drive_keys, &["sensors.grade=typical"]]);
        let of = |name: &str| {
            ladder()
                .unwrap()
                .into_iter()
                .find(|e| e.name == name)
                .unwrap()
        };
        scene.estimators = vec![of("whitening")];
        let truth = TruthRun::of(&scene).unwrap();
        let all = floor(&scene, &truth).unwrap();
        let mut averaged = scene.clone();
        averaged.sensors.spec.torque_noise = 0.0;
        let noiseless = floor(&averaged, &truth).unwrap();
        let summaries = study(&scene, &truth, &SEEDS).unwrap();
        // The case of typical sensors.
        let [whitening, best] = [&summaries[0], &on_smooth()[d][1]].map(|s| s.nrmse().unwrap());
        println!(
            "{drive}: bound {:.3} %, without white noise {:.3} %; whitening {:.3} %, kalman {:.3} %",
            100.0 * all,
            100.0 * noiseless,
            100.0 * whitening.mean,
            100.0 * best.mean
        );
        assert!(whitening.mean <= 1.2 * all);
        // The mean of ten seeds is uncertain: two standard errors.
        let upper = whitening.mean + 2.0 * whitening.standard_error.unwrap();
        assert!(upper >= noiseless, "{upper} {noiseless}");
        assert!(best.mean <= 1.2 * all);
        assert!(best.mean <= 0.5 * all, "{} {all}", best.mean);
    }
}

/// Ablation: with typical sensors, every step of the ladder reduces the error or increases it by at
/// most 2 % (the benefit of a step can depend on a later one), and `kalman` errs by less than a tenth
/// of `paper-wheels`. Without contact angles the parity residual reduces the error, too, below that
/// of every ablation step that is given them but corrects nothing over time.
#[test]
fn every_step_of_the_ladder_carries() {
    let mut scene = with_kalman("smooth", &[&["sensors.grade=typical"]]);
    scene.estimators = ladder().unwrap();
    let truth = TruthRun::of(&scene).unwrap();
    let summaries = study(&scene, &truth, &SEEDS[..5]).unwrap();
    let errors: Vec<f64> = summaries.iter().map(|s| s.nrmse().unwrap().mean).collect();
    let place = |name: &str| summaries.iter().position(|s| s.name == name).unwrap();
    let (best, whitening) = (place("rolling"), place("whitening"));
    for (k, scores) in summaries.iter().enumerate() {
        println!("{:14} {:.3} %", scores.name, 100.0 * errors[k]);
        let follows = k > 0 && k != place("unknown-angles");
        if follows {
            let pair = [errors[k - 1], errors[k]];
            assert!(pair[1] <= 1.02 * pair[0], "{}: {pair:?}", scores.name);
        }
    }
    assert!(10.0 * errors[best] < errors[1], "{errors:?}");
    assert!(
        errors[place("kalman-no-angles")] < errors[whitening],
        "{errors:?}"
    );
}

/// Determinism and equivalence: on one thread and on three a study gives the bits of the plain loop
/// over seeds and samples.
#[test]
fn a_study_does_not_depend_on_threads() {
    let short = [
        "record.duration=2.5",
        "sensors.grade=poor",
        "record.rate=200",
        "sensors.rate=200",
    ];
    let scene = with_kalman("smooth", &[&short]);
    let study_of = |jobs| {
        let study = Study::of_scene(&scene, 7, true).unwrap();
        let data = compute_dataset(&study, jobs, &Watch::SILENT).unwrap();
        Report::of(&study, &data).unwrap()
    };
    let report = study_of(1);
    assert!(report == study_of(3));
    let truth = TruthRun::of(&scene).unwrap();
    let scene = Scene {
        estimators: ladder().unwrap(),
        ..scene
    };
    assert_eq!(report.floor, floor(&scene, &truth));
    let plain = study(&scene, &truth, &SEEDS[..7]).unwrap();
    assert_eq!(plain.len(), report.estimators.len());
    for (line, scores) in report.estimators.iter().zip(&plain) {
        assert_eq!(line.name, scores.name);
        assert_eq!(line.nrmse, scores.nrmse());
        assert_eq!(line.nrmse_at_one_contact, scores.at_one_contact().nrmse());
        assert_eq!(line.traction_rmse_n, scores.traction_rmse());
        assert_eq!(line.stated, scores.stated());
        assert_eq!(line.error_over_stated, scores.normalised());
        assert_eq!(line.consistency, scores.consistency());
        assert_eq!(line.missing, scores.missing());
    }
}
