"""Work on processes and on executors: results in order, few of them waiting, none left behind."""

import multiprocessing
import os
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from msbsdf_cli.run.executors import AHEAD, map_ordered


def later_first(job):
    time.sleep(0.02 * (3 - job % 4))
    return job


def heavy(job):
    return np.full(100_000, job)


def die(job):
    os._exit(9)


def fail(job):
    raise ArithmeticError(f"job {job}")


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_results_come_in_the_order_of_the_jobs(workers):
    assert list(map_ordered(later_first, range(12), workers)) == list(range(12))


def test_any_executor_will_do():
    with ThreadPoolExecutor(3) as executor:
        assert list(map_ordered(later_first, range(12), executor)) == list(range(12))


def test_few_jobs_are_taken_before_their_turn():
    taken = []

    def jobs():
        for job in range(1000):
            taken.append(job)
            yield job

    results = map_ordered(later_first, jobs(), 2)
    next(results)
    assert len(taken) <= AHEAD * 2 + 1
    results.close()


def test_what_goes_wrong_is_told_and_nobody_is_left():
    with pytest.raises(RuntimeError, match="a process was killed, most likely for want of memory"):
        list(map_ordered(die, range(4), 2))
    with pytest.raises(ArithmeticError, match="job 0"):
        list(map_ordered(fail, range(4), 2))
    assert multiprocessing.active_children() == []


def test_who_stops_in_the_middle_of_large_results_waits_for_nobody():
    """A process that is killed while it writes leaves half of a result to be read."""
    for _ in range(10):
        results = map_ordered(heavy, range(10_000), 2)
        for _ in range(3):
            next(results)
        started = time.monotonic()
        results.close()
        assert time.monotonic() - started < 20
        assert multiprocessing.active_children() == []
