//! A level drive as messages of ROS 2 in a file of MCAP: what nodes really publish.

use crate::readings::level_drive::LevelDrive;
use std::collections::BTreeMap;
use std::path::Path;

/// A message in CDR: little-endian, numbers at multiples of their size behind the head.
struct Cdr(Vec<u8>);

impl Cdr {
    /// With the header of a stamp, ns.
    fn new(stamp: u64) -> Self {
        let mut message = Self(vec![0, 1, 0, 0]);
        message.put(i32::try_from(stamp / 1_000_000_000).unwrap().to_le_bytes());
        message.put(u32::try_from(stamp % 1_000_000_000).unwrap().to_le_bytes());
        message.text("base_link");
        message
    }

    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        let length = 4 + (self.0.len() - 4).next_multiple_of(N);
        self.0.resize(length, 0);
        self.0.extend(bytes);
    }

    fn count(&mut self, count: usize) {
        self.put(u32::try_from(count).unwrap().to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.count(text.len() + 1);
        self.0.extend(text.bytes().chain([0]));
    }

    fn numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|x| self.put(x.to_le_bytes()));
    }

    fn sequence(&mut self, numbers: &[f64]) {
        self.count(numbers.len());
        self.numbers(numbers);
    }
}

/// Joints `front`, `middle`, `rear`; a part of which nothing is known is empty.
pub fn joints(stamp: u64, position: &[f64], velocity: &[f64], effort: &[f64]) -> Vec<u8> {
    let mut message = Cdr::new(stamp);
    message.count(3);
    ["front", "middle", "rear"]
        .into_iter()
        .for_each(|name| message.text(name));
    [position, velocity, effort]
        .into_iter()
        .for_each(|part| message.sequence(part));
    message.0
}

/// A part of an IMU and the first element of its covariance.
pub type Part<const N: usize> = ([f64; N], f64);

/// An IMU: orientation x y z w, angular velocity, linear acceleration.
pub fn imu(stamp: u64, orientation: Part<4>, velocity: Part<3>, acceleration: Part<3>) -> Vec<u8> {
    let mut message = Cdr::new(stamp);
    let covariance = |first: f64| [first, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    message.numbers(&orientation.0);
    message.numbers(&covariance(orientation.1));
    message.numbers(&velocity.0);
    message.numbers(&covariance(velocity.1));
    message.numbers(&acceleration.0);
    message.numbers(&covariance(acceleration.1));
    message.0
}

/// The orientation of a sensor with x forward and z up at an inclination, nose up positive, rad.
pub fn inclined(inclination: f64) -> [f64; 4] {
    let (sin, cos) = (-0.5 * inclination).sin_cos();
    [0.0, sin, 0.0, cos]
}

/// What the accelerometer of such a sensor shows at rest, m/s^2.
pub fn at_rest(inclination: f64) -> [f64; 3] {
    let (sin, cos) = inclination.sin_cos();
    [9.81 * sin, 0.0, 9.81 * cos]
}

/// Messages by topic: kind, time of the recorder (ns), bytes.
#[derive(Default)]
pub struct Topics(Vec<(&'static str, &'static str, u64, Vec<u8>)>);

impl Topics {
    pub fn add(&mut self, topic: &'static str, kind: &'static str, time: u64, message: Vec<u8>) {
        self.0.push((topic, kind, time, message));
    }

    /// Writes the messages between two times, ns.
    pub fn write(&self, path: &Path, from: u64, to: u64) {
        let file = std::fs::File::create(path).unwrap();
        let mut writer = mcap::Writer::new(file).unwrap();
        let mut channels = BTreeMap::new();
        for (sequence, (topic, kind, time, data)) in self.0.iter().enumerate() {
            if !(from..to).contains(time) {
                continue;
            }
            let channel = *channels.entry(topic).or_insert_with(|| {
                let schema = writer.add_schema(kind, "ros2msg", b"").unwrap();
                writer
                    .add_channel(schema, topic, "cdr", &BTreeMap::new())
                    .unwrap()
            });
            let header = mcap::records::MessageHeader {
                channel_id: channel,
                sequence: u32::try_from(sequence).unwrap(),
                log_time: *time,
                publish_time: *time,
            };
            writer.write_to_known_channel(&header, data).unwrap();
        }
        writer.finish().unwrap();
    }
}

pub const JOINTS: &str = "sensor_msgs/msg/JointState";
pub const IMU: &str = "sensor_msgs/msg/Imu";

/// A row of a level drive: its time (ns), angles, torques, inclinations and rates.
pub struct Sample {
    pub time: u64,
    pub angles: [f64; 3],
    pub torques: [f64; 3],
    pub inclination: [f64; 2],
    pub rate: [f64; 2],
}

/// When the recording starts, ns since 1970.
pub const START: u64 = 1_714_564_800_000_000_000;

/// The rows of a drive.
pub fn samples(drive: &LevelDrive) -> Vec<Sample> {
    let column = |name: &str| {
        let found = drive.columns.iter().find(|(column, _)| column == name);
        found.unwrap().1.clone()
    };
    let wheel = |part: &str| [1, 2, 3].map(|i| column(&format!("wheel{i}_{part}")));
    let link = |part: &str| [1, 2].map(|i| column(&format!("link{i}_{part}")));
    let (angles, torques) = (wheel("angle"), wheel("motor_torque"));
    let (inclination, rate) = (link("inclination"), link("rate"));
    (0..column("time").len())
        .map(|k| Sample {
            time: START + 10_000_000 * k as u64,
            angles: [0, 1, 2].map(|i| angles[i][k]),
            torques: [0, 1, 2].map(|i| torques[i][k]),
            inclination: [0, 1].map(|i| inclination[i][k]),
            rate: [0, 1].map(|i| rate[i][k]),
        })
        .collect()
}

/// The description of joints and of an IMU on each link; `keys` are those of both sensors, `channel` those of the
/// channel of the joints.
pub fn description(keys: &str, channel: &str) -> String {
    let channels = [
        ("joints", "/joint_states"),
        ("imu1", "/imu/link1"),
        ("imu2", "/imu/link2"),
    ];
    let channels = channels.map(|(name, topic)| {
        format!("[[channel]]\nname = \"{name}\"\ntopic = \"{topic}\"\n{channel}\n")
    });
    let wheels = ["front", "middle", "rear"].into_iter().enumerate().map(|(i, joint)| {
        format!(
            "wheel{0}_angle = {{ column = \"{joint}.position\" }}\nwheel{0}_motor_torque = {{ column = \"{joint}.effort\" }}\n",
            i + 1
        )
    });
    let imus = [1, 2].map(|i| format!("[imu.link{i}]\nchannel = \"imu{i}\"\n{keys}\n"));
    format!(
        "missing = [\"wheel1_contact_angle\", \"wheel2_contact_angle\", \"wheel3_contact_angle\"]\n{}\n{}[reading]\n{}{}",
        super::level_drive::DESCRIPTION,
        channels.concat(),
        wheels.collect::<String>(),
        imus.concat(),
    )
}
