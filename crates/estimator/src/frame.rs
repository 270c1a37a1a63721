//! Readings of one instant, checked. The last good value is held where a reading is missing.

use crate::flags::Flags;

/// Readings of the inclinometer and the rate gyroscope on one link; `None` where a reading is
/// missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkReading {
    /// Turn from the nominal pose, rad, counter-clockwise.
    pub inclination: Option<f64>,
    /// Angular rate, rad/s, counter-clockwise.
    pub rate: Option<f64>,
}

/// All readings of one instant, SI; `None` where a reading is missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorFrame {
    /// Time of the sample, s; must increase from frame to frame.
    pub time: f64,
    /// Turn of each wheel relative to its link, rad, forward positive: encoder counts times 2 pi /
    /// counts a turn.
    pub wheel_angle: [Option<f64>; 3],
    /// Motor torque at each wheel after the gear, N m, forward positive.
    pub motor_torque: [Option<f64>; 3],
    /// Sensors on link 1.
    pub link1: LinkReading,
    /// Sensors on link 2.
    pub link2: LinkReading,
    /// Contact angles, rad: given, as the paper assumes. An estimator for
    /// [`crate::ContactAngles::Unknown`] ignores them.
    pub contact_angle: [Option<f64>; 3],
}

/// Gap between frames, or between readings of an encoder, beyond which the filters start anew, s.
/// Guard: a robot can stop within it.
pub(crate) const LONGEST_GAP: f64 = 0.5;
/// Least time between frames, s. Half of the shortest period that is supported, 1 us: time stamps
/// are rounded, so that their differences are not exactly equal (at 3 s by 4e-16 s, in seconds
/// since 1970 by 2e-7 s).
/// Definition.
pub(crate) const SHORTEST_STEP: f64 = 0.5e-6;

/// Limits of a robot of this kind. A reading beyond its limit counts as missing.
mod limit {
    /// Motor torque at a wheel, N m: thirty times the drive's.
    /// Guard.
    pub const TORQUE: f64 = 300.0;
    /// Turn of a wheel, rad: 100 000 km. Beyond it rounding exceeds a count.
    /// Guard.
    pub const TURN: f64 = 1e9;
    /// Inclination and contact angle, rad: upside down.
    /// Guard.
    pub const ANGLE: f64 = core::f64::consts::FRAC_PI_2;
    /// Angular rate of a link, rad/s: 2000 deg/s, the range of common gyroscopes.
    /// Data sheet.
    pub const RATE: f64 = 35.0;
    /// Spin speed of a wheel, rad/s: 20 m/s at the rim.
    /// Guard.
    pub const SPIN: f64 = 200.0;
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

    /// The value, unless it has been held for long.
    pub fn recent(&self) -> Option<f64> {
        (self.known && self.age <= Inputs::STALE_AFTER).then_some(self.value)
    }

    /// Takes the reading of a frame `dt` (s) after the last one, if it is finite and `possible`.
    fn take(&mut self, reading: Option<f64>, dt: f64, possible: impl Fn(f64) -> bool) -> Flags {
        // Stays finite.
        self.age = (self.age + dt).min(f64::MAX);
        let flags = match reading {
            Some(value) if value.is_finite() && possible(value) => {
                (self.value, self.age, self.known) = (value, 0.0, true);
                return Flags::NONE;
            }
            Some(_) => Flags::SENSOR_ABSURD | Flags::SENSOR_MISSING,
            None => Flags::SENSOR_MISSING,
        };
        flags | Flags::SENSOR_STALE.when(self.age > Inputs::STALE_AFTER)
    }
}

/// All readings, each with its last good value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Inputs {
    pub wheel_angle: [Held; 3],
    pub motor_torque: [Held; 3],
    /// Links 1 and 2.
    pub inclination: [Held; 2],
    pub rate: [Held; 2],
    pub contact_angle: [Held; 3],
    /// Whether the wheel's angle counts from a new zero with this frame.
    pub new_zero: [bool; 3],
}

impl Inputs {
    /// Age beyond which a held reading is called stale, s: a wheel has then rolled 2 cm at 0.2 m/s.
    /// Guard.
    pub const STALE_AFTER: f64 = 0.1;

    /// Takes a frame `dt` seconds after the last one. Contact angles are read `with_angles` only.
    pub fn take(&mut self, frame: &SensorFrame, dt: f64, with_angles: bool) -> Flags {
        let within = |limit: f64| move |v: f64| libm::fabs(v) <= limit;
        let mut flags = Flags::NONE;
        for i in 0..3 {
            let held = &mut self.wheel_angle[i];
            let (last, known) = (held.value, held.known);
            // A hundredth of a turn more, for coarse encoders.
            let reach = limit::SPIN * (held.age + dt) + 0.06;
            let found = held.take(frame.wheel_angle[i], dt, |v| {
                libm::fabs(v) <= limit::TURN && (!known || libm::fabs(v - last) <= reach)
            });
            flags |= found;
            // An encoder that stays out of the wheel's reach has a new zero: it was reset, or the
            // last angle was false.
            self.new_zero[i] = false;
            if let Some(value) = frame.wheel_angle[i]
                && found.contains(Flags::SENSOR_ABSURD | Flags::SENSOR_STALE)
                && libm::fabs(value) <= limit::TURN
            {
                (held.value, held.age, held.known) = (value, 0.0, true);
                self.new_zero[i] = true;
            }
            let torque = frame.motor_torque[i];
            flags |= self.motor_torque[i].take(torque, dt, within(limit::TORQUE));
            if with_angles {
                let angle = frame.contact_angle[i];
                flags |= self.contact_angle[i].take(angle, dt, within(limit::ANGLE));
            }
        }
        for (i, link) in [&frame.link1, &frame.link2].into_iter().enumerate() {
            flags |= self.inclination[i].take(link.inclination, dt, within(limit::ANGLE));
            flags |= self.rate[i].take(link.rate, dt, within(limit::RATE));
        }
        flags
    }

    /// The first reading that no frame has had so far; contact angles count `with_angles` only.
    pub fn never_read(&self, with_angles: bool) -> Option<&'static str> {
        let unknown = |held: &[Held]| held.iter().any(|h| !h.known);
        [
            ("wheel_angle", unknown(&self.wheel_angle)),
            ("motor_torque", unknown(&self.motor_torque)),
            ("link1.inclination", unknown(&self.inclination[..1])),
            ("link2.inclination", unknown(&self.inclination[1..])),
            ("link1.rate", unknown(&self.rate[..1])),
            ("link2.rate", unknown(&self.rate[1..])),
            ("contact_angle", with_angles && unknown(&self.contact_angle)),
        ]
        .into_iter()
        .find_map(|(field, unknown)| unknown.then_some(field))
    }
}
