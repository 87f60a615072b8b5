"""Independent jobs on all cores, their results in order, with progress.

Processes, not threads: an array operation on a block that fits the cache takes microseconds, and
threads would spend as long again handing the interpreter to each other.
"""

import multiprocessing
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar, cast

import click

Job = TypeVar("Job")
Result = TypeVar("Result")

AHEAD = 4
"""Jobs of each process that may be done before their turn comes; it bounds what waits."""


def in_order(work: Callable[[Job], Result], jobs: Iterable[Job], threads: int) -> Iterator[Result]:
    """Yield work(job) for every job, in the order of the jobs, so that a sum over the results does
    not depend on `threads`. No more than a few results wait at any time.

    Raises RuntimeError when a process is killed, and what `work` raises. However it ends, no
    process is left: they are plain processes on pipes, since an executor's threads can hang in
    the middle of an interrupt.
    """
    if threads == 1:
        yield from map(work, jobs)
        return
    # A fork starts at once; elsewhere than on Linux system libraries do not survive it.
    context: Any = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
    crew: dict[Connection, Any] = {}
    try:
        for _ in range(threads):
            ours, theirs = context.Pipe()
            # A copy of a parent's end would keep a process waiting for a parent that is gone.
            crew[ours] = None
            args = work, theirs, tuple(crew)
            crew[ours] = context.Process(target=_serve, args=args, daemon=True)
            crew[ours].start()
            theirs.close()
        yield from _results(crew, iter(enumerate(jobs)))
    finally:
        for pipe, process in crew.items():
            pipe.close()
            if process is not None and process.pid is not None:
                process.kill()
                process.join()


def _results(crew: dict[Connection, Any], jobs: Iterator[tuple[int, Any]]) -> Iterator[Any]:
    """Hand out jobs to whoever is free, and yield the results in order."""
    turn, given = 0, 0
    done: dict[int, Any] = {}
    idle, busy = list(crew), set[Connection]()
    exhausted = False
    while True:
        while idle and not exhausted and given < turn + AHEAD * len(crew):
            try:
                job = next(jobs)
            except StopIteration:
                exhausted = True
                break
            pipe = idle.pop()
            pipe.send(job)
            busy.add(pipe)
            given += 1
        while turn in done:
            yield done.pop(turn)
            turn += 1
        if not busy:
            if exhausted:
                return
            continue
        for ready in wait(busy):
            pipe = cast(Connection, ready)
            try:
                number, result = pipe.recv()
            except EOFError:
                raise RuntimeError(
                    "a process was killed, most likely for want of memory; "
                    "fewer --threads, --cells or a smaller --extent need less."
                ) from None
            if isinstance(result, BaseException):
                raise result
            done[number] = result
            busy.discard(pipe)
            idle.append(pipe)


def _serve(work: Callable[[Any], Any], pipe: Connection, others: tuple[Connection, ...]) -> None:
    """Do jobs until killed. Ctrl-C is for the parent, which then ends its processes."""
    for other in others:
        other.close()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while True:
        try:
            number, job = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send((number, work(job)))
        except Exception as error:
            pipe.send((number, error))


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
