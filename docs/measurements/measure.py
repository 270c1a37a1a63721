#!/usr/bin/env python3
"""Writes the measured tables of this folder, each page by its command and with its head: `just measure`.

    python3 docs/measurements/measure.py                      # all pages, hours of two cores
    python3 docs/measurements/measure.py ground no-angles     # some
    python3 docs/measurements/measure.py --seeds 4 no-angles  # with fewer seeds than the page's own number
    python3 docs/measurements/measure.py --list

A page is written when all its commands have run; where a test fails by its limit, page and exit code say so. It needs
Python alone, but for `ablation`, `speed`, `noise-budget` and `lumping` (pandas, pyarrow), `mujoco` and `whole-rover`
(mujoco) and `climbs` (matplotlib).
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
ROBHAZ = TARGET / "release/robhaz"
SOFT = ["drive.kp=2", "drive.ki=0"]
TYPICAL, POOR = ["sensors.grade=typical"], ["sensors.grade=poor"]
FRICTION = ["sensors.torque_friction=0.5"]
NOMINAL = ["model_error.body_cg='10 mm'", "model_error.link_masses=0.1", "model_error.pins='2 mm'"]
# Lines of cargo and of the test harness.
NOISE = re.compile(r"^(running \d+ test|test result|ok$|successes:|failures:|\s*(Compiling|Finished|Running) )"
                   r"|has been running for over|^Found \d+ outliers|^  \d+ \(\d"
                   r"|^test \S+ \.\.\. (ok$|ignored)|^FAILED$|^    \w+(::\w+)+$")

BEYOND_LIMITS = []


def run(command, **environment):
    """Standard output of a command in the repository."""
    env = os.environ | {key: str(value) for key, value in environment.items()}
    done = subprocess.run([str(word) for word in command], cwd=ROOT, env=env, text=True, capture_output=True)
    if done.returncode != 0 and "test result: FAILED" in done.stdout:
        # What was measured is beyond the limit of a test: the page says so.
        BEYOND_LIMITS.append(" ".join(map(str, command)))
        return done.stdout + f"\nBEYOND THE LIMIT OF THE TEST: {done.stderr.split('panicked at')[-1].splitlines()[1]}\n"
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}")
    return done.stdout


def page_of(lines):
    """Rows of tables as they are, other lines as blocks of text."""
    found, kind, starts_table = [], None, False
    for line in lines:
        now = "table" if line.startswith("|") else "heading" if line.startswith("### ") else "text"
        if now != kind:
            found += ["```"] * (kind == "text") + [""] + ["```text"] * (now == "text")
            starts_table, kind = now == "table", now
        elif kind == "table" and starts_table:
            # A table whose test prints no line below its head.
            found += ["|---" * (line.count("|") - 1) + "|"] * (not line.startswith("|---"))
            starts_table = False
        found.append(line)
    return "\n".join(found + ["```"] * (kind == "text"))


class Tests:
    """What tests print: the crate's options, a filter; with `ignored` the studies that do not run by default."""

    def __init__(self, options, *filters, ignored=False, **environment):
        self.words = ["cargo", "test", "--release", "--locked", *options.split()]
        self.filters, self.ignored, self.environment = filters, ignored, environment

    def environment_of(self, seeds):
        return {name: value.format(seeds=seeds) for name, value in self.environment.items()}

    def command(self, seeds):
        before = "".join(f"{name}={value} " for name, value in self.environment_of(seeds).items())
        ignored = " --ignored" * self.ignored
        return f"{before}{' '.join(self.words)} -- {' '.join(self.filters)}{ignored} --nocapture"

    def text(self, seeds):
        words = [*self.words, "--", *self.filters, *["--ignored"] * self.ignored, "--nocapture", "--test-threads=1"]
        lines = []
        for line in run(words, **self.environment_of(seeds)).splitlines():
            if NOISE.search(line) or not line.strip():
                continue
            test = re.match(r"^test (\S+) \.\.\. ?", line)
            if test:
                name, line = test[1].split("::")[-1].replace("_", " "), line[test.end():]
                lines.append(f"### {name[:1].upper()}{name[1:]}")
            if line.strip():
                lines.append(line.rstrip())
        # A test that prints nothing has no heading.
        return page_of([a for a, b in zip(lines, [*lines[1:], "### "]) if not (a.startswith("### ") and b.startswith("### "))])


def mean(score, name, factor=100.0):
    value = score.get(name)
    return None if value is None else factor * value["mean"]


def both(values, digits):
    """The figures of both drives: PI / soft."""
    return " / ".join("-" if value is None else f"{value:.{digits}f}" for value in values)


class Cases:
    """Scenes with overrides, both drives, means over seeds of some estimators: `robhaz study SCENE`."""

    def __init__(self, cases, *estimators, options=()):
        self.cases, self.estimators, self.options = cases, estimators, list(options)

    def words(self, scene, keys, seeds):
        sets = [word for key in keys for word in ("--set", key)]
        return [ROBHAZ, "study", f"scenes/{scene}.toml", "--engine", "direct", *self.options, "--seeds", seeds, *sets]

    def command(self, seeds):
        scene, keys = next(iter(self.cases.values()))
        words = self.words(scene, keys, seeds)
        return f"robhaz {' '.join(map(str, words[1:]))}     # a case; soft: --set {' --set '.join(SOFT)}"

    def text(self, seeds):
        lines = ["| case | estimator | N, % | N at one contact, % | T, N | stated, % | within two sigma, % | NEES |",
                 "|---|---|---|---|---|---|---|---|"]
        for name, (scene, keys) in self.cases.items():
            reports = [json.loads(run([*self.words(scene, [*keys, *drive], seeds), "--json", "-q"])) for drive in ([], SOFT)]
            for estimator in self.estimators or [e["name"] for e in reports[0]["estimators"]]:
                scores = [next(e for e in r["estimators"] if e["name"] == estimator) for r in reports]
                consistency = [s["consistency"] or {} for s in scores]
                cells = [both([mean(s, "nrmse") for s in scores], 2), both([mean(s, "nrmse_at_one_contact") for s in scores], 2),
                         both([mean(s, "traction_rmse_n", 1.0) for s in scores], 2),
                         both([mean(s, "stated") for s in scores], 2),
                         both([mean(c, "coverage") for c in consistency], 1), both([mean(c, "nees", 1.0) for c in consistency], 2)]
                lines.append(f"| {name} | `{estimator}` | {' | '.join(cells)} |")
        return "PI drive / low-gain drive.\n\n" + "\n".join(lines)


class Dataset:
    """Medians over the runs of a study file, %: `rows` and `columns` are columns of the dataset."""

    def __init__(self, study, rows, columns, scores=("nrmse",), code=None):
        self.study, self.rows, self.columns, self.scores, self.code = study, rows, columns, scores, code

    def command(self, _seeds):
        return f"robhaz study studies/{self.study}.toml"

    def text(self, _seeds):
        import pandas
        with tempfile.TemporaryDirectory() as folder:
            run([ROBHAZ, "study", f"studies/{self.study}.toml", "--out", f"{folder}/study", "-q"])
            table = pandas.read_parquet(f"{folder}/study/study.parquet")
        if self.code:
            return self.code(table)
        found = []
        for score in self.scores:
            order = list(dict.fromkeys(table[self.rows].dropna()))
            names = list(dict.fromkeys(table[self.columns].dropna()))
            median = table.groupby([self.rows, self.columns])[score].median()
            lines = [f"`{score}`, %:", "", f"| {self.rows} | {' | '.join(f'{name}' for name in names)} |", "|---" * (len(names) + 1) + "|"]
            for row in order:
                cells = [f"{100 * median.get((row, name), float('nan')):.2f}" for name in names]
                lines.append(f"| {row} | {' | '.join(cells)} |")
            found.append("\n".join(lines))
        return "Medians over the runs.\n\n" + "\n\n".join(found)


def lumping(table):
    """How often one way of lumping beats the other, by the place of the body's centre of mass."""
    import pandas
    errors = table[table.error.isna()].pivot(index="index", columns="estimator", values="nrmse")
    place = table.drop_duplicates("index").set_index("index")["robot.geometry.body_cg.0"].loc[errors.index]
    better = errors["paper-wheels"] < errors["paper-body"]
    lines = ["| body's centre of mass, x | robots | share where Fig. 8 is better, % | `paper-body`, % | `paper-wheels`, % | `true-mass`, % |",
             "|---|---|---|---|---|---|"]
    for name, low, high in [("all", -9, 9), ("below -10 mm", -9, -0.01), ("-10 to 30 mm", -0.01, 0.03),
                            ("30 to 70 mm", 0.03, 0.07), ("above 70 mm", 0.07, 9)]:
        of = (place >= low) & (place < high)
        medians = [f"{100 * errors[of][e].median():.1f}" for e in ("paper-body", "paper-wheels", "true-mass")]
        lines.append(f"| {name} | {of.sum()} | {100 * better[of].mean():.1f} | {' | '.join(medians)} |")
    failed = table[table.error.notna()].drop_duplicates("index").error.str.split(r"[:;,(]|\d").str[0].str.strip()
    lines += ["", f"{table['index'].nunique()} robots drawn; runs that failed, by their reason:", "", "| reason | robots |", "|---|---|"]
    lines += [f"| {reason} | {count} |" for reason, count in failed.value_counts().items()]
    return "Medians over the robots.\n\n" + "\n".join(lines)


class Rates:
    """Errors over the sampling rate, one seed."""

    RATES = {"1000 Hz": ["sensors.rate=1000"], "200 Hz": ["sensors.rate=200", "record.rate=200"],
             "100 Hz": ["sensors.rate=100", "record.rate=100"], "50 Hz": ["sensors.rate=50", "record.rate=50"],
             "20 Hz": ["sensors.rate=20", "record.rate=20"], "10 Hz": ["sensors.rate=10", "record.rate=10"],
             "10 kHz": ["sensors.rate=10000", "record.duration=3"], "100 kHz": ["sensors.rate=100000", "record.duration=3"]}

    def command(self, seeds):
        return f"robhaz study scenes/SCENE.toml --engine direct --seeds {seeds} --set sensors.grade=typical --set sensors.rate=RATE"

    def text(self, seeds):
        cases = {f"`{scene}`, {rate}": (scene, [*TYPICAL, *keys]) for scene in ("cosbump", "sine", "smooth")
                 for rate, keys in self.RATES.items() if "kHz" not in rate or scene == "smooth"}
        return Cases(cases, "paper-wheels", "kalman", "kalman-no-angles").text(seeds)


class Command:
    """What a command prints."""

    def __init__(self, words, shown):
        self.words, self.shown = words, shown

    def command(self, _seeds):
        return self.shown

    def text(self, _seeds):
        lines = [line.rstrip() for line in run(self.words).splitlines() if not NOISE.search(line) and line.strip()]
        return page_of(lines)


class Mujoco(Command):
    def __init__(self, script):
        self.script = f"examples/mujoco/{script}"
        super().__init__(None, f"python {self.script} --command target/release/robhaz --out FOLDER --seeds {{}}")

    def command(self, seeds):
        return self.shown.format(seeds)

    def text(self, seeds):
        with tempfile.TemporaryDirectory() as folder:
            words = [sys.executable, self.script, "--command", ROBHAZ, "--out", folder, "--seeds", seeds]
            return page_of([line for line in run(words).splitlines() if line])


class Climbs(Command):
    """Writes its figure into docs/, too."""

    def __init__(self):
        rovers = [f"robots/{name}.toml" for name in ("open-source-rover", "exomy", "curiosity", "sojourner")]
        words = ["examples/python/climbs.py", *rovers, "A", "B", "C", "--figure", "docs/climbs.png"]
        super().__init__([sys.executable, *words], f"python {' '.join(words)}")

    def text(self, _seeds):
        return run(self.words, ROBHAZ=ROBHAZ)


STUDY = "-p robhaz-study --test study"
TRUTH = "-p robhaz --test robhaz"
EDGES = {f"`{scene}`{' (A)' * (scene == 'stairs')}, {grade[0].split('=')[1]}":
         (scene, [*grade, *["robot.geometry=A"] * (scene == "stairs")])
         for scene in ("ramp", "step", "ditch", "course", "stairs") for grade in (TYPICAL, POOR)}
WEIGHED = [*TYPICAL, *FRICTION, *NOMINAL]
STEPS = {"ideal": ["sensors.grade=ideal"], "typical": TYPICAL, "typical, 0.5 N m of friction": [*TYPICAL, *FRICTION], "poor": POOR}
FIXED = "those that the tests name"
# Name of a page: title, seeds ({seeds} of a recipe that takes a number), default number, parts.
PAGES = {
    "levels": ("Errors and consistency of `kalman` with given contact angles, against the required levels",
               "0 to 9 on `smooth`, 0 to 4 elsewhere", 10, [Tests(TRUTH, "acceptance_estimators")]),
    "ablation": ("What each step of the method brings",
                 "0 to {last} on `smooth`; 0 to 3 on the other grounds (`studies/ladder.toml`)", 10,
                 [Cases({name: ("smooth", keys) for name, keys in STEPS.items()}, options=["--ladder"]),
                  Dataset("ladder", "estimator", "terrain.kind", ("nrmse", "nrmse_at_one_contact"))]),
    "no-angles": ("`kalman` without contact angles: samples with one contact a wheel, then all", "0 to {last}", 10,
                  [Tests(STUDY, "no_angles::study_of", ignored=True, ROBHAZ_SEEDS="{seeds}")]),
    "edges": ("Errors at edges", "0 to {last}", 10, [Cases(EDGES, "paper-wheels", "kalman")]),
    "contact-states": ("Contact states: events found; shares of the time falsely stated and missed (NaN: there is none)", "0 to 2", 3,
                       [Tests(TRUTH, "acceptance_contacts")]),
    "ground": ("Errors of the estimated terrain", "0 to 9", 10, [Tests("-p robhaz-run --test run", "ground::")]),
    "torque-scale": ("Torques of a wrong scale, and payloads", "5", 1,
                     [Tests(TRUTH, "check::torque_scale::nothing_wrong_is_trusted", ignored=True)]),
    "check-faults": ("Faults that `robhaz check` finds, and false alarms", "{seeds} from 1000 on", 20,
                     [Tests(TRUTH, "check::study::", ignored=True, SEEDS="{seeds}")]),
    "false-alarms": ("False alarms of `robhaz check` and of the estimators' health",
                     "of the logs from 5000 on; of the health 0 to {last}", 100,
                     [Tests(TRUTH, "check::honest_logs::", ignored=True), Tests(TRUTH, "check::health::", ignored=True, SEEDS="{seeds}")]),
    "fault-times": ("Time until a fault is reported: runs within 5 s / ever / all; median and last, s of driving", "0 to {last}", 20,
                    [Tests(TRUTH, "check::fault_times::", ignored=True, SEEDS="{seeds}")]),
    "rates": ("Errors over the sampling rate", "0 to {last}", 5, [Rates()]),
    "friction-test": ("The friction test", "{seeds} from 100 on; onset of slip 0 to 9; parts 0 to 4", 20,
                      [Tests(STUDY, "friction_test::", ignored=True, ROBHAZ_SEEDS="{seeds}")]),
    "driving": ("Drives compared: needed friction, slip, energy; ramps and kerbs climbed", "of the scenes", 1,
                [Tests(STUDY, "driving::study", ignored=True)]),
    "path-verdict": ("The verdict of `robhaz path` against driving", "{seeds} random paths of series 300, drawn after the verdict was made", 280,
                     [Tests(STUDY, "path_verdict::study", ignored=True, ROBHAZ_SERIES="300", ROBHAZ_PATHS="{seeds}", ROBHAZ_DRIVE=drive)
                      for drive in ("shared", "speed")]),
    "weighing": ("Weighed robots", "0 to {last} while driving; 40 random robots at rest", 10,
                 [Tests("-p robhaz-masses --test weighing"),
                  Cases({"exact robot": ("smooth", [*TYPICAL, *FRICTION]), "nominal robot": ("smooth", WEIGHED),
                         **{f"weighed, scales to {scale} N": ("smooth", [*WEIGHED, f"model_error.scales={scale}"])
                            for scale in (0.2, 1, 2)},
                         "ideal sensors, nominal robot": ("smooth", NOMINAL),
                         "ideal sensors, weighed to 0.2 N": ("smooth", [*NOMINAL, "model_error.scales=0.2"])},
                        "kalman", "kalman-no-angles")]),
    "mujoco": ("`kalman` without contact angles in MuJoCo", "1 to {seeds}", 10, [Mujoco("table.py")]),
    "whole-rover": ("Both sides of rovers in MuJoCo", "{seeds} from 61 on; of rovers as described at most 3", 6, [Mujoco("rover_table.py")]),
    "rovers": ("Rovers: `kalman` without contact angles, friction tests, go or no-go",
               "0 to 3; {seeds} random paths of series 301", 301,
               [Tests(TRUTH, "rovers::study", ignored=True),
                *[Tests(STUDY, "path_verdict::study", ignored=True, ROBHAZ_ROVER=rover, ROBHAZ_SERIES="301", ROBHAZ_PATHS="{seeds}",
                        ROBHAZ_DRIVE="speed") for rover in ("open-source-rover", "curiosity")]]),
    "climbs": ("What each robot climbs", "0", 1, [Climbs()]),
    "speed": ("Error over the speed", "0 to 19", 20, [Dataset("speed", "drive.speed", "estimator", ("nrmse",))]),
    "noise-budget": ("One kind of sensor ideal or poor, all others typical", "0 to 9", 10,
                     [Dataset("noise-budget", "sensors", "estimator")]),
    "lumping": ("Linkage mass lumped to the body or to the wheels", "0; 2450 robots drawn by `studies/lumping.toml`", 1,
                [Dataset("lumping", "", "", code=lumping)]),
    "truth": ("Validation of the truth", FIXED, 1,
              [Tests(TRUTH, *("reference:: conservation:: closed_form:: friction_laws:: convergence:: invariance:: properties::").split()),
               Tests(TRUTH, "engines_agree_on_every_shipped_scene", ignored=True)]),
    "sensitivity": ("Half and double of the estimator's constants", "0 to {last}", 1,
                    [Command([sys.executable, "benches/sensitivity.py", "--seeds", "1"], "python3 benches/sensitivity.py --seeds 1")]),
    "cost": ("Speed of engines and estimators: times, which depend on the load of the machine, and instructions, which do not", "0", 1,
             [Command(["cargo", "bench", "-p", "robhaz-benches", "--locked"], "cargo bench -p robhaz-benches"),
              Command([".ci/instructions"], ".ci/instructions"),
              Command(["cargo", "run", "--release", "--locked", "--manifest-path", "crates/estimator/no_panic/Cargo.toml",
                       "--target-dir", TARGET / "no_panic"], "cd crates/estimator/no_panic && cargo run --release")]),
}


def version():
    """Of the program, and of the code that it was built from; pages and their recipe do not count."""
    commit = run(["git", "rev-parse", "--short", "HEAD"]).strip()
    paths = ["crates", "scenes", "robots", "studies", "tests", "benches", "examples", "Cargo.lock"]
    changed = run(["git", "status", "--porcelain", "--", *paths]).strip()
    return f"{run([ROBHAZ, '--version']).strip()}, code {commit}{'-dirty' * bool(changed)}"


def main():
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("pages", nargs="*", metavar="PAGE")
    asked.add_argument("--seeds", type=int, help="number of seeds, in place of the page's own")
    asked.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder of the pages")
    asked.add_argument("--list", action="store_true", help="names the pages")
    asked = asked.parse_args()
    if asked.list:
        print("\n".join(PAGES))
        return
    unknown = [name for name in asked.pages if name not in PAGES]
    if unknown:
        raise SystemExit(f"no page {', '.join(unknown)}; there are {', '.join(PAGES)}")
    run(["cargo", "build", "--release", "--locked"])
    asked.out.mkdir(parents=True, exist_ok=True)
    for name in asked.pages or PAGES:
        title, seeds, default, parts = PAGES[name]
        count = asked.seeds or default
        head = f"Written by `just measure {name}`, not by hand. Version: {version()}."
        head += f"\nSeeds: {seeds.format(seeds=count, last=count - 1)}."
        print(f"{name} ...", file=sys.stderr, flush=True)
        blocks = [f"    {part.command(count)}\n\n{part.text(count).strip()}" for part in parts]
        (asked.out / f"{name}.md").write_text(f"# {title}\n\n{head}\n\n" + "\n\n".join(blocks) + "\n")
    index = [f"| [{name}]({name}.md) | {page[0]} |" for name, page in PAGES.items()]
    index = ["# Measurements", "", "Written by `just measure`; the head of each page has the version and the seeds.", "",
             "| page | content |", "|---|---|", *index,
             "| [rules](rules.md) | What each rule of the estimator does when it is off; measured once, before most were deleted |"]
    (asked.out / "README.md").write_text("\n".join(index) + "\n")
    if BEYOND_LIMITS:
        raise SystemExit("beyond the limits of their tests:\n" + "\n".join(BEYOND_LIMITS))


main()
