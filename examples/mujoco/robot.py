"""The robot of `robots/*.toml` as a MuJoCo model: planar, one side, x forward and z up (robhaz calls it y).

All joints turn about the y axis. Links turn counter-clockwise (x towards z, axis -y), wheels turn forward (axis +y), so
joint angles have the signs of robhaz.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tomllib

ROBOTS = Path(__file__).resolve().parents[2] / "robots"
GRAVITY = 9.81
WHEELS = ("wheel1", "wheel2", "wheel3")
BARS = ("body", "link1", "link2", "link3")


@dataclass
class Units:
    """A robot's units of length, time and torque over those of robot A, with which its world is scaled (Froude)."""

    length: float
    time: float
    torque: float


@dataclass
class Robot:
    """Dimensions (m), masses (kg) and inertias (kg m^2) of one side of the robot, in its nominal pose."""

    radius: float
    axles: np.ndarray  # 3x2, axles of the wheels
    carriers: list[str]  # the link that carries each wheel
    cg: dict[str, np.ndarray]  # centre of mass of each bar without wheels
    pins: dict[str, np.ndarray]  # p, q, r, s
    stop: tuple[float, float]  # range of theta1 - theta2, rad
    mass: dict[str, float]
    inertia: dict[str, float]  # of the bars, about their centres of mass
    wheel_mass: float
    wheel_inertia: float  # resists the absolute spin
    rotor_inertia: float  # resists the spin relative to the link
    gravity: float = GRAVITY  # m/s^2
    body_on: str | None = None  # of a bogie: the link that the body is fixed to

    @property
    def total_mass(self) -> float:
        return sum(self.mass.values()) + 3 * self.wheel_mass

    @property
    def bars(self) -> tuple[str, ...]:
        return tuple(self.mass)

    @property
    def units(self) -> Units:
        length = self.radius / 0.1
        weight = self.total_mass * self.gravity / (14.0 * GRAVITY)
        return Units(length, math.sqrt(length * GRAVITY / self.gravity), weight * length)


GRAVITIES = {"earth": GRAVITY, "mars": 3.71, "moon": 1.62}


def load(geometry: str = "geometry-a", mass: str = "mass-caption") -> Robot:
    """Reads two files of the folder `robots`, named without their extension, or one of a rover that has both."""
    g, m = (tomllib.loads((ROBOTS / f"{name}.toml").read_text()) for name in (geometry, mass))
    gravity = GRAVITY
    if "robot" in g:
        rover = g["robot"]
        g, m = rover["geometry"], rover["mass"]
        gravity = rover.get("gravity", GRAVITY)
        gravity = GRAVITIES.get(gravity, gravity)
    suspension = g.get("suspension", {"kind": "four-bar"})
    bars = BARS if suspension["kind"] == "four-bar" else BARS[:3]
    pins = {name: np.array(at, float) for name, at in g["pins"].items()}
    axles = np.array(g["axles"], float)
    ends = {"link1": "pq", "link2": "qr", "link3": "rs"}
    ends = {link: [n for n in ends[link] if n in pins] for link in bars[1:]}
    cg = {"body": np.array(g["body_cg"], float)}
    for i, (link, names) in enumerate(ends.items()):
        points = [pins[n] for n in names] + [a for a, c in zip(axles, g["carriers"], strict=True) if c == link]
        cg[link] = np.array(g["link_cg"][i]) if "link_cg" in g else np.mean(points, axis=0)
    robot = Robot(
        radius=g["wheel_radius"],
        axles=axles,
        carriers=g["carriers"],
        cg=cg,
        pins=pins,
        stop=(_angle(g["stop"]["lower"]), _angle(g["stop"]["upper"])),
        mass=dict(zip(bars, [m["body"], *m["links"]], strict=True)),
        inertia=dict(zip(bars, [m["body_inertia"], *m["link_inertias"]], strict=True)),
        wheel_mass=m["wheel"],
        wheel_inertia=m["wheel_inertia"],
        rotor_inertia=m["rotor_inertia"],
        gravity=gravity,
        body_on=suspension.get("body"),
    )
    height = g.get("steering_height", 3 * robot.radius)
    for axle, link, steering in zip(axles, robot.carriers, m.get("steering", ()), strict=False):
        _add(robot, link, steering, np.array([axle[0], height]))
    return robot


def _add(robot: Robot, link: str, mass: float, at: np.ndarray) -> None:
    """A point mass becomes a part of a link."""
    own, apart = robot.mass[link], at - robot.cg[link]
    robot.mass[link] = own + mass
    robot.cg[link] = robot.cg[link] + apart * mass / (own + mass)
    robot.inertia[link] += own * mass / (own + mass) * (apart @ apart)


def _angle(value: float | str) -> float:
    """An angle of a robot file, rad: a number, or a text such as "-40 deg"."""
    if isinstance(value, str):
        number, unit = value.split()
        return float(number) * {"rad": 1.0, "deg": math.pi / 180}[unit]
    return float(value)


def _pos(point: np.ndarray) -> str:
    return f"{point[0]:.17g} 0 {point[1]:.17g}"


def _inertial(at: np.ndarray, mass: float, inertia: float) -> str:
    # Only the moment about y acts in the plane; the others must merely be possible (triangle inequality).
    return f'<inertial pos="{_pos(at)}" mass="{mass:.17g}" diaginertia="{inertia:.17g} {inertia:.17g} {inertia:.17g}"/>'


def bodies(robot: Robot, damping: float) -> str:
    """The robot as bodies of MJCF: a tree body - link1 - link2 and body - link3, to be closed at R; of a bogie the body
    with the link that it is fixed to, and the other link.

    `damping` is the viscous damping B of the wheel modules, N m s. Q is a joint of the tree, so that the end stops are
    the limits of a joint.
    """
    r, pins = robot, robot.pins

    def bar(name: str, joint: str, at: np.ndarray, parent: np.ndarray, inside: str, limits: str = "") -> str:
        # A bar without a joint is fixed to its parent.
        hinge = f'<joint name="{joint}" axis="0 -1 0" {limits}/>' if joint else ""
        return (
            f'<body name="{name}" pos="{_pos(at - parent)}">{hinge}'
            f"{_inertial(r.cg[name] - at, r.mass[name], r.inertia[name])}{wheels_of(name, at)}{inside}</body>"
        )

    def wheels_of(link: str, origin: np.ndarray) -> str:
        return "".join(
            f'<body name="{name}" pos="{_pos(axle - origin)}">'
            f'<joint name="{name}" axis="0 1 0" armature="{r.rotor_inertia:.17g}" damping="{damping:.17g}"/>'
            f"{_inertial(np.zeros(2), r.wheel_mass, r.wheel_inertia)}"
            f'<geom name="{name}" class="wheel" conaffinity="{1 << i}" size="{r.radius:.17g}"/></body>'
            for i, (name, axle, carrier) in enumerate(zip(WHEELS, r.axles, r.carriers, strict=True))
            if carrier == link
        )

    # The joint at Q is theta2 - theta1, or theta1 - theta2 where the body is fixed to link 2.
    low, high = r.stop if r.body_on == "link2" else (-r.stop[1], -r.stop[0])
    limits = f'limited="true" range="{low:.17g} {high:.17g}"'
    if r.body_on:
        other = "link1" if r.body_on == "link2" else "link2"
        inner = bar(other, "q", pins["q"], pins["q"], "", limits)
        inside = bar(r.body_on, "", pins["q"], r.cg["body"], inner)
    else:
        link2 = bar("link2", "q", pins["q"], pins["p"], "", limits)
        link1 = bar("link1", "p", pins["p"], r.cg["body"], link2)
        inside = link1 + bar("link3", "s", pins["s"], r.cg["body"], "")
    return (
        f'<body name="body" pos="{_pos(r.cg["body"])}">'
        '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>'
        '<joint name="pitch" axis="0 -1 0"/>'
        f"{_inertial(np.zeros(2), r.mass['body'], r.inertia['body'])}{inside}</body>"
    )
