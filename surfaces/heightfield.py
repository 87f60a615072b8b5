"""Random heightfields of Beckmann slopes: periodic, Gaussian, of unit height variance.

All is measured in correlation lengths, in which the autocorrelation of the heights is
exp(-(u^2 + v^2)). A surface of roughness alpha_x, alpha_y is such a field stretched to correlation
lengths 2 / alpha_x and 2 / alpha_y (Heitz 2015, Generating procedural Beckmann surfaces): its
slopes are then Gaussian, of variance alpha^2 / 2. So one field serves every roughness.
"""

import numpy as np

from surfaces.facet import Array

K_MAX = 16.0
"""Wave numbers, per correlation length, beyond which no wave is laid: exp(-K_MAX^2 / 4), the power
spectrum there, is below the rounding of a double."""


def lattice(extent: float) -> Array:
    """Wave numbers of the lattice on which waves have the period `extent` (one axis)."""
    m = int(np.ceil(K_MAX * extent / (2 * np.pi)))
    return 2 * np.pi / extent * np.arange(-m, m + 1)


def all_waves(extent: float, rng: np.random.Generator) -> Array:
    """Complex amplitudes (k, k) of every wave of the lattice, with random phases.

    The amplitudes are those of the power spectrum exp(-k^2 / 4) / (4 pi), the phases those of white
    noise. So the variances of heights and slopes over one period are the expected ones in every
    realisation, and only the shape of the surface is random.
    """
    k = lattice(extent)
    power = np.exp(-(k[:, None] ** 2 + k**2) / 4) * np.pi / extent**2
    noise = rng.standard_normal(power.shape) + 1j * rng.standard_normal(power.shape)
    noise += np.conj(noise[::-1, ::-1])
    centre = len(k) // 2
    offset = noise[centre, centre].real / 2
    noise /= np.abs(noise)
    # The lattice's constant wave has no phase: it is a Gaussian offset of the whole period.
    noise[centre, centre] = offset
    return np.sqrt(power) * noise


def some_waves(extent: float, waves: int, rng: np.random.Generator) -> Array:
    """Complex amplitudes (k, k) of `waves` equal cosines of random phase (Heitz 2015).

    Wave vectors come from the Gaussian on the lattice, so the field is periodic and has, in the
    mean over realisations, the same statistics as with all the waves.
    """
    k = lattice(extent)
    weight = np.exp(-(k**2) / 4)
    weight /= weight.sum()
    i, j = rng.choice(len(k), (2, waves), p=weight)
    amplitudes = np.zeros((len(k), len(k)), complex)
    phase = np.exp(2j * np.pi * rng.random(waves))
    np.add.at(amplitudes, (i, j), np.sqrt(0.5 / waves) * phase)
    return amplitudes + np.conj(amplitudes[::-1, ::-1])


def synthesise(amplitudes: Array, extent: float, cells: int) -> Array:
    """Heights (n, n) on a grid of `cells` points a correlation length, n = extent x cells.

    exp(i k u) factorises over the axes, so the sum over all waves is two matrix products, and the
    same amplitudes give the same field on any grid.
    """
    k = lattice(extent)
    n = round(extent * cells)
    half = len(k) // 2
    u = np.arange(n) / cells
    waves_u = np.exp(1j * np.outer(u, k))
    # The field is real: waves k and -k are conjugate, and half of them suffice along one axis.
    waves_v = np.exp(1j * np.outer(k[half:], u))
    waves_v[1:] *= 2
    return ((waves_u @ amplitudes[:, half:]) @ waves_v).real
