//! Checks whether the simulated truth of a scene can be trusted.
//!
//! [`verify`] runs a scene with both engines, with half the step, and a second time. It checks
//! momentum, energy, the bounds of the laws, the agreement of the runs, and repetition. It needs no
//! reference run, so it can check any scene. Momentum and energy are checked with the impulses and
//! the work that the engines integrate at their own steps; impacts between records are therefore
//! included. The measures are public, so that tests can use them with their own limits.

mod balance;
mod run;

pub use balance::{Agreement, Energy, agreement, energy, impulse_difference, momentum_error};
pub use run::Run;

use crate::{Result, Stop, TruthClearance};
use robhaz_model::Bar;
use robhaz_scene::{EngineKind, PlantFailure, Scene};
use robhaz_sim::Truth;
use serde::Serialize;

/// Result of one check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Name of the check.
    pub check: String,
    /// The measured value with its unit and limit, or the reason why the check does not apply.
    pub finding: String,
    /// Whether the value is within its limit; `None` where the check does not apply to this scene.
    pub passed: Option<bool>,
}

/// Limit without impacts: RMS difference of N between two runs, relative to the mean of N.
const ROLLING: f64 = 1e-3;
/// Limit with impacts: difference of the ground's impulse on a wheel over the run, relative to this
/// impulse.
const IMPULSE: f64 = 1e-2;
/// Limit of the distance between the bodies of two runs at the end, m.
const APART: f64 = 1e-3;
/// Limit of the momentum error, relative to weight times time. The error of direct is 1e-8 at its
/// default tolerance and 3.5e-6 at its largest; that of rapier is rounding.
const MOMENTUM: f64 = 1e-5;
/// Limit of the energy error without impacts, relative to its scale. The error of rapier is of
/// first order in the step: 1e-5.
const ENERGY: f64 = 1e-3;
/// Limit of the energy error with impacts, relative to its scale. The error of rapier is 4e-4 on
/// the shipped trench and 1.4e-3 there at 3 m/s, half as much with half the step; that of direct is
/// 1e-7.
const ENERGY_OF_IMPACTS: f64 = 3e-3;
/// Limit of the gap of a pin, m. The joints of rapier are slightly compliant; direct closes the
/// loop analytically.
const fn gap_allowed(kind: EngineKind) -> f64 {
    match kind {
        EngineKind::Rapier => 1e-6,
        EngineKind::Direct => 1e-9,
    }
}

/// Runs all checks on a scene. `step` receives the name of each step as it begins.
///
/// If a run stops before its end, one check fails with the reason; the other checks judge the run
/// up to this time. A scene that is too stiff for `rapier` is judged by `direct` alone, with a
/// second run at a tenth of the tolerance.
///
/// # Errors
/// [`RunError`](crate::RunError) if there is no run to judge, or `stop` names a cause.
pub fn verify(scene: &Scene, step: &mut dyn FnMut(&str), stop: Stop<'_>) -> Result<Vec<Verdict>> {
    let has_corners = scene.terrain.build(&scene.robot.robot).has_corners();
    let mut verdicts = Vec::new();
    let mut engine = |kind| of_engine(scene, kind, has_corners, step, &mut verdicts, stop);
    if let Some(why) = scene.too_stiff_for_rapier() {
        let direct = engine(EngineKind::Direct)?;
        verdicts.insert(0, verdict("rapier: all checks", why, None));
        step("engine direct, a tenth of the tolerance");
        let mut finer = with(scene, EngineKind::Direct);
        finer.engine.tolerance *= 0.1;
        let finer = Run::until(&finer, stop)?;
        let what = "direct and a tenth of its tolerance";
        verdicts.extend(compared(what, [&direct, &finer], has_corners));
        return Ok(verdicts);
    }
    let rapier = engine(EngineKind::Rapier)?;
    let direct = engine(EngineKind::Direct)?;
    verdicts.extend(compared("the engines", [&rapier, &direct], has_corners));
    // Two runs in memory are enough.
    drop(direct);
    step("engine rapier, half the step");
    let mut halved = with(scene, EngineKind::Rapier);
    halved.engine.step *= 0.5;
    let halved = Run::until(&halved, stop)?;
    if rapier.stopped.is_none() {
        verdicts.push(reaches_its_end("rapier with half its step", &halved));
    }
    let what = "rapier and half its step";
    verdicts.extend(compared(what, [&rapier, &halved], has_corners));
    Ok(verdicts)
}

/// The scene with another engine.
fn with(scene: &Scene, kind: EngineKind) -> Scene {
    let mut scene = scene.clone();
    scene.engine.kind = kind;
    scene
}

/// Runs a scene with an engine and appends the verdicts on this run.
fn of_engine(
    scene: &Scene,
    kind: EngineKind,
    has_corners: bool,
    step: &mut dyn FnMut(&str),
    verdicts: &mut Vec<Verdict>,
    stop: Stop<'_>,
) -> Result<Run> {
    let name = kind.name();
    step(&format!("engine {name}"));
    let scene = with(scene, kind);
    let run = Run::until(&scene, stop)?;
    verdicts.push(reaches_its_end(name, &run));
    verdicts.extend(alone(&scene, &run, has_corners));
    step(&format!("engine {name}, once more"));
    let same = run.repeats(&scene, stop)?;
    let bits = if same { "the same" } else { "different" };
    let check = format!("{name}: a second run");
    verdicts.push(verdict(check, format!("{bits} bits"), same));
    Ok(run)
}

/// Checks that a run was not stopped.
fn reaches_its_end(name: &str, run: &Run) -> Verdict {
    let finding = match &run.stopped {
        None => format!("{} s", run.truth.last().map_or(0.0, |t| t.time)),
        Some(why) => PlantFailure::from(*why).to_string(),
    };
    let check = format!("{name}: runs to its end");
    verdict(check, finding, run.stopped.is_none())
}

/// Checks of a single run.
fn alone(scene: &Scene, run: &Run, has_corners: bool) -> Vec<Verdict> {
    let engine = scene.engine.kind.name();
    let (truth, robot) = (&run.truth, &scene.robot.robot);
    // Changes need two records.
    if truth.len() < 2 {
        let check = format!("{engine}: all other checks");
        return vec![verdict(check, "the run stopped at once", None)];
    }
    let gap = truth.iter().map(|t| t.loop_error).fold(0.0, f64::max);
    let beyond = beyond_the_laws(scene, truth);
    let mut meter = TruthClearance::of(scene);
    let clearances = truth.iter().map(|t| meter.at(t));
    let (bar, clearance) = clearances.fold((Bar::Body, f64::INFINITY), |least, found| {
        let found = found.least;
        if found.1 < least.1 { found } else { least }
    });
    let check = |what: &str| format!("{engine}: {what}");
    let is_clear = clearance > 0.0;
    let clear = format!("at least {:.0} mm, {}", 1e3 * clearance, bar.name());
    let outside = format!("{beyond} of {} records outside", truth.len());
    let momentum = momentum_error(robot, truth, &run.balance);
    let (of_momentum, of_energy) = ("relative to weight times time", "relative to its scale");
    let energy = energy(robot, truth, &run.balance).relative_error;
    let gap_limit = gap_allowed(scene.engine.kind);
    let energy_limit = match has_corners || leaves_the_ground(run) {
        true => ENERGY_OF_IMPACTS,
        false => ENERGY,
    };
    vec![
        bounded(check("gap of the pins"), gap, gap_limit, "m"),
        verdict(check("body and links clear of the ground"), clear, is_clear),
        verdict(check("N >= 0, |T| <= mu_s N"), outside, beyond == 0),
        bounded(check("momentum"), momentum, MOMENTUM, of_momentum),
        bounded(check("energy"), energy, energy_limit, of_energy),
    ]
}

/// Number of records in which a force at a contact violates its law.
fn beyond_the_laws(scene: &Scene, truth: &[Truth]) -> usize {
    let stretches = scene.terrain.stretches.iter().map(|s| s.mu_s);
    let mu_s = stretches.fold(scene.friction.mu_s, f64::max);
    let beyond = |t: &&Truth| {
        let mut contacts = t.wheels.iter().flat_map(|w| w.contact_list.iter());
        // The factor allows rounding.
        contacts.any(|c| {
            c.normal_force < 0.0 || c.traction.abs() > mu_s * c.normal_force * (1.0 + 1e-12)
        })
    };
    truth.iter().filter(beyond).count()
}

/// Checks of the agreement of two runs.
fn compared(what: &str, runs: [&Run; 2], has_corners: bool) -> Vec<Verdict> {
    let [a, b] = runs;
    if a.stopped.is_some() || b.stopped.is_some() {
        return vec![verdict(what, "a run stopped before its end", None)];
    }
    let found = agreement(&a.truth, &b.truth);
    let force = if has_corners || leaves_the_ground(a) || leaves_the_ground(b) {
        // Records miss the peaks of N; the integrated impulse contains them.
        let ends = a.balance.last().zip(b.balance.last());
        let found = ends.map_or(f64::NAN, |(a, b)| impulse_difference(a, b));
        let check = format!("{what}: impulse on a wheel");
        bounded(check, found, IMPULSE, "relative")
    } else {
        let (check, unit) = (format!("{what}: N"), "RMS, relative to its mean");
        bounded(check, found.normal_force, ROLLING, unit)
    };
    let check = format!("{what}: distance of the bodies at the end");
    vec![force, bounded(check, found.apart, APART, "m")]
}

/// Whether a wheel is in the air in any record. It then lands with an impact.
fn leaves_the_ground(run: &Run) -> bool {
    let mut wheels = run.truth.iter().flat_map(|t| &t.wheels);
    wheels.any(|wheel| wheel.contacts == 0)
}

fn verdict(
    check: impl Into<String>,
    finding: impl Into<String>,
    passed: impl Into<Option<bool>>,
) -> Verdict {
    Verdict {
        check: check.into(),
        finding: finding.into(),
        passed: passed.into(),
    }
}

/// A check of a value (in `unit`) against its upper limit.
fn bounded(check: String, found: f64, allowed: f64, unit: &str) -> Verdict {
    let finding = format!("{found:.1e} {unit}, at most {allowed:.0e}");
    // In this form a NaN fails.
    verdict(check, finding, found <= allowed)
}
