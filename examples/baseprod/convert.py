"""Turns a traverse of BASEPROD (doi 10.57780/esa-xxd1ysw) into a log and a table of true forces for `robhaz estimate`:

    python examples/baseprod/convert.py rover_sensors/2023-07-23_12-52-39 --out runs/baseprod

Reads FTS_FL_CORRECTED.csv and the other five, IMU.csv and TF_CORRECTED_REAR_BOGIE.csv, as the scripts of the dataset
write them (github.com/spaceuma/baseprod). Writes log.csv (default names of a log of both sides, SI), truth.csv (N and T
of each wheel) and robot.toml (`robots/marta.toml` with the weight that the sensors show), and prints what it found.

A force sensor sits above its wheel and steers with it: x forward, y right, z down, force of the wheel on the leg. With
the weight below the sensor, w, and the inclination of the leg: T = Fx + w sin, N = -Fz + w cos. The wheel's torque is
Ty - h Fx. N and T are along the leg's axes: where the ground is steeper than the leg by an angle, they turn by it.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
from marta import GRAVITY, JOINTS, LEGS, ROBOT_FILE, SENSORS, WHEELS, Marta, up_in_body
from scipy.spatial.transform import Rotation

BELOW = 0.255  # kg below a sensor: wheel and bracket (rover_config, urdf/marta.xacro)
HEIGHT = 0.0885  # m of a sensor above the axle: the steering joint there
TURNED = Rotation.from_euler("z", 180, degrees=True)  # the IMU on the body
LONGEST_GAP = 0.5  # s between samples that are interpolated
REST, REST_RATE = 2.0, 0.01  # s; rad/s: wheels that turn less for so long stand
LEVEL = np.radians(3)  # largest inclination of body and links at which sensors can be zeroed
# N of N or T at rest: the dataset's sensors drift by up to 13 N; a centre of mass 30 mm off adds 3 N, rough ground some
MOST_BIAS = 20.0


class Problem(Exception):
    """A traverse that cannot be read: file, column, what was found, what is allowed."""


def read(folder: Path, name: str, columns: list[str], texts: tuple[str, ...] = ()) -> dict[str, np.ndarray]:
    """Columns of a CSV file, in the order of its stamps; numbers, but for `texts`. Rows that lack one are left out, which
    is printed."""
    path = folder / name
    types = {c: pa.string() if c in texts else pa.float64() for c in columns} | {"Timestamp": pa.int64()}
    try:
        options = pa.csv.ConvertOptions(column_types=types, include_columns=["Timestamp", *columns])
        table = pa.csv.read_csv(path, convert_options=options)
    except (OSError, pa.ArrowInvalid, pa.ArrowKeyError) as error:
        raise Problem(f"{path}: {error}; allowed: CSV with the columns Timestamp (ns), {', '.join(columns)}") from error
    is_there = {c: pc.is_valid(v) if c in texts else pc.is_finite(v) for c, v in zip(table.column_names, table.columns)}
    is_there = {c: np.array(v.fill_null(False), dtype=bool) for c, v in is_there.items()}
    lacking = [f", no {c} in {n}" for c, v in is_there.items() if (n := np.sum(~v))]
    rows = table.num_rows
    table = table.filter(pa.array(np.all(list(is_there.values()), axis=0))).sort_by("Timestamp")
    found = f"{table.num_rows} whole rows of {rows}{''.join(lacking)}"
    if table.num_rows < 2:
        raise Problem(f"{path}: found {found}; allowed: at least 2")
    if lacking:
        print(f"{path}: {found}: the others are left out")
    return {c: np.array(table[c].to_pylist() if c in texts else table[c]) for c in table.column_names}


def rotations(path: Path, table: dict[str, np.ndarray], columns: list[str]) -> Rotation:
    """Of the quaternions in four columns."""
    quaternions = np.stack([table[c] for c in columns], axis=1)
    lengths = np.linalg.norm(quaternions, axis=1)
    if len(wrong := np.flatnonzero(np.abs(lengths - 1) > 0.01)):
        found = f"found a quaternion of length {lengths[wrong[0]]:.3g} at the stamp {table['Timestamp'][wrong[0]]}"
        raise Problem(f"{path}: {columns[0]} to {columns[-1]}: {found}; allowed: 1, to 1 %")
    return Rotation.from_quat(quaternions)


def joint_angles(folder: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Stamps (ns) and angles (rad, unwrapped) of each joint, about the axis that its frame names."""
    name = "TF_CORRECTED_REAR_BOGIE.csv"
    quaternion = ["QX", "QY", "QZ", "QW"]
    tf = read(folder, name, ["Child_Frame_ID", *quaternion], ("Child_Frame_ID",))
    found = {}
    for frame, nominal in JOINTS.items():
        rows = tf["Child_Frame_ID"] == frame
        if not rows.any():
            raise Problem(f"{folder / name}: Child_Frame_ID: no row of {frame}; allowed: rows of {', '.join(JOINTS)}")
        turn = nominal.inv() * rotations(folder / name, {c: v[rows] for c, v in tf.items()}, quaternion)
        matrix = turn.as_matrix()
        if (worst := matrix[:, 2, 2].min()) < 0.99:
            other = np.degrees(np.arccos(worst))
            message = f"{frame} turns by {other:.0f} deg about another axis; allowed: about the z axis alone"
            raise Problem(f"{folder / name}: QX to QW: {message}")
        found[frame] = tf["Timestamp"][rows], np.unwrap(np.arctan2(matrix[:, 1, 0], matrix[:, 0, 0]))
    return found


def mean_at(time: np.ndarray, stamps: np.ndarray, values: np.ndarray, span: float) -> np.ndarray:
    """Values at `time` (s): means over `span`, between which is interpolated; NaN in gaps."""
    half = 0.5 * span
    first, last = np.searchsorted(stamps, time - half), np.searchsorted(stamps, time + half, side="right")
    total = np.concatenate([[0.0], np.cumsum(values - values[0])])
    count = last - first
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = values[0] + (total[last] - total[first]) / count
    return np.where(count > 1, mean, interpolated(time, stamps, values))


def interpolated(time: np.ndarray, stamps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values at `time` (s); NaN in gaps."""
    after = np.clip(np.searchsorted(stamps, time), 1, len(stamps) - 1)
    gap = (stamps[after] - stamps[after - 1] > LONGEST_GAP) | (time < stamps[0]) | (time > stamps[-1])
    return np.where(gap, np.nan, np.interp(time, stamps, values))


@dataclass
class Traverse:
    """A traverse on one clock, in the signs of robhaz. Arrays over wheels are left 1 to 3, right 1 to 3."""

    time: np.ndarray  # s from the start
    wheel_angle: np.ndarray  # rad, forward
    steering: np.ndarray  # rad, to the left
    pins: np.ndarray  # rad, side bogie less body, nose up: left, right
    rear: np.ndarray  # rad, rear bogie less body, left side up
    pitch: np.ndarray  # rad, nose up
    roll: np.ndarray  # rad, left side up
    rates: np.ndarray  # rad/s about x, y, z
    specific_force: np.ndarray  # m/s^2 along x, y, z
    force: np.ndarray  # N, of the ground, and of the weight below, along x, y, z of each leg's sensor
    torque: np.ndarray  # N m, about y of it

    def __getitem__(self, rows: np.ndarray) -> "Traverse":
        return Traverse(**{name: values[rows] for name, values in vars(self).items()})

    @property
    def up(self) -> tuple[np.ndarray, np.ndarray]:
        """The vertical's parts along forward and up of each sensor, which turns with bogie and steering."""
        x, y, z = up_in_body(self.pitch, self.roll).T
        forward, upward = np.zeros((2, len(self.time), 6))
        for wheel in range(6):
            if wheel % 3 == 2:
                c, s = np.cos(self.rear), np.sin(self.rear)
                leg_x, leg_y, leg_z = x, c * y + s * z, c * z - s * y
            else:
                pin = self.pins[:, wheel // 3]
                c, s = np.cos(pin), np.sin(pin)
                leg_x, leg_y, leg_z = c * x + s * z, y, c * z - s * x
            steering = self.steering[:, wheel]
            forward[:, wheel] = np.cos(steering) * leg_x + np.sin(steering) * leg_y
            upward[:, wheel] = leg_z
        return forward, upward


def load(folder: Path, rate: float) -> Traverse:
    """Reads a traverse, `rate` samples a second."""
    joints = joint_angles(folder)
    orientation = [f"Orientation_{a}" for a in "XYZW"]
    rates, accelerations = ([f"{name}_{a}" for a in "XYZ"] for name in ("Angular_Velocity", "Linear_Acceleration"))
    imu = read(folder, "IMU.csv", orientation + rates + accelerations)
    columns = ["Force_X", "Force_Y", "Force_Z", "Torque_Y"]
    wrenches = [read(folder, f"FTS_{sensor}_CORRECTED.csv", columns) for sensor in SENSORS]

    stamps = [joint[0] for joint in joints.values()] + [table["Timestamp"] for table in (imu, *wrenches)]
    start, end = max(s[0] for s in stamps), min(s[-1] for s in stamps)
    if end <= start:
        raise Problem(f"{folder}: Timestamp: the files have no time in common; allowed: files of one traverse")
    time = np.arange(0, (end - start) * 1e-9, 1 / rate)

    def at(stamps: np.ndarray, values: np.ndarray) -> np.ndarray:
        return mean_at(time, (stamps - start) * 1e-9, values, 1 / rate)

    def angle(frame: str) -> np.ndarray:
        stamps, values = joints[frame]
        return interpolated(time, (stamps - start) * 1e-9, values)

    def vector(names: list[str]) -> np.ndarray:
        return np.stack([at(imu["Timestamp"], imu[name]) for name in names], axis=1)

    # Rows of this matrix are world axes in the body frame: the last one is the vertical.
    body = rotations(folder / "IMU.csv", imu, orientation) * TURNED.inv()
    vertical = np.stack([at(imu["Timestamp"], body.as_matrix()[:, 2, i]) for i in range(3)], axis=1)
    pins = [-angle(f"link_bogie_{side}FB") for side in "LR"]
    whole = Traverse(
        time=time,
        wheel_angle=np.stack([angle(f"link_DRV_{leg}") for leg in LEGS], axis=1),
        steering=np.stack([angle(f"link_STR_{leg}") for leg in LEGS], axis=1),
        pins=np.stack(pins, axis=1),
        rear=angle("link_bogie_MRB"),
        pitch=np.arctan2(vertical[:, 0], np.hypot(vertical[:, 1], vertical[:, 2])),
        roll=np.arctan2(vertical[:, 1], vertical[:, 2]),
        rates=vector(rates) @ TURNED.as_matrix().T,
        specific_force=vector(accelerations) @ TURNED.as_matrix().T,
        force=np.stack([[at(w["Timestamp"], w[f"Force_{a}"]) for w in wrenches] for a in "XYZ"]).transpose(2, 1, 0),
        torque=np.stack([at(w["Timestamp"], w["Torque_Y"]) for w in wrenches], axis=1),
    )
    values = (np.reshape(v, (len(time), -1)) for v in vars(whole).values())
    kept = np.isfinite(np.concatenate(list(values), axis=1)).all(axis=1)
    span = f"{kept.sum()} of {len(time)} samples in {(end - start) * 1e-9:.3g} s"
    gaps = f"gaps of up to {LONGEST_GAP} s between rows of a file"
    if kept.sum() < 2:
        raise Problem(f"{folder}: Timestamp: found {span}; allowed: at least 2, with stamps in ns and {gaps}")
    if not kept.all():
        print(f"{folder}: {span} are kept, those with {gaps}")
    return whole[kept]


def at_rest(traverse: Traverse) -> np.ndarray:
    """The samples of the first time in which the rover stands for `REST` seconds; none if it never does."""
    time = traverse.time
    moving = np.abs(np.gradient(traverse.wheel_angle, time, axis=0)).max(axis=1) > REST_RATE
    edges = np.flatnonzero(np.diff(np.concatenate([[True], moving, [True]]).astype(int)))
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        if time[end - 1] - time[first] >= REST:
            return np.arange(first, end)
    return np.arange(0)


@dataclass
class Forces:
    """Forces of the ground on each wheel, along its leg, N, and wheel torques, N m."""

    normal: np.ndarray
    traction: np.ndarray
    torque: np.ndarray


def forces(traverse: Traverse, below: float, height: float) -> Forces:
    """What the sensors show. `below`: kg below a sensor; `height` of a sensor above its axle, m."""
    forward, upward = traverse.up
    return Forces(
        normal=-traverse.force[:, :, 2] + below * GRAVITY * upward,
        traction=traverse.force[:, :, 0] + below * GRAVITY * forward,
        torque=traverse.torque - height * traverse.force[:, :, 0],
    )


def bias(found: Forces, traverse: Traverse, rest: np.ndarray, marta: Marta) -> Forces:
    """Means of the sensors' errors at rest, against the loads of this rover on ground parallel to its legs."""
    load = marta.loads_at_rest(traverse.pitch[rest].mean(), traverse.roll[rest].mean())
    traction, normal = (load * part[rest].mean(axis=0) for part in traverse.up)
    return Forces(
        normal=found.normal[rest].mean(axis=0) - normal,
        traction=found.traction[rest].mean(axis=0) - traction,
        torque=found.torque[rest].mean(axis=0) - marta.radius * traction,
    )


def write(path: Path, columns: dict[str, np.ndarray]) -> None:
    """A CSV file."""
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")


def log_columns(traverse: Traverse, found: Forces) -> dict[str, np.ndarray]:
    """The log, with the default names of both sides."""
    columns = {"time": traverse.time}
    for i, wheel in enumerate(WHEELS):
        columns[f"{wheel}_angle"] = traverse.wheel_angle[:, i]
        columns[f"{wheel}_motor_torque"] = found.torque[:, i]
        columns[f"{wheel}_steering"] = traverse.steering[:, i]
    columns |= {"left_pin_angle": traverse.pins[:, 0], "right_pin_angle": traverse.pins[:, 1]}
    columns |= {"rear_bogie_angle": traverse.rear}
    columns |= {"body_inclination": traverse.pitch, "body_roll": traverse.roll}
    columns |= {"body_roll_rate": traverse.rates[:, 0], "body_rate": -traverse.rates[:, 1]}
    columns |= {"body_yaw_rate": traverse.rates[:, 2]}
    return columns | {f"body_specific_force_{a}": traverse.specific_force[:, i] for i, a in enumerate("xyz")}


def truth_columns(traverse: Traverse, found: Forces) -> dict[str, np.ndarray]:
    """N and T of each wheel."""
    columns = {"time": traverse.time}
    for i, wheel in enumerate(WHEELS):
        columns |= {f"{wheel}_normal_force": found.normal[:, i], f"{wheel}_traction": found.traction[:, i]}
    return columns


def weigh(found: Forces, traverse: Traverse, rest: np.ndarray, marta: Marta) -> str:
    """Gives the body the mass that the sensors show at rest; returns the robot file with it."""
    mass = (found.normal / traverse.up[1])[rest].sum(axis=1).mean() / GRAVITY
    other = marta.mass - marta.body.mass
    if mass <= other:
        message = f"at rest the sensors show {mass:.2f} kg; bogies, legs and wheels alone have {other:.2f} kg"
        raise Problem(f"Force_Z: {message}; allowed: more, with N = -Force_Z")
    old = f"\nbody = {0.5 * marta.body.mass} # kg; "
    if (text := ROBOT_FILE.read_text()).count(old) != 1:
        raise Problem(f"{ROBOT_FILE}: robot.mass: found no line that starts with {old.strip()!r}; allowed: one")
    marta.body.mass = mass - other
    return text.replace(old, f"\nbody = {0.5 * marta.body.mass:.6f} # kg; from the force sensors at rest; before: ")


def rest_problem(traverse: Traverse, rest: np.ndarray) -> str | None:
    """Why the sensors cannot be zeroed."""
    if not len(rest):
        return f"the wheels never stand for {REST} s"
    angles = {"pitch": traverse.pitch, "roll": traverse.roll, "left bogie": traverse.pins[:, 0]}
    angles |= {"right bogie": traverse.pins[:, 1], "rear bogie": traverse.rear}
    for name, angle in angles.items():
        if abs(mean := angle[rest].mean()) > LEVEL:
            return f"at rest the {name} is {np.degrees(mean):.1f} deg; allowed: up to {np.degrees(LEVEL):.0f} deg"
    size = np.linalg.norm(traverse.specific_force[rest].mean(axis=0))
    if abs(size - GRAVITY) > 0.5:
        return f"IMU.csv: Linear_Acceleration at rest is {size:.2f} m/s^2; allowed: {GRAVITY} m/s^2, gravity included"
    return None


def bias_problem(offsets: Forces) -> str | None:
    """Why a bias is none that a force sensor has."""
    for what, values in (("N = -Force_Z", offsets.normal), ("T = Force_X", offsets.traction)):
        if abs(worst := values[i := np.abs(values).argmax()]) > MOST_BIAS:
            found = f"the bias of {what} at rest is {worst:.1f} N"
            return f"FTS_{SENSORS[i]}_CORRECTED.csv: {found}; allowed: up to {MOST_BIAS:.0f} N"
    return None


def lever(traverse: Traverse) -> np.ndarray:
    """Ty over Fx of each wheel, by least squares about their means: height of the sensor over the ground, m. NaN where
    Fx does not vary."""
    force, torque = (v - v.mean(axis=0) for v in (traverse.force[:, :, 0], traverse.torque))
    square = (force**2).sum(axis=0)
    return np.divide((force * torque).sum(axis=0), square, out=np.full(6, np.nan), where=square > 1e-12 * (traverse.force[:, :, 0] ** 2).sum(axis=0))


def report(offsets: Forces, rest: np.ndarray, traverse: Traverse, mass: float, height: float) -> str:
    """What was found, for people."""
    (first, last), levers = traverse.time[rest[[0, -1]]], lever(traverse)
    lines = [f"at rest from {first:.1f} to {last:.1f} s: {mass:.2f} kg in all", "bias of N, T (N), wheel torque (N m):"]
    for i, wheel in enumerate(WHEELS):
        values = (f"{v[i]:8.3f}" for v in (offsets.normal, offsets.traction, offsets.torque))
        radius = f"= {levers[i] - height:.4f} m" if np.isfinite(levers[i]) else "unknown, Fx does not vary"
        lines.append(f"  {wheel} (FTS_{SENSORS[i]}): {' '.join(values)}; Ty/Fx - h {radius}")
    return "\n".join(lines)


def convert(folder: Path, out: Path, rate: float, below: float, height: float, zero: bool) -> str:
    """Writes log, truth and robot; returns what was found."""
    marta, traverse = Marta(), load(folder, rate)
    found, rest = forces(traverse, below, height), at_rest(traverse)
    if problem := rest_problem(traverse, rest):
        if zero:
            raise Problem(f"{folder}: sensors cannot be zeroed: {problem}; --no-zero leaves their bias")
        text, said = ROBOT_FILE.read_text(), f"not zeroed: {problem}; the robot's mass is that of {ROBOT_FILE.name}"
    else:
        text = weigh(found, traverse, rest, marta)
        offsets = bias(found, traverse, rest, marta)
        said = report(offsets, rest, traverse, marta.mass, height)
        if zero:
            if problem := bias_problem(offsets):
                raise Problem(f"{folder}: sensors cannot be zeroed: {problem}; --no-zero leaves their bias")
            for name, values in vars(offsets).items():
                setattr(found, name, getattr(found, name) - values)
    try:
        out.mkdir(parents=True, exist_ok=True)
        (out / "robot.toml").write_text(text)
        write(out / "log.csv", log_columns(traverse, found))
        write(out / "truth.csv", truth_columns(traverse, found))
    except OSError as error:
        raise Problem(f"--out {out}: {error}; allowed: a folder that can be written") from error
    return said


def between(least: float, most: float) -> Callable[[str], float]:
    """Reads an option that is a number."""

    def number(text: str) -> float:
        if not least <= (value := float(text)) <= most:
            raise argparse.ArgumentTypeError(f"found {text}, allowed: {least:g} to {most:g}")
        return value

    return number


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("traverse", type=Path, help="folder of an exported traverse")
    parser.add_argument("--out", type=Path, required=True, help="folder for log.csv, truth.csv, robot.toml")
    options = {
        "--rate": (20.0, "rows a second, 2 to 1000", between(2, 1000)),
        "--below": (BELOW, "kg below a force sensor, 0 to 10", between(0, 10)),
        "--height": (HEIGHT, "m of a sensor above the axle, 0 to 1", between(0, 1)),
    }
    for name, (default, words, number) in options.items():
        parser.add_argument(name, type=number, default=default, help=f"{words} (default {default})")
    parser.add_argument("--no-zero", action="store_true", help="leave the bias of the force sensors")
    options = parser.parse_args()
    try:
        print(convert(options.traverse, options.out, options.rate, options.below, options.height, not options.no_zero))
    except Problem as problem:
        sys.exit(f"error: {problem}")


if __name__ == "__main__":
    main()
