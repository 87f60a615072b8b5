"""Light on an explicit surface: rays uniform over the mean plane, facet after facet.

Embree finds the facet; where the ray meets it is computed again, on the facet's plane, in double
precision.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from surfaces.batch import Batch, concatenate
from surfaces.facet import Array
from surfaces.light import Light, append_event
from surfaces.materials import Material
from surfaces.periodic import ESCAPED, LOST, meet, next_triangle
from surfaces.stretch import Stretch
from surfaces.surface import Surface
from surfaces.views import Views, each, upside_down

BLOCK = 32768
"""Rays handled together."""


@dataclass
class Rays(Batch):
    """Paths under way: origins in the surface's coordinates and directions in the world, (3, n);
    directions are in single precision, as Embree takes them."""

    o: Array
    d: Array
    view: Array | None = None
    """Which of `surfaces.views` each is traced on, (n,), ascending; None: the mesh as it is."""
    weight: Array | None = None
    inside: Array | None = None
    sequence: Array | None = None


class Tracer:
    """Light on `surface`, in the world that `stretch` takes to its grid, with facets of
    `material`; on the first so many `views` of it, the same number of rays on each."""

    def __init__(
        self, surface: Surface, stretch: Stretch, material: Material, views: int = 1
    ) -> None:
        self.surface = surface
        self.material = material
        self.views = Views(stretch, views)
        self.number = views

    def trace(
        self,
        wi: Array,
        n: int,
        rng: np.random.Generator,
        max_order: int,
        piece: tuple[int, int] = (0, 1),
    ) -> Iterator[Light]:
        """Trace `n` rays from the direction `wi` (3,), z > 0; yield what leaves, order by order.

        Rays start uniformly over the mean plane, one on each of `n` equal pieces of a
        space-filling curve: evenly spread, and neighbours in memory are neighbours in space,
        which is what makes Embree fast. `piece` (i, k) is the i-th of k equal pieces of that curve,
        where the rays start. What is still under way after `max_order` facets comes
        last, unresolved.
        """
        survivors: list[Rays] = []
        for start in range(0, n, BLOCK):
            count = min(BLOCK, n - start)
            place = (start + np.arange(count) + rng.random(count)) / n
            yield from self._facet(self._arrive(wi, place, piece), 1, rng, survivors)
        for order in range(2, max_order + 2):
            if not survivors:
                return
            rays = concatenate(survivors)
            survivors = []
            for block in rays.blocks(BLOCK):
                yield from self._facet(block, order, rng, survivors)
        if survivors:
            rays = concatenate(survivors)
            yield _leave(rays, np.arange(rays.size), max_order + 1, resolved=False)

    def _arrive(self, wi: Array, place: Array, piece: tuple[int, int]) -> Rays:
        """Rays at the places (n,) in [0, 1) of the curve, or of those of all views in turn."""
        n, view = place.size, None
        o, d = np.empty((3, n)), np.empty((3, n), np.float32)
        top, bottom = self.surface.top, self.surface.bottom
        o[2] = top
        if self.number > 1:
            place = place * self.number
            view = place.astype(np.int8)
            place -= view
            o[2] += (bottom - top) * upside_down(view)
        o[:2] = morton((piece[0] + place) / piece[1]) * self.surface.period
        d[:] = -wi[:, None]
        rays = Rays(o, d, view)
        if self.material.absorbs:
            rays.weight = np.ones((self.material.channels, n))
        if self.material.transmits:
            rays.inside = np.zeros(n, bool)
            rays.sequence = np.ones(n, np.int64)
        return rays

    def _facet(
        self, rays: Rays, order: int, rng: np.random.Generator, survivors: list[Rays]
    ) -> Iterator[Light]:
        """Take rays to their facet number `order`; yield those that find none."""
        d = each(self.views.to_mesh, rays.d, rays.view)
        triangle = next_triangle(self.surface, rays.o, d, _below(rays))
        escaped, lost = (np.flatnonzero(triangle == none) for none in (ESCAPED, LOST))
        if escaped.size:
            # Light that arrives has to meet a facet before it leaves.
            yield _leave(rays, escaped, order - 1, resolved=order > 1)
        if lost.size:
            yield _leave(rays, lost, order - 1, resolved=False)
        if escaped.size or lost.size:
            hit = np.flatnonzero(triangle >= 0)
            rays, d, triangle = rays.take(hit), d.take(hit, axis=1), triangle.take(hit)
        point, upper, slopes = meet(self.surface, rays.o, d, triangle)
        below = _below(rays)
        facing = upper if below is None else upper ^ below
        if not facing.all():
            # The far side of a facet was met: the ray has leaked through the surface.
            yield _leave(rays, np.flatnonzero(~facing), order - 1, resolved=False)
            rays, point, slopes = rays.compress(facing), point[:, facing], slopes[:, facing]
        if point.size:
            survivors.append(self._scatter(rays, point, slopes, rng))

    def _scatter(self, rays: Rays, point: Array, slopes: Array, rng: np.random.Generator) -> Rays:
        m = self.views.normals(slopes.astype(np.float32), rays.view)
        if rays.inside is not None:
            np.negative(m, out=m, where=rays.inside)
        travel, gain, transmitted = self.material.scatter(rays.d, m, rays.inside, rng)
        after = Rays(point, travel, rays.view)
        if gain is not None and rays.weight is not None:
            after.weight = rays.weight * gain
        if transmitted is not None and rays.inside is not None and rays.sequence is not None:
            after.inside = rays.inside ^ transmitted
            after.sequence = append_event(rays.sequence, transmitted)
        below, lift = _below(after), self.surface.lift
        point[2] += lift if below is None else lift - (2 * lift) * below
        return after


def _leave(rays: Rays, lanes: Array, order: int, resolved: bool = True) -> Light:
    """The light of some of the rays (n,)."""
    numbers = rays.weight, rays.inside, rays.sequence
    weight, inside, sequence = (None if a is None else a.take(lanes, axis=-1) for a in numbers)
    return Light(order, rays.d.take(lanes, axis=1), weight, inside, sequence, resolved)


def _below(rays: Rays) -> Array | None:
    """Who is on the mesh's lower side, (n,); None: nobody."""
    if rays.view is None:
        return rays.inside
    flipped = upside_down(rays.view)
    return flipped if rays.inside is None else flipped ^ rays.inside


def morton(curve: Array) -> Array:
    """Points (2, n) of the unit square at the places `curve` in [0, 1) of Morton's curve.

    26 bits an axis: a cell of the curve is far below the single precision of Embree.
    """
    code = (curve * 2.0**52).astype(np.uint64)
    return np.stack([_every_other_bit(code >> np.uint64(1)), _every_other_bit(code)]) * 2.0**-26


def _every_other_bit(code: Array) -> Array:
    code = code & np.uint64(0x5555555555555555)
    moved = np.empty_like(code)
    for shift, mask in (
        (1, 0x3333333333333333),
        (2, 0x0F0F0F0F0F0F0F0F),
        (4, 0x00FF00FF00FF00FF),
        (8, 0x0000FFFF0000FFFF),
        (16, 0x00000000FFFFFFFF),
    ):
        np.right_shift(code, np.uint64(shift), out=moved)
        code |= moved
        code &= np.uint64(mask)
    return code.astype(np.float64)
