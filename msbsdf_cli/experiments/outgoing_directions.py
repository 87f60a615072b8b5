"""Outgoing directions over which values are summed to energies."""

import numpy as np

from msbsdf_cli.methods.single import Single, phase_density
from surfaces.facet import Array, unit_circle


def outgoing_directions(
    single: Single, wi: Array, number: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Outgoing directions (3, number) and 1 / (number / 2 times their density) (number,): half of
    them from cosine lobes on each side that light leaves on, half from the first bounce; 0 where
    that one does not leave."""
    n = number // 2
    cos_phi, sin_phi = unit_circle(n, rng)
    # Strata: each n-th of the squared radius once.
    radius2 = (rng.permutation(n) + rng.random(n)) / n
    sides = 2 if single.material.transmits else 1
    z = np.sqrt(1 - radius2) * np.where(np.arange(n) % sides == 1, -1, 1)
    lobe = np.stack([np.sqrt(radius2) * cos_phi, np.sqrt(radius2) * sin_phi, z])
    bounced, weight = single.sample(wi, n, rng)
    leaves = np.append(np.ones(n, bool), weight[0] > 0)
    wo = np.hstack([lobe, np.where(leaves[n:], bounced, lobe)])
    density = phase_density(single.slopes, single.material, wi, wo)
    density += np.abs(wo[2]) / np.pi / sides
    return wo, leaves / (n * density)
