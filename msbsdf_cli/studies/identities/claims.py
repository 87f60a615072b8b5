"""What the methods claim of themselves: not every method is to fulfil every identity."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Claims:
    """The claims of one method."""

    energy: bool
    """Whether all light leaves a lossless surface; else only the first order does."""
    reciprocal: bool
    correlated: bool = True
    """Whether the first order has height-correlated masking and shadowing."""
    table_error: float = 0.0
    """Known error of energies."""
    table_error_dielectric: float = 0.0
    because: str = ""

    def slack(self, material: str) -> float:
        """Known error of energies for a material."""
        return self.table_error_dielectric if material == "dielectric" else self.table_error


CLAIMS = {
    "single": Claims(energy=False, reciprocal=True),
    "walk": Claims(energy=True, reciprocal=True),
    "walk-low-variance": Claims(energy=True, reciprocal=True),
    "position-free-uncorrelated": Claims(energy=True, reciprocal=True, correlated=False),
    "position-free-correlated": Claims(energy=True, reciprocal=False),
    "exact": Claims(energy=True, reciprocal=True),
    "energy-compensated": Claims(
        energy=True,
        reciprocal=True,
        table_error=1e-3,
        table_error_dielectric=1e-2,
        because="table of albedos",
    ),
}
"""By name, see `msbsdf_cli.methods.registry`; a method without an entry is not measured."""
