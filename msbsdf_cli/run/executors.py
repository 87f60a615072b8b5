"""Independent jobs on all cores, or on any executor, their results in order.

Processes, not threads: an array operation on a block that fits the cache takes microseconds, and
threads would spend as long again handing the interpreter to each other.
"""

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import chain, islice
from typing import Any, TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")

AHEAD = 4
"""Jobs of each process that may be done before their turn comes; it bounds what waits."""

OTHER_WORKERS = 64
"""Workers that an executor from elsewhere is taken to have at most, as it need not say how many."""

Workers = int | Executor
"""Processes to start, or an executor: anything with `submit`."""


def map_ordered(
    work: Callable[[Job], Result], jobs: Iterable[Job], workers: Workers
) -> Iterator[Result]:
    """Yield work(job) for every job, in the order of the jobs, so that a sum over the results does
    not depend on `workers`. No more than a few results wait at any time.

    Raises RuntimeError when a process is killed, and what `work` raises. However it ends, none of
    the processes that it started is left.
    """
    if workers == 1:
        yield from map(work, jobs)
        return
    if not isinstance(workers, int):
        waiting: deque[Future[Result]] = deque()
        try:
            yield from _window(workers, work, jobs, AHEAD * OTHER_WORKERS, waiting)
        finally:
            for future in waiting:
                future.cancel()
        return
    jobs = iter(jobs)
    first = list(islice(jobs, workers))
    if len(first) < 2:
        yield from map(work, first)
        return
    # All processes of a pool start at once: no more than have something to do.
    with processes(len(first)) as pool:
        yield from _window(pool, work, chain(first, jobs), AHEAD * workers, deque())


def do_all(tasks: Iterable[Callable[[], None]], workers: Workers) -> None:
    """Do what has no result, such as draw pictures."""
    for _ in map_ordered(_call, tasks, workers):
        pass


def _call(task: Callable[[], None]) -> None:
    task()


def _window(
    executor: Executor,
    work: Callable[[Job], Result],
    jobs: Iterable[Job],
    length: int,
    waiting: "deque[Future[Result]]",
) -> Iterator[Result]:
    """Results in order; at most `length` jobs are `waiting`, under way or done too early."""
    for job in jobs:
        waiting.append(executor.submit(work, job))
        if len(waiting) == length:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


@contextmanager
def processes(count: int) -> Iterator[Executor]:
    """An executor of processes of our own, which are killed if anything interrupts the work."""
    # A fork starts at once; elsewhere than on Linux system libraries do not survive it.
    context: Any = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
    pool = ProcessPoolExecutor(count, mp_context=context, initializer=_begin)
    try:
        yield pool
    except BaseException as error:
        _kill(pool)
        if isinstance(error, BrokenProcessPool):
            raise RuntimeError(
                "a process was killed, most likely for want of memory; "
                "fewer --threads, --cells or a smaller --extent need less."
            ) from None
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _kill(pool: ProcessPoolExecutor) -> None:
    """End the processes at once, whatever they are doing, as no executor of Python 3.11 can."""
    for process in list((pool._processes or {}).values()):
        process.kill()
        process.join()
    # Who was killed in the middle of a result leaves its reader waiting for the rest, until nobody
    # is left that could write it.
    pool._result_queue._writer.close()  # type: ignore[attr-defined]


def _begin() -> None:
    """Leave signals to the parent, which then ends its processes, and never outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()


def _end_with(parent: int) -> None:
    """End this process once its parent has, however that ended."""
    while os.getppid() == parent:
        time.sleep(LOOK_S)
    os._exit(1)


LOOK_S = 0.25
"""How often a process looks whether its parent lives."""
