"""Independent jobs on processes that may die, or on any executor, each result as soon as it is
there."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import chain, islice
from typing import Generic, Protocol, runtime_checkable

from msbsdf_cli.run.executors import AHEAD, OTHER_WORKERS, Job, Result, Workers, processes

LOOK_S = 10
"""How often to look whether anybody works at all, where nothing comes back."""

KILLED = "its process was killed, most likely for want of memory"


@dataclass(frozen=True)
class Failed:
    """Why a job has no result."""

    reason: str


@runtime_checkable
class Watched(Protocol):
    """An executor that may lose all who work for it."""

    def check(self) -> None:
        """Raise RuntimeError where nobody is left."""


@dataclass(frozen=True)
class _Guarded(Generic[Job, Result]):
    """Work whose errors are results."""

    work: Callable[[Job], Result]

    def __call__(self, job: Job) -> Result | Failed:
        try:
            return self.work(job)
        except MemoryError:
            return Failed("there was not enough memory")
        except Exception as error:
            return Failed(f"{error}" or type(error).__name__)


def map_completed(
    work: Callable[[Job], Result], jobs: Iterable[Job], workers: Workers
) -> Iterator[tuple[Job, Result | Failed]]:
    """Yield every job with its result, or why it has none, in the order in which they end.

    A process that is killed costs the job that it was at: the others of that moment are done
    again, one by one, so that what kills a process twice is known. No more than a few jobs are
    under way or wait at any time. However it ends, no process that it started is left.
    """
    guarded, jobs = _Guarded(work), iter(jobs)
    if workers == 1:
        yield from ((job, guarded(job)) for job in jobs)
    elif not isinstance(workers, int):
        for job, result in _on(workers, guarded, jobs, AHEAD * OTHER_WORKERS):
            yield job, Failed(KILLED) if result is None else result
    else:
        yield from _on_processes(guarded, jobs, workers)


def _on_processes(
    work: Callable[[Job], Result | Failed], jobs: Iterator[Job], workers: int
) -> Iterator[tuple[Job, Result | Failed]]:
    while first := list(islice(jobs, workers)):
        suspects: list[Job] = []
        # What a broken pool did not take is still in it.
        jobs = chain(first, jobs)
        with processes(len(first)) as pool:
            for job, result in _on(pool, work, jobs, AHEAD * workers):
                if result is None:
                    suspects.append(job)
                else:
                    yield job, result
        for job in suspects:
            with processes(1) as pool:
                for _, result in _on(pool, work, iter((job,)), 1):
                    yield job, Failed(KILLED) if result is None else result


def _on(
    executor: Executor,
    work: Callable[[Job], Result | Failed],
    jobs: Iterator[Job],
    length: int,
) -> Iterator[tuple[Job, "Result | Failed | None"]]:
    """Jobs with their results; with None, and no further ones, once a process was killed."""
    waiting: dict[Future[Result | Failed], Job] = {}
    broken = False
    try:
        while True:
            while not broken and len(waiting) < length and (more := list(islice(jobs, 1))):
                try:
                    waiting[executor.submit(work, more[0])] = more[0]
                except BrokenProcessPool:
                    broken = True
                    yield more[0], None
            if not waiting:
                return
            done = wait(waiting, LOOK_S, return_when=FIRST_COMPLETED).done
            if not done and isinstance(executor, Watched):
                executor.check()
            for future in done:
                job = waiting.pop(future)
                result = _result(future)
                broken = broken or result is None
                yield job, result
    finally:
        # Of an executor from elsewhere; processes of our own are ended with all that they have.
        if not isinstance(executor, ProcessPoolExecutor):
            for future in waiting:
                future.cancel()


def _result(future: "Future[Result | Failed]") -> "Result | Failed | None":
    try:
        return future.result()
    except (BrokenProcessPool, CancelledError):
        return None
    except Exception as error:
        # Another executor's: its worker was lost, or had not what the work needs.
        return Failed(f"{error}" or type(error).__name__)
