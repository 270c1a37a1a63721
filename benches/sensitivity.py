#!/usr/bin/env python3
"""Half and double of every constant of the estimator: what each does to the errors of `kalman`.

    python3 benches/sensitivity.py [--cases smooth,course] [--seeds 2] [--only contact/]

The product has no switch for its constants. This script copies the sources to target/sensitivity/, makes a function of every constant
there, whose value is multiplied by the environment variable ROBHAZ_CONSTANT ("file::NAME=2"), and runs the study `no_angles` of that
copy. `just measure sensitivity` writes the page.
"""

import argparse
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COPY = ROOT / "target" / "sensitivity"
DECLARED = re.compile(r"^([ ]*)((?:pub(?:\([a-z]+\))? )?)const ([A-Z][A-Z0-9_]*): (f64|\[f64; 2\]) =\s*([^;]+);", re.M)
FACTOR = """//! Factors of the constants, for benches/sensitivity.py.

fn factor(name: &str) -> f64 {
    static SET: std::sync::OnceLock<Option<(std::string::String, f64)>> = std::sync::OnceLock::new();
    let set = SET.get_or_init(|| {
        let text = std::env::var("ROBHAZ_CONSTANT").ok()?;
        let (name, factor) = text.split_once('=')?;
        Some((name.into(), factor.parse().ok()?))
    });
    match set {
        Some((set, factor)) if set == name => *factor,
        _ => 1.0,
    }
}

/// One constant.
pub fn one(name: &str, value: f64) -> f64 {
    value * factor(name)
}

/// A pair.
pub fn pair(name: &str, value: [f64; 2]) -> [f64; 2] {
    value.map(|value| one(name, value))
}
"""
# Constants of geometry and mathematics, of time stamps and of rounding.
LEFT_OUT = {"UNIFORM", "DIFFERENCES", "HALF_ROOT_3", "ROUNDING", "LONGEST_GAP", "SHORTEST_STEP", "RADIUS", "MASS", "UNKNOWN_TIME", "STRAIGHT",
            "TORQUE", "TURN", "ANGLE", "RATE", "SPIN", "CELLS_BETWEEN", "DEGREE", "OVERLAP", "REACH"}


def outside_comments(text, change):
    """Applies `change` to every line that is neither a comment nor part of a `use`."""
    lines, importing = [], False
    for line in text.split("\n"):
        stripped = line.strip()
        importing = importing or re.match(r"(pub(\([a-z]+\))? )?use ", stripped) is not None
        lines.append(line if importing or stripped.startswith("//") else change(line))
        importing = importing and not stripped.endswith(";")
    return "\n".join(lines)


def transform(source):
    """Makes functions of all constants below `source`. Returns their names."""
    names, files = [], {}
    tuning = source / "filters" / "motion" / "tuning.rs"
    for path in sorted(source.rglob("*.rs")):
        if path.name != "tests.rs":
            files[path] = path.read_text().split("#[cfg(test)]\nmod tests {")[0]
    own = {path: set() for path in files}
    for path, text in files.items():
        module = str(path.relative_to(source).with_suffix(""))

        def declare(match):
            indent, visible, name, kind, value = match.groups()
            if name in LEFT_OUT:
                return match.group(0)
            own[path].add(name)
            names.append(f"{module}::{name}")
            call = "one" if kind == "f64" else "pair"
            return f'{indent}#[allow(non_snake_case)] {visible}fn {name}() -> {kind} {{ crate::factor::{call}("{names[-1]}", {value}) }}'

        files[path] = text if path == tuning else DECLARED.sub(declare, text)
    public = {n for p, text in files.items() for n in own[p] if re.search(rf"pub(\([a-z]+\))? fn {n}\(", text)}
    of_motion = set(re.findall(r"^pub const (\w+):", files[tuning], flags=re.M))
    for path, text in files.items():
        imported = set(re.findall(r"\b[A-Z_]{2,}\b", " ".join(re.findall(r"\buse [\w:]*\bmotion::[^;]+;", text))))
        # Another constant of the same name is not the public one.
        elsewhere = {name for name in public if not re.search(rf"\bconst {name}:", text)} | imported & of_motion

        def call(line):
            for name in own[path] | elsewhere:
                mine = name in own[path]
                before = r"(?<!fn )(?<![\w.\"])((?:[A-Za-z_]+::)*)\b" if mine else r"(?<!fn )(?<![\w.\"])((?:[A-Za-z_]+::)+|)\b"
                line = re.sub(before + name + r"\b(?!\s*\()(?![\w:\"])", lambda m: m.group(0) + "()", line)
            return line
        files[path] = outside_comments(text, call)
    # Their names are those of states, too: only after `tuning::` they are constants.
    def process(match):
        name, kind, value = match.groups()
        names_of = [f"tuning::{name.lower()}"]
        values = [value]
        if kind == "GaussMarkov":
            names_of = [f"{names_of[0]}.sigma", f"{names_of[0]}.time"]
            values = re.match(r"GaussMarkov::new\(([^,]+), ([^)]+)\)", value).groups()
        names.extend(names_of)
        scaled = ", ".join(f'crate::factor::one("{n}", {v})' for n, v in zip(names_of, values))
        scaled = f"GaussMarkov::new({scaled})" if kind == "GaussMarkov" else scaled
        return f"#[allow(non_snake_case)] pub fn {name}() -> {kind} {{ {scaled} }}"

    files[tuning] = re.sub(r"^pub const (\w+): (\w+) = ([^;]+);", process, files[tuning], flags=re.M)
    for path, text in files.items():
        if path.parent == tuning.parent and path != tuning:
            text = re.sub(r"\btuning::([A-Z_]+)\b(?!\()", r"tuning::\1()", text)
        path.write_text(text)
    (source / "factor.rs").write_text(FACTOR)
    library = source / "lib.rs"
    library.write_text(library.read_text().replace("#![no_std]", "").replace("mod contact;", "mod contact;\nmod factor;"))
    return names


def study(binary, constant, arguments):
    """Errors (%) and shares within two sigma (%) of N by case and drive."""
    environment = os.environ | {
        "ROBHAZ_CONSTANT": constant, "ROBHAZ_CASES": arguments.cases, "ROBHAZ_SEEDS": str(arguments.seeds)}
    command = [binary, "no_angles::study_of_all", "--ignored", "--nocapture"]
    run = subprocess.run(command, env=environment, cwd=COPY / "crates" / "study", capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"{constant}: {run.stderr[-2000:]}")
    rows = [line.split("|")[1:-1] for line in run.stdout.splitlines() if line.startswith("| ") and "---" not in line]
    return {f"{row[0].strip()}, {row[1].strip()}": (float(row[2]), float(row[4])) for row in rows if row[1].strip() in ("PI", "soft")}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", default="smooth,rough,course,step,ditch,v_s 0.6,v_s 120,stretches,0.5 m/s,front wheel slips")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--only", default="", help="constants whose name contains this")
    arguments = parser.parse_args()
    for folder in ("crates", "scenes", "robots", "terrains", "tests", "benches"):
        shutil.rmtree(COPY / folder, ignore_errors=True)
        shutil.copytree(ROOT / folder, COPY / folder)
    for file in ("Cargo.toml", "Cargo.lock"):
        shutil.copy(ROOT / file, COPY / file)
    names = transform(COPY / "crates" / "estimator" / "src")
    build = ["cargo", "test", "--release", "--locked", "-p", "robhaz-study", "--test", "study", "--no-run", "--message-format=json"]
    built = subprocess.run(build, cwd=COPY, stdout=subprocess.PIPE, text=True, check=True, env=os.environ | {"CARGO_TARGET_DIR": str(COPY / "target")})
    binary = re.findall(r'"executable":"([^"]+)"', built.stdout)[-1]
    before = study(binary, "", arguments)
    print(f"Mean change of the error of N over {len(before)} cases without contact angles, both drives, %, and the case that changes most, %.")
    print("A dash: no case changes by more than 2 %. Constants of health, friction and the torques' scale do not act on N: their tests hold them.\n")
    print("| constant | half: mean | worst | double: mean | worst |\n|---|---|---|---|---|")
    for name in names:
        if arguments.only not in name or name.startswith(("health/", "friction", "torque_scale")):
            continue
        row = f"| `{name}` |"
        for factor in ("0.5", "2"):
            after = study(binary, f"{name}={factor}", arguments)
            change = {case: 100 * (after[case][0] / error - 1) for case, (error, _) in before.items()}
            mean = 100 * (math.exp(sum(math.log(1 + c / 100) for c in change.values()) / len(change)) - 1)
            worst = max(change, key=lambda case: abs(change[case]))
            row += f" {mean:+.1f} | {worst} {change[worst]:+.0f} |" if abs(change[worst]) > 2 else " - | - |"
        print(row, flush=True)


if __name__ == "__main__":
    main()
