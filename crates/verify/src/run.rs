//! A run of a scene, kept whole.

use robhaz_scene::Scene;
use robhaz_sim::{Balance, Plant, PlantError, Truth};

/// Most records of a run that is verified: a record with its balance is 696 bytes, and three runs are held at once.
pub const MOST_RECORDS: u64 = 500_000;

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
    /// The robot cannot stand at its start: there is no run to judge.
    #[error(transparent)]
    Start(PlantError),
    /// A run stopped before its end, where all of it is needed.
    #[error("engine {engine}: {source}")]
    Stopped {
        /// Which engine.
        engine: &'static str,
        /// Why.
        source: PlantError,
    },
}

/// Truth and balance of a run, record by record, up to its end or to where it stopped.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The truth of each record.
    pub truth: Vec<Truth>,
    /// Impulse and work up to each record.
    pub balance: Vec<Balance>,
    /// Why the run stopped before its end.
    pub stopped: Option<PlantError>,
}

impl Run {
    /// Runs a whole scene, one record a period.
    ///
    /// # Errors
    /// [`VerifyError`]: the run is too long, or the robot cannot stand at its start.
    pub fn of(scene: &Scene) -> Result<Self, VerifyError> {
        let found = scene.record_count();
        if found > MOST_RECORDS {
            return Err(VerifyError::TooLong { found });
        }
        let mut setup = scene.plant_setup();
        setup.period = 1.0 / scene.record.rate;
        setup.balance = true;
        let mut plant = Plant::new(&setup).map_err(VerifyError::Start)?;
        let mut run = Self {
            truth: Vec::new(),
            balance: Vec::new(),
            stopped: None,
        };
        for _ in 0..found {
            match plant.next_truth() {
                Ok(truth) => {
                    run.truth.push(truth);
                    run.balance.extend(plant.balance());
                }
                Err(why) => {
                    run.stopped = Some(why);
                    break;
                }
            }
        }
        Ok(run)
    }
}

/// The truth of a whole scene, record by record.
///
/// # Errors
/// As [`Run::of`], and [`VerifyError::Stopped`] where the run does not reach its end.
pub fn truth_of(scene: &Scene) -> Result<Vec<Truth>, VerifyError> {
    let run = Run::of(scene)?;
    match run.stopped {
        None => Ok(run.truth),
        Some(source) => Err(VerifyError::Stopped {
            engine: scene.engine.kind.name(),
            source,
        }),
    }
}
