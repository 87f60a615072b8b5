"""Sweeps on a Dask cluster: the same bytes, whatever happens to a worker."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from command_line import msbsdf

distributed = pytest.importorskip("distributed")

SWEEP = ("sweep", "walk", "--alpha", "0.3:0.9:4", "--theta", "0,1", "--samples", "300000")


def dask(part, *words):
    """A scheduler or a worker, a process of its own as on another machine."""
    command = [sys.executable, "-m", f"distributed.cli.dask_{part}", *map(str, words)]
    return subprocess.Popen([*command, "--no-dashboard"], stderr=subprocess.DEVNULL)


@pytest.fixture
def cluster(tmp_path_factory):
    """The address of a scheduler, and its two workers."""
    place = tmp_path_factory.mktemp("dask")
    file = place / "scheduler.json"
    where = "--scheduler-file", file
    scheduler = dask("scheduler", *where, "--host", "127.0.0.1", "--port", "0")
    wait_for(file.exists)
    how = "--nthreads", "1", "--no-nanny", "--local-directory", place
    workers = [dask("worker", *where, *how) for _ in range(2)]
    yield json.loads(file.read_text())["address"], workers
    for process in (*workers, scheduler):
        process.kill()
        process.wait()


def wait_for(holds):
    started = time.monotonic()
    while not holds() and time.monotonic() < started + 60:
        time.sleep(0.02)


def on_cluster(address, out):
    words = [*SWEEP, "--scheduler", address, "--out", str(out)]
    return subprocess.Popen(
        [sys.executable, "-m", "msbsdf_cli", *words], stderr=subprocess.PIPE, text=True
    )


def test_a_cluster_gives_the_same_bytes_though_a_worker_is_killed(cluster, tmp_path):
    address, workers = cluster
    assert msbsdf(*SWEEP, "--threads", "1", "--out", tmp_path / "here").returncode == 0
    wanted = (tmp_path / "here" / "sweep.csv").read_bytes()
    whole = on_cluster(address, tmp_path / "there")
    _, said = whole.communicate(timeout=120)
    assert whole.returncode == 0, said
    assert (tmp_path / "there" / "sweep.csv").read_bytes() == wanted
    run = on_cluster(address, tmp_path / "killed")
    wait_for(lambda: list(tmp_path.glob("killed.pieces/*.npz")))
    os.kill(workers[0].pid, signal.SIGKILL)
    _, said = run.communicate(timeout=120)
    assert run.returncode == 0, said
    assert (tmp_path / "killed" / "sweep.csv").read_bytes() == wanted


def test_a_scheduler_that_does_not_answer_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("msbsdf_cli.run.cluster.WAIT_S", 1)
    run = msbsdf(*SWEEP, "--scheduler", "tcp://127.0.0.1:9", "--out", tmp_path / "a")
    assert run.returncode == 1
    assert "no scheduler answers at tcp://127.0.0.1:9" in run.stderr
    assert not list(tmp_path.iterdir())


def test_a_cluster_that_loses_all_workers_is_no_endless_wait(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr("msbsdf_cli.run.completed.LOOK_S", 0.5)
    address, workers = cluster

    def kill():
        wait_for(lambda: list(tmp_path.glob("a.pieces/*.npz")))
        for worker in workers:
            worker.kill()

    threading.Thread(target=kill).start()
    run = msbsdf(*SWEEP, "--scheduler", address, "--out", tmp_path / "a")
    assert run.returncode == 1
    assert "no worker any more" in run.stderr
    assert "are done and kept in a.pieces" in run.stderr
