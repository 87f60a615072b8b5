"""How far off a value may be for the sake of rare paths that no walk has found yet.

Some directions are reached by hardly any walk, but brightly. The scatter of the walks cannot tell
of these before the first has come, so that a standard error from it alone is far too small. What
has not happened in n walks may yet happen once in n: to the error belongs one walk more. It is an
upper bound, and far too large where nothing comes along such paths at all, as on smooth surfaces.
"""

import numpy as np

from msbsdf_cli.methods.base import Outgoing, adjoint_weight
from msbsdf_cli.methods.paths import Paths, arriving, meet, reversed_phase, scatter
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material

PATHS = 16
"""Paths followed back from each outgoing direction, of which the brightest counts: later orders
come along other ways than the first that leads back, and often brighter ones. The greatest of 16 is
within a factor of 10 of the greatest of 1e5, and `evaluate` takes the greatest of all parts' 16."""


def undersampling_bound(
    slopes: Slopes, material: Material, out: Outgoing, walks: int, rng: np.random.Generator
) -> Array:
    """What one of `walks` adds to the mean towards each outgoing direction (channels, n) from the
    second order on, if it comes along a bright path that leads there: the greatest of what its last
    facet sends, for some paths drawn from the exit, over `walks`."""
    which = np.tile(np.arange(out.n), PATHS)
    paths = Paths(**arriving(slopes, material, -out.w[:, which], out.inside[which]))
    paths.m = meet(slopes, material, paths, rng)
    after, _ = scatter(slopes, material, paths, paths.m, rng)
    sends = np.zeros(paths.n)
    # Light that would come so steeply from below that no facet is in its way does not come.
    comes = slopes.sigma(-after.d) > 0
    sends[comes] = reversed_phase(slopes, material, paths.compress(comes), after.compress(comes))
    colours = np.ones((material.channels, 1)) if after.weight is None else after.weight
    brightest = (colours * sends).reshape(-1, PATHS, out.n).max(axis=1)
    return np.where(adjoint_weight(material, out) > 0, brightest / walks, 0)
