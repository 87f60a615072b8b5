"""A BSDF as a file of measurements, which Mitsuba's plugin `measured` reads (Dupuy & Jakob, "An
Adaptive Parameterization for Efficient Material Acquisition and Rendering", 2018).

Over polar angles of incidence it holds BSDF x cosine on a grid of half vectors, with
theta_m = pi/2 u^2 and phi_m = pi (2 v - 1), times 4 sigma / D: what is left of a lobe then is wide.
To D, which is written beside it, something is added that it may be divided by. Light is sampled by
the values themselves, so that the file's visible normals are uniform.
"""

from pathlib import Path

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from msbsdf_cli.renderers.tables import BsdfTable
from msbsdf_cli.renderers.tabulate import FAINT, LEAST_COSINE
from surfaces.facet import Array
from surfaces.streams import stream

INCIDENT, GRID = 48, 128
"""Polar angles of incidence and half vectors along each axis: 12 MB, as interpolation is linear."""

FINER = 8
"""How many times as fine D and sigma are: D is convex where it falls like a Gaussian, and what is
linear between nodes lies above it."""

STEEPEST = 0.985 * np.pi / 2
"""Of the polar angles of incidence; directions beyond have the values of this one."""

BACKGROUND, BACKGROUND_OF_DIFFUSE = 0.02, 3.0
"""Added to D, in parts of its mean over the hemisphere: more where no lobe goes with D."""

PAIRS = 4096
"""Random pairs of directions in which the file is held against the table."""


def measurements(table: BsdfTable) -> dict[str, Array]:
    """The fields of the file for the table of an opaque surface of one roughness, in red, green and
    blue."""
    u, theta_i = np.linspace(0, 1, GRID), np.linspace(0, STEEPEST, INCIDENT)
    m = half_vectors(u)
    fine = np.linspace(0, 1, FINER * (GRID - 1) + 1)
    inclined = half_vectors(fine, 1)
    background = BACKGROUND if table.material.specular else BACKGROUND_OF_DIFFUSE
    D = table.slopes.D(inclined) + background / (2 * np.pi)
    area = np.tile(u * np.hypot(m[0, :GRID], m[1, :GRID]), GRID)
    sigma_of = table.slopes.sigma(-inclined)
    colours, luminance = [], []
    for theta in theta_i:
        wi = np.array([np.sin(theta), 0, np.cos(theta)])
        cos_i = wi @ m
        wo = 2 * cos_i * m - wi[:, None]
        above = (wo[2] > 0) & (cos_i > 0)
        value = np.zeros((3, wo.shape[1]))
        value[:, above] = table.evaluate(wi, wo[:, above])
        # sigma is interpolated too, and divided by as it then is.
        sigma = np.interp(np.sqrt(theta / (np.pi / 2)), fine, sigma_of)
        colours.append(value * 4 * sigma / np.tile(D[::FINER], GRID))
        luminance.append(value.mean(axis=0) * area * np.maximum(cos_i, 0))
    slopes, material = table.slopes, table.material
    words = f"{material.name}, {slopes.name} slopes, alpha {slopes.alpha_x:g}, all bounces (msbsdf)"
    return {
        "description": np.frombuffer(words.encode(), np.uint8),
        "theta_i": theta_i,
        "phi_i": np.zeros(1),
        # Two equal rows: neither depends on the azimuth.
        "ndf": np.tile(D, (2, 1)),
        "sigma": np.tile(sigma_of, (2, 1)),
        "vndf": np.ones((1, INCIDENT, 2, 2)),
        "luminance": np.reshape(luminance, (1, INCIDENT, GRID, GRID)),
        "rgb": np.reshape(colours, (1, INCIDENT, 3, GRID, GRID)),
        "jacobian": np.ones(1, np.uint8),
    }


def half_vectors(u: Array, rows: int = GRID) -> Array:
    """Of the grid, (3, v x u): v, the azimuth, first."""
    theta, phi = np.pi / 2 * u * u, np.pi * (2 * np.linspace(0, 1, rows) - 1)
    sin, cos = np.sin(theta), np.cos(theta)
    across = (np.outer(f(phi), sin).ravel() for f in (np.cos, np.sin))
    return np.array([*across, np.tile(cos, rows)])


def evaluate_measurements(fields: dict[str, Array], wi: Array, wo: Array) -> Array:
    """BSDF x cosine (3, n) for directions (3, n) above the surface, by linear interpolation, as
    Mitsuba has it."""
    u = np.linspace(0, 1, GRID)
    m = wi + wo
    m = m / np.sqrt((m * m).sum(axis=0))
    turned = np.arctan2(m[1], m[0]) - np.arctan2(wi[1], wi[0])
    v = np.mod((turned + np.pi) / (2 * np.pi), 1)
    u_m, u_i = (np.sqrt(np.arctan2(np.hypot(w[0], w[1]), w[2]) / (np.pi / 2)) for w in (m, wi))
    theta = np.minimum(u_i * u_i * np.pi / 2, STEEPEST)
    grid = RegularGridInterpolator((fields["theta_i"], u, u), np.moveaxis(fields["rgb"][0], 1, -1))
    found = grid(np.stack([theta, v, u_m], axis=-1)).T
    fine = np.linspace(0, 1, fields["ndf"].shape[1])
    D, sigma = np.interp(u_m, fine, fields["ndf"][0]), np.interp(u_i, fine, fields["sigma"][0])
    return np.asarray(found * D / (4 * sigma))


def measured_error(table: BsdfTable, fields: dict[str, Array], seed: int = 0) -> Array:
    """Relative errors (pairs,) against the table, as those of `table_error`."""
    rng = stream(seed, "export pairs", "measured")
    errors = []
    for _ in range(PAIRS // 64):
        cos, phi = rng.uniform(LEAST_COSINE, 1, 65), rng.uniform(0, 2 * np.pi, 65)
        sin = np.sqrt(1 - cos * cos)
        w = np.array([sin * np.cos(phi), sin * np.sin(phi), cos])
        wi, wo = w[:, 0], w[:, 1:]
        truth = table.evaluate(wi, wo)
        mine = evaluate_measurements(fields, np.broadcast_to(wi[:, None], wo.shape), wo)
        errors.append((np.abs(mine - truth) / np.maximum(truth, FAINT)).max(axis=0))
    return np.concatenate(errors)


TYPES = {"uint8": 1, "float32": 10}
"""Numbers of types in the format."""


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
