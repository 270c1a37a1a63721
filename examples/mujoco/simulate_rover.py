"""Drives a rover with both sides in MuJoCo and writes the truth of its wheels' forces:

    python simulate_rover.py --case slope5 rough1 --out runs/rover.csv

A row has the case, the motion of body and joints, and for each wheel the force of the ground with its parts, the
contact point and the contact's angles: SI, in the body frame (`whole_rover.py`). The first two seconds are left out.
"""

import argparse
import csv
from pathlib import Path

from whole_rover import CASES, World

SETTLED = 2.0  # s: standing still, start


def rows(name: str, rate: float, instants: int | None):
    """Rows of a case: `rate` a second, or so many instants in all, equally spaced."""
    case = CASES[name]
    world = World(case)
    dt = world.model.opt.timestep
    every = (case.duration - SETTLED) / instants if instants else 1 / rate
    world.data.time, due = -1.5, SETTLED
    while world.data.time < case.duration - 0.5 * dt:
        world.step()
        if world.time >= due - 0.5 * dt:
            due += every
            yield {"case": name} | world.truth()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", nargs="+", choices=CASES, default=list(CASES), help="default: all")
    parser.add_argument("--rate", type=float, default=50, help="rows a second")
    parser.add_argument("--instants", type=int, help="so many rows a case instead")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with options.out.open("w", newline="") as file:
        table = None
        for name in options.case:
            for row in rows(name, options.rate, options.instants):
                if table is None:
                    table = csv.DictWriter(file, list(row))
                    table.writeheader()
                table.writerow({k: v if isinstance(v, str) else f"{v:.10g}" for k, v in row.items()})


if __name__ == "__main__":
    main()
