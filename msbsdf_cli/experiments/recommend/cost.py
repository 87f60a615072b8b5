"""What a candidate costs: nanoseconds for a sample, as a path tracer asks for it."""

import time

from msbsdf_cli.experiments.recommend.candidates import COMPENSATED, MEMORY, Candidate
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.walk import random_walk
from surfaces.streams import stream

SAMPLES = 1 << 15
ROUNDS = 3
"""The least time of as many counts: others work on the machine too."""


def costs_ns(surface: SceneSurface, candidates: list[Candidate]) -> list[float]:
    """Of each candidate, processor time of one core. A walk costs as much as the facets that it
    meets."""
    found = []
    each: dict[str, float] = {}
    for c in candidates:
        closed = c.bounces == 1 or c.method in (*COMPENSATED, MEMORY)
        name = c.method if closed else "a facet"
        if name not in each:
            each[name] = sample_ns(c.method, surface) if closed else facet_ns(surface)
        found.append(each[name] * (1 if closed else c.facets))
    return found


def sample_ns(method: str, surface: SceneSurface) -> float:
    """Nanoseconds of a direction drawn by a method, with its weight; tables are made before."""
    slopes, wi = surface.slopes[-1], direction(surface.theta[len(surface.theta) // 2])
    bsdf, took = METHODS[method](slopes, surface.material, 1), []
    for k in range(ROUNDS):
        rng, started = stream(0, "timed run", method, k, 0), time.process_time_ns()
        bsdf.sample(wi, SAMPLES, rng)
        took.append(time.process_time_ns() - started)
    return min(took) / SAMPLES


def facet_ns(surface: SceneSurface) -> float:
    """Nanoseconds of a facet that random walks meet."""
    slopes, wi = surface.slopes[-1], direction(surface.theta[len(surface.theta) // 2])
    took = []
    for k in range(ROUNDS):
        rng, started = stream(0, "timed run", "walk", k, 0), time.process_time_ns()
        met = sum(
            light.order * light.w.shape[1]
            for light in random_walk(slopes, surface.material, wi, SAMPLES, rng, 1000)
        )
        took.append((time.process_time_ns() - started) / met)
    return min(took)
