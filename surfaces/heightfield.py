"""Random heightfields: periodic, of unit height variance; Gaussian ones have Beckmann's slopes.

The unit of length is such that slopes have the variance 2 along each axis; with the Gaussian
autocorrelation exp(-(u^2 + v^2)) it is the correlation length. A surface of roughness alpha_x,
alpha_y is such a field stretched by 2 / alpha_x and 2 / alpha_y (Heitz 2015, Generating procedural
Beckmann surfaces): its slopes are then Gaussian, of variance alpha^2 / 2, whatever the spectrum. So
one field serves every roughness. Heights of another distribution (`surfaces.marginal`) are made of
a Gaussian field, and are stretched so that their slopes have that variance too.
"""

from functools import cache

import numpy as np

from surfaces.facet import Array
from surfaces.marginal import GAUSSIAN_HEIGHTS, Marginal
from surfaces.spectrum import GAUSSIAN, Spectrum


def lattice(extent: float, spectrum: Spectrum = GAUSSIAN) -> Array:
    """Wave numbers of the lattice on which waves have the period `extent` (one axis)."""
    m = int(np.ceil(spectrum.k_max * extent / (2 * np.pi)))
    return 2 * np.pi / extent * np.arange(-m, m + 1)


def powers(extent: float, spectrum: Spectrum = GAUSSIAN) -> Array:
    """Power (k, k) of every wave of the lattice, which gives slopes the variance 2 exactly.

    The heights' variance is 1 as far as the period is long against the longest waves.
    """
    k = lattice(extent, spectrum)
    power = spectrum.power(np.hypot(k[:, None], k))
    return np.asarray(power * (2 / (k**2 @ power).sum()))


@cache
def shortened(
    cells: int,
    extent: float,
    spectrum: Spectrum = GAUSSIAN,
    marginal: Marginal = GAUSSIAN_HEIGHTS,
) -> float:
    """Cells a unit of length of a mesh whose facets have the slope variance of the field.

    A flat facet spans one cell, and its slope is the mean over it, low in variance by what the
    shorter waves have. The surface is shortened by the root of that, so that the facets, which is
    what light meets, have the variance alpha^2 / 2 exactly.
    """
    k, power = lattice(extent, spectrum), powers(extent, spectrum).sum(axis=1)
    apart = 2 * np.sin(k / (2 * cells)) ** 2 @ power
    return float(1 / np.sqrt(marginal.half_structure(float(power.sum()), apart)))


def all_waves(extent: float, rng: np.random.Generator, spectrum: Spectrum = GAUSSIAN) -> Array:
    """Complex amplitudes (k, k) of every wave of the lattice, with random phases.

    The amplitudes are those of the power spectrum, the phases those of white noise. So the
    variances of heights and slopes over one period are the expected ones in every realisation, and
    only the shape of the surface is random.
    """
    power = powers(extent, spectrum)
    noise = rng.standard_normal(power.shape) + 1j * rng.standard_normal(power.shape)
    noise += np.conj(noise[::-1, ::-1])
    centre = len(power) // 2
    offset = noise[centre, centre].real / 2
    noise /= np.abs(noise)
    # The lattice's constant wave has no phase: it is a Gaussian offset of the whole period.
    noise[centre, centre] = offset
    return np.sqrt(power) * noise


def some_waves(
    extent: float, waves: int, rng: np.random.Generator, spectrum: Spectrum = GAUSSIAN
) -> Array:
    """Complex amplitudes (k, k) of `waves` equal cosines of random phase (Heitz 2015).

    Wave vectors come from the spectrum on the lattice, so the field is periodic and has, in the
    mean over realisations, the same statistics as with all the waves.
    """
    power = powers(extent, spectrum)
    total = power.sum()
    chosen = rng.choice(power.size, waves, p=(power / total).ravel())
    amplitudes = np.zeros(power.shape, complex)
    phase = np.exp(2j * np.pi * rng.random(waves))
    np.add.at(amplitudes.reshape(-1), chosen, np.sqrt(0.5 * total / waves) * phase)
    return amplitudes + np.conj(amplitudes[::-1, ::-1])


def synthesise(amplitudes: Array, extent: float, cells: int) -> Array:
    """Heights (n, n) on a grid of `cells` points a unit of length, n = extent x cells.

    exp(i k u) factorises over the axes, so the sum over all waves is two matrix products, and the
    same amplitudes give the same field on any grid.
    """
    half = len(amplitudes) // 2
    k = 2 * np.pi / extent * np.arange(-half, half + 1)
    n = round(extent * cells)
    u = np.arange(n) / cells
    waves_u = np.exp(1j * np.outer(u, k))
    # The field is real: waves k and -k are conjugate, and half of them suffice along one axis.
    waves_v = np.exp(1j * np.outer(k[half:], u))
    waves_v[1:] *= 2
    return ((waves_u @ amplitudes[:, half:]) @ waves_v).real
