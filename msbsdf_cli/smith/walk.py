"""The Smith random walk, in the coordinate t = -ln C1(h) that makes heights unnecessary.

t is 0 at the top of the microsurface and infinite at its bottom. A free path in direction d is
t_next = t - E d_z / sigma(d) with E exponential, for every direction, and it leaves the surface
when t_next < 0: Algorithm 1 of [HHdD16] (Eqs. 25 to 30) with C1 = exp(-t) put in.

Inside a dielectric the walk sees the surface upside down. Lanes inside are kept point-reflected
(d -> -d, C1 -> 1 - C1), so that every lane at every time is above the surface and the same three
lines serve both sides.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from surfaces.batch import Batch, concatenate
from surfaces.facet import Array
from surfaces.light import Light, append_event
from surfaces.materials import Material

BLOCK = 16384
"""Lanes handled together: a dozen arrays of this length stay in a core's second-level cache,
and the cost of a NumPy call is spread over enough lanes."""


@dataclass
class Lanes(Batch):
    """Walks under way. Arrays have one entry for each lane, or one for all of them."""

    d: Array
    t: Array
    weight: Array | None = None
    inside: Array | None = None
    sequence: Array | None = None


def random_walk(
    slopes: Slopes,
    material: Material,
    wi: Array,
    n: int,
    rng: np.random.Generator,
    max_order: int,
) -> Iterator[Light]:
    """Walk `n` times from the direction `wi` (3,), a unit vector with z > 0, in its precision.

    Yields the light that leaves, order by order; what is still under way after `max_order`
    facets comes last, unresolved. [HHdD16] Algorithm 7 without its next-event estimation.
    """
    arriving = _arrive(slopes, material, wi.reshape(3, 1))
    survivors = []
    for start in range(0, n, BLOCK):
        light, lanes = _bounce(slopes, material, arriving, min(BLOCK, n - start), 1, rng)
        yield light
        survivors.append(lanes)
    for order in range(2, max_order + 1):
        lanes = concatenate(survivors)
        if lanes.size == 0:
            return
        survivors = []
        for block in lanes.blocks(BLOCK):
            light, staying = _bounce(slopes, material, block, block.size, order, rng)
            yield light
            survivors.append(staying)
    lanes = concatenate(survivors)
    if lanes.size:
        yield leave(lanes, max_order, resolved=False)


def exponential(n: int, rng: np.random.Generator, dtype: type) -> Array:
    """Exponential numbers; half the generator's spacing keeps them above zero."""
    E: Array = rng.standard_exponential(n, dtype=dtype) + np.finfo(dtype).epsneg / 2
    return E


def free_path(t: Array, d: Array, sigma: Array, E: Array) -> tuple[Array, Array]:
    """Who leaves the surface, and the coordinate t of the next facet for those who do not.

    The question is put without a division, since sigma vanishes towards the zenith; the answer
    is kept above zero, where only rounding could take it.
    """
    step = E * d[2]
    leaves = step >= t * sigma
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return leaves, np.maximum(t - step / sigma, np.finfo(t.dtype).tiny)


def flip(t: Array) -> Array:
    """C1 -> 1 - C1 in t, with all digits at both ends."""
    flat, flipped = t.ravel(), np.empty(t.size, t.dtype)
    near = flat < math.log(2)
    top, bottom = np.flatnonzero(near), np.flatnonzero(~near)
    with np.errstate(divide="ignore"):
        flipped[top] = -np.log(-np.expm1(-flat.take(top)))
    flipped[bottom] = -np.log1p(-np.exp(-flat.take(bottom)))
    return flipped.reshape(t.shape)


def _arrive(slopes: Slopes, material: Material, wi: Array) -> Lanes:
    """One lane for all: from above the surface, t = 0, towards it."""
    lanes = Lanes(d=-wi, t=np.zeros(1, wi.dtype))
    if material.absorbs:
        lanes.weight = np.ones((material.channels, 1), wi.dtype)
    if material.transmits:
        lanes.inside = np.zeros(1, bool)
        lanes.sequence = np.ones(1, np.int64)
    return lanes


def _bounce(
    slopes: Slopes, material: Material, lanes: Lanes, n: int, order: int, rng: np.random.Generator
) -> tuple[Light, Lanes]:
    """The facet of number `order`: who leaves after it, and who stays for another."""
    dtype = lanes.d.dtype.type
    t = lanes.t
    if order == 1:
        _, t = free_path(t, lanes.d, slopes.sigma(lanes.d), exponential(n, rng, dtype))
    m = slopes.visible_normals(-lanes.d, n, rng)
    d, gain, transmitted = material.scatter(lanes.d, m, lanes.inside, rng)
    after = Lanes(d, t)
    if gain is not None and lanes.weight is not None:
        after.weight = np.broadcast_to(lanes.weight * gain, (material.channels, n))
    if transmitted is not None and lanes.inside is not None and lanes.sequence is not None:
        d *= sign(transmitted, dtype)
        after.t = np.where(transmitted, flip(t), t)
        after.inside = lanes.inside ^ transmitted
        after.sequence = append_event(lanes.sequence, transmitted)
    leaves, t_next = free_path(after.t, d, slopes.sigma(d), exponential(n, rng, dtype))
    light = leave(after.compress(leaves), order)
    after.t = t_next
    return light, after.compress(~leaves)


class Leaving(Protocol):
    """What is known of walks that leave: `Lanes`, or those of a walk that remembers."""

    d: Array
    weight: Array | None
    inside: Array | None
    sequence: Array | None


def leave(lanes: Leaving, order: int, resolved: bool = True) -> Light:
    """Light of walks after their facet of number `order`."""
    w = lanes.d
    if lanes.inside is not None:
        w = w * sign(lanes.inside, w.dtype.type)
    return Light(order, w, lanes.weight, lanes.inside, lanes.sequence, resolved)


def sign(turned: Array, dtype: type) -> Array:
    """-1 where lanes are `turned`, and 1 elsewhere; `np.where` costs ten times as much of a choice
    that nothing predicts."""
    signs: Array = dtype(1) - dtype(2) * turned
    return signs
