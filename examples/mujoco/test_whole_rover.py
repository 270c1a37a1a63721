"""What the world of a rover with both sides must keep: a closed form, and forces that carry the rover."""

import math

import mujoco
import numpy as np
import pytest
from simulate_rover import Readings, rows
from whole_rover import CASES, NAMES, Case, World, rough

# N, level, T = 0: by moments of a bogie about Q and of a rocker about the rear axle.
LEVEL = np.array([18.240, 25.149, 18.904])
# Shares of a load at the rockers' pivot, and the distance of the sides by them (m); weight (N) and its height (m).
SHARES, BASE = np.array([0.25379, 0.47018, 0.27603]), 0.43533
WEIGHT, HEIGHT = 124.587, 0.16933


def test_loads_on_a_cross_slope():
    """Closed form, left side up. 0.2 %: the tyres' 0.3 mm roll the rover by a mrad, and creep lets it slide."""
    angle = 8.0
    world = World(Case(cross_slope=angle, gains=(0, 0)))
    for _ in range(5000):
        world.step()
    truth = world.truth()
    loads = [truth[f"{name}_normal_force"] for name in NAMES]
    shift = SHARES * WEIGHT * HEIGHT * math.sin(math.radians(angle)) / BASE
    straight = LEVEL * math.cos(math.radians(angle))
    assert loads == pytest.approx([*(straight - shift), *(straight + shift)], rel=2e-3)


@pytest.mark.parametrize("case", ["ackermann", "triple-rough1"])
def test_forces_carry_the_rover(case):
    """Conservation: the impulse of all forces and of gravity is the change of momentum over 2 s of driving, to 0.5 % of
    the weight's. And the parts of a wheel's force are the force."""
    world = World(CASES[case])
    masses, impulse, momentum, dt = world.model.body_mass, np.zeros(3), [], world.model.opt.timestep
    for k in range(8001):
        world.step()
        if k < 4000:
            continue
        truth = world.truth()
        force = sum(world.contacts()[0])
        impulse += dt * (force + masses.sum() * world.model.opt.gravity) * (k < 8000)
        if k in (4000, 8000):
            momentum.append(_momentum(world))
        for name in NAMES:
            parts = [truth[f"{name}_{part}"] for part in ("in_plane_normal_force", "traction", "axial_force")]
            vector = [truth[f"{name}_force_{axis}"] for axis in "xyz"]
            assert np.linalg.norm(parts) == pytest.approx(np.linalg.norm(vector), rel=1e-9, abs=1e-9)
    weight = masses.sum() * world.robot.gravity * 4000 * dt
    assert momentum[1] - momentum[0] == pytest.approx(impulse, abs=5e-3 * weight)


def _momentum(world):
    """Momentum of all bodies at the start of the last step, N s."""
    data = mujoco.MjData(world.model)
    data.qpos[:], data.qvel[:] = world.qpos, world.qvel
    mujoco.mj_forward(world.model, data)
    mujoco.mj_subtreeVel(world.model, data)
    return data.subtree_linvel[0] * world.model.body_subtreemass[0]


def test_a_drawn_rover_has_its_weight_and_its_resistance():
    """Closed form on level ground: the wheels carry the drawn weight (0.2 %), which is within 5 % of the nominal one;
    at a steady speed the motors do what damping, gears and rolling resistance take (3 %: toe drags, too). Another seed is
    another rover, the same one the same."""
    world = World(Case(duration=4.0), draw=64)
    build, radius = world.build, world.robot.radius
    weight = world.model.body_mass.sum() * world.robot.gravity
    torque, count, normal = 0.0, 0, 0.0
    while world.data.time < 4.0:
        world.step()
        if world.time > 2.5:
            torque, count = torque + world.torque.sum(), count + 1
            normal += world.contacts()[0][:, 2].sum()
    assert normal / count == pytest.approx(weight, rel=2e-3)
    assert weight == pytest.approx(WEIGHT, rel=0.05) and weight != pytest.approx(WEIGHT, rel=1e-4)
    taken = 6 * (world.DAMPING * 0.2 / radius + build.gear_friction) + build.rolling_resistance * radius * weight
    assert torque / count == pytest.approx(taken, rel=0.03)
    again, other = (World(Case(), draw=seed).build for seed in (64, 65))
    assert again.sides[0].mass == build.sides[0].mass != other.sides[0].mass


def test_rough_ground_has_the_slopes_that_it_says():
    """Slopes are the differences of heights: 1e-6 of central differences."""
    ground, random = rough(3), np.random.default_rng(0)
    x, y = random.uniform(0, 4, 200), random.uniform(-1, 1, 200)
    _, zx, zy = ground(x, y)
    step = 1e-6
    assert (ground(x + step, y)[0] - ground(x - step, y)[0]) / (2 * step) == pytest.approx(zx, abs=1e-6)
    assert (ground(x, y + step)[0] - ground(x, y - step)[0]) / (2 * step) == pytest.approx(zy, abs=1e-6)


def test_readings_have_the_signs_of_the_frame():
    """Left side up is positive roll and pushes the accelerometer to the left; driving forward turns the wheels forward,
    a turn to the left is positive yaw. Errors within five of their deviations; the same seed repeats them."""
    slope, turn = Case(cross_slope=8.0, duration=1.0), Case(speed=0.1, radius=1.0, steered=True, duration=4.0)
    readings = [Readings(1, 0.34, "differential", case.steered) for case in (slope, turn, turn)]
    *_, at_rest = (readings[0].read(truth) for truth in rows(World(slope), 0.5, 0.0))
    assert at_rest["body_roll"] == pytest.approx(math.radians(8), abs=math.radians(0.7))
    assert at_rest["body_specific_force_y"] == pytest.approx(9.81 * math.sin(math.radians(8)), abs=0.1)
    truth = list(rows(World(turn), 0.5, 2.5))
    turning, again = ([reader.read(row) for row in truth] for reader in readings[1:])
    assert turning == again
    assert np.mean([row["body_yaw_rate"] for row in turning]) == pytest.approx(0.1, rel=0.05)
    assert turning[0]["left_wheel1_steering"] > 0.2 > -0.1 > turning[0]["left_wheel3_steering"]
    assert turning[-1]["right_wheel2_angle"] > turning[-1]["left_wheel2_angle"] > 0
