r"""Drives the robot in MuJoCo and writes what a robot would record, with the truth beside it:

    python simulate.py --terrain smooth --seed 1 --out runs/mujoco-smooth
    robhaz estimate runs/mujoco-smooth/log-1.csv --sensors runs/mujoco-smooth/SENSORS.toml \
        --truth runs/mujoco-smooth/truth.csv --contact-angles none

With `--geometry open-source-rover`, or another rover of robots/, ground, speed, gains, sensors and duration are scaled
to it (Froude): the options are those of robot A. Then `robhaz estimate` takes `--robot robots/open-source-rover.toml`.

The folder gets `log-SEED.csv` (readings), `SENSORS.toml` (their description) and `truth.csv` (forces and motion).
"""

import argparse
import csv
import math
from contextlib import ExitStack
from pathlib import Path

import ground
from robot import Robot, load
from sensors import DAMPING_ERROR, DEG, TYPICAL, Sensors
from world import Contact, Drive, World

SENSORS_TOML = """\
# Readings of a robot simulated in MuJoCo. Keys and defaults: docs/logs.md.

sides = "plane"
missing = ["wheel1_contact_angle", "wheel2_contact_angle", "wheel3_contact_angle"]

[drive]
viscous_damping = {damping:.6g} # N m s

[budget]
# The simulated robot is the described one.
body_cg = 0
link_masses = 0
encoder_counts = {encoder_counts}
torque_gain = {torque_gain}
torque_offset = {torque_offset} # N m
torque_noise = {torque_noise} # N m
inclination_bias = "{bias_deg:.6g} deg"
inclination_noise = "{noise_deg:.6g} deg"
rate_noise = "{rate_deg:.6g} deg/s"

[[channel]]
name = "log"

[reading]
{readings}
"""


def record(world: World, seeds: list[int], duration: float, rate: int, folder: Path) -> None:
    """Simulates `duration` seconds once and writes `rate` samples a second: the truth, and a log for each seed."""
    steps = round(1 / (rate * world.model.opt.timestep))
    torque, gravity = world.robot.units.torque, world.robot.gravity
    sensors = {f"log-{seed}.csv": Sensors(seed, torque, gravity) for seed in seeds}
    with ExitStack() as files:
        tables = {
            n: csv.writer(files.enter_context((folder / n).open("w", newline=""))) for n in (*sensors, "truth.csv")
        }
        for sample in range(round(duration * rate)):
            world.step()
            truth = world.truth()
            truth["time"] = sample / rate  # without the rounding of a sum of steps
            if not all(map(math.isfinite, truth.values())) or truth["loop_error"] > 1e-4:
                raise SystemExit(f"simulate.py: the simulation broke down at {truth['time']} s: try a smaller --step")
            rows = {"truth.csv": truth} | {name: s.read(truth) for name, s in sensors.items()}
            for name, row in rows.items():
                if sample == 0:
                    tables[name].writerow(row)
                tables[name].writerow([repr(float(v)) for v in row.values()])
            for _ in range(steps - 1):
                world.step()


def describe(damping: float, torque: float) -> str:
    """The description of the log: readings by their own names, and the errors of the sensors, those of the torques in
    units of `torque`."""
    typical = TYPICAL | {name: torque * TYPICAL[name] for name in ("torque_offset", "torque_noise")}
    names = [f"wheel{i}_{r}" for i in (1, 2, 3) for r in ("angle", "motor_torque")]
    names += [f"link{i}_{r}" for i in (1, 2) for r in ("inclination", "rate")]
    return SENSORS_TOML.format(
        damping=(1 + DAMPING_ERROR) * damping,
        readings="\n".join(f'{name} = {{ column = "{name}" }}' for name in names),
        bias_deg=TYPICAL["inclination_bias"] / DEG,
        noise_deg=TYPICAL["inclination_noise"] / DEG,
        rate_deg=TYPICAL["rate_noise"] / DEG,
        **typical,
    )


def arguments() -> argparse.Namespace:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    contact, drive, profile = Contact(), Drive(), ground.Ground()
    p.add_argument("--terrain", choices=sorted(ground.PROFILES), default=profile.terrain)
    p.add_argument(
        "--facet", type=float, default=profile.facet, help="smooth, sine: distance of corners, m; 0 for a curve (0)"
    )
    p.add_argument("--kerb", type=float, default=profile.kerb, help="step: height, m (%(default)s)")
    p.add_argument("--seed", type=int, nargs="+", default=[1], help="of the sensors' errors; each gets a log (1)")
    p.add_argument("--duration", type=float, default=20.0, help="s (%(default)s)")
    p.add_argument("--rate", type=int, default=1000, help="samples a second (%(default)s)")
    p.add_argument("--step", type=float, default=2.5e-4, help="time step, s (%(default)s)")
    p.add_argument("--geometry", default="geometry-a", help="a file of robots/ (%(default)s)")
    p.add_argument("--mass", default="mass-caption", help="a file of robots/ (%(default)s)")
    p.add_argument("--speed", type=float, default=drive.speed, help="m/s (%(default)s)")
    p.add_argument("--kp", type=float, default=drive.kp, help="N m s (%(default)s)")
    p.add_argument("--ki", type=float, default=drive.ki, help="N m; 0 for a low-gain drive (%(default)s)")
    p.add_argument("--mu", type=float, default=contact.mu, help="friction coefficient (%(default)s)")
    p.add_argument("--solref", default=contact.solref, help="of the contacts (%(default)s)")
    p.add_argument("--solimp", default=contact.solimp, help="of the contacts (%(default)s)")
    p.add_argument(
        "--impratio", type=float, default=contact.impratio, help="friction over normal impedance (%(default)s)"
    )
    p.add_argument(
        "--rolling-resistance", type=float, default=contact.rolling_resistance, help="moment over r N (%(default)s)"
    )
    p.add_argument("--out", type=Path, required=True, help="folder for the files")
    return p.parse_args()


def main() -> None:
    a = arguments()
    robot: Robot = load(a.geometry, a.mass)
    u = robot.units
    drive = Drive(
        speed=a.speed * u.length / u.time,
        kp=a.kp * u.torque * u.time,
        ki=a.ki * u.torque,
        torque_limit=10.0 * u.torque,
        tracking_time=0.1 * u.time,
        damping=0.15 * u.torque * u.time,
        start_time=0.8 * u.time,
        ramp_time=0.6 * u.time,
    )
    # A rover with a longer wheelbase over its wheels has farther to go.
    duration = a.duration * u.time * (robot.axles[0][0] - robot.axles[2][0]) / (0.6 * u.length)
    time_constant, damping_ratio = map(float, a.solref.split())
    solref = f"{time_constant * u.time:.17g} {damping_ratio:.17g}"
    contact = Contact(a.mu, solref, a.solimp, a.impratio, a.rolling_resistance)
    world = World(robot, ground.Ground(a.terrain, a.facet, a.kerb), contact, drive, a.step)
    a.out.mkdir(parents=True, exist_ok=True)
    record(world, a.seed, duration, a.rate, a.out)
    (a.out / "SENSORS.toml").write_text(describe(drive.damping, u.torque))
    print(f"wrote truth.csv, SENSORS.toml and {len(a.seed)} log(s) to {a.out}")


if __name__ == "__main__":
    main()
