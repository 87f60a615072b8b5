"""Jobs whose processes die: nothing hangs, and nothing but what kills is lost."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest

from msbsdf_cli.run.completed import KILLED, Failed, map_completed


def square(job):
    if job == 7:
        raise ValueError("seven is not squared")
    return job * job


def die_at(job, killer, once):
    """Squares, but for what kills its process: once, if there is a file `once` to remember it."""
    if job == killer and (once is None or not once.exists()):
        if once is not None:
            once.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return job * job


@pytest.mark.parametrize("workers", [1, 2])
def test_every_job_comes_back_with_its_result_or_why_there_is_none(workers):
    found = dict(map_completed(square, range(20), workers))
    wanted = {k: k * k for k in range(20)} | {7: Failed("seven is not squared")}
    assert found == wanted


def test_any_executor_will_do():
    with ThreadPoolExecutor(3) as pool:
        found = dict(map_completed(square, iter(range(300)), pool))
    assert found[299] == 299**2
    assert found[7] == Failed("seven is not squared")


def test_a_process_killed_once_costs_nothing_but_time(tmp_path):
    work = partial(die_at, killer=5, once=tmp_path / "once")
    assert dict(map_completed(work, range(40), 2)) == {k: k * k for k in range(40)}


def test_what_kills_every_process_is_told_from_what_it_took_along():
    work = partial(die_at, killer=5, once=None)
    wanted = {k: k * k for k in range(40)} | {5: Failed(KILLED)}
    assert dict(map_completed(work, range(40), 2)) == wanted


STOPPED = """
import signal, time
from msbsdf_cli.run.completed import map_completed

def size(job):
    time.sleep(0.05)
    return len(job)

def stop(*_):
    raise KeyboardInterrupt

signal.signal(signal.SIGALRM, stop)
signal.setitimer(signal.ITIMER_REAL, 1)
for _ in map_completed(size, (bytes(1 << 21) for _ in range(100_000)), 2):
    pass
"""


def test_a_stopped_run_ends_though_large_jobs_wait():
    """They fill the pipe to processes that are dead: nobody may wait until it is read."""
    run = subprocess.run(
        [sys.executable, "-c", STOPPED], timeout=60, capture_output=True, text=True
    )
    assert run.returncode == -signal.SIGINT
    assert "InvalidStateError" not in run.stderr


def test_jobs_are_taken_as_they_are_needed():
    taken = []

    def jobs():
        for k in range(10_000):
            taken.append(k)
            yield k

    with ThreadPoolExecutor(2) as pool:
        results = map_completed(square, jobs(), pool)
        next(results)
        assert len(taken) < 1000
        results.close()
