"""MaRTA: joints and force sensors of its files, and its loads at rest, from `robots/marta.toml`."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tomllib
from scipy.spatial.transform import Rotation

GRAVITY = 9.81
ROBOT_FILE = Path(__file__).resolve().parents[2] / "robots" / "marta.toml"

# Wheels are left 1 to 3, then right 1 to 3: their names, force sensors, and legs in the names of frames.
WHEELS = [f"{side}_wheel{k}" for side in ("left", "right") for k in (1, 2, 3)]
SENSORS = ("FL", "CL", "BL", "FR", "CR", "BR")
LEGS = ("LF", "LM", "LR", "RF", "RM", "RR")

# Orientation of a joint's frame at angle 0; it turns about its z (rover_config, urdf/marta.xacro).
_ACROSS, _UP = Rotation.from_euler("x", -90, degrees=True), Rotation.from_euler("x", 90, degrees=True)
JOINTS = (
    {"link_bogie_LFB": _ACROSS, "link_bogie_RFB": _ACROSS}
    | {"link_bogie_MRB": Rotation.from_euler("z", -90, degrees=True) * _ACROSS}
    | {f"link_STR_{leg}": _UP for leg in LEGS}
    | {f"link_DRV_{leg}": _ACROSS for leg in LEGS}
)


@dataclass
class Part:
    """A mass, kg, at a point of the body frame in the nominal pose, m."""

    mass: float
    at: np.ndarray


class Marta:
    """Dimensions (m) and masses (kg). Body frame: x forward, y left, z up; origin below the middle axles."""

    def __init__(self, path: Path = ROBOT_FILE) -> None:
        robot = tomllib.loads(path.read_text())["robot"]
        geometry, mass, across = robot["geometry"], robot["mass"], robot["across"]
        self.radius = geometry["wheel_radius"]
        self.pivot = across["pivot"]
        self.axles, self.contacts = np.zeros((6, 3)), np.zeros((6, 3))
        self.pins = []
        groups: dict[str, list[Part]] = {"body": [], "left": [], "right": [], "rear": []}
        x, z = geometry["body_cg"]
        self.body = Part(2 * mass["body"], np.array([x, across["body_place"], z]))
        groups["body"].append(self.body)
        for s, (side, sign) in enumerate((("left", 1), ("right", -1))):
            for link, group in ((0, side), (1, "rear")):
                x, z = geometry["link_cg"][link]
                groups[group].append(Part(mass["links"][link], np.array([x, sign * across["link_places"][link], z])))
            for k, (x, z) in enumerate(geometry["axles"]):
                at = np.array([x, sign * across["half_tracks"][k], z])
                self.axles[3 * s + k], self.contacts[3 * s + k] = at, at - [0, 0, self.radius]
                group = side if k < 2 else "rear"
                groups[group].append(Part(mass["wheel"], at))
                above = at + [0, 0, geometry["steering_height"] - z]
                groups[group].append(Part(mass["steering"][k], above))
            x, z = geometry["pins"]["q"]
            self.pins.append(np.array([x, sign * across["link_places"][0], z]))
        self.groups = groups

    @property
    def mass(self) -> float:
        """Of the whole rover, kg."""
        return sum(part.mass for parts in self.groups.values() for part in parts)

    def loads_at_rest(self, pitch: float, roll: float) -> np.ndarray:
        """Vertical forces on the six wheels, N, in the nominal pose on ground inclined as the body (nose up, left side
        up, rad). Wheels do not push each other: each force is vertical."""
        up = up_in_body(pitch, roll)
        fore, across = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
        hinge = np.array([self.pivot[0], 0, self.pivot[1]])
        groups = self.groups
        every = [part for parts in groups.values() for part in parts]
        left, right, rear = [0, 1], [3, 4], [2, 5]
        # Each row: about which axis through which point, what turns about it, and its wheels.
        rows = [
            (fore, hinge, every, range(6)),
            (across, hinge, every, range(6)),
            (across, self.pins[0], groups["left"], left),
            (across, self.pins[1], groups["right"], right),
            (fore, hinge, groups["rear"], rear),
        ]
        matrix, loads = np.zeros((6, 6)), np.zeros(6)
        matrix[0], loads[0] = 1.0, GRAVITY * self.mass
        for i, (axis, point, parts, wheels) in enumerate(rows, 1):
            for wheel in wheels:
                matrix[i, wheel] = np.cross(self.contacts[wheel] - point, up) @ axis
            loads[i] = sum(GRAVITY * part.mass * (np.cross(part.at - point, up) @ axis) for part in parts)
        return np.linalg.solve(matrix, loads)


def up_in_body(pitch: np.ndarray | float, roll: np.ndarray | float) -> np.ndarray:
    """The vertical in the body frame; nose up and left side up positive, rad."""
    x, flat = np.sin(pitch), np.cos(pitch)
    return np.stack([x, flat * np.sin(roll), flat * np.cos(roll)], axis=-1)
