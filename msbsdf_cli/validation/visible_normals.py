"""Visible normals: normalisation and sampling, [HHdD16 impl.] 4.2."""

from collections.abc import Iterator

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.visible_slopes import visible_slopes
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.statistics.test_statistics import ChiSquare, Exact, Mean
from msbsdf_cli.validation.configurations import (
    Configuration,
    hard_anywhere,
    random_anywhere,
)
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.reference import SEEN, projected_area
from surfaces.facet import Array, dot

NODES = 48
"""Quadrature nodes along each axis; the error is what half of them would change."""

BINS = 20
"""Bins of slopes along each axis, before those of few counts are pooled."""

SUB = 48
"""Midpoints along each side of a bin: the density's kink, where facets turn away, crosses some
bins, and there the rule errs by 1 / SUB^2 of a bin."""

MOMENTS = ("x", "y", "z", "xx", "yy", "zz")


def moments(w: Array) -> Array:
    """x, y, z and their squares of directions (3, n): (6, n)."""
    return np.concatenate([w, w * w])


def normalisation(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """The integral of D_wi is 1: <wi, m> D(m) over the projected area in closed form (4.2.1)."""
    if projected_area(c, c.i) < SEEN:
        return
    sums = []
    for nodes in (NODES // 2, NODES):
        _, weight = visible_slopes(c.slopes, -c.i, nodes, nodes)
        sums.append(float(weight.sum()))
    sigma = float(c.slopes.sigma(-c.i)[0])
    slack = abs(sums[1] - sums[0]) / sigma + 1e-9
    because = f"what half of {NODES} nodes change, and rounding"
    evidence = Exact(1.0, sums[1] / sigma, slack, because)
    yield Finding("visible normals, normalisation", "4.2.1", c, evidence)


def sampled_moments(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Moments of sampled normals against those by quadrature (4.2.2)."""
    if projected_area(c, c.i) < SEEN:
        return
    slopes = c.slopes
    expected, error = quadrature_moments(slopes, c.i)
    m = slopes.visible_normals(c.i, n, rng)
    values = moments(m / np.sqrt(dot(m, m)))
    because = f"what half of {NODES} quadrature nodes change"
    for name, value, wanted, slack in zip(MOMENTS, values, expected, error, strict=True):
        stderr = float(value.std() / np.sqrt(n))
        evidence = Mean(float(wanted), float(value.mean()), stderr, n - 1, float(slack), because)
        yield Finding(f"visible normals, E[{name}]", "4.2.2", c, evidence)


def quadrature_moments(slopes: Slopes, wi: Array) -> tuple[Array, Array]:
    """Moments (6,) of the normals visible from wi (3, 1), and their errors."""
    results = []
    for nodes in (NODES // 2, NODES):
        m, weight = visible_slopes(slopes, -wi, nodes, nodes)
        results.append((moments(m[..., 0]) * weight[:, 0]).sum(axis=1) / weight.sum())
    return results[1], np.abs(results[1] - results[0]) + 1e-9


def sampled_slopes(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Chi-square of sampled slopes in the stretched frame of wi (4.2.2)."""
    area = projected_area(c, c.i)
    if area < SEEN:
        return
    along, across = _stretched_slopes(c, c.slopes.visible_normals(c.i, n, rng))
    pilot, tested = slice(None, n // 8), slice(n // 8, None)
    borders = np.linspace(0, 1, BINS + 1)[1:-1]
    edges = [np.quantile(v[pilot], borders) for v in (along, across)]
    counts = np.histogram2d(along[tested], across[tested], edges)[0].ravel()
    s = float(np.hypot(c.slopes.alpha[0] * c.i[0, 0], c.slopes.alpha[1] * c.i[1, 0]))
    shares = _shares(c.slopes, s, float(c.i[2, 0]), *edges) / area
    total = along[tested].size
    evidence = ChiSquare.of_counts(
        np.append(counts, total - counts.sum()),
        total * np.append(shares, max(1 - shares.sum(), 0)),
        "bins are quantiles of an eighth of the sample, which is not counted",
    )
    if evidence is not None:
        yield Finding("visible normals, slopes", "4.2.2", c, evidence)


def _stretched_slopes(c: Configuration, m: Array) -> tuple[Array, Array]:
    """Slopes over roughness, along the azimuth of the stretched direction and across it."""
    x, y = -m[0] / m[2] / c.slopes.alpha[0], -m[1] / m[2] / c.slopes.alpha[1]
    azimuth = np.arctan2(c.slopes.alpha[1] * c.i[1, 0], c.slopes.alpha[0] * c.i[0, 0])
    cos_phi, sin_phi = np.cos(azimuth), np.sin(azimuth)
    return x * cos_phi + y * sin_phi, y * cos_phi - x * sin_phi


def _shares(slopes: Slopes, s: float, z: float, along: Array, across: Array) -> Array:
    """Integrals (cells,) of (z - s p)+ P22(p, q) over bins of slopes, by the midpoint rule on the
    textbook's density."""
    p, q = _fine(along)[:, None], _fine(across)[None]
    density = slopes.slope_density(p, q)
    value = np.maximum(z - s * p, 0) * density
    cells = value.reshape(along.size - 1, SUB, across.size - 1, SUB).mean(axis=(1, 3))
    return (cells * np.diff(along)[:, None] * np.diff(across)).ravel()


def _fine(edges: Array) -> Array:
    """Midpoints of SUB parts of every bin."""
    parts = (np.arange(SUB) + 0.5) / SUB
    return (edges[:-1, None] + np.diff(edges)[:, None] * parts).ravel()


IDENTITIES = (
    Identity(normalisation, hard_anywhere, random_anywhere, draws=8, cost=0.1),
    Identity(sampled_moments, hard_anywhere, random_anywhere, draws=4),
    Identity(sampled_slopes, hard_anywhere, random_anywhere, draws=6, share=0.25),
)
