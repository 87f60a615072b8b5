"""How the heights of a random surface are distributed: Gaussian, or skewed to ridges or pits.

Skewed heights are the exponential of a Gaussian field g, h = (exp(s g) - exp(s^2 / 2)) / sd: their
distribution is log-normal, of mean 0 and variance 1 (J. Aitchison & J. A. C. Brown, The Lognormal
Distribution, 1957). Ridges stand out of a plain; pits are ridges upside down, -h(-g).

Slopes s exp(s g) grad g / sd are steeper the further from the plain: no longer Gaussian, nor
independent of heights. Their variance is s^2 / (1 - exp(-s^2)) times that of the Gaussian field;
the surface is stretched by the root of it, so that a roughness alpha still is slopes of variance
alpha^2 / 2.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from surfaces.facet import Array
from surfaces.spectrum import Spectrum

LEAST, MOST = 0.01, 4.0
"""Skewness: below, heights are Gaussian; above, a few peaks have nearly all of the slopes."""

NODES = 16
"""Of heights, in means over them: good to 1e-6 of a slope's absolute value, or better."""

SIGNS = {"ridges": 1.0, "pits": -1.0}


@dataclass(frozen=True)
class Marginal:
    """Heights of this skewness; 0 is Gaussian. Raises ValueError for what is out of range."""

    skewness: float = 0.0

    def __post_init__(self) -> None:
        if self.skewness and not LEAST <= abs(self.skewness) <= MOST:
            raise ValueError(
                f"the skewness is {abs(self.skewness):g}: a number from {LEAST:g} to {MOST:g} is "
                "wanted."
            )

    @cached_property
    def name(self) -> str:
        """As on the command line."""
        if not self.skewness:
            return "gaussian"
        return f"{'ridges' if self.skewness > 0 else 'pits'}:{abs(self.skewness):g}"

    @cached_property
    def _sign(self) -> float:
        return float(np.sign(self.skewness))

    @cached_property
    def _s2(self) -> float:
        """s^2: exp(s^2) is the root w of (w + 2) sqrt(w - 1) = skewness."""
        half = self.skewness**2 / 2
        root = np.cbrt(1 + half + np.sqrt(half * (2 + half)))
        return float(np.log(root + 1 / root - 1))

    def heights(self, g: Array) -> Array:
        """Heights where the Gaussian field, of variance 1, is `g`."""
        if not self.skewness:
            return g
        s, sign = np.sqrt(self._s2), self._sign
        above = np.exp(sign * s * g - self._s2 / 2) - 1
        return np.asarray(sign * above / np.sqrt(np.expm1(self._s2)))

    def gaussian(self, h: Array | float) -> Array:
        """The Gaussian field where the heights are `h`; infinite where they never are."""
        if not self.skewness:
            return np.asarray(h, float)
        above = 1 + self._sign * np.asarray(h) * np.sqrt(np.expm1(self._s2))
        with np.errstate(divide="ignore"):
            g = (np.log(np.maximum(above, 0)) + self._s2 / 2) / np.sqrt(self._s2)
        return np.asarray(self._sign * g)

    def half_structure(self, variance: float, apart: Array | float) -> Array:
        """Half the mean square of what heights at two points differ by, where those of the Gaussian
        field have a variance and differ by twice `apart` in the mean square."""
        if not self.skewness:
            return np.asarray(apart)
        s2 = self._s2
        grown = np.exp(s2 * (2 * variance - 1 - np.asarray(apart)))
        return np.asarray(grown * np.expm1(s2 * np.asarray(apart)) / np.expm1(s2))

    @cached_property
    def slope_variance(self) -> float:
        """Of the heights, over that of the Gaussian field."""
        return self._s2 / -float(np.expm1(-self._s2)) if self.skewness else 1.0

    def roughness(self) -> list[tuple[float, float]]:
        """Roughness over that of all heights together, where these have one value, and its share of
        them: slopes are Gaussian given the height, steeper the further from the plain."""
        if not self.skewness:
            return [(1.0, 1.0)]
        g, weight = np.polynomial.hermite_e.hermegauss(NODES)
        scale = np.exp(np.sqrt(self._s2) * g - self._s2)
        return list(zip(scale.tolist(), (weight / weight.sum()).tolist(), strict=True))

    def correlation_length(self, spectrum: Spectrum) -> float:
        """Distance at which heights correlate by 1/e, in the unit of the Gaussian field."""
        if not self.skewness:
            return spectrum.correlation_length
        return spectrum.distance(float(np.log1p(np.expm1(self._s2) / np.e)) / self._s2)


def marginal(text: str) -> Marginal:
    """A distribution of heights by name: `gaussian`, `ridges` or `pits`, of skewness 1 or, as
    `ridges:S`, of S. Raises ValueError for what is none."""
    name, colon, value = text.partition(":")
    if text == "gaussian":
        return GAUSSIAN_HEIGHTS
    try:
        skewness = float(value) if colon else 1.0
    except ValueError:
        skewness = float("nan")
    if name not in SIGNS or skewness != skewness:
        raise ValueError(
            f"{text!r} is not a distribution of heights: gaussian, ridges, pits, or one of the "
            "latter with its skewness, such as ridges:1.5."
        )
    if not skewness > 0:
        raise ValueError(
            f"the skewness is {skewness:g}: a number from {LEAST:g} to {MOST:g} is wanted; of "
            "ridges it is positive by name, and of pits negative."
        )
    return Marginal(SIGNS[name] * skewness)


GAUSSIAN_HEIGHTS = Marginal()
