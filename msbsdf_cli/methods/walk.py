"""The random walk of [HHdD16] with next-event estimation, as published."""

from functools import partial

import numpy as np

from msbsdf_cli.methods.base import Outgoing, outgoing
from msbsdf_cli.methods.estimate import Estimate, batches
from msbsdf_cli.methods.paths import coloured, follow, next_event
from msbsdf_cli.methods.protocol import Evaluation
from msbsdf_cli.methods.sampling import SampledByWalk
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.methods.walks import Walks, escape, first_facet, leave_facet
from msbsdf_cli.smith.walk import exponential, free_path
from surfaces.facet import Array


class Walk(SampledByWalk):
    """[HHdD16 impl.] Algorithm 2, in the coordinate t: at each facet, the energy towards wo is
    the phase function times exp(-Lambda(wo) t), the probability of leaving that way unhindered.

    One walk serves all outgoing directions. Walks end only by leaving, or with nothing left.
    """

    name = "walk"
    traits = Traits("#d55e00", "o")

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        out = outgoing(self.slopes, wo.astype(wi.dtype, copy=False))
        estimate = Estimate(self.material.channels, self.orders, out.n)
        for n in batches(samples, out.n):
            self._follow(np.tile(-wi[:, None], n), None, out, estimate, rng)
            estimate.close_batch()
        return Evaluation(*estimate.mean(samples))

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        return self._one_path_each(self._follow, wi, outgoing(self.slopes, wo, each=True), rng)

    def _follow(
        self,
        d: Array,
        start: Array | None,
        out: Outgoing,
        estimate: Estimate,
        rng: np.random.Generator,
    ) -> None:
        inside = np.zeros(d.shape[1], bool)
        walks = first_facet(self.slopes, self.material, d, inside, rng, start)
        towards, on = partial(self._towards, out=out), partial(self._leave_facet, rng=rng)
        follow(self.slopes, self.material, walks, out.per_path, estimate, rng, towards, on)

    def _towards(self, walks: Walks, out: Outgoing) -> Array:
        """Next events, (channels, n, directions)."""
        phase, colour = next_event(self.slopes, self.material, walks, out)
        return coloured(
            phase * escape(walks.t, walks.inside, out.seen_by(walks.start)), colour, walks.weight
        )

    def _leave_facet(self, walks: Walks, rng: np.random.Generator) -> Walks:
        """The walks that meet another facet, and where."""
        after = leave_facet(self.slopes, self.material, walks, rng)
        E = exponential(after.n, rng, after.d.dtype.type)
        leaves, after.t = free_path(after.t, after.d, after.sigma, E)
        stays = ~leaves
        if after.weight is not None:
            stays &= after.weight.any(axis=0)
        return after.compress(stays)
