"""The way from the dataset's files to a log and a table of truth, on a made-up traverse in their format with known
forces. Its sensors are computed with vectors and the joints' frames, not with the formulas of the script.

    pytest examples/baseprod
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
pytest.importorskip("scipy", reason="pip install scipy")
pytest.importorskip("pyarrow", reason="pip install pyarrow")
import convert
import tomllib
from marta import GRAVITY, LEGS, SENSORS, WHEELS, Marta
from scipy.spatial.transform import Rotation

BODY_MASS = 21.0  # kg, another than that of robots/marta.toml
START, REST, END = 1_689_953_714_000_000_000, 6.0, 18.0  # ns; s
# N; along z they sum to 0: a common part of N cannot be distinguished from weight.
BIAS_FORCE = np.array([[3.0, -2, 7], [-4, 1, -6], [1, 0, 10], [0.5, 2, -3], [-2, 0, -12], [4, 1, 4]])
BIAS_TORQUE = np.array([0.2, -0.3, 0.1, 0.0, 0.4, -0.2])


def loaded() -> Marta:
    """MaRTA as it is in this traverse."""
    marta = Marta()
    marta.body.mass = BODY_MASS
    return marta


def about(axis: str, angles: np.ndarray) -> Rotation:
    return Rotation.from_euler(axis, angles[:, None])


class Drive:
    """Posture and forces over time: at rest on level ground, then slow waves of everything."""

    def __init__(self, time: np.ndarray) -> None:
        self.time = time
        self.moved = np.clip(time - REST, 0, None)

        def wave(size: float, rate: float) -> np.ndarray:
            return size * np.sin(rate * self.moved) * self.moved**2 / (1 + self.moved**2)

        self.pitch, self.roll, self.yaw = wave(0.12, 0.7), wave(-0.1, 0.9), wave(0.6, 0.3)
        self.pins, self.rear = [wave(0.15, 0.8), wave(-0.2, 0.6)], wave(0.1, 1.0)
        self.steering = [wave(0.05 * (i - 2.5), 0.5) for i in range(6)]
        self.angle = [0.7 * self.moved + 2.9 + 0.3 * i for i in range(6)]
        load = loaded().loads_at_rest(0.0, 0.0)
        self.normal = [load[i] + wave(6.0, 0.5 + 0.1 * i) for i in range(6)]
        self.traction = [wave(5.0, 1.1 - 0.1 * i) for i in range(6)]
        self.axial = [wave(3.0, 0.4 + 0.1 * i) for i in range(6)]

    def body(self) -> Rotation:
        """Body in the world; nose up is about -y."""
        return Rotation.from_euler("ZYX", np.stack([self.yaw, -self.pitch, self.roll], axis=1))

    def sensor(self, i: int) -> Rotation:
        """A sensor in the body: x forward, y left, z up."""
        leg = about("x", self.rear) if i % 3 == 2 else about("y", -self.pins[i // 3])
        return leg * about("z", self.steering[i])


def write(path: Path, header: str, rows: list) -> None:
    path.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]) + "\n")


def stamps(rate: float, late: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and stamps of a topic."""
    time = np.arange(late, END, 1 / rate)
    return time, START + np.round(time * 1e9).astype(np.int64)


def write_sensors(folder: Path) -> None:
    time, stamp = stamps(100, 0.031)
    drive, marta = Drive(time), Marta()
    up = drive.body().inv().apply([0, 0, 1])
    flip = np.array([1, -1, -1])  # to x forward, y right, z down
    for i, name in enumerate(SENSORS):
        wheel = np.stack([drive.traction[i], drive.axial[i], drive.normal[i]], axis=1)
        weight = -convert.BELOW * GRAVITY * drive.sensor(i).inv().apply(up)
        to_axle = np.array([0, 0, -convert.HEIGHT])
        torque = np.cross(to_axle - [0, 0, marta.radius], wheel) + np.cross(to_axle, weight)
        values = np.hstack([(wheel + weight) * flip + BIAS_FORCE[i], torque * flip])
        values[:, 4] += BIAS_TORQUE[i]
        header = "Timestamp,Force_X,Force_Y,Force_Z,Torque_X,Torque_Y,Torque_Z"
        rows = [[s, *(f"{v:.12f}" for v in row)] for s, row in zip(stamp, values, strict=True)]
        rows.insert(300, [stamp[300] + 1, *["nan"] * 6])
        write(folder / f"FTS_{name}_CORRECTED.csv", header, rows)


def write_imu(folder: Path) -> None:
    time, stamp = stamps(100, 0.0)
    body = Drive(time).body()
    imu = Rotation.from_euler("z", 180, degrees=True)
    force = imu.inv().apply(GRAVITY * body.inv().apply([0, 0, 1]))
    turn = (body[:-1].inv() * body[1:]).as_rotvec() * 100
    rates = imu.inv().apply(np.vstack([turn, turn[-1:]]))
    values = np.hstack([(body * imu).as_quat(), rates, force, np.zeros((len(time), 3))])
    header = "Timestamp," + ",".join(f"Orientation_{a}" for a in "XYZW")
    for name in ("Angular_Velocity", "Linear_Acceleration", "Angle"):
        header += "," + ",".join(f"{name}_{a}" for a in "XYZ")
    write(folder / "IMU.csv", header, [[s, *row] for s, row in zip(stamp, values, strict=True)])


def write_frames(folder: Path) -> None:
    time, stamp = stamps(25, 0.013)
    drive = Drive(time)

    def joint(before: str, angles: list[float], about_z: np.ndarray) -> np.ndarray:
        return (Rotation.from_euler(before, angles, degrees=True) * about("z", about_z)).as_quat()

    # The side bogies' joints turn nose down.
    frames = {
        "link_bogie_LFB": joint("XYZ", [-90, 0, 0], -drive.pins[0]),
        "link_bogie_RFB": joint("XYZ", [-90, 0, 0], -drive.pins[1]),
        "link_bogie_MRB": joint("xyz", [-90, 0, -90], drive.rear),
        "link_ptu": joint("xyz", [0, 0, 0], 0 * time),
    }
    for i, leg in enumerate(LEGS):
        frames[f"link_STR_{leg}"] = joint("XYZ", [90, 0, 0], drive.steering[i])
        frames[f"link_DRV_{leg}"] = joint("XYZ", [-90, 0, 0], drive.angle[i])
    rows = [[s, "parent", name, 0, 0, 0, *q[k]] for k, s in enumerate(stamp) for name, q in frames.items()]
    write(folder / "TF_CORRECTED_REAR_BOGIE.csv", "Timestamp,Frame_ID,Child_Frame_ID,TX,TY,TZ,QX,QY,QZ,QW", rows)


@pytest.fixture(scope="module")
def traverse(tmp_path_factory):
    folder = tmp_path_factory.mktemp("2023-07-21_17-34-18")
    for part in (write_sensors, write_imu, write_frames):
        part(folder)
    return folder


@pytest.fixture(scope="module")
def converted(traverse, tmp_path_factory):
    """What the script says, its folder, and its tables."""
    out = tmp_path_factory.mktemp("out")
    said = convert.convert(traverse, out, 20.0, convert.BELOW, convert.HEIGHT, zero=True)
    tables = [np.genfromtxt(out / f"{name}.csv", delimiter=",", names=True) for name in ("log", "truth")]
    return said, out, *tables


def test_forces_are_those_of_the_traverse(converted):
    """Known truth, to 10 mN and 2 mN m: a mean over 50 ms flattens the waves by up to 3 mN."""
    *_, log, truth = converted
    drive = Drive(truth["time"] + 0.031)  # the latest start of all files
    for i, wheel in enumerate(WHEELS):
        assert truth[f"{wheel}_normal_force"] == pytest.approx(drive.normal[i], abs=0.01), wheel
        assert truth[f"{wheel}_traction"] == pytest.approx(drive.traction[i], abs=0.01), wheel
        torque = Marta().radius * drive.traction[i]
        assert log[f"{wheel}_motor_torque"] == pytest.approx(torque, abs=2e-3), wheel


def test_readings_have_the_signs_of_a_log(converted):
    """Known posture, to 1 mrad: linear between frames of 40 ms. Rates of differences over 10 ms: 5 mrad/s."""
    *_, log, _ = converted
    drive = Drive(log["time"] + 0.031)
    for i, wheel in enumerate(WHEELS):
        turned = log[f"{wheel}_angle"] - log[f"{wheel}_angle"][0]
        assert turned == pytest.approx(drive.angle[i] - drive.angle[i][0], abs=2e-3), wheel
        assert log[f"{wheel}_steering"] == pytest.approx(drive.steering[i], abs=1e-3), wheel
    names = ["left_pin_angle", "right_pin_angle", "rear_bogie_angle", "body_inclination", "body_roll"]
    for name, angle in zip(names, [*drive.pins, drive.rear, drive.pitch, drive.roll], strict=True):
        assert log[name] == pytest.approx(angle, abs=1e-3), name
    turned = Drive(np.stack([log["time"] + 0.031 + dt for dt in (-0.005, 0.005)]).T.ravel()).body()
    rates = (turned[::2].inv() * turned[1::2]).as_rotvec() / 0.01
    for name, rate in zip(["roll_rate", "rate", "yaw_rate"], (rates * [1, -1, 1]).T, strict=True):
        assert log[f"body_{name}"] == pytest.approx(rate, abs=5e-3), name
    up = drive.body().inv().apply([0, 0, GRAVITY])
    for name, force in zip("xyz", up.T, strict=True):
        assert log[f"body_specific_force_{name}"] == pytest.approx(force, abs=0.01), name


def test_bias_and_weight_are_found(converted):
    """Known, to 1 mN; files have 1e-12 N, the report 1 mN."""
    said, out, *_ = converted
    mass = tomllib.loads((out / "robot.toml").read_text())["robot"]["mass"]
    assert 2 * mass["body"] == pytest.approx(BODY_MASS, abs=1e-4)
    for i, wheel in enumerate(WHEELS):
        line = next(line for line in said.splitlines() if line.strip().startswith(wheel))
        normal, traction, torque = (float(v) for v in line.split(":")[1].split(";")[0].split())
        assert normal == pytest.approx(-BIAS_FORCE[i, 2], abs=1e-3)
        assert traction == pytest.approx(BIAS_FORCE[i, 0], abs=1e-3)
        assert torque == pytest.approx(BIAS_TORQUE[i] - convert.HEIGHT * BIAS_FORCE[i, 0], abs=1e-3)


def test_loads_at_rest():
    """Closed forms: moments of a half about Q; on a slope equilibrium about an axis that no row has, and a mirror."""
    marta = Marta()
    level = marta.loads_at_rest(0.0, 0.0)
    bogie, q = marta.groups["left"], marta.pins[0][0]
    front, middle, rear = (at[0] for at in marta.axles[:3])
    half = [(0.5 * part.mass, part.at[0]) for group in ("body", "rear") for part in marta.groups[group]]
    at_q = sum(m * (x - rear) for m, x in half) / (q - rear)
    weights = [(part.mass, part.at[0]) for part in bogie] + [(at_q, q)]
    of_front = sum(m * (x - middle) for m, x in weights) / (front - middle)
    of_middle = sum(m for m, _ in weights) - of_front
    of_rear = sum(m for m, _ in half) - at_q
    assert level == pytest.approx(GRAVITY * np.array([of_front, of_middle, of_rear] * 2), rel=1e-12)
    pitch, roll = 0.04, 0.05
    inclined, mirrored = marta.loads_at_rest(pitch, roll), marta.loads_at_rest(pitch, -roll)
    assert inclined == pytest.approx(np.roll(mirrored, 3), rel=1e-12)
    up = convert.up_in_body(pitch, roll)
    parts = [part for group in marta.groups.values() for part in group]
    moment = np.cross(marta.contacts[5], up) * 0
    for force, at in [*zip(inclined, marta.contacts, strict=True), *((-GRAVITY * p.mass, p.at) for p in parts)]:
        moment = moment + force * np.cross(at - marta.contacts[5], up)
    assert moment == pytest.approx(np.zeros(3), abs=1e-9)


def test_what_is_missing_is_said(traverse, tmp_path):
    """File, column, what was found, what is allowed."""

    def refused(name: str, change) -> str:
        folder = Path(tempfile.mkdtemp(dir=tmp_path))
        for path in traverse.iterdir():
            text = change(path.read_text()) if path.name == name else path.read_text()
            if text is not None:
                (folder / path.name).write_text(text)
        with pytest.raises(convert.Problem) as problem:
            convert.convert(folder, tmp_path / "out", 20.0, convert.BELOW, convert.HEIGHT, zero=True)
        return str(problem.value)

    assert "FTS_BR_CORRECTED.csv" in refused("FTS_BR_CORRECTED.csv", lambda text: None)
    message = refused("IMU.csv", lambda text: text.replace("Linear_Acceleration_Z", "az", 1))
    assert "IMU.csv" in message and "Linear_Acceleration_Z" in message and "allowed: CSV with the columns" in message
    message = refused("TF_CORRECTED_REAR_BOGIE.csv", lambda text: text.replace("link_DRV_RM", "link_RM"))
    assert "Child_Frame_ID: no row of link_DRV_RM; allowed: rows of" in message
    imu, frames, force = "IMU.csv", "TF_CORRECTED_REAR_BOGIE.csv", "FTS_FL_CORRECTED.csv"

    def cells(change):
        """Changes the cells of each row but the head, by its number."""

        def all_rows(text: str) -> str:
            head, *rows = text.splitlines()
            rows = [",".join(change(i, row.split(","))) for i, row in enumerate(rows)]
            return "\n".join([head, *(row for row in rows if row)]) + "\n"

        return all_rows

    message = refused(imu, cells(lambda i, row: row[:1] + ["0"] * 4 + row[5:] if i == 50 else row))
    assert (
        f"{imu}: Orientation_X to Orientation_W: found a quaternion of length 0 at the stamp {START + 500_000_000}"
        in message
    )
    message = refused(frames, cells(lambda i, row: row[:-4] + ["0"] * 4 if i == 500 else row))
    assert f"{frames}: QX to QW: found a quaternion of length 0 at the stamp" in message
    message = refused(force, cells(lambda i, row: [*row[:1], "nan", *row[2:]]))
    assert "found 0 whole rows of 1798, no Force_X in 1798, " in message and "allowed: at least 2" in message
    message = refused(force, cells(lambda i, row: [*row[:3], str(-float(row[3])), *row[4:]]))
    assert "FTS_FL_CORRECTED.csv: the bias of N = -Force_Z at rest is -" in message and "allowed: up to 20 N" in message
    # Joints every 0.8 s.
    message = refused(frames, cells(lambda i, row: row if i // 16 % 20 == 0 else []))
    assert "Timestamp: found 0 of " in message and "gaps of up to 0.5 s" in message
    assert not (tmp_path / "out").exists()


def test_stamps_in_another_unit_are_refused(traverse, tmp_path):
    """All of them in ms: 18 us have one sample."""
    for path in traverse.iterdir():
        head, *rows = path.read_text().splitlines()
        rows = [f"{int(row[:19]) // 1_000_000}{row[19:]}" for row in rows]
        (tmp_path / path.name).write_text("\n".join([head, *rows]) + "\n")
    with pytest.raises(
        convert.Problem, match="found 1 of 1 samples in 1.79e-05 s; allowed: at least 2, with stamps in ns"
    ):
        convert.load(tmp_path, 20.0)


def test_columns_that_are_not_used_do_not_count(traverse, tmp_path, capsys):
    """Torques about x. Rows without a value are left out aloud: each made-up sensor has one."""
    for path in traverse.iterdir():
        head, *rows = path.read_text().splitlines()
        if path.name.startswith("FTS"):
            rows = [",".join([*row.split(",")[:4], "nan", *row.split(",")[5:]]) for row in rows]
        (tmp_path / path.name).write_text("\n".join([head, *rows]) + "\n")
    assert np.isfinite(convert.load(tmp_path, 20.0).torque).all()
    assert "FTS_FL_CORRECTED.csv: 1797 whole rows of 1798, no Force_X in 1, " in capsys.readouterr().out


def test_a_lever_of_a_force_that_does_not_vary_is_not_known(traverse):
    """In place of a division by 0, which warns."""
    rest = convert.load(traverse, 20.0)[np.arange(3)]
    rest.force[:, :, 0] = 1.5
    assert np.isnan(convert.lever(rest)).all()


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--rate", "inf", "--rate: found inf, allowed: 2 to 1000"),
        ("--rate", "1e-9", "--rate: found 1e-9, allowed: 2 to 1000"),
        ("--height", "nan", "--height: found nan, allowed: 0 to 1"),
        ("--below", "nan", "--below: found nan, allowed: 0 to 10"),
        ("--out", __file__, "allowed: a folder that can be written"),
    ],
)
def test_options_that_cannot_be_taken(traverse, tmp_path, monkeypatch, capsys, option, value, message):
    """Refused by name, with what is allowed, and without a log."""
    out = tmp_path / "out"
    monkeypatch.setattr(sys, "argv", ["convert.py", str(traverse), "--out", str(out), option, value])
    with pytest.raises(SystemExit) as stop:
        convert.main()
    assert message in f"{stop.value.code} {capsys.readouterr().err}"
    assert not out.exists()


def test_sensors_are_zeroed_on_level_ground_alone(traverse, tmp_path):
    """After the start there is no rest; without zeroing the biases stay."""
    later = tmp_path / "later"
    later.mkdir()
    for path in traverse.iterdir():
        head, *rows = path.read_text().splitlines()
        kept = [row for row in rows if int(row.split(",")[0]) > START + int((REST + 1.5) * 1e9)]
        (later / path.name).write_text("\n".join([head, *kept]) + "\n")
    settings = (tmp_path / "out", 20.0, convert.BELOW, convert.HEIGHT)
    with pytest.raises(convert.Problem, match="cannot be zeroed: the wheels never stand for"):
        convert.convert(later, *settings, zero=True)
    assert convert.convert(later, *settings, zero=False).startswith("not zeroed: the wheels never stand")
    truth = np.genfromtxt(tmp_path / "out" / "truth.csv", delimiter=",", names=True)
    start = REST + 1.5 + 0.04  # after the first row of every file
    drive = Drive(truth["time"] + start)
    for i, wheel in enumerate(WHEELS):
        off = truth[f"{wheel}_normal_force"] - drive.normal[i] + BIAS_FORCE[i, 2]
        assert off == pytest.approx(np.zeros_like(off), abs=0.3)


@pytest.mark.parametrize("slope", [0.0, 3.0])
def test_loads_at_rest_are_those_of_mujoco(slope):
    """Another engine, from the same file, left side up. 0.5 %: there wheels share the push across in another way."""
    pytest.importorskip("mujoco", reason="pip install mujoco")
    sys.path.insert(0, str(Path(__file__).parents[1] / "mujoco"))
    import robot
    import whole_rover

    case = whole_rover.Case(cross_slope=slope, gains=(0, 0), across=whole_rover.load_across("marta"))
    world = whole_rover.World(case, robot=robot.load("marta"))
    for _ in range(4000):
        world.step()
    truth, roll = world.truth(), np.radians(slope)
    expected = Marta().loads_at_rest(0.0, roll) * np.cos(roll)
    assert [truth[f"{wheel}_normal_force"] for wheel in WHEELS] == pytest.approx(expected, rel=5e-3)
