"""The random walk of [HHdD16] with next-event estimation, as published."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from msbsdf_cli.methods.base import Outgoing, outgoing
from msbsdf_cli.methods.estimate import Estimate, batches
from msbsdf_cli.methods.paths import (
    Paths,
    arriving,
    coloured,
    follow,
    next_event,
    scatter,
)
from msbsdf_cli.methods.protocol import Evaluation
from msbsdf_cli.methods.sampling import SampledByWalk
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.walk import exponential, flip, free_path
from surfaces.facet import Array


@dataclass(kw_only=True)
class Walks(Paths):
    """Paths with their coordinate t = -ln C1(h), at the facet they met."""

    t: Array


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
            follow(
                self.slopes,
                self.material,
                self._arrive(wi, n, rng),
                out.n,
                estimate,
                rng,
                partial(self._towards, out=out),
                partial(self._leave_facet, rng=rng),
            )
            estimate.close_batch()
        return Evaluation(*estimate.mean(samples))

    def _arrive(self, wi: Array, n: int, rng: np.random.Generator) -> Walks:
        """At the first facet: a free path from t = 0."""
        d = np.tile(-wi[:, None], n)
        columns = arriving(self.slopes, self.material, d, np.zeros(n, bool))
        E = exponential(n, rng, wi.dtype.type)
        _, t = free_path(np.zeros(n, wi.dtype), d, columns["sigma"], E)
        return Walks(**columns, t=t)

    def _towards(self, walks: Walks, out: Outgoing) -> Array:
        """Next events, (channels, n, directions)."""
        phase, colour = next_event(self.slopes, self.material, walks, out)
        return coloured(phase * escape(walks.t, walks.inside, out), colour, walks.weight)

    def _leave_facet(self, walks: Walks, rng: np.random.Generator) -> Walks:
        """The walks that meet another facet, and where."""
        assert walks.m is not None
        after, transmitted = scatter(self.slopes, self.material, walks, walks.m, rng)
        if transmitted is not None:
            after.t = np.where(transmitted, flip(after.t), after.t)
        E = exponential(after.n, rng, after.d.dtype.type)
        leaves, after.t = free_path(after.t, after.d, after.sigma, E)
        stays = ~leaves
        if after.weight is not None:
            stays &= after.weight.any(axis=0)
        return after.compress(stays)


def escape(t: Array, inside: Array | None, out: Outgoing) -> Array:
    """Probability exp(-Lambda t) of leaving in each outgoing direction, (n, directions), from
    `t` (n,)."""
    if inside is None:
        return _escape(t, out.Lambda)
    return np.where(
        inside[:, None] == out.inside, _escape(t, out.Lambda), _escape(flip(t), out.Lambda)
    )


def _escape(t: Array, Lambda: Array) -> Array:
    return np.exp(-np.outer(t, Lambda))
