"""The memory of a surface, and what rays meet next: by the hazard, or among drawn heights."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.memory.correlation import Correlation, correlation
from msbsdf_cli.memory.entry import Entry, entry
from msbsdf_cli.memory.escape import Escape
from msbsdf_cli.memory.march import NOWHERE, Hits, march
from msbsdf_cli.memory.profile import Crossings, Profile, draw, profile
from msbsdf_cli.memory.way_in import WayIn, way_in
from surfaces.batch import concatenate
from surfaces.facet import Array
from surfaces.spectrum import GAUSSIAN, Spectrum

SURE = 1.02, 1e-3
"""Rays of which the table says that the hazard comes to less than E by so much, as a factor and in
itself, leave; where the others meet the surface, or whether, the march says."""


TOGETHER = 1 << 10
"""Rays at least that are drawn together where the way in makes most of them unlikely."""


@dataclass(frozen=True, eq=False)
class Memory:
    """The surface that a walk remembers: its autocorrelation, and what follows from it."""

    correlation: Correlation
    escape: Escape
    entry: Entry
    way_in: WayIn
    profile: Profile | None
    """What the heights that a ray has passed say, where these are remembered too."""

    @classmethod
    def of(cls, spectrum: Spectrum = GAUSSIAN, number: int = 1) -> "Memory":
        """That of a spectrum, as `--memory` has the `number`, 1 or 2; tables are made once in a
        process, in some seconds."""
        first = entry(spectrum)
        heights = profile(spectrum) if number == 2 else None
        return cls(correlation(spectrum), first.escape, first, way_in(spectrum), heights)


def next_facets(
    memory: Memory, facet: Array, rng: np.random.Generator, before: Array | None = None
) -> tuple[Hits, Array]:
    """What rays meet next that leave facets of the four numbers `facet` (4, n), and who of them
    meets nothing, (n,) of bool; `before` (5, n) is what is known of the ways in of rays from first
    facets, for which nothing is met more often."""
    if memory.profile is not None:
        return passing(memory, memory.profile, facet, rng, before)
    delta, h, s, u = facet
    E = rng.standard_exponential(h.size, dtype=np.float32)
    total = memory.escape.hazard(h, s + delta, delta, u)
    away = SURE[0] * total + SURE[1] <= E
    seeking = np.flatnonzero(~away)
    known = None if before is None else (memory.way_in, before.take(seeking, axis=1))
    facet, E = facet.take(seeking, axis=1), E.take(seeking)
    hits, others = march(memory.correlation, facet, E, known=known)
    away[seeking[others.slot]] = True
    hits.slot = seeking[hits.slot]
    return hits, away


def passing(
    memory: Memory,
    heights: Profile,
    facet: Array,
    rng: np.random.Generator,
    before: Array | None,
) -> tuple[Hits, Array]:
    """The same where the heights that rays pass are remembered."""
    start = facet.astype(float)
    start[3] = memory.correlation.bend * facet[3] - facet[1]
    lanes, found = np.arange(facet.shape[1]), []
    while lanes.size:
        times = 1 if before is None else max(TOGETHER // lanes.size, 1)
        rays = lanes.repeat(times)
        met = draw(heights, start.take(rays, axis=1), rng)
        good, crossing = np.ones(rays.size, bool), np.full(rays.size, -1)
        if before is not None:
            mine, x = rays.take(met.slot), met.x.astype(np.float32)
            known = facet.take(mine, axis=1), x, before.take(mine, axis=1)
            good[met.slot] = rng.random(x.size) < memory.way_in.likelihood(*known)
        crossing[met.slot] = np.arange(met.slot.size)
        # Of surfaces that the way in makes so much less likely, others are drawn.
        each = good.reshape(lanes.size, times)
        done = np.flatnonzero(each.any(axis=1))
        chosen = crossing.take(done * times + each.argmax(axis=1).take(done))
        met.slot = rays.take(met.slot)
        found.append(met.take(chosen[chosen >= 0]))
        lanes = np.delete(lanes, done)
    return _as_hits(memory.correlation, concatenate(found), facet.shape[1])


def _as_hits(cor: Correlation, met: Crossings, n: int) -> tuple[Hits, Array]:
    away = np.ones(n, bool)
    away[met.slot] = False
    place = np.where(met.x < cor.x[-1], cor.index(met.x), NOWHERE)
    facet = np.stack([met.slope, (met.second + met.h) / cor.bend]).astype(np.float32)
    return Hits(met.slot, met.h.astype(np.float32), place, facet), away
