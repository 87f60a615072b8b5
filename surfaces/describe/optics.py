"""Where geometrical optics, which the tracing of rays is, does not hold for a surface."""

import numpy as np

from surfaces.patch import Patch

BENDS = 4 * np.pi
"""Radii of curvature, over the wavelength, from which a facet reflects as its tangent plane does:
the criterion of Kirchhoff, P. Beckmann & A. Spizzichino, The Scattering of Electromagnetic Waves
from Rough Surfaces, 1963, section 3.1."""

DEEP = 4.0
"""A standard deviation of heights below the wavelength over that leaves a mirror image (Rayleigh's
criterion), which geometrical optics does not know of."""


def optics_warnings(patch: Patch, correlation_length: float, wavelength: float) -> list[str]:
    """Sentences on where the surface is too fine or too flat for light of a wavelength, in the
    unit of the steps. Raises ValueError for a wavelength that is none."""
    if not 0 < wavelength < np.inf:
        raise ValueError(f"the wavelength is {wavelength}: a finite number above 0 is wanted.")
    sentences, end = [], "geometrical optics does not hold"
    if correlation_length < wavelength:
        sentences.append(
            f"the correlation length is {correlation_length / wavelength:.2g} wavelengths, and "
            f"below one {end}: light is diffracted."
        )
    if (radius := curvature_radius(patch)) < wavelength / BENDS:
        sentences.append(
            f"facets bend over {radius / wavelength:.2g} wavelengths, and below "
            f"{1 / BENDS:.2g} they do not reflect as planes: {end}."
        )
    depth = float(patch.heights.std())
    if depth < wavelength / DEEP:
        sentences.append(
            f"heights deviate by {depth / wavelength:.2g} wavelengths, and below {1 / DEEP:.2g} a "
            f"mirror image is left: {end}."
        )
    return sentences


def curvature_radius(patch: Patch) -> float:
    """Over the root mean square of second derivatives of the heights, along x and y together."""
    parts = [
        (np.diff(patch.heights, 2, axis=axis) ** 2).mean() / patch.step[axis] ** 4
        for axis in (0, 1)
    ]
    curvature = float(np.sqrt(np.mean(parts)))
    return 1 / curvature if curvature else float("inf")
