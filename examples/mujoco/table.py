r"""Measures what an estimator reaches in MuJoCo's world, and prints the tables of docs/mujoco.md:

    cargo build --release
    python table.py --command ../../target/release/robhaz --out ../../runs/mujoco
    python table.py --command ... --out ... --rows smooth,facets

Each row is one simulation and logs of typical sensors, ten or `--seeds`. A simulation that is already in the folder
`--out` is used again: delete it after a change of the world.
"""

import argparse
import json
import re
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROVERS = ["open-source-rover", "exomy", "curiosity", "sojourner"]
DRIVES = {"PI": "", "soft": "--kp 2 --ki 0"}
# Rows: name, options of simulate.py. Each is driven by the PI and by the low-gain drive.
ROWS = {
    "flat": "--terrain flat",
    "smooth": "--terrain smooth",
    "sine": "--terrain sine",
    "ramp": "--terrain ramp",
    "smooth, robot B": "--terrain smooth --geometry geometry-b",
    "mu 0.4": "--terrain smooth --mu 0.4",
    "mu 0.6": "--terrain smooth --mu 0.6",
    "mu 1.0": "--terrain smooth --mu 1.0",
    "creep 2 mm/s": "--terrain smooth --impratio 50 --step 1.25e-4",
    "creep 5 mm/s": "--terrain smooth --impratio 20",
    "creep 50 mm/s": "--terrain smooth --impratio 2",
    "0.3 m/s": "--terrain smooth --speed 0.3 --duration 14",
    "0.4 m/s": "--terrain smooth --speed 0.4 --duration 11",
    "facets of 20 mm": "--terrain smooth --facet 0.02",
    "facets of 35 mm": "--terrain smooth --facet 0.035",
    "facets of 50 mm": "--terrain smooth --facet 0.05",
    "rolling resistance 0.01": "--terrain smooth --rolling-resistance 0.01",
    "rolling resistance 0.02": "--terrain smooth --rolling-resistance 0.02",
    "rolling resistance 0.02, flat": "--terrain flat --rolling-resistance 0.02",
    "step": "--terrain step",
    "stairs": "--terrain stairs",
    **{f"smooth, {rover}": f"--terrain smooth --geometry {rover}" for rover in ROVERS},
}


HEADER = (
    "| world | drive | error of N, % (range over seeds) | within two sigma, % | stated sigma, % | error of T, N "
    "| creep at T = N, mm/s | in the air, % |\n|---|---|---|---|---|---|---|---|"
)


def simulate(options: list[str], folder: Path, seeds: range) -> None:
    """Writes truth and logs, unless they are there."""
    if not (folder / "SENSORS.toml").exists():
        names = map(str, seeds)
        command = [sys.executable, HERE / "simulate.py", *options, "--seed", *names, "--out", folder]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    if "geometry-b" in options:
        (folder / "robot.toml").write_text('[robot]\ngeometry = "B"\n')
    for rover in set(ROVERS).intersection(options):
        shutil.copy(HERE.parents[1] / f"robots/{rover}.toml", folder / "robot.toml")


def estimate(command: Path, folder: Path, seed: int) -> dict:
    """The summary of `kalman` without contact angles on one log."""
    out = folder / f"estimate-{seed}"
    arguments = [command, "estimate", folder / f"log-{seed}.csv", "--sensors", folder / "SENSORS.toml"]
    arguments += ["--truth", folder / "truth.csv", "--contact-angles", "none", "--out", out]
    robot = folder / "robot.toml"
    if robot.exists():
        arguments += ["--robot", robot]
    subprocess.run(arguments, check=True, capture_output=True)
    summary = json.loads((out / "summary.json").read_text())["estimators"]["kalman-no-angles"]
    shutil.rmtree(out)
    return summary


def of_the_world(folder: Path) -> tuple[float | None, float]:
    """Creep speed of gripping wheels at T = N, mm/s; share of samples with a wheel in the air, %. From 2 s on."""
    with (folder / "truth.csv").open() as file:
        names = file.readline().strip().split(",")
    columns = [names.index(f"wheel{i}_{q}") for q in ("normal_force", "traction", "slip_speed") for i in (1, 2, 3)]
    truth = np.loadtxt(folder / "truth.csv", delimiter=",", skiprows=2001, usecols=columns)
    normal, traction, slip = truth[:, :3], truth[:, 3:6], truth[:, 6:]
    ratio = traction / np.maximum(normal, 1.0)
    grips = (normal > 10) & (np.abs(ratio) > 0.05) & (np.abs(ratio) < 0.3)
    creep = 1e3 * (slip[grips] @ ratio[grips]) / (ratio[grips] @ ratio[grips]) if grips.any() else None
    return creep, 100 * float(np.mean(np.any(normal == 0, axis=1)))


def row(command: Path, name: str, drive: str, folder: Path, seeds: range) -> str:
    """A line of the table."""
    with ThreadPoolExecutor() as pool:
        found = list(pool.map(lambda seed: estimate(command, folder, seed), seeds))
    errors = [100 * s["normal_force"]["nrmse"] for s in found]
    within = 100 * np.mean([s["coverage"] for s in found])
    stated = 100 * np.mean([s["stated"] for s in found])
    traction = np.mean([s["traction"]["rmse_all"] for s in found])
    creep, air = of_the_world(folder)
    slip = "-" if creep is None else f"{creep:.1f}"
    error = f"{np.mean(errors):.2f} ({min(errors):.2f} to {max(errors):.2f})"
    return f"| {name} | {drive} | {error} | {within:.1f} | {stated:.2f} | {traction:.2f} | {slip} | {air:.1f} |"


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--command", type=Path, required=True, help="the command robhaz")
    p.add_argument("--out", type=Path, required=True, help="folder for the logs")
    p.add_argument("--rows", default="", help="words divided by commas: rows whose name contains one of them")
    p.add_argument("--seeds", type=int, default=10, help="number of logs of a row")
    a = p.parse_args()
    seeds = range(1, a.seeds + 1)
    print(HEADER, flush=True)
    for name, options in ROWS.items():
        if not any(word in name for word in a.rows.split(",")):
            continue
        folders = {drive: a.out / re.sub("[^a-z0-9]+", "-", f"{name} {drive}".lower()) for drive in DRIVES}
        with ThreadPoolExecutor() as pool:
            both = [pool.submit(simulate, shlex.split(f"{options} {DRIVES[d]}"), folders[d], seeds) for d in DRIVES]
            _ = [simulation.result() for simulation in both]
        for drive, folder in folders.items():
            print(row(a.command, name, drive, folder, seeds), flush=True)


if __name__ == "__main__":
    main()
