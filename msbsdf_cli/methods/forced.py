"""Random walks that always meet another facet, weighted by the chance that they would have."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.methods.directions import Exits
from msbsdf_cli.methods.estimate import BLOCK, Estimate
from msbsdf_cli.methods.paths import Paths, concatenate, lanes_for, meet, next_event, scatter
from msbsdf_cli.methods.walk import escape
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import flip
from surfaces.facet import Array
from surfaces.materials import Material

PATIENCE = 4
"""A path is ended by chance once it carries less than one part in `PATIENCE`. Any value is
unbiased; with 4 the product of variance and time was smallest, or nearly, over roughness 0.3 to 1."""


@dataclass(kw_only=True)
class Forced(Paths):
    """Paths with their coordinate t = -ln C1(h), at the facet they met."""

    t: Array
    share: Array
    """Chance to have come so far, over the chance that roulette let it, (n,)."""
    other: Array | None = None
    """What the same first facet, seen from the other end, sends towards the start, (n,)."""
    start: Array | None = None
    """Number of the direction that the path starts from, (n,)."""


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
) -> tuple[Forced, Array | None]:
    """The walks in their directions after the facet, and who of them changed sides."""
    assert walks.m is not None
    after, transmitted = scatter(slopes, material, walks, walks.m, rng)
    if transmitted is not None:
        after.t = np.where(transmitted, flip(after.t), after.t)
    return after, transmitted


def next_facet(walks: Forced, rng: np.random.Generator) -> Forced:
    """The walks that roulette leaves, at their next facet."""
    walks.t, chance = forced_free_path(walks.t, walks.d, walks.sigma, rng)
    share = walks.share * chance
    stays, boost = roulette(share, walks.weight, rng)
    walks.share = share * boost
    return walks.compress(stays)


def follow(
    slopes: Slopes,
    material: Material,
    walks: Forced,
    out: Exits,
    estimate: Estimate,
    rng: np.random.Generator,
    value: Callable[[Forced], Array],
    order: int,
) -> None:
    """Add `value` (channels, n, exits) of walks at their facet number `order`, and at all later
    ones, until no walk is left."""
    while walks.n:
        if order > estimate.orders and estimate.tail is None:
            walks.slot = np.arange(walks.n)
            estimate.open_tail(walks.n, out.n, walks.start)
        staying = []
        for block in walks.blocks(BLOCK):
            block.m = meet(slopes, material, block, rng)
            for piece in block.blocks(lanes_for(out)):
                estimate.add(order, value(piece), piece.slot, piece.start)
            after, _ = leave_facet(slopes, material, block, rng)
            staying.append(next_facet(after, rng))
        walks = concatenate(staying)
        order += 1


def towards(
    slopes: Slopes, material: Material, walks: Forced, out: Exits
) -> tuple[Array, Array | None]:
    """Next events of walks at a facet, (n, exits), and their colour."""
    phase, colour = next_event(slopes, material, walks, out)
    return phase * escape(walks.t, walks.inside, out), colour
