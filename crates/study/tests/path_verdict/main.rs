//! The verdict of `robhaz path` against driving in the simulator: random paths, engine `direct`, drive `shared`.
//!
//! The study behind the tables in `docs/friction.md`:
//! `cargo test --release -p robhaz-study --test path_verdict study -- --ignored --nocapture`. `ROBHAZ_PATHS` is the number of paths,
//! `ROBHAZ_SERIES` the number of the series that they are drawn from.

// A test may panic.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod grounds;

use grounds::{Kind, RandomPath, random_path};
use rayon::prelude::*;
use robhaz_path::{DriveKind, Options, PathReport, PathSetup, judge};
use robhaz_run::{DrivenPlant, TruthClearance};

type Outcome<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// Standard deviation of the friction coefficient that the probability is stated for, -.
const MU_SIGMA: f64 = 0.03;

/// A path with its verdict and what driving it showed.
struct Trial {
    kind: Kind,
    words: String,
    report: Result<PathReport, String>,
    /// x of the middle wheel at its end, m, and how it ended.
    x: f64,
    goal: f64,
    end: &'static str,
}

impl Trial {
    fn passed(&self) -> bool {
        self.end == "passed"
    }

    fn go(&self) -> bool {
        self.report.as_ref().is_ok_and(|r| r.go)
    }

    fn probability(&self) -> f64 {
        self.report.as_ref().map_or(0.0, |r| r.probability)
    }

    fn line(&self) -> String {
        let verdict = match &self.report {
            Err(error) => error.clone(),
            Ok(r) => format!(
                "stop {:.3} {} p {:.3} margin {:?} at {:?}, {:?}",
                r.places
                    .iter()
                    .map(|p| (p.opening - 0.6109).max(-0.6981 - p.opening))
                    .fold(-9.0, f64::max),
                if r.go { "GO" } else { "no-go" },
                r.probability,
                r.margin,
                r.margin_x,
                r.first_failure.map(|f| (f.x, f.reason, f.by))
            ),
        };
        format!(
            "{}: {} at {:.3} of {:.3} m; {verdict}",
            self.words, self.end, self.x, self.goal
        )
    }
}

/// Drives until the goal (m), until the robot has not come 5 mm farther in 4 s, or until a bar touches the ground, whose force is not
/// modelled.
fn drive(path: &RandomPath, goal: f64) -> Outcome<(f64, &'static str)> {
    let scene = &path.scene;
    let mut plant = DrivenPlant::new(scene, &scene.plant_setup())?;
    let mut meter = TruthClearance::of(scene);
    let (mut best, mut since, mut x, mut sample) = (f64::NEG_INFINITY, 0.0, 0.0, 0_u32);
    loop {
        let Ok(truth) = plant.next_truth() else {
            return Ok((x, "overturned"));
        };
        x = truth.wheels[1].position.x;
        if x > best + 0.005 {
            (best, since) = (x, truth.time);
        }
        sample += 1;
        if sample.is_multiple_of(10) && meter.at(&truth).touches() {
            return Ok((x, "touched"));
        }
        if x >= goal {
            return Ok((x, "passed"));
        }
        if truth.time > since.max(scene.drive.start_time) + 4.0
            || truth.time >= scene.record.duration
        {
            return Ok((x, "stuck"));
        }
    }
}

fn trial(series: u64, number: u64, known: Option<&str>) -> Outcome<Trial> {
    let path = random_path(series, number)?;
    let options = Options {
        drive: DriveKind::ALL[std::env::var("ROBHAZ_KIND").map_or(Ok(1), |t| t.parse())?],
        mu_sigma: MU_SIGMA,
        ..Options::default()
    };
    let setup = PathSetup::new(&path.scene, options)?;
    let goal = setup.distance;
    let (x, end) = match known {
        Some(line) => {
            let mut words = line.split(' ').skip(1);
            let x: f64 = words.next().ok_or("x")?.parse()?;
            let end = words.next().ok_or("end")?;
            (
                x,
                ["passed", "stuck", "touched", "overturned"]
                    .into_iter()
                    .find(|e| *e == end)
                    .ok_or("end")?,
            )
        }
        None => drive(&path, goal)?,
    };
    let report = judge(&setup).map_err(|e| e.to_string());
    Ok(Trial {
        kind: path.kind,
        words: path.words,
        report,
        x,
        goal,
        end,
    })
}

#[test]
#[ignore = "a study of some minutes"]
fn study() {
    let number =
        |name: &str, default: u64| std::env::var(name).map_or(default, |t| t.parse().unwrap());
    let (series, count) = (number("ROBHAZ_SERIES", 1), number("ROBHAZ_PATHS", 140));
    let file = std::env::var("ROBHAZ_OUTCOMES").ok();
    let known = file
        .as_ref()
        .and_then(|f| std::fs::read_to_string(f).ok())
        .unwrap_or_default();
    let known: Vec<&str> = known.lines().collect();
    let only = std::env::var("ROBHAZ_ONLY").ok();
    let trials: Vec<Trial> = (0..count)
        .into_par_iter()
        .filter(|n| {
            only.as_ref()
                .is_none_or(|o| o.split(',').any(|k| k.parse::<u64>().unwrap() == n % 7))
        })
        .map(|n| trial(series, n, known.get(n as usize).copied()).unwrap())
        .collect();
    if let Some(file) = file
        && known.is_empty()
    {
        let lines: Vec<String> = trials
            .iter()
            .enumerate()
            .map(|(n, t)| format!("{n} {} {}", t.x, t.end))
            .collect();
        std::fs::write(file, lines.join("\n")).unwrap();
    }
    for t in trials.iter().filter(|t| t.go() != t.passed()) {
        println!("{}", t.line());
    }
    println!(
        "| ground | paths | go, passed | go, not passed | no-go, passed | no-go, not passed | agree |"
    );
    for kind in Kind::ALL {
        let of: Vec<_> = trials.iter().filter(|t| t.kind == kind).collect();
        let n = |go, passed| {
            of.iter()
                .filter(|t| t.go() == go && t.passed() == passed)
                .count()
        };
        println!(
            "| {} | {} | {} | {} | {} | {} |",
            kind.name(),
            of.len(),
            n(true, true),
            n(true, false),
            n(false, true),
            n(false, false)
        );
    }
    let agree = trials.iter().filter(|t| t.go() == t.passed()).count();
    let sure: Vec<_> = trials.iter().filter(|t| t.probability() >= 0.95).collect();
    let failed = sure.iter().filter(|t| !t.passed()).count();
    println!(
        "agree {agree} of {}; sure {}, of them not passed {failed}",
        trials.len(),
        sure.len()
    );
}
