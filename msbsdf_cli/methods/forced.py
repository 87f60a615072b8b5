"""Random walks that always meet another facet, weighted by the chance that they would have."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.methods.directions import Exits
from msbsdf_cli.methods.estimate import Estimate
from msbsdf_cli.methods.paths import Paths, coloured, follow, next_event, scatter
from msbsdf_cli.methods.walk import escape
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import flip
from surfaces.facet import Array
from surfaces.materials import Material

PATIENCE = 4
"""A path is ended by chance once it carries less than one part in `PATIENCE`. Any value is
unbiased; with 4 variance times time was smallest, or nearly, over roughness 0.3 to 1."""


@dataclass(kw_only=True)
class Forced(Paths):
    """Paths with their coordinate t = -ln C1(h), at the facet they met."""

    t: Array
    share: Array
    """Chance to have come so far, over the chance that roulette let it, (n,)."""
    other: Array | None = None
    """What the same first facet, seen from the other end, sends towards the start, (n,)."""


def roulette(left: Array, weight: Array | None, rng: np.random.Generator) -> tuple[Array, Array]:
    """Who goes on of paths that have `left` (n,) to give, and what makes up for those who do not.

    Light lost to absorption (`weight`) counts as lost as well.
    """
    if weight is not None:
        left = left * weight.max(axis=0)
    goes_on = np.minimum(PATIENCE * left, 1)
    stays = rng.random(left.size, dtype=left.dtype) < goes_on
    return stays, 1 / np.where(stays, goes_on, 1)


def forced_free_path(
    t: Array, d: Array, sigma: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """The next facet's t, given that there is one, and the chance of that ([HHdD16] 9.1)."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        chance = np.where(d[2] > 0, -np.expm1(-t * (sigma / d[2])), 1)
        E = -np.log1p(-chance * rng.random(t.size, dtype=t.dtype))
        step = np.where(chance > 0, E * d[2] / sigma, 0)
    return np.maximum(t - step, np.finfo(t.dtype).tiny), chance.astype(t.dtype, copy=False)


def leave_facet(
    slopes: Slopes, material: Material, walks: Forced, rng: np.random.Generator
) -> Forced:
    """The walks in their directions after the facet."""
    assert walks.m is not None
    after, transmitted = scatter(slopes, material, walks, walks.m, rng)
    if transmitted is not None:
        after.t = np.where(transmitted, flip(after.t), after.t)
    return after


def next_facet(walks: Forced, rng: np.random.Generator) -> Forced:
    """The walks that roulette leaves, at their next facet."""
    walks.t, chance = forced_free_path(walks.t, walks.d, walks.sigma, rng)
    share = walks.share * chance
    stays, boost = roulette(share, walks.weight, rng)
    walks.share = share * boost
    return walks.compress(stays)


def follow_forced(
    slopes: Slopes,
    material: Material,
    walks: Forced,
    out: Exits,
    estimate: Estimate,
    rng: np.random.Generator,
    order: int,
    weigh: Callable[[Array, Forced], Array] = lambda value, walks: value,
) -> None:
    """Add what walks send to the exits, from their facet number `order` on, until none is left;
    `weigh` turns contributions (n, exits) into others."""

    def value(walks: Forced) -> Array:
        phase, colour = next_event(slopes, material, walks, out)
        here = weigh(phase * escape(walks.t, walks.inside, out), walks)
        return coloured(here * walks.share[:, None], colour, walks.weight)

    def go_on(walks: Forced) -> Forced:
        return next_facet(leave_facet(slopes, material, walks, rng), rng)

    follow(slopes, material, walks, out.n, estimate, rng, value, go_on, order)
