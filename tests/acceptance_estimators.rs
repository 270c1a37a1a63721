//! Acceptance of `best`: how exact it is, whether it knows it, and how that stands to the Cramer-Rao bound of one sample.
//!
//! With `--nocapture` each test prints its table. All on the engine direct, means over ten seeds on the main scene and five elsewhere
//! (ideal sensors: one, nothing is random).

use crate::support::scene;
use robhaz_run::Observers;
use robhaz_scene::{Scene, SensorSpec};
use robhaz_study::{Consistency, CovarianceVerdict, SeedScores, TruthRun, floor, ladder, study};

const SEEDS: [u64; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];
const DRIVES: [(&str, &[&str]); 2] = [("PI", &[]), ("soft", &["drive.kp=2", "drive.ki=0"])];

/// Sensors and drawings that get worse, and the NRMSE of N in % that each must keep to on `smooth`, PI and soft drive.
const CASES: [(&str, &[&str], [f64; 2]); 6] = [
    // What the method itself errs by: slope of the penetration, observer's lag.
    ("ideal", &["sensors.grade=ideal"], [0.5, 0.1]),
    // The independent implementation reaches 1.96 and 1.3 % here.
    ("typical", &["sensors.grade=typical"], [2.0, 1.4]),
    // Friction that nobody told of must be found: not finding it costs it 4.5 and 3.4 %, finding it reaches 2.2 and 1.4 %.
    (
        "friction in the reading",
        &["sensors.grade=typical", "sensors.torque_friction=0.5"],
        [2.2, 1.5],
    ),
    // The same in the plant looks the same to who reads: the same bounds.
    (
        "friction in the plant",
        &["sensors.grade=typical", "drive.gear_friction=0.5"],
        [2.2, 1.5],
    ),
    // No estimator here looks for masses: link masses wrong by 10 % are 2 % of N. The independent one: 3.2 and 2.7 %.
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
    // Nothing was asked of these: a third above the 1.90 and 1.17 % that were measured.
    ("poor", &["sensors.grade=poor"], [2.6, 1.6]),
];

fn with_best(name: &str, overrides: &[&[&str]]) -> Scene {
    let best = ["engine.kind=direct", "estimator=[{name='best'}]"];
    scene(name, &[&best, overrides.concat().as_slice()].concat())
}

/// As many seeds, or one where nothing is random.
fn seeds_of(scene: &Scene, seeds: usize) -> &'static [u64] {
    let random = scene.sensors.spec != SensorSpec::ideal();
    &SEEDS[..if random { seeds } else { 1 }]
}

/// The scores of the scene's first estimator.
fn measure(scene: &Scene, truth: &TruthRun, seeds: usize) -> SeedScores {
    let summaries = study(scene, truth, seeds_of(scene, seeds), &|| ()).unwrap();
    summaries.into_iter().next().unwrap()
}

/// NRMSE of N in %, printed beside its bound and all else.
fn print_row(what: &str, scores: &SeedScores, must: f64) -> (f64, Consistency) {
    let (nrmse, stated) = (scores.nrmse().unwrap(), scores.stated().unwrap());
    let consistency = scores.consistency().unwrap();
    println!(
        "{what:42} N {:.3} +- {:.3} % (must {must:.2})  T {:.2} N  stated {:.3} %  2 sigma hold {:.1} %  NEES {:.2}  NIS {:.2}  {}",
        100.0 * nrmse.mean,
        100.0 * nrmse.standard_error.unwrap_or(0.0),
        scores.traction_rmse().unwrap().mean,
        100.0 * stated.mean,
        100.0 * consistency.coverage.mean,
        consistency.nees.mean,
        consistency.nis.unwrap().mean,
        consistency.verdict().words(),
    );
    (100.0 * nrmse.mean, consistency)
}

/// `best` knows how exact it is: NEES and NIS lie in the 95 % bounds of chi-squared, and a stated two sigma, which should mean 95.4 %,
/// means 90 % at least: over so few runs the share itself is known to some percent only, because a run's errors last.
fn is_honest(what: &str, case: &str, consistency: &Consistency) {
    let hold = consistency.coverage.mean;
    assert!(hold >= 0.9, "{what}: {hold}");
    if case == "ideal" {
        // Nothing is random, so that there is no verdict: the errors are those of the method, and must lie within what is stated.
        let nees = consistency.nees.mean;
        assert_eq!(consistency.verdict(), CovarianceVerdict::NotJudged);
        assert!(nees <= Consistency::COMPONENTS, "{what}: NEES {nees}");
        return;
    }
    assert_eq!(
        consistency.verdict(),
        CovarianceVerdict::Consistent,
        "{what}: {:?}",
        consistency.nees
    );
    assert_eq!(
        consistency.parity_verdict(),
        Some(CovarianceVerdict::Consistent),
        "{what}: {:?}",
        consistency.nis
    );
}

fn meets_the_levels(
    name: &str,
    overrides: &[&str],
    seeds: usize,
    factor: f64,
    judge: impl Fn(&str) -> bool,
) {
    for (d, (drive, drive_keys)) in DRIVES.into_iter().enumerate() {
        for (case, keys, must) in CASES {
            if !judge(case) {
                continue;
            }
            let scene = with_best(name, &[overrides, drive_keys, keys]);
            let truth = TruthRun::of(&scene).unwrap();
            let what = format!("{name} {} {drive} {case}", overrides.join(" "));
            let must = factor * must[d];
            let (nrmse, consistency) = print_row(&what, &measure(&scene, &truth, seeds), must);
            assert!(nrmse <= must, "{what}: {nrmse} % above {must} %");
            is_honest(&what, case, &consistency);
        }
    }
}

/// Acceptance, the main scene: every case within its level, and honest about it.
#[test]
fn best_keeps_to_its_levels_on_smooth_ground() {
    meets_the_levels("smooth", &[], 10, 1.0, |_| true);
}

/// The limit of the last case, where the level is close (soft drive): wrong drawings alone, with ideal sensors, cost 2.4 % over these
/// seeds. Sensors and friction add to it no more than what they cost alone, but for what wrong drawings hide: 1.1 times.
#[test]
fn wrong_drawings_are_most_of_what_is_left() {
    let error = |keys: &[&str]| {
        let scene = with_best("smooth", &[DRIVES[1].1, keys]);
        let truth = TruthRun::of(&scene).unwrap();
        let summaries = study(&scene, &truth, &SEEDS, &|| ()).unwrap();
        100.0 * summaries[0].nrmse().unwrap().mean
    };
    let [_, _, (_, friction, _), _, (_, all, _), _] = CASES;
    let drawings: Vec<&str> = all[2..].to_vec();
    let (drawings, friction, all) = (error(&drawings), error(friction), error(all));
    println!(
        "drawings alone {drawings:.3} %, sensors and friction alone {friction:.3} %, both {all:.3} %"
    );
    assert!(drawings > 2.0, "{drawings}");
    assert!(all <= 1.1 * drawings.hypot(friction), "{all}");
}

/// Acceptance: one tuning for all. Other courses and the other robot within 1.3 times the levels.
#[test]
fn best_keeps_to_its_levels_elsewhere() {
    // Friction in the plant is friction in the reading, as `smooth` shows for both drives.
    let judge = |case: &str| case != "friction in the plant";
    for name in ["cosbump", "sine", "flat", "rough"] {
        meets_the_levels(name, &[], 5, 1.3, judge);
    }
    meets_the_levels("smooth", &["robot.geometry=B"], 5, 1.3, judge);
}

/// Acceptance: nor a tuning for one speed. Half as fast again, where the wheels of the PI drive slide for part of the way, within 1.3 times
/// the levels and as honest.
#[test]
fn best_keeps_to_its_levels_at_other_speeds() {
    let judge = |case: &str| ["typical", "friction in the reading", "poor"].contains(&case);
    meets_the_levels("smooth", &["drive.speed=0.3"], 5, 1.3, judge);
    meets_the_levels("smooth", &["drive.speed=0.1"], 5, 1.3, judge);
}

/// Acceptance on the ramp, whose concave corner hits the wheels: the levels within 1.3 times, and honest.
#[test]
fn best_keeps_to_its_levels_behind_the_ramps_corners() {
    meets_the_levels("ramp", &[], 5, 1.3, |_| true);
}

/// Where `best` is off by more than rolling ground makes it: on edges its errors are several percent, and most of the time it knows.
/// Where a wheel stands on riser and tread for seconds, the contact angle that it is told is none that it rolls along.
#[test]
fn on_edges_it_mostly_knows_how_wrong_it_is() {
    for (drive, drive_keys) in DRIVES {
        // A third above the greatest errors that were measured, 3.2, 3.2 and 8.4 %.
        for (name, most) in [("step", 4.2), ("ditch", 4.2), ("stairs", 11.0)] {
            let scene = with_best(name, &[drive_keys, &["sensors.grade=typical"]]);
            let truth = TruthRun::of(&scene).unwrap();
            let what = format!("{name} {drive} typical");
            let (nrmse, consistency) = print_row(&what, &measure(&scene, &truth, 5), most);
            assert!(nrmse <= most, "{what}: {nrmse} %");
            // 93 to 98 % were measured; before blows and doubts were told, 41 to 90 %.
            let hold = consistency.coverage.mean;
            assert!(hold >= 0.9, "{what}: {hold}");
        }
    }
}

/// No tuning for one law of friction: wheels that creep a tenth and twice as much as the default's cost `best` less than a factor of
/// two in error, and a stated two sigma still holds for nine errors of ten.
#[test]
fn wheels_may_creep_as_they_like() {
    // Less than twice the 0.69 and 0.43 % of the default's creep.
    for ((drive, drive_keys), most) in DRIVES.into_iter().zip([1.36, 0.83]) {
        for v_s in ["contact.v_s=0.002", "contact.v_s=0.04"] {
            let scene = with_best("smooth", &[drive_keys, &["sensors.grade=typical", v_s]]);
            let truth = TruthRun::of(&scene).unwrap();
            let what = format!("smooth {drive} typical {v_s}");
            let (nrmse, consistency) = print_row(&what, &measure(&scene, &truth, 5), most);
            assert!(nrmse <= most, "{what}: {nrmse} %");
            let hold = consistency.coverage.mean;
            assert!(hold >= 0.9, "{what}: {hold}");
        }
    }
}

/// A robot that stands for 20 s learns nothing of friction in gears that do not turn: what it states of it is what it was told (but for
/// the first milliseconds, before the speeds are known), and what it has found is nothing.
#[test]
fn friction_is_not_read_off_wheels_that_stand() {
    for name in ["flat", "smooth"] {
        let scene = with_best(name, &[&["sensors.grade=typical", "drive.start_time=60"]]);
        let truth = TruthRun::of(&scene).unwrap();
        for seed in SEEDS {
            let scene = Scene {
                seed,
                ..scene.clone()
            };
            let mut observers = Observers::new(&scene).unwrap();
            let mut last = None;
            for sample in truth.samples() {
                last = observers.observe(sample).1[0].as_ref().ok().copied();
            }
            let (found, sigma) = last.unwrap().reading_errors.unwrap().gear_friction;
            let told = scene.noise_budget().gear_friction;
            assert!(sigma > 0.99 * told, "{name}, seed {seed}: {sigma}");
            assert!(found.abs() < 0.01, "{name}, seed {seed}: {found} ± {sigma}");
        }
    }
}

/// Against the independent implementation: with errors of T of 1 N and of contact angles of 2 deg the bound is 1.9 % under the PI
/// drive and 1.3 % under the soft one, both to the digits that are known of them.
#[test]
fn the_floor_is_that_of_the_independent_implementation() {
    for ((drive, drive_keys), expected) in DRIVES.into_iter().zip([0.019, 0.013]) {
        // 0.1 N m on a radius of 0.1 m.
        let errors = [
            "sensors.torque_noise=0.1",
            "sensors.contact_angle_error='2 deg'",
        ];
        let scene = with_best("smooth", &[drive_keys, &errors]);
        let truth = TruthRun::of(&scene).unwrap();
        let found = floor(&scene, &truth).unwrap();
        println!("{drive}: floor {:.3} %", 100.0 * found);
        assert!((found - expected).abs() <= 0.0005, "{drive}: {found}");
    }
}

/// Where the bound applies, it is reached; where an estimator knows more than one sample, it is beaten. `whitening` uses one sample
/// but for the torque's white noise, which its observer averages: within 1.2 times the floor, and not below what is left of it
/// without that noise. `best` learns offsets and angles over time: below.
#[test]
fn one_samples_floor_is_reached_and_then_left_behind() {
    for (drive, drive_keys) in DRIVES {
        let mut scene = with_best("smooth", &[drive_keys, &["sensors.grade=typical"]]);
        let of = |name: &str| ladder().into_iter().find(|e| e.name == name).unwrap();
        scene.estimators = ["whitening", "rolling"].map(of).to_vec();
        let truth = TruthRun::of(&scene).unwrap();
        let all = floor(&scene, &truth).unwrap();
        let mut averaged = scene.clone();
        averaged.sensors.spec.torque_noise = 0.0;
        let lasting = floor(&averaged, &truth).unwrap();
        let summaries = study(&scene, &truth, &SEEDS, &|| ()).unwrap();
        let [whitening, best] = [0, 1].map(|i| summaries[i].nrmse().unwrap());
        println!(
            "{drive}: floor {:.3} %, without white noise {:.3} %; whitening {:.3} %, best {:.3} %",
            100.0 * all,
            100.0 * lasting,
            100.0 * whitening.mean,
            100.0 * best.mean
        );
        assert!(whitening.mean <= 1.2 * all);
        // Ten seeds know the mean to its standard error; two of them.
        let known = whitening.mean + 2.0 * whitening.standard_error.unwrap();
        assert!(known >= lasting, "{known} {lasting}");
        assert!(best.mean <= 1.2 * all);
        assert!(best.mean <= 0.5 * all, "{} {all}", best.mean);
    }
}

/// Ablation: every rung from true masses to `best` helps or does no harm with typical sensors, and the ladder ends ten times below
/// the paper's estimators. A rung that repairs what the paper leaves undone may wait for a later one: it may cost 2 %.
#[test]
fn every_rung_of_the_ladder_carries() {
    let mut scene = with_best("smooth", &[&["sensors.grade=typical"]]);
    scene.estimators = ladder();
    let truth = TruthRun::of(&scene).unwrap();
    let summaries = study(&scene, &truth, &SEEDS[..5], &|| ()).unwrap();
    let errors: Vec<f64> = summaries.iter().map(|s| s.nrmse().unwrap().mean).collect();
    for (pair, scores) in errors.windows(2).zip(&summaries[1..]) {
        println!("{:12} {:.3} %", scores.name, 100.0 * pair[1]);
        assert!(pair[1] <= 1.02 * pair[0], "{}: {pair:?}", scores.name);
    }
    assert!(10.0 * errors[errors.len() - 1] < errors[1], "{errors:?}");
}

/// Determinism: the same result to the bit from one thread and from three.
#[test]
fn a_study_does_not_depend_on_threads() {
    let short = ["record.duration=3", "sensors.grade=poor"];
    let scene = with_best("smooth", &[&short]);
    let truth = TruthRun::of(&scene).unwrap();
    let of = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let study = || study(&scene, &truth, &SEEDS[..7], &|| ());
        pool.build().unwrap().install(study).unwrap()
    };
    assert!(of(1) == of(3));
}
