"""Light that leaves a surface, with standard errors, whoever it comes from: what is compared and
drawn."""

from dataclasses import dataclass, field

import numpy as np

from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, lobe_axes
from msbsdf_cli.statistics.tally import REST, SIDES, Estimate, Tally
from surfaces.facet import Array


def order_names(orders: int) -> list[str]:
    """`1`, `2`, ..., `K`, `>K`."""
    return [*map(str, range(1, orders + 1)), f">{orders}"]


@dataclass(frozen=True)
class Lobes:
    """Energies and lobes for each incident angle; energies are fractions of the incident one."""

    label: str
    """`simulate`, `walk` or another method."""
    theta: tuple[float, ...]
    """Incident polar angles in radians."""
    phi: float
    orders: int
    transmits: bool
    energy: Estimate
    """(theta, order, side), orders 1 to `orders` and all the later ones."""
    bins: Estimate
    """Energies in the bins of lobes, (theta, order, side, bin)."""
    rest: dict[str, Estimate] = field(default_factory=dict)
    """`absorbed` and `unresolved`, (theta,) each, where they are known."""
    groups: Array | None = None
    """Energies of independent groups of surfaces, (theta, group, order, side, merged bin)."""
    free_paths: FreePaths | None = None

    @property
    def names(self) -> list[str]:
        """Names of the orders."""
        return order_names(self.orders)

    @property
    def sides(self) -> tuple[str, ...]:
        """Names of the sides that light leaves on."""
        return SIDES[: 1 + self.transmits]

    @property
    def density(self) -> Array:
        """Densities per steradian, (theta, order, side, polar angle, azimuth)."""
        return _per_steradian(self.bins.value)

    @property
    def density_stderr(self) -> Array:
        """Standard errors of `density`."""
        return _per_steradian(self.bins.stderr)


def _per_steradian(bins: Array) -> Array:
    density = bins.reshape(*bins.shape[:-1], THETA_BINS, PHI_BINS) / lobe_axes()[2][:, None]
    return np.asarray(density)


def lobes_of(
    label: str,
    theta: tuple[float, ...],
    phi: float,
    transmits: bool,
    tallies: list[Tally],
    groups: Array | None = None,
    free_paths: FreePaths | None = None,
) -> Lobes:
    """The light in tallies, one for each incident angle."""

    figures = [tally.figures() for tally in tallies]

    def estimate(name: str) -> Estimate:
        both = (
            np.array([tally.views(row)[name] for tally, row in zip(tallies, rows, strict=True)])
            for rows in zip(*figures, strict=True)
        )
        value, variance = both
        return Estimate(value, np.sqrt(variance))

    rest = {name: estimate(name) for name in REST}
    light = estimate("energy"), estimate("lobe")
    return Lobes(label, theta, phi, tallies[0].orders, transmits, *light, rest, groups, free_paths)
