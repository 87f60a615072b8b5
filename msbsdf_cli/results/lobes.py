"""Light that leaves a surface, with standard errors, whoever it comes from: what is compared and
drawn."""

import math
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


def plane_of_incidence(
    lobes: Lobes, row: int, orders: slice, side: int
) -> tuple[Array, Array, Array]:
    """Angles in degrees, densities and standard errors in the plane of incidence, of the sum over
    some orders."""
    polar, azimuth, _ = lobe_axes()
    backward, forward = (_window(polar, azimuth, lobes.phi + turn) for turn in (0, np.pi))
    values = lobes.density[row, orders, side].sum(axis=0)
    errors = np.sqrt((lobes.density_stderr[row, orders, side] ** 2).sum(axis=0))
    halves = [(values * window).sum(axis=1) for window in (backward, forward)]
    # Errors of bins outside may be infinite.
    squares = [
        (np.where(window > 0, errors, 0) ** 2 * window**2).sum(axis=1)
        for window in (backward, forward)
    ]
    return (
        np.degrees(np.concatenate([-polar[::-1], polar])),
        np.concatenate([halves[0][::-1], halves[1]]),
        np.sqrt(np.concatenate([squares[0][::-1], squares[1]])),
    )


def _window(polar: Array, azimuth: Array, phi: float) -> Array:
    """Weights (polar, azimuth) of the bins near azimuth `phi`: a bin wide, and towards the pole,
    where bins are slivers, as wide as a bin is high."""
    half_bin = np.pi / 4 / THETA_BINS
    reach = np.maximum(np.pi / PHI_BINS, half_bin / np.sin(polar))
    apart = np.abs(np.angle(np.exp(1j * (azimuth - math.remainder(phi, 2 * math.pi)))))
    near = apart[None] <= reach[:, None] * (1 + 1e-9)
    return near / near.sum(axis=1, keepdims=True)
