//! The readings of a whole rover, and those of the links of each side that follow from them.

use super::posture::sign;
use crate::deviation::root_sum_square;
use crate::flags::Flags;
use crate::frame::{Inputs, LinkReading, SensorFrame};
use robhaz_model::{
    BodyMount, BodyReading, Coupling, Geometry, PathAngle, Suspension, Units, WholeRover,
};

/// All readings of one instant, SI; `None` where one is missing. Wheels are left 1 to 3, then right
/// 1 to 3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WholeFrame {
    /// Time of the sample, s; must increase from frame to frame.
    pub time: f64,
    /// Turn of each wheel relative to its link, rad, forward positive.
    pub wheel_angle: [Option<f64>; 6],
    /// Motor torque at each wheel after the gear, N m, forward positive.
    pub motor_torque: [Option<f64>; 6],
    /// Steering of each wheel, rad, to the left; 0 of a wheel that has had none so far.
    pub steering: [Option<f64>; 6],
    /// Angles of the bogies against the links that they are pivoted to, rad, nose up: left, right.
    pub pins: [Option<f64>; 2],
    /// Angle of the left rocker against the body, rad, nose up; of a rear bogie its roll against the
    /// body's, left side up.
    pub coupling: Option<f64>,
    /// Inclination of the body, rad, nose up: `atan2(f_x, hypot(f_y, f_z))` of the specific force f
    /// at rest.
    pub inclination: Option<f64>,
    /// Roll of the body, rad, left side up: `atan2(f_y, f_z)` at rest.
    pub roll: Option<f64>,
    /// Rates of the body, rad/s: roll (left side up), pitch (nose up), yaw (to the left).
    pub rates: [Option<f64>; 3],
}

impl WholeFrame {
    /// The same with the rates of inclination and roll in place of those of the body about its own axes:
    /// where it is inclined, a rate of yaw is a part of them.
    pub(super) fn with_rates_of_attitude(&self) -> Self {
        let (Some(inclination), Some(roll), [Some(p), Some(q), Some(r)]) =
            (self.inclination, self.roll, self.rates)
        else {
            return *self;
        };
        let ((s, c), t) = (libm::sincos(roll), libm::tan(inclination));
        let rates = [p - t * (r * c - q * s), q * c + r * s, r];
        Self {
            rates: rates.map(Some),
            ..*self
        }
    }
}

/// Makes the readings that sensors on the links of both sides would give, of those of the body and of
/// the joints.
#[derive(Clone, Debug, PartialEq)]
pub struct SideReadings {
    kind: Coupling,
    /// Whether link 1 is the bogie, not link 2.
    bogie_first: bool,
    mounts: [BodyMount; 2],
    coupling: PathAngle<6>,
    coupled: (f64, f64),
    /// Time of the last frame, s, and for how long the coupling has not been read.
    time: Option<f64>,
    silent: f64,
    /// For how long a reading may be held, s.
    held: f64,
}

impl SideReadings {
    /// For a rover whose joints are read with this white noise, rad a sample.
    pub fn new(rover: &WholeRover, joint_noise: f64) -> Self {
        let geometry = &rover.side.geometry;
        let mount = BodyMount::new(geometry, joint_noise);
        Self {
            kind: rover.coupling,
            bogie_first: bogie_of(geometry) == 0,
            mounts: [mount.clone(), mount],
            coupling: PathAngle::new(geometry.wheel_radius, joint_noise),
            coupled: (0.0, 0.0),
            time: None,
            silent: 0.0,
            held: Inputs::STALE_AFTER * Units::of(&rover.side).time,
        }
    }

    /// The same, but every reading of a pin counts: [`BodyMount::keeping_jumps`].
    #[must_use]
    pub fn keeping_jumps(self) -> Self {
        Self {
            mounts: self.mounts.map(BodyMount::keeping_jumps),
            ..self
        }
    }

    /// As before its first frame.
    pub(super) fn started_anew(&self) -> Self {
        Self {
            mounts: self.mounts.each_ref().map(BodyMount::started_anew),
            coupling: self.coupling.started_anew(),
            time: None,
            ..self.clone()
        }
    }

    /// Angle of the coupling in the last frame that had one, rad, and its rate, rad/s; 0 of one that has not been read for
    /// too long.
    pub(super) fn coupled(&self) -> (f64, f64) {
        let (angle, rate) = self.coupled;
        (angle, if self.is_stale() { 0.0 } else { rate })
    }

    /// Whether the coupling has not been read for too long.
    pub(super) fn is_stale(&self) -> bool {
        self.silent > self.held
    }

    /// Flags of a rear bogie's angle that is missing. That of a differential is one of the links' readings.
    pub(super) fn flags(&self) -> Flags {
        if self.kind == Coupling::Differential {
            return Flags::NONE;
        }
        Flags::SENSOR_MISSING.when(self.silent > 0.0) | Flags::SENSOR_STALE.when(self.is_stale())
    }

    /// Standard deviation of the rate of a rear bogie that is read, rad/s.
    pub(super) fn rear_rate_error(&self) -> f64 {
        match self.kind {
            Coupling::Differential => 0.0,
            Coupling::RearBogie => self.coupling.rate_error(),
        }
    }

    /// What a differential's angle makes the rates of its rockers err by, of one as much up as of the other
    /// down, rad/s.
    pub(super) fn rocker_rate_error(&self) -> f64 {
        match self.kind {
            Coupling::Differential => self.coupling.rate_error(),
            Coupling::RearBogie => 0.0,
        }
    }

    /// The readings of the left and of the right side in a frame. The pitch of a differential's rockers
    /// is that of the body plus or less its angle; a rear bogie's front halves have the body's.
    pub fn frames(&mut self, frame: &WholeFrame) -> [SensorFrame; 2] {
        let coupling = (self.coupling).update(frame.time, frame.coupling, &frame.wheel_angle);
        self.coupled = coupling.unwrap_or(self.coupled);
        let last = self.time.replace(frame.time).unwrap_or(frame.time);
        self.silent = match coupling {
            Some(_) => 0.0,
            None => self.silent + (frame.time - last).max(0.0),
        };
        let turned = match self.kind {
            Coupling::Differential => coupling,
            Coupling::RearBogie => Some((0.0, 0.0)),
        };
        let of_rocker = self.rocker_rate_error();
        let [_, pitch_rate, _] = frame.rates;
        let of = |wheels: &[Option<f64>; 6], side: usize| [0, 1, 2].map(|i| wheels[3 * side + i]);
        [0, 1].map(|side: usize| {
            let body = frame.inclination.zip(turned);
            let rate = pitch_rate.zip(turned);
            let pin = frame.pins[side];
            let reading = BodyReading {
                inclination: body.map(|(body, (angle, _))| body + sign(side) * angle),
                rate: rate.map(|(body, (_, rate))| body + sign(side) * rate),
                pin: pin.map(|pin| if self.bogie_first { pin } else { -pin }),
                wheels: of(&frame.wheel_angle, side),
            };
            let links = self.mounts[side].links(frame.time, &reading);
            let [link1, link2] = links.map(|link| LinkReading {
                rate_error: root_sum_square(link.rate_error, of_rocker),
                ..link
            });
            SensorFrame {
                time: frame.time,
                wheel_angle: of(&frame.wheel_angle, side),
                motor_torque: of(&frame.motor_torque, side),
                link1,
                link2,
                contact_angle: [None; 3],
            }
        })
    }
}

/// Index of the link that is the bogie.
pub(super) fn bogie_of(geometry: &Geometry) -> usize {
    match geometry.suspension {
        Suspension::Bogie { body } => 1 - body.index(),
        Suspension::FourBar => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: a rover that turns about the vertical on a slope keeps inclination and roll.
    #[test]
    fn a_turn_about_the_vertical_keeps_the_attitude() {
        let (inclination, roll, turn) = (0.2_f64, -0.3_f64, 0.5);
        let (sp, cp) = libm::sincos(inclination);
        let (sr, cr) = libm::sincos(roll);
        let frame = WholeFrame {
            inclination: Some(inclination),
            roll: Some(roll),
            rates: [turn * sp, -turn * cp * sr, turn * cp * cr].map(Some),
            ..WholeFrame::default()
        };
        let [p, q, r] = frame.with_rates_of_attitude().rates;
        assert!(p.is_some_and(|p| p.abs() < 1e-15) && q.is_some_and(|q| q.abs() < 1e-15));
        assert_eq!(r, frame.rates[2]);
    }
}
