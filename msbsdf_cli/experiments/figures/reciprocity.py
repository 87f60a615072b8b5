"""A picture, and the same with the ends of light swapped: the position-free models."""

import numpy as np

from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.methods.position_free import (
    PositionFree,
    PositionFreeCorrelated,
    PositionFreeUncorrelated,
)
from msbsdf_cli.results.files import from_rows
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import Ggx
from surfaces.facet import Array
from surfaces.materials import Conductor
from surfaces.streams import stream

SLOPES, MATERIAL = Ggx(1.0, 1.0), Conductor()
LIGHT = 1.0
"""Polar angle of the lamp at the view's side, in radians."""
LEAST_COS = 0.05
"""Of both angles: where light or view is nearer to the horizon there is hardly any picture."""

COLUMNS = ("method", "row", "column", "forward", "backward", "difference", "stderr")


def wang_16(settings: Settings) -> Tables:
    """A sphere of GGX mirrors of roughness 1 under a lamp: values of f(i, o) and f(o, i) at each
    pixel, from the same number of paths, and their difference."""
    side, batches, each = settings.pick((24, 8, 32), (48, 32, 64))
    place, wi, wo = sphere(side)
    rows = []
    for kind in (PositionFreeUncorrelated, PositionFreeCorrelated):
        method: PositionFree = kind(SLOPES, MATERIAL, 1)
        values = np.empty((batches, 2, wi.shape[1]))
        for k, batch in enumerate(values):
            for way, (a, b) in enumerate(((wi, wo), (wo, wi))):
                rng = stream(settings.seed, "swapped ends", method.name, way, k)
                incoming, outgoing = (np.repeat(w, each, axis=1) for w in (a, b))
                found = method.evaluate_each(incoming, outgoing, rng)[0].reshape(-1, each)
                batch[way] = found.mean(axis=1) / b[2]
        forward, backward = values.mean(axis=0)
        apart = values[:, 0] - values[:, 1]
        stderr = apart.std(axis=0, ddof=1) / np.sqrt(batches)
        pixels = zip(*place, forward, backward, apart.mean(axis=0), stderr, strict=True)
        rows += [(method.name, int(i), int(j), *map(float, rest)) for i, j, *rest in pixels]
    return {"wang_16": from_rows(COLUMNS, rows)}


def sphere(side: int) -> tuple[Array, Array, Array]:
    """Rows and columns (2, n) of the pixels on a sphere that see the lamp, and the directions
    (3, n) to the eye and to the lamp over each one's tangent plane."""
    x = (np.arange(side) + 0.5) / side * 2 - 1
    up, right = (a.ravel() for a in np.meshgrid(-x, x, indexing="ij"))
    depth = 1 - up * up - right * right
    seen = np.flatnonzero(depth > 0)
    normal = np.stack([right[seen], up[seen], np.sqrt(depth[seen])])
    frame = _frames(normal)
    eye, lamp = np.array([0.0, 0.0, 1.0]), direction(LIGHT)
    wi, wo = (np.einsum("ijn,j->in", frame, w) for w in (eye, lamp))
    lit = np.minimum(wi[2], wo[2]) > LEAST_COS
    place = np.stack(np.divmod(seen, side))
    return place[:, lit], wi[:, lit], wo[:, lit]


def _frames(normal: Array) -> Array:
    """Rows (3, 3, n) of tangent, bitangent and normal."""
    tangent = np.stack([normal[2], np.zeros_like(normal[0]), -normal[0]])
    tangent /= np.linalg.norm(tangent, axis=0)
    return np.stack([tangent, np.cross(normal, tangent, axis=0), normal])
