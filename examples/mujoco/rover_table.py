"""Measures what the estimator of both sides reaches in MuJoCo. Prints the tables of docs/measurements/whole-rover.md:

    cargo build --release
    python rover_table.py --command ../../target/release/robhaz --out ../../runs/rover

The first table is of rovers that are exactly as described, and stated to be so; the second of rovers drawn from
what people build (`drawn` in `whole_rover.py`), each with a log of its own. Logs that are already in `--out` are used
again: delete them after a change of the world.
"""

import argparse
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from whole_rover import CASES, TRIPLE_BOGIE

HERE = Path(__file__).resolve().parent
ROVER = HERE.parents[1] / "robots/open-source-rover.toml"
EXACT = "[budget]\nbody_cg = 0\nlink_masses = 0\n"
SETTLED = 2.5  # s, from which errors count

HEADER = (
    "| case | N in the wheel's plane: error, stated, % | within two sigma, % (least) "
    "| N along the ground's normal: error, stated, % | within, % |\n|---|---|---|---|---|"
)


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


def estimate(command: Path, folder: Path, robot: Path, case: str, seed: str) -> dict:
    """What the summary says of both sides."""
    truth = folder / f"{case}-{seed}.csv"
    out = folder / f"estimate-{case}-{seed}"
    arguments = [folder / f"{case}-log-{seed}.csv", "--robot", robot, "--sensors", folder / "SENSORS.toml"]
    arguments += ["--truth", truth if truth.exists() else folder / f"{case}.csv", "--out", out, "--force"]
    subprocess.run([command, "estimate", *arguments, "--quiet"], check=True)
    return json.loads((out / "summary.json").read_text())["both"]


def row(case: str, found: list[dict]) -> str:
    """A line of a table: root mean squares over the logs, means of the shares."""

    def of(errors: str) -> tuple[float, float, np.ndarray]:
        rms = [100 * np.sqrt(np.mean([one[errors][key] ** 2 for one in found])) for key in ("nrmse", "stated")]
        return *rms, 100 * np.array([one[errors]["coverage"] for one in found])

    plane, normal = of("in_plane_normal_force"), of("normal_force")
    shown = f"{plane[0]:.1f}, {plane[1]:.1f} | {plane[2].mean():.1f} ({plane[2].min():.0f}) "
    return f"| {case} | {shown}| {normal[0]:.1f}, {normal[1]:.1f} | {normal[2].mean():.1f} |"


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--command", type=Path, required=True, help="the command robhaz")
    p.add_argument("--out", type=Path, required=True, help="folder for the logs")
    p.add_argument("--case", nargs="+", choices=CASES, default=list(CASES), help="default: all")
    p.add_argument("--seeds", type=int, default=6, help="number of logs of a case, from 61 on; of exact rovers at most 3")
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


if __name__ == "__main__":
    main()
