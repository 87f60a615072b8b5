"""Slices of outgoing directions, and the table of values along them."""

import math
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.evaluate import Values
from msbsdf_cli.results.files import Table
from msbsdf_cli.results.lobes import order_names
from msbsdf_cli.scene import Scene
from surfaces.facet import Array


@dataclass(frozen=True)
class Slice:
    """Outgoing directions in a vertical plane."""

    theta_o: Array
    """Polar angles (n,) in radians."""
    phi_o: Array
    """Azimuths (n,) in radians."""
    wo: Array
    """Unit vectors (3, n)."""


def slice_directions(scene: Scene, phi_o: tuple[float, ...] | None, points: int) -> Slice:
    """`points` directions from horizon to horizon through the zenith, and for a dielectric as many
    below the surface; the far half has azimuth `phi_o`, by default that of the mirror direction.
    Angles are midpoints of equal parts, so that none is horizontal."""
    azimuth = scene.phi + math.pi if phi_o is None else phi_o[0]
    angle = ((np.arange(points) + 0.5) / points - 0.5) * np.pi
    theta = np.abs(angle)
    if scene.material.transmits:
        theta = np.concatenate([theta, np.pi - theta])
        angle = np.concatenate([angle, angle])
    phi = np.where(angle < 0, azimuth - np.pi, azimuth) % (2 * np.pi)
    wo = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    return Slice(theta, phi, wo)


CHANNELS = ("red", "green", "blue")


def channel_names(channels: int) -> list[str]:
    """`red`, `green`, `blue` for three channels; numbers for more; nothing for one."""
    if channels == 1:
        return [""]
    return list(CHANNELS) if channels == 3 else [str(i + 1) for i in range(channels)]


def slice_table(scene: Scene, directions: Slice, values: list[Values]) -> Table:
    """slice.csv"""
    names = ("method", "theta_i_rad", "phi_i_rad", "theta_o_rad", "phi_o_rad", "order")
    table: dict[str, list[float | str]] = {
        name: [] for name in (*names, "value_per_sr", "stderr_per_sr", "channel")
    }
    orders = [*order_names(scene.orders), "all"]
    n = directions.theta_o.size
    for v in values:
        for c, channel in enumerate(channel_names(len(v.value))):
            for row, order in enumerate(orders):
                columns = (
                    [v.method] * n,
                    [v.theta] * n,
                    [scene.phi] * n,
                    directions.theta_o.tolist(),
                    directions.phi_o.tolist(),
                    [order] * n,
                    v.value[c, row].tolist(),
                    v.stderr[c, row].tolist(),
                    [channel] * n,
                )
                for column, cells in zip(table.values(), columns, strict=True):
                    column.extend(cells)
    return table
