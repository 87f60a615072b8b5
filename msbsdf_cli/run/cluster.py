"""Work on a Dask cluster, wherever that runs."""

from collections.abc import Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

from msbsdf_cli import __version__

WAIT_S = 30
"""How long a scheduler may take to answer, and a cluster to have a worker."""

MISSING = "Dask is not installed: pip install 'msbsdf[cluster]'."


def has_dask() -> bool:
    """Whether Dask's scheduler and workers are installed."""
    return find_spec("distributed") is not None


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """An executor on the cluster whose scheduler listens at `address`, `tcp://HOST:PORT`.

    Raises RuntimeError with a sentence where nobody answers, no worker comes, or a worker has
    another version of this program.
    """
    from distributed import Client

    try:
        client = Client(address, timeout=WAIT_S)
    except (OSError, ValueError) as error:
        raise RuntimeError(f"no scheduler answers at {address}: {error}.") from None
    try:
        _check(client, address)
        yield _Cluster(client)
    finally:
        client.close()


class _Cluster(Executor):
    """Dask's executor, which waits for ever where no worker is left."""

    def __init__(self, client: Any) -> None:
        self.client, self.executor = client, client.get_executor()

    def submit(self, work: Any, /, *arguments: Any, **keywords: Any) -> "Future[Any]":
        future: Future[Any] = self.executor.submit(work, *arguments, **keywords)
        return future

    def check(self) -> None:
        """Raise RuntimeError where no worker is left."""
        if not self.client.scheduler_info()["workers"]:
            raise RuntimeError("the cluster has no worker any more")


def _check(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WAIT_S)
    except TimeoutError:
        raise RuntimeError(f"the cluster at {address} has no worker.") from None
    for worker, version in client.run(_version).items():
        if version != __version__:
            raise RuntimeError(
                f"the worker {worker} has msbsdf {version} and not {__version__}: all machines "
                "need the same."
            )


def _version() -> str:
    return __version__
