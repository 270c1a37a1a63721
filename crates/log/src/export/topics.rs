//! An MCAP file with messages of ROS 2.

use super::forces::{AXIAL, Forces, OF_MESSAGE, SLIP, SLOPE};
use super::odometry::{Odometry, Step};
use super::readings::{Exported, read};
use super::sensors::Sensors;
use crate::messages::{
    FORCES, ODOMETRY, Schema, WRENCH, encode_numbers, encode_wrench, nanoseconds,
};
use crate::{Channels, LogError, LogPlace, own_names};
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use robhaz_run::Stop;
use robhaz_scene::{LogChoice, Values, frame, whole_frame};
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
        let writer = options.create(BufWriter::new(file));
        let mut writer = writer.map_err(Self::failed(path))?;
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
            let topic = topics.add(allowed(topic), FORCES)?;
            let mut wheels = [0; 3];
            for (i, wheel) in wheels.iter_mut().enumerate() {
                let topic = format!("/robhaz/wrench/{name}/{}", forces.wheel(i));
                *wheel = topics.add(allowed(topic), WRENCH)?;
            }
            all.push((forces, topic, wheels));
        }
        let mut estimate = Self {
            sides: all,
            odometry: None,
        };
        if moves {
            let topic = allowed(format!("/robhaz/odometry/{name}"));
            let topic = topics.add(topic, ODOMETRY)?;
            estimate.odometry = Some((topic, Odometry::new(choice, is_of_both)));
        }
        Ok(estimate)
    }

    /// Writes what it has at a time (s) beside the readings.
    fn write(
        &mut self,
        time: f64,
        readings: &Values,
        sensors: &Sensors,
        topics: &mut Topics<'_>,
    ) -> Result<(), LogError> {
        let (mut slip, mut slope) = (Vec::new(), Vec::new());
        for (forces, topic, wheels) in &mut self.sides {
            let Some(found) = forces.at(time).copied() else {
                continue;
            };
            let message = encode_numbers(time, found[..OF_MESSAGE].as_flattened());
            topics.write(*topic, time, &message)?;
            let [normal, traction, ..] = found;
            for (i, (normal, traction)) in normal.into_iter().zip(traction).enumerate() {
                if traction.is_finite() && normal.is_finite() {
                    let frame = format!("{}_contact", forces.wheel(i));
                    // Of one side none is known.
                    let axial = found[AXIAL][i];
                    let axial = if axial.is_finite() { axial } else { 0.0 };
                    let force = [traction, axial, normal];
                    let message = encode_wrench(time, &frame, force);
                    topics.write(wheels[i], time, &message)?;
                }
            }
            slip.extend(found[SLIP]);
            slope.extend(found[SLOPE]);
        }
        let is_whole = slip.len() == 3 * self.sides.len();
        if let Some((topic, odometry)) = self.odometry.as_mut().filter(|_| is_whole) {
            let message = odometry.add(time, &step(time, readings, sensors, [slip, slope]));
            topics.write(*topic, time, &message)?;
        }
        Ok(())
    }
}

/// The step of a frame, with slip (m/s) and slope (rad) of as many wheels.
fn step(time: f64, readings: &Values, sensors: &Sensors, [slip, slope]: [Vec<f64>; 2]) -> Step {
    let number = |x: Option<f64>| x.unwrap_or(f64::NAN);
    let (angle, steering) = if slip.len() > 3 {
        let whole = whole_frame(time, readings);
        let steering = whole.steering.map(|x| x.unwrap_or(0.0));
        (whole.wheel_angle.map(number).to_vec(), steering.to_vec())
    } else {
        let frame = frame(time, readings, None);
        (frame.wheel_angle.map(number).to_vec(), vec![0.0; 3])
    };
    let (attitude, rates) = sensors.imu(0, readings);
    Step {
        angle,
        steering,
        slip,
        slope,
        attitude,
        rates,
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
    let mut sensors = Sensors::new(readings.is_of_both());
    for (topic, kind) in &sensors.topics {
        topics.add(topic.clone(), (kind.name(), kind.definition()))?;
    }
    let mut estimates = Vec::new();
    for sides in forces.chunk_by_mut(|a, b| a.name == b.name) {
        estimates.push(Estimate::new(sides, &place.choice, &mut topics)?);
    }
    let parts = topics.names.clone();
    let exported = read(readings, parts, stop, |time, now| {
        for (topic, message) in sensors.messages(time, &now).iter().enumerate() {
            topics.write(topic, time, message)?;
        }
        let mut all = estimates.iter_mut();
        all.try_for_each(|estimate| estimate.write(time, &now, &sensors, &mut topics))
    })?;
    topics.finish()?;
    Ok(exported)
}
