"""Models of a surface against light that is traced on explicit surfaces."""

import numpy as np

from msbsdf_cli.experiments.recommend.apart import Apart, by_lobe
from msbsdf_cli.experiments.recommend.candidates import (
    COMPENSATED,
    MEMORY,
    Candidate,
    doubt,
)
from msbsdf_cli.experiments.recommend.cases import (
    ORDERS,
    Case,
    facets,
    one_angle,
    scenes,
    walk_of,
)
from msbsdf_cli.experiments.recommend.light import (
    RAYS_PER_SURFACE,
    Light,
    channels,
    replaced,
    traced,
    walked,
)
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.experiments.resolution import LEAST_REALISATIONS
from msbsdf_cli.memory.remembered import Remembered
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import holds
from msbsdf_cli.run.executors import Workers
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.distances import Histogram
from surfaces.facet import Array

WALKS_OF_RAYS = 2
"""Walks for each ray: a walk is cheaper, and its noise is to be the lesser one."""

SLOPES = "beckmann"
"""Of a surface that is the sum of many waves."""

SURFACES_PER_S = 9.0
RAYS_PER_S = 0.3e6
"""Rough rates of one core, making meshes of three finenesses, and walks, included."""


def against_surfaces(
    surface: SceneSurface, rays: int, seed: int, workers: Workers, scale: float
) -> list[Candidate]:
    """All candidates, with errors that hold the noise of surfaces and walks. `rays` for each angle,
    channel and roughness. Raises UnsupportedError for slopes that no surface has."""
    if any(slopes.name != SLOPES for slopes in surface.slopes):
        raise UnsupportedError(
            f"its slopes are {surface.slopes[0].name}, and the surfaces that are traced are "
            f"Gaussian ones: against them slopes {SLOPES} can be judged"
        )
    solved: list[Case] = []
    apart: dict[tuple[str, int], list[Apart]] = {}
    for scene in scenes(surface):
        truth = traced(scene, rays, seed, workers)
        model = walked(scene, WALKS_OF_RAYS * rays, seed)
        remembered = walked(scene, WALKS_OF_RAYS * rays, seed, Remembered())
        names = [n for n in COMPENSATED if holds(n, scene.slopes, scene.material)]
        instead = {name: replaced(name, scene) for name in names}
        for i, theta in enumerate(scene.theta):
            case = _case(one_angle(scene, theta), model[i])
            solved.append(case)
            for n in (*range(1, ORDERS + 1), 0):
                apart.setdefault(("", n), []).append(_truncated(case, n, model[i], truth[i]))
            with_memory = _case(one_angle(scene, theta), remembered[i])
            found = _truncated(with_memory, 0, remembered[i], truth[i])
            apart.setdefault((MEMORY, 0), []).append(found)
            for name in names:
                found = _compensated(case, instead[name][i], model[i], truth[i])
                apart.setdefault((name, 0), []).append(found)
    cost, walk = facets(solved), walk_of(solved)
    candidates = []
    for (name, n), each in apart.items():
        # A method that does not hold for each roughness is no candidate.
        if len(each) == len(solved):
            method = name or ("single" if n == 1 else walk)
            met = 1.0 if name in COMPENSATED else float(cost[n - 1])
            candidates.append(Candidate.of(method, n, met, each, scale))
    return candidates


def distance(scene: Scene, rays: int, seed: int) -> list[Apart]:
    """How far the Smith model of all bounces is from surfaces, from each angle of a scene."""
    truth, model = traced(scene, rays, seed, 1), walked(scene, WALKS_OF_RAYS * rays, seed)
    return [
        _truncated(_case(one_angle(scene, theta), m), 0, m, t)
        for theta, m, t in zip(scene.theta, model, truth, strict=True)
    ]


def seconds(surface: SceneSurface, rays: int) -> float:
    """About how many seconds one core needs."""
    each = sum(len(channels(s.material)) for s in scenes(surface))
    per_surface = max(rays / RAYS_PER_SURFACE, LEAST_REALISATIONS) / SURFACES_PER_S
    return each * (per_surface + rays * len(surface.theta) / RAYS_PER_S)


def _case(scene: Scene, model: list[Light]) -> Case:
    energy = np.array([light.energy.value for light in model])
    return Case(scene, energy, np.array([light.total.stderr for light in model]))


def _truncated(case: Case, n: int, model: list[Light], truth: list[Light]) -> Apart:
    """Of the first n bounces; of all for 0."""
    lobes = [
        (m.orders(0, n or None), t.orders(0), t.groups) for m, t in zip(model, truth, strict=True)
    ]
    if n:
        value = case.energy[:, :n].sum(axis=1)
        square = sum(np.array([m.energy.stderr[k] for m in model]) ** 2 for k in range(n))
        energies = value, np.sqrt(square)
    else:
        energies = _totals(model)
    return by_lobe(case.place, energies, _totals(truth), lobes)


def _compensated(
    case: Case, mine: list[tuple[Array, float]], model: list[Light], truth: list[Light]
) -> Apart:
    first = np.array([(m.energy.value[0], m.energy.stderr[0]) for m in model]).T
    added = np.array([later.sum() for later, _ in mine])
    lobes = []
    for (later, _), m, t in zip(mine, model, truth, strict=True):
        single = m.orders(0, 1)
        lobes.append((Histogram(single.value + later, single.stderr), t.orders(0), t.groups))
    energies = first[0] + added, first[1]
    return by_lobe(case.place, energies, _totals(truth), lobes, doubt(first[0], mine))


def _totals(light: list[Light]) -> tuple[Array, Array]:
    value, stderr = (
        np.array([getattr(one.total, f) for one in light]) for f in ("value", "stderr")
    )
    return value, stderr
