"""What walks that remember the last facet send towards given directions: next-event estimation.

The probability of leaving unhindered depends on the facet, and so on the direction where facets are
specular: it is that of the facet which sends light there.
"""

import numpy as np

from msbsdf_cli.memory.entry import bends, heights
from msbsdf_cli.memory.escape import LEAST, largest
from msbsdf_cli.memory.facets import Conditional, Facets
from msbsdf_cli.memory.frame import (
    Directions,
    clearance,
    curvature,
    directions,
    slopes_along,
    turned,
)
from msbsdf_cli.memory.march import march
from msbsdf_cli.memory.next_facet import Memory
from msbsdf_cli.memory.walk import Lanes
from msbsdf_cli.memory.way_in import beside
from msbsdf_cli.methods.base import Outgoing
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot
from surfaces.materials import Material

NODES = 32, 3
"""Of heights and of curvatures, over which the first order of specular facets is integrated."""

SHARE = 0.125
"""Of rays from first facets that march, which takes some times as long as looking up."""

TOGETHER = 128
"""Outgoing directions integrated at once: half a megabyte for each number."""


def first_order(
    memory: Memory, slopes: Slopes, material: Material, wi: Array, out: Outgoing
) -> Array:
    """BSDF x cos(theta_o) of the first bounce off specular facets, (channels, n), for `wi` (3,):
    q / cos(theta_i) times the probability, over heights and curvatures of the facet, that the ways
    to both directions are free, over the normalisation of the entry."""
    value = np.zeros((material.channels, out.n), wi.dtype)
    d = -wi[:, None]
    ray = directions(slopes, wi[:, None])
    scale = wi[2] * memory.entry.normalisation(float(ray.c[0]))
    for there in (False, True) if material.transmits else (False,):
        ends = np.flatnonzero((out.inside == there) & (out.w[2] > 0))
        for start in range(0, ends.size, TOGETHER):
            some = ends[start : start + TOGETHER]
            q, colour = _kernel(slopes, material, d, out.w[:, some], False, there)
            bright = np.flatnonzero(q > 0)
            some, q = some[bright], q[bright]
            share = 1.0 if colour is None else colour.reshape(len(colour), -1)[:, bright]
            w = out.w[:, some]
            free = _both_free(
                memory, slopes, ray, wi, w, half_vector(material, d, w, False, there), there
            )
            value[:, some] = share * q * free / scale
    return value


def _kernel(
    normals: Slopes | Conditional,
    material: Material,
    d: Array,
    w: Array,
    here: bool,
    there: bool,
) -> tuple[Array, Array | None]:
    if here == there:
        return material.reflection(normals, d, w, here)
    return material.refraction(normals, d, w, here), None


def half_vector(material: Material, d: Array, w: Array, here: bool, there: bool) -> Array:
    """Normals, of any length, of the specular facets that send `d` to `w`, in the frames of the
    sides they are on, as `materials` has them."""
    if here == there:
        return w - d
    eta = material.relative_ior(here)
    return (eta * w + d) * (1 if eta > 1 else -1)


def _both_free(
    memory: Memory, slopes: Slopes, ray: Directions, wi: Array, w: Array, m: Array, there: bool
) -> Array:
    """The probability (n,) that facets `m` are seen from `wi` and from `w` (3, n), `there`
    below."""
    ends = directions(slopes, w)
    h, weight = heights(NODES[0], float(ray.c[0]))
    u, share = bends(NODES[1])
    back, on = clearance(ray, wi[:, None], m), clearance(ends, w, m)
    # Axes: heights, curvatures along the way in, those along the way out, directions.
    h, u_i, u_o = h[:, None, None, None], u[:, None, None], u[:, None]
    seen = memory.escape.probability(h, ray.c, back, u_i)
    cos2 = (ray.x * ends.x + ray.y * ends.y) ** 2
    fourth = memory.correlation.fourth
    shared = cos2 + (1 - cos2) * (fourth / 3 - 1) / (fourth - 1)
    u_o = shared * u_i + np.sqrt(np.maximum(1 - shared * shared, 0)) * u_o
    turn = -1 if there else 1
    free = memory.escape.probability(turn * h, ends.c, on, turn * u_o)
    if not there:
        before = beside(ends, ray, back, u_i)
        free = free + more_often(memory, (on, h, ends.c - on, u_o), before, before[0] > 0)
    return np.einsum("hijn,h,i,j->n", seen * free, weight, share, share)


def more_often(memory: Memory, facet: tuple[Array, ...], before: Array, which: Array) -> Array:
    """How much likelier `which` rays (...) of bool are to leave first facets of the four numbers
    `facet` than others, as light came in by the ways of which `before` (5, ...) is known."""
    *numbers, which = np.broadcast_arrays(*facet, *before, which)
    more = np.zeros(which.shape, np.float32)
    some = np.flatnonzero(which)
    rays = np.stack([a.ravel().take(some) for a in numbers]).astype(np.float32)
    delta, h, s, u = left = rays[:4]
    table = memory.escape.probability(h, s + delta, delta, u)
    most = largest(np.maximum(s + delta, LEAST))
    _, away = march(memory.correlation, left, most, known=(memory.way_in, rays[4:]))
    free = np.zeros_like(table)
    free[away.slot] = np.exp(away.left - most[away.slot])
    # The way in makes no ray likelier to be met: less than the table's is the table's error.
    more.ravel()[some] = np.maximum(free - table, 0)
    return more


def drawn(
    memory: Memory,
    slopes: Slopes,
    material: Material,
    lanes: Lanes,
    out: Outgoing,
    rng: np.random.Generator | None,
) -> tuple[Array, Array | None]:
    """Per steradian, what walks send from the diffuse facets that they have met, (n, directions),
    and the share of each channel. Of first facets, which have an `rng`, a `SHARE` is asked what it
    says that light came in."""
    ends = directions(slopes, out.w)
    m = lanes.m / np.sqrt(dot(lanes.m, lanes.m))
    phase = np.where(out.inside, 0, material.lobe(m.T @ out.w))
    run = ends.run * lanes.m[2][:, None]
    above = np.maximum((lanes.m.T @ out.w).astype(np.float32) / run, np.finfo(np.float32).eps)
    u = curvature(ends, lanes.bends[:, :, None])
    free = memory.escape.probability(lanes.h[:, None], ends.c, above, u)
    if rng is not None:
        back = directions(slopes, -lanes.d)
        steeper = clearance(back, -lanes.d, lanes.m)
        bend = curvature(back, lanes.bends)
        before = beside(ends, back.column(), steeper[:, None], bend[:, None])
        which = (before[0] > 0) & (phase > 0) & (rng.random(free.shape, np.float32) < SHARE)
        facet = above, lanes.h[:, None], ends.c - above, u
        free = free + more_often(memory, facet, before, which) / SHARE
    return phase * free, material.kept(phase.dtype)[:, None]


def met(
    memory: Memory,
    slopes: Slopes,
    material: Material,
    lanes: Lanes,
    on_way: tuple[Directions, Facets],
    out: Outgoing,
) -> tuple[Array, Array | None]:
    """The same from the specular facets that they might have met."""
    phase, colour = np.zeros((lanes.slot.size, out.n), lanes.d.dtype), None
    below = np.zeros(lanes.slot.size, bool) if lanes.inside is None else lanes.inside
    for here in (False, True):
        for there in (False, True) if material.transmits else (False,):
            mine, ends = np.flatnonzero(below == here), np.flatnonzero(out.inside == there)
            if mine.size and ends.size:
                ray, facets = on_way[0].take(mine), on_way[1].take(mine)
                some = lanes.take(mine)
                where = np.ix_(mine, ends)
                phase[where], some_colour = _met_on_sides(
                    memory, slopes, material, some, ray, facets, out.w[:, ends], here, there
                )
                if some_colour is not None:
                    colour = np.zeros((len(some_colour), *phase.shape), phase.dtype)
                    colour[:, where[0], where[1]] = some_colour
    return phase, colour


def _met_on_sides(
    memory: Memory,
    slopes: Slopes,
    material: Material,
    lanes: Lanes,
    ray: Directions,
    facets: Facets,
    w: Array,
    here: bool,
    there: bool,
) -> tuple[Array, Array | None]:
    """Of walks that are all on one side, towards directions that are."""
    ray, facets, ends = ray.column(), facets.column(), directions(slopes, w)
    normals = Conditional(slopes, ray, facets)
    d, w = lanes.d[:, :, None], w[:, None, :]
    density, colour = _kernel(normals, material, d, w, here, there)
    with np.errstate(divide="ignore", invalid="ignore"):
        m = half_vector(material, d, w, here, there)
        along, _ = slopes_along(slopes, ray, m)
        steeper = (along - ray.c).astype(np.float32)
        u = curvature(ends, turned(ray, facets.bends(memory.correlation, steeper)))
        turn = np.float32(1 if here == there else -1)
        above = clearance(ends, w, m)
    lit = density > 0
    numbers = (np.where(lit, a, 0) for a in (above, u * turn))
    free = memory.escape.probability(lanes.h[:, None] * turn, ends.c, *numbers)
    return np.where(lit, density / normals.sigma * free, 0), colour
