//! The estimator: readings in, wheel forces out.

use crate::door;
use crate::estimate::{Estimate, EstimateError};
use crate::filters::motion::MotionFilter;
use crate::flags::Flags;
use crate::frame::{Gate, Inputs, LONGEST_GAP, SHORTEST_STEP, SensorFrame};
use crate::ground::{FrictionBounds, GroundPoint};
use crate::methods::{Across, KalmanFilters, PaperFilters, SideState, Step};
use crate::nominal::{Instant, Nominal};
use crate::settings::{EstimatorSettings, Method};
use crate::start::Start;
use crate::statics::Forces;
use crate::torque_scale::{Rolling, ScaleFilter};
use robhaz_model::{Robot, Units, Vec2};

/// An estimator for one robot. It takes one frame of readings after the other.
#[derive(Clone, Debug)]
pub struct Estimator {
    /// Units of all that follows.
    units: Units,
    nominal: Nominal,
    /// Time of the last frame, s; `None` before the first.
    time: Option<f64>,
    /// Whether each reading has been known at least once.
    complete: bool,
    inputs: Inputs,
    start: Start,
    filters: Filters,
}

/// An instant of a side of a whole rover, before its forces are known.
pub(crate) struct SideStep {
    pub state: SideState,
    step: Step,
    time: f64,
    /// In the filters' units.
    pub dt: f64,
    flags: Flags,
}

/// Time that counts as passed when it is not known, s: a gap.
/// Definition.
const UNKNOWN_TIME: f64 = 2.0 * LONGEST_GAP;

#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "no allocator to box one")]
enum Filters {
    Paper(PaperFilters),
    Kalman(KalmanFilters),
}

impl Filters {
    /// Of a robot at rest.
    fn new(nominal: &Nominal) -> Self {
        let (robot, settings) = (&nominal.robot, &nominal.settings);
        match &settings.method {
            Method::Paper(method) => Self::Paper(PaperFilters::new(robot, method, settings)),
            Method::Kalman(method) => {
                Self::Kalman(KalmanFilters::new(robot, *method, &settings.budget))
            }
        }
    }

    /// Starts anew after a gap: the robot may be moving, and the section of the ground ends. The
    /// paper's filters do not assume rest.
    fn start_anew(&mut self, nominal: &Nominal) {
        let mut fresh = Self::new(nominal);
        if let (Self::Kalman(fresh), Self::Kalman(before)) = (&mut fresh, &*self) {
            fresh.take_over(before);
        }
        *self = fresh;
    }
}

impl Estimator {
    /// An estimator for a robot at rest, from its nominal geometry and masses.
    pub fn new(robot: &Robot, settings: EstimatorSettings) -> Self {
        let units = Units::of(robot);
        let settings = door::settings_in(&units, &settings);
        let nominal = Nominal::new(&units.robot_in(robot), settings);
        Self {
            units,
            time: None,
            complete: false,
            inputs: Inputs::default(),
            start: Start::new(nominal.settings.budget.inclination_noise),
            filters: Filters::new(&nominal),
            nominal,
        }
    }

    /// The filters of `kalman`.
    pub(crate) fn kalman_filters(&self) -> Option<&KalmanFilters> {
        match &self.filters {
            Filters::Kalman(filters) => Some(filters),
            Filters::Paper(_) => None,
        }
    }

    /// Takes the readings of one instant and estimates the forces of that instant.
    ///
    /// Times below are those of robot A on Earth; a robot of another size, or on another planet,
    /// has them times sqrt(r/g) over A's. The last good value stands in for a missing reading, and
    /// a flag says so. After a gap of more than 0.5 s the filters start anew; after a step back of
    /// more than 0.5 s (a clock that was set) everything does. Where all wheels have turned further
    /// than they can since the last frame, the clock was set back by less: `kalman` takes the time
    /// from their speeds, as for lost frames, and a flag says so.
    ///
    /// # Errors
    /// [`EstimateError`]. After [`EstimateError::Time`] the estimator is unchanged. After the other
    /// errors it has taken the readings, and continues with the next frame.
    pub fn update(&mut self, frame: &SensorFrame) -> Result<Estimate, EstimateError> {
        let mut found = self.update_in_units(&door::frame_in(&self.units, frame));
        match &mut found {
            Ok(estimate) => door::estimate_out(&self.units, estimate, frame.time),
            Err(EstimateError::Time { last, now }) => {
                (*last, *now) = (*last * self.units.time, frame.time);
            }
            Err(_) => {}
        }
        found
    }

    fn update_in_units(&mut self, frame: &SensorFrame) -> Result<Estimate, EstimateError> {
        let (dt, flags) = self.read(frame)?;
        let instant = Instant {
            nominal: &self.nominal,
            dt,
            inputs: &self.inputs,
            flags,
        };
        match &mut self.filters {
            Filters::Paper(filters) => filters.estimate(&instant),
            Filters::Kalman(filters) => filters.estimate(&instant),
        }
    }

    /// Takes the readings of a frame. Returns the time since the last one (s; 0 where filters start)
    /// and the flags of the readings.
    fn read(&mut self, frame: &SensorFrame) -> Result<(f64, Flags), EstimateError> {
        let (mut dt, mut flags) = self.advance_clock(frame.time)?;
        let set_back = flags.contains(Flags::SENSOR_STALE);
        let frame = &self.inputs.without_repeats(frame, dt);
        let nominal = &self.nominal;
        // Where it contradicts the time stamps. The paper's filters use these.
        let by_wheels = self
            .kalman_filters()
            .and_then(|filters| filters.time_of_wheels(nominal, &self.inputs, frame, dt));
        if let Some(time) = by_wheels {
            flags |= Flags::SENSOR_STALE;
            dt = if time.is_finite() { time } else { UNKNOWN_TIME };
        }
        let found = self
            .kalman_filters()
            .and_then(|filters| filters.speed_at_found_link(&self.nominal.robot.geometry, frame));
        flags |= Flags::SENSOR_STALE.when(found.is_some());
        let interrupted = dt > LONGEST_GAP || set_back || found.is_some();
        let (noise, moves) = self.start.take(frame.time, &frame.wheel_angle, interrupted);
        let moves = moves.or(found);
        self.nominal.settings.budget.inclination_noise = noise;
        let nominal = &self.nominal;
        let with_angles = nominal.settings.needs_contact_angles();
        let gate = Gate::new(&nominal.settings.budget, &nominal.robot);
        flags |= self.inputs.take(frame, dt, &gate, with_angles);
        if !self.complete {
            if let Some(field) = self.inputs.never_read(with_angles) {
                self.start.wait();
                return Err(EstimateError::Missing { field });
            }
            self.complete = true;
            dt = 0.0;
        }
        flags |= Flags::SENSOR_STALE.when(dt > LONGEST_GAP);
        let carried = match &mut self.filters {
            Filters::Kalman(filters) => filters.is_carried(&self.inputs),
            Filters::Paper(_) => false,
        };
        flags |= Flags::SENSOR_STALE.when(carried);
        if dt > LONGEST_GAP || moves.is_some() || carried {
            self.filters.start_anew(nominal);
            dt = 0.0;
        }
        if let (Some(speed), Filters::Kalman(filters)) = (moves, &mut self.filters) {
            filters.motion.assume_velocity(Vec2::new(speed, 0.0));
        }
        Ok((dt, flags))
    }

    /// For a side of a whole rover that is carried: the filters start anew with the next frame.
    pub(crate) fn start_anew(&mut self) {
        self.filters.start_anew(&self.nominal);
        self.complete = false;
    }

    /// For a side of a whole rover: advances the filters of `kalman` to a frame (SI), up to the
    /// equations of the forces. `across` is in SI.
    pub(crate) fn advance(
        &mut self,
        frame: &SensorFrame,
        across: &Across,
    ) -> Result<SideStep, EstimateError> {
        let (dt, flags) = self.read(&door::frame_in(&self.units, frame))?;
        let instant = Instant {
            nominal: &self.nominal,
            dt,
            inputs: &self.inputs,
            flags,
        };
        let Filters::Kalman(filters) = &mut self.filters else {
            return Err(EstimateError::Singular);
        };
        let (speed, length) = (self.units.speed(), self.units.length);
        filters.across = Across {
            velocity: across.velocity.map(|velocity| velocity / speed),
            place: across.place.map(|place| place / length),
            slope: across.slope,
            of_sensor: across.of_sensor * self.units.time / speed,
            follow: across.follow,
            shares: across.shares,
            slip: across.slip.map(|slip| slip / speed),
            settled: across.settled,
            turns: false,
            trailing: across.trailing,
        };
        let step = filters.advance(&instant)?;
        Ok(SideStep {
            state: filters.side_state(&self.units, &self.nominal, &self.inputs, &step),
            step,
            time: frame.time,
            dt,
            flags,
        })
    }

    /// The motion filter of a side of a whole rover.
    pub(crate) fn motion(&mut self) -> Option<&mut MotionFilter> {
        match &mut self.filters {
            Filters::Kalman(filters) => Some(&mut filters.motion),
            Filters::Paper(_) => None,
        }
    }

    /// For the torques of a whole rover, by the mean of both sides, against its weight, in the units of
    /// the filters. `trailing`: see [`Across`].
    pub(crate) fn scale_filter(&self, trailing: usize) -> ScaleFilter {
        KalmanFilters::scale_filter(&self.nominal, trailing)
    }

    /// How a side rolls, as of its last estimate, in the units of the filters.
    pub(crate) fn rolling(&self) -> Option<&Rolling> {
        self.kalman_filters()?.rolling.as_ref()
    }

    /// The weight of a side, in the units of the filters, and the relative error of its mass.
    pub(crate) fn weight(&self) -> (f64, f64) {
        (3.0 * self.nominal.mean_load, self.nominal.mass_sigma)
    }

    /// Takes the state of a side anew, after its motion filter was corrected.
    pub(crate) fn retake(&self, side: &mut SideStep) {
        if let Some(filters) = self.kalman_filters() {
            filters.retake(&self.nominal, &mut side.step);
            side.state = filters.side_state(&self.units, &self.nominal, &self.inputs, &side.step);
        }
    }

    /// The estimate of a side after [`Self::advance`], for the forces (N) of the whole rover.
    pub(crate) fn conclude(&mut self, side: SideStep, mut forces: Forces) -> Option<Estimate> {
        let Filters::Kalman(filters) = &mut self.filters else {
            return None;
        };
        forces.scale(1.0 / self.units.force());
        let instant = Instant {
            nominal: &self.nominal,
            dt: side.dt,
            inputs: &self.inputs,
            flags: side.flags,
        };
        let mut estimate = filters.conclude(&instant, side.step, forces);
        door::estimate_out(&self.units, &mut estimate, side.time);
        Some(estimate)
    }

    /// The ground in memory, from rear to front: what the wheels have passed since they were about
    /// as far apart as they are now, a little more than the robot's length. A point is there as
    /// soon as the first wheel has passed it. Later wheels correct it until it leaves the memory:
    /// see [`Self::completed_ground`]. The paper's methods have none.
    ///
    /// Points are at equal distances of the axles along x, 10 mm for the default robot. Places that no
    /// wheel has touched, such as the foot of a kerb, have none.
    pub fn ground(&self) -> impl Iterator<Item = GroundPoint> + '_ {
        let points = self
            .kalman_filters()
            .into_iter()
            .flat_map(|f| f.ground.points());
        points.map(|point| door::point_out(&self.units, point))
    }

    /// The points of the ground that left the memory with the last update, in their final form. All
    /// wheels have passed them. To keep the whole profile, append them after every update, and
    /// [`Self::ground`] at the end.
    ///
    /// A robot that comes back to a place gives its points again.
    pub fn completed_ground(&self) -> impl Iterator<Item = GroundPoint> + '_ {
        let points = self
            .kalman_filters()
            .into_iter()
            .flat_map(|f| f.ground.completed());
        points.map(|point| door::point_out(&self.units, point))
    }

    /// Angle of the ground under a wheel whose axle is at a place along the path (m), rad, and its standard
    /// deviation for a wheel that comes there now. `None` where the ground is not in memory.
    pub fn ground_slope(&self, x: f64) -> Option<(f64, f64)> {
        self.kalman_filters()?
            .ground
            .slope_at(x / self.units.length)
    }

    /// Bounds of the friction under a wheel whose axle is at a place along the path (m), in the frame of
    /// [`Self::ground`]. `None` from the paper's methods.
    pub fn friction_at(&self, x: f64) -> Option<FrictionBounds> {
        let memory = &self.kalman_filters()?.ground;
        Some(memory.friction_at(x / self.units.length))
    }

    /// Places of the axles of front, middle and rear wheel along the path, m, in the frame of
    /// [`Self::ground`]. `None` before the robot has moved, and from the paper's methods.
    pub fn wheel_places(&self) -> Option<[f64; 3]> {
        let places = self.kalman_filters()?.ground.wheel_places()?;
        Some(places.map(|place| place * self.units.length))
    }

    /// Sets the time of a frame, s. Returns the time since the last frame (s; 0 at the first), and
    /// the flag of a clock that was set back.
    fn advance_clock(&mut self, now: f64) -> Result<(f64, Flags), EstimateError> {
        let mut dt = self.time.map_or(0.0, |last| now - last);
        let set_back = dt < -LONGEST_GAP && now.is_finite();
        if set_back {
            (self.complete, self.inputs) = (false, Inputs::default());
            self.filters.start_anew(&self.nominal);
            dt = 0.0;
        } else if let Some(last) = self.time {
            // Written so that a NaN fails too.
            if !(now.is_finite() && dt >= SHORTEST_STEP) {
                return Err(EstimateError::Time { last, now });
            }
            if let Filters::Kalman(filters) = &mut self.filters {
                filters.ground.drop_left();
            }
        } else if !now.is_finite() {
            return Err(EstimateError::Time { last: 0.0, now });
        }
        self.time = Some(now);
        Ok((dt, Flags::SENSOR_STALE.when(set_back)))
    }
}
