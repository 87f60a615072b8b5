"""Masking, shadowing and visible normals on explicit Beckmann surfaces.

There the Smith model is an approximation, since it knows nothing of what lies near: differences
are its own, are reported as agreement, and are not judged.
"""

from collections.abc import Iterator

import numpy as np

from msbsdf_cli.experiments.random_surfaces import Resolution, make_surface
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.statistics.multiple_testing import AGREEMENT, Finding
from msbsdf_cli.validation import reference
from msbsdf_cli.validation.batches import of_batches
from msbsdf_cli.validation.configurations import GRAZING, Configuration
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.visible_normals import MOMENTS, moments, quadrature_moments
from surfaces.facet import Array, dot
from surfaces.periodic import ESCAPED, meet, next_triangle
from surfaces.stretch import Stretch
from surfaces.surface import Surface
from surfaces.tracing import morton

SURFACES = Resolution(cells=8, extent=16, realisations=16)
"""Standard errors are over the realisations: rays on one surface are not independent."""

SECTION = "explicit surfaces"


def on_surfaces(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Points uniform over the mean plane that face a direction, or two, and whether they are seen
    from there; and the normals that rays from wi meet first."""
    rays = n // SURFACES.realisations
    figures = np.array(
        [
            _one_surface(c, make_surface(SURFACES, rng), rays, rng)
            for _ in range(SURFACES.realisations)
        ]
    )
    G1 = reference.masking_shadowing(c, c.i, np.array([[0.0], [0.0], [1.0]]))
    G2 = reference.masking_shadowing(c, c.i, c.o)
    wanted = [G1, G2, *quadrature_moments(c.slopes, c.i)[0]]
    names = ["masking", "masking-shadowing", *(f"visible normals, E[{m}]" for m in MOMENTS)]
    for name, expected, values in zip(names, wanted, figures.T, strict=True):
        evidence = of_batches(float(expected), values)
        yield Finding(f"{name} on surfaces", SECTION, c, evidence, AGREEMENT)


def _one_surface(
    c: Configuration, surface: Surface, n: int, rng: np.random.Generator
) -> list[float]:
    """Shares of points seen from wi, and from wi and wo, and moments of the visible normals."""
    stretch = surface.stretch(*c.slopes.alpha, c.wi[1])
    towards_i, towards_o = stretch.to_grid(c.i), stretch.to_grid(c.o)
    points, planes = _points(surface, n, rng)
    facing = [planes[1] * w[0] + planes[2] * w[1] < w[2] for w in (towards_i, towards_o)]
    seen_i = _escapes(surface, points, towards_i)
    seen_o = _escapes(surface, points, towards_o)
    both = facing[0] & facing[1]
    m = _visible_normals(surface, stretch, -towards_i, n, rng)
    return [
        float(seen_i[facing[0]].mean()),
        float((seen_i & seen_o)[both].mean()),
        *moments(m).mean(axis=1),
    ]


def _points(surface: Surface, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Points (3, n), lifted off the surface, and the planes (3, n) they lie on: all triangles have
    the same share of the mean plane."""
    corners, planes = surface.period_triangles
    chosen = rng.integers(planes.shape[1], size=n)
    a, b = rng.random((2, n))
    over = a + b > 1
    a, b = np.where(over, 1 - a, a), np.where(over, 1 - b, b)
    first, second, third = corners[..., chosen]
    points = first + a * (second - first) + b * (third - first)
    points[2] += surface.lift
    return points, planes[:, chosen]


def _escapes(surface: Surface, points: Array, travel: Array) -> Array:
    """Which points (3, n) see the sky along a direction (3, 1) of the surface's coordinates."""
    along = np.broadcast_to(travel, points.shape)
    return next_triangle(surface, points.copy(), along, None) == ESCAPED


def _visible_normals(
    surface: Surface, stretch: Stretch, travel: Array, n: int, rng: np.random.Generator
) -> Array:
    """Unit normals (3, k) of the facets that rays along `travel` meet first."""
    o = np.empty((3, n))
    o[:2] = morton((np.arange(n) + rng.random(n)) / n) * surface.period
    o[2] = surface.top
    along = np.broadcast_to(travel, o.shape)
    triangle = next_triangle(surface, o, along, None)
    hit = triangle >= 0
    _, facing, slopes = meet(surface, o[:, hit], along[:, hit], triangle[hit])
    m = stretch.normals(slopes[:, facing])
    return m / np.sqrt(dot(m, m))


def hard() -> list[Configuration]:
    """From steep to grazing, smooth to rough."""
    return [
        Configuration(Beckmann(*alpha), (theta, 0.0), (1.0, 2.0))
        for alpha in ((0.3, 0.3), (1.0, 1.0), (1.0, 0.3))
        for theta in (0.5, 1.2, GRAZING)
    ]


IDENTITIES = (Identity(on_surfaces, hard, thin=5, share=0.1, cost=4),)
