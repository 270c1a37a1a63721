//! What truly happens in a scene, and which of it counts.

use robhaz_scene::{Scene, is_compared};
use robhaz_sim::{Plant, PlantError, Truth};

/// Why a scene cannot be studied.
#[derive(Debug, thiserror::Error)]
pub enum CourseError {
    /// The truth of the whole run is kept in memory.
    #[error(
        "the run has {found} samples; a study keeps all in memory and takes at most {MOST_SAMPLES}: shorten it, as with --set record.duration=20"
    )]
    TooLong {
        /// Samples of the scene's sensors.
        found: u64,
    },
    /// The simulation left its range of validity.
    #[error("the simulation stopped")]
    Plant(#[from] PlantError),
    /// No sample counts.
    #[error(
        "nothing to judge: of {compared} samples from {from} s on, every one has a wheel that touches at two places"
    )]
    NothingCounts {
        /// Samples from `record.compare_from` on.
        compared: usize,
        /// `record.compare_from`, s.
        from: f64,
    },
}

/// Samples beyond which a course is refused: about 0.4 GB.
pub const MOST_SAMPLES: u64 = 500_000;

/// The truth at every sample of a scene's sensors. Samples count from `record.compare_from` on, but for those at which a wheel
/// touches at two places: one contact angle is all that an estimator is told of a wheel.
#[derive(Clone, Debug)]
pub struct Course {
    truth: Vec<Truth>,
    counts: Vec<bool>,
    left_out: usize,
}

impl Course {
    /// Simulates a scene with its engine.
    ///
    /// # Errors
    /// [`CourseError`]
    pub fn of(scene: &Scene) -> Result<Self, CourseError> {
        let found = (scene.record_count() - 1) * scene.samples_per_record() + 1;
        if found > MOST_SAMPLES {
            return Err(CourseError::TooLong { found });
        }
        let mut plant = Plant::new(&scene.plant_setup())?;
        let truth: Vec<Truth> = (0..found)
            .map(|_| plant.next_truth())
            .collect::<Result<_, _>>()?;
        let from = scene.record.compare_from;
        let compared = |t: &Truth| is_compared(t.time, from);
        let bridges = |t: &Truth| t.wheels.iter().any(|wheel| wheel.contacts > 1);
        let course = Self {
            counts: truth.iter().map(|t| compared(t) && !bridges(t)).collect(),
            left_out: truth.iter().filter(|t| compared(t) && bridges(t)).count(),
            truth,
        };
        if course.counted() == 0 {
            return Err(CourseError::NothingCounts {
                compared: course.left_out,
                from,
            });
        }
        Ok(course)
    }

    /// Every sample, and whether it counts.
    pub fn samples(&self) -> impl Iterator<Item = (&Truth, bool)> {
        self.truth.iter().zip(self.counts.iter().copied())
    }

    /// How many samples count.
    pub fn counted(&self) -> usize {
        self.counts.iter().filter(|counts| **counts).count()
    }

    /// How many samples would count but for a wheel with two contacts.
    pub fn left_out(&self) -> usize {
        self.left_out
    }
}
