//! The ROS 2 messages that logs are made of: definitions, and their numbers by the names of
//! columns.

use crate::cdr::{CdrReader, CdrWriter};
use crate::{Stamp, TimeUnit};
use nalgebra::UnitQuaternion;
use robhaz_model::named;
use robhaz_scene::Reading;

named! {
    /// A kind of message that holds readings, by the name of its schema.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum MessageKind {
        /// Joints.
        JointState = "sensor_msgs/msg/JointState",
        /// An inertial measurement unit.
        Imu = "sensor_msgs/msg/Imu",
        /// The readings of a run.
        Readings = "robhaz_msgs/msg/Readings",
        /// Those of a log of both sides.
        WholeReadings = "robhaz_msgs/msg/WholeReadings",
    }
}

/// A message, decoded: its time in the header, or, of `Readings`, its exact time, the header's `frame_id`, and its
/// numbers.
pub type Decoded<'a> = (Stamp, &'a str, Vec<Number<'a>>);

/// A number of a message. Its column is `name`, or `name.part` where it has a part. Names are not
/// joined for each message.
pub struct Number<'a> {
    name: &'a str,
    part: &'static str,
    /// The number.
    pub value: f64,
}

impl Number<'_> {
    /// The name of its column.
    pub fn column(&self) -> String {
        match self.part {
            "" => self.name.to_owned(),
            part => format!("{}.{part}", self.name),
        }
    }

    /// Whether it is the number of a column.
    pub fn is(&self, column: &str) -> bool {
        let rest = column.strip_prefix(self.name);
        match self.part {
            "" => rest == Some(""),
            part => rest.and_then(|rest| rest.strip_prefix('.')) == Some(part),
        }
    }
}

/// Parts of an `Imu` and their numbers; each has a covariance. One that starts with -1 states that
/// the part is not measured.
const IMU: [(&str, &[&str]); 3] = [
    ("orientation", &["x", "y", "z", "w"]),
    ("angular_velocity", &["x", "y", "z"]),
    ("linear_acceleration", &["x", "y", "z"]),
];

impl MessageKind {
    /// Its definition in the language of ROS 2 (`ros2msg`).
    pub const fn definition(self) -> &'static str {
        match self {
            Self::JointState => include_str!("definitions/JointState.msg"),
            Self::Imu => include_str!("definitions/Imu.msg"),
            Self::Readings => include_str!("definitions/Readings.msg"),
            Self::WholeReadings => include_str!("definitions/WholeReadings.msg"),
        }
    }

    /// Decodes a message; `None` if it is not of this kind.
    pub fn decode(self, message: &[u8]) -> Option<Decoded<'_>> {
        let mut reader = CdrReader::new(message)?;
        let (stamp, frame) = header(&mut reader)?;
        Some(match self {
            Self::JointState => (stamp, frame, joint_state(&mut reader)?),
            Self::Imu => (stamp, frame, imu(&mut reader)?),
            Self::Readings | Self::WholeReadings => {
                let time = TimeUnit::SECOND.of_float(reader.f64()?)?;
                let all: Vec<Reading> = match self {
                    Self::WholeReadings => Reading::of_whole().collect(),
                    _ => Reading::of_frame().collect(),
                };
                (time, frame, readings(&mut reader, &all)?)
            }
        })
    }
}

/// Stamp and `frame_id` of `std_msgs/Header`.
fn header<'a>(reader: &mut CdrReader<'a>) -> Option<(Stamp, &'a str)> {
    let (seconds, nanoseconds) = (reader.take().map(i32::from_le_bytes)?, reader.u32()?);
    let frame = reader.text()?;
    // Far below the largest number.
    let whole = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
    Some((Stamp::Nanoseconds(whole), frame))
}

fn joint_state<'a>(reader: &mut CdrReader<'a>) -> Option<Vec<Number<'a>>> {
    let count = reader.u32()?;
    let names: Vec<&str> = (0..count).map(|_| reader.text()).collect::<Option<_>>()?;
    let mut numbers = Vec::with_capacity(3 * names.len());
    for part in ["position", "velocity", "effort"] {
        // A sequence may be empty.
        let values = reader.doubles()?;
        let named = names.iter().zip(values);
        numbers.extend(named.map(|(name, value)| Number { name, part, value }));
    }
    Some(numbers)
}

fn imu<'a>(reader: &mut CdrReader<'a>) -> Option<Vec<Number<'a>>> {
    let mut numbers = Vec::with_capacity(10);
    for (name, parts) in IMU {
        let own = numbers.len();
        for part in parts {
            let value = reader.f64()?;
            numbers.push(Number { name, part, value });
        }
        let is_stated_absent = reader.f64()? < 0.0;
        for _ in 1..9 {
            reader.f64()?;
        }
        // A quaternion without length is none.
        let numbers = &mut numbers[own..];
        let is_none = name == "orientation" && numbers.iter().all(|n| n.value == 0.0);
        if is_stated_absent || is_none {
            numbers.iter_mut().for_each(|n| n.value = f64::NAN);
        }
    }
    Some(numbers)
}

fn readings<'a>(reader: &mut CdrReader<'a>, all: &[Reading]) -> Option<Vec<Number<'a>>> {
    let mut number = |reading: &Reading| {
        let (name, part, value) = (reading.name(), "", reader.f64()?);
        Some(Number { name, part, value })
    };
    all.iter().map(&mut number).collect()
}

/// Time in whole nanoseconds, of times since the start.
pub fn nanoseconds(time: f64) -> u64 {
    // The cast saturates; times start at 0.
    (time * 1e9).round() as u64
}

/// A message that starts with the header of a time (s).
pub fn with_header(time: f64, frame: &str) -> CdrWriter {
    const SECOND: u64 = 1_000_000_000;
    let time = nanoseconds(time);
    let mut writer = CdrWriter::new();
    let seconds = i32::try_from(time / SECOND).unwrap_or(i32::MAX);
    writer.put(seconds.to_le_bytes());
    // Below a second.
    writer.put(((time % SECOND) as u32).to_le_bytes());
    writer.text(frame);
    writer
}

/// `Readings` or `WheelForces`: the numbers in the order of the definition, to the bit; not a
/// number where one is missing.
pub fn encode_numbers(time: f64, numbers: &[f64]) -> Vec<u8> {
    let mut writer = with_header(time, "");
    writer.array(&[time]);
    writer.array(numbers);
    writer.0
}

/// A joint: its name, position rad, velocity rad/s, effort N m.
pub type Joint = (&'static str, [f64; 3]);

/// `JointState`.
pub fn encode_joints(time: f64, joints: &[Joint]) -> Vec<u8> {
    let mut writer = with_header(time, "");
    writer.count(joints.len());
    joints.iter().for_each(|joint| writer.text(joint.0));
    for part in 0..3 {
        let of_part: Vec<f64> = joints.iter().map(|joint| joint.1[part]).collect();
        writer.sequence(&of_part);
    }
    writer.0
}

/// Quaternion x y z w to the world of a body with x forward, y to the left, z up: roll (left side up),
/// inclination (nose up, which turns about y backwards), yaw (to the left), rad.
pub fn orientation(roll: f64, inclination: f64, yaw: f64) -> [f64; 4] {
    let rotation = UnitQuaternion::from_euler_angles(roll, -inclination, yaw);
    rotation.coords.into()
}

/// `Imu` of a frame with x forward, y to the left, z up: roll and inclination (rad) as orientation,
/// rates of roll, inclination and yaw (rad/s). Acceleration was not measured, which -1 in its
/// covariance states.
pub fn encode_imu(
    time: f64,
    frame: &str,
    [roll, inclination]: [f64; 2],
    rates: [f64; 3],
) -> Vec<u8> {
    const UNKNOWN: [f64; 9] = [0.0; 9];
    const NONE: [f64; 9] = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut writer = with_header(time, frame);
    let [roll_rate, rate, yaw_rate] = rates;
    writer.array(&orientation(roll, inclination, 0.0));
    writer.array(&UNKNOWN);
    writer.array(&[roll_rate, -rate, yaw_rate]);
    writer.array(&UNKNOWN);
    writer.array(&[0.0; 3]);
    writer.array(&NONE);
    writer.0
}

/// `WrenchStamped` of a force (N) without a moment.
pub fn encode_wrench(time: f64, frame: &str, force: [f64; 3]) -> Vec<u8> {
    let mut writer = with_header(time, frame);
    writer.array(&force);
    writer.array(&[0.0; 3]);
    writer.0
}

/// Name and definition of a message.
pub type Schema = (&'static str, &'static str);

/// Forces of three wheels.
pub const FORCES: Schema = (
    "robhaz_msgs/msg/WheelForces",
    include_str!("definitions/WheelForces.msg"),
);
/// The force on a wheel.
pub const WRENCH: Schema = (
    "geometry_msgs/msg/WrenchStamped",
    include_str!("definitions/WrenchStamped.msg"),
);
/// Odometry.
pub const ODOMETRY: Schema = (
    "nav_msgs/msg/Odometry",
    include_str!("definitions/Odometry.msg"),
);

#[cfg(test)]
mod tests {
    use super::*;

    /// The fields of a definition are those that are written, in their order: other programs read by it.
    #[test]
    fn definitions_have_all_readings() {
        let fields = |kind: MessageKind| -> Vec<&str> {
            let own = kind
                .definition()
                .lines()
                .take_while(|line| !line.starts_with('='));
            let numbers = own.filter_map(|line| line.strip_prefix("float64 ")?.split(' ').next());
            numbers.collect()
        };
        let names = |of: Vec<Reading>| -> Vec<&str> {
            ["time"]
                .into_iter()
                .chain(of.into_iter().map(Reading::name))
                .collect()
        };
        assert_eq!(
            fields(MessageKind::Readings),
            names(Reading::of_frame().collect())
        );
        assert_eq!(
            fields(MessageKind::WholeReadings),
            names(Reading::of_whole().collect())
        );
    }
}
