"""How far off a value may be for the sake of rare paths that no walk has found yet.

Some directions are reached by hardly any walk, but brightly. The scatter of the walks cannot tell
of these before the first has come, so that a standard error from it alone is far too small. What
has not happened in n walks may yet happen once in n: to the error belongs one walk more.
"""

import numpy as np

from msbsdf_cli.methods.directions import Exits, far_end
from msbsdf_cli.methods.paths import Paths, arriving, meet, reversed_phase, scatter
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material

PATHS = 16
"""Paths followed back from each exit, of which the brightest counts: later orders come along
other ways than the first that leads back, and often brighter ones."""


def unseen(
    slopes: Slopes, material: Material, out: Exits, walks: int, rng: np.random.Generator
) -> Array:
    """What one of `walks` adds to the mean towards each exit (n,) from the second order on, if it
    comes along a bright path that leads there: the greatest phase function of some paths drawn
    from the exit, over `walks`.

    Upward directions count no more than their chance to meet a facet (about Lambda): where that
    is below one in `walks`, the phase function may be enormous, but nothing comes that way.
    """
    which = np.tile(np.arange(out.n), PATHS)
    paths = Paths(**arriving(slopes, material, -out.w[:, which], out.inside[which]))
    paths.m = meet(slopes, material, paths, rng)
    after, _ = scatter(slopes, material, paths, paths.m, rng)
    came = -after.d.astype(float)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        phase = reversed_phase(slopes, material, paths, after)
        chance = np.where(came[2] > 0, slopes.sigma(came) / came[2], 1)
        share = np.where(chance > 0, phase * np.minimum(1 / walks, chance), 0)
    return np.where(far_end(material, out) > 0, share.reshape(PATHS, out.n).max(axis=0), 0)
