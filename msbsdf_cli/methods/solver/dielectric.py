"""Surfaces that transmit: the BSDF of a dielectric."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.heights import Heights
from msbsdf_cli.methods.solver.interpolation import InterpolatedGrid, InterpolatedModes
from msbsdf_cli.methods.solver.nodes import SplitElevations, abscissa
from msbsdf_cli.methods.solver.opaque import ENDS
from msbsdf_cli.methods.solver.second_order import Arrival, SecondOrder
from msbsdf_cli.methods.solver.slope_quadrature import SlopeQuadrature
from msbsdf_cli.methods.solver.two_sides import Flights, TwoSides
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material

PANEL = 24
"""Facets between two neighbouring edges, along either axis, for energies to 1e-6."""


@dataclass(frozen=True)
class Start:
    """Light from one direction."""

    d: Array
    """Direction of travel (3,)."""
    flights: Flights
    arrival: Arrival


@dataclass(frozen=True)
class DielectricSolution:
    """All orders of a dielectric interface, at one resolution."""

    slopes: Slopes
    material: Material
    orders: int
    resolution: float
    _last: dict[bytes, list[Start]] = field(default_factory=dict, compare=False, repr=False)
    """What came from the incident directions that were asked for last."""

    def evaluate(self, wi: Array, wo: Array) -> tuple[Array, float]:
        """BSDF x |cos(theta_o)| from order 2 on, (1, orders + 1, n), and the energy not accounted
        for. The first order, 0 here, is in closed form."""
        value, unresolved = self.pairs(wi[:, None], wo)
        return value[0], unresolved

    def pairs(self, wi: Array, wo: Array, some: int | None = None) -> tuple[Array, float]:
        """The same between all of `wi` (3, m) and all of `wo` (3, n), (m, 1, orders + 1, n):
        outgoing directions are followed back once for all of the incident ones, and these are kept
        for the next call, also those beyond the first `some` that are asked for."""
        starts = self._starts(wi)[:some]
        value = np.zeros((len(starts), self.orders + 1, wo.shape[1]))
        grid, second = self._directional, self._second
        for side, sign in ((0, 1), (1, -1)):
            lanes = np.flatnonzero(sign * wo[2] > 0)
            for part in (lanes[i : i + ENDS] for i in range(0, lanes.size, ENDS)):
                # Inside, light is point-reflected.
                w = sign * wo[:, part]
                ends, which = grid.directions.distinct(w)
                each = grid.emerge([start.flights for start in starts], ends, side)
                for k, (start, later) in enumerate(zip(starts, each, strict=True)):
                    factors = grid.directions.parting(start.d[:, None], w)
                    summed = np.sum(later[..., which] * factors, axis=1)
                    # Two facets are the last row, if no later one is asked for.
                    value[k, min(self.orders, 2) :, part] = summed.T
                arrivals = [start.arrival for start in starts]
                for i in range(ends.shape[1]):
                    same = which == i
                    value[:, 1, part[same]] += second.emerge(arrivals, w[:, same], ends[:, i], side)
        return value[:, None], max(start.flights.unresolved for start in starts)

    def _starts(self, wi: Array) -> list[Start]:
        key = wi.tobytes()
        if key not in self._last:
            grid, second = self._directional, self._second
            self._last.clear()
            self._last[key] = [
                Start(-w, grid.follow(w, self.orders), second.arrive(w)) for w in wi.T
            ]
        return self._last[key]

    def energy(self, wi: Array) -> Array:
        """Energy (1, sides, orders + 1) that leaves in each order for `wi` (3,)."""
        grid = self._energetic
        return grid.energy(grid.follow(wi, self.orders))[None]

    @cached_property
    def _directional(self) -> TwoSides:
        return self._discretise(energy_only=False)

    @cached_property
    def _second(self) -> SecondOrder:
        grid = self._directional
        facets = SlopeQuadrature(self.slopes, 2 * grid.facets.panel, half=False)
        return SecondOrder(
            self.slopes, self.material, grid.directions.elevations, grid.heights, facets
        )

    @cached_property
    def _energetic(self) -> TwoSides:
        return self._discretise(energy_only=True)

    def _discretise(self, energy_only: bool) -> TwoSides:
        """As fine as the lobes are narrow, as for a half space."""
        alpha, wide = sorted(self.slopes.alpha)
        directions: InterpolatedModes | InterpolatedGrid
        if alpha == wide:
            elevations = self._elevations(16 + 4 / alpha + 10 * np.sqrt(alpha))
            modes = 1 if energy_only else round(self.resolution * (16 + 16 / alpha))
            directions = InterpolatedModes(elevations, modes)
        else:
            elevations = self._elevations(14 + 0.4 / alpha + 2 * np.sqrt(wide))
            lobes = 10 + 1.4 * wide / alpha if energy_only else 8 + wide / alpha + 1 / alpha
            blocks = 1 if energy_only else 4
            directions = InterpolatedGrid(
                self.slopes, elevations, round(self.resolution * lobes), blocks
            )
        # Of a grid there are many more rows, whose errors are of either sign.
        panel = PANEL if alpha == wide else 0.6 * PANEL
        facets = SlopeQuadrature(self.slopes, round(self.resolution * panel), directions.half)
        heights = Heights(round(self.resolution * 20))
        return TwoSides(self.slopes, self.material, directions, heights, facets)

    def _elevations(self, n: float) -> SplitElevations:
        """What steep facets show of total reflection ends where a direction is as far from the
        mean plane as the critical angle is from the normal: a kink, weak unless many are steep."""
        ior = self.material.ior
        split = float(abscissa(np.arcsin(min(ior, 1 / ior))))
        shares = np.sqrt([split, 1 - split])
        below, above = np.ceil(self.resolution * n * shares / shares.sum()).astype(int)
        return SplitElevations(int(below), max(int(above), 1), split)
