//! The verdict of `robhaz path --drive shared|speed` against driving in the simulator: random
//! paths, engine `direct`, the same drive.
//!
//! The study behind `docs/measurements/path-verdict.md`:
//! `cargo test --release -p robhaz-study --test study path_verdict::study -- --ignored --nocapture`.
//! `ROBHAZ_PATHS` is the number of paths, `ROBHAZ_SERIES` the number of the series that they are
//! drawn from, `ROBHAZ_DRIVE` the drive, `shared` by default, `ROBHAZ_ROVER` a rover of `robots/`
//! in place of robot A. `ROBHAZ_OUTCOMES` names a file that keeps how the drives ended: where it
//! exists, nothing is driven and only the verdict is computed anew.

// A test may panic.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod grounds;
mod trial;

use grounds::Kind;
use rayon::prelude::*;
use robhaz_path::DriveKind;
use trial::{Drove, Trial};

/// The trials of a series; `known` are the ends of their drives as far as they are known.
fn trials(
    series: u64,
    count: u64,
    drive: DriveKind,
    rover: Option<&str>,
    known: &[Drove],
) -> Vec<Trial> {
    let known = |n: u64| usize::try_from(n).ok().and_then(|n| known.get(n)).copied();
    (0..count)
        .into_par_iter()
        .map(|n| Trial::new(series, n, drive, rover, known(n)).unwrap())
        .collect()
}

/// Numbers of trials of one kind, or of all, by verdict and outcome.
struct Confusion {
    go: [usize; 2],
    no_go: [usize; 2],
}

impl Confusion {
    fn of<'a>(trials: impl Iterator<Item = &'a Trial>) -> Self {
        let mut found = Self {
            go: [0; 2],
            no_go: [0; 2],
        };
        for trial in trials {
            let row = if trial.go() {
                &mut found.go
            } else {
                &mut found.no_go
            };
            row[usize::from(!trial.passed())] += 1;
        }
        found
    }

    fn row(&self, name: &str) -> String {
        let ([a, b], [c, d]) = (self.go, self.no_go);
        let all = a + b + c + d;
        format!("| {name} | {all} | {a} | {b} | {c} | {d} |")
    }
}

/// Trials that are called go with a probability of at least 0.95, and how many of them did not
/// pass.
fn sure(trials: &[Trial]) -> (usize, usize) {
    let sure = trials.iter().filter(|t| t.go() && t.probability() >= 0.95);
    let failed = sure.clone().filter(|t| !t.passed()).count();
    (sure.count(), failed)
}

/// Acceptance, on a few paths of each kind: the verdict agrees with driving but for one path, and
/// no path that is called go with a probability of at least 0.95 stops the robot. The share of all
/// is that of the study.
#[test]
fn the_verdict_agrees_with_driving() {
    let trials = trials(100, 21, DriveKind::Shared, None, &[]);
    let wrong: Vec<String> = trials
        .iter()
        .filter(|t| t.go() != t.passed())
        .map(Trial::line)
        .collect();
    assert!(wrong.len() <= 1, "{wrong:#?}");
    assert_eq!(sure(&trials).1, 0, "{wrong:#?}");
    // Sensitivity: both verdicts and both outcomes occur.
    for is_go in [true, false] {
        assert!(trials.iter().filter(|t| t.go() == is_go).count() >= 4);
        assert!(trials.iter().filter(|t| t.passed() == is_go).count() >= 4);
    }
}

#[test]
#[ignore = "a study of some minutes"]
fn study() {
    let number =
        |name: &str, default: u64| std::env::var(name).map_or(default, |t| t.parse().unwrap());
    let (series, count) = (number("ROBHAZ_SERIES", 1), number("ROBHAZ_PATHS", 140));
    let drive = match std::env::var("ROBHAZ_DRIVE").as_deref() {
        Ok("speed") => DriveKind::Speed,
        Ok("shared") | Err(_) => DriveKind::Shared,
        Ok(other) => panic!("the drive {other} cannot be driven"),
    };
    let file = std::env::var("ROBHAZ_OUTCOMES").ok();
    let text = file.as_ref().and_then(|f| std::fs::read_to_string(f).ok());
    let known: Vec<Drove> = text
        .iter()
        .flat_map(|t| t.lines())
        .map(|line| Drove::parse(line).unwrap())
        .collect();
    let rover = std::env::var("ROBHAZ_ROVER").ok();
    let trials = trials(series, count, drive, rover.as_deref(), &known);
    if let Some(file) = file.filter(|_| text.is_none()) {
        let lines: Vec<String> = trials.iter().map(|t| t.drove.line()).collect();
        std::fs::write(file, lines.join("\n")).unwrap();
    }
    for trial in trials.iter().filter(|t| t.go() != t.passed()) {
        println!("{}", trial.line());
    }
    println!(
        "| ground | paths | go, passed | go, not passed | no-go, passed | no-go, not passed |"
    );
    println!("|---|---|---|---|---|---|");
    for kind in Kind::ALL {
        let of = trials.iter().filter(|t| t.kind == kind);
        println!("{}", Confusion::of(of).row(kind.name()));
    }
    println!("{}", Confusion::of(trials.iter()).row("all"));
    let agree = trials.iter().filter(|t| t.go() == t.passed()).count();
    let (sure, failed) = sure(&trials);
    println!(
        "agree {agree} of {count}; go with probability >= 0.95: {sure}, of them not passed {failed}"
    );
}
