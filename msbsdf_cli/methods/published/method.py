"""`published`: the random walk in heights, as renderers took it over from the paper."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.methods.estimate import Estimate, batches
from msbsdf_cli.methods.paths import lanes_for
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.published import facets
from msbsdf_cli.methods.published.areas import Lambda, projected_area
from msbsdf_cli.methods.published.heights import HEIGHTS, escape, next_height
from msbsdf_cli.methods.published.visible_slopes import visible_normals
from msbsdf_cli.methods.sampling import FollowsPaths
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.slopes import Beckmann, Ggx, Slopes
from msbsdf_cli.smith.walk import BLOCK
from surfaces.batch import Batch, concatenate
from surfaces.facet import Array, dot
from surfaces.materials import Material

MOST_FACETS = 10_000
"""The print has no bound; a walk that is longer counts as unresolved here."""


@dataclass
class Walks(Batch):
    """Walks under way, (..., n)."""

    d: Array
    h: Array
    inside: Array
    slot: Array
    weight: Array | None = None
    start: Array | None = None
    """Number of the direction that the walk starts from, where each has its own."""


@dataclass
class Lights(Batch):
    """Walks that have ended."""

    w: Array
    weight: Array
    facets: Array
    """Number of facets that each has hit, (n,)."""
    start: Array | None = None
    """As that of `Walks`."""


class Published(FollowsPaths):
    """[HHdD16 impl.] Algorithms 1 to 7, thresholds and fits included, in the precision of `wi`.

    `heights` are `uniform` or `gaussian`, which should not matter; `polynomial` takes the fit to
    erf that some implementations have in Lambda; `most_facets` ends walks, as some do.
    Weights for metals and albedos are those of Algorithms 4 and 6.
    """

    name = "published"
    traits = Traits("#8c510a", "h", model="published", consistent=False)

    def __init__(
        self,
        slopes: Slopes,
        material: Material,
        orders: int,
        heights: str = "uniform",
        polynomial: bool = False,
        most_facets: int = MOST_FACETS,
    ) -> None:
        super().__init__(slopes, material, orders)
        self.heights, self.polynomial, self.most_facets = HEIGHTS[heights], polynomial, most_facets
        self.hidden = 0
        """Values so far that were not finite and that the algorithm replaces or leaves out."""
        self.cut = 0
        """Walks so far that `most_facets` cut off."""

    @classmethod
    def check_supported(cls, slopes: Slopes, material: Material) -> None:
        super().check_supported(slopes, material)
        if not isinstance(slopes, Beckmann | Ggx):
            raise UnsupportedError(
                f"method {cls.name} is for Beckmann and GGX slopes, and not for {slopes.name} ones"
            )
        if not material.specular and material.name != "diffuse":
            raise UnsupportedError(f"method {cls.name} is not for {material.name} facets")

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        wo = wo.astype(wi.dtype, copy=False)
        estimate = Estimate(self.material.channels, self.orders, wo.shape[1])
        cut = 0
        for n in batches(samples, wo.shape[1]):
            cut += self._shine(self._arrive(np.tile(-wi[:, None], n)), wo, estimate, rng)
        return Evaluation(*estimate.mean(samples), unresolved=cut / samples)

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        estimate = Estimate(self.material.channels, 0, wo.shape[1])
        self._shine(self._arrive(-wi, np.arange(wo.shape[1])), wo, estimate, rng)
        return estimate.sums[:, 0]

    def _shine(self, walks: Walks, wo: Array, estimate: Estimate, rng: np.random.Generator) -> int:
        """Add what walks send towards `wo` (3, directions), or each towards that of its `start`;
        how many of them `most_facets` cuts off."""
        order, each = 1, 1 if walks.start is not None else wo.shape[1]
        while walks.size and order <= self.most_facets:
            if order > estimate.orders and estimate.tail is None:
                walks = replace(walks, slot=np.arange(walks.size))
                estimate.open_tail(walks.size, each, walks.start)
            walks = self._bounce(walks, wo, order, estimate, rng)
            order += 1
        estimate.close_batch()
        # Of those at their last facet some would have left.
        cut = self._next_heights(walks, rng)[0].size if walks.size else 0
        self.cut += cut
        return cut

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """Where walks leave, (3, n), and their weights; a walk that is not finite ends at the
        zenith with all of its weight, as in the print."""
        parts = list(self.follow(wi, n, rng))
        lights = concatenate(parts)
        order = rng.permutation(lights.facets.size)
        return lights.w[:, order], lights.weight[:, order]

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        n = wi.shape[1]
        w, weight = np.empty_like(wi), np.empty((self.material.channels, n), wi.dtype)
        for lights in self._leave(self._arrive(-wi, np.arange(n)), rng):
            w[:, lights.start], weight[:, lights.start] = lights.w, lights.weight
        return w, weight

    def follow(self, wi: Array, n: int, rng: np.random.Generator) -> Iterator[Lights]:
        """The walks of Algorithm 3 in the order in which they end. Those that `most_facets` cuts
        off come last, with no weight left."""
        for first in range(0, n, 4 * BLOCK):
            some = min(4 * BLOCK, n - first)
            yield from self._leave(self._arrive(np.tile(-wi[:, None], some)), rng)

    def _leave(self, walks: Walks, rng: np.random.Generator) -> Iterator[Lights]:
        """Those of `walks` in the order in which they end."""
        for order in range(self.most_facets + 1):
            walks, gone = self._next_heights(walks, rng)
            yield self._lights(gone, order, gone.d)
            if not walks.size or order == self.most_facets:
                break
            walks = self._scatter(walks, rng)
            bad = ~(np.isfinite(walks.d[2]) & ~np.isnan(walks.h))
            if bad.any():
                self.hidden += int(bad.sum())
                lost = walks.compress(bad)
                zenith = np.zeros_like(lost.d)
                zenith[2] = 1
                yield self._lights(lost, order + 1, zenith)
                walks = walks.compress(~bad)
        self.cut += walks.size
        cut = self._lights(walks, self.most_facets, walks.d)
        yield replace(cut, weight=0 * cut.weight)

    def _lights(self, walks: Walks, order: int, w: Array) -> Lights:
        weight = walks.weight
        if weight is None:
            weight = np.ones((self.material.channels, walks.size), w.dtype)
        return Lights(w, weight, np.full(walks.size, order), walks.start)

    def _arrive(self, d: Array, start: Array | None = None) -> Walks:
        n = d.shape[1]
        h = np.repeat(self.heights.start(d.dtype.type), n)
        weight = np.ones((self.material.channels, n)) if self.material.absorbs else None
        return Walks(d, h, np.zeros(n, bool), np.arange(n), weight, start)

    def _bounce(
        self, walks: Walks, wo: Array, order: int, estimate: Estimate, rng: np.random.Generator
    ) -> Walks:
        """One facet: next events, and who meets another."""
        staying = []
        each = 1 if walks.start is not None else wo.shape[1]
        for block in walks.blocks(lanes_for(each)):
            at, _ = self._next_heights(block, rng)
            if not at.size:
                continue
            value = self._towards(at, wo, rng)
            after = self._scatter(at, rng)
            finite = np.isfinite(value)
            self.hidden += int(value.size - finite.sum())
            good = np.isfinite(after.d[2]) & ~np.isnan(after.h)
            self.hidden += int(after.size - good.sum())
            value = np.where(finite & good[:, None], value, 0)
            estimate.add(order, value, at.slot, at.start)
            staying.append(after.compress(good))
        return concatenate(staying) if staying else walks.compress(np.zeros(walks.size, bool))

    def _next_heights(self, walks: Walks, rng: np.random.Generator) -> tuple[Walks, Walks]:
        """Who meets a facet, at which height, and who leaves; inside, all is upside down."""
        side = np.where(walks.inside, -1, 1).astype(walks.d.dtype)
        U = rng.random(walks.size, dtype=walks.d.dtype.type)
        d = side * walks.d
        Lambda_d = Lambda(self.slopes.at(walks.start), d, self.polynomial)
        leaves, h = next_height(self.heights, Lambda_d, d[2], side * walks.h, U)
        return replace(walks, h=side * h).compress(~leaves), walks.compress(leaves)

    def _towards(self, walks: Walks, wo: Array, rng: np.random.Generator) -> Array:
        """Next events (channels, n, directions), or (channels, n, 1) towards the direction of
        `start`: phase function times shadowing."""
        own = walks.start is not None
        value = np.zeros((self.material.channels, walks.size, 1 if own else wo.shape[1]), wo.dtype)
        for inside in (False, True) if self.material.transmits else (False,):
            for above in (True, False) if self.material.transmits else (True,):
                lanes, ends, w = _ends(walks, wo, inside, above)
                if not lanes.size or not ends.size:
                    continue
                side = -1 if inside else 1
                slopes, material = self._at(walks, lanes)
                wi = -side * walks.d[:, lanes, None]
                phase = self._phase(slopes, material, wi, side * w, inside, above == inside, rng)
                out = w if above else -w
                h = walks.h[lanes, None] if above else -walks.h[lanes, None]
                Lambda_o = Lambda(slopes, out, self.polynomial)
                passes = escape(self.heights, Lambda_o, out[2], h)
                with np.errstate(invalid="ignore"):
                    value[:, lanes[:, None], ends] = phase * passes
        return value if walks.weight is None else value * walks.weight[:, :, None]

    def _at(self, walks: Walks, lanes: Array) -> tuple[Slopes, Material]:
        """Slopes and material that some of the walks meet, to go with arrays (n, directions)."""
        if walks.start is None:
            return self.slopes, self.material
        slopes, start = self.slopes.at(walks.start[lanes]), walks.start[lanes]
        if slopes.textured:
            slopes = slopes.of_lanes(*(np.asarray(a)[:, None] for a in slopes.alpha))
        return slopes, self.material.at(start)

    def _phase(
        self,
        slopes: Slopes,
        material: Material,
        wi: Array,
        wo: Array,
        inside: bool,
        through: bool,
        rng: np.random.Generator,
    ) -> Array:
        """Phase function (channels, n, directions)."""
        if not material.specular:
            m, hidden = visible_normals(slopes, wi, rng)
            self.hidden += hidden
            value = np.maximum(dot(m, wo), 0) / np.pi
            return np.asarray(value * material.kept()[:, :, None])
        area, eta = projected_area(slopes, wi), material.relative_ior(inside)
        if through:
            return facets.transmitted(slopes, wi, wo, area, eta)[None]
        value, colour = facets.reflected(slopes, material, wi, wo, area, eta)
        return value[None] if colour is None else value * colour

    def _scatter(self, walks: Walks, rng: np.random.Generator) -> Walks:
        """The walks after their facet."""
        dtype = walks.d.dtype.type
        side = np.where(walks.inside, dtype(-1), dtype(1))
        wi = -side * walks.d
        m, hidden = visible_normals(self.slopes.at(walks.start), wi, rng)
        self.hidden += hidden
        weight, inside, material = walks.weight, walks.inside, self.material.at(walks.start)
        if not material.specular:
            d = facets.diffuse(m, rng)
            gain = material.kept()
        else:
            d, gain = facets.mirror(wi, m), np.ones((material.channels, 1))
            if material.absorbs:
                gain = material.reflectance(np.clip(dot(wi, m), 0, 1))
        if material.transmits:
            eta = np.where(inside, dtype(1 / material.ior), dtype(material.ior))
            reflects = rng.random(walks.size, dtype=dtype) < facets.fresnel(dot(wi, m), eta)
            d = np.where(reflects, d, facets.refract(wi, m, eta))
            inside = inside ^ ~reflects
        if weight is not None:
            weight = weight * gain
        return replace(walks, d=side * d, inside=inside, weight=weight)


def _ends(walks: Walks, wo: Array, inside: bool, above: bool) -> tuple[Array, Array, Array]:
    """Walks on a side, the directions of leaving on a side that they look towards, and these as
    arrays (3, 1, directions), or (3, n, 1) of a direction for each walk."""
    here, there = walks.inside == inside, (wo[2] > 0) == above
    if walks.start is None:
        ends = np.flatnonzero(there)
        return np.flatnonzero(here), ends, wo[:, None, ends]
    lanes = np.flatnonzero(here & there[walks.start])
    return lanes, np.zeros(1, int), wo[:, walks.start[lanes], None]
