//! Readings of one instant, checked. The last good value is held where a reading is missing.

use crate::deviation::{GATE, root_sum_square};
use crate::flags::Flags;
use crate::settings::NoiseBudget;
use robhaz_model::Robot;

pub use robhaz_model::{LinkReading, SensorFrame};

/// Gap between frames, or between readings of an encoder, beyond which the filters start anew, s.
/// Guard: a robot can stop within it.
pub(crate) const LONGEST_GAP: f64 = 0.5;
/// Least time between frames, s. Half of the shortest period that is supported, 1 us: time stamps
/// are rounded, so that their differences are not exactly equal (at 3 s by 4e-16 s, in seconds
/// since 1970 by 2e-7 s).
/// Definition.
pub(crate) const SHORTEST_STEP: f64 = 0.5e-6;

/// Angular acceleration from which a change of a link's rate is an impact, rad/s^2: 15 times
/// `v^2/(R l)`, that of a link with l = 0.3 m whose wheel follows ground with a radius of R = 0.1 m
/// at 0.2 m/s.
/// Chosen; sensitive.
pub(crate) const IMPACT: f64 = 20.0;

/// Motor torque at a wheel of robot A, N m, beyond which a reading counts as missing: thirty times the drive's.
/// Guard.
pub const LARGEST_TORQUE: f64 = 300.0;

/// Limits of a robot of this kind. A reading beyond its limit counts as missing.
pub(crate) mod limit {
    /// Turn of a wheel, rad: 100 000 km. Beyond it rounding exceeds a count.
    /// Guard.
    pub const TURN: f64 = 1e9;
    /// Inclination and contact angle, rad: upside down.
    /// Guard.
    pub const ANGLE: f64 = core::f64::consts::FRAC_PI_2;
    /// Angular rate of a link, rad/s: 2000 deg/s, the range of common gyroscopes.
    /// Data sheet.
    pub const RATE: f64 = 35.0;
}

/// The last good value of one reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Held {
    /// The value.
    pub value: f64,
    /// Time since it was read, s; 0 when it is of this frame.
    pub age: f64,
    /// Whether there has ever been one.
    pub known: bool,
    /// The last reading, if it was left out as a jump that none has confirmed.
    jumped: Option<f64>,
    /// What a jump that this frame confirms had changed before it, and was left out: its size times
    /// the time for which it counted, in the reading's unit times s.
    pub late: f64,
}

impl Held {
    /// Whether the value is of this frame.
    pub fn fresh(&self) -> bool {
        self.known && self.age <= 0.0
    }

    /// The value, if it is of this frame.
    pub fn now(&self) -> Option<f64> {
        self.fresh().then_some(self.value)
    }

    /// By how much the reading of this frame differs from the value, if it was left out as a jump; 0
    /// else.
    pub fn left_out(&self) -> f64 {
        self.jumped.map_or(0.0, |jumped| jumped - self.value)
    }

    /// The value, unless it has been held for long.
    pub fn recent(&self) -> Option<f64> {
        (self.known && self.age <= Inputs::STALE_AFTER).then_some(self.value)
    }

    /// Takes the reading of a frame `dt` (s) after the last one, if it is finite, within `limit`,
    /// and no unconfirmed jump by more than `reach` allows after a time (s).
    ///
    /// A jump is confirmed by the next reading if that lies at least half as far out on the same
    /// side. So a single wrong reading never counts, and a true change counts a reading later. A
    /// value that has been held against other readings for long is given up.
    fn take(
        &mut self,
        reading: Option<f64>,
        dt: f64,
        limit: f64,
        reach: impl Fn(f64) -> f64,
    ) -> Flags {
        // Stays finite.
        self.age = (self.age + dt).min(f64::MAX);
        self.late = 0.0;
        let mut flags = Flags::SENSOR_MISSING;
        match reading {
            Some(value) if value.is_finite() && libm::fabs(value) <= limit => {
                let change = value - self.value;
                let jumps = libm::fabs(change) > reach(self.age);
                let before = self.jumped.map(|jumped| jumped - self.value);
                let confirmed = before.filter(|before| change * before >= 0.5 * before * before);
                let given_up = before.is_some() && self.age > Inputs::STALE_AFTER;
                if !(self.known && jumps && confirmed.is_none()) || given_up {
                    if let Some(before) = confirmed.filter(|_| jumps && !given_up) {
                        // From half a frame before the jump to half a frame behind it.
                        self.late = before * 0.5 * self.age;
                    }
                    self.set(value);
                    return Flags::NONE;
                }
                self.jumped = Some(value);
            }
            Some(_) => flags |= Flags::SENSOR_ABSURD,
            None => {}
        }
        flags | Flags::SENSOR_STALE.when(self.age > Inputs::STALE_AFTER)
    }

    /// A value of this frame.
    fn set(&mut self, value: f64) {
        (self.value, self.age, self.known, self.jumped) = (value, 0.0, true, None);
    }
}

/// The angle of a wheel, as its encoder counts it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Encoder {
    /// The last good angle, rad.
    pub angle: Held,
    /// Whether the angle counts from a new zero with this frame.
    pub new_zero: bool,
    /// Spin speed between the last two good angles, rad/s, and the time between them, s:
    /// [`LONGEST_GAP`] for a speed that is not known.
    speed: f64,
    interval: f64,
    /// By how much the last reading was beyond the expected angle, rad, if it was left out.
    beyond: Option<f64>,
}

impl Encoder {
    /// Torque of a drive, N m: what it reads can be late or zero.
    /// Guard.
    const DRIVE_TORQUE: f64 = 10.0;
    /// Angle within which no jump is looked for, rad: a coarse text format, and an impact's change
    /// of the speed within a millisecond.
    /// Guard.
    const LEAST_JUMP: f64 = 1e-3;
    /// Change of the spin speed in an impact, rad/s: 2 m/s at the rim.
    /// Guard.
    const LARGEST_CHANGE: f64 = 20.0;
    /// Counts by which the difference of two differences of counted angles may err.
    /// Definition.
    const COUNTS: f64 = 4.0;

    /// Takes the angle (rad) of a frame `dt` (s) after the last one.
    ///
    /// The expected angle follows from the last two. Torque and inertia limit how far the wheel
    /// can be from it, since the drive cannot change its speed faster. A reading beyond that is left
    /// out. If the next one is as far beyond, the encoder counts from a new zero; if it is farther
    /// on the same side, the speed has changed, as in an impact.
    fn take(&mut self, reading: Option<f64>, torque: f64, dt: f64, gate: &Gate<'_>) -> Flags {
        self.new_zero = false;
        let angle = &mut self.angle;
        angle.age = (angle.age + dt).min(f64::MAX);
        let elapsed = angle.age;
        let stale = Flags::SENSOR_STALE.when(elapsed > Inputs::STALE_AFTER);
        let Some(value) = reading else {
            return Flags::SENSOR_MISSING | stale;
        };
        if !(value.is_finite() && libm::fabs(value) <= limit::TURN) {
            return Flags::SENSOR_ABSURD | Flags::SENSOR_MISSING | stale;
        }
        if !angle.known {
            angle.set(value);
            self.interval = LONGEST_GAP;
            return Flags::NONE;
        }
        let change = value - angle.value;
        let beyond = change - self.speed * elapsed;
        let acceleration = (Self::DRIVE_TORQUE + libm::fabs(torque)) / gate.inertia;
        let reach = |time: f64| {
            let counts = Self::COUNTS * gate.count();
            // Three stamps, one of them counted twice: sqrt(6).
            let stamps = 2.5 * GATE * gate.budget.jitter * libm::fabs(self.speed);
            Self::LEAST_JUMP.max(counts) + stamps + acceleration * time
        };
        let of_speed = 0.5 * elapsed * (elapsed + self.interval);
        if libm::fabs(beyond) <= reach(of_speed) {
            self.accept(value, elapsed);
            return Flags::NONE;
        }
        let Some(before) = self.beyond.replace(beyond) else {
            return Flags::SENSOR_MISSING | stale;
        };
        let of_zero = libm::fabs(beyond - before);
        let is_zero = of_zero <= reach(of_speed).min(0.25 * libm::fabs(before));
        if is_zero || !stale.is_empty() {
            if !is_zero {
                (self.speed, self.interval) = (0.0, LONGEST_GAP);
            }
            self.angle.set(value);
            (self.beyond, self.new_zero) = (None, true);
            return Flags::SENSOR_STALE;
        }
        let speeds_up = beyond * before > before * before;
        if speeds_up && libm::fabs(beyond) <= Self::LARGEST_CHANGE * elapsed {
            self.accept(value, elapsed);
            return Flags::NONE;
        }
        Flags::SENSOR_MISSING | stale
    }

    fn accept(&mut self, value: f64, elapsed: f64) {
        if elapsed > 0.0 {
            self.speed = (value - self.angle.value) / elapsed;
            self.interval = elapsed;
        }
        self.angle.set(value);
        self.beyond = None;
    }
}

/// Whether an inertial sensor gives the same numbers over and over, as of a bus that hangs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Repeats<const N: usize> {
    last: [Option<u64>; N],
    /// For how long they have been the same while the wheels turned, s.
    time: f64,
}

impl<const N: usize> Default for Repeats<N> {
    fn default() -> Self {
        Self {
            last: [None; N],
            time: 0.0,
        }
    }
}

impl<const N: usize> Repeats<N> {
    /// Time from which on they are no readings, s: more than the period of a sensor of 10 Hz.
    /// Chosen.
    const LONGEST: f64 = 0.15;

    /// Takes the numbers of a frame `dt` (s) after the last one. Zeros may last, of exact sensors.
    pub fn take(&mut self, numbers: [Option<f64>; N], dt: f64, turns: bool) -> bool {
        let bits = numbers.map(|number| number.map(f64::to_bits));
        let is_read = numbers.iter().flatten().all(|number| number.abs() > 0.0);
        let repeats = is_read && bits == self.last && bits.iter().any(Option::is_some);
        self.time = match repeats {
            true if turns => self.time + dt,
            true => self.time,
            false => 0.0,
        };
        self.last = bits;
        self.time > Self::LONGEST
    }
}

/// All readings, each with its last good value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Inputs {
    pub encoder: [Encoder; 3],
    pub motor_torque: [Held; 3],
    /// Links 1 and 2.
    pub inclination: [Held; 2],
    pub rate: [Held; 2],
    pub contact_angle: [Held; 3],
    /// [`LinkReading::rate_error`] of the last rates, rad/s.
    pub joint_noise: [f64; 2],
    repeats: [Repeats<2>; 2],
}

/// By how much readings may change: the gate of the jumps.
///
/// Of white noise two readings in a row differ by more than `5 sqrt(2)` standard deviations once in
/// 1.7 million samples. What the robot does itself is added to that, as a step and a slope.
pub(crate) struct Gate<'a> {
    budget: &'a NoiseBudget,
    /// What a motor accelerates at its wheel, kg m^2: wheel, rotor, and a third of the robot. A wheel
    /// that breaks loose is faster: its angle counts a reading later.
    inertia: f64,
}

impl<'a> Gate<'a> {
    /// Step (N m) and slope (N m/s) of a torque: a fifth of the mean load times the radius, and a
    /// drive that reaches its limit within 0.1 s.
    /// Guard.
    const TORQUE: [f64; 2] = [1.0, 100.0];
    /// Step (rad/s) and slope (rad/s^2) of a link's rate: the acceleration from which a change is an
    /// impact.
    /// Guard.
    const RATE: [f64; 2] = [0.0, IMPACT];
    /// Step (rad) and slope (rad/s) of an inclination: an acceleration of 0.05 g that begins, a
    /// link that turns at 2 rad/s.
    /// Guard.
    const INCLINATION: [f64; 2] = [0.05, 2.0];
    /// Step (rad) and slope (rad/s) of a contact angle: a corner of 20 deg, as of facets and ramps, and
    /// a curve of a fifth of the radius of a wheel of 0.1 m at 0.2 m/s. The angle of a kerb counts a
    /// reading later.
    /// Guard.
    const CONTACT_ANGLE: [f64; 2] = [0.35, 10.0];

    /// For the noise of the readings and the robot.
    pub fn new(budget: &'a NoiseBudget, robot: &Robot) -> Self {
        let (mass, radius) = (&robot.mass, robot.geometry.wheel_radius);
        let of_robot = mass.total() * radius * radius / 3.0;
        let inertia = mass.wheel_inertia + mass.rotor_inertia + of_robot;
        Self { budget, inertia }
    }

    /// A count of the encoders, rad; 0 if they are exact.
    fn count(&self) -> f64 {
        let counts = self.budget.encoder_counts;
        let exact = !(counts > 0.0);
        let turn = 2.0 * core::f64::consts::PI;
        if exact { 0.0 } else { turn / counts }
    }

    /// The largest change of a reading with a noise, a step and a slope, after a time (s).
    fn reach(noise: f64, [step, slope]: [f64; 2]) -> impl Fn(f64) -> f64 {
        let of_noise = GATE * core::f64::consts::SQRT_2 * noise;
        move |time| of_noise + step + slope * time
    }
}

/// Readings of the body of a whole rover that no side has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BodyInputs {
    /// Roll, rad.
    pub roll: Held,
    /// Rates of roll and yaw, rad/s.
    pub rates: [Held; 2],
}

impl BodyInputs {
    /// Takes the roll and the rates of roll and yaw of a frame `dt` (s) after the last one.
    pub fn take(
        &mut self,
        roll: Option<f64>,
        rates: [Option<f64>; 2],
        dt: f64,
        gate: &Gate<'_>,
    ) -> Flags {
        let reach = Gate::reach(gate.budget.inclinometer_noise(), Gate::INCLINATION);
        let mut flags = self.roll.take(roll, dt, limit::ANGLE, reach);
        for (held, rate) in self.rates.iter_mut().zip(rates) {
            let reach = Gate::reach(gate.budget.rate_noise, Gate::RATE);
            flags |= held.take(rate, dt, limit::RATE, reach);
        }
        flags
    }
}

impl Inputs {
    /// Age beyond which a held reading is called stale, s: a wheel has then rolled 2 cm at 0.2 m/s.
    /// Guard.
    pub const STALE_AFTER: f64 = 0.1;

    /// A frame `dt` seconds after the last one without the readings of links whose sensor gives the same numbers
    /// over and over.
    pub fn without_repeats(&mut self, frame: &SensorFrame, dt: f64) -> SensorFrame {
        let turns = self.encoder.iter().any(|encoder| encoder.speed.abs() > 0.0);
        let mut frame = *frame;
        let links = [&mut frame.link1, &mut frame.link2];
        for (link, repeats) in links.into_iter().zip(&mut self.repeats) {
            if repeats.take([link.inclination, link.rate], dt, turns) {
                *link = LinkReading::default();
            }
        }
        frame
    }

    /// Takes a frame `dt` seconds after the last one. Contact angles are read `with_angles` only.
    pub fn take(
        &mut self,
        frame: &SensorFrame,
        dt: f64,
        gate: &Gate<'_>,
        with_angles: bool,
    ) -> Flags {
        let budget = gate.budget;
        let mut flags = Flags::NONE;
        for i in 0..3 {
            let torque = &mut self.motor_torque[i];
            let reach = Gate::reach(budget.torque_noise, Gate::TORQUE);
            flags |= torque.take(frame.motor_torque[i], dt, LARGEST_TORQUE, reach);
            flags |= self.encoder[i].take(frame.wheel_angle[i], torque.value, dt, gate);
            if with_angles {
                let reach = Gate::reach(budget.contact_angle, Gate::CONTACT_ANGLE);
                let held = &mut self.contact_angle[i];
                flags |= held.take(frame.contact_angle[i], dt, limit::ANGLE, reach);
            }
        }
        let noise = budget.inclinometer_noise();
        for (i, link) in [&frame.link1, &frame.link2].into_iter().enumerate() {
            let reach = Gate::reach(noise, Gate::INCLINATION);
            let held = &mut self.inclination[i];
            flags |= held.take(link.inclination, dt, limit::ANGLE, reach);
            if link.rate.is_some() && (0.0..limit::RATE).contains(&link.rate_error) {
                self.joint_noise[i] = link.rate_error;
            }
            let noise_of_rate = root_sum_square(budget.rate_noise, self.joint_noise[i]);
            let reach = Gate::reach(noise_of_rate, Gate::RATE);
            flags |= self.rate[i].take(link.rate, dt, limit::RATE, reach);
        }
        flags
    }

    /// The first reading that no frame has had so far; contact angles count `with_angles` only.
    pub fn never_read(&self, with_angles: bool) -> Option<&'static str> {
        let encoders = self.encoder.each_ref().map(|encoder| encoder.angle.known);
        let [inclination, rate] = [&self.inclination, &self.rate];
        [
            ("wheel_angle[0]", encoders[0]),
            ("wheel_angle[1]", encoders[1]),
            ("wheel_angle[2]", encoders[2]),
            ("motor_torque[0]", self.motor_torque[0].known),
            ("motor_torque[1]", self.motor_torque[1].known),
            ("motor_torque[2]", self.motor_torque[2].known),
            ("link1.inclination", inclination[0].known),
            ("link2.inclination", inclination[1].known),
            ("link1.rate", rate[0].known),
            ("link2.rate", rate[1].known),
            (
                "contact_angle",
                !with_angles || self.contact_angle.iter().all(|held| held.known),
            ),
        ]
        .into_iter()
        .find_map(|(field, known)| (!known).then_some(field))
    }
}
