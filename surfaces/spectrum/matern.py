"""Matern's autocorrelations: from rough below a smoothness of 1 to Gaussian far above.

The spectrum is (1 + q^2)^(-1 - nu), q the wave number times a length (B. Matern, Spatial Variation,
1960). Up to nu = 1 slopes would have no finite variance, and above it is in ever shorter waves: the
spectrum ends at q = `BAND`.
"""

from dataclasses import dataclass

from surfaces.facet import Array
from surfaces.spectrum._spectrum import Spectrum

BAND = 16.0
"""Longest over shortest size of bumps: what a mesh can hold that is to have many of the longest."""

ROUNDING = 2.0**53

LEAST, MOST = 0.1, 50.0
"""Smoothness: below, nearly all is in the shortest waves; above, it is the Gaussian spectrum."""


@dataclass(frozen=True)
class Matern(Spectrum):
    """Of the smoothness `nu`, from 0.1 to 50. Raises ValueError for any other."""

    nu: float

    def __post_init__(self) -> None:
        if not LEAST <= self.nu <= MOST:
            raise ValueError(f"nu is {self.nu:g}: a number from {LEAST:g} to {MOST:g} is wanted.")

    @property
    def name(self) -> str:
        return f"matern:{self.nu:g}"

    def shape(self, q: Array) -> Array:
        return (1 + q * q) ** (-1 - self.nu)

    @property
    def knots(self) -> tuple[float, ...]:
        # Far above 1 the spectrum ends by itself, where it is below the rounding of a double.
        end = min(BAND, float(ROUNDING ** (0.5 / (1 + self.nu))))
        # The corner at q = 1 has nodes of its own.
        return (2.0, end) if end > 2 else (end,)
