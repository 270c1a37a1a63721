//! Acceptance of `kalman` without any contact angle: other grounds, friction laws, speeds, continuous
//! slip.
//!
//! The study behind `docs/measurements/no-angles.md`:
//! `cargo test --release -p robhaz-study --test study no_angles::study_of_all -- --ignored --nocapture`.
//! It runs ten seeds of every case with both drives. The variable `ROBHAZ_CASES` selects the cases
//! whose name contains one of its words, divided by commas; `ROBHAZ_FIRST` and `ROBHAZ_SEEDS` are
//! the first seed and the number of seeds.

use rayon::prelude::*;
use robhaz_run::Observers;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_score::{Rule, Score};
use robhaz_study::TruthRun;
use std::ops::Range;
use std::path::Path;

const DRIVES: [(&str, &[&str]); 2] = [("PI", &[]), ("soft", &["drive.kp=2", "drive.ki=0"])];

/// A shipped scene with overrides, and the limits for both drives (PI, soft).
struct Case {
    name: &'static str,
    scene: &'static str,
    overrides: &'static [&'static str],
    /// Largest error of N over the seeds of the test, % of its mean, samples with two contacts left
    /// out: a third above that of ten seeds. `None` in the study only.
    limits: Option<[f64; 2]>,
}

impl Case {
    const fn within(mut self, limits: [f64; 2]) -> Self {
        self.limits = Some(limits);
        self
    }
}

const fn on(scene: &'static str, name: &'static str, overrides: &'static [&'static str]) -> Case {
    Case {
        name,
        scene,
        overrides,
        limits: None,
    }
}

const fn on_smooth(name: &'static str, overrides: &'static [&'static str]) -> Case {
    on("smooth", name, overrides)
}

const POOR_GROUND: [&str; 2] = ["contact.mu_s=0.5", "contact.mu_d=0.45"];
const SLOPE: [&str; 4] = [
    "terrain.kind=ramp",
    "terrain.start=-1.5",
    "terrain.length=3.5",
    "record.duration=16",
];
const FRONT_FASTER: &str = "drive.scaling=[{wheels=[1],from=4,to=14,factor=1.5}]";

const CASES: &[Case] = &[
    on_smooth("smooth", &[]).within([1.0, 0.85]),
    on("sine", "sine", &[]),
    on("rough", "rough", &[]),
    on("heights", "heights", &[]),
    on_smooth("robot B", &["robot.geometry=B"]),
    on("cosbump", "cosbump", &[]),
    on("flat", "flat", &[]),
    on("ramp", "ramp", &[]),
    on("course", "course", &[]).within([1.9, 1.9]),
    on("step", "step", &[]).within([4.3, 3.7]),
    on(
        "step",
        "kerb of 150 mm",
        &["terrain.kerb=0.15", "record.duration=16"],
    ),
    on("ditch", "ditch", &[]),
    on("stairs", "stairs, robot A", &["robot.geometry=A"]),
    on("stairs", "stairs, robot C", &[]),
    on_smooth("v_s 0.6 mm/s", &["contact.v_s=6e-4"]).within([1.35, 0.75]),
    on_smooth("v_s 2 mm/s", &["contact.v_s=2e-3"]),
    on_smooth("v_s 6 mm/s", &["contact.v_s=6e-3"]),
    on_smooth("v_s 40 mm/s", &["contact.v_s=0.04"]),
    on_smooth("v_s 80 mm/s", &["contact.v_s=0.08"]),
    on_smooth("v_s 120 mm/s", &["contact.v_s=0.12", "contact.v_d=0.3"]).within([0.8, 0.8]),
    on_smooth(
        "brush, C = 5",
        &["contact.friction=brush", "contact.slip_stiffness=5"],
    )
    .within([0.85, 0.9]),
    on_smooth("brush, C = 20", &["contact.friction=brush"]),
    on_smooth(
        "brush, C = 50",
        &["contact.friction=brush", "contact.slip_stiffness=50"],
    ),
    on_smooth("rigid, v_s 1 mm/s", &["contact.friction=rigid"]),
    on_smooth(
        "rigid, v_s 0.2 mm/s",
        &["contact.friction=rigid", "contact.v_s=2e-4"],
    ),
    on_smooth(
        "mu 0.3 on stretches",
        &[
            "terrain.stretch=[{from=0.8,to=1.6,mu_s=0.3,mu_d=0.25},{from=2.2,to=2.6,mu_s=0.3,mu_d=0.25}]",
        ],
    ),
    on_smooth("mu 0.3", &["contact.mu_s=0.3", "contact.mu_d=0.25"]),
    on_smooth(
        "rolling resistance 0.02",
        &["contact.rolling_resistance=0.02"],
    ),
    on_smooth("0.005 m/s", &["drive.speed=0.005", "record.duration=300"]),
    on_smooth("0.01 m/s", &["drive.speed=0.01", "record.duration=160"]).within([0.95, 1.1]),
    on_smooth("0.02 m/s", &["drive.speed=0.02", "record.duration=110"]).within([0.65, 0.7]),
    on_smooth("0.05 m/s", &["drive.speed=0.05", "record.duration=60"]),
    on_smooth("0.1 m/s", &["drive.speed=0.1", "record.duration=36"]),
    on_smooth("0.3 m/s", &["drive.speed=0.3", "record.duration=14"]),
    on_smooth("0.5 m/s", &["drive.speed=0.5", "record.duration=9"]).within([1.85, 1.2]),
    on(
        "ramp",
        "start on a slope of 0.1",
        &[SLOPE[0], SLOPE[1], SLOPE[2], SLOPE[3], "terrain.angle=0.1"],
    )
    .within([1.2, 1.5]),
    on(
        "ramp",
        "start on a slope of -0.1",
        &[SLOPE[0], SLOPE[1], SLOPE[2], SLOPE[3], "terrain.angle=-0.1"],
    ),
    on(
        "flat",
        "front wheel slips, level",
        &[
            POOR_GROUND[0],
            POOR_GROUND[1],
            FRONT_FASTER,
            "record.duration=18",
        ],
    ),
    on(
        "flat",
        "middle wheel slips, level",
        &[
            POOR_GROUND[0],
            POOR_GROUND[1],
            "drive.scaling=[{wheels=[2],from=4,to=14,factor=1.5}]",
            "record.duration=18",
        ],
    ),
    on_smooth(
        "front wheel slips",
        &[POOR_GROUND[0], POOR_GROUND[1], FRONT_FASTER],
    )
    .within([1.1, 0.9]),
    on_smooth(
        "rear wheel drags",
        &[
            POOR_GROUND[0],
            POOR_GROUND[1],
            "drive.scaling=[{wheels=[3],from=4,to=14,factor=0.3}]",
        ],
    ),
    on_smooth(
        "forth and back",
        &["drive.scaling=[{wheels=[1,2,3],from=10,to=19,factor=-1}]"],
    ),
    on_smooth(
        "backwards over bumps",
        &[
            "terrain.kind=bumps",
            "drive.speed=-0.2",
            "terrain.bumps=[{height=0.05,centre=-1.0,width=0.22},{height=-0.035,centre=-1.45,width=0.2},{height=0.04,centre=-1.9,width=0.17},{height=0.06,centre=-2.5,width=0.28},{height=-0.03,centre=-2.95,width=0.16}]",
        ],
    ),
];

fn load(case: &Case, drive: &[&str], world: &[String]) -> Scene {
    let fixed = [
        "engine.kind=direct",
        "sensors.grade=typical",
        "estimator=[{name='kalman',contact_angles='none'}]",
    ];
    let all = [&fixed, case.overrides, drive].concat();
    let mut overrides: Vec<String> = all.iter().map(|s| (*s).to_owned()).collect();
    overrides.extend_from_slice(world);
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let path = scenes.join(format!("{}.toml", case.scene));
    Scene::load(&path, &overrides).unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

/// What one seed shows.
struct Seed {
    score: Score,
    /// Square error of the contact angles of loaded wheels, rad^2, against the equivalent contact.
    angle: f64,
}

fn observe(scene: &Scene, truth: &TruthRun) -> Result<Seed, ModelErrorTooLarge> {
    let rule = Rule {
        compare_from: scene.record.compare_from,
    };
    let mut observers = Observers::new(scene)?;
    let mut score = Score::new(rule);
    let (mut angle, mut count) = (0.0, 0.0);
    for t in truth.samples() {
        let (_, estimates) = observers.observe(t);
        let estimate = estimates[0].as_ref().ok();
        score.add(t, estimate);
        let Some(e) = estimate.filter(|_| rule.compares(t.time)) else {
            continue;
        };
        for (found, wheel) in e.contact_angle.iter().zip(&t.wheels) {
            if let Some(contact) = wheel.equivalent_contact().filter(|c| c.normal_force > 2.0) {
                angle += (found - contact.angle).powi(2);
                count += 1.0;
            }
        }
    }
    Ok(Seed {
        score,
        angle: angle / count,
    })
}

/// Means over the seeds of a case, %.
struct Measured {
    /// Error of N at one contact a wheel.
    error: f64,
    /// Their stated deviation.
    stated: f64,
    /// Share of these errors within two sigma.
    inside: f64,
    /// Mean NEES of these samples.
    nees: f64,
    /// Share of the errors of all samples within two sigma.
    inside_all: f64,
    /// Mean NEES of all samples.
    nees_all: f64,
}

/// Means over the seeds, printed as a row.
fn row(name: &str, drive: &str, seeds: &[Seed]) -> Measured {
    let mean = |f: &dyn Fn(&Seed) -> Option<f64>| {
        let values: Vec<f64> = seeds.iter().filter_map(f).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let found = Measured {
        error: 100.0 * mean(&|s| s.score.at_one_contact().nrmse()),
        stated: 100.0 * mean(&|s| s.score.at_one_contact().stated()),
        inside: 100.0 * mean(&|s| s.score.at_one_contact().coverage()),
        nees: mean(&|s| s.score.at_one_contact().nees()),
        inside_all: 100.0 * mean(&|s| s.score.coverage()),
        nees_all: mean(&|s| s.score.nees()),
    };
    println!(
        "| {name} | {drive} | {:.2} | {:.2} | {:.1} | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} | {:.0} | {:.2} |",
        found.error,
        found.stated,
        found.inside,
        found.nees,
        mean(&|s| Some(s.score.at_one_contact().traction()?.rmse_all)),
        mean(&|s| Some(s.angle)).sqrt().to_degrees(),
        100.0 * mean(&|s| s.score.nrmse()),
        found.inside_all,
        found.nees_all,
        mean(&|s| Some(s.score.traction()?.rmse_all)),
    );
    found
}

/// Runs the seeds of a case on one truth, and prints a row.
fn measure(case: &Case, drive: (&str, &[&str]), seeds: Range<u64>) -> Measured {
    let scene = load(case, drive.1, &[]);
    let truth = TruthRun::of(&scene).unwrap_or_else(|e| panic!("{}: {e}", case.name));
    let with_seed = |seed: u64| {
        let scene = Scene {
            seed,
            ..scene.clone()
        };
        observe(&scene, &truth).unwrap_or_else(|e| panic!("{}: {e}", case.name))
    };
    let seeds: Vec<Seed> = seeds.into_par_iter().map(with_seed).collect();
    row(case.name, drive.0, &seeds)
}

/// The magnitude of a standard normal variable in the middle of each tenth of its distribution.
const TENTHS: [f64; 10] = [
    0.063, 0.189, 0.319, 0.454, 0.598, 0.755, 0.935, 1.150, 1.440, 1.960,
];

/// As [`measure`], with `count` seeds from `first` on, ten at most, in worlds that have what the budget
/// allows for and no shipped scene has: rolling resistance and gear friction of its deviations, drawn
/// in tenths.
fn measure_drawn(case: &Case, drive: (&str, &[&str]), first: u64, count: usize) -> Measured {
    let budget = load(case, drive.1, &[]).noise_budget();
    let budget = budget.unwrap_or_else(|e| panic!("{}: {e}", case.name));
    let with_seed = |k: usize| {
        let rolling = TENTHS[k] * budget.rolling_resistance;
        // Another order, so that the two are independent.
        let friction = TENTHS[7 * k % 10] * budget.gear_friction;
        let world = [
            format!("contact.rolling_resistance={rolling}"),
            format!("drive.gear_friction={friction}"),
            format!("seed={}", first + k as u64),
        ];
        let scene = load(case, drive.1, &world);
        let truth = TruthRun::of(&scene).unwrap_or_else(|e| panic!("{}: {e}", case.name));
        observe(&scene, &truth).unwrap_or_else(|e| panic!("{}: {e}", case.name))
    };
    let draws = 0..count.min(TENTHS.len());
    let seeds: Vec<Seed> = draws.into_par_iter().map(with_seed).collect();
    row(case.name, drive.0, &seeds)
}

/// The error stays within a third above that of ten seeds, and at least 85 % of the errors within
/// two sigma: of four seeds one may have drawn offsets of two sigma, which last for the whole run.
/// Over ten seeds it is at least 90 %, but for the cases that the documents name.
#[test]
fn errors_without_contact_angles() {
    for case in CASES {
        let Some(limits) = case.limits else { continue };
        for (drive, limit) in DRIVES.into_iter().zip(limits) {
            let Measured { error, inside, .. } = measure(case, drive, 0..4);
            assert!(error <= limit, "{} {}: {error} %", case.name, drive.0);
            assert!(inside >= 85.0, "{} {}: {inside} %", case.name, drive.0);
        }
    }
}

/// What is stated is what it errs by, in worlds that the budget allows: the mean NEES is 1.2 to 5, 3
/// being right, what is stated 0.75 to 1.6 times the error, and 91 % of the errors are within two
/// deviations.
#[test]
fn what_is_stated_holds_in_worlds_that_the_budget_allows() {
    for name in [
        "smooth",
        "rough",
        "brush, C = 20",
        "start on a slope of 0.1",
    ] {
        let case = CASES.iter().find(|case| case.name == name);
        let case = case.expect("a case of that name");
        for drive in DRIVES {
            let found = measure_drawn(case, drive, 300, 10);
            let ratio = found.stated / found.error;
            let name = format!("{name} {}", drive.0);
            assert!((1.2..5.0).contains(&found.nees), "{name}: {}", found.nees);
            assert!((0.75..1.6).contains(&ratio), "{name}: {ratio}");
            assert!(found.inside > 91.0, "{name}: {} %", found.inside);
        }
    }
}

/// A robot that a kerb or stairs hold is found to stand, and states that it hardly knows N: over
/// two seeds at least 90 % of all errors are within two sigma, impacts included. Their mean NEES is 20
/// at most, 3 being right: in an impact N changes by many weights between two readings.
#[test]
fn a_held_robot_states_what_it_does_not_know() {
    for name in ["kerb of 150 mm", "stairs, robot A"] {
        let case = CASES.iter().find(|case| case.name == name);
        let case = case.expect("a case of that name");
        for drive in DRIVES {
            let Measured {
                inside_all,
                nees_all,
                ..
            } = measure(case, drive, 0..2);
            assert!(inside_all >= 90.0, "{name} {}: {inside_all} %", drive.0);
            assert!(nees_all <= 20.0, "{name} {}: {nees_all}", drive.0);
        }
    }
}

#[test]
#[ignore = "a study of some minutes"]
fn study_of_worlds_that_the_budget_allows() {
    heading();
    for case in CASES
        .iter()
        .filter(|case| case.name != "rolling resistance 0.02")
    {
        if selected(case) {
            for drive in DRIVES {
                let (first, count) = (number("ROBHAZ_FIRST", 0), number("ROBHAZ_SEEDS", 10));
                measure_drawn(case, drive, first, count as usize);
            }
        }
    }
}

#[test]
#[ignore = "a study of some minutes"]
fn study_of_all() {
    heading();
    let (first, count) = (number("ROBHAZ_FIRST", 0), number("ROBHAZ_SEEDS", 10));
    for case in CASES.iter().filter(|case| selected(case)) {
        for drive in DRIVES {
            measure(case, drive, first..first + count);
        }
    }
}

fn heading() {
    println!(
        "| case | drive | N, % | stated, % | within two sigma, % | NEES | T, N | angle, deg | all: N, % | within, % | NEES | T, N |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
}

fn selected(case: &Case) -> bool {
    let words = std::env::var("ROBHAZ_CASES").unwrap_or_default();
    words.split(',').any(|word| case.name.contains(word))
}

fn number(name: &str, default: u64) -> u64 {
    let number = |text: String| {
        let parsed = text.parse();
        parsed.unwrap_or_else(|e| panic!("{name}={text}: {e}"))
    };
    std::env::var(name).map_or(default, number)
}
