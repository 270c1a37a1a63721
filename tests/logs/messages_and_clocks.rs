//! Logs of other sources: standard messages, and tables with clocks, rates and units of their own.

use super::recorded::{estimated, recorded, refused};
use crate::support::{assert_contains, robhaz, root, summary, words};
use std::fmt::Write as _;
use std::path::Path;

/// The numbers of a CSV table by columns; empty cells as not a number.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let names = reader
        .headers()
        .unwrap()
        .iter()
        .map(str::to_owned)
        .collect();
    let rows = reader.records().map(|row| {
        let row = row.unwrap();
        row.iter()
            .map(|cell| cell.parse().unwrap_or(f64::NAN))
            .collect()
    });
    (names, rows.collect())
}

/// Largest difference of the columns of two tables whose names end like this, over rows from a time
/// (s) on.
fn difference(a: &Path, b: &Path, end: &str, from: f64) -> f64 {
    let ((names, a), (other, b)) = (table(a), table(b));
    assert_eq!((&names, a.len()), (&other, b.len()));
    let columns: Vec<usize> = (0..names.len())
        .filter(|i| names[*i].ends_with(end))
        .collect();
    assert!(!columns.is_empty());
    let mut largest = 0.0_f64;
    for (a, b) in a.iter().zip(&b).filter(|(a, _)| a[0] >= from) {
        for i in &columns {
            assert!(
                a[*i].is_nan() == b[*i].is_nan(),
                "{} at {}",
                names[*i],
                a[0]
            );
            largest = largest.max((a[*i] - b[*i]).abs());
        }
    }
    largest
}

/// Exports the folder `run` to `run.mcap` with the messages alone, as other recorders write it:
/// without the run's description.
pub fn exported_messages(folder: &Path) {
    let mut export = robhaz(folder);
    export.args(["export", "run", "--to", "mcap", "--out", "described.mcap"]);
    assert!(export.status().unwrap().success());
    rewritten(
        &folder.join("described.mcap"),
        &folder.join("run.mcap"),
        |message, writer| writer.write(&message).unwrap(),
    );
}

/// The example of a description, with this offset of the IMUs: exported ones have no delay.
fn example(offset: &str) -> String {
    let example = std::fs::read_to_string(root().join("examples/logs/SENSORS.toml")).unwrap();
    example.replace("\"-2 ms\"", offset)
}

/// Writes the messages of an MCAP file into another one, as `write` does with each.
fn rewritten(
    from: &Path,
    to: &Path,
    mut write: impl FnMut(mcap::Message<'_>, &mut mcap::Writer<std::fs::File>),
) {
    let bytes = std::fs::read(from).unwrap();
    let mut writer = mcap::Writer::new(std::fs::File::create(to).unwrap()).unwrap();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        write(message.unwrap(), &mut writer);
    }
    writer.finish().unwrap();
}

/// The standard messages in an exported file, read with the example's description: time stamps are
/// whole nanoseconds and inclinations pass through a quaternion, which changes N by less than 10
/// nN.
#[test]
fn standard_messages_give_nearly_the_same_estimates() {
    let (folder, _) = recorded("csv", &["sensors.dropped=0"]);
    exported_messages(folder.path());
    let example = example("0");
    std::fs::write(folder.path().join("SENSORS.toml"), &example).unwrap();
    let common = words("--sensors SENSORS.toml --estimator kalman --format csv");
    let direct = [
        &words("run/sensors.csv --contact-angles none --out direct"),
        &common[2..],
    ];
    // The same budget for both: that of the example, without its columns.
    let budget: String = example
        .split("[[channel]]")
        .next()
        .unwrap()
        .lines()
        .filter(|line| !line.starts_with("missing") && !line.starts_with("time_base"))
        .fold(String::new(), |text, line| text + line + "\n");
    std::fs::write(folder.path().join("budget.toml"), budget).unwrap();
    estimated(
        folder.path(),
        &[&direct.concat()[..], &["--sensors", "budget.toml"]].concat(),
    );
    estimated(
        folder.path(),
        &[&["run.mcap", "--out", "mcap"], &common[..]].concat(),
    );
    let [a, b] = ["direct", "mcap"].map(|f| folder.path().join(f).join("estimate-kalman.csv"));
    let largest = difference(&a, &b, "normal_force", 0.0);
    // Ten times what was found over 20 s; a wrong sign or a lost reading changes N by 0.01 N and
    // more.
    assert!(largest < 1e-8, "{largest} N");
    assert!(largest > 0.0, "nothing was rounded: the files are the same");
}

/// Sets the clock of both IMUs of an MCAP file ahead, by 100 s in the headers and by 200 s where it
/// was recorded.
fn set_ahead(from: &Path, to: &Path) {
    rewritten(from, to, |mut message, writer| {
        if message.channel.topic.starts_with("/imu/") {
            let mut data = message.data.into_owned();
            // CDR: four bytes of encapsulation, then the seconds of the stamp.
            let seconds: [u8; 4] = data[4..8].try_into().unwrap();
            let seconds = i32::from_le_bytes(seconds) + 100;
            data[4..8].copy_from_slice(&seconds.to_le_bytes());
            message.data = data.into();
            message.log_time += 200_000_000_000;
        }
        writer.write(&message).unwrap();
    });
}

/// A copy of a file whose messages have another encoding, each changed.
fn encoded(from: &Path, to: &Path, encoding: &str, change: impl Fn(&mut Vec<u8>)) {
    rewritten(from, to, |mut message, writer| {
        let mut channel = (*message.channel).clone();
        encoding.clone_into(&mut channel.message_encoding);
        message.channel = channel.into();
        change(message.data.to_mut());
        writer.write(&message).unwrap();
    });
}

/// Messages in another encoding, and those that are compressed one by one, are named with what to convert; a chunk
/// whose bytes were damaged is none, though its messages can be decoded.
#[test]
fn other_encodings_and_damaged_chunks_are_named() {
    let (folder, _) = recorded("csv", &["record.duration=1.5"]);
    let folder = folder.path();
    exported_messages(folder);
    std::fs::write(folder.join("mine.toml"), example("0")).unwrap();
    let (run, other) = (folder.join("run.mcap"), folder.join("other.mcap"));
    let zstd = [0x28, 0xb5, 0x2f, 0xfd];
    for (encoding, starts, expected) in [
        ("json", [0; 4], ["in the encoding \"json\"", "as a table"]),
        (
            "ros1",
            [0; 4],
            ["in the encoding \"ros1\"", "rosbags-convert"],
        ),
        (
            "cdr",
            zstd,
            ["compression_mode MESSAGE", "ros2 bag convert"],
        ),
    ] {
        encoded(&run, &other, encoding, |data| {
            if starts == zstd {
                data[..4].copy_from_slice(&zstd);
            }
        });
        let error = refused(folder, &["other.mcap", "--sensors", "mine.toml"]);
        for expected in expected {
            assert!(error.contains(expected), "{expected}: {error}");
        }
    }
    let plain = mcap::WriteOptions::new().compression(None);
    let mut writer = plain
        .create(std::fs::File::create(&other).unwrap())
        .unwrap();
    for message in mcap::MessageStream::new(&std::fs::read(&run).unwrap()).unwrap() {
        writer.write(&message.unwrap()).unwrap();
    }
    writer.finish().unwrap();
    let mut bytes = std::fs::read(&other).unwrap();
    estimated(folder, &["other.mcap", "--sensors", "mine.toml"]);
    // In the position of the first joint of the last message.
    let name = b"wheel1\0";
    let place = bytes.windows(name.len()).rposition(|w| w == name).unwrap();
    bytes[place + 45] ^= 1;
    std::fs::write(&other, bytes).unwrap();
    let error = refused(folder, &["other.mcap", "--sensors", "mine.toml"]);
    assert!(error.to_lowercase().contains("crc"), "{error}");
}

/// Topics with clocks of their own, by their headers and by the recorder: with the offsets the
/// estimates are those of the file with one clock, but for the rounding of the times; without them
/// no row is in common.
#[test]
fn topics_with_two_clocks_are_brought_onto_one_time() {
    let (folder, _) = recorded("csv", &["sensors.dropped=0"]);
    let folder = folder.path();
    exported_messages(folder);
    set_ahead(&folder.join("run.mcap"), &folder.join("two.mcap"));
    let estimate = |log: &str, offset: &str, out: &str| {
        let sensors = format!("{out}.toml");
        std::fs::write(folder.join(&sensors), example(offset)).unwrap();
        let args = [log, "--sensors", &sensors, "--estimator", "kalman"];
        let out = ["--format", "csv", "--out", out];
        estimated(folder, &[&args[..], &out].concat());
    };
    estimate("run.mcap", "0", "one");
    estimate("two.mcap", "\"-100 s\"", "header");
    estimate("two.mcap", "\"-200 s\"\ntime = \"log\"", "log");
    let table = |out: &str| folder.join(out).join("estimate-kalman.csv");
    for out in ["header", "log"] {
        let largest = difference(&table("one"), &table(out), "normal_force", 0.0);
        // As above; a reading that goes to the next frame changes N by 1e-4 N and more.
        assert!(largest < 1e-8, "{out}: {largest} N");
    }
    std::fs::write(folder.join("none.toml"), example("0")).unwrap();
    let error = refused(folder, &["two.mcap", "--sensors", "none.toml"]);
    assert_contains(&error, "no row in common");
}

/// A copy of an exported run in which each message of `/joint_states` is three of one wheel each,
/// that of wheel i later by (i - 1) `apart` (ns).
fn one_wheel_a_message(from: &Path, to: &Path, apart: u32) {
    rewritten(from, to, |mut message, writer| {
        if message.channel.topic != "/joint_states" {
            return writer.write(&message).unwrap();
        }
        // CDR: four bytes of encapsulation, from which on alignment counts: seconds, nanoseconds,
        // an empty frame, three names, and three sequences of three doubles.
        let whole = message.data.into_owned();
        assert_eq!(whole.len(), 4 + 152);
        for wheel in 0..3 {
            let mut data = whole[..4 + 16].to_vec();
            let mut nanoseconds = u32::from_le_bytes(data[8..12].try_into().unwrap());
            nanoseconds += apart * wheel as u32;
            data[8..12].copy_from_slice(&nanoseconds.to_le_bytes());
            data.extend(1_u32.to_le_bytes());
            data.extend(7_u32.to_le_bytes());
            data.extend(format!("wheel{}\0\0", wheel + 1).bytes());
            for start in [64, 96, 128] {
                data.extend(1_u32.to_le_bytes());
                data.resize((data.len() - 4).next_multiple_of(8) + 4, 0);
                let at = 4 + start + 8 * wheel;
                data.extend(&whole[at..at + 8]);
            }
            message.data = data.into();
            writer.write(&message).unwrap();
        }
    });
}

/// Drives that publish their own joint each on one topic: of one stamp their messages are one row,
/// and the estimates are those of whole messages to the bit. With stamps of their own each drive is
/// a channel of that topic, stated or not.
#[test]
fn joints_in_messages_of_their_own_are_read() {
    let (folder, _) = recorded("csv", &["sensors.dropped=0"]);
    let folder = folder.path();
    exported_messages(folder);
    let example = example("0");
    std::fs::write(folder.join("one.toml"), &example).unwrap();
    let mut three = example.replace(
        "name = \"joints\"\ntopic = \"/joint_states\"\n",
        "name = \"joints\"\ntopic = \"/joint_states\"\n[[channel]]\nname = \"middle\"\ntopic = \"/joint_states\"\n\
         offset = -1e-7\n[[channel]]\nname = \"rear\"\ntopic = \"/joint_states\"\noffset = -2e-7\n",
    );
    for (wheel, channel) in [(2, "middle"), (3, "rear")] {
        for part in ["position", "effort"] {
            let column = format!("column = \"wheel{wheel}.{part}\"");
            three = three.replace(&column, &format!("{column}, channel = \"{channel}\""));
        }
    }
    std::fs::write(folder.join("three.toml"), three).unwrap();
    one_wheel_a_message(&folder.join("run.mcap"), &folder.join("split.mcap"), 0);
    one_wheel_a_message(&folder.join("run.mcap"), &folder.join("apart.mcap"), 100);
    one_wheel_a_message(&folder.join("run.mcap"), &folder.join("own.mcap"), 20_000);
    let estimate = |log: &str, sensors: &str| {
        let (out, log) = (format!("of-{log}"), format!("{log}.mcap"));
        let out = ["--format", "csv", "--out", &out];
        let args = [&log, "--sensors", sensors, "--estimator", "kalman"];
        estimated(folder, &[&args[..], &out].concat())
    };
    estimate("run", "one.toml");
    let printed = estimate("split", "one.toml");
    assert_contains(&printed, "joints: 2501 rows at 1000 Hz");
    let printed = estimate("apart", "three.toml");
    for channel in ["joints", "middle", "rear"] {
        let rows = format!("{channel}: 2501 rows at 1000 Hz");
        assert_contains(&printed, &rows);
    }
    let printed = estimate("own", "one.toml");
    for wheel in ["wheel1", "wheel2", "wheel3"] {
        let rows = format!("joints, {wheel}_angle: 2501 rows at 1000 Hz");
        assert_contains(&printed, &rows);
    }
    let table = |log: &str| folder.join(format!("of-{log}/estimate-kalman.csv"));
    // 20 and 40 us later they are of the next frame, moved to its time along straight lines, which averages the noise of
    // two readings; the first frame has none. A wheel that is lost, or a frame late, makes whole newtons.
    let largest = difference(&table("run"), &table("own"), "normal_force", 0.5);
    assert!(largest < 0.2, "own: {largest} N");
    for log in ["split", "apart"] {
        // `apart`: offsets are rounded as any time in seconds; a reading in another frame changes N
        // by 1e-4 N and more.
        let largest = difference(&table("run"), &table(log), "normal_force", 0.0);
        assert!(
            largest <= if log == "split" { 0.0 } else { 1e-8 },
            "{log}: {largest} N"
        );
    }
}

/// A second IMU on the topic of the first one, and a joint that a message names twice, are refused; `frame` chooses one IMU,
/// and the estimates are those of a file without the other one to the bit.
#[test]
fn publishers_that_share_a_topic_are_told_apart() {
    let (folder, _) = recorded("csv", &["sensors.dropped=0"]);
    let folder = folder.path();
    exported_messages(folder);
    let run = folder.join("run.mcap");
    let copy = |out: &str, topic: &str, from: &[u8], to: &[u8], keeps: bool| {
        rewritten(&run, &folder.join(out), |mut message, writer| {
            if message.channel.topic != topic {
                return writer.write(&message).unwrap();
            }
            if keeps {
                writer.write(&message).unwrap();
            }
            let data = message.data.to_mut();
            let at = data.windows(from.len()).position(|bytes| bytes == from);
            let at = at.unwrap();
            data[at..at + from.len()].copy_from_slice(to);
            if keeps {
                // Numbers of the orientation: another sensor.
                data[32..48].reverse();
            }
            writer.write(&message).unwrap();
        });
    };
    let example = example("0");
    std::fs::write(folder.join("any.toml"), &example).unwrap();
    for frame in ["link1", "other"] {
        let topic = "topic = \"/imu/link1\"\n";
        let text = example.replace(topic, &format!("{topic}frame = \"{frame}\"\n"));
        assert_ne!(text, example);
        std::fs::write(folder.join(format!("{frame}.toml")), text).unwrap();
    }
    copy("two.mcap", "/imu/link1", b"link1\0", b"camra\0", true);
    let error = refused(folder, &["two.mcap", "--sensors", "any.toml"]);
    let words = "state frame = \"link1\" or \"camra\" in its [[channel]]";
    assert_contains(&error, words);
    let error = refused(folder, &["two.mcap", "--sensors", "other.toml"]);
    let words = "no message with the frame_id \"other\" of the topic /imu/link1, found: \"camra\", \"link1\"";
    assert_contains(&error, words);
    for (log, sensors) in [("run", "any"), ("two", "link1")] {
        let (out, log) = (format!("of-{log}"), format!("{log}.mcap"));
        let sensors = format!("{sensors}.toml");
        let args = [&log, "--sensors", &sensors, "--estimator", "kalman"];
        estimated(
            folder,
            &[&args[..], &["--format", "csv", "--out", &out]].concat(),
        );
    }
    let table = |log: &str| folder.join(log).join("estimate-kalman.csv");
    let largest = difference(&table("of-run"), &table("of-two"), "normal_force", 0.0);
    assert!(largest <= 0.0, "{largest} N");

    copy(
        "twice.mcap",
        "/joint_states",
        b"wheel2\0",
        b"wheel1\0",
        false,
    );
    let error = refused(folder, &["twice.mcap", "--sensors", "any.toml"]);
    assert_contains(&error, "a message has wheel1.position twice");
}

/// Two tables with clocks, rates, units and signs of their own give estimates as accurate as the
/// run's readings.
#[test]
fn two_clocks_are_brought_onto_one_time() {
    let (folder, run) = recorded("csv", &["sensors.dropped=0"]);
    let (names, rows) = table(&run.join("sensors.csv"));
    let column = |name: &str| names.iter().position(|n| n == name).unwrap();
    let log = folder.path().join("log");
    std::fs::create_dir(&log).unwrap();
    let mut joints = "stamp;encoder1;encoder2;encoder3;current1;current2;current3\n".to_owned();
    let mut imus = "t,a1x,a1y,a1z,g1x,g1y,g1z,a2x,a2y,a2z,g2x,g2y,g2z\n".to_owned();
    for (k, row) in rows.iter().enumerate() {
        let stamp = 1_700_000_000_000_000 + (row[0] * 1e6).round() as i64;
        let counts = |i: usize| {
            (row[column(&format!("wheel{i}_angle"))] * 160_000.0 / std::f64::consts::TAU).round()
        };
        let current = |i: usize| {
            format!(
                "{:.9}",
                row[column(&format!("wheel{i}_motor_torque"))] / 4.0
            )
            .replace('.', ",")
        };
        let (c1, c2, c3) = (counts(1), counts(2), -counts(3));
        writeln!(
            joints,
            "{stamp};{c1};{c2};{c3};{};{};{}",
            current(1),
            current(2),
            current(3)
        )
        .unwrap();
        // Every second reading.
        if k % 2 == 0 {
            let imu = |link: usize| {
                let (sin, cos) = row[column(&format!("link{link}_inclination"))].sin_cos();
                let rate = row[column(&format!("link{link}_rate"))].to_degrees();
                format!("{},0.1,{},0,{},0", 9.81 * sin, 9.81 * cos, -rate)
            };
            let time = 1_700_000_100.0 + row[0] - 1e-5;
            writeln!(imus, "{time:?},{},{}", imu(1), imu(2)).unwrap();
        }
    }
    std::fs::write(log.join("joints.csv"), joints).unwrap();
    std::fs::write(log.join("imus.csv"), imus).unwrap();
    let example = root().join("examples/logs/two-tables.toml");
    let mut description = std::fs::read_to_string(example).unwrap();
    description +=
        "\n[[channel]]\nname = \"truth\"\noffset = 1700000000\n\n[record]\ncompare_from = 1\n";
    std::fs::write(folder.path().join("two.toml"), description).unwrap();
    let args = ["log", "--sensors", "two.toml", "--truth", "run/truth.csv"];
    let printed = estimated(folder.path(), &args);
    assert_contains(&printed, "joints: 2501 rows at 1000 Hz");
    assert_contains(&printed, "imus: 1251 rows at 500 Hz");
    let found = summary(&folder.path().join("runs/log-estimate"));
    // Half of the frames have no new inclination.
    assert_eq!(found["log"]["missing"]["link1_inclination"], 1250);
    assert_eq!(found["log"]["missing"]["wheel1_angle"], 0);
    let nrmse = found["estimators"]["kalman-no-angles"]["normal_force"]["nrmse"].as_f64();
    // The run's own figure without contact angles is 2 to 4 % at the start of the course; wrong
    // signs give 20 % and more.
    assert!(nrmse.unwrap() < 0.06, "{nrmse:?}");
    // An offset that is left out leaves no row in common.
    let text = std::fs::read_to_string(folder.path().join("two.toml")).unwrap();
    std::fs::write(
        folder.path().join("bad.toml"),
        text.replace("\"-100 s\"", "0"),
    )
    .unwrap();
    let error = refused(folder.path(), &["log", "--sensors", "bad.toml"]);
    assert_contains(&error, "imus");
    assert_contains(&error, "`offset`");
}
