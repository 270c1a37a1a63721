"""The robot on its ground in MuJoCo: the model, the drive, and the truth of each sample."""

import math
from dataclasses import dataclass, field

import ground
import mujoco
import numpy as np
from robot import WHEELS, Robot, bodies


@dataclass
class Contact:
    """MuJoCo's soft contact; see "Solver parameters" in its documentation.

    The default is like a rubber tyre: 0.3 mm of penetration under the robot's weight, 125 rad/s, lightly damped; a slip
    of 10 mm/s carries T = N while the wheel grips. MuJoCo's own defaults ("0.02 1", "0.9 0.95 0.001 0.5 2", 1) creep as
    much, but lift a wheel that slides: its friction model is convex, which couples sliding to separation. A wheel hops
    from a slip of about c impratio/mu on, where c is the slip speed at T = N. The values here raise it from 20 to 130
    mm/s.
    """

    mu: float = 0.8  # friction coefficient of Coulomb's law
    solref: str = "0.04 0.2"  # time constant (s) and damping ratio
    solimp: str = "0.3 0.3 0.001 0.5 2"  # impedance over penetration
    impratio: float = 10.0  # friction over normal impedance
    rolling_resistance: float = 0.0  # moment against the rolling over r N, as `contact.rolling_resistance` of a scene


@dataclass
class Drive:
    """Speed control of the wheels, as `[drive]` of a scene: a PI law with a smooth start and anti-windup."""

    speed: float = 0.20  # m/s
    kp: float = 5.0  # N m s
    ki: float = 50.0  # N m
    torque_limit: float = 10.0  # N m
    tracking_time: float = 0.1  # s
    damping: float = 0.15  # viscous damping B in the wheel modules, N m s
    start_time: float = 0.8  # s
    ramp_time: float = 0.6  # s
    integral: np.ndarray = field(default_factory=lambda: np.zeros(3))  # of the speed errors, rad

    def torque(self, t: float, omega: np.ndarray, radius: float, dt: float) -> np.ndarray:
        """Motor torques at the wheels for the step from `t` to `t + dt`, N m."""
        s = min(max((t - self.start_time) / self.ramp_time, 0.0), 1.0)
        error = self.speed / radius * s**3 * (10 - 15 * s + 6 * s * s) - omega
        wanted = self.kp * error + self.ki * self.integral
        torque = np.minimum(np.maximum(wanted, -self.torque_limit), self.torque_limit)
        if self.ki > 0:
            self.integral += dt * (error - (wanted - torque) / (self.ki * self.tracking_time))
        return torque


def mjcf(robot: Robot, points: np.ndarray, contact: Contact, damping: float, step: float) -> str:
    """The model. Each wheel is a sphere: in the plane that is a disc, and MuJoCo's contact of a sphere with a box is
    exact."""
    closed = ""
    if not robot.body_on:
        anchor = robot.pins["r"] - robot.pins["q"]  # R in the frame of link2
        stiff = f'solref="{2 * step:.17g} 1" solimp="0.999 0.9999 0.001 0.5 2"'
        at = f"{anchor[0]:.17g} 0 {anchor[1]:.17g}"
        closed = f'<equality><connect body1="link2" body2="link3" anchor="{at}" {stiff}/></equality>'
    motors = "".join(f'<motor name="{w}" joint="{w}"/>' for w in WHEELS)
    sensors = "".join(
        f'<framepos objtype="body" objname="{b}"/><framelinvel objtype="body" objname="{b}"/>'
        for b in (*robot.bars, *WHEELS)
    )
    return f"""<mujoco model="robhaz">
  <compiler angle="radian" autolimits="false"/>
  <option gravity="0 0 {-robot.gravity}" timestep="{step:.17g}" integrator="implicitfast" cone="elliptic"
          impratio="{contact.impratio}" tolerance="1e-12" iterations="200"/>
  <default>
    <default class="ground"><geom type="box" contype="7" conaffinity="0" condim="3" friction="{contact.mu} 0 0"
      solref="{contact.solref}" solimp="{contact.solimp}"/></default>
    <default class="wheel"><geom type="sphere" contype="0" condim="3" friction="{contact.mu} 0 0"
      solref="{contact.solref}" solimp="{contact.solimp}" mass="0"/></default>
  </default>
  <worldbody>{ground.boxes(points)}{bodies(robot, damping)}</worldbody>
  {closed}
  <actuator>{motors}</actuator>
  <sensor>{sensors}</sensor>
</mujoco>"""


class World:
    """A robot on its ground, in steps of `step` seconds. `truth()` is the row of the last step's start."""

    ROLLS = 0.1  # rad/s: rolling resistance reaches its full moment from 1 cm/s at the rim on

    def __init__(self, robot: Robot, profile: ground.Ground, contact: Contact, drive: Drive, step: float) -> None:
        self.robot, self.drive, self.contact = robot, drive, contact
        self.points = ground.polyline(profile, robot)
        self.model = mujoco.MjModel.from_xml_string(mjcf(robot, self.points, contact, drive.damping, step))
        self.data = mujoco.MjData(self.model)
        # The joints whose angles add up to that of each bar.
        self.turns = {
            None: [["pitch"], ["pitch", "p"], ["pitch", "p", "q"], ["pitch", "s"]],
            "link1": [["pitch"], ["pitch"], ["pitch", "q"]],
            "link2": [["pitch"], ["pitch", "q"], ["pitch"]],
        }[robot.body_on]
        names = {joint for turn in self.turns for joint in turn}
        self.joint = {name: self.model.joint(name).dofadr[0] for name in (*names, *WHEELS)}
        self.spins = [self.joint[w] for w in WHEELS]
        self.wheel_of_geom = {self.model.geom(w).id: i for i, w in enumerate(WHEELS)}
        self.wheel_bodies = [self.model.body(w).id for w in WHEELS]
        self.nearest = ground.Nearest(self.points)
        self.normal_force = np.zeros(3)

    def step(self) -> None:
        """One step. Contact forces and accelerations of `data` then belong to the state at its start."""
        d = self.data
        mujoco.mj_kinematics(self.model, d)
        # Geoms are numbered body by body: those of the ground come first, in the order of their segments.
        kinds = self.model.geom_contype[: len(self.nearest.length)]
        kinds[:] = 0
        for i, w in enumerate(WHEELS):
            near, touch = self.nearest.touches(d.geom(w).xpos[[0, 2]])
            kinds[near] |= touch.astype(kinds.dtype) << i
        mujoco.mj_step1(self.model, d)
        self.time = d.time
        self.qpos, self.qvel = d.qpos.copy(), d.qvel.copy()
        # Positions and velocities (x, z) of the centres of mass: bars, then wheels.
        self.frames = d.sensordata.reshape(-1, 2, 3)[:, :, [0, 2]].copy()
        d.ctrl[:] = self.drive.torque(d.time, self.qvel[self.spins], self.robot.radius, self.model.opt.timestep)
        self.torque = d.ctrl.copy()
        if self.contact.rolling_resistance > 0:
            self._resist_rolling()
        mujoco.mj_step2(self.model, d)
        if self.contact.rolling_resistance > 0:
            self.normal_force = np.array([sum(max(f @ n, 0.0) for f, n, _ in c) for c in self.contact_forces()])

    def _resist_rolling(self) -> None:
        """Moments on the wheels against their absolute spin, from the normal forces of the last step."""
        _, rates = self.link_angles()
        for i, joint in enumerate(self.spins):
            spin = self.qvel[joint] - rates[self.robot.bars.index(self.robot.carriers[i])]
            share = min(max(spin / self.ROLLS, -1.0), 1.0)
            moment = self.contact.rolling_resistance * self.robot.radius * self.normal_force[i] * share
            # Forward spin is positive about +y.
            self.data.xfrc_applied[self.wheel_bodies[i], 4] = -moment

    def contact_forces(self) -> list[list[tuple]]:
        """Contacts of each wheel: force of the ground (x, z), normal (x, z), penetration."""
        found, force = [[], [], []], np.zeros(6)
        for i, contact in enumerate(self.data.contact):
            first, second = contact.geom
            wheel = self.wheel_of_geom.get(second, self.wheel_of_geom.get(first))
            mujoco.mj_contactForce(self.model, self.data, i, force)
            # The frame's first axis points from the first geom to the second, and the force acts on the second.
            sign = 1.0 if second in self.wheel_of_geom else -1.0
            frame = contact.frame.reshape(3, 3)
            world = sign * frame.T @ force[:3]
            found[wheel].append((world[[0, 2]], sign * frame[0, [0, 2]], -contact.dist))
        return found

    def link_angles(self) -> tuple[np.ndarray, np.ndarray]:
        """Angles (rad) and rates (rad/s) of the bars, counter-clockwise from the nominal pose."""
        of = lambda v: np.array([sum(v[self.joint[j]] for j in turn) for turn in self.turns])  # noqa: E731
        return of(self.qpos), of(self.qvel)

    def loop_error(self) -> float:
        """Distance of the two ends of the loop at R, m; 0 of a bogie, which has none."""
        if self.robot.body_on:
            return 0.0
        angles, _ = self.link_angles()
        ends = []
        for bar in (2, 3):
            c, s = math.cos(angles[bar]), math.sin(angles[bar])
            arm = self.robot.pins["r"] - self.robot.cg[self.robot.bars[bar]]
            ends.append(self.frames[bar, 0] + np.array([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]]))
        return float(np.hypot(*(ends[0] - ends[1])))

    def truth(self) -> dict[str, float]:
        """Motion and forces at the start of the last step, with the names of the table `truth` of a run."""
        angles, rates = self.link_angles()
        row = {"time": self.time, "loop_error": self.loop_error()}
        for i, bar in enumerate(self.robot.bars):
            (x, y), (vx, vy) = self.frames[i]
            angle, rate = ("pitch", "pitch_rate") if bar == "body" else ("angle", "rate")
            values = {"x": x, "y": y, angle: angles[i], "vx": vx, "vy": vy, rate: rates[i]}
            row |= {f"{bar}_{name}": value for name, value in values.items()}
        for i, contacts in enumerate(self.contact_forces()):
            carrier_rate = rates[self.robot.bars.index(self.robot.carriers[i])]
            row |= {f"wheel{i + 1}_{name}": value for name, value in self._wheel(i, contacts, carrier_rate).items()}
        return row

    def _wheel(self, i: int, contacts: list[tuple], carrier_rate: float) -> dict[str, float]:
        """State of a wheel and the equivalent contact: one with the same force on the axle and the same traction T."""
        (x, y), velocity = self.frames[len(self.robot.bars) + i]
        omega = self.qvel[self.spins[i]]
        contacts = [c for c in contacts if c[0] @ c[1] > 0]
        if contacts:
            force = sum(c[0] for c in contacts)
            traction = sum(f @ np.array([n[1], -n[0]]) for f, n, _ in contacts)
            normal_force = math.sqrt(max(force @ force - traction**2, 0.0))
            # F = (T + i N) t with vectors as complex numbers.
            angle = math.atan2(force[1], force[0]) - math.atan2(normal_force, traction)
            penetration = max(c[2] for c in contacts)
            normals = [math.atan2(-n[0], n[1]) for _, n, _ in contacts]
            # Contacts with neighbouring segments of one curve are one contact.
            count = 2 if max(normals) - min(normals) > math.radians(15) else 1
        else:
            angle, distance = ground.slope_near(self.points, x, y)
            force, traction, normal_force, penetration, count = np.zeros(2), 0.0, 0.0, self.robot.radius - distance, 0
        angle = math.remainder(angle, 2 * math.pi)
        tangent = np.array([math.cos(angle), math.sin(angle)])
        return {
            "x": x,
            "y": y,
            "angle": self.qpos[self.spins[i]],
            "omega": omega,
            "torque": self.torque[i],
            "normal_force": normal_force,
            "traction": traction,
            "contact_angle": angle,
            "penetration": penetration,
            "slip_speed": (omega - carrier_rate) * (self.robot.radius - penetration) - velocity @ tangent,
            "contacts": count,
            "equivalent_normal_force": normal_force,
            "equivalent_contact_angle": angle,
        }
