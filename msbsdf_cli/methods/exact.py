"""The Smith model with its heights integrated out: only directions are sampled."""

from collections import defaultdict
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from msbsdf_cli.methods.base import Outgoing, outgoing
from msbsdf_cli.methods.estimate import Estimate, batches
from msbsdf_cli.methods.forced_collisions import (
    ForcedPaths,
    follow_forced_paths,
    forced_free_path,
    roulette,
)
from msbsdf_cli.methods.paths import (
    coloured,
    lanes_for,
    meet,
    next_event,
    scatter,
)
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.sampling import SampledByWalk
from msbsdf_cli.methods.single import first_order, first_order_of_each
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.methods.walks import Walks, first_facet
from msbsdf_cli.smith.integrated_heights import IntegratedHeights, arriving_heights, extinction_of
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import BLOCK
from surfaces.batch import concatenate
from surfaces.facet import Array
from surfaces.materials import Material

HEIGHTS_FROM = 5
HEIGHTS_FROM_MIRRORS = 24
"""Paths of diffuse facets and of mirrors have their heights integrated out up to the facet before
this one. Of mirrors, hardly a path comes so far unless roughness is well above 1."""


@dataclass(kw_only=True)
class IntegratedPaths(Walks):
    """Paths with the columns of `IntegratedHeights`, all with as many ways down."""

    throughput: Array
    """1 over the probability that roulette let the path come so far, (n,)."""
    hit: Array
    """Probability of the heights t, which are sampled along for later use, (n,)."""
    extinction: Array
    follow: Array
    up: Array
    turn: Array | None

    @property
    def heights(self) -> IntegratedHeights:
        return IntegratedHeights(self.extinction, self.follow, self.up, self.turn)


class Exact(SampledByWalk):
    """The model of Bitterli & d'Eon 2022 and Cui et al. 2023, which is that of [HHdD16] with the
    integral over heights done (`msbsdf_cli.smith.integrated_heights`).

    Directions are sampled along the scattering kernel, with a next event towards wo at each facet
    and the first order in closed form. Paths go on as long as light probably meets another facet
    along their directions, and end by roulette: no bias, no cap.

    The work for a path grows with the square of its length, with the cube where light turns down
    again. From facet number `HEIGHTS_FROM` on (`HEIGHTS_FROM_MIRRORS`), heights are sampled:
    those orders are noisier, and no less right.
    """

    name = "exact"
    traits = Traits("#009e73", "D")

    @classmethod
    def check_supported(cls, slopes: Slopes, material: Material) -> None:
        super().check_supported(slopes, material)
        if material.transmits:
            raise UnsupportedError(
                "method exact is for conductors and diffuse facets: light that changes sides turns "
                "the surface upside down, and its heights cannot be integrated out beyond that"
            )

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        out = outgoing(self.slopes, wo.astype(wi.dtype, copy=False))
        estimate = Estimate(self.material.channels, self.orders, out.n)
        for n in batches(samples, out.n):
            self._follow(np.tile(-wi[:, None], n), None, out, estimate, rng)
            estimate.close_batch()
        value, stderr = estimate.mean(samples)
        value[:, 0] = first_order(self.slopes, self.material, wi, out)
        stderr[:, 0] = 0
        return Evaluation(value, stderr)

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        out = outgoing(self.slopes, wo, each=True)
        first = first_order_of_each(self.slopes, self.material, wi, out, rng)
        return first + self._one_path_each(self._follow, wi, out, rng)

    def _follow(
        self,
        d: Array,
        start: Array | None,
        out: Outgoing,
        estimate: Estimate,
        rng: np.random.Generator,
    ) -> None:
        """Add what paths along `d` (3, n) send to the outgoing directions from their second facet
        on."""
        groups = [self._arrive(d, start, rng)]
        for order in count(1):
            if order == estimate.orders + 1:
                _open_tail(groups, out, estimate)
            if order == (HEIGHTS_FROM_MIRRORS if mirrors(self.material) else HEIGHTS_FROM):
                self._sample_heights(groups, out, estimate, order, rng)
                return
            parts = defaultdict(list)
            for paths in groups:
                for block in paths.blocks(BLOCK):
                    block.m = meet(self.slopes, self.material, block, rng)
                    if order > 1:
                        for piece in block.blocks(lanes_for(out.per_path)):
                            value = self._towards(piece, out)
                            estimate.add(order, value, piece.slot, piece.start)
                    for after in self._leave_facet(block, rng):
                        parts[len(after.extinction)].append(after)
            groups = [concatenate(same_depth) for same_depth in parts.values()]
            if not groups:
                return

    def _arrive(self, d: Array, start: Array | None, rng: np.random.Generator) -> IntegratedPaths:
        n = d.shape[1]
        walks = first_facet(self.slopes, self.material, d, np.zeros(n, bool), rng, start)
        heights = arriving_heights(extinction_of(d, walks.sigma), not mirrors(self.material))
        one = np.ones(n, d.dtype)
        return IntegratedPaths(**vars(walks), hit=one, throughput=one, **vars(heights))

    def _sample_heights(
        self,
        groups: list[IntegratedPaths],
        out: Outgoing,
        estimate: Estimate,
        order: int,
        rng: np.random.Generator,
    ) -> None:
        """Go on with the heights sampled so far, from facet number `order`."""
        walks = [
            ForcedPaths(
                d=g.d,
                sigma=g.sigma,
                slot=g.slot,
                start=g.start,
                weight=g.weight,
                t=g.t,
                throughput=g.throughput * g.hit,
            )
            for g in groups
        ]
        follow_forced_paths(
            self.slopes, self.material, concatenate(walks), out, estimate, rng, order
        )

    def _towards(self, paths: IntegratedPaths, out: Outgoing) -> Array:
        """Next events, (channels, n, directions)."""
        phase, colour = next_event(self.slopes, self.material, paths, out)
        leaves = paths.heights.leaving(out.seen_by(paths.start).Lambda)[0]
        leaves *= paths.throughput[:, None]
        return coloured(phase * leaves, colour, paths.weight)

    def _leave_facet(
        self, paths: IntegratedPaths, rng: np.random.Generator
    ) -> list[IntegratedPaths]:
        """The paths that go on: those that head up, and those that head down."""
        assert paths.m is not None
        after, _ = scatter(self.slopes, self.material, paths, paths.m, rng)
        if after.weight is not None:
            after = after.compress(after.weight.max(axis=0) > 0)
        after.t, probability = forced_free_path(after.t, after.d, after.sigma, rng)
        after.hit = after.hit * probability
        heads_up = after.d[2] > 0
        up, down = after.compress(heads_up), after.compress(~heads_up)
        ways_on = []
        if up.n:
            up = replace(up, **vars(up.heights.upward(extinction_of(up.d, up.sigma))))
            arrives = up.heights.leaving(np.zeros(1, up.d.dtype))[0][:, 0]
            stays, boost = roulette(arrives * up.throughput, up.weight, rng)
            up.throughput = up.throughput * boost
            ways_on.append(up.compress(stays))
        if down.n:
            ways_on.append(
                replace(down, **vars(down.heights.downward(extinction_of(down.d, down.sigma))))
            )
        return [paths for paths in ways_on if paths.n]


def mirrors(material: Material) -> bool:
    """Whether light that heads up never heads down again: a mirror always raises d_z."""
    return material.specular and not material.transmits


def _open_tail(groups: list[IntegratedPaths], out: Outgoing, estimate: Estimate) -> None:
    first, starts = 0, []
    for paths in groups:
        paths.slot = np.arange(first, first + paths.n)
        first += paths.n
        if paths.start is not None:
            starts.append(paths.start)
    estimate.open_tail(first, out.per_path, np.concatenate(starts) if starts else None)
