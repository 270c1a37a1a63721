//! One random path: its verdict, and what driving it showed.

use super::grounds::{Kind, RandomPath, random_path};
use robhaz_path::{DriveKind, Options, PathReport, PathSetup, judge};
use robhaz_run::{DrivenPlant, TruthClearance};
use robhaz_sim::Truth;
use std::error::Error;

pub type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Standard deviation of the friction coefficient that the probability is stated for, -.
const MU_SIGMA: f64 = 0.03;
/// The robot is stuck when it has not come so much farther (m) in so long (s).
const FARTHER: f64 = 0.005;
const PATIENCE: f64 = 4.0;

/// How a drive ended.
const ENDS: [&str; 4] = ["passed", "stuck", "touched", "overturned"];

/// A drive: x of the middle wheel at its end, m, and how it ended.
#[derive(Clone, Copy)]
pub struct Drove {
    x: f64,
    end: &'static str,
}

impl Drove {
    /// As a line of text.
    pub fn line(&self) -> String {
        format!("{} {}", self.x, self.end)
    }

    /// From a line of text; words before the last two are skipped.
    pub fn parse(line: &str) -> Outcome<Self> {
        let mut words = line.split(' ').rev();
        let word = words.next().ok_or("no end")?;
        let end = ENDS.into_iter().find(|e| *e == word).ok_or("no end")?;
        let x = words.next().ok_or("no x")?.parse()?;
        Ok(Self { x, end })
    }

    /// Drives until the goal (m), until the robot is stuck or turns over, or until a bar touches
    /// the ground, whose force is not modelled.
    fn along(path: &RandomPath, goal: f64) -> Outcome<Self> {
        let scene = &path.scene;
        let mut plant = DrivenPlant::new(scene, &scene.plant_setup())?;
        let mut meter = TruthClearance::of(scene);
        let (mut best, mut since, mut x) = (f64::NEG_INFINITY, 0.0, 0.0);
        for sample in 1_u32.. {
            let Ok(truth) = plant.next_truth() else {
                let end = "overturned";
                return Ok(Self { x, end });
            };
            x = truth.wheels[1].position.x;
            if x > best + FARTHER {
                (best, since) = (x, truth.time);
            }
            let waited = truth.time - since.max(scene.drive.start_time);
            let end = if sample.is_multiple_of(10) && touches(&mut meter, &truth) {
                "touched"
            } else if x >= goal {
                "passed"
            } else if waited > PATIENCE || truth.time >= scene.record.duration {
                "stuck"
            } else {
                continue;
            };
            return Ok(Self { x, end });
        }
        Err("the drive never ended".into())
    }
}

/// A path with its verdict and its drive.
pub struct Trial {
    pub kind: Kind,
    words: String,
    report: Result<PathReport, String>,
    pub drove: Drove,
    goal: f64,
}

impl Trial {
    /// The path of a number in a series; a drive that is known is not repeated.
    pub fn new(
        series: u64,
        number: u64,
        drive: DriveKind,
        rover: Option<&str>,
        known: Option<Drove>,
    ) -> Outcome<Self> {
        let path = random_path(series, number, drive, rover)?;
        let options = Options {
            drive,
            mu_sigma: MU_SIGMA,
            ..Options::default()
        };
        let setup = PathSetup::new(&path.scene, options)?;
        let drove = match known {
            Some(drove) => drove,
            None => Drove::along(&path, setup.distance)?,
        };
        Ok(Self {
            kind: path.kind,
            words: path.words,
            report: judge(&setup).map_err(|e| e.to_string()),
            drove,
            goal: setup.distance,
        })
    }

    /// Whether the robot came to the end of the path.
    pub fn passed(&self) -> bool {
        self.drove.end == "passed"
    }

    /// The verdict. A path that cannot be judged is no-go.
    pub fn go(&self) -> bool {
        self.report.as_ref().is_ok_and(|r| r.go)
    }

    /// Its probability of go.
    pub fn probability(&self) -> f64 {
        self.report.as_ref().map_or(0.0, |r| r.probability)
    }

    /// Path, drive and verdict in words.
    pub fn line(&self) -> String {
        let verdict = match &self.report {
            Err(error) => error.clone(),
            Ok(r) => format!(
                "{} with probability {:.3}, margin {:?} {:?}",
                if r.go { "go" } else { "no-go" },
                r.probability,
                r.margin,
                r.first_failure.map(|f| (f.x, f.reason, f.by))
            ),
        };
        let Drove { x, end } = self.drove;
        let (words, goal) = (&self.words, self.goal);
        format!("{words}: {end} at {x:.3} of {goal:.3} m; {verdict}")
    }
}

/// Whether a bar touches the ground.
fn touches(meter: &mut TruthClearance, truth: &Truth) -> bool {
    meter.at(truth).touches()
}
