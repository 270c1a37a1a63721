"""What does my rover climb? The highest kerb and the steepest slope, up and down, over the friction coefficient: judged at
rest (`robhaz path`) and driven (`robhaz run`), with the wheel that fails first and why.

    python examples/python/climbs.py robots/open-source-rover.toml robots/curiosity.toml --figure climbs.png

A ROBOT is a scene with the section `[robot]`, such as the rovers of robots/, or A, B or C. Needs `robhaz` on the PATH (or
in the variable ROBHAZ), and matplotlib for the figure.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import tomllib

ROBHAZ = os.environ.get("ROBHAZ", "robhaz")
WHEELS = ("front", "middle", "rear")
MU_D = 0.875  # over mu_s
# Finest difference of two kerbs, in wheel radii, and of two slopes, deg; the first step is ten times as large.
FINEST = {"kerb": 0.02, "slope": 0.25}
MOST = {"kerb": 6.0, "slope": 60.0}


@dataclass
class Rover:
    path: Path
    radius: float  # m
    front: float  # x of the axles, m
    rear: float
    speed: float  # m/s

    @classmethod
    def load(cls, path: Path) -> "Rover":
        """The rover of a scene, with all defaults."""
        with tempfile.TemporaryDirectory() as folder:
            run(["run", path, "--set", "record.duration=0.2", "--set", "record.compare_from=0.1", "--set", "record.rate=10",
                 "--set", "sensors.rate=10", "--set", "estimator=[]", "--engine", "direct", "--rerun", "off",
                 "--out", f"{folder}/r"])
            scene = tomllib.loads(Path(folder, "r", "scene.toml").read_text())
        geometry = scene["robot"]["geometry"]
        front, _, rear = (axle[0] for axle in geometry["axles"])
        return cls(path, geometry["wheel_radius"], front, rear, scene["drive"]["speed"])

    @property
    def start(self) -> float:
        """Where the kerb or the slope begins, m."""
        return self.front + 2 * self.radius

    @property
    def goal(self) -> float:
        """x of the middle wheel once the rear wheel has passed the kerb, or stands on the slope, m."""
        return self.start - self.rear + 2 * self.radius


def run(words: list) -> subprocess.CompletedProcess:
    done = subprocess.run([ROBHAZ, *map(str, words)], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(done.stderr)
    return done


def terrain(rover: Rover, kind: str, size: float) -> list[str]:
    """Overrides for a kerb of `size` wheel radii, or a slope of `size` degrees; negative ones go down."""
    sets = [f"terrain.start={rover.start}"]
    if kind == "kerb":
        sets += ["terrain.kind=step", f"terrain.kerb={size * rover.radius}"]
    else:
        sets += ["terrain.kind=ramp", f"terrain.angle={size} deg", f"terrain.length={3 * (rover.front - rover.rear)}"]
    return [word for key in sets for word in ("--set", key)]


def judged(rover: Rover, kind: str, size: float, mu: float) -> str | None:
    """Why `robhaz path` says no-go, with the wheel at the obstacle; None for go."""
    done = run(["--json", "path", rover.path, "--mu", mu, "--distance", rover.goal, *terrain(rover, kind, size)])
    if not done.stdout:
        raise SystemExit(done.stderr)
    report = json.loads(done.stdout)
    failure = report["first_failure"]
    if failure is None:
        return None
    place = min(report["places"], key=lambda p: abs(p["wheel_x"][1] - failure["x"]))
    distances = [abs(x - rover.start) for x in place["wheel_x"]]
    nearest = distances.index(min(distances))
    wheel = WHEELS[nearest] if distances[nearest] < 1.5 * rover.radius else "all"
    return f"{failure['reason']}, {wheel}"


def driven(rover: Rover, kind: str, size: float, mu: float) -> bool:
    """Whether the robot gets there under the speed control of its scene, with no bar on the ground."""
    duration = round(2 * rover.goal / rover.speed + 5)
    rate = max(1, round(2000 / duration))
    with tempfile.TemporaryDirectory() as folder:
        sets = [f"contact.mu_s={mu}", f"contact.mu_d={MU_D * mu}", f"record.duration={duration}", f"record.rate={rate}",
                f"sensors.rate={rate}", "estimator=[]"]
        words = [word for key in sets for word in ("--set", key)]
        run(["run", rover.path, *words, *terrain(rover, kind, size), "--engine", "direct", "--rerun", "off", "--format",
             "csv", "--out", f"{folder}/r"])
        table = Path(folder, "r", "truth.csv")
        if not table.exists():
            return False
        with table.open(newline="") as rows:
            for row in csv.DictReader(rows):
                # A bar on the ground is not modelled, and a robot that slides down does not drive.
                slides = kind == "slope" and float(row["body_vx"]) > 2 * rover.speed
                if float(row["clearance"]) <= 0 or slides:
                    return False
                if float(row["wheel2_x"]) >= rover.goal:
                    return True
    return False


def largest(passes, finest: float, most: float) -> float:
    """The largest size below the first one that does not pass, to `finest`; `most` if all pass."""
    low = 0.0
    for step in (10 * finest, 2 * finest, finest):
        while low + step <= most and passes(low + step):
            low += step
    return low


def row(rover: Rover, kind: str, sign: int, mu: float) -> tuple[float, str, float]:
    """Largest size at rest, why the next one fails, largest size driven."""
    finest, most = FINEST[kind], MOST[kind]
    at_rest = largest(lambda s: judged(rover, kind, sign * s, mu) is None, finest, most)
    why = judged(rover, kind, sign * (at_rest + finest), mu) if at_rest < most else "-"
    return at_rest, why or "-", largest(lambda s: driven(rover, kind, sign * s, mu), finest, most)


CASES = [("kerb", 1), ("kerb", -1), ("slope", 1), ("slope", -1)]
TITLES = {("kerb", 1): "kerb up, D", ("kerb", -1): "kerb down, D", ("slope", 1): "slope up, deg", ("slope", -1): "slope down, deg"}


def shown(kind: str, size: float) -> str:
    """Kerbs in wheel diameters, slopes in degrees; a bound with a sign."""
    value = f"{size / 2:.2f}" if kind == "kerb" else f"{size:.1f}"
    return f">{value}" if size >= MOST[kind] - 1e-9 else value


def figure(results: dict, path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    fig, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    for (name, table), colour in zip(results.items(), plt.get_cmap("tab10").colors, strict=False):
        for axis, case, scale in ((axes[0], CASES[0], 0.5), (axes[1], CASES[2], 1.0)):
            mus = list(table)
            axis.plot(mus, [scale * table[mu][case][0] for mu in mus], color=colour, label=name)
            axis.plot(mus, [scale * table[mu][case][2] for mu in mus], "o", color=colour, markersize=4)
    axes[0].set(title="Highest kerb up", xlabel="friction coefficient", ylabel="wheel diameters")
    axes[1].set(title="Steepest slope up", xlabel="friction coefficient", ylabel="degrees")
    for axis in axes:
        axis.grid(alpha=0.3)
        axis.set_ylim(bottom=0)
    axes[0].legend(fontsize=8, title="line: at rest, dots: driven", title_fontsize=8)
    fig.savefig(path, dpi=110)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("robot", type=Path, nargs="+", metavar="ROBOT")
    p.add_argument("--mu", type=float, nargs="+", default=[0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
    p.add_argument("--jobs", type=int, default=os.cpu_count(), help="commands at once (%(default)s)")
    p.add_argument("--figure", type=Path, help="file of the figure: .png or .svg")
    a = p.parse_args()
    results = {}
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(a.jobs) as pool:
        for path in a.robot:
            if str(path) in ("A", "B", "C"):
                path = Path(folder, f"{path}.toml")
                path.write_text(f'[robot]\ngeometry = "{path.stem}"\n')
            rover = Rover.load(path)
            work = {(mu, c): pool.submit(row, rover, *c, mu) for mu in a.mu for c in CASES}
            table = {mu: {c: work[mu, c].result() for c in CASES} for mu in a.mu}
            results[path.stem] = table
            print(f"### {path.stem}\n\nAt rest / driven at {rover.speed} m/s; in brackets why the next one fails, and at which wheel.\n")
            print("| mu | " + " | ".join(TITLES[c] for c in CASES) + " |\n|---|" + "---|" * len(CASES))
            for mu, cells in table.items():
                texts = [f"{shown(k, cells[k, s][0])} / {shown(k, cells[k, s][2])} ({cells[k, s][1]})" for k, s in CASES]
                print(f"| {mu} | " + " | ".join(texts) + " |")
            print(flush=True)
    if a.figure:
        figure(results, a.figure)


if __name__ == "__main__":
    sys.exit(main())
