//! What a frame brings: its clock, the readings that there are, and whether the filters start anew.

use super::WholeEstimator;
use super::misfit::MeanMisfit;
use crate::estimate::EstimateError;
use crate::filters::LinkAngleKalman;
use crate::flags::Flags;
use crate::frame::{BodyInputs, LARGEST_TORQUE, LONGEST_GAP, SHORTEST_STEP, limit};
use crate::start::Carried;
use crate::whole::readings::WholeFrame;
use robhaz_model::Vec2;

impl WholeEstimator {
    /// The frame with the rates of its attitude, without the readings of a body's sensor that gives the same numbers over
    /// and over, and without a rate that does: a gyroscope has noise, where an angle may rest.
    pub(super) fn read_body(&mut self, mut frame: WholeFrame, dt: f64) -> WholeFrame {
        let [p, q, r] = frame.rates;
        let numbers = [frame.inclination, frame.roll, p, q, r];
        let turns = !self.sliding.stands();
        if self.repeats.take(numbers, dt / self.units.time, turns) {
            (frame.inclination, frame.roll, frame.rates) = (None, None, [None; 3]);
        }
        let noise = self.settings.budget.rate_noise;
        let dt = if turns { dt / self.units.time } else { 0.0 };
        for (hangs, rate) in self.hung.iter_mut().zip(&mut frame.rates) {
            if hangs.take(*rate, dt, noise) {
                *rate = None;
            }
        }
        frame.with_rates_of_attitude()
    }

    /// The filter of the roll starts anew where the first frames show that the rover drives, as those of
    /// the sides do; they do, too, where it is inclined while its wheels stand. `interrupted`: there is a gap
    /// before this frame. Returns the flag of a roll that was lost and is read again.
    pub(super) fn begin(&mut self, frame: &WholeFrame, interrupted: bool) -> Flags {
        let now = frame.time / self.units.time;
        let found = self.roll.is_lost() && frame.roll.is_some_and(f64::is_finite);
        let interrupted = interrupted || found;
        let (noise, moves) = self.start.take(now, &frame.wheel_angle, interrupted);
        self.settings.budget.inclination_noise = noise;
        if let [Some(a), Some(b), Some(c), ..] = frame.wheel_angle
            && self.roll.started
            && self.carried.take([a, b, c], [self.roll.angle(); 2])
        {
            self.carried = Carried::default();
            self.start_anew();
        }
        if moves.is_some() || interrupted {
            self.roll = LinkAngleKalman::new(&self.budget_in_units());
        }
        Flags::SENSOR_STALE.when(found)
    }

    /// All filters start anew with the next frame.
    pub(super) fn start_anew(&mut self) {
        for side in &mut self.sides {
            side.start_anew();
            if let Some(motion) = side.motion() {
                motion.couple();
            }
        }
        self.roll = LinkAngleKalman::new(&self.budget_in_units());
        self.scale.interrupt();
        self.misfit = MeanMisfit::default();
        self.velocity = [Vec2::zeros(); 2];
        self.about = self.level;
    }

    /// Sets the time of a frame, s. Returns the time since the last one, s, 0 at the first, and whether
    /// the filters start anew after a gap or a clock that was set back.
    pub(super) fn advance_clock(&mut self, now: f64) -> Result<(f64, bool), EstimateError> {
        let last = self.time.unwrap_or(now);
        let (dt, unit) = (now - last, self.units.time);
        let set_back = dt < -LONGEST_GAP * unit;
        let allowed = self.time.is_none() || set_back || dt >= SHORTEST_STEP * unit;
        if !(now.is_finite() && allowed) {
            return Err(EstimateError::Time { last, now });
        }
        self.time = Some(now);
        if set_back {
            self.readings = self.readings.started_anew();
            self.body = BodyInputs::default();
        }
        let interrupted = set_back || dt > LONGEST_GAP * unit;
        if interrupted {
            self.scale.interrupt();
        }
        Ok((dt.max(0.0), interrupted))
    }

    /// Notes which readings there are, and holds the steering.
    pub(super) fn take(&mut self, frame: &WholeFrame) {
        let [roll_rate, _, yaw_rate] = frame.rates;
        let [left, right] = frame.pins;
        let readings = [
            left,
            right,
            frame.coupling,
            frame.inclination,
            frame.roll,
            roll_rate,
            yaw_rate,
        ];
        let largest_rate = limit::RATE / self.units.time;
        // A log may begin in a turn.
        let [_, _, _, _, _, _, yaw_is_known, ..] = self.known;
        if let (false, Some(first)) = (
            yaw_is_known,
            yaw_rate.filter(|rate| rate.abs() <= largest_rate),
        ) {
            self.yaw.start(first);
        }
        let wheels = frame.wheel_angle.iter().chain(&frame.motor_torque);
        // Of what is beyond them the sides' estimators would name links and wheels of their own.
        let limits = [limit::ANGLE; 5].into_iter().chain([largest_rate; 2]);
        let limits = limits.chain([limit::TURN; 6]);
        let limits = limits.chain([LARGEST_TORQUE * self.units.torque(); 6]);
        let readings = readings.iter().chain(wheels).zip(limits);
        for (known, (read, limit)) in self.known.iter_mut().zip(readings) {
            *known |= read.is_some_and(|read| read.abs() <= limit);
        }
        let of_wheels = self.steering.iter_mut().zip(&mut self.steered);
        for ((held, is_steered), read) in of_wheels.zip(frame.steering) {
            let read = read.filter(|angle| angle.is_finite());
            *is_steered |= read.is_some();
            *held = read.unwrap_or(*held);
        }
    }
}
