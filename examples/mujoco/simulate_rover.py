"""Drives a rover with both sides in MuJoCo and writes the truth of its wheels' forces, and what it records:

    python simulate_rover.py --case slope5 rough1 --out runs/rover
    python simulate_rover.py --case slope5 rough1 --instants 10 --out truth.csv

`--out` is a folder, which gets `CASE.csv` and `CASE-log-SEED.csv` (with `--draw` a truth for each seed, too,
`CASE-SEED.csv`); with `--instants` a table with so many instants of each case. A row of the truth has the motion of body and joints, and for each wheel the force of the ground with its
parts, the contact point and the contact's angles: SI, in the body frame (`whole_rover.py`). Readings have the errors of
typical sensors (`sensors.py`): joints 0.1 deg, steering 0.5 deg, accelerometer 0.02 m/s^2.
"""

import argparse
import csv
import math
from pathlib import Path

import numpy as np
from sensors import DEG, TYPICAL
from whole_rover import CASES, NAMES, World

SETTLED = 2.0  # s: standing still, start
STEERING_BIAS, ACCELERATION_NOISE = 0.5 * DEG, 0.02  # rad, m/s^2


class Readings:
    """Readings of both sides and of an inertial sensor in O. The same seed, the same errors."""

    def __init__(self, seed: int, torque: float, coupling: str, steered: bool) -> None:
        """`torque`: the rover's unit of torque over that of robot A, of which offsets and noise are that many times."""
        self.random = random = np.random.default_rng(seed)
        self.torque, self.steered = torque, steered
        self.coupling = "differential_angle" if coupling == "differential" else "rear_bogie_angle"
        self.gain = 1 + TYPICAL["torque_gain"] * random.standard_normal(6)
        self.offset = torque * TYPICAL["torque_offset"] * random.standard_normal(6)
        self.bias = TYPICAL["inclination_bias"] * random.standard_normal(5)
        self.steering = STEERING_BIAS * random.standard_normal(6)

    def read(self, truth: dict[str, float]) -> dict[str, float]:
        """The readings of a sample: angles (rad), rates (rad/s), torques (N m), specific force (m/s^2)."""

        def noisy(value: float, key: str) -> float:
            return value + TYPICAL[key] * self.random.standard_normal()

        row, count = {"time": truth["time"]}, 2 * math.pi / TYPICAL["encoder_counts"]
        for i, name in enumerate(NAMES):
            row[f"{name}_angle"] = math.floor(truth[f"{name}_angle"] / count) * count
            noise = self.torque * TYPICAL["torque_noise"] * self.random.standard_normal()
            row[f"{name}_motor_torque"] = self.gain[i] * truth[f"{name}_motor_torque"] + self.offset[i] + noise
            if self.steered and i % 3 != 1:
                row[f"{name}_steering"] = truth[f"{name}_steering"] + self.steering[i]
        f = np.array([truth[f"body_specific_force_{axis}"] for axis in "xyz"])
        angles = {
            "left_pin_angle": truth["left_pin_angle"],
            "right_pin_angle": truth["right_pin_angle"],
            self.coupling: truth["coupling_angle"],
            "body_inclination": math.atan2(f[0], math.hypot(f[1], f[2])),
            "body_roll": math.atan2(f[1], f[2]),
        }
        for bias, (name, angle) in zip(self.bias, angles.items(), strict=True):
            row[name] = noisy(angle + bias, "inclination_noise")
        for name, axis, sign in (("roll", "x", 1), ("", "y", -1), ("yaw", "z", 1)):
            name = f"body_{name}_rate".replace("__", "_")
            row[name] = noisy(sign * truth[f"body_rate_{axis}"], "rate_noise")
        for axis, value in zip("xyz", f, strict=True):
            row[f"body_specific_force_{axis}"] = value + ACCELERATION_NOISE * self.random.standard_normal()
        return row


def rows(world: World, every: float, start: float):
    """The truth every so many seconds from `start` on; before 0 the rover settles."""
    dt = world.model.opt.timestep
    world.data.time, due = -1.5, start
    while world.data.time < world.case.duration - 0.5 * dt:
        world.step()
        if world.time >= due - 0.5 * dt:
            due += every
            yield world.truth() | {"time": round(world.time, 9)}


class Table:
    """A CSV file with the columns of its first row."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self.file, self.writer = path.open("w", newline=""), None

    def write(self, row: dict) -> None:
        if self.writer is None:
            self.writer = csv.DictWriter(self.file, list(row))
            self.writer.writeheader()
        self.writer.writerow({k: v if isinstance(v, str) else f"{v:.10g}" for k, v in row.items()})


def drive(name: str, options: argparse.Namespace, seeds: list[int], draw: int | None = None) -> None:
    """One drive of a case: its truth, and a log for each seed of the sensors."""
    case, world = CASES[name], World(CASES[name], draw=draw)
    table = Table(options.out / (f"{name}.csv" if draw is None else f"{name}-{draw}.csv"))
    unit, coupling = world.robot.units.torque, case.across.coupling
    logs = [
        (Table(options.out / f"{name}-log-{seed}.csv"), Readings(seed, unit, coupling, case.steered)) for seed in seeds
    ]
    if draw is not None:
        # The control steers by what it reads.
        world.heading = world.heading - logs[0][1].steering
    for truth in rows(world, 1 / options.rate, 0.0):
        table.write(truth)
        for log, readings in logs:
            log.write(readings.read(truth))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", nargs="+", choices=CASES, default=list(CASES), help="default: all")
    parser.add_argument("--rate", type=int, default=200, help="rows a second")
    parser.add_argument("--seed", type=int, nargs="+", default=[1], help="of the sensors: a log for each")
    parser.add_argument("--draw", action="store_true", help="each seed also draws a rover: `drawn`")
    parser.add_argument("--instants", type=int, help="so many instants a case, and no logs")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    if options.instants:
        table = Table(options.out)
        for name in options.case:
            every = (CASES[name].duration - SETTLED) / options.instants
            for truth in rows(World(CASES[name]), every, SETTLED):
                table.write({"case": name} | truth)
        return
    for name in options.case:
        if options.draw:
            for seed in options.seed:
                drive(name, options, [seed], draw=seed)
        else:
            drive(name, options, options.seed)


if __name__ == "__main__":
    main()
