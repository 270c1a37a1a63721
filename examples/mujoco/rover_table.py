"""Measures what the estimator of both sides reaches in MuJoCo. Prints the tables of docs/measurements/whole-rover.md:

    cargo build --release
    python rover_table.py --command ../../target/release/robhaz --out ../../runs/rover

The first table is of rovers that are exactly as described, and stated to be so; the second of rovers drawn from
what people build (`drawn` in `whole_rover.py`), each with a log of its own; the third of each side of these alone, as a
log of one side. Logs that are already in `--out` are used again: delete them after a change of the world.
"""

import argparse
import csv
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from sensors import TYPICAL
from whole_rover import CASES, TRIPLE_BOGIE

HERE = Path(__file__).resolve().parent
ROVER = HERE.parents[1] / "robots/open-source-rover.toml"
# What has no error in the world.
EXACT = "[budget]\n" + "".join(
    f"{key} = 0\n" for key in ("body_cg", "link_masses", "gear_friction", "rolling_resistance", "toe")
)
SETTLED = 2.5  # s, from which errors count
SIDE_TRUTH = (("normal_force", "in_plane_normal_force"), ("traction", "traction"))

HEADER = (
    "| case | N in the wheel's plane: error, stated, % | within two sigma, % (least) "
    "| N along the ground's normal: error, stated, % | within, % |\n|---|---|---|---|---|"
)

HEADER_OF_A_SIDE = "| case | N in the wheel's plane: error, stated, % | within two sigma, % (least) |\n|---|---|---|"


def robot_of(case: str, out: Path) -> Path:
    """The robot file of a case: the Open Source Rover, or its parts as a triple bogie."""
    across = CASES[case].across
    if across is not TRIPLE_BOGIE:
        return ROVER
    values = {
        "coupling": '"rear-bogie"',
        "pivot": list(across.pivot),
        "half_tracks": list(across.half_tracks),
        "link_places": list(across.link_places),
    }
    head, rest = ROVER.read_text().split("[robot.across]")
    lines = [line for line in rest.splitlines() if line.split(" = ")[0] not in values]
    path = out / "triple-bogie.toml"
    own = [f"{key} = {value}" for key, value in values.items()]
    path.write_text(head + "[robot.across]" + "\n".join([lines[0], *own, *lines[1:]]))
    return path


def simulate(case: str, seeds: list[str], folder: Path, draw: bool) -> None:
    """Writes truth and logs, unless they are there."""
    seeds = [seed for seed in seeds if not (folder / f"{case}-log-{seed}.csv").exists()]
    if seeds:
        # One that breaks off leaves no log that looks whole.
        new = folder / f"new-{case}"
        options = ["--case", case, "--seed", *seeds, "--out", new, *(["--draw"] if draw else [])]
        subprocess.run([sys.executable, HERE / "simulate_rover.py", *options], check=True)
        for file in new.iterdir():
            file.replace(folder / file.name)
        new.rmdir()


def of_one_side(folder: Path, case: str, seed: str, side: str) -> str:
    """Writes a log and a truth of a side alone, whose bogie and rocker have an inclinometer and a gyroscope. Returns
    the case's name in their files."""
    sign, series = (1, 0) if side == "left" else (-1, 1000)
    random = np.random.default_rng(series + int(seed))
    name = f"{case}-{side}"
    files = [folder / f"{case}-log-{seed}.csv", folder / f"{case}-{seed}.csv"]
    written = [folder / f"{name}-log-{seed}.csv", folder / f"{name}-{seed}.csv"]
    with (
        files[0].open() as log,
        files[1].open() as truth,
        written[0].open("w") as side_log,
        written[1].open("w") as side_truth,
    ):
        readings, forces = csv.writer(side_log), csv.writer(side_truth)
        wheels = [
            (f"wheel{k}_{what}", f"{side}_wheel{k}_{what}") for k in (1, 2, 3) for what in ("angle", "motor_torque")
        ]
        links = [f"link{k}_{what}" for k in (1, 2) for what in ("inclination", "rate")]
        loads = [(f"wheel{k}_{a}", f"{side}_wheel{k}_{b}") for k in (1, 2, 3) for a, b in SIDE_TRUTH]
        readings.writerow(["time", *(to for to, _ in wheels), *links])
        forces.writerow(["time", *(to for to, _ in loads)])
        for read, true in zip(csv.DictReader(log), csv.DictReader(truth), strict=True):
            rocker = float(read["body_inclination"]) + sign * float(read["differential_angle"])
            rocker_rate = sign * float(true["coupling_rate"]) - float(true["body_rate_y"])
            bogie, bogie_rate = rocker + float(read[f"{side}_pin_angle"]), rocker_rate + float(true[f"{side}_pin_rate"])
            noise = TYPICAL["rate_noise"] * random.standard_normal(2)
            on_links = [bogie, bogie_rate + noise[0], rocker, rocker_rate + noise[1]]
            readings.writerow([read["time"], *(read[of] for _, of in wheels), *on_links])
            forces.writerow([true["time"], *(true[of] for _, of in loads)])
    return name


def estimate(command: Path, folder: Path, robot: Path, case: str, seed: str) -> dict:
    """What the summary says of a log."""
    truth = folder / f"{case}-{seed}.csv"
    out = folder / f"estimate-{case}-{seed}"
    arguments = [folder / f"{case}-log-{seed}.csv", "--robot", robot, "--sensors", folder / "SENSORS.toml"]
    arguments += ["--truth", truth if truth.exists() else folder / f"{case}.csv", "--out", out, "--force"]
    subprocess.run([command, "estimate", *arguments, "--quiet"], check=True)
    return json.loads((out / "summary.json").read_text())


def errors_of(errors: list[dict]) -> tuple[str, str, float]:
    """Error and stated deviation as root mean squares over the logs; mean and least of the shares within two stated
    deviations, the mean as a number, too. All in %."""
    error, stated = (100 * np.sqrt(np.mean([one[key] ** 2 for one in errors])) for key in ("nrmse", "stated"))
    within = 100 * np.array([one["coverage"] for one in errors])
    return f"{error:.1f}, {stated:.1f}", f"{within.mean():.1f} ({within.min():.0f})", within.mean()


def row(case: str, found: list[dict]) -> str:
    """A line of a table of both sides."""
    of = [errors_of([one["both"][key] for one in found]) for key in ("in_plane_normal_force", "normal_force")]
    (plane, within, _), (normal, _, share) = of
    return f"| {case} | {plane} | {within} | {normal} | {share:.1f} |"


def of_a_side(found: dict) -> dict | None:
    """The errors of N of a log of one side; `None` of one with a wheel in the air throughout."""
    (kalman,) = found["estimators"].values()
    if kalman["stated"] is None:
        return None
    return {"nrmse": kalman["normal_force"]["nrmse"], "stated": kalman["stated"], "coverage": kalman["coverage"]}


def sides_alone(a: argparse.Namespace, folder: Path, seeds: list[str]) -> None:
    """Prints the table of sides alone, without triple bogies, whose rear half has no gyroscope, and without logs with a
    wheel in the air throughout."""
    print(f"### One side alone of rovers as built\n\n{HEADER_OF_A_SIDE}", flush=True)
    shares = []
    with ThreadPoolExecutor(2) as pool:
        for case in (case for case in a.case if CASES[case].across is not TRIPLE_BOGIE):

            def found(of: tuple[str, str], case: str = case) -> dict | None:
                name = of_one_side(folder, case, of[0], of[1])
                return of_a_side(estimate(a.command, folder, ROVER, name, of[0]))

            logs = [(seed, side) for seed in seeds for side in ("left", "right")]
            error, within, share = errors_of([errors for errors in pool.map(found, logs) if errors])
            print(f"| {case} | {error} | {within} |", flush=True)
            shares.append(share)
    print(f"\nWithin two sigma in the mean of the cases: {np.mean(shares):.1f} %.")


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--command", type=Path, required=True, help="the command robhaz")
    p.add_argument("--out", type=Path, required=True, help="folder for the logs")
    p.add_argument("--case", nargs="+", choices=CASES, default=list(CASES), help="default: all")
    p.add_argument(
        "--seeds", type=int, default=6, help="number of logs of a case, from 61 on; of exact rovers at most 3"
    )
    a = p.parse_args()
    for what, count in (("exact", min(a.seeds, 3)), ("drawn", a.seeds)):
        folder, seeds = a.out / what, [str(61 + k) for k in range(count)]
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "SENSORS.toml").write_text(f"{EXACT if what == 'exact' else ''}[record]\ncompare_from = {SETTLED}\n")
        with ThreadPoolExecutor(2) as pool:
            _ = list(pool.map(lambda case, f=folder, s=seeds, w=what: simulate(case, s, f, w == "drawn"), a.case))
            print(f"### Rovers {'as described' if what == 'exact' else 'as built'}\n\n{HEADER}", flush=True)
            for case in a.case:
                robot = robot_of(case, a.out)
                found = pool.map(lambda seed, f=folder, r=robot, c=case: estimate(a.command, f, r, c, seed), seeds)
                print(row(case, list(found)), flush=True)
        print()
    sides_alone(a, folder, seeds)


if __name__ == "__main__":
    main()
