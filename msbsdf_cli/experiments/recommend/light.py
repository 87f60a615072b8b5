"""Light that a surface sends back, in the bins of lobes: of the Smith model, of methods that
replace its later bounces, and as traced on explicit surfaces."""

from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np

from msbsdf_cli.experiments import realisations
from msbsdf_cli.experiments.method_lobes import bins, places
from msbsdf_cli.experiments.resolution import LEAST_REALISATIONS, plan
from msbsdf_cli.experiments.walks import walk
from msbsdf_cli.memory.remembered import Remembered
from msbsdf_cli.methods.protocol import Method
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.run.executors import Workers
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, merge_sides
from msbsdf_cli.statistics.distances import Histogram
from msbsdf_cli.statistics.tally import Estimate
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.streams import stream

MAX_ORDER = 10_000

RAYS_PER_SURFACE = 20_000
"""More on one surface say little that is new: lobes of 16 surfaces are known no better from 1e6
rays than from 2e5 (mirror, alpha 0.1: a total variation to .004 either way)."""

ACCURACY = 0.0025
"""Of energies by tracing, which decides the mesh and the period: a fourth of the usual tolerance.
"""


@dataclass(frozen=True)
class Light:
    """Of one channel, from one direction, as a fraction of what comes in; bins are those of the
    sides where light leaves."""

    energy: Estimate
    """Of each order and all later ones, (orders + 1,)."""
    lobe: Estimate
    """The same in bins, (orders + 1, bins)."""
    total: Estimate
    """What leaves in all, a number."""
    groups: Array | None
    """Bins (groups, bins) of independent groups of surfaces, all orders together."""

    def orders(self, first: int, last: int | None = None) -> Histogram:
        """Bins of the orders from place `first` to before `last`."""
        part = slice(first, last)
        square = (self.lobe.stderr[part] ** 2).sum(axis=0)
        return Histogram(self.lobe.value[part].sum(axis=0), np.sqrt(square))


def walked(
    scene: Scene, walks: int, seed: int, memory: Remembered | None = None
) -> list[list[Light]]:
    """Light of the Smith model, or of one with `memory`, by random walks: for each angle, for each
    channel."""
    how = walks, _no_paths(), "gaussian", seed, 1, "float64", MAX_ORDER, True, memory
    return _by_angle([walk(one, *how).lobes() for one in _channels(scene)])


def traced(scene: Scene, rays: int, seed: int, workers: Workers) -> list[list[Light]]:
    """Light traced on explicit surfaces, likewise; `rays` for each angle and channel."""
    surfaces = max(LEAST_REALISATIONS, -(-rays // RAYS_PER_SURFACE))
    resolution = plan(scene, ACCURACY, None, None, surfaces, None)
    how = rays, resolution, _no_paths(), seed, workers, MAX_ORDER, True
    return _by_angle([realisations.simulate(one, *how).lobes() for one in _channels(scene)])


def replaced(method: str, scene: Scene) -> list[list[tuple[Array, float]]]:
    """What a method without noise has in the place of all bounces but the first: for each angle
    and channel bins, and the energy of the first bounce to which its values in bins add up: how far
    that is off tells the error of adding them up."""
    wo, solid_angle = bins(scene.material.transmits, places(scene))
    flat = wo.transpose(1, 0, 2).reshape(3, -1)
    bsdf = _made(method, scene.slopes, scene.material)
    found = []
    for theta in scene.theta:
        value = bsdf.evaluate(scene.wi(theta), flat, 0, stream(0, "without noise")).value
        energy = value.reshape(*value.shape[:2], *wo[:, 0].shape).mean(axis=2) * solid_angle
        found.append([(_merged(later), float(first.sum())) for first, later in energy])
    return found


@lru_cache(maxsize=2)
def _made(method: str, slopes: Slopes, material: Material) -> Method:
    """Tables of one roughness serve all its directions."""
    return METHODS[method](slopes, material, 1)


def _channels(scene: Scene) -> list[Scene]:
    """The scene in each channel alone, which is all that tallies follow."""
    return [replace(scene, material=m) for m in channels(scene.material)]


def channels(material: Any) -> list[Any]:
    """A material in each of its channels alone: what it has one of for each is a tuple."""
    n = material.channels
    parts = {f.name: getattr(material, f.name) for f in fields(material)}
    parts = {k: v for k, v in parts.items() if isinstance(v, tuple) and len(v) == n}
    return [replace(material, **{k: v[i : i + 1] for k, v in parts.items()}) for i in range(n)]


def _no_paths() -> FreePaths:
    return FreePaths((), (), np.array([0.0, 1.0]))


def _by_angle(runs: list[Lobes]) -> list[list[Light]]:
    return [[_light(lobes, i) for lobes in runs] for i in range(len(runs[0].theta))]


def _light(lobes: Lobes, i: int) -> Light:
    sides = len(lobes.sides)
    value, square = (
        np.array([_merged(order[:sides].ravel()) for order in part])
        for part in (lobes.bins.value[i], lobes.bins.stderr[i] ** 2)
    )
    energy = Estimate(lobes.energy.value[i].sum(axis=1), np.hypot(*lobes.energy.stderr[i].T))
    lost = [lobes.rest[name] for name in ("absorbed", "unresolved")]
    # What a period moves is moved between orders: with their errors in quadrature it counts twice.
    stderr = min(float(np.hypot(*(part.stderr[i] for part in lost))), _length(energy.stderr))
    total = Estimate(1 - sum(part.value[i] for part in lost), np.array(stderr))
    groups = None
    if lobes.groups is not None:
        groups = lobes.groups[i][:, :, :sides].sum(axis=1).reshape(len(lobes.groups[i]), -1)
    return Light(energy, Estimate(value, np.sqrt(square)), total, groups)


def _length(errors: Array) -> float:
    return float(np.sqrt((errors**2).sum()))


def _merged(lobe: Array) -> Array:
    """Energies in merged bins, from those in all bins of one side or both."""
    return merge_sides(lobe.reshape(-1, THETA_BINS * PHI_BINS))
