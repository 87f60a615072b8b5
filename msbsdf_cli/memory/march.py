"""Rays on their way from a facet: the integral of the hazard along them, and where it reaches E.

Steps grow with the distance as long as the surface is still nearly the parabola that it is at the
facet, and are then a fraction of a correlation length and of the way in which the ray climbs a
standard deviation, alone where nothing is remembered any more.
"""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.memory import hazard, normal
from msbsdf_cli.memory.correlation import STEP, Correlation
from msbsdf_cli.memory.way_in import WayIn
from surfaces.batch import Batch, concatenate
from surfaces.facet import Array

GROWTH = 0.4
LENGTH = 0.3
FAR = 0.06
CLIMB = 0.4
"""A step is at most `GROWTH` of the distance, `LENGTH` (where slopes have variance 1) or, farther
out, `FAR` of the distance, and it climbs at most `CLIMB` standard deviations of height."""

CURVED = 2.5
"""Deviations of curvature by which the surface may yet bend up more than the facet does."""

TOP = 7.5
"""Height above which rays that climb meet nothing, but 3e-14 of the time."""

LEVEL = 1e-9
"""Slope in standard deviations of a ray that is as good as level."""

NOWHERE = -1
"""Place of hits where nothing is remembered."""


@dataclass
class Rays(Batch):
    """Rays that leave a facet, arrays (n,)."""

    facet: Array
    """The four numbers of the facet, (4, n)."""
    left: Array
    """Integral of the hazard that is left to go."""
    slot: Array
    """Number of the ray."""
    x: Array
    """Distance that is behind."""
    below: Array
    """ln P(h < l) there."""
    down: Array
    """Downward crossings there."""
    factor: Array
    """Of looking back, and of the way in."""
    before: Array | None = None
    """What is known of the way in, (5, n) as `way_in.beside` has it, of rays from first facets."""

    @property
    def c(self) -> Array:
        """Slope of the ray."""
        return self.facet[0] + self.facet[2]


@dataclass
class Hits(Batch):
    """Where rays met the surface, arrays (n,)."""

    slot: Array
    h: Array
    """Height."""
    place: Array
    """Of the distance in the lattice, or `NOWHERE`."""
    facet: Array | None = None
    """Slope and curvature along the ray, (2, n), where they are known already."""


def march(
    correlation: Correlation,
    facet: Array,
    E: Array,
    fineness: float = 1.0,
    known: tuple[WayIn, Array] | None = None,
) -> tuple[Hits, Rays]:
    """Those of the rays that meet the surface before the hazard has come to `E` (n,), and the
    others with what is then left of it. `facet` (4, n) are delta, height, slope and curvature;
    `known` is what is known of the ways in of rays from first facets, (5, n)."""
    rays, hits, away = _start(correlation, facet, E), [], []
    way_in, rays.before = known or (None, None)
    while rays.size:
        rays, met, over = _step(correlation, rays, fineness, way_in)
        hits.append(met)
        away.append(over)
    rays, out = concatenate([rays, *away]), away[:0]
    while rays.size or not out:
        rays, met, over = _far_step(correlation, rays, fineness, way_in)
        hits.append(met)
        out.append(over)
    return concatenate(hits), concatenate(out)


def _start(correlation: Correlation, facet: Array, E: Array) -> Rays:
    """Rays at a distance before which the parabola of the facet is not met."""
    delta, h, _, u = facet
    bend = np.maximum(correlation.bend * u - h, 0) + CURVED * correlation.bend
    x = np.minimum(delta / bend, correlation.x[-1] / 8).astype(E.dtype)
    zero, one = np.zeros((2, x.size), x.dtype), np.ones_like(x)
    return Rays(facet, E, np.arange(x.size), x, zero[0], zero[1], one)


def _step(
    correlation: Correlation, rays: Rays, fineness: float, way_in: WayIn | None = None
) -> tuple[Rays, Hits, Rays]:
    """Those that go on after another step, those that met the surface in it, and those that have
    come to where nothing is remembered."""
    low, c = rays.x, rays.c
    length = np.maximum(LENGTH, FAR * low) * fineness
    length = np.minimum(length, CLIMB * fineness / np.maximum(np.abs(c), CLIMB))
    # At least two places of the lattice, to either of which distances are rounded.
    i = correlation.index(low + np.clip(length, 2 * STEP * low, GROWTH * fineness * low))
    after = hazard.near(correlation, i, rays.facet)
    x = correlation.x.take(i)
    after = _informed(way_in, rays, x, after, i)
    level = rays.facet[1] + c * x
    step, half = x - rays.x, x.dtype.type(0.5)
    total = rays.below - after.below + step * (rays.down + after.down) * half
    away = (level > TOP) & (c > 0)
    on, hits, out = _go(rays, x, after, total, (x >= correlation.x[-1]) | away)
    hits.place = correlation.index(hits.place)
    return on, hits, out


def _far_step(
    correlation: Correlation, rays: Rays, fineness: float, way_in: WayIn | None = None
) -> tuple[Rays, Hits, Rays]:
    """The same beyond, where the integral of Smith's hazard is Lambda times the difference of t; at
    last those that are away."""
    c = rays.c
    # A ray that does not climb at all has no other hazard than one that hardly does.
    climb = np.where(np.abs(c) > LEVEL, c, np.copysign(c.dtype.type(LEVEL), c))
    x = rays.x + CLIMB * fineness / np.abs(climb)
    level = rays.facet[1] + climb * x
    after = hazard.far(correlation, level, climb)
    after = _informed(way_in, rays, x, after, None)
    total = (after.below - rays.below) * normal.excess(climb) / climb
    on, hits, out = _go(rays, x, after, total, (level > TOP) & (climb > 0))
    hits.place = np.full(hits.slot.size, NOWHERE)
    return on, hits, out


def _informed(
    way_in: WayIn | None, rays: Rays, x: Array, after: hazard.Parts, place: Array | None
) -> hazard.Parts:
    """The hazard's parts `after` at distances `x` (n,), with what the way in says, if any."""
    if way_in is None or rays.before is None:
        return after
    factor = way_in.factor(rays.before, rays.facet[1], x, after, place)
    return after._replace(factor=after.factor * factor)


def _go(
    rays: Rays, x: Array, after: hazard.Parts, total: Array, last: Array
) -> tuple[Rays, Hits, Rays]:
    """Rays on to the distances `x`, where the hazard's parts are `after`, its integral over the
    step being `total` without looking back: those that go on, those that met the surface, whose
    places are distances still, and those of which it was the `last` step."""
    step, half = x - rays.x, x.dtype.type(0.5)
    total = np.maximum(total * (rays.factor + after.factor) * half, 0)
    left = rays.left - total
    stays = left > 0
    met = np.flatnonzero(~stays)
    part = rays.left.take(met) / np.maximum(total.take(met), np.finfo(x.dtype).tiny)
    where = rays.x.take(met) + part * step.take(met)
    delta, h, s, _ = rays.facet.take(met, axis=1)
    hits = Hits(rays.slot.take(met), h + (s + delta) * where, where)
    on = Rays(rays.facet, left, rays.slot, x, after.below, after.down, after.factor, rays.before)
    out = on.compress(stays & last)
    return (on.compress(stays & ~last) if met.size or out.size else on), hits, out
