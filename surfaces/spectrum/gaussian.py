"""The Gaussian autocorrelation exp(-r^2): smooth bumps of one size."""

from dataclasses import dataclass

import numpy as np

from surfaces.facet import Array
from surfaces.spectrum._spectrum import Spectrum

END = 16.0
"""Wave number at which exp(-k^2 / 4) is below the rounding of a double."""


@dataclass(frozen=True)
class Gaussian(Spectrum):
    """exp(-k^2 / 4); the field's unit of length is its correlation length."""

    @property
    def name(self) -> str:
        return "gaussian"

    def shape(self, q: Array) -> Array:
        return np.exp(-(q * q) / 4)

    @property
    def knots(self) -> tuple[float, ...]:
        return (END,)
