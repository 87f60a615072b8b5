"""Random walks that always meet another facet, weighted by the probability that they would have."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.methods.base import Outgoing
from msbsdf_cli.methods.estimate import Estimate
from msbsdf_cli.methods.paths import coloured, follow, next_event
from msbsdf_cli.methods.walks import Walks, escape, leave_facet
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material

PATIENCE = 4
"""A path is ended by probability once it carries less than one part in `PATIENCE`. Any value is
unbiased; with 4 variance times time was smallest, or nearly, over roughness 0.3 to 1."""


@dataclass(kw_only=True)
class ForcedPaths(Walks):
    """Walks that always meet another facet."""

    throughput: Array
    """Probability to have come so far, over the probability that roulette let it, (n,)."""
    other: Array | None = None
    """What the same first facet, seen from the other end, sends towards the start, (n,)."""


def roulette(left: Array, weight: Array | None, rng: np.random.Generator) -> tuple[Array, Array]:
    """Who goes on of paths that have `left` (n,) to give, and what makes up for those who do not.

    Light lost to absorption (`weight`) counts as lost as well.
    """
    if weight is not None:
        left = left * weight.max(axis=0)
    goes_on = np.minimum(PATIENCE * left, 1)
    # From (0, 1], so that no path goes on whose probability is below the generator's spacing.
    stays = 1 - rng.random(left.size, dtype=left.dtype) <= goes_on
    return stays, 1 / np.where(stays, goes_on, 1)


def forced_free_path(
    t: Array, d: Array, sigma: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """The next facet's t, given that there is one, and the probability of that ([HHdD16] 9.1)."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        probability = np.where(d[2] > 0, -np.expm1(-t * (sigma / d[2])), 1)
        E = -np.log1p(-probability * rng.random(t.size, dtype=t.dtype))
        step = np.where(probability > 0, E * d[2] / sigma, 0)
    return np.maximum(t - step, np.finfo(t.dtype).tiny), probability.astype(t.dtype, copy=False)


def next_facet(walks: ForcedPaths, rng: np.random.Generator) -> ForcedPaths:
    """The walks that roulette leaves, at their next facet."""
    walks.t, probability = forced_free_path(walks.t, walks.d, walks.sigma, rng)
    throughput = walks.throughput * probability
    stays, boost = roulette(throughput, walks.weight, rng)
    walks.throughput = throughput * boost
    return walks.compress(stays)


def follow_forced_paths(
    slopes: Slopes,
    material: Material,
    walks: ForcedPaths,
    out: Outgoing,
    estimate: Estimate,
    rng: np.random.Generator,
    order: int,
    weigh: Callable[[Array, ForcedPaths], Array] = lambda value, walks: value,
) -> None:
    """Add what walks send to the outgoing directions, from their facet number `order` on, until
    none is left; `weigh` turns contributions (n, directions) into others."""

    def value(walks: ForcedPaths) -> Array:
        phase, colour = next_event(slopes, material, walks, out)
        leaves = escape(walks.t, walks.inside, out.seen_by(walks.start))
        here = weigh(phase * leaves, walks)
        return coloured(here * walks.throughput[:, None], colour, walks.weight)

    def go_on(walks: ForcedPaths) -> ForcedPaths:
        return next_facet(leave_facet(slopes, material, walks, rng), rng)

    follow(slopes, material, walks, out.per_path, estimate, rng, value, go_on, order)
