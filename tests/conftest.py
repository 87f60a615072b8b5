import gc
import os
import sys
from pathlib import Path

# As the command line does, before NumPy reads it: tests have a process for each core already.
for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20160711)


# The same examples each time, so that a run says something of the change and not of luck.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")


def pytest_collection_finish() -> None:
    """What imports have left, half a million objects, is not looked through again and again, and
    what tests leave more seldom."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 100)
