//! The estimator: readings in, wheel forces out.

use crate::door::Door;
use crate::estimate::{Estimate, EstimateError};
use crate::flags::Flags;
use crate::frame::{Inputs, Instant, LONGEST_GAP, SHORTEST_STEP, SensorFrame};
use crate::ground::{FrictionBounds, GroundMemory, GroundPoint};
use crate::methods::{BestFilters, PaperFilters};
use crate::nominal::Nominal;
use crate::settings::{EstimatorSettings, Method};
use robhaz_model::Robot;

/// An estimator for one robot. It takes one frame of readings after the other.
#[derive(Clone, Debug)]
pub struct Estimator {
    settings: EstimatorSettings,
    /// Units of all that follows.
    door: Door,
    nominal: Nominal,
    state: State,
}

/// Time that counts as passed when it is not known, s: a gap.
/// Definition.
const UNKNOWN_TIME: f64 = 2.0 * LONGEST_GAP;

/// The state from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct State {
    time: f64,
    /// Whether there has been a frame.
    started: bool,
    /// Whether each reading has been known at least once.
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
    /// For a start after a gap: the robot may be moving, and the section of the ground of `before`
    /// ends. The paper's filters do not assume rest.
    fn start_after(&mut self, before: &Self) {
        if let (Self::Best(filters), Self::Best(before)) = (self, before) {
            filters.reset_motion();
            filters.take_over(before);
        }
    }

    fn drop_left_ground(&mut self) {
        if let Self::Best(filters) = self {
            filters.drop_left_ground();
        }
    }

    fn ground(&self) -> Option<&GroundMemory> {
        match self {
            Self::Paper(_) => None,
            Self::Best(filters) => Some(filters.ground()),
        }
    }
}

impl State {
    /// For a robot at rest, before its first frame.
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

impl State {
    /// Time since the last frame by the wheels, s, where it contradicts the `dt` (s) of the time
    /// stamps. The paper's filters use the time stamps.
    fn time_of_wheels(&self, nominal: &Nominal, frame: &SensorFrame, dt: f64) -> Option<f64> {
        let FilterState::Best(filters) = &self.filters else {
            return None;
        };
        let time = filters.time_of_wheels(nominal, &self.inputs, frame, dt)?;
        Some(if time.is_finite() { time } else { UNKNOWN_TIME })
    }
}

impl Estimator {
    /// An estimator for a robot at rest, from its nominal geometry and masses.
    pub fn new(robot: &Robot, settings: EstimatorSettings) -> Self {
        let door = Door::of(robot);
        let nominal = Nominal::new(&door.robot_in(robot), door.settings_in(&settings));
        Self {
            settings,
            door,
            state: State::new(&nominal.robot, &nominal.settings),
            nominal,
        }
    }

    /// Its settings.
    pub fn settings(&self) -> &EstimatorSettings {
        &self.settings
    }

    /// The filters of `best`.
    #[cfg(test)]
    pub(crate) fn best_filters(&self) -> Option<&BestFilters> {
        match &self.state.filters {
            FilterState::Best(filters) => Some(filters),
            FilterState::Paper(_) => None,
        }
    }

    /// Takes the readings of one instant and estimates the forces of that instant.
    ///
    /// Times below are those of robot A on Earth; a robot of another size, or on another planet,
    /// has them times sqrt(r/g) over A's. The last good value stands in for a missing reading, and
    /// a flag says so. After a gap of more than 0.5 s the filters start anew; after a step back of
    /// more than 0.5 s (a clock that was set) everything does. Where all wheels have turned further
    /// than they can since the last frame, the clock was set back by less: `best` takes the time
    /// from their speeds, as for lost frames, and a flag says so.
    ///
    /// # Errors
    /// [`EstimateError`]. After [`EstimateError::Time`] the estimator is unchanged. After the other
    /// errors it has taken the readings, and continues with the next frame.
    pub fn update(&mut self, frame: &SensorFrame) -> Result<Estimate, EstimateError> {
        let mut found = self.update_in_units(&self.door.frame_in(frame));
        match &mut found {
            Ok(estimate) => self.door.estimate_out(estimate, frame.time),
            Err(EstimateError::Time { last, now }) => {
                (*last, *now) = (self.door.time_out(*last), frame.time);
            }
            Err(_) => {}
        }
        found
    }

    fn update_in_units(&mut self, frame: &SensorFrame) -> Result<Estimate, EstimateError> {
        let (mut dt, mut flags) = self.advance_clock(frame.time)?;
        if let Some(time) = self.state.time_of_wheels(&self.nominal, frame, dt) {
            flags |= Flags::SENSOR_STALE;
            dt = time;
        }
        let with_angles = self.nominal.settings.needs_contact_angles();
        flags |= self.state.inputs.take(frame, dt, with_angles);
        if !self.state.complete {
            if let Some(field) = self.state.inputs.never_read(with_angles) {
                return Err(EstimateError::Missing { field });
            }
            self.state.complete = true;
            dt = 0.0;
        }
        if dt > LONGEST_GAP {
            let mut fresh = filters(&self.nominal.robot, &self.nominal.settings);
            fresh.start_after(&self.state.filters);
            self.state.filters = fresh;
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
            FilterState::Paper(filters) => filters.estimate(&self.nominal, &instant),
            FilterState::Best(filters) => filters.estimate(&self.nominal, &instant),
        }
    }

    /// The ground in memory, from rear to front: what the wheels have passed since they were about
    /// as far apart as they are now, a little more than the robot's length. A point is there as
    /// soon as the first wheel has passed it. Later wheels correct it until it leaves the memory:
    /// see [`Self::completed_ground`]. The paper's methods have none.
    ///
    /// Points are at equal distances along x, 10 mm for the default robot. Places that no wheel has
    /// touched, such as the foot of a kerb, have none.
    pub fn ground(&self) -> impl Iterator<Item = GroundPoint> + '_ {
        let memory = self.state.filters.ground();
        let points = memory.into_iter().flat_map(GroundMemory::points);
        points.map(|point| self.door.point_out(point))
    }

    /// The points of the ground that left the memory with the last update, in their final form. All
    /// wheels have passed them. To keep the whole profile, append them after every update, and
    /// [`Self::ground`] at the end.
    ///
    /// A robot that comes back to a place gives its points again.
    pub fn completed_ground(&self) -> impl Iterator<Item = GroundPoint> + '_ {
        let memory = self.state.filters.ground();
        let points = memory.into_iter().flat_map(GroundMemory::completed);
        points.map(|point| self.door.point_out(point))
    }

    /// Angle of the ground at a place along the path (m), rad, and its standard deviation for a
    /// wheel that comes to that place now. `None` where the ground is not in memory.
    pub fn ground_slope(&self, x: f64) -> Option<(f64, f64)> {
        let x = self.door.length_in(x);
        self.state.filters.ground()?.slope_at(x)
    }

    /// Bounds of the friction at a place along the path (m), in the frame of [`Self::ground`].
    /// `None` from the paper's methods.
    pub fn friction_at(&self, x: f64) -> Option<FrictionBounds> {
        let x = self.door.length_in(x);
        Some(self.state.filters.ground()?.friction_at(x))
    }

    /// Places of the contacts of front, middle and rear wheel along the path, m, in the frame of
    /// [`Self::ground`]. `None` before the robot has moved, and from the paper's methods.
    pub fn wheel_places(&self) -> Option<[f64; 3]> {
        let places = self.state.filters.ground()?.wheel_places()?;
        Some(places.map(|place| self.door.length_out(place)))
    }

    /// Sets the time of a frame, s. Returns the time since the last frame (s; 0 at the first), and
    /// the flag of a clock that was set back.
    fn advance_clock(&mut self, now: f64) -> Result<(f64, Flags), EstimateError> {
        let last = self.state.time;
        let mut dt = if self.state.started { now - last } else { 0.0 };
        let mut flags = Flags::NONE;
        if dt < -LONGEST_GAP && now.is_finite() {
            let mut fresh = State::new(&self.nominal.robot, &self.nominal.settings);
            fresh.filters.start_after(&self.state.filters);
            self.state = fresh;
            flags = Flags::SENSOR_STALE;
            dt = 0.0;
        }
        // Written so that a NaN fails too.
        if !(now.is_finite() && (dt >= SHORTEST_STEP || !self.state.started)) {
            return Err(EstimateError::Time { last, now });
        }
        if self.state.started {
            self.state.filters.drop_left_ground();
        }
        self.state.time = now;
        self.state.started = true;
        Ok((dt, flags))
    }
}

/// Filters of a robot at rest.
fn filters(robot: &Robot, settings: &EstimatorSettings) -> FilterState {
    match &settings.method {
        Method::Paper(method) => FilterState::Paper(PaperFilters::new(robot, method, settings)),
        Method::Kalman(method) => {
            FilterState::Best(BestFilters::new(robot, *method, &settings.budget))
        }
    }
}
