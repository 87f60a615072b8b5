"""A BSDF as a file of measurements, which Mitsuba's plugin `measured` reads (Dupuy & Jakob, "An
Adaptive Parameterization for Efficient Material Acquisition and Rendering", 2018).

Over polar angles of incidence it holds BSDF x cosine on a grid of half vectors, with
theta_m = pi/2 u^2 and phi_m = pi (2 v - 1), times 4 sigma / D: what is left of a lobe then is wide.
The distribution D is written as it is over the grid, with something added that it may be divided
by; light is sampled by the values themselves, so that the file's visible normals are uniform.
"""

from pathlib import Path

import numpy as np

from msbsdf_cli.renderers.tables import BsdfTable
from surfaces.facet import Array

INCIDENT, GRID = 48, 128
"""Polar angles of incidence and half vectors along each axis: 12 MB, within which Mitsuba's linear
interpolation is right to 1 % for alpha 0.2 to 1 and theta up to 1.4."""

STEEPEST = 0.985 * np.pi / 2
"""Of the polar angles of incidence; directions beyond have the values of this one."""

BACKGROUND = 0.05
"""Added to D, as a part of its mean over the hemisphere."""

TYPES = {"uint8": 1, "float32": 10}
"""Numbers of types in the format."""


def write_measured(path: str | Path, table: BsdfTable) -> None:
    """Write the table of an opaque surface of one roughness, in red, green and blue."""
    u = np.linspace(0, 1, GRID)
    theta_i = np.linspace(0, STEEPEST, INCIDENT)
    m = half_vectors(u)
    inclined = m[:, :GRID]
    D = table.slopes.D(inclined) + BACKGROUND / (2 * np.pi)
    area = np.tile(u * np.hypot(inclined[0], inclined[1]), GRID)
    colours, luminance = [], []
    for theta in theta_i:
        wi = np.array([np.sin(theta), 0, np.cos(theta)])
        cos_i = wi @ m
        wo = 2 * cos_i * m - wi[:, None]
        above = (wo[2] > 0) & (cos_i > 0)
        value = np.zeros((3, wo.shape[1]))
        value[:, above] = table.evaluate(wi, wo[:, above])
        sigma = table.slopes.sigma(-wi[:, None])
        colours.append(value * 4 * sigma / np.tile(D, GRID))
        luminance.append(value.mean(axis=0) * area * np.maximum(cos_i, 0))
    grid = GRID, GRID
    fields: dict[str, Array] = {
        "description": np.frombuffer(_description(table).encode(), np.uint8),
        "theta_i": theta_i,
        "phi_i": np.zeros(1),
        # Two equal rows: neither depends on the azimuth.
        "ndf": np.tile(D, (2, 1)),
        "sigma": np.tile(table.slopes.sigma(-inclined), (2, 1)),
        "vndf": np.ones((1, INCIDENT, 2, 2)),
        "luminance": np.reshape(luminance, (1, INCIDENT, *grid)),
        "rgb": np.reshape(colours, (1, INCIDENT, 3, *grid)),
        "jacobian": np.ones(1, np.uint8),
    }
    write_tensors(path, fields)


def _description(table: BsdfTable) -> str:
    slopes, material = table.slopes, table.material
    return f"{material.name}, {slopes.name} slopes, alpha {slopes.alpha_x:g}, all bounces (msbsdf)"


def half_vectors(u: Array) -> Array:
    """Of the grid, (3, v x u): v, the azimuth, first."""
    theta, phi = np.pi / 2 * u * u, np.pi * (2 * u - 1)
    sin, cos = np.sin(theta), np.cos(theta)
    return np.array(
        [
            np.outer(np.cos(phi), sin).ravel(),
            np.outer(np.sin(phi), sin).ravel(),
            np.tile(cos, u.size),
        ]
    )


def write_tensors(path: str | Path, fields: dict[str, Array]) -> None:
    """Write arrays by name in Mitsuba's format `tensor_file` 1.0: a table of names, types, places
    and shapes, and then the numbers; all but bytes in single precision."""
    arrays = {
        name: np.ascontiguousarray(a if a.dtype == np.uint8 else a.astype(np.float32))
        for name, a in fields.items()
    }
    head = b"tensor_file\0" + bytes([1, 0]) + np.uint32(len(arrays)).tobytes()
    place = len(head) + sum(13 + len(name) + 8 * a.ndim for name, a in arrays.items())
    for name, a in arrays.items():
        head += np.uint16(len(name)).tobytes() + name.encode() + np.uint16(a.ndim).tobytes()
        head += bytes([TYPES[a.dtype.name]]) + np.uint64(place).tobytes()
        head += np.array(a.shape, np.uint64).tobytes()
        place += a.nbytes
    Path(path).write_bytes(head + b"".join(a.tobytes() for a in arrays.values()))
