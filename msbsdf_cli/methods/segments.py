"""Segments of the position-free models: heights averaged bounce by bounce, not along the path.

Wherever a path meets a facet, its height is taken to be spread as if it had come from outside
along its last direction. Then the chance to leave towards the next direction depends on
these two alone [WJFYHY22 supp.]. The uncorrelated model takes the height of leaving to be
independent of that of arriving as well.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import betaln

from msbsdf_cli.methods.directions import Exits
from msbsdf_cli.methods.forced import roulette
from msbsdf_cli.methods.paths import Paths, coloured, next_event, scatter
from msbsdf_cli.smith.descent import slant
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material


def leaving_chance(
    L: Array, d: Array, Lambda: Array, through: Array | bool, correlated: bool
) -> Array:
    """Chance to leave unhindered along `d` (3, n), of `Lambda`, after arriving along a direction of
    `L` = sigma / |d_z|, for light that reflects or goes `through` the facet.

    [WJFYHY22 supp.] Eqs. 3 and 12, written with L for 1 + Lambda(-d) and both hemispheres; the
    Beta function for transmission as in [HHdD16 impl.] 3.4. 0 for a downward direction.
    """
    if correlated:
        upward = L / (L + Lambda)
        if np.any(through):
            upward = np.where(through, np.exp(_log_transmits(L, Lambda)), upward)
    else:
        upward = 1 / (1 + Lambda) + np.zeros_like(L)
    return np.where(d[2] > 0, upward, 0).astype(d.dtype, copy=False)


def meeting_chance(
    L: Array, d: Array, L_next: Array, through: Array | bool, correlated: bool
) -> Array:
    """Chance to meet another facet along `d` (3, n), of `L_next`, after arriving along `L`.

    [WJFYHY22 supp.] Eq. 17; 1 for a downward direction.
    """
    if not correlated:
        upward = L_next / (1 + L_next)
    else:
        upward = L_next / (L + L_next)
        if np.any(through):
            upward = np.where(through, -np.expm1(_log_transmits(L, L_next)), upward)
    return np.where(d[2] > 0, upward, 1).astype(d.dtype, copy=False)


def _log_transmits(L: Array, Lambda: Array) -> Array:
    """ln(L B(L, 1 + Lambda)), never above 0, whatever rounding does to enormous arguments."""
    return np.minimum(np.log(L) + betaln(L, 1 + Lambda), 0)


@dataclass(kw_only=True)
class Segments(Paths):
    """Paths that remember no height, only their last direction."""

    L: Array
    """sigma(d) / |d_z|, (n,)."""
    share: Array
    """Chance to have come so far, over the chance that roulette let it, (n,)."""


def send(
    slopes: Slopes, material: Material, paths: Segments, out: Exits, correlated: bool
) -> Array:
    """Next events of paths at a facet, (channels, n, exits)."""
    phase, colour = next_event(slopes, material, paths, out)
    through: Array | bool = False
    if paths.inside is not None:
        through = paths.inside[:, None] != out.inside
    leaves = leaving_chance(paths.L[:, None], out.w[:, None], out.Lambda[None], through, correlated)
    return coloured(phase * leaves * paths.share[:, None], colour, paths.weight)


def go_on(
    slopes: Slopes,
    material: Material,
    paths: Segments,
    correlated: bool,
    rng: np.random.Generator,
) -> Segments:
    """The paths that meet another facet."""
    assert paths.m is not None
    after, transmitted = scatter(slopes, material, paths, paths.m, rng)
    after.L = slant(after.d, after.sigma)
    through = False if transmitted is None else transmitted
    share = paths.share * meeting_chance(paths.L, after.d, after.L, through, correlated)
    stays, boost = roulette(share, after.weight, rng)
    after.share = share * boost
    return after.compress(stays)
