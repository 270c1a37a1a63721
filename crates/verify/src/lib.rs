//! Checks that the simulated truth of a scene can be trusted.
//!
//! [`verify`] runs a scene on both engines, with half the step and a second time, and checks the forces: momentum,
//! energy, the laws' bounds, agreement, repetition. No reference run is needed, so that any scene can be checked.
//! Momentum and energy are judged by the impulses and the work that the engines integrate at their own steps, so that
//! impacts between records count. The measures themselves are public: tests use them with bounds of their own.

mod agreement;
mod balance;
mod run;

pub use agreement::{Agreement, agreement, impulse_difference};
pub use balance::{Energy, energy, momentum_error};
pub use run::{MOST_RECORDS, Run, VerifyError, truth_of};

use robhaz_scene::{EngineKind, PlantFailure, Scene};
use robhaz_sim::Truth;
use robhaz_terrain::Terrain;

/// What came of one check.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// What was checked.
    pub check: String,
    /// What was found, with its unit, and what is allowed; or why the check does not apply.
    pub finding: String,
    /// Whether it holds.
    pub outcome: Outcome,
}

/// Whether a check holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It holds.
    Passed,
    /// It does not.
    Failed,
    /// It says nothing about this scene.
    NotJudged,
}

/// On rolling ground: N of the engines, RMS over its mean.
const ROLLING: f64 = 1e-3;
/// With impacts: impulse of the ground on a wheel over the run, of itself.
const IMPULSE: f64 = 1e-2;
/// Distance of the bodies at the end, m.
const APART: f64 = 1e-3;
/// Momentum, of weight times time: direct leaves 1e-8 at its default tolerance, 3.5e-6 at its loosest; rapier rounding
/// alone.
const MOMENTUM: f64 = 1e-5;
/// On rolling ground: energy, of its scale. Rapier is of first order in its step and leaves 1e-5.
const ENERGY: f64 = 1e-3;
/// With impacts: energy, of its scale. Rapier leaves 4e-4 on the shipped trench and 1.4e-3 on the same at 3 m/s, half
/// of it with half the step; direct leaves 1e-7.
const ENERGY_OF_IMPACTS: f64 = 3e-3;
/// Gap of a pin, m: rapier's joints give way a little; direct closes the loop in closed form.
const fn gap_allowed(kind: EngineKind) -> f64 {
    match kind {
        EngineKind::Rapier => 1e-6,
        EngineKind::Direct => 1e-9,
    }
}

/// Runs all checks on a scene. `step` hears what is being done.
///
/// An engine that stops before the end fails a check; the others judge its run up to there.
///
/// # Errors
/// [`VerifyError`] where there is nothing to judge.
pub fn verify(scene: &Scene, step: &mut dyn FnMut(&str)) -> Result<Vec<Verdict>, VerifyError> {
    let with = |kind| {
        let mut scene = scene.clone();
        scene.engine.kind = kind;
        scene
    };
    let has_corners = Terrain::new(scene.terrain.profile.clone()).has_corners();
    let mut verdicts = Vec::new();
    let mut runs = Vec::new();
    for kind in EngineKind::ALL {
        let name = kind.name();
        step(&format!("engine {name}"));
        let scene = with(kind);
        let run = Run::of(&scene)?;
        verdicts.push(reaches_its_end(name, &run));
        verdicts.extend(alone(&scene, &run, has_corners));
        step(&format!("engine {name}, once more"));
        let same = Run::of(&scene)? == run;
        verdicts.push(Verdict {
            check: format!("{name}: a second run"),
            finding: if same { "the same bits" } else { "other bits" }.to_owned(),
            outcome: outcome(same),
        });
        runs.push((name, run));
    }
    let [(_, rapier), (_, direct)] = [&runs[0], &runs[1]];
    verdicts.extend(compared("the engines", [rapier, direct], has_corners));
    step("engine rapier, half the step");
    let mut halved = with(EngineKind::Rapier);
    halved.engine.step *= 0.5;
    let halved = Run::of(&halved)?;
    if rapier.stopped.is_none() {
        verdicts.push(reaches_its_end("rapier with half its step", &halved));
    }
    let what = "rapier and half its step";
    verdicts.extend(compared(what, [rapier, &halved], has_corners));
    Ok(verdicts)
}

/// Whether a run was not stopped.
fn reaches_its_end(name: &str, run: &Run) -> Verdict {
    Verdict {
        check: format!("{name}: runs to its end"),
        finding: match &run.stopped {
            None => format!("{} s", run.truth.last().map_or(0.0, |t| t.time)),
            Some(why) => PlantFailure::from(*why).to_string(),
        },
        outcome: outcome(run.stopped.is_none()),
    }
}

/// Checks that need one run.
fn alone(scene: &Scene, run: &Run, has_corners: bool) -> Vec<Verdict> {
    let engine = scene.engine.kind.name();
    let (truth, robot) = (&run.truth, &scene.robot.robot);
    // Rates and differences need two records.
    if truth.len() < 2 {
        return vec![not_judged(
            format!("{engine}: all other checks"),
            "the run stopped at once",
        )];
    }
    let gap = truth.iter().map(|t| t.loop_error).fold(0.0, f64::max);
    let beyond = beyond_the_laws(scene, truth);
    let allowed_energy = if has_corners || leaves_the_ground(run) {
        ENERGY_OF_IMPACTS
    } else {
        ENERGY
    };
    vec![
        bounded(
            format!("{engine}: gap of the pins"),
            gap,
            gap_allowed(scene.engine.kind),
            "m",
        ),
        Verdict {
            check: format!("{engine}: N >= 0, |T| <= mu_s N"),
            finding: format!("{beyond} of {} records beyond", truth.len()),
            outcome: outcome(beyond == 0),
        },
        bounded(
            format!("{engine}: momentum"),
            momentum_error(robot, truth, &run.balance),
            MOMENTUM,
            "of weight times time",
        ),
        bounded(
            format!("{engine}: energy"),
            energy(robot, truth, &run.balance).relative_error(),
            allowed_energy,
            "of what is turned over",
        ),
    ]
}

/// Records where a force leaves its law.
fn beyond_the_laws(scene: &Scene, truth: &[Truth]) -> usize {
    let stretches = scene.terrain.stretches.iter().map(|s| s.mu_s);
    let mu_s = stretches.fold(scene.friction.mu_s, f64::max);
    let beyond = |t: &&Truth| {
        t.wheels.iter().any(|w| {
            // Of two contacts N is the sum of vectors and T the plain sum: the bound is that of one.
            let slides =
                w.contacts == 1 && w.traction.abs() > mu_s * w.normal_force * (1.0 + 1e-12);
            w.normal_force < 0.0 || slides
        })
    };
    truth.iter().filter(beyond).count()
}

/// Two runs held against each other.
fn compared(what: &str, runs: [&Run; 2], has_corners: bool) -> Vec<Verdict> {
    let [a, b] = runs;
    if a.stopped.is_some() || b.stopped.is_some() {
        return vec![not_judged(what.to_owned(), "a run stopped before its end")];
    }
    let found = agreement(&a.truth, &b.truth);
    let force = if has_corners || leaves_the_ground(a) || leaves_the_ground(b) {
        // N peaks between the records; its impulse does not get lost there.
        let found = match (a.balance.last(), b.balance.last()) {
            (Some(a), Some(b)) => impulse_difference(a, b),
            _ => f64::NAN,
        };
        bounded(
            format!("{what}: impulse on a wheel"),
            found,
            IMPULSE,
            "of itself",
        )
    } else {
        bounded(
            format!("{what}: N"),
            found.normal_force,
            ROLLING,
            "RMS of its mean",
        )
    };
    let apart = bounded(
        format!("{what}: place of the body at the end"),
        found.apart,
        APART,
        "m apart",
    );
    vec![force, apart]
}

/// Whether a wheel is ever in the air, and so lands.
fn leaves_the_ground(run: &Run) -> bool {
    run.truth
        .iter()
        .any(|t| t.wheels.iter().any(|w| w.contacts == 0))
}

fn not_judged(check: String, why: &str) -> Verdict {
    Verdict {
        check,
        finding: why.to_owned(),
        outcome: Outcome::NotJudged,
    }
}

fn outcome(holds: bool) -> Outcome {
    if holds {
        Outcome::Passed
    } else {
        Outcome::Failed
    }
}

fn bounded(check: String, found: f64, allowed: f64, unit: &str) -> Verdict {
    Verdict {
        check,
        finding: format!("{found:.1e} {unit}, at most {allowed:.0e}"),
        // Written so that a NaN fails.
        outcome: outcome(found <= allowed),
    }
}
