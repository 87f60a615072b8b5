"""The random walk that remembers the last facet: below the floor of the Smith model."""

from typing import Self

import numpy as np

from msbsdf_cli.memory import next_event
from msbsdf_cli.memory.facets import Facets
from msbsdf_cli.memory.frame import Directions, directions
from msbsdf_cli.memory.next_facet import Memory
from msbsdf_cli.memory.walk import Lanes, random_walk
from msbsdf_cli.methods.base import outgoing
from msbsdf_cli.methods.estimate import Estimate, batches
from msbsdf_cli.methods.paths import coloured, lanes_for
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.sampling import FollowsPaths, shuffled
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.spectrum import GAUSSIAN, Spectrum, spectrum

MAX_ORDER = 10_000
"""Facets after which a walk counts as unresolved: light that creeps along a hollow meets thousands,
once in millions of walks."""


class WalkMemory(FollowsPaths):
    """Heights are those of a Gaussian surface given the last facet (`msbsdf_cli.memory`): at each
    facet, the energy towards wo is what the facets that might as well have been met send there,
    times the probability of leaving that way unhindered from there.

    The first order knows that light came in, too; of specular facets it has no noise but that of a
    quadrature over heights and curvatures.
    """

    name = "walk-memory"
    traits = Traits(
        "#6a3d9a",
        ">",
        model="memory",
        reciprocal=False,
        smith_first=False,
        consistent=False,
        pairs=False,
    )

    def __init__(
        self, slopes: Slopes, material: Material, orders: int, spectrum: Spectrum = GAUSSIAN
    ) -> None:
        super().__init__(slopes, material, orders)
        self.memory = Memory.of(spectrum)

    @classmethod
    def on(cls, slopes: Slopes, material: Material, orders: int, autocorrelation: str) -> Self:
        return cls(slopes, material, orders, spectrum(autocorrelation))

    @classmethod
    def check_supported(cls, slopes: Slopes, material: Material) -> None:
        super().check_supported(slopes, material)
        if slopes.name != "beckmann":
            raise UnsupportedError(
                f"method {cls.name} remembers facets of Gaussian surfaces, whose slopes are "
                f"beckmann, not {slopes.name}"
            )

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        out = outgoing(self.slopes, wo.astype(wi.dtype, copy=False))
        estimate, unresolved = Estimate(self.material.channels, self.orders, out.n), 0
        about = self.memory, self.slopes, self.material
        step, specular = lanes_for(out.n), self.material.specular

        def look(order: int, lanes: Lanes, on_way: tuple[Directions, Facets] | None) -> None:
            for start in range(0, 0 if specular and on_way is None else lanes.slot.size, step):
                some = np.arange(start, min(start + step, lanes.slot.size))
                few = lanes.take(some)
                if specular and on_way is not None:
                    mine = on_way[0].take(some), on_way[1].take(some)
                    phase, colour = next_event.met(*about, few, mine, out)
                else:
                    phase, colour = next_event.drawn(*about, few, out, rng if order == 1 else None)
                estimate.add(order, coloured(phase, colour, few.weight), few.slot)

        for n in batches(samples, out.n):
            estimate.open_tail(n, out.n)
            for light in random_walk(*about, wi, n, rng, MAX_ORDER, look):
                unresolved += 0 if light.resolved else light.w.shape[1]
            estimate.close_batch()
        value, stderr = estimate.mean(samples)
        if specular:
            value[:, 0] = next_event.first_order(*about, wi, out)
        return Evaluation(value, stderr, unresolved / samples)

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        walks = self.slopes, self.material, wi, n, rng, MAX_ORDER
        return shuffled(random_walk(self.memory, *walks), self.material, rng)

    def entry_normalisation(self, wi: Array) -> float:
        """What the light that comes in was divided by, so that none is lost or made: how far it is
        from 1 is what the approximate hazard would lose or make otherwise."""
        return self.memory.entry.normalisation(float(directions(self.slopes, wi).c))
