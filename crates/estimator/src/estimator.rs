//! Readings in, wheel forces out: the paper's steps in their order, and the better ones in the same places.

use crate::best::BestFilters;
use crate::estimate::{Estimate, EstimateError};
use crate::flags::Flags;
use crate::frame::{Inputs, SensorFrame};
use crate::paper::PaperFilters;
use crate::saved::{NUMBERS, RestoreError, SavedState};
use crate::settings::{EstimatorSettings, Filters};
use crate::told::{Instant, Told};
use crate::visit::{Visit, visit_fields};
use robhaz_model::Robot;

/// An estimator for one robot: takes a frame of readings after the other.
#[derive(Clone, Debug)]
pub struct Estimator {
    told: Told,
    state: State,
}

/// Everything that one frame hands on to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct State {
    time: f64,
    /// Whether a frame has come.
    started: bool,
    /// Whether every reading has come at least once.
    complete: bool,
    inputs: Inputs,
    filters: FilterState,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "one estimator, one state: nothing is boxed without an allocator"
)]
enum FilterState {
    Paper(PaperFilters),
    Best(BestFilters),
}

impl FilterState {
    /// The robot may be moving already: for a start after a gap. The paper's filters take nothing for granted.
    fn forget_motion(&mut self) {
        if let Self::Best(filters) = self {
            filters.forget_motion();
        }
    }
}

impl Visit for FilterState {
    fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
        match self {
            Self::Paper(filters) => filters.visit(f),
            Self::Best(filters) => filters.visit(f),
        }
    }
}

visit_fields!(State: time, started, complete, inputs, filters);

/// A gap between frames, or between readings of an encoder, beyond which the filters start anew, s.
pub(crate) const LONGEST_GAP: f64 = 0.5;
/// Least time between frames, s: readings divided by less say nothing of a rate.
const SHORTEST_STEP: f64 = 1e-6;

impl State {
    /// Of a robot at rest, before its first frame.
    fn new(robot: &Robot, settings: &EstimatorSettings) -> Self {
        Self {
            time: 0.0,
            started: false,
            complete: false,
            inputs: Inputs::default(),
            filters: filters(robot, settings),
        }
    }
}

impl Estimator {
    /// An estimator for a robot at rest. What is told of the robot may differ from the robot.
    pub fn new(robot: &Robot, settings: EstimatorSettings) -> Self {
        Self {
            told: Told::new(robot, settings),
            state: State::new(robot, &settings),
        }
    }

    /// The choices that it was made with.
    pub fn settings(&self) -> &EstimatorSettings {
        &self.told.settings
    }

    /// The filters of `best`.
    #[cfg(test)]
    pub(crate) fn best_filters(&self) -> Option<&BestFilters> {
        match &self.state.filters {
            FilterState::Best(filters) => Some(filters),
            FilterState::Paper(_) => None,
        }
    }

    /// The state after the last frame, to go on from elsewhere or later.
    pub fn save(&self) -> SavedState {
        let mut numbers = [0.0; NUMBERS];
        let mut places = numbers.iter_mut();
        // Only reads; the copy is what `visit` may change.
        let mut state = self.state;
        state.visit(&mut |number| {
            if let Some(place) = places.next() {
                *place = *number;
            }
        });
        SavedState {
            filters: self.told.settings.filters,
            numbers,
        }
    }

    /// Goes on from a saved state, to the same bits if robot and settings are the same ones.
    ///
    /// # Errors
    /// [`RestoreError::OtherFilters`]; the estimator then stands as it was.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), RestoreError> {
        let own = self.told.settings.filters;
        if saved.filters != own {
            return Err(RestoreError::OtherFilters {
                saved: saved.filters,
                own,
            });
        }
        let mut numbers = saved.numbers.iter();
        self.state.visit(&mut |number| {
            if let Some(found) = numbers.next() {
                *number = *found;
            }
        });
        Ok(())
    }

    /// Takes the readings of one instant and estimates the forces of that instant.
    ///
    /// A missing reading is stood in for by the last good one, and flagged. After a gap of more than 0.5 s the filters start
    /// anew; after a step back of more than 0.5 s (a clock that was set) everything does.
    ///
    /// # Errors
    /// [`EstimateError`]. After [`EstimateError::Time`] the estimator stands as if the frame had not come; after the others it has
    /// taken the readings, and goes on with the next frame.
    pub fn update(&mut self, frame: &SensorFrame) -> Result<Estimate, EstimateError> {
        let mut dt = 0.0;
        if self.state.started {
            dt = frame.time - self.state.time;
        }
        let set_back = dt < -LONGEST_GAP;
        if set_back && frame.time.is_finite() {
            self.state = State::new(&self.told.robot, &self.told.settings);
            self.state.filters.forget_motion();
            dt = 0.0;
        }
        // Written so that a NaN fails too.
        if !(frame.time.is_finite() && (dt >= SHORTEST_STEP || !self.state.started)) {
            return Err(EstimateError::Time {
                last: self.state.time,
                now: frame.time,
            });
        }
        self.state.time = frame.time;
        self.state.started = true;
        let mut flags = self.state.inputs.take(frame, dt);
        if set_back {
            flags |= Flags::SENSOR_STALE;
        }
        if !self.state.complete {
            if let Some(field) = self.state.inputs.never_read() {
                return Err(EstimateError::Missing { field });
            }
            self.state.complete = true;
            dt = 0.0;
        }
        if dt > LONGEST_GAP {
            self.state.filters = filters(&self.told.robot, &self.told.settings);
            self.state.filters.forget_motion();
            flags |= Flags::SENSOR_STALE;
            dt = 0.0;
        }
        let State {
            time,
            inputs,
            filters,
            ..
        } = &mut self.state;
        let instant = Instant {
            time: *time,
            dt,
            inputs,
            flags,
        };
        match filters {
            FilterState::Paper(filters) => filters.estimate(&self.told, &instant),
            FilterState::Best(filters) => filters.estimate(&self.told, &instant),
        }
    }
}

fn filters(robot: &Robot, settings: &EstimatorSettings) -> FilterState {
    match settings.filters {
        Filters::Paper => FilterState::Paper(PaperFilters::new(robot, settings)),
        Filters::Kalman => FilterState::Best(BestFilters::new(robot, &settings.budget)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::LinkReading;
    use crate::testing::Random;

    /// Frames in which everything moves and now and then something is missing, absurd or counts from a new zero.
    fn frames(count: u32) -> impl Iterator<Item = SensorFrame> {
        let mut random = Random::new();
        (0..count).map(move |k| {
            let time = 1e-3 * f64::from(k);
            let mut some = |scale: f64| (k % 7 != 3).then(|| scale * random.normal());
            let mut link = || LinkReading {
                inclination: some(0.01),
                rate: some(0.1),
            };
            let (link1, link2) = (link(), link());
            let zero = if k > 300 { 1000.0 } else { 0.0 };
            SensorFrame {
                time,
                wheel_angle: [0.0, 1.0, zero].map(|start| Some(start + 2.0 * time)),
                motor_torque: [0, 1, 2].map(|_| some(0.5).map(|torque| torque + 0.3)),
                link1,
                link2,
                contact_angle: [0, 1, 2].map(|_| some(0.05)),
            }
        })
    }

    fn settings() -> [EstimatorSettings; 2] {
        [EstimatorSettings::paper_wheels(), EstimatorSettings::best()]
    }

    /// Equivalence: after any frame a fresh estimator that takes up the saved bytes has the whole state, field by field (what
    /// `visit` forgets would differ: the frames change every field), and goes on to the same bits.
    #[test]
    fn a_restored_estimator_goes_on_to_the_same_bits() {
        let robot = Robot::default_a();
        for settings in settings() {
            let mut original = Estimator::new(&robot, settings);
            let mut restored = None;
            for (k, frame) in frames(600).enumerate() {
                let expected = original.update(&frame);
                if let Some(restored) = &mut restored {
                    assert_eq!(Estimator::update(restored, &frame), expected, "frame {k}");
                }
                if [0, 1, 250, 301, 400, 401].contains(&k) {
                    let bytes = original.save().to_bytes();
                    let mut fresh = Estimator::new(&robot, settings);
                    let saved = SavedState::from_bytes(&bytes).expect("just written");
                    fresh.restore(&saved).expect("same filters");
                    assert_eq!(fresh.state, original.state, "frame {k}");
                    assert_eq!(fresh.save(), original.save());
                    restored = Some(fresh);
                }
            }
        }
    }

    /// Every number that `visit` finds has its place: counted, and the larger state fills all places.
    #[test]
    fn the_largest_state_fills_a_saved_one() {
        let count = |settings: EstimatorSettings| {
            let mut count = 0;
            let mut state = State::new(&Robot::default_a(), &settings);
            state.visit(&mut |_| count += 1);
            count
        };
        assert_eq!(count(EstimatorSettings::best()), NUMBERS);
        assert!(count(EstimatorSettings::paper_wheels()) < NUMBERS);
    }

    #[test]
    fn other_filters_are_refused() {
        let [paper, best] = settings().map(|s| Estimator::new(&Robot::default_a(), s));
        let mut other = best.clone();
        assert_eq!(
            other.restore(&paper.save()),
            Err(RestoreError::OtherFilters {
                saved: Filters::Paper,
                own: Filters::Kalman
            })
        );
        assert_eq!(other.state, best.state);
    }
}
