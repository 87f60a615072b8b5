"""The random walk with the variance reduction of [HHdD16] Section 9.1."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.methods.base import Outgoing, adjoint_weight, outgoing
from msbsdf_cli.methods.estimate import Estimate, batches
from msbsdf_cli.methods.forced_collisions import ForcedPaths, follow_forced_paths, next_facet
from msbsdf_cli.methods.paths import meet, reversed_phase
from msbsdf_cli.methods.protocol import Evaluation
from msbsdf_cli.methods.sampling import SampledByWalk
from msbsdf_cli.methods.single import first_order, first_order_of_each
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.methods.undersampling import undersampling_bound
from msbsdf_cli.methods.walks import first_facet, leave_facet
from msbsdf_cli.smith.walk import BLOCK
from surfaces.batch import concatenate
from surfaces.facet import Array

ENOUGH_FOR_ERRORS = 64
"""Walks from each wo, if so many can be had, whose scatter is to tell their standard error."""


class WalkLowVariance(SampledByWalk):
    """The first bounce in closed form, forced intersections, and walks from both ends.

    A path of n facets is found from wi with contribution C_i and from wo with C_o, either being
    the last facet's phase function times the probability to leave from it: all other factors are
    sampled. The density of finding it is therefore its energy over C, and the balance heuristic
    for n_i and n_o walks has a path count C_i C_o / (n_i C_o + n_o C_i), whichever way it is
    found: the larger of the two cannot spoil it.

    A walk from wi serves all wo, one from wo serves only that: there are as many from all wo
    together as from wi, or enough to know their error. What diffuse facets send anywhere is
    bounded, so that there the second end would cost more than it saves.
    Light carries energy, so that a walk from wo counts eta_o^2 cos(theta_o) / cos(theta_i).
    Paths end by roulette, not at a threshold: nothing is lost.
    """

    name = "walk-low-variance"
    traits = Traits("#e69f00", "s")

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        out = outgoing(self.slopes, wo.astype(wi.dtype, copy=False))
        n_i, n_o = self._shares(samples, out.n)
        ends = _Ends(out, n_o / n_i, adjoint_weight(self.material, out) / wi[2])
        value, stderr = self._from_wi(wi, ends, n_i, rng)
        if self.material.specular:
            from_wo, stderr_wo = self._from_wo(wi, ends, n_o, rng)
            value, stderr = value + from_wo, np.hypot(stderr, stderr_wo)
        value[:, 0] = first_order(self.slopes, self.material, wi, out)
        stderr[:, 0] = 0
        return Evaluation(value, stderr)

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        """A walk from either end: `evaluate` with n_i = n_o = 1."""
        out, start = outgoing(self.slopes, wo, each=True), np.arange(wo.shape[1])
        ends = _Ends(out, 1.0, adjoint_weight(self.material, out) / wi[2])
        estimate = Estimate(self.material.channels, 0, out.n)
        walks = self._arrive(-wi, np.zeros(out.n, bool), rng, start)
        self._follow(walks, out, ends.from_wi, estimate, rng)
        estimate.close_batch()
        if self.material.specular:
            walks = self._arrive(-out.w, out.inside, rng, start)
            back = outgoing(self.slopes, wi, each=True)
            self._follow(walks, back, ends.from_wo, estimate, rng)
            estimate.close_batch()
        first = first_order_of_each(self.slopes, self.material, wi, out, rng)
        return first + estimate.sums[:, 0]

    def undersampling(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Array:
        """Of either end, the less: a path counts by both."""
        out, (n_i, n_o) = outgoing(self.slopes, wo), self._shares(samples, wo.shape[1])
        from_wi = undersampling_bound(self.slopes, self.material, out, n_i, rng)
        if not self.material.specular:
            return from_wi
        start = outgoing(self.slopes, wi[:, None])
        from_wo = undersampling_bound(self.slopes, self.material, start, n_o, rng)
        return np.minimum(from_wi, from_wo * adjoint_weight(self.material, out) / wi[2])

    def _shares(self, samples: int, directions: int) -> tuple[int, int]:
        """Walks from wi, and from each wo."""
        fair = max(samples // (1 + directions), ENOUGH_FOR_ERRORS)
        n_o = max(1, min(fair, samples // 2)) if self.material.specular else 0
        return max(1, samples - n_o), n_o

    def _from_wi(
        self, wi: Array, ends: "_Ends", samples: int, rng: np.random.Generator
    ) -> tuple[Array, Array]:
        """Walks from `wi` towards all outgoing directions, mean and standard error."""
        estimate = Estimate(self.material.channels, self.orders, ends.out.n)
        for n in batches(samples, ends.out.n):
            walks = self._arrive(np.tile(-wi[:, None], n), np.zeros(n, bool), rng)
            self._follow(walks, ends.out, ends.from_wi, estimate, rng)
            estimate.close_batch()
        return estimate.mean(samples)

    def _from_wo(
        self, wi: Array, ends: "_Ends", samples: int, rng: np.random.Generator
    ) -> tuple[Array, Array]:
        """Walks from each outgoing direction towards `wi`, mean and standard error."""
        out = ends.out
        estimate = Estimate(self.material.channels, self.orders, out.n)
        for n in batches(samples, out.n):
            start = np.tile(np.arange(out.n), n)
            walks = self._arrive(-out.w[:, start], out.inside[start], rng, start)
            back = outgoing(self.slopes, wi[:, None])
            self._follow(walks, back, ends.from_wo, estimate, rng)
            estimate.close_batch()
        return estimate.mean(samples)

    def _arrive(
        self, d: Array, inside: Array, rng: np.random.Generator, start: Array | None = None
    ) -> ForcedPaths:
        walks = first_facet(self.slopes, self.material, d, inside, rng, start)
        return ForcedPaths(**vars(walks), throughput=np.ones(walks.n, d.dtype))

    def _follow(
        self,
        walks: ForcedPaths,
        out: Outgoing,
        weigh: Callable[[Array, ForcedPaths], Array],
        estimate: Estimate,
        rng: np.random.Generator,
    ) -> None:
        """Add what the walks send to the outgoing directions from their second facet on."""
        parts = []
        for block in walks.blocks(BLOCK):
            block.m = meet(self.slopes, self.material, block, rng)
            after = leave_facet(self.slopes, self.material, block, rng)
            if self.material.specular:
                after.other = self._seen_from_beyond(block, after)
            parts.append(next_facet(after, rng))
        follow_forced_paths(
            self.slopes, self.material, concatenate(parts), out, estimate, rng, 2, weigh
        )

    def _seen_from_beyond(self, walks: ForcedPaths, after: ForcedPaths) -> Array:
        """What the same path, walked from its other end, would send to this walk's start."""
        # From the horizon Lambda is finite here, as in `outgoing`.
        cos = np.maximum(-walks.d[2], np.finfo(walks.d.dtype).eps ** 2)
        Lambda = self.slopes.at(walks.start).sigma(-walks.d) / cos
        back = reversed_phase(self.slopes, self.material, walks, after)
        return back * np.exp(-Lambda * walks.t)


@dataclass(frozen=True)
class _Ends:
    """The outgoing directions, and how the walks from there compare with those from wi."""

    out: Outgoing
    per_walk: float
    """Walks from each outgoing direction for one from wi."""
    scale: Array
    """What a walk from each outgoing direction counts, (directions,)."""

    def from_wi(self, here: Array, walks: ForcedPaths) -> Array:
        """Contributions (n, directions) of walks from wi, weighed against those of the same paths
        found from the other end."""
        if walks.other is None:
            return here
        there = walks.other[:, None] * self._scale(walks)
        return here * (there / np.maximum(there + self.per_walk * here, np.finfo(here.dtype).tiny))

    def from_wo(self, here: Array, walks: ForcedPaths) -> Array:
        """The same of walks from the directions that `start` numbers."""
        assert walks.other is not None
        here, there = here * self._scale(walks), self.per_walk * walks.other[:, None]
        return here * (there / np.maximum(here + there, np.finfo(here.dtype).tiny))

    def _scale(self, walks: ForcedPaths) -> Array:
        return self.scale if walks.start is None else self.scale[walks.start][:, None]
