"""A study under a real Slurm on this machine: a task is killed meanwhile, and the dataset is that of one process.

    ROBHAZ=target/release/robhaz pytest examples/slurm
"""

import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROBHAZ = os.environ.get("ROBHAZ", "robhaz")
NEEDED = ["slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "munged"]
# Longest wait for what takes seconds on an idle machine.
PATIENCE = 240
CONFIG = """
ClusterName=robhaz
SlurmctldHost={host}(127.0.0.1)
AuthInfo=socket={folder}/munge.socket
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,bf_interval=1,requeue_delay=0
MpiDefault=none
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def wait_for(what, reached):
    start = time.monotonic()
    while not reached():
        assert time.monotonic() - start < PATIENCE, f"no {what} after {PATIENCE} s"
        time.sleep(0.2)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def slurm(tmp_path):
    """A cluster of this machine; the environment for its commands."""
    missing = [name for name in NEEDED if shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin") is None]
    if missing:
        pytest.skip(f"Slurm is not installed: no {', '.join(missing)} (apt install slurm-wlm munge)")
    if os.geteuid() != 0:
        pytest.skip("slurmd needs root")
    folder = tmp_path / "slurm"
    for name in ["state", "spool"]:
        (folder / name).mkdir(parents=True)
    host = socket.gethostname().split(".")[0]
    config = folder / "slurm.conf"
    config.write_text(CONFIG.format(host=host, folder=folder, ports=[free_port(), free_port()]))
    # The plugin for cgroups wants the system's; none is used here.
    (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
    key = folder / "munge.key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    environment = os.environ | {"SLURM_CONF": str(config), "PATH": os.environ["PATH"] + ":/usr/sbin"}
    # munged wants folders that no other user can write to.
    folder.chmod(0o755)
    munge = ["munged", "-F", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket"]
    munge += [f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log", f"--seed-file={folder}/munge.seed"]
    logs = open(folder / "daemons.log", "w")
    daemons = []

    def start(command):
        daemons.append(subprocess.Popen(command, env=environment, stdout=logs, stderr=logs))

    try:
        start(munge)
        wait_for("socket of munged", (folder / "munge.socket").exists)
        start(["slurmctld", "-D", "-c"])
        start(["slurmd", "-D", "-N", host])

        def is_idle():
            found = subprocess.run(["sinfo", "-h", "-o", "%T"], env=environment, capture_output=True, text=True)
            return found.stdout.strip() == "idle"

        try:
            wait_for("idle node", is_idle)
        except AssertionError:
            text = "".join(p.read_text()[-1500:] for p in folder.glob("*.log"))
            pytest.fail(f"Slurm did not start:\n{text}")
        yield environment
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
        for daemon in daemons:
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()


def test_a_requeued_task_leaves_the_dataset_of_one_process(slurm, study, tmp_path):
    alone = tmp_path / "alone"
    subprocess.run([ROBHAZ, "study", study, "--out", alone, "--quiet"], check=True)

    out = tmp_path / "out"
    environment = slurm | {"STUDY": str(study), "OUT": str(out), "SHARDS": "3", "ROBHAZ": shutil.which(ROBHAZ)}

    def sbatch(*arguments):
        command = ["sbatch", "--parsable", f"--chdir={tmp_path}", *arguments]
        found = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return found.stdout.strip()

    job = sbatch("--array=1-3", str(HERE / "study.sbatch"))
    sbatch(f"--dependency=afterok:{job}", str(HERE / "dataset.sbatch"))
    journal = out / "runs-1-of-3.jsonl"
    wait_for("finished run of the first shard", lambda: journal.exists() and journal.stat().st_size > 0)
    # The task is killed and starts again.
    subprocess.run(["scontrol", "requeue", f"{job}_1"], env=environment, check=True)
    dataset = out / "study.parquet"
    wait_for("dataset", dataset.exists)
    assert dataset.read_bytes() == (alone / "study.parquet").read_bytes()
    assert "runs are done already" in (tmp_path / "study-1.log").read_text(), "the first task was not killed in mid-work"
