//! A run of a scene, kept in memory.

use robhaz_scene::{PlantFailure, Scene};
use robhaz_sim::{Balance, Plant, PlantError, Truth};

/// Largest number of records of a run that is verified. A record with its balance has about 0.7 kB, and three runs are in memory at
/// once.
pub const MOST_RECORDS: u64 = 500_000;

/// Reason why a scene cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The run has too many records to be kept in memory.
    #[error(
        "the run has {found} records; verify keeps all in memory and takes at most {MOST_RECORDS}: shorten it, as with --set record.duration=20"
    )]
    TooLong {
        /// Number of records of the scene.
        found: u64,
    },
    /// The robot cannot stand at its start. There is no run to judge.
    #[error(transparent)]
    Start(PlantFailure),
    /// A run stopped before its end, but the whole run is needed.
    #[error("the run of engine {engine} stopped")]
    Stopped {
        /// Name of the engine.
        engine: &'static str,
        /// The reason.
        source: PlantFailure,
    },
}

/// Truth and balance of a run at each record, up to its end or until it stopped.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The truth at each record.
    pub truth: Vec<Truth>,
    /// Impulse and work up to each record.
    pub balance: Vec<Balance>,
    /// Reason why the run stopped before its end.
    pub stopped: Option<PlantError>,
}

impl Run {
    /// Runs a whole scene, with one record per period.
    ///
    /// # Errors
    /// [`VerifyError::TooLong`] and [`VerifyError::Start`].
    pub fn of(scene: &Scene) -> Result<Self, VerifyError> {
        let found = scene.record_count();
        if found > MOST_RECORDS {
            return Err(VerifyError::TooLong { found });
        }
        let mut setup = scene.plant_setup();
        setup.period = 1.0 / scene.record.rate;
        setup.balance = true;
        let mut plant =
            Plant::new(&setup).map_err(|cause| VerifyError::Start(PlantFailure::from(cause)))?;
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

/// The truth of a whole scene at each record.
///
/// # Errors
/// As [`Run::of`], and [`VerifyError::Stopped`] if the run does not reach its end.
pub fn truth_of(scene: &Scene) -> Result<Vec<Truth>, VerifyError> {
    let run = Run::of(scene)?;
    match run.stopped {
        None => Ok(run.truth),
        Some(cause) => Err(VerifyError::Stopped {
            engine: scene.engine.kind.name(),
            source: PlantFailure::from(cause),
        }),
    }
}
