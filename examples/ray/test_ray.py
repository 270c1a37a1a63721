"""A sweep on a real Ray on this machine: a worker is killed meanwhile, and the dataset is that of one process.

    ROBHAZ=target/release/robhaz pytest examples/ray
"""

import os
import shutil
import signal
import subprocess
import threading
import time
from pathlib import Path

import pytest

# A loaded machine takes longer to start Ray than its default of 30 s.
os.environ.setdefault("RAY_raylet_start_wait_time_s", "240")
ray = pytest.importorskip("ray", reason="Ray is not installed: pip install ray")

from sweep import finished_runs, sweep  # noqa: E402

ROBHAZ = shutil.which(os.environ.get("ROBHAZ", "robhaz"))
PATIENCE = 120

SCENE = """
[terrain]
kind = "flat"
[record]
duration = 1
compare_from = 0.5
[[estimator]]
name = "best"
"""
STUDY = """
scene = "scene.toml"
[[axis]]
key = "drive.kp"
values = [2, 5]
[[axis]]
key = "seed"
count = 30
"""


def worker_of(folder: Path):
    """Process of the Ray worker whose command computes the shard in this folder; None while there is none."""
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            if b"sweep" in words and str(folder).encode() in words:
                status = (process / "status").read_text()
                return int(next(line for line in status.splitlines() if line.startswith("PPid:")).split()[1])
        except (FileNotFoundError, ProcessLookupError):
            continue
    return None


def test_a_lost_worker_leaves_the_dataset_of_one_process(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    subprocess.run([ROBHAZ, "sweep", study, "--out", tmp_path / "alone", "--quiet"], check=True)
    out = tmp_path / "out"
    killed = []

    def kill_a_worker():
        start = time.monotonic()
        while time.monotonic() - start < PATIENCE and not killed:
            worker = worker_of(out / "shard-1")
            # In mid-work: some runs of its shard are done, others are not.
            if worker and finished_runs(out) > 0:
                os.kill(worker, signal.SIGKILL)
                killed.append(worker)
            time.sleep(0.02)

    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    killer = threading.Thread(target=kill_a_worker)
    killer.start()
    try:
        dataset = sweep(ROBHAZ, study, shards=3, threads=1, out=out, poll=0.5)
    finally:
        killer.join()
        ray.shutdown()
    assert killed, "no worker was killed in mid-work"
    assert dataset.read_bytes() == (tmp_path / "alone" / "sweep.parquet").read_bytes()
