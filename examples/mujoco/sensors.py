"""Readings of the robot's sensors with the errors of typical ones: `sensors.grade = "typical"` of docs/scenes.md."""

import math

import numpy as np
from robot import GRAVITY

DEG = math.pi / 180
# Standard deviations; a gain, an offset and a bias are drawn once a run and sensor, noise at each sample.
TYPICAL = {
    "encoder_counts": 160000,  # in a turn of the wheel
    "torque_gain": 0.02,
    "torque_offset": 0.1,  # N m
    "torque_noise": 0.1,  # N m
    "inclination_bias": 0.1 * DEG,
    "inclination_noise": 0.1 * DEG,
    "rate_noise": 0.1 * DEG,  # rad/s
}
DAMPING_ERROR = 0.1  # the estimator's nominal damping B of the wheel modules is 10 % too high


class Sensors:
    """Encoders and motor torques of the wheels, inclinometers and gyros of links 1 and 2. The same seed, the same
    errors."""

    def __init__(self, seed: int, torque: float = 1.0, gravity: float = GRAVITY) -> None:
        """`torque` is the unit of torque of the robot over that of robot A: offsets and noise are that much larger."""
        self.torque, self.gravity = torque, gravity
        self.random = np.random.default_rng(seed)
        self.gain = 1 + TYPICAL["torque_gain"] * self.random.standard_normal(3)
        self.offset = torque * TYPICAL["torque_offset"] * self.random.standard_normal(3)
        self.bias = TYPICAL["inclination_bias"] * self.random.standard_normal(2)
        self.last: dict[str, float] | None = None

    def read(self, truth: dict[str, float]) -> dict[str, float]:
        """The readings of a sample, with the names and units of the table `sensors` of a run."""
        white = self.random.standard_normal(7)
        row = {"time": truth["time"]}
        count = 2 * math.pi / TYPICAL["encoder_counts"]
        for i in range(3):
            name = f"wheel{i + 1}"
            row[f"{name}_angle"] = math.floor(truth[f"{name}_angle"] / count) * count
            torque = self.gain[i] * truth[f"{name}_torque"] + self.offset[i]
            row[f"{name}_motor_torque"] = torque + self.torque * TYPICAL["torque_noise"] * white[i]
        for i in range(2):
            name = f"link{i + 1}"
            direction = self._specific_force_direction(name, truth) + self.bias[i]
            row[f"{name}_inclination"] = direction + TYPICAL["inclination_noise"] * white[3 + i]
            row[f"{name}_rate"] = truth[f"{name}_rate"] + TYPICAL["rate_noise"] * white[5 + i]
        self.last = truth
        return row

    def _specific_force_direction(self, link: str, truth: dict[str, float]) -> float:
        """Direction of the specific force in the link, rad: its angle plus atan(a_x/(g + a_y)).

        The acceleration is the mean one since the last sample, as of a sensor with a filter against aliasing.
        """
        a = np.zeros(2)
        if self.last is not None:
            dt = truth["time"] - self.last["time"]
            a = np.array([truth[f"{link}_{v}"] - self.last[f"{link}_{v}"] for v in ("vx", "vy")]) / dt
        return truth[f"{link}_angle"] + math.atan2(a[0], self.gravity + a[1])
