"""Sampling by random walks, and densities that stand in for the unknown one of such samples."""

import sys
from collections.abc import Callable, Iterable

import numpy as np

from msbsdf_cli.methods.base import MethodBase, Outgoing, outgoing
from msbsdf_cli.methods.estimate import Estimate
from msbsdf_cli.methods.single import phase_density
from msbsdf_cli.methods.undersampling import undersampling_bound
from msbsdf_cli.methods.walks import sample_each
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import random_walk
from surfaces.facet import Array
from surfaces.light import Light
from surfaces.materials import Material

MULTIPLE_SHARE = 0.25
"""Share of the density that is spread over all directions for the sake of later bounces. It
biases nothing; it need only not be small where later bounces are bright."""


def sample_walk(
    slopes: Slopes, material: Material, wi: Array, n: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Directions (3, n) in which random walks leave and the energy (channels, n) they have left.

    The walk is a perfect sampler of its own expectation ([HHdD16] Section 9).
    """
    return shuffled(random_walk(slopes, material, wi, n, rng, sys.maxsize), material, rng)


def shuffled(
    lights: Iterable[Light], material: Material, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Directions (3, n) and energies (channels, n) of light that comes sorted by order, so that any
    part of it is a fair one."""
    parts = list(lights)
    w = np.concatenate([light.w for light in parts], axis=1)
    full = np.ones((material.channels, 1), w.dtype)
    weights = [
        np.broadcast_to(
            full if light.weight is None else light.weight, (len(full), light.w.shape[1])
        )
        for light in parts
    ]
    order = rng.permutation(w.shape[1])
    return w[:, order], np.concatenate(weights, axis=1)[:, order]


def broadened_pdf(slopes: Slopes, material: Material, wi: Array, wo: Array) -> Array:
    """A density (n,) for multiple importance sampling: the first bounce's, and a cosine lobe on
    each side that light can leave on, as [HHdD16] Section 9 proposes. `wi` is (3,) or (3, n)."""
    cosine = np.abs(wo[2]) / np.pi
    if not material.specular:
        return np.where(wo[2] > 0, cosine, 0)
    lobe = cosine / 2 if material.transmits else np.where(wo[2] > 0, cosine, 0)
    first = phase_density(slopes, material, wi, wo)
    return (1 - MULTIPLE_SHARE) * first + MULTIPLE_SHARE * lobe


class FollowsPaths(MethodBase):
    """Base of the methods that follow paths: these miss some, and no density of them is known."""

    def undersampling(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Array:
        return undersampling_bound(
            self.slopes, self.material, outgoing(self.slopes, wo), samples, rng
        )

    def pdf(self, wi: Array, wo: Array) -> Array:
        return broadened_pdf(self.slopes, self.material, wi, wo)

    def pdf_each(self, wi: Array, wo: Array) -> Array:
        return broadened_pdf(self.slopes, self.material, wi, wo)

    def _one_path_each(
        self,
        follow: Callable[[Array, Array, Outgoing, Estimate, np.random.Generator], None],
        wi: Array,
        out: Outgoing,
        rng: np.random.Generator,
    ) -> Array:
        """What one path from each of `wi` (3, n), which `follow` follows, sends to an outgoing
        direction of its own, all orders together, (channels, n)."""
        estimate = Estimate(self.material.channels, 0, out.n)
        follow(-wi, np.arange(out.n), out, estimate, rng)
        estimate.close_batch()
        return estimate.sums[:, 0]


class SampledByWalk(FollowsPaths):
    """Base of the methods that evaluate the random walk's own model: the walk samples it."""

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        return sample_walk(self.slopes, self.material, wi, n, rng)

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        return sample_each(self.slopes, self.material, wi, rng)
