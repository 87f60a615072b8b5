"""Height and slope parameters of ISO 25178-2, and the anisotropy of slopes, with error bars."""

import numpy as np

from surfaces.describe.gaussian import errors_of_gaussian, helped
from surfaces.describe.quantities import Quantity, propagated
from surfaces.describe.spread import block_means, covariance
from surfaces.facet import Array
from surfaces.patch import Patch

UNDETERMINED = np.pi / np.sqrt(12)
"""Standard deviation of a direction of which nothing is known."""


def height_parameters(patch: Patch, unit: str) -> list[Quantity]:
    """Sa, Sq, Ssk and Sku."""
    h = patch.heights - patch.heights.mean()
    scale = float(h.std())
    h = h / scale
    blocks = np.stack([block_means(np.abs(h)), *(block_means(h**power) for power in (1, 2, 3, 4))])

    def parameters(m: Array) -> Array:
        # Central moments, since the mean is known no better than the rest.
        absolute, mean, second, third, fourth = m
        variance = second - mean**2
        skew = (third - 3 * mean * second + 2 * mean**3) / variance**1.5
        kurtosis = fourth - 4 * mean * third + 6 * mean**2 * second - 3 * mean**4
        return np.array([absolute, np.sqrt(variance), skew, kurtosis / variance**2])

    _, error = propagated(parameters, blocks.mean(axis=(1, 2)), covariance(blocks))
    exact = parameters(np.array([np.abs(h).mean(), *((h**power).mean() for power in (1, 2, 3, 4))]))
    error[2:] = helped(error[2:], exact[2:], errors_of_gaussian(h, patch.periodic))
    sizes, units = (scale, scale, 1, 1), (unit, unit, "", "")
    names = ("sa", "sq", "ssk", "sku")
    return [
        Quantity(name, float(v * size), float(e * size), u)
        for name, v, e, size, u in zip(names, exact, error, sizes, units, strict=True)
    ]


SLOPES = ("sdq", "alpha_x", "alpha_y", "slope_correlation", "anisotropy", "direction_rad")
"""What is made of the variances of slopes."""


def slope_parameters(patch: Patch) -> list[Quantity]:
    """Sdq, the roughness of Beckmann's distribution along the axes of the grid, and anisotropy.

    `anisotropy` is the roughness in the direction of the steepest slopes over that across, and
    `direction_rad` its azimuth.
    """
    x, y = patch.slopes
    products = [x * x, y * y, x * y]
    blocks = np.stack([block_means(p) for p in products])
    mean = np.array([p.mean() for p in products])
    value, error = propagated(_of_variances, mean, covariance(blocks))
    error[-1] = min(error[-1], UNDETERMINED)
    notes = ["root mean square slope", *("sqrt(2) times the standard deviation of slopes",) * 2]
    notes += ["of slopes along x and along y", "of roughness, in principal directions"]
    notes += ["azimuth of the steepest slopes, from x towards y"]
    return [
        Quantity(name, float(v), float(e), "rad" if name.endswith("_rad") else "", note)
        for name, v, e, note in zip(SLOPES, value, error, notes, strict=True)
    ]


def _of_variances(m: Array) -> Array:
    xx, yy, xy = m
    middle, apart = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    # Grooves have no slopes along them.
    least = np.finfo(float).tiny
    return np.array(
        [
            np.sqrt(xx + yy),
            np.sqrt(2 * xx),
            np.sqrt(2 * yy),
            xy / np.sqrt(max(xx * yy, least)),
            np.sqrt((middle + apart) / max(middle - apart, least)),
            np.arctan2(2 * xy, xx - yy) / 2,
        ]
    )
