"""Self-affine surfaces: a power law between a roll-off and a shortest wave.

The spectrum is q^(-2 - 2 H) from the roll-off q = 1 to q = `BAND`, and constant below (B. N. J.
Persson et al., J. Phys.: Condens. Matter 17, 2005, R1); H is Hurst's exponent.
"""

from dataclasses import dataclass

import numpy as np

from surfaces.facet import Array
from surfaces.spectrum._spectrum import Spectrum
from surfaces.spectrum.matern import BAND


@dataclass(frozen=True)
class PowerLaw(Spectrum):
    """Of Hurst's exponent above 0 and below 1. Raises ValueError for any other."""

    hurst: float

    def __post_init__(self) -> None:
        if not 0 < self.hurst < 1:
            raise ValueError(f"H is {self.hurst:g}: a number above 0 and below 1 is wanted.")

    @property
    def name(self) -> str:
        return f"power-law:{self.hurst:g}"

    def shape(self, q: Array) -> Array:
        return np.maximum(q, 1) ** (-2 - 2 * self.hurst)

    @property
    def knots(self) -> tuple[float, ...]:
        return 1.0, BAND
