"""However a run ends, nothing half-written is left, and none of its processes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from command_line import WITHOUT_PICTURES, msbsdf

from msbsdf_cli.results.seal import unsealed

ON_FORK = """
import os, signal
left = [{}]
os.register_at_fork(after_in_parent=lambda: left and signal.raise_signal(left.pop()))
"""
LONG = ["walk", "--samples", "1e11"]


def start(*words, before=""):
    """A run in a process of its own; its standard error is a pipe that its workers hold too."""
    command = [sys.executable, "-c", before + WITHOUT_PICTURES, *map(str, words)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=heed_interrupts)


def heed_interrupts():
    """The interrupt of a shell's background job is ignored, which would be inherited."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def running(pid):
    """Processes whose parent is `pid`."""
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            text = status.read_text()
        except OSError:
            continue
        if int(text.rpartition(")")[2].split()[1]) == pid:
            found.append(int(status.parent.name))
    return found


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"])
def test_a_killed_run_leaves_nothing(name, threads, tmp_path):
    notes = tmp_path / "notes.txt"
    notes.write_text("mine")
    # Between start-up and long after it, another moment for each case.
    moment = np.random.default_rng([threads, getattr(signal, name)]).uniform(0.2, 0.9)
    process = start(*LONG, "--threads", threads, "--out", tmp_path / "r")
    time.sleep(moment)
    workers = running(process.pid)
    process.send_signal(getattr(signal, name))
    try:
        # Workers hold standard error open: it ends with the last of them.
        _, said = process.communicate(timeout=20)
    finally:
        process.kill()
    gone_by = time.monotonic() + 5
    while any(alive(worker) for worker in workers) and time.monotonic() < gone_by:
        time.sleep(0.02)
    assert not any(alive(worker) for worker in workers)
    assert process.returncode != 0
    assert "Traceback" not in said
    assert "BrokenPipe" not in said
    assert not (tmp_path / "r").exists()
    assert notes.read_text() == "mine"
    again = msbsdf("walk", "--samples", 1e3, "--theta", 1, "--quiet", "--out", tmp_path / "r")
    assert again.returncode == 0, again.stderr
    unsealed(tmp_path / "r")
    assert sorted(os.listdir(tmp_path)) == ["notes.txt", "r"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing forks here")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_that_comes_during_a_fork_is_heeded(name, tmp_path):
    """Python loses what is raised there."""
    number = int(getattr(signal, name))
    process = start(*LONG, "--threads", 2, "--out", tmp_path / "r", before=ON_FORK.format(number))
    try:
        _, said = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == (1 if name == "SIGINT" else 128 + number)
    assert "Traceback" not in said
    assert "no report is written" in said
    assert list(tmp_path.iterdir()) == []


def test_runs_at_once_into_one_place_are_all_kept(tmp_path):
    out = tmp_path / "r"
    words = ["walk", "--samples", 1e4, "--theta", 1, "--threads", 1, "--quiet", "--out", out]
    runs = [start(*words, "--seed", seed) for seed in range(3)]
    said = [run.communicate(timeout=60)[1] for run in runs]
    assert [run.returncode for run in runs] == [0, 0, 0] or any("already" in s for s in said)
    kept = [unsealed(path)["seed"] for path in sorted(tmp_path.iterdir())]
    finished = [seed for seed, run in enumerate(runs) if run.returncode == 0]
    assert sorted(kept) == finished
    elsewhere = [s for s in said if "was taken while this ran" in s]
    assert len(elsewhere) == len(finished) - 1
    for path in (path for path in tmp_path.iterdir() if path != out):
        assert any(str(path) in s for s in elsewhere)


@pytest.mark.parametrize("closed", ["2>&-", ">&- 2>&-", "| head -c 1"])
def test_a_closed_stream_is_no_failure(closed, tmp_path):
    words = f"walk --samples 1e3 --theta 1 --alpha 6 --out {tmp_path / 'r'}"
    command = f'{sys.executable} -c "{WITHOUT_PICTURES}" {words} {closed}'.replace("\n", "; ")
    result = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert "Traceback" not in result.stderr
    unsealed(tmp_path / "r")
