"""Exported MCAP files, read by a decoder of ROS 2 messages that is not ours."""

import csv
import math
import os
import subprocess
from pathlib import Path

import pytest

reader = pytest.importorskip("mcap.reader")
decoder = pytest.importorskip("mcap_ros2.decoder")
ROOT = Path(__file__).resolve().parents[3]
COMMAND = os.environ.get("ROBHAZ")
pytestmark = pytest.mark.skipif(not COMMAND, reason="the variable ROBHAZ does not name the command")


def _command(folder, *args):
    subprocess.run([COMMAND, *map(str, args)], cwd=folder, check=True, capture_output=True)


def _messages(file):
    """All messages by topic; every schema is known to the decoder."""
    found = {}
    with file.open("rb") as stream:
        messages = reader.make_reader(stream, decoder_factories=[decoder.DecoderFactory()])
        for schema, channel, _, message in messages.iter_decoded_messages():
            assert schema.encoding == "ros2msg"
            found.setdefault(channel.topic, []).append(message)
    return found


def _table(file):
    with file.open() as stream:
        return [{k: float(v or "nan") for k, v in row.items()} for row in csv.DictReader(stream)]


def _seconds(message):
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """Runs up a ramp with typical sensors, on ground that grips and on ground that is slippery."""
    folder = tmp_path_factory.mktemp("drive")
    slippery = 'terrain.stretch=[{ from = "-10 m", to = "10 m", mu_s = 0.3, mu_d = 0.25 }]'
    sets = ["sensors.grade=typical", "record.duration=8", "record.rate=100", "sensors.rate=100"]
    for name, more in (("run", []), ("slips", [slippery])):
        fixed = ["--engine=direct", "--rerun=off", "--format=csv", f"--out={name}"]
        _command(folder, "run", ROOT / "scenes/ramp.toml", *fixed, *(f"--set={s}" for s in [*sets, *more]))
        _command(folder, "export", name, "--to", "mcap")
    return folder


def test_wrenches_are_the_forces_of_the_table(drive):
    messages, table = _messages(drive / "run.mcap"), _table(drive / "run/estimate-kalman.csv")
    for i in (1, 2, 3):
        wrenches = messages[f"/robhaz/wrench/kalman/wheel{i}"]
        rows = [row for row in table if math.isfinite(row[f"wheel{i}_normal_force"])]
        assert len(wrenches) == len(rows) > 700
        for row, message in zip(rows, wrenches, strict=True):
            force = message.wrench.force
            assert message.header.frame_id == f"wheel{i}_contact"
            # Stamps are whole nanoseconds.
            assert abs(_seconds(message) - row["time"]) < 1e-9
            assert (force.x, force.y, force.z) == (row[f"wheel{i}_traction"], 0, row[f"wheel{i}_normal_force"])
            assert (message.wrench.torque.x, message.wrench.torque.y, message.wrench.torque.z) == (0, 0, 0)


def _end(folder, name):
    """Way, its deviation and its error at the end of a run, m, by the middle of its axles."""
    last = _messages(folder / f"{name}.mcap")["/robhaz/odometry/kalman"][-1]
    rows = _table(folder / name / "truth.csv")
    way = sum(rows[-1][f"wheel{i}_x"] - rows[0][f"wheel{i}_x"] for i in (1, 2, 3)) / 3
    x = last.pose.pose.position.x
    assert (last.header.frame_id, last.child_frame_id) == ("odom", "link1")
    return way, math.sqrt(last.pose.covariance[0]), x - way


def test_odometry_states_what_slip_costs(drive):
    """The error is within two stated deviations, and the deviation grows where the wheels slip."""
    way, deviation, error = _end(drive, "run")
    assert way > 0.5
    assert abs(error) < 2 * deviation, (way, deviation, error)
    slippery, grown, error = _end(drive, "slips")
    assert abs(error) < 2 * grown, (slippery, grown, error)
    assert grown / slippery > 1.4 * deviation / way, (deviation, grown)


def test_both_sides(tmp_path):
    """Forces of six wheels, body and joints of an estimate of both sides."""
    folder, fixture = tmp_path, ROOT / "tests/logs/both"
    robot = ROOT / "robots/open-source-rover.toml"
    _command(folder, "estimate", fixture / "readings.csv", "--robot", robot, "--format=csv", "--rerun=off", "--out=both")
    _command(folder, "export", "both", "--to", "mcap")
    messages, table = _messages(folder / "both.mcap"), _table(folder / "both/estimate-kalman.csv")
    readings = _table(fixture / "readings.csv")
    for side in ("left", "right"):
        for i in (1, 2, 3):
            wheel = f"{side}_wheel{i}"
            wrenches = messages[f"/robhaz/wrench/kalman/{wheel}"]
            assert wrenches[0].header.frame_id == f"{wheel}_contact"
            found = [(m.wrench.force.x, m.wrench.force.z) for m in wrenches]
            assert found == [(row[f"{wheel}_traction"], row[f"{wheel}_normal_force"]) for row in table]
        forces = messages[f"/robhaz/estimate/kalman_{side}"]
        assert [m.normal_force[2] for m in forces] == [row[f"{side}_wheel3_normal_force"] for row in table]
    joints = messages["/joint_states"]
    names = [f"{side}_wheel{i}" for side in ("left", "right") for i in (1, 2, 3)]
    assert list(joints[0].name) == [*names, "left_pin", "right_pin", "differential"]
    assert [m.position[6] for m in joints] == [row["left_pin_angle"] for row in readings]
    assert [m.effort[5] for m in joints] == [row["right_wheel3_motor_torque"] for row in readings]
    for message, row in zip(messages["/imu/body"], readings, strict=True):
        q, rate = message.orientation, message.angular_velocity
        # Up in the body's axes, from the quaternion and from the readings; rounding.
        up = (2 * (q.x * q.z - q.w * q.y), 2 * (q.y * q.z + q.w * q.x), 1 - 2 * (q.x**2 + q.y**2))
        pitch, roll = row["body_inclination"], row["body_roll"]
        expected = (math.sin(pitch), math.cos(pitch) * math.sin(roll), math.cos(pitch) * math.cos(roll))
        assert up == pytest.approx(expected, abs=1e-12)
        assert (rate.x, -rate.y, rate.z) == (row["body_roll_rate"], row["body_rate"], row["body_yaw_rate"])
    odometry = messages["/robhaz/odometry/kalman"]
    assert odometry[0].child_frame_id == "base_link"
    ways = [m.pose.pose.position.x for m in odometry]
    deviations = [m.pose.covariance[0] for m in odometry]
    assert ways[-1] > 0.1
    assert deviations == sorted(deviations)
    # The wheels' mean, less their slip.
    rolled = sum(readings[-1][f"{w}_angle"] - readings[0][f"{w}_angle"] for w in names) / 6 * 0.075
    assert abs(ways[-1] - rolled) < 0.1 * rolled
