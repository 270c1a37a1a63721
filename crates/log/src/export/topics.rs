//! An MCAP file with messages of ROS 2.

use super::forces::{Forces, OF_MESSAGE};
use super::odometry::{Odometry, Step};
use super::readings::{Exported, read};
use crate::channel::Channels;
use crate::error::LogError;
use crate::messages::{
    FORCES, FORCES_DEFINITION, Joint, MessageKind, ODOMETRY, ODOMETRY_DEFINITION, WRENCH,
    WRENCH_DEFINITION, encode_imu, encode_joints, encode_numbers, encode_odometry, encode_wrench,
    nanoseconds,
};
use crate::own_names;
use crate::place::LogPlace;
use crate::readings::{Reading, Values, frame, whole_frame};
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use robhaz_estimator::LinkReading;
use robhaz_run::Stop;
use robhaz_scene::LogChoice;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Topics of an MCAP file being written.
struct Topics<'a> {
    path: &'a Path,
    writer: Writer<BufWriter<File>>,
    names: Vec<String>,
    /// Number of each topic in the file, and of its messages.
    topics: Vec<(u16, u32)>,
}

impl<'a> Topics<'a> {
    fn failed(path: &Path) -> impl FnOnce(McapError) -> LogError + '_ {
        |error| match error {
            McapError::Io(cause) => LogError::write(path)(cause),
            other => LogError::write(path)(other),
        }
    }

    /// Without topics, with the description of the run.
    fn create(path: &'a Path, description: Option<String>) -> Result<Self, LogError> {
        let file = File::create(path).map_err(LogError::write(path))?;
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("robhaz ", env!("CARGO_PKG_VERSION")));
        let mut writer = options
            .create(BufWriter::new(file))
            .map_err(Self::failed(path))?;
        if let Some(text) = description {
            let metadata = Metadata {
                name: own_names::METADATA.to_owned(),
                metadata: BTreeMap::from([(LogPlace::DESCRIPTION.to_owned(), text)]),
            };
            let written = writer.write_metadata(&metadata);
            written.map_err(Self::failed(path))?;
        }
        Ok(Self {
            path,
            writer,
            names: Vec::new(),
            topics: Vec::new(),
        })
    }

    /// Adds a topic: its place.
    fn add(&mut self, topic: String, (schema, definition): Schema) -> Result<usize, LogError> {
        let failed = || Self::failed(self.path);
        let writer = &mut self.writer;
        let schema = writer.add_schema(schema, "ros2msg", definition.as_bytes());
        let schema = schema.map_err(failed())?;
        let channel = writer.add_channel(schema, &topic, "cdr", &BTreeMap::new());
        self.topics.push((channel.map_err(failed())?, 0));
        self.names.push(topic);
        Ok(self.topics.len() - 1)
    }

    /// Writes a message of a topic at a time, s.
    fn write(&mut self, topic: usize, time: f64, data: &[u8]) -> Result<(), LogError> {
        let at = nanoseconds(time);
        let (channel_id, count) = &mut self.topics[topic];
        let header = MessageHeader {
            channel_id: *channel_id,
            sequence: *count,
            log_time: at,
            publish_time: at,
        };
        *count += 1;
        let written = self.writer.write_to_known_channel(&header, data);
        written.map_err(Self::failed(self.path))
    }

    fn finish(mut self) -> Result<(), LogError> {
        self.writer.finish().map_err(Self::failed(self.path))?;
        let mut writer = self.writer.into_inner();
        writer.flush().map_err(LogError::write(self.path))
    }
}

/// Name and definition of a message.
type Schema = (&'static str, &'static str);

/// The topics of the truth or of an estimator, and where its rover is.
struct Estimate<'a> {
    /// Forces of each side, their topic, and that of each wheel.
    sides: Vec<(&'a mut Forces, usize, [usize; 3])>,
    odometry: Option<(usize, Odometry)>,
}

impl<'a> Estimate<'a> {
    fn new(
        sides: &'a mut [Forces],
        choice: &LogChoice,
        topics: &mut Topics<'_>,
    ) -> Result<Self, LogError> {
        // ROS 2 allows letters, digits and `_` in the names of topics.
        let allowed = |name: String| name.replace('-', "_");
        let name = sides.first().map_or(String::new(), |f| f.name.clone());
        let (is_of_both, moves) = (sides.len() > 1, sides.iter().all(Forces::has_slip));
        let mut all = Vec::new();
        for forces in sides {
            let topic = match forces.name.as_str() {
                "truth" => format!("/robhaz/{}", forces.label()),
                _ => format!("/robhaz/estimate/{}", forces.label()),
            };
            let topic = topics.add(allowed(topic), (FORCES, FORCES_DEFINITION))?;
            let mut wheels = [0; 3];
            for (i, wheel) in wheels.iter_mut().enumerate() {
                let topic = format!("/robhaz/wrench/{name}/{}", forces.wheel(i));
                *wheel = topics.add(allowed(topic), (WRENCH, WRENCH_DEFINITION))?;
            }
            all.push((forces, topic, wheels));
        }
        let odometry = match moves {
            true => {
                let topic = allowed(format!("/robhaz/odometry/{name}"));
                let topic = topics.add(topic, (ODOMETRY, ODOMETRY_DEFINITION))?;
                Some((topic, Odometry::new(choice, is_of_both)))
            }
            false => None,
        };
        Ok(Self {
            sides: all,
            odometry,
        })
    }

    /// Writes what it has at a time (s) beside the readings.
    fn write(
        &mut self,
        time: f64,
        readings: &Values,
        topics: &mut Topics<'_>,
    ) -> Result<(), LogError> {
        let (mut slip, mut slope) = (Vec::new(), Vec::new());
        for (forces, topic, wheels) in &mut self.sides {
            let Some(found) = forces.numbers(time) else {
                continue;
            };
            let message = encode_numbers(time, &found.0[..OF_MESSAGE]);
            topics.write(*topic, time, &message)?;
            for (i, [traction, normal]) in found.forces().into_iter().enumerate() {
                if traction.is_finite() && normal.is_finite() {
                    let frame = format!("{}_contact", forces.wheel(i));
                    let message = encode_wrench(time, &frame, [traction, 0.0, normal]);
                    topics.write(wheels[i], time, &message)?;
                }
            }
            slip.extend(found.slip());
            slope.extend(found.slopes());
        }
        let is_whole = slip.len() == 3 * self.sides.len();
        if let Some((topic, odometry)) = self.odometry.as_mut().filter(|_| is_whole) {
            let moved = odometry.add(time, &step(time, readings, slip, slope));
            topics.write(*topic, time, &encode_odometry(time, &moved))?;
        }
        Ok(())
    }
}

/// Readings of a frame, and slip (m/s) and slope (rad) of as many wheels.
fn step(time: f64, readings: &Values, slip: Vec<f64>, slope: Vec<f64>) -> Step {
    let number = |x: Option<f64>| x.unwrap_or(f64::NAN);
    if slip.len() > 3 {
        let whole = whole_frame(time, readings);
        return Step {
            angle: whole.wheel_angle.map(number).to_vec(),
            steering: whole.steering.map(|x| x.unwrap_or(0.0)).to_vec(),
            slip,
            slope,
            attitude: [whole.roll, whole.inclination].map(number),
            rates: whole.rates.map(number),
        };
    }
    let frame = frame(time, readings, None);
    Step {
        angle: frame.wheel_angle.map(number).to_vec(),
        steering: vec![0.0; 3],
        slip,
        slope,
        attitude: [0.0, number(frame.link1.inclination)],
        rates: [0.0, number(frame.link1.rate), 0.0],
    }
}

/// Writes the readings of a run and its forces. The file gets the description of the folder, too.
pub fn write_mcap(
    readings: &Channels,
    forces: &mut [Forces],
    place: &LogPlace,
    out: &Path,
    stop: Stop<'_>,
) -> Result<Exported, LogError> {
    let version = env!("CARGO_PKG_VERSION");
    let description = place.is_described.then(|| place.choice.to_toml(version));
    let mut topics = Topics::create(out, description)?;
    let both = readings.is_of_both();
    let sensors: &[(&str, MessageKind)] = match both {
        false => &[
            (own_names::TOPIC, MessageKind::Readings),
            ("/joint_states", MessageKind::JointState),
            ("/imu/link1", MessageKind::Imu),
            ("/imu/link2", MessageKind::Imu),
        ],
        true => &[
            (own_names::TOPIC, MessageKind::WholeReadings),
            ("/joint_states", MessageKind::JointState),
            ("/imu/body", MessageKind::Imu),
        ],
    };
    for (topic, kind) in sensors {
        topics.add((*topic).to_owned(), (kind.name(), kind.definition()))?;
    }
    let mut estimates = Vec::new();
    for sides in forces.chunk_by_mut(|a, b| a.name == b.name) {
        estimates.push(Estimate::new(sides, &place.choice, &mut topics)?);
    }
    let mut last = None;
    let joints = joints_of_both();
    let parts = topics.names.clone();
    let exported = read(readings, parts, stop, |time, now| {
        let messages = match both {
            false => of_one_side(time, &now, last.as_ref()),
            true => of_both_sides(time, &now, last.as_ref(), &joints),
        };
        last = Some((time, now));
        for (topic, message) in messages.iter().enumerate() {
            topics.write(topic, time, message)?;
        }
        let mut all = estimates.iter_mut();
        all.try_for_each(|estimate| estimate.write(time, &now, &mut topics))
    })?;
    topics.finish()?;
    Ok(exported)
}

/// A joint. No sensor measures the speed: it is the difference of the last two angles.
fn joint(
    name: String,
    (time, position): (f64, Option<f64>),
    before: Option<(f64, Option<f64>)>,
    effort: Option<f64>,
) -> Joint {
    let speed = before.and_then(|(before, last)| Some((position? - last?) / (time - before)));
    Joint {
        name,
        numbers: [position, speed, effort].map(|x| x.unwrap_or(f64::NAN)),
    }
}

/// The messages of one frame of one side: readings, joints, both IMUs. `last` is the frame before.
fn of_one_side(time: f64, now: &Values, last: Option<&(f64, Values)>) -> Vec<Vec<u8>> {
    let readings: Vec<f64> = Reading::of_frame().map(|r| number(now, r)).collect();
    let now = frame(time, now, None);
    let last = last.map(|(time, last)| frame(*time, last, None));
    let joints = [0, 1, 2].map(|i| {
        let before = last.map(|f| (f.time, f.wheel_angle[i]));
        let position = (time, now.wheel_angle[i]);
        joint(
            format!("wheel{}", i + 1),
            position,
            before,
            now.motor_torque[i],
        )
    });
    let imu = |name: &str, link: LinkReading| {
        let [inclination, rate] = [link.inclination, link.rate].map(|x| x.unwrap_or(f64::NAN));
        encode_imu(time, name, [0.0, inclination], [0.0, rate, 0.0])
    };
    vec![
        encode_numbers(time, &readings),
        encode_joints(time, &joints),
        imu("link1", now.link1),
        imu("link2", now.link2),
    ]
}

/// A joint of both sides: its angle, and the torque of its motor.
struct JointOfBoth {
    name: &'static str,
    angle: Reading,
    torque: Option<Reading>,
    /// A wheel that is not steered has no such joint, and a rover one of two couplings.
    may_lack: bool,
}

fn joints_of_both() -> Vec<JointOfBoth> {
    let of = |angle: Reading| {
        let full = angle.name();
        let name = full.strip_suffix("_angle").unwrap_or(full);
        let mut all = Reading::of_whole();
        let torque = all.find(|r| r.name().strip_suffix("_motor_torque") == Some(name));
        let is_coupling = ["differential_angle", "rear_bogie_angle"].contains(&full);
        let may_lack = is_coupling || full.ends_with("_steering");
        (may_lack || full.ends_with("_angle")).then_some(JointOfBoth {
            name,
            angle,
            torque,
            may_lack,
        })
    };
    Reading::of_whole().filter_map(of).collect()
}

/// The messages of one frame of both sides: readings, `joints`, the body's IMU.
fn of_both_sides(
    time: f64,
    now: &Values,
    last: Option<&(f64, Values)>,
    joints: &[JointOfBoth],
) -> Vec<Vec<u8>> {
    let readings: Vec<f64> = Reading::of_whole().map(|r| number(now, r)).collect();
    let body = whole_frame(time, now);
    let value = |r: Reading| now[r.index()];
    let joints = joints
        .iter()
        .filter(|j| !j.may_lack || value(j.angle).is_some());
    let of = |j: &JointOfBoth| {
        let before = last.map(|(time, last)| (*time, last[j.angle.index()]));
        let position = (time, value(j.angle));
        joint(
            j.name.to_owned(),
            position,
            before,
            j.torque.and_then(value),
        )
    };
    let joints: Vec<Joint> = joints.map(of).collect();
    let [roll, inclination] = [body.roll, body.inclination].map(|x| x.unwrap_or(f64::NAN));
    let rates = body.rates.map(|x| x.unwrap_or(f64::NAN));
    vec![
        encode_numbers(time, &readings),
        encode_joints(time, &joints),
        encode_imu(time, "base_link", [roll, inclination], rates),
    ]
}

fn number(values: &Values, reading: Reading) -> f64 {
    values[reading.index()].unwrap_or(f64::NAN)
}
