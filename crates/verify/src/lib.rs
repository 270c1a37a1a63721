//! Checks that the simulated truth of a scene can be trusted.
//!
//! [`verify`] runs a scene on both engines, with half the step and a second time, and holds the forces against what must
//! hold of them: momentum, energy, the laws' bounds, agreement, repetition. No reference run is needed, so that any scene can be
//! checked. The measures themselves are public: tests use them with bounds of their own.

mod agreement;
mod balance;

pub use agreement::{Agreement, agreement};
pub use balance::{Energy, energy, momentum_error};

use robhaz_scene::{EngineKind, Scene};
use robhaz_sim::{Plant, PlantError, Truth};
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

/// Why a scene cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The truth of the whole run is kept in memory.
    #[error(
        "the run has {found} records; verify keeps all in memory and takes at most {MOST_RECORDS}: shorten it, as with --set record.duration=20"
    )]
    TooLong {
        /// Records of the scene.
        found: u64,
    },
    /// Errors are sums over records, and a record a millisecond resolves the contact.
    #[error(
        "records are {period} s apart; verify needs 1 ms or less, as with --set record.rate=1000"
    )]
    TooCoarse {
        /// Time between records, s.
        period: f64,
    },
    /// A run broke off.
    #[error("engine {engine}: {source}")]
    Run {
        /// Which engine.
        engine: &'static str,
        /// Why.
        source: PlantError,
    },
}

/// Most records of a run that is verified: a record is 608 bytes, and three runs are held at once.
pub const MOST_RECORDS: u64 = 500_000;

/// On rolling ground: N of the engines, RMS over its mean.
const ROLLING: f64 = 1e-3;
/// On edges: impulse of N of a wheel over the run, of itself.
const IMPULSE: f64 = 1e-2;
/// Distance of the bodies at the end, m.
const APART: f64 = 1e-3;
/// Momentum, of weight times time: the rule of the records' sums is good to 1e-7 on the main course.
const MOMENTUM: f64 = 1e-5;
/// Energy, of the motors' work: rapier is of first order in its step.
const ENERGY: f64 = 1e-3;
/// Gap of a pin, m: rapier's joints give way a little; direct closes the loop in closed form.
const fn gap_allowed(kind: EngineKind) -> f64 {
    match kind {
        EngineKind::Rapier => 1e-6,
        EngineKind::Direct => 1e-9,
    }
}

/// The truth of a whole scene, record by record.
///
/// # Errors
/// [`VerifyError`].
pub fn truth_of(scene: &Scene) -> Result<Vec<Truth>, VerifyError> {
    let found = scene.record_count();
    if found > MOST_RECORDS {
        return Err(VerifyError::TooLong { found });
    }
    if scene.record.rate < 999.0 {
        let period = 1.0 / scene.record.rate;
        return Err(VerifyError::TooCoarse { period });
    }
    let mut setup = scene.plant_setup();
    setup.period = 1.0 / scene.record.rate;
    let mut plant = Plant::new(&setup);
    (0..found)
        .map(|_| {
            plant.next_truth().map_err(|source| VerifyError::Run {
                engine: scene.engine.kind.name(),
                source,
            })
        })
        .collect()
}

/// Runs all checks on a scene. `step` is told of what is being done.
///
/// # Errors
/// [`VerifyError`] where there is nothing to judge.
pub fn verify(scene: &Scene, step: &mut dyn FnMut(&str)) -> Result<Vec<Verdict>, VerifyError> {
    let with = |kind| {
        let mut scene = scene.clone();
        scene.engine.kind = kind;
        scene
    };
    let has_edges = Terrain::new(scene.terrain.profile.clone()).has_corners();
    let mut verdicts = Vec::new();
    let mut runs = Vec::new();
    for kind in EngineKind::ALL {
        step(&format!("engine {}", kind.name()));
        let scene = with(kind);
        let truth = truth_of(&scene)?;
        verdicts.extend(alone(&scene, &truth, has_edges));
        step(&format!("engine {}, once more", kind.name()));
        let same = truth_of(&scene)? == truth;
        verdicts.push(Verdict {
            check: format!("{}: a second run", kind.name()),
            finding: if same { "the same bits" } else { "other bits" }.to_owned(),
            outcome: outcome(same),
        });
        runs.push(truth);
    }
    verdicts.extend(compared(
        "the engines",
        &agreement(&runs[0], &runs[1]),
        has_edges,
    ));
    step("engine rapier, half the step");
    let mut halved = with(EngineKind::Rapier);
    halved.engine.step *= 0.5;
    let halved = agreement(&runs[0], &truth_of(&halved)?);
    verdicts.extend(compared("rapier and half its step", &halved, has_edges));
    Ok(verdicts)
}

/// Checks that need one run.
fn alone(scene: &Scene, truth: &[Truth], has_edges: bool) -> Vec<Verdict> {
    let engine = scene.engine.kind.name();
    let mut verdicts = Vec::new();
    let gap = truth.iter().map(|t| t.loop_error).fold(0.0, f64::max);
    let allowed = gap_allowed(scene.engine.kind);
    verdicts.push(bounded(
        format!("{engine}: gap of the pins"),
        gap,
        allowed,
        "m",
    ));
    let beyond = beyond_the_laws(scene, truth);
    verdicts.push(Verdict {
        check: format!("{engine}: N >= 0, |T| <= mu_s N"),
        finding: format!("{beyond} of {} records beyond", truth.len()),
        outcome: outcome(beyond == 0),
    });
    let (momentum, balance) = (format!("{engine}: momentum"), format!("{engine}: energy"));
    if has_edges {
        // Peaks at edges last less than a record; sums over records miss them.
        for check in [momentum, balance] {
            verdicts.push(Verdict {
                check,
                finding: "not resolved by the records: N peaks between them at corners".to_owned(),
                outcome: Outcome::NotJudged,
            });
        }
    } else {
        let of = "of weight times time";
        verdicts.push(bounded(
            momentum,
            momentum_error(scene, truth),
            MOMENTUM,
            of,
        ));
        let energy = energy(scene, truth);
        verdicts.push(if energy.motors > 0.0 {
            bounded(
                balance,
                energy.relative_error().abs(),
                ENERGY,
                "of the motors' work",
            )
        } else {
            Verdict {
                check: balance,
                finding: "the motors do no work".to_owned(),
                outcome: Outcome::NotJudged,
            }
        });
    }
    verdicts
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
fn compared(what: &str, agreement: &Agreement, has_edges: bool) -> Vec<Verdict> {
    let apart = bounded(
        format!("{what}: place of the body at the end"),
        agreement.apart,
        APART,
        "m apart",
    );
    let force = if has_edges {
        bounded(
            format!("{what}: impulse of a wheel's N"),
            agreement.impulse,
            IMPULSE,
            "of itself",
        )
    } else {
        bounded(
            format!("{what}: N"),
            agreement.normal_force,
            ROLLING,
            "RMS of its mean",
        )
    };
    vec![force, apart]
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
