"""A study on a real Ray on this machine: a worker is killed meanwhile, and the dataset is that of one process.

    ROBHAZ=target/release/robhaz pytest examples/ray
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("ray", reason="Ray is not installed: pip install ray")

ROBHAZ = shutil.which(os.environ.get("ROBHAZ", "robhaz"))
HERE = Path(__file__).parent


def worker_of(shard: str):
    """Process of the Ray worker whose command computes this shard; None while there is none."""
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            if b"--shard" in words and shard.encode() in words:
                status = (process / "status").read_text()
                return int(next(line for line in status.splitlines() if line.startswith("PPid:")).split()[1])
        except (FileNotFoundError, ProcessLookupError):
            continue
    return None


def test_a_lost_worker_leaves_the_dataset_of_one_process(study, tmp_path):
    subprocess.run([ROBHAZ, "study", study, "--out", tmp_path / "alone", "--quiet"], check=True)
    out = tmp_path / "out"
    command = [sys.executable, HERE / "study.py", study, "--shards", "3", "--out", out, "--robhaz", ROBHAZ]
    # A loaded machine takes longer to start Ray than its default of 30 s.
    environment = {"RAY_raylet_start_wait_time_s": "240"} | os.environ
    log = tmp_path / "log"
    with open(log, "w") as file:
        driver = subprocess.Popen(command, env=environment, stdout=file, stderr=file)
    killed = None
    while driver.poll() is None:
        worker = worker_of("1/3")
        journal = out / "runs-1-of-3.jsonl"
        # In mid-work: some runs of the shard are done, others are not.
        if killed is None and worker and journal.exists() and journal.stat().st_size > 0:
            os.kill(worker, signal.SIGKILL)
            killed = worker
        time.sleep(0.02)
    assert driver.returncode == 0, log.read_text()
    assert killed, "no worker was killed in mid-work"
    dataset = out / "study.parquet"
    assert dataset.read_bytes() == (tmp_path / "alone" / "study.parquet").read_bytes()
