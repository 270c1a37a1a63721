"""A rover with both sides in MuJoCo: a side of `robots/*.toml`, what lies across, its ground, and the truth.

Body frame: origin O on the rockers' pivot axis or the rear bogie's hinge, in the middle plane; x forward, y left, z up.
Links turn nose up (about -y), a rear bogie left side up (about +x), wheels forward (about +y), steering to the left.
Wheels are left 1 to 3, then right 1 to 3.

Each wheel is an ellipsoid: a tyre with a round crown. It has a plane of its own, which every step lays on the tangent
plane of the ground where the wheel touches it: one exact contact a wheel, without the seams of a height field.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np
import tomllib
from robot import ROBOTS, Robot, load

SIDES = ("left", "right")
NAMES = [f"{side}_wheel{k}" for side in SIDES for k in (1, 2, 3)]


@dataclass(frozen=True)
class Across:
    """What lies across: `[robot.across]` of a robot file, with its names."""

    coupling: str  # "differential" or "rear-bogie"
    pivot: tuple[float, float]  # x, height, m
    half_tracks: tuple[float, ...]  # m
    link_places: tuple[float, float]  # m
    body_inertia: tuple[float, float]  # roll, yaw, kg m^2
    link_inertias: tuple[tuple[float, float], ...]  # roll, yaw of links 1 and 2, kg m^2
    wheel_inertia: float  # about a diameter, kg m^2
    body_place: float = 0.0  # m
    half_width: float = 0.03  # of a wheel, m


def load_across(rover: str) -> Across:
    """Reads `[robot.across]` of a file of the folder `robots`."""
    return Across(**tomllib.loads((ROBOTS / f"{rover}.toml").read_text())["robot"]["across"])


OPEN_SOURCE_ROVER = load_across("open-source-rover")
# The same parts, with a hinge at the rear, and all wheels of a side in one plane.
TRIPLE_BOGIE = replace(
    OPEN_SOURCE_ROVER,
    coupling="rear-bogie",
    pivot=(-0.25, 0.12),
    half_tracks=(0.3, 0.3, 0.3),
    link_places=(0.3, 0.3),
)


@dataclass(frozen=True)
class Build:
    """What a rover has beside its description."""

    sides: tuple[Robot, Robot]  # left, right
    across: Across
    radii: np.ndarray = field(default_factory=lambda: np.ones(6))  # over the nominal ones
    toe: np.ndarray = field(default_factory=lambda: np.zeros(6))  # of the axles about the vertical, rad
    camber: np.ndarray = field(default_factory=lambda: np.zeros(6))  # about the way, rad
    gear_friction: float = 0.0  # N m, of each wheel
    rolling_resistance: float = 0.0  # -


def drawn(robot: Robot, across: Across, seed: int) -> Build:
    """A rover as people build one: masses of parts to 3 %, of the whole to 1 %; centres of mass to 5 mm and pins to 1 mm
    for wheels as large as robot A's, otherwise in proportion; rolling radii to 0.5 %; axles to 0.3 deg; gears and ground
    that the budget of typical sensors allows (`NoiseBudget::typical_for`). The body is the mean of two such parts, one a
    side."""
    random = np.random.default_rng(seed)
    normal, unit = random.standard_normal, robot.units

    def point(at: np.ndarray, deviation: float) -> np.ndarray:
        return at + deviation * unit.length * math.sqrt(0.5) * normal(2)

    def side() -> Robot:
        masses = {name: mass * (1 + 0.03 * normal()) for name, mass in robot.mass.items()}
        cg = {name: point(at, 0.005) for name, at in robot.cg.items()}
        pins = {name: point(at, 0.001) for name, at in robot.pins.items()}
        return replace(robot, mass=masses, cg=cg, pins=pins, wheel_mass=robot.wheel_mass * (1 + 0.03 * normal()))

    sides = (side(), side())
    total = 2 * robot.total_mass * (1 + 0.01 * normal()) / sum(one.total_mass for one in sides)
    sides = tuple(
        replace(one, mass={n: m * total for n, m in one.mass.items()}, wheel_mass=one.wheel_mass * total)
        for one in sides
    )
    across = replace(
        across,
        pivot=tuple(point(np.array(across.pivot), 0.001)),
        body_place=across.body_place + 0.005 * unit.length * math.sqrt(0.5) * normal(2)[0],
    )
    axles = 0.3 * math.pi / 180
    return Build(
        sides,
        across,
        radii=1 + 0.005 * normal(6),
        toe=axles * normal(6),
        camber=axles * normal(6),
        gear_friction=abs(0.3 * unit.torque * normal()),
        rolling_resistance=abs(0.01 * normal()),
    )


def flat(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    """Heights of the ground, m, and their slopes along x and y."""
    return 0 * x, 0 * x, 0 * x


BUMPS = (  # height, centre, width, m
    (0.0375, 0.982, 0.165),
    (-0.0262, 1.42, 0.15),
    (0.03, 1.87, 0.128),
    (0.045, 2.45, 0.21),
    (-0.0225, 2.9, 0.12),
)


def bumps_left(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    """The bumps of `robots/open-source-rover.toml` under the left side alone."""
    h, hx = 0 * x, 0 * x
    for height, centre, width in BUMPS:
        bump = height * np.exp(-(((x - centre) / width) ** 2))
        h, hx = h + bump, hx - bump * 2 * (x - centre) / width**2
    across, edge = np.tanh(y / 0.04), 0.04
    share, change = 0.5 * (1 + across), 0.5 * (1 - across**2) / edge
    return h * share, hx * share, h * change


def rough(seed: int) -> Callable:
    """A sum of 40 plane waves of 0.45 to 2.5 m in all directions, from x = 0.5 m on, whole at 1.1 m."""
    random = np.random.default_rng(seed)
    length = np.geomspace(0.45, 2.5, 40)
    heading, phase = random.uniform(0, 2 * math.pi, 40), random.uniform(0, 2 * math.pi, 40)
    kx, ky = 2 * math.pi / length * np.cos(heading), 2 * math.pi / length * np.sin(heading)
    height = 0.0055 * length**0.9

    def ground(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
        u = np.clip((x - 0.5) / 0.6, 0, 1)
        share, change = u * u * (3 - 2 * u), 6 * u * (1 - u) / 0.6
        angle = np.outer(x, kx) + np.outer(y, ky) + phase
        h, c = np.sin(angle) @ height, np.cos(angle)
        return share * h, change * h + share * (c @ (height * kx)), share * (c @ (height * ky))

    return ground


@dataclass
class Case:
    """A rover, its ground and its commands."""

    ground: Callable = flat
    cross_slope: float = 0.0  # deg, left side up: gravity is inclined
    speed: float = 0.2  # m/s of O
    radius: float = math.inf  # of the turn to the left, m, about a point beside the middle wheels; 0 on the spot
    every: float = math.inf  # s: it halts so often, for two fifths of the time
    steered: bool = False  # the corner wheels steer; else the rover skids
    gains: tuple[float, float] = (1.5, 17.0)  # of the speed control, N m s and N m
    duration: float = 14.0  # s
    across: Across = OPEN_SOURCE_ROVER


LOW_GAIN = (0.6, 0.0)
CASES = {
    "slope5": Case(cross_slope=5),
    "slope10": Case(cross_slope=10),
    "slope15": Case(cross_slope=15),
    "bumps-left": Case(bumps_left, duration=18),
    "bumps-left-low": Case(bumps_left, duration=18, gains=LOW_GAIN),
    "bumps-left-slope8": Case(bumps_left, cross_slope=8, duration=18),
    "rough1": Case(rough(1), duration=16),
    "rough1-low": Case(rough(1), duration=16, gains=LOW_GAIN),
    "skid": Case(speed=0.1, radius=1.0),
    "skid-slope8": Case(cross_slope=8, speed=0.1, radius=1.0),
    "ackermann": Case(speed=0.1, radius=1.0, steered=True),
    "ackermann-slope10": Case(cross_slope=10, speed=0.1, radius=1.0, steered=True),
    "ackermann-rough": Case(rough(1), speed=0.15, radius=1.5, steered=True, duration=18),
    "pivot": Case(speed=0.2, radius=0.0, steered=True),
    "stops": Case(rough(1), duration=20, every=5.0),
    "triple-slope5": Case(cross_slope=5, across=TRIPLE_BOGIE),
    "triple-rough1": Case(rough(1), duration=16, across=TRIPLE_BOGIE),
    "triple-rough1-slope5": Case(rough(1), cross_slope=5, duration=16, across=TRIPLE_BOGIE),
}


def _inertial(at: np.ndarray, mass: float, inertia: tuple) -> str:
    pos, diagonal = (" ".join(f"{v:.12g}" for v in values) for values in (at, inertia))
    return f'<inertial pos="{pos}" mass="{mass:.12g}" diaginertia="{diagonal}"/>'


def mjcf(build: Build, case: Case, step: float, friction: float, damping: float) -> str:
    """The model: body, rockers or rear bogie, bogies, wheels, and a plane for each wheel."""
    across, robot = build.across, build.sides[0]
    differential = across.coupling == "differential"
    rocker = robot.body_on
    bogie = "link1" if rocker == "link2" else "link2"
    links = ("link1", "link2")
    link_place = dict(zip(links, across.link_places, strict=True))
    link_inertia = dict(zip(links, across.link_inertias, strict=True))
    soft = 'solref="0.06 0.15" solimp="0.1 0.1 0.001 0.5 2"'  # 0.3 mm under the weight

    def place(at: np.ndarray, y: float) -> np.ndarray:
        return np.array([at[0] - across.pivot[0], y, at[1] - across.pivot[1]])

    def body(name: str, at: np.ndarray, inside: str, turn: tuple = (0, 0, 0)) -> str:
        pos, euler = (" ".join(f"{v:.12g}" for v in values) for values in (at, turn))
        return f'<body name="{name}" pos="{pos}" euler="{euler}">{inside}</body>'

    def wheel(i: int, origin: np.ndarray) -> str:
        side, k = divmod(i, 3)
        robot = build.sides[side]
        radius, turn = build.radii[i] * robot.radius, (build.camber[i], 0, build.toe[i])
        at = place(robot.axles[k], (1 - 2 * side) * across.half_tracks[k]) - origin
        inertia = (across.wheel_inertia, robot.wheel_inertia, across.wheel_inertia)
        size = f"{radius} {across.half_width} {radius}"
        inside = (
            f'<joint name="{NAMES[i]}" axis="0 1 0" armature="{robot.rotor_inertia}" damping="{damping}"'
            f' frictionloss="{build.gear_friction}"/>'
            f"{_inertial(np.zeros(3), robot.wheel_mass, inertia)}"
            f'<geom name="{NAMES[i]}" type="ellipsoid" size="{size}" contype="0" conaffinity="{1 << i}"'
            f' friction="{friction} 0 0" condim="3" priority="1" {soft} mass="0"/>'
        )
        if not case.steered or k == 1:
            return body(NAMES[i], at, inside, turn)
        steering = f'<joint name="{NAMES[i]}_steering" axis="0 0 1" armature="0.02" damping="2"/>'
        massless = _inertial(np.zeros(3), 1e-6, (1e-6,) * 3)
        return body(f"{NAMES[i]}_steering", at, steering + massless + body(NAMES[i], np.zeros(3), inside, turn))

    def link(name: str, side: int, origin: np.ndarray) -> str:
        """Inertia and wheels of a link of one side, about `origin`."""
        roll, yaw = link_inertia[name]
        robot = build.sides[side]
        at = place(robot.cg[name], (1 - 2 * side) * link_place[name]) - origin
        wheels = [3 * side + k for k in range(3) if robot.carriers[k] == name]
        inertial = _inertial(at, robot.mass[name], (roll, robot.inertia[name], yaw))
        return inertial + "".join(wheel(i, origin) for i in wheels)

    def bogie_of(side: int, parent: np.ndarray) -> str:
        q = place(build.sides[side].pins["q"], (1 - 2 * side) * link_place[bogie])
        hinge = f'<joint name="{SIDES[side]}_pin" axis="0 -1 0" limited="true" range="-0.5 0.5"/>'
        return body(f"{SIDES[side]}_bogie", q - parent, hinge + link(bogie, side, q))

    if differential:
        tree = ""
        for side, name in enumerate(SIDES):
            at = np.array([0, (1 - 2 * side) * link_place[rocker], 0])
            hinge = f'<joint name="{name}_rocker" axis="0 -1 0"/>'
            tree += body(f"{name}_rocker", at, hinge + link(rocker, side, at) + bogie_of(side, at))
        stiff = f'solref="{2 * step} 1" solimp="0.999 0.9999 0.001 0.5 2"'
        closed = f'<joint joint1="left_rocker" joint2="right_rocker" polycoef="0 -1 0 0 0" {stiff}/>'
    else:
        halves = "".join(body(f"rear_{n}", np.zeros(3), link(rocker, s, np.zeros(3))) for s, n in enumerate(SIDES))
        hinge = '<joint name="rear" axis="1 0 0"/>' + _inertial(np.zeros(3), 1e-6, (1e-6,) * 3)
        tree = body("rear", np.zeros(3), hinge + halves) + bogie_of(0, np.zeros(3)) + bogie_of(1, np.zeros(3))
        closed = ""
    planes = "".join(
        f'<body name="ground{i}" mocap="true"><geom name="ground{i}" type="plane" size="0 0 .1" contype="{1 << i}"'
        f' conaffinity="0" friction="{friction} 0 0" {soft}/></body>'
        for i in range(6)
    )
    motors = "".join(f'<motor name="{n}" joint="{n}"/>' for n in NAMES)
    if case.steered:
        motors += "".join(f'<position joint="{n}_steering" kp="400" kv="8"/>' for n in NAMES if not n.endswith("2"))
    slope = math.radians(case.cross_slope)
    roll, yaw = across.body_inertia
    inertia = (roll, 2 * robot.inertia["body"], yaw)
    masses = [one.mass["body"] for one in build.sides]
    centre = sum(m * one.cg["body"] for m, one in zip(masses, build.sides, strict=True)) / sum(masses)
    inertial = _inertial(place(centre, across.body_place), sum(masses), inertia)
    rover = f'<freejoint name="root"/>{inertial}{tree}'
    return f"""<mujoco model="rover">
  <compiler angle="radian" autolimits="false"/>
  <option gravity="0 {-robot.gravity * math.sin(slope):.12g} {-robot.gravity * math.cos(slope):.12g}" timestep="{step}"
          integrator="implicitfast" cone="elliptic" impratio="20" tolerance="1e-12" iterations="200"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody>{planes}{body("body", np.array([across.pivot[0], 0, across.pivot[1]]), rover)}</worldbody>
  <equality>{closed}</equality>
  <actuator>{motors}</actuator>
</mujoco>"""


class World:
    """A rover in steps of `step` seconds. `truth()` is the row of the last step's start."""

    START, RAMP = 0.8, 0.6  # s: when the wheels begin to turn, and how long until their speed is whole
    TORQUE_LIMIT, DAMPING, FRICTION = 3.7, 0.044, 0.7  # N m, N m s

    def __init__(self, case: Case, step: float = 5e-4, robot: Robot | None = None, draw: int | None = None) -> None:
        """`draw`: the seed of a rover with errors, `drawn`; None is the nominal one."""
        self.case, self.robot = case, robot or load("open-source-rover")
        nominal = Build((self.robot, self.robot), case.across)
        self.build = nominal if draw is None else drawn(self.robot, case.across, draw)
        self.model = mujoco.MjModel.from_xml_string(mjcf(self.build, case, step, self.FRICTION, self.DAMPING))
        self.data = mujoco.MjData(self.model)
        self.joint = {self.model.joint(j).name: self.model.joint(j) for j in range(self.model.njnt)}
        self.wheels = [self.model.body(n).id for n in NAMES]
        self.wheel_of_geom = {self.model.geom(n).id: i for i, n in enumerate(NAMES)}
        self.spins = [int(self.joint[n].dofadr[0]) for n in NAMES]
        self.planes = [int(self.model.body_mocapid[self.model.body(f"ground{i}").id]) for i in range(6)]
        self.normal, self.integral = np.tile([0.0, 0, 1], (6, 1)), np.zeros(6)
        # A turn about a point on the line of the middle wheels: speed and heading of each wheel.
        x = self.robot.axles[[0, 1, 2] * 2, 0]
        y = np.array([(1 - 2 * (i // 3)) * case.across.half_tracks[i % 3] for i in range(6)])
        # On the spot it is the speed of the front wheels.
        ahead, reach = (0.0, math.hypot(x[0], y[0])) if case.radius == 0 else (case.speed, case.radius)
        yaw_rate = case.speed / reach
        along, side = ahead - yaw_rate * y, yaw_rate * x
        # A wheel is steered by a quarter turn at most, and turns backwards beyond.
        forwards = np.where(along < 0, -1.0, 1.0)
        self.heading = np.arctan2(forwards * side, forwards * along) if case.steered else np.zeros(6)
        self.speed = forwards * np.hypot(along, side) if case.steered else along

    def step(self) -> None:
        """One step. Contact forces and accelerations of `data` then belong to the state at its start."""
        d, dt = self.data, self.model.opt.timestep
        mujoco.mj_kinematics(self.model, d)
        self._lay_ground()
        mujoco.mj_step1(self.model, d)
        self.time, self.qpos, self.qvel = d.time, d.qpos.copy(), d.qvel.copy()
        error = self.speed / self.robot.radius * self._share(d.time) - self.qvel[self.spins]
        kp, ki = self.case.gains
        wanted = kp * error + ki * self.integral
        self.torque = np.clip(wanted, -self.TORQUE_LIMIT, self.TORQUE_LIMIT)
        if ki > 0:
            self.integral += dt * (error - (wanted - self.torque) / (ki * 0.1))
        d.ctrl[:6] = self.torque
        if self.case.steered:
            d.ctrl[6:] = self.heading[[0, 2, 3, 5]]
        mujoco.mj_step2(self.model, d)
        if self.build.rolling_resistance > 0:
            self._resist()

    def _resist(self) -> None:
        """Rolling resistance of the next step, by the normal forces of this one."""
        force, _ = self.contacts()
        moment = self.build.rolling_resistance * self.robot.radius * np.sum(force * self.normal, 1)
        # Rolling forward is about +a.
        turning = np.tanh(self.qvel[self.spins] / 0.05)
        self.data.xfrc_applied[self.wheels, 3:] = -(moment * turning)[:, None] * self._axles()

    def _share(self, time: float) -> float:
        """Of its speed that the rover shall have."""
        since = time - self.START
        since = since % self.case.every if since > 0 and self.case.every < math.inf else since
        on, off = (min(max(t / self.RAMP, 0.0), 1.0) for t in (since, since - 0.6 * self.case.every))
        return sum(s * u**3 * (10 - 15 * u + 6 * u * u) for s, u in ((1, on), (-1, off)))

    def _axles(self) -> np.ndarray:
        """Unit vectors along the axles, pointing left."""
        return self.data.xmat[self.wheels].reshape(6, 3, 3)[:, :, 1]

    def _lay_ground(self) -> None:
        """Each wheel's plane, by fixed-point iteration on the ellipsoid's lowest point along the ground's normal."""
        d, r, w = self.data, (self.robot.radius * self.build.radii)[:, None], self.case.across.half_width
        centre, a, n = d.xpos[self.wheels], self._axles(), self.normal
        for _ in range(3):
            along = np.sum(n * a, 1, keepdims=True) * a
            arm = r**2 * (n - along) + w**2 * along
            at = centre - arm / np.sqrt(np.sum(n * arm, 1, keepdims=True))
            z, zx, zy = self.case.ground(at[:, 0], at[:, 1])
            n = np.stack([-zx, -zy, np.ones(6)], 1)
            n /= np.linalg.norm(n, axis=1, keepdims=True)
        self.normal = n
        turn = np.stack([1 + n[:, 2], -n[:, 1], n[:, 0], np.zeros(6)], 1)  # turns z into n
        d.mocap_pos[self.planes] = np.stack([at[:, 0], at[:, 1], z], 1)
        d.mocap_quat[self.planes] = turn / np.linalg.norm(turn, axis=1, keepdims=True)

    def contacts(self) -> tuple[np.ndarray, np.ndarray]:
        """Force of the ground on each wheel, N, and the point where it acts, m, in the world."""
        d, found = self.data, np.zeros(6)
        radii = self.robot.radius * self.build.radii
        force, at = np.zeros((6, 3)), d.xpos[self.wheels] - radii[:, None] * self.normal
        for k, contact in enumerate(d.contact):
            first, second = contact.geom
            mujoco.mj_contactForce(self.model, d, k, found)
            sign = 1.0 if second in self.wheel_of_geom else -1.0
            i = self.wheel_of_geom[second if sign > 0 else first]
            force[i] = sign * contact.frame.reshape(3, 3).T @ found[:3]
            at[i] = contact.pos
        return force, at

    def truth(self) -> dict[str, float]:
        """Motion and forces in the body frame at the start of the last step."""
        d = self.data
        root, dof = self.joint["root"].qposadr[0], self.joint["root"].dofadr[0]
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, self.qpos[root + 3 : root + 7])
        turn = turn.reshape(3, 3)
        origin = self.qpos[root : root + 3]
        row = {"time": self.time, "x": origin[0], "y": origin[1]}
        of_body = {
            "specific_force": (d.qacc[dof : dof + 3] - self.model.opt.gravity) @ turn,
            "rate": self.qvel[dof + 3 : dof + 6],
            "angular_acceleration": d.qacc[dof + 3 : dof + 6],
        }
        for name, vector in of_body.items():
            row |= {f"body_{name}_{axis}": v for axis, v in zip("xyz", vector, strict=True)}
        coupling = "left_rocker" if "left_rocker" in self.joint else "rear"
        for name, joint in (("coupling", coupling), ("left_pin", "left_pin"), ("right_pin", "right_pin")):
            j = self.joint[joint]
            row[f"{name}_angle"] = self.qpos[j.qposadr[0]]
            row[f"{name}_rate"], row[f"{name}_acceleration"] = self.qvel[j.dofadr[0]], d.qacc[j.dofadr[0]]
        (force, at), axle, normal = self.contacts(), self._axles() @ turn, self.normal @ turn
        force, at = force @ turn, (at - origin) @ turn
        for i, name in enumerate(NAMES):
            steering = self.joint.get(f"{name}_steering")
            a, n, spin = axle[i], normal[i], self.spins[i]
            in_plane = n - (n @ a) * a
            in_plane /= np.linalg.norm(in_plane)
            up = np.array([0, 0, 1]) - a[2] * a
            up /= np.linalg.norm(up)
            tangent = np.cross(a, in_plane)
            row |= {
                f"{name}_steering": self.qpos[steering.qposadr[0]] if steering else 0.0,
                f"{name}_angle": self.qpos[self.joint[name].qposadr[0]],
                f"{name}_spin_rate": self.qvel[spin],
                f"{name}_spin_acceleration": d.qacc[spin],
                f"{name}_motor_torque": self.torque[i],
                f"{name}_contact_angle": math.atan2(tangent @ up, in_plane @ up),
                f"{name}_lateral_tilt": math.atan2(n @ a, n @ in_plane),
                f"{name}_normal_force": force[i] @ n,
                f"{name}_in_plane_normal_force": force[i] @ in_plane,
                f"{name}_traction": force[i] @ tangent,
                f"{name}_axial_force": force[i] @ a,
            }
            for axis, f, p in zip("xyz", force[i], at[i], strict=True):
                row |= {f"{name}_force_{axis}": f, f"{name}_contact_{axis}": p}
        return row
