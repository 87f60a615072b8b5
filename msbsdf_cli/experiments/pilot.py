"""A short run of the walk, which tells how long others will take."""

from functools import lru_cache
from time import perf_counter

from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.walk import random_walk
from surfaces.streams import stream

PILOT, PILOT_ORDER = 4096, 4000
"""Walks of a pilot, and facets after which one ends."""


@lru_cache(maxsize=16)
def pilot(scene: Scene) -> tuple[float, float]:
    """Seconds that one core needs for a walk from each incident angle of this scene, and the facets
    that a walk hits in the mean, from a short run."""
    # What is made at the first walk, such as tables of slopes, is no part of what the others cost.
    first = scene.wi(scene.theta[0]), 1, stream(0, "pilot of time", len(scene.theta)), 1
    list(random_walk(scene.slopes, scene.material, *first))
    started, facets = perf_counter(), 0
    for i, theta in enumerate(scene.theta):
        rng, wi = stream(0, "pilot of time", i), scene.wi(theta)
        walks = random_walk(scene.slopes, scene.material, wi, PILOT, rng, PILOT_ORDER)
        facets += sum(light.order * light.w.shape[1] for light in walks)
    return (perf_counter() - started) / PILOT, facets / PILOT / len(scene.theta)
