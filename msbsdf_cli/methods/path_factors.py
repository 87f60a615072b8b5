"""Path factors of the position-free models: heights averaged bounce by bounce, not along the path.

Wherever a path meets a facet, its height is taken to be spread as if it had come from outside
along its last direction. Then the probability to leave towards the next direction depends on
these two alone [WJFYHY22 supp.]. The uncorrelated model takes the height of leaving to be
independent of that of arriving as well.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import betaln

from msbsdf_cli.methods.base import Outgoing
from msbsdf_cli.methods.forced_collisions import roulette
from msbsdf_cli.methods.paths import Paths, coloured, next_event, scatter
from msbsdf_cli.smith.integrated_heights import extinction_of
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material


def leaving_probability(
    extinction: Array, d: Array, Lambda: Array, through: Array | bool, correlated: bool
) -> Array:
    """Probability to leave unhindered along `d` (3, n), of `Lambda`, after arriving along a
    direction of `extinction` = sigma / |d_z|, for light that reflects or goes `through` the facet.

    [WJFYHY22 supp.] Eqs. 3 and 12, written with the extinction for 1 + Lambda(-d) and both
    hemispheres; the Beta function for transmission as in [HHdD16 impl.] 3.4. 0 for a downward
    direction.
    """
    if correlated:
        upward = extinction / (extinction + Lambda)
        if np.any(through):
            upward = np.where(through, np.exp(_log_transmits(extinction, Lambda)), upward)
    else:
        upward = 1 / (1 + Lambda) + np.zeros_like(extinction)
    return np.where(d[2] > 0, upward, 0).astype(d.dtype, copy=False)


def meeting_probability(
    before: Array, d: Array, extinction: Array, through: Array | bool, correlated: bool
) -> Array:
    """Probability to meet another facet along `d` (3, n), of `extinction`, after arriving along a
    direction whose extinction was `before`.

    [WJFYHY22 supp.] Eq. 17; 1 for a downward direction.
    """
    if not correlated:
        upward = extinction / (1 + extinction)
    else:
        upward = extinction / (before + extinction)
        if np.any(through):
            upward = np.where(through, -np.expm1(_log_transmits(before, extinction)), upward)
    return np.where(d[2] > 0, upward, 1).astype(d.dtype, copy=False)


def _log_transmits(extinction: Array, Lambda: Array) -> Array:
    """ln(L B(L, 1 + Lambda)) of the extinction L, never above 0, whatever rounding does to enormous
    arguments."""
    return np.minimum(np.log(extinction) + betaln(extinction, 1 + Lambda), 0)


@dataclass(kw_only=True)
class FactoredPaths(Paths):
    """Paths that remember no height, only their last direction."""

    extinction: Array
    """sigma(d) / |d_z|, (n,)."""
    throughput: Array
    """Probability to have come so far, over the probability that roulette let it, (n,)."""


def send(
    slopes: Slopes, material: Material, paths: FactoredPaths, out: Outgoing, correlated: bool
) -> Array:
    """Next events of paths at a facet, (channels, n, directions)."""
    phase, colour = next_event(slopes, material, paths, out)
    ends, through = out.seen_by(paths.start), np.zeros(1, bool)
    if paths.inside is not None:
        through = paths.inside[:, None] != ends.inside
    leaves = leaving_probability(
        paths.extinction[:, None], ends.w, ends.Lambda, through, correlated
    )
    return coloured(phase * leaves * paths.throughput[:, None], colour, paths.weight)


def go_on(
    slopes: Slopes,
    material: Material,
    paths: FactoredPaths,
    correlated: bool,
    rng: np.random.Generator,
) -> FactoredPaths:
    """The paths that meet another facet."""
    assert paths.m is not None
    after, transmitted = scatter(slopes, material, paths, paths.m, rng)
    after.extinction = extinction_of(after.d, after.sigma)
    through = False if transmitted is None else transmitted
    throughput = paths.throughput * meeting_probability(
        paths.extinction, after.d, after.extinction, through, correlated
    )
    stays, boost = roulette(throughput, after.weight, rng)
    after.throughput = throughput * boost
    return after.compress(stays)
