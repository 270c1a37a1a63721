"""Profiles of the ground as polylines, and as boxes of MuJoCo: one box under each segment.

The profiles are those of robhaz with the same names and default values (docs/scenes.md, `[terrain]`).
"""

import math
from dataclasses import dataclass

import numpy as np
from robot import Robot

START, END = -1.5, 8.0  # m
MAX_TURN = math.radians(0.2)  # between two segments of a curve: a wheel at 0.2 m/s meets 0.7 mm/s
THICKNESS = 0.05  # of the boxes, m
BUMPS = ((0.050, 1.00, 0.22), (-0.035, 1.45, 0.20), (0.040, 1.90, 0.17), (0.060, 2.50, 0.28), (-0.030, 2.95, 0.16))


def smooth(x):
    """Five Gaussian bumps (height, centre, width), m."""
    return sum(height * np.exp(-(((x - centre) / width) ** 2)) for height, centre, width in BUMPS)


def sine(x):
    """Five waves of 0.5 m, 20 mm from trough to crest, from x = 0.7 m."""
    u = (np.asarray(x) - 0.7) / 0.5
    return np.where((u >= 0) & (u <= 5), 0.01 * (1 - np.cos(2 * math.pi * u)), 0.0)


def _curve(height, facet: float) -> np.ndarray:
    """Points on a curve, so close that it turns by at most MAX_TURN between them; or `facet` metres apart, with
    corners."""
    if facet > 0:
        x = np.arange(START, END, facet)
        return np.stack([x, height(x)], axis=1)
    fine = np.arange(START, END, 1e-4)
    slope = np.arctan(np.gradient(height(fine), fine))
    turned = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(slope)))])
    # A new point when turning over MAX_TURN plus way over 20 mm reaches 1, so that neighbours are of similar length.
    count = np.floor(turned / MAX_TURN + (fine - START) / 0.02)
    x = fine[np.concatenate([[True], np.diff(count) > 0])]
    return np.stack([x, height(x)], axis=1)


def _ramp() -> list:
    length, angle = 0.8, math.radians(15)
    top = (0.7 + length * math.cos(angle), length * math.sin(angle))
    return [(START, 0), (0.7, 0), top, (END, top[1])]


def _stairs(rise: float, count: int) -> list:
    points = [(START, 0.0)]
    for k in range(count):
        points += [(0.7 + 0.3 * k, rise * k), (0.7 + 0.3 * k, rise * (k + 1))]
    return [*points, (END, rise * count)]


@dataclass
class Ground:
    """A profile by its name, with its sizes."""

    terrain: str = "smooth"
    facet: float = 0.0  # of smooth, sine: distance of the corners, m; 0 for a curve without corners
    kerb: float = 0.05  # of step: height, m


PROFILES = {
    "flat": lambda g: [(START, 0), (END, 0)],
    "smooth": lambda g: _curve(smooth, g.facet),
    "sine": lambda g: _curve(sine, g.facet),
    "ramp": lambda g: _ramp(),
    "step": lambda g: _stairs(g.kerb, 1),
    "stairs": lambda g: _stairs(0.08, 4),
}


def polyline(ground: Ground, robot: Robot) -> np.ndarray:
    """Points (x, z) of the ground from rear to front, m: as large as the robot, over the size of robot A, and as far
    ahead of its front wheel."""
    size, ahead = robot.units.length, robot.axles[0][0] - 0.3 * robot.units.length
    points = size * np.array(PROFILES[ground.terrain](ground), float)
    return points + np.array([ahead if robot.body_on else 0.0, 0.0])


def boxes(points: np.ndarray) -> str:
    """The ground as MJCF: the upper face of each box is a segment of the polyline."""
    geoms = []
    for a, b in zip(points[:-1], points[1:], strict=True):
        along = b - a
        length = np.hypot(*along)
        angle = math.atan2(along[1], along[0])
        middle = (a + b) / 2 + THICKNESS / 2 * np.array([math.sin(angle), -math.cos(angle)])
        geoms.append(
            f'<geom class="ground" pos="{middle[0]:.17g} 0 {middle[1]:.17g}" euler="0 {-angle:.17g} 0" '
            f'size="{length / 2:.17g} 0.2 {THICKNESS / 2}"/>'
        )
    return "".join(geoms)


def slope_near(points: np.ndarray, x: float, z: float) -> tuple[float, float]:
    """Slope (rad) of the segment nearest to a point, and the distance to it (m)."""
    a, along = points[:-1], np.diff(points, axis=0)
    to = np.array([x, z]) - a
    at = np.clip(np.sum(to * along, axis=1) / np.sum(along**2, axis=1), 0, 1)
    distance = np.hypot(*(to - at[:, None] * along).T)
    k = int(np.argmin(distance))
    return math.atan2(along[k, 1], along[k, 0]), float(distance[k])


class Nearest:
    """Which segments touch a wheel: those whose own nearest point is a local minimum of the distance to the ground.

    MuJoCo would also report the corners of neighbouring boxes, which a wheel that penetrates a smooth ground overlaps
    although the ground has no corner there ("internal edges"), and both sides of each joint of a hollow. Each of these
    contacts would push the wheel for itself.
    """

    NEAR = 0.2  # m: farther segments do not touch a wheel

    def __init__(self, points: np.ndarray) -> None:
        along = np.diff(points, axis=0)
        self.length = np.hypot(*along.T)
        self.start = points[:-1]
        self.tangent = along / self.length[:, None]
        self.normal = np.stack([-self.tangent[:, 1], self.tangent[:, 0]], axis=1)
        turn = np.arcsin(np.sum(self.normal[:-1] * self.tangent[1:], axis=1))
        self.smooth = np.abs(turn) < 2 * MAX_TURN  # a joint within a curve, not a corner of the ground

    def touches(self, at: np.ndarray) -> tuple[slice, np.ndarray]:
        """Segments near a point (x, z), and for each whether it may touch a wheel there. A corner belongs to the
        segment after it."""
        first, end = np.searchsorted(self.start[:, 0], [at[0] - self.NEAR, at[0] + self.NEAR])
        near = slice(max(first - 1, 0), end)
        to = at - self.start[near]
        length, smooth = self.length[near], self.smooth[near][: len(to) - 1]
        passed = (to * self.tangent[near]).sum(axis=1)
        touch = (passed >= 0) & (passed <= length)
        # In a smooth hollow the nearer one of two neighbours counts.
        height = (to * self.normal[near]).sum(axis=1)
        both = touch[:-1] & touch[1:] & smooth
        farther = height[:-1] > height[1:]
        touch[:-1] &= ~(both & farther)
        touch[1:] &= ~(both & ~farther)
        touch[1:] |= (passed[1:] < 0) & (passed[:-1] > length[:-1])
        return near, touch
