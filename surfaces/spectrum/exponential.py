"""The exponential autocorrelation exp(-r): as of ground and blasted surfaces, with bumps on bumps.

Its slopes have no finite variance: the spectrum ends at `surfaces.spectrum.matern.BAND` times the
inverse correlation length.
"""

from dataclasses import dataclass

from surfaces.spectrum.matern import Matern


@dataclass(frozen=True)
class Exponential(Matern):
    """Matern's of smoothness 1/2."""

    nu: float = 0.5

    @property
    def name(self) -> str:
        return "exponential"
