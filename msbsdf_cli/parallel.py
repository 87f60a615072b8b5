"""Independent jobs on all cores, their results in order, with progress.

Processes, not threads: an array operation on a block that fits the cache takes microseconds, and
threads would spend as long again handing the interpreter to each other.
"""

import multiprocessing
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

import click

Job = TypeVar("Job")
Result = TypeVar("Result")


def in_order(work: Callable[[Job], Result], jobs: Iterable[Job], threads: int) -> Iterator[Result]:
    """Yield work(job) for every job, in the order of the jobs, so that a sum over the results does
    not depend on `threads`. No more than a few results wait at any time.

    Raises RuntimeError when a worker process is killed.
    """
    if threads == 1:
        yield from map(work, jobs)
        return
    # A fork starts at once; elsewhere than on Linux system libraries do not survive it.
    method = "fork" if sys.platform == "linux" else "spawn"
    pool = ProcessPoolExecutor(threads, multiprocessing.get_context(method), _ignore_interrupt)
    try:
        waiting: deque[Future[Result]] = deque()
        for job in jobs:
            waiting.append(pool.submit(work, job))
            if len(waiting) > 3 * threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    except BrokenProcessPool:
        raise RuntimeError(
            "a worker process was killed, most likely for want of memory; "
            "fewer --threads, --cells or a smaller --extent need less."
        ) from None
    except BaseException:
        for process in list(pool._processes.values()):
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _ignore_interrupt() -> None:
    """Ctrl-C is for the parent, which then ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class Progress:
    """A line on standard error with the share done, the rate and the time left."""

    def __init__(self, label: str, total: float, unit: str, quiet: bool) -> None:
        self.started = time.monotonic()
        self.done = 0.0
        self.unit = unit
        self.bar: Any = click.progressbar(
            length=1000,
            label=label,
            file=sys.stderr,
            hidden=quiet or not sys.stderr.isatty(),
            item_show_func=lambda _: f"{self.rate:.3g} {unit}/s",
        )
        self.total = total

    @property
    def rate(self) -> float:
        """Units done a second."""
        return self.done / max(time.monotonic() - self.started, 1e-9)

    def __enter__(self) -> "Progress":
        self.bar.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self.bar.__exit__(None, None, None)

    def advance(self, amount: float) -> None:
        """Count work as done."""
        before = int(1000 * self.done / self.total)
        self.done += amount
        self.bar.update(int(1000 * self.done / self.total) - before, self.unit)
