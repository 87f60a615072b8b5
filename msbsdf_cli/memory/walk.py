"""The random walk that remembers the last facet.

As in `msbsdf_cli.smith.walk` lanes inside a dielectric are kept point-reflected, so that every lane
at every time is above the surface: heights and curvatures change their sign there, slopes do not.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.memory.facets import Facets, remembered, spread_out
from msbsdf_cli.memory.frame import (
    Directions,
    clearance,
    curvature,
    directions,
    normals,
    slopes_along,
    turned,
)
from msbsdf_cli.memory.next_facet import Memory, next_facets
from msbsdf_cli.memory.way_in import beside
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import leave, sign
from surfaces.batch import Batch, concatenate
from surfaces.facet import Array
from surfaces.light import Light, append_event
from surfaces.materials import Material

BLOCK = 1 << 16
"""Walks handled together: of these a fourth or less march on, and the cost of a NumPy call is
spread over enough of them in all but the last steps."""


@dataclass
class Lanes(Batch):
    """Walks at a facet. Arrays (..., n), in single precision but for directions and weights."""

    d: Array
    """Direction of travel towards the facet, (3, n)."""
    h: Array
    """Height of the facet."""
    m: Array
    """Its normal, (3, n), of any length."""
    bends: Array
    """Its curvatures, (3, n), see `frame.turned`."""
    slot: Array
    """Number of the walk."""
    weight: Array | None = None
    inside: Array | None = None
    sequence: Array | None = None


Look = Callable[[int, Lanes, tuple[Directions, Facets] | None], None]
"""What is told of walks at a facet: its number, the walks, and, beyond the first, how they climb
and what facets might as well have been met."""


def random_walk(
    memory: Memory,
    slopes: Slopes,
    material: Material,
    wi: Array,
    n: int,
    rng: np.random.Generator,
    max_order: int,
    look: Look | None = None,
) -> Iterator[Light]:
    """Walk `n` times from the direction `wi` (3,), a unit vector with z > 0, as
    `msbsdf_cli.smith.walk.random_walk` does."""
    survivors = []
    for start in range(0, n, BLOCK):
        slot = np.arange(start, min(start + BLOCK, n))
        lanes = arrive(memory, slopes, material, wi, slot, rng)
        if look is not None:
            look(1, lanes, None)
        light, staying = bounce(memory, slopes, material, lanes, 1, rng, look)
        yield light
        survivors.append(staying)
    for order in range(2, max_order + 1):
        lanes = concatenate(survivors)
        if lanes.size == 0:
            return
        survivors = []
        for block in lanes.blocks(BLOCK):
            light, staying = bounce(memory, slopes, material, block, order, rng, look)
            yield light
            survivors.append(staying)
    lanes = concatenate(survivors)
    if lanes.size:
        yield leave(lanes, max_order, resolved=False)


def arrive(
    memory: Memory,
    slopes: Slopes,
    material: Material,
    wi: Array,
    slot: Array,
    rng: np.random.Generator,
) -> Lanes:
    """Walks from `wi` (3,) at their first facets."""
    n = slot.size
    d = np.tile(-wi[:, None], n)
    ray = directions(slopes, d)
    h, along, across, u = memory.entry.draw(ray, n, rng)
    noise = rng.standard_normal((2, n), dtype=np.float32)
    curvatures = turned(ray, spread_out(memory.correlation, u, noise))
    lanes = Lanes(d, h, normals(slopes, ray, along, across), curvatures, slot)
    if material.absorbs:
        lanes.weight = np.ones((material.channels, n), wi.dtype)
    if material.transmits:
        lanes.inside = np.zeros(n, bool)
        lanes.sequence = np.ones(n, np.int64)
    return lanes


def bounce(
    memory: Memory,
    slopes: Slopes,
    material: Material,
    lanes: Lanes,
    order: int,
    rng: np.random.Generator,
    look: Look | None = None,
) -> tuple[Light, Lanes]:
    """The facet of number `order`: who leaves after it, and who stays, at the next one."""
    after = scatter(material, lanes, rng)
    ray = directions(slopes, after.d)
    delta, u = clearance(ray, after.d, after.m), curvature(ray, after.bends)
    along, across = slopes_along(slopes, ray, after.m)
    facet = np.stack([delta, after.h, along, u])
    before = None if order > 1 else came_from_outside(slopes, lanes, after, ray)
    hits, away = next_facets(memory, facet, rng, before)
    light, stays = leave(after.compress(away), order), hits.slot
    staying, ray = after.take(stays), ray.take(stays)
    facets = remembered(
        memory.correlation, hits.place, ray, facet.take(stays, axis=1), across.take(stays), rng
    )
    along, across = facets.draw(rng)
    if hits.facet is None:
        bends = facets.bends(memory.correlation, along - ray.c)
    else:
        along, u = hits.facet
        bends = spread_out(memory.correlation, u, facets.noise[1:])
    staying.h, staying.m = hits.h, normals(slopes, ray, along, across)
    staying.bends = turned(ray, bends)
    if look is not None:
        look(order + 1, staying, (ray, facets))
    return light, staying


def came_from_outside(slopes: Slopes, lanes: Lanes, after: Lanes, ray: Directions) -> Array:
    """What is known of the ways in of walks at first facets, (5, n) as `way_in.beside` has it."""
    back = directions(slopes, -lanes.d)
    steeper = clearance(back, -lanes.d, lanes.m)
    before = beside(ray, back, steeper, curvature(back, lanes.bends))
    if after.inside is not None and lanes.inside is not None:
        # The way in is on the other side of the surface.
        before[0] = np.where(after.inside == lanes.inside, before[0], 0)
    return before


def scatter(material: Material, lanes: Lanes, rng: np.random.Generator) -> Lanes:
    """Walks after their facets."""
    m = lanes.m.astype(lanes.d.dtype, copy=False)
    d, gain, transmitted = material.scatter(lanes.d, m, lanes.inside, rng)
    after = replace(lanes, d=d)
    if gain is not None and lanes.weight is not None:
        after.weight = lanes.weight * gain
    if transmitted is not None and lanes.inside is not None and lanes.sequence is not None:
        after.d = d * sign(transmitted, d.dtype.type)
        turn = sign(transmitted, np.float32)
        after.h, after.bends = lanes.h * turn, lanes.bends * turn
        after.inside = lanes.inside ^ transmitted
        after.sequence = append_event(lanes.sequence, transmitted)
    return after
