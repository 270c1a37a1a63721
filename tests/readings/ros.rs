//! Messages of ROS 2 as nodes publish them, and bags as `ros2 bag` leaves them.

use crate::readings::level_drive::{LevelDrive, check_of, estimate_of, largest_error, refused};
use crate::readings::messages::{
    IMU, JOINTS, START, Sample, Topics, at_rest, description, imu, inclined, joints, samples,
};
use crate::support::{assert_contains, text};
use std::fs;
use std::path::Path;

/// Topics of the joints and of an IMU on each link, whose message is made of inclination and rate.
fn topics(of_imu: impl Fn(u64, f64, f64) -> Vec<u8>) -> Topics {
    with_joints(|s| joints(s.time, &s.angles, &[], &s.torques), of_imu)
}

fn with_joints(
    of_joints: impl Fn(&Sample) -> Vec<u8>,
    of_imu: impl Fn(u64, f64, f64) -> Vec<u8>,
) -> Topics {
    let mut topics = Topics::default();
    for sample in samples(&LevelDrive::new(1)) {
        topics.add("/joint_states", JOINTS, sample.time, of_joints(&sample));
        for (i, topic) in ["/imu/link1", "/imu/link2"].into_iter().enumerate() {
            let message = of_imu(sample.time, sample.inclination[i], sample.rate[i]);
            topics.add(topic, IMU, sample.time, message);
        }
    }
    topics
}

/// An IMU with x forward and z up that measures all.
fn usual(time: u64, inclination: f64, rate: f64) -> Vec<u8> {
    let force = at_rest(inclination);
    imu(
        time,
        (inclined(inclination), 0.0),
        ([0.0, -rate, 0.0], 0.0),
        (force, 0.0),
    )
}

/// `check` finds no fault, and N is that of the static loads as in the drive's own test.
fn is_right(folder: &Path, log: &str) {
    for output in [check_of(folder, log), estimate_of(folder, log)] {
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(output.status.success(), "{said}");
    }
    let error = largest_error(folder);
    assert!(error < 2.0, "{error} N");
}

fn written(topics: &Topics, description: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    topics.write(&folder.path().join("log.mcap"), 0, u64::MAX);
    fs::write(folder.path().join("d.toml"), description).unwrap();
    folder
}

/// What a message states not to measure is missing, not zero: -1 in the covariance, or a quaternion without length.
#[test]
fn what_is_not_measured_is_missing() {
    let orientation = description("inclination = \"orientation\"", "");
    type Message = fn(u64, f64, f64) -> Vec<u8>;
    let without: [Message; 2] = [
        |t, i, r| {
            let identity = ([0.0, 0.0, 0.0, 1.0], -1.0);
            imu(t, identity, ([0.0, -r, 0.0], 0.0), (at_rest(i), 0.0))
        },
        |t, i, r| imu(t, ([0.0; 4], 0.0), ([0.0, -r, 0.0], 0.0), (at_rest(i), 0.0)),
    ];
    for of_imu in without {
        let folder = written(&topics(of_imu), &orientation);
        let parts = [
            "link1_inclination has no value in 601 messages",
            "inclination = \"acceleration\"",
        ];
        refused(folder.path(), "log.mcap", &parts);
        fs::write(folder.path().join("d.toml"), description("", "")).unwrap();
        is_right(folder.path(), "log.mcap");
    }
    let no_gyro = |t, i, _| imu(t, (inclined(i), 0.0), ([0.0; 3], -1.0), (at_rest(i), 0.0));
    let folder = written(&topics(no_gyro), &orientation);
    refused(
        folder.path(),
        "log.mcap",
        &["link1_rate has no value", "rate_channel"],
    );
    let no_force = |t, i, r: f64| {
        imu(
            t,
            (inclined(i), 0.0),
            ([0.0, -r, 0.0], 0.0),
            ([0.0; 3], -1.0),
        )
    };
    let folder = written(&topics(no_force), &description("", ""));
    refused(
        folder.path(),
        "log.mcap",
        &[
            "link1_inclination has no value",
            "inclination = \"orientation\"",
        ],
    );
}

/// Gyroscope and accelerometer with topics of their own, by `rate_channel` or by a reading of its own.
#[test]
fn gyroscope_and_accelerometer_may_be_apart() {
    let mut topics = Topics::default();
    let none = ([0.0, 0.0, 0.0, 1.0], -1.0);
    for s in samples(&LevelDrive::new(1)) {
        let message = joints(s.time, &s.angles, &[], &s.torques);
        topics.add("/joint_states", JOINTS, s.time, message);
        let of_link = [("/imu/link1", "/gyro/link1"), ("/imu/link2", "/gyro/link2")];
        for (i, (force, gyro)) in of_link.into_iter().enumerate() {
            let rate = ([0.0, -s.rate[i], 0.0], 0.0);
            // The gyroscope is 2 ms ahead.
            let message = imu(s.time - 2_000_000, none, rate, ([0.0; 3], -1.0));
            topics.add(gyro, IMU, s.time - 2_000_000, message);
            let message = imu(
                s.time,
                none,
                ([0.0; 3], -1.0),
                (at_rest(s.inclination[i]), 0.0),
            );
            topics.add(force, IMU, s.time, message);
        }
    }
    let gyros =
        [1, 2].map(|i| format!("[[channel]]\nname = \"gyro{i}\"\ntopic = \"/gyro/link{i}\"\n"));
    let own = description("", "").replace("[reading]", &(gyros.concat() + "[reading]"));
    let by_key = [1, 2].into_iter().fold(own.clone(), |text, i| {
        let channel = format!("channel = \"imu{i}\"");
        text.replace(&channel, &format!("{channel}\nrate_channel = \"gyro{i}\""))
    });
    let folder = written(&topics, &by_key);
    is_right(folder.path(), "log.mcap");
    let readings = [1, 2].map(|i| {
        format!("link{i}_rate = {{ channel = \"gyro{i}\", column = \"angular_velocity.y\", sign = \"-\" }}\n")
    });
    let by_reading = own.replace("[imu.link1]", &(readings.concat() + "[imu.link1]"));
    fs::write(folder.path().join("d.toml"), by_reading).unwrap();
    is_right(folder.path(), "log.mcap");
    // Without either the accelerometer's topic has no rate.
    fs::write(folder.path().join("d.toml"), description("", "")).unwrap();
    refused(
        folder.path(),
        "log.mcap",
        &["link1_rate has no value in 601 messages", "rate_channel"],
    );
}

/// Headers without stamps say so, all of them or some; the recorder's times are right.
#[test]
fn headers_without_a_stamp_say_so() {
    let all = with_joints(
        |s| joints(0, &s.angles, &[], &s.torques),
        |_, inclination, rate| usual(0, inclination, rate),
    );
    let folder = written(&all, &description("", ""));
    let parts = [
        "channel joints: all 601 messages have the stamp 0",
        "time = \"log\"",
    ];
    refused(folder.path(), "log.mcap", &parts);
    fs::write(
        folder.path().join("d.toml"),
        description("", "time = \"log\""),
    )
    .unwrap();
    is_right(folder.path(), "log.mcap");
    for at in [START, START + 3_000_000_000] {
        let stamp = move |time| if time == at { 0 } else { time };
        let some = with_joints(|s| joints(stamp(s.time), &s.angles, &[], &s.torques), usual);
        let folder = written(&some, &description("", ""));
        refused(
            folder.path(),
            "log.mcap",
            &["the publisher sets none; state time = \"log\""],
        );
    }
}

/// The folder of a bag is read, with its files in their order; what is in another format says what to do.
#[test]
fn folders_of_bags_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("my_bag");
    fs::create_dir(&bag).unwrap();
    let all = topics(usual);
    let second = START + 2_000_000_000;
    all.write(&bag.join("my_bag_0.mcap"), 0, second);
    all.write(&bag.join("my_bag_1.mcap"), second, u64::MAX);
    fs::write(folder.path().join("d.toml"), description("", "")).unwrap();
    // Killed before its list was written.
    is_right(folder.path(), "my_bag");
    let list = "rosbag2_bagfile_information:\n  version: 9\n  relative_file_paths:\n    - my_bag_0.mcap\n    - my_bag_1.mcap\n";
    fs::write(bag.join("metadata.yaml"), list).unwrap();
    is_right(folder.path(), "my_bag");
    fs::rename(bag.join("my_bag_1.mcap"), bag.join("my_bag_1.mcap.zstd")).unwrap();
    refused(
        folder.path(),
        "my_bag",
        &["my_bag_1.mcap.zstd", "`zstd -d my_bag_1.mcap.zstd`"],
    );
    refused(
        folder.path(),
        "my_bag/my_bag_1.mcap.zstd",
        &["`zstd -d my_bag_1.mcap.zstd`"],
    );
    refused(folder.path(), "my_bag/metadata.yaml", &["name its folder"]);
    fs::write(bag.join("metadata.yaml"), list.replace("mcap", "db3")).unwrap();
    fs::write(bag.join("my_bag_0.db3"), "SQLite format 3").unwrap();
    refused(
        folder.path(),
        "my_bag",
        &["my_bag_0.db3", "ros2 bag convert"],
    );
}

/// Joints with a velocity and no position: the angle is its integral, and the budget has its error.
#[test]
fn velocities_are_integrated() {
    let all = samples(&LevelDrive::new(1));
    let speed = |s: &Sample| {
        let k = all.iter().position(|other| other.time == s.time).unwrap();
        let (before, after) = (&all[k.saturating_sub(1)], &all[(k + 1).min(all.len() - 1)]);
        let step = (after.time - before.time) as f64 * 1e-9;
        [0, 1, 2].map(|i| (after.angles[i] - before.angles[i]) / step)
    };
    let topics = with_joints(|s| joints(s.time, &[], &speed(s), &s.torques), usual);
    let positions = description("", "");
    let folder = written(&topics, &positions);
    let parts = [
        "has no column front.position",
        "column = \"front.velocity\" integrates the speed",
    ];
    refused(folder.path(), "log.mcap", &parts);
    fs::write(
        folder.path().join("d.toml"),
        positions.replace(".position", ".velocity"),
    )
    .unwrap();
    is_right(folder.path(), "log.mcap");
    let said = text(&estimate_of(folder.path(), "log.mcap").stderr);
    let notice = "wheel1_angle is the integral of front.velocity, a speed";
    assert_contains(&said, notice);
    assert_contains(&said, "counts a turn");
}

/// A sensor that hangs upside down shows 180 deg from both sides: `check` names the axis, and with it, or with sign and
/// offset, the log is right.
#[test]
fn a_sensor_may_hang_upside_down() {
    // Turned about its x axis by 180 deg: y and z point the other way.
    let turned = |t, inclination: f64, rate: f64| {
        let [x, y, z, w] = inclined(inclination);
        // The product with the quaternion of the turn, (1, 0, 0, 0).
        let orientation = [w, z, -y, -x];
        let [forward, side, up] = at_rest(inclination);
        imu(
            t,
            (orientation, 0.0),
            ([0.0, rate, 0.0], 0.0),
            ([forward, -side, -up], 0.0),
        )
    };
    for source in ["acceleration", "orientation"] {
        let key = format!("inclination = \"{source}\"");
        let folder = written(&topics(turned), &description(&key, ""));
        let output = check_of(folder.path(), "log.mcap");
        let said = text(&output.stdout);
        assert!(
            !output.status.success() && said.contains("up = \"-z\" of imu.link1"),
            "{said}"
        );
        assert_contains(&said, "2 with a fault");
        let keys = format!("{key}\nup = \"-z\"");
        fs::write(folder.path().join("d.toml"), description(&keys, "")).unwrap();
        is_right(folder.path(), "log.mcap");
        let keys = format!("{key}\ninclination_offset = \"180 deg\"");
        fs::write(folder.path().join("d.toml"), description(&keys, "")).unwrap();
        is_right(folder.path(), "log.mcap");
    }
}

/// A world with z down, and bodies with z down, by one key.
#[test]
fn a_world_may_have_its_z_axis_down() {
    let aviation = |t, inclination: f64, rate: f64| {
        let (sin, cos) = (0.5 * inclination).sin_cos();
        let force = [9.81 * inclination.sin(), 0.0, -9.81 * inclination.cos()];
        imu(
            t,
            ([0.0, sin, 0.0, cos], 0.0),
            ([0.0, rate, 0.0], 0.0),
            (force, 0.0),
        )
    };
    for source in ["acceleration", "orientation"] {
        let keys = format!("inclination = \"{source}\"\nworld = \"NED\"");
        let folder = written(&topics(aviation), &description(&keys, ""));
        is_right(folder.path(), "log.mcap");
    }
}
