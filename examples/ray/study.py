"""A study on a Ray cluster: each task computes one shard, a lost worker's shard goes on elsewhere.

    pip install ray
    python examples/ray/study.py studies/speed.toml --shards 16 --out runs/speed

All nodes need the same `robhaz` binary and a folder that all of them see. Without `--address` Ray starts on this machine.
"""

import argparse
import ctypes
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import ray


def die_with_parent():
    """A worker that is lost takes its command with it: the shard's folder is free for the next worker. Linux."""
    if sys.platform == "linux":
        PR_SET_PDEATHSIG = 1
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


# `max_retries` is for lost workers and nodes; with `retry_exceptions` also for a command that fails, as on a full disk.
@ray.remote(max_retries=5, retry_exceptions=True)
def shard(robhaz: str, study: str, part: int, of: int, threads: int, folder: str) -> int:
    """Computes a shard, or what is left of it. Returns its number."""
    command = [robhaz, "study", study, "--shard", f"{part}/{of}", "--jobs", str(threads), "--out", folder, "--quiet"]
    done = subprocess.run(command, preexec_fn=die_with_parent, capture_output=True, text=True)
    if done.returncode != 0:
        # A command of the worker that was lost may need a moment to end.
        time.sleep(1)
        raise RuntimeError(f"shard {part}/{of}: {done.stderr}")
    return part


def finished_runs(folder: Path) -> int:
    """Finished runs of all shards: their journals have one line a run."""
    return sum(journal.read_bytes().count(b"\n") for journal in folder.glob("runs-*.jsonl"))


def run(robhaz: str, study: Path, shards: int, threads: int, out: Path, poll: float = 5.0) -> Path:
    """Computes all shards, prints progress, makes the dataset. Returns its path."""
    out, study = out.resolve(), study.resolve()
    of_thread = shard.options(num_cpus=threads)
    pending = [
        of_thread.remote(robhaz, str(study), part, shards, threads, str(out)) for part in range(1, shards + 1)
    ]
    start, before = time.monotonic(), finished_runs(out)
    while pending:
        done, pending = ray.wait(pending, num_returns=len(pending), timeout=poll)
        ray.get(done)
        runs = finished_runs(out)
        rate = (runs - before) / (time.monotonic() - start)
        print(f"{runs} runs, {rate:.2f} a second, {shards - len(pending)} of {shards} shards", flush=True)
    subprocess.run([robhaz, "study", study, "--out", out], check=True)
    return out / "study.parquet"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path, help="study file (TOML)")
    parser.add_argument("--shards", type=int, required=True, help="number of shards: a few for each worker")
    parser.add_argument("--threads", type=int, default=1, help="threads of a shard")
    parser.add_argument("--out", type=Path, required=True, help="folder that all nodes see")
    parser.add_argument("--robhaz", default=os.environ.get("ROBHAZ", "robhaz"), help="the command")
    parser.add_argument("--address", help="address of a cluster; without it Ray starts here")
    arguments = parser.parse_args()
    if arguments.address:
        ray.init(address=arguments.address)
    else:
        ray.init(include_dashboard=False)
    run(arguments.robhaz, arguments.study, arguments.shards, arguments.threads, arguments.out)


if __name__ == "__main__":
    main()
