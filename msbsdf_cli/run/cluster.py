"""Work on a Dask cluster, wherever that runs."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from msbsdf_cli import __version__

WAIT_S = 30
"""How long a scheduler may take to answer, and a cluster to have a worker."""

MISSING = "a cluster needs Dask, which is not installed: pip install 'msbsdf[cluster]'."


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """An executor on the cluster whose scheduler listens at `address`, `tcp://HOST:PORT`.

    Raises RuntimeError with a sentence where Dask is missing, nobody answers, no worker comes, or
    a worker has another version of this program.
    """
    try:
        from distributed import Client
    except ImportError:
        raise RuntimeError(MISSING) from None
    try:
        client = Client(address, timeout=WAIT_S)
    except (OSError, ValueError) as error:
        raise RuntimeError(f"no scheduler answers at {address}: {error}.") from None
    try:
        _check(client, address)
        yield client.get_executor()
    finally:
        client.close()


def _check(client: "object", address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WAIT_S)  # type: ignore[attr-defined]
    except TimeoutError:
        raise RuntimeError(f"the cluster at {address} has no worker.") from None
    for worker, version in client.run(_version).items():  # type: ignore[attr-defined]
        if version != __version__:
            raise RuntimeError(
                f"the worker {worker} has msbsdf {version} and not {__version__}: all machines "
                "need the same."
            )


def _version() -> str:
    return __version__
