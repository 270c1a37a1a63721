//! The messages of the readings of a frame: all readings, joints, IMUs.

use crate::messages::{Joint, MessageKind, encode_imu, encode_joints, encode_numbers};
use crate::own_names;
use robhaz_scene::{Reading, Values};

/// The readings of an IMU behind the name of its body: roll, inclination, and the rates of roll,
/// inclination and yaw. What a log does not have is 0, as of a link, which moves in the plane.
const IMU: [&str; 5] = ["roll", "inclination", "roll_rate", "rate", "yaw_rate"];

/// The sensors of a log.
pub struct Sensors {
    /// Topics and their messages.
    pub topics: Vec<(String, MessageKind)>,
    readings: Vec<Reading>,
    joints: Vec<JointReadings>,
    /// The IMUs with their frames.
    imus: Vec<(&'static str, [Option<Reading>; 5])>,
    /// Time (s) and readings of the frame before.
    last: Option<(f64, Values)>,
}

/// A joint: its angle, and the torque of its motor.
struct JointReadings {
    name: &'static str,
    angle: Reading,
    torque: Option<Reading>,
    /// A wheel that is not steered has no such joint, and a rover one of two couplings.
    may_lack: bool,
}

impl Sensors {
    /// Those of one side, or of both.
    pub fn new(both: bool) -> Self {
        let (kind, readings): (_, Vec<Reading>) = match both {
            true => (MessageKind::WholeReadings, Reading::of_whole().collect()),
            false => (MessageKind::Readings, Reading::of_frame().collect()),
        };
        // With their frames.
        let bodies: &[_] = match both {
            true => &[("body", "base_link")],
            false => &[("link1", "link1"), ("link2", "link2")],
        };
        let named = |name: String| Reading::named(&name).filter(|r| readings.contains(r));
        let imu =
            |(body, frame): &(&str, _)| (*frame, IMU.map(|part| named(format!("{body}_{part}"))));
        let joint = |angle: &Reading| JointReadings::of(*angle, &readings);
        let mut topics = vec![
            (own_names::TOPIC.to_owned(), kind),
            ("/joint_states".to_owned(), MessageKind::JointState),
        ];
        topics.extend((bodies.iter()).map(|(body, _)| (format!("/imu/{body}"), MessageKind::Imu)));
        Self {
            topics,
            joints: readings.iter().filter_map(joint).collect(),
            imus: bodies.iter().map(imu).collect(),
            readings,
            last: None,
        }
    }

    /// The messages of the next frame, at a time (s), in the order of the topics.
    pub fn messages(&mut self, time: f64, now: &Values) -> Vec<Vec<u8>> {
        let last = self.last.replace((time, *now));
        let numbers = self.readings.iter().map(|r| number(now, *r));
        let joints = self.joints.iter();
        let joints = joints.filter(|j| !j.may_lack || now[j.angle.index()].is_some());
        let joints = joints.map(|joint| joint.at(time, now, last.as_ref()));
        let mut all = vec![
            encode_numbers(time, &numbers.collect::<Vec<f64>>()),
            encode_joints(time, &joints.collect::<Vec<Joint>>()),
        ];
        for (i, (frame, _)) in self.imus.iter().enumerate() {
            let (attitude, rates) = self.imu(i, now);
            all.push(encode_imu(time, frame, attitude, rates));
        }
        all
    }

    /// Roll and inclination (rad) of an IMU, and the rates of roll, inclination and yaw, rad/s.
    pub fn imu(&self, i: usize, now: &Values) -> ([f64; 2], [f64; 3]) {
        let of = |reading: Option<Reading>| reading.map_or(0.0, |reading| number(now, reading));
        let [roll, inclination, rates @ ..] = self.imus[i].1.map(of);
        ([roll, inclination], rates)
    }
}

impl JointReadings {
    /// The joint of an angle; `None` of another reading.
    fn of(angle: Reading, all: &[Reading]) -> Option<Self> {
        let full = angle.name();
        let name = full.strip_suffix("_angle").unwrap_or(full);
        let is_torque = |r: &Reading| r.name().strip_suffix("_motor_torque") == Some(name);
        let may_lack = angle.is_of_coupling() || full.ends_with("_steering");
        let is_joint = (may_lack || full.ends_with("_angle")) && !angle.is_contact_angle();
        is_joint.then(|| Self {
            name,
            angle,
            torque: all.iter().copied().find(is_torque),
            may_lack,
        })
    }

    /// No sensor measures the speed: it is the difference of the last two angles.
    fn at(&self, time: f64, now: &Values, last: Option<&(f64, Values)>) -> Joint {
        let position = now[self.angle.index()];
        let speed = last.and_then(|(before, last)| {
            Some((position? - last[self.angle.index()]?) / (time - before))
        });
        let effort = self.torque.and_then(|torque| now[torque.index()]);
        let numbers = [position, speed, effort];
        (self.name, numbers.map(|x| x.unwrap_or(f64::NAN)))
    }
}

/// A reading; not a number where it is missing.
fn number(values: &Values, reading: Reading) -> f64 {
    values[reading.index()].unwrap_or(f64::NAN)
}
