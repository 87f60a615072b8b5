"""Surfaces that do not transmit: light stays in one half space, and heights need no grid."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.anisotropic import DiffuseGrid, MirrorGrid
from msbsdf_cli.methods.solver.isotropic import DiffuseModes, MirrorModes
from msbsdf_cli.methods.solver.nodes import Elevations
from msbsdf_cli.methods.solver.orders import Discretisation, Table, energy, tabulate
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material

ENDS = 128
"""Outgoing directions followed together."""


@dataclass(frozen=True)
class OpaqueSolution:
    """All orders of a conductor or of diffuse facets, at one resolution."""

    slopes: Slopes
    material: Material
    orders: int
    resolution: float

    def evaluate(self, wi: Array, wo: Array) -> tuple[Array, float]:
        """BSDF x cos(theta_o) from order 2 on, (channels, orders + 1, n), and the energy not
        accounted for. The first order, 0 here, needs no solution."""
        value, unresolved = self.pairs(wi[:, None], wo)
        return value[0], unresolved

    def pairs(self, wi: Array, wo: Array) -> tuple[Array, float]:
        """The same between all of `wi` (3, m) and all of `wo` (3, n), (m, channels, orders + 1, n):
        outgoing directions are followed back once for all of the incident ones."""
        channels, m, n = self.material.channels, wi.shape[1], wo.shape[1]
        value = np.zeros((m, channels, self.orders + 1, n))
        up = np.flatnonzero(wo[2] > 0)
        d = -wi
        grid, table = self._directional
        rows = [grid.rows(d[:, [i]]) for i in range(m)]
        starts = [table.extend(row) for row in rows]
        for part in (up[i : i + ENDS] for i in range(0, up.size, ENDS)):
            w = wo[:, part]
            ends, which = grid.distinct(w)
            end_rows = grid.rows(ends)
            end_series = table.extend(end_rows)
            for i, (row, start) in enumerate(zip(rows, starts, strict=True)):
                later = table.connect(row, start, end_rows, end_series)
                value[i, :, 1:, part] = np.moveaxis(
                    np.sum(later[..., which] * grid.parting(d[:, [i]], w), axis=2), -1, 0
                ).swapaxes(1, 2)
        return value * np.maximum(wo[2], 0), max(start.unresolved for start in starts)

    def energy(self, wi: Array) -> Array:
        """Energy (channels, sides, orders + 1) that leaves in each order for `wi` (3,)."""
        grid, table = self._energetic
        reflected = energy(table.kernel, table.extend(grid.rows(wi[:, None])))[..., 0]
        first = grid.first_order(wi)
        if first is not None:
            reflected[:, 0] = first
        return np.stack([reflected, np.zeros_like(reflected)], axis=1)

    @cached_property
    def _directional(self) -> tuple[Discretisation, Table]:
        grid = self._discretise(energy_only=False)
        return grid, tabulate(grid.kernel(), self.orders)

    @cached_property
    def _energetic(self) -> tuple[Discretisation, Table]:
        grid = self._discretise(energy_only=True)
        return grid, tabulate(grid.kernel(), self.orders)

    def _discretise(self, energy_only: bool) -> Discretisation:
        """As fine as the lobes are narrow: as wide as the roughness in elevation, and narrower
        still in azimuth towards grazing angles; what a diffuse facet scatters is wide. On very
        rough surfaces all is decided near grazing angles. A grid of directions has to afford
        less in azimuth than Fourier modes do."""
        alpha, wide = sorted(self.slopes.alpha)
        diffuse = not self.material.specular
        if alpha == wide:
            elevations = Elevations(
                round(self.resolution * (20 + 2.4 / alpha + 10 * np.sqrt(alpha)))
            )
            modes = round(self.resolution * (64 if diffuse else 40 + 40 / alpha))
            modes = 1 if energy_only else modes
            kind = DiffuseModes if diffuse else MirrorModes
            return kind(self.slopes, self.material, elevations, modes)
        elevations = Elevations(round(self.resolution * (14 + 1.2 / alpha + 6 * np.sqrt(wide))))
        lobes = 4 + 1.4 * wide / alpha if energy_only or diffuse else 8 + wide / alpha + 1 / alpha
        quarter, blocks = round(self.resolution * lobes), 1 if energy_only else 4
        grid = DiffuseGrid if diffuse else MirrorGrid
        return grid(self.slopes, elevations, quarter, blocks, self.material)
