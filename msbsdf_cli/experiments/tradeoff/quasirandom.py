"""Scrambled Sobol points where a method draws its uniform numbers."""

from typing import Any

import numpy as np
from scipy.stats import qmc

from msbsdf_cli.methods.estimate import BATCH_VALUES
from msbsdf_cli.methods.protocol import Method
from msbsdf_cli.smith.walk import BLOCK
from surfaces.facet import Array
from surfaces.streams import generator

DIMENSIONS = 12
"""Coordinates of a point: a path draws 3 to 7 numbers at its first facet, and some methods keep all
their paths for the second."""

BITS = 30
"""Of a Sobol number in scipy; the rest is filled with pseudo-random ones."""


class QuasiRandom(np.random.Generator):
    """A generator whose first draws of one number for each path are those of a Sobol sequence.

    Paths come in a fixed order, and only as long as none has ended does a draw of n numbers belong
    to them one by one. So a draw gets a new coordinate as long as it is for all paths, and is
    pseudo-random from there on. Each path follows its own law as before: no bias.
    """

    def __init__(self, seed: np.random.SeedSequence) -> None:
        super().__init__(generator(seed).bit_generator)
        (scramble,) = seed.spawn(1)
        self.sobol = qmc.Sobol(DIMENSIONS, scramble=True, bits=BITS, seed=generator(scramble))
        self.begin()

    def begin(self) -> None:
        """What is drawn first from now on says how many paths there are: these get new points."""
        self.points: Array | None = None
        self.used = 0

    def random(self, size: Any = None, dtype: Any = np.float64, out: Any = None) -> Any:
        """Uniform numbers, of the sequence where there is one for each path."""
        uniform = super().random(size, dtype, out)
        if self.points is None and isinstance(size, int | np.integer):
            # A power of two whatever is wanted: scipy warns of others, and cutting is harmless.
            whole = 1 << max(int(size) - 1, 0).bit_length()
            self.points = self.sobol.random(whole)[:size].T
        points = self.points
        if points is None or np.shape(uniform) != points.shape[1:] or self.used == DIMENSIONS:
            return uniform
        column = points[self.used]
        self.used += 1
        return np.minimum(column + uniform * 2.0**-BITS, 1 - np.finfo(dtype).epsneg).astype(dtype)

    def standard_exponential(
        self, size: Any = None, dtype: Any = np.float64, method: Any = None, out: Any = None
    ) -> Any:
        """By inversion: one number of the sequence for each."""
        return -np.log(1 - self.random(size, dtype, out))


def evaluate_quasirandom(
    method: Method, wi: Array, wo: Array, samples: int, rng: QuasiRandom
) -> Array:
    """`method.evaluate` with the points of `rng`, (channels, orders + 1, n).

    One part after another, each followed together from its first facet to its last.
    """
    part = min(BLOCK, max(1, BATCH_VALUES // wo.shape[1]))
    total: Array | float = 0.0
    for start in range(0, samples, part):
        n = min(part, samples - start)
        rng.begin()
        total = total + n / samples * method.evaluate(wi, wo, n, rng).value
    return np.asarray(total)
