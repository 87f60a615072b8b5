"""Lobes of rough glass by the history of reflections and transmissions."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.experiments.random_surfaces import Resolution, realisation
from msbsdf_cli.experiments.resolution import plan
from msbsdf_cli.results.files import from_rows
from msbsdf_cli.run.executors import map_ordered
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.binning import PHI_BINS, lobe_axes, lobe_bin
from msbsdf_cli.statistics.tally import BINS, SIDES
from surfaces.facet import Array
from surfaces.light import Light
from surfaces.materials import Dielectric
from surfaces.streams import stream
from surfaces.tracing import Tracer
from surfaces.views import VIEWS

SCENES = [Scene(Dielectric(ior), Beckmann(1.0, 1.0), (1.0,)) for ior in (1.5, 1 / 1.5)]
"""Light from outside; light from inside, upside down."""
SEQUENCES = ("R", "T", "RR", "RT", "TR", "TT", "TRT", "TTR")
REST = "others"
MAX_ORDER = 1000

LOBE = (
    *("ior", "source", "sequence", "side", "theta_i_rad", "theta_o_rad", "phi_o_rad"),
    *("solid_angle_sr", "density_per_sr", "stderr_per_sr"),
)
ENERGY = ("ior", "source", "sequence", "side", "theta_i_rad", "energy", "stderr")


def heitz_sequences(settings: Settings) -> Tables:
    """Glass of roughness 1 under light from 57 degrees, from outside and from inside, by the walk
    and traced on surfaces."""
    accuracy, each = settings.pick((0.01, 20_000), (0.002, 60_000))
    lobes, energies = [], []
    for number, scene in enumerate(SCENES):
        resolution = plan(scene, accuracy, None, None, None, None)
        walks = settings.pick(20_000, 100_000)
        of_surface = partial(_traced, scene, resolution, each, settings.seed)
        of_walks = partial(_walked, scene, walks, settings.seed, number)
        for source, unit, n in (
            ("walk", of_walks, settings.pick(32, 64)),
            ("surfaces", of_surface, resolution.realisations),
        ):
            units = _units(unit, range(n), settings)
            where = scene.material.ior, source
            lobes += [(*where, *row) for row in _lobe_rows(scene, units)]
            energies += [(*where, *row) for row in _energy_rows(scene, units)]
    return {
        "heitz_sequences": from_rows(LOBE, lobes),
        "heitz_sequences_energy": from_rows(ENERGY, energies),
    }


@dataclass(frozen=True)
class Units:
    """Means and standard errors over independent units."""

    lobes: tuple[Array, Array]
    """(sequences, sides, bins)"""
    energies: tuple[Array, Array]
    """(sequences and others, sides)"""


def _units(unit: Callable[[int], Array], numbers: Iterable[int], settings: Settings) -> Units:
    sums: list[Array] = [np.zeros(1)] * 4
    n = 0
    for shares in map_ordered(unit, numbers, settings.workers):
        energy, lobe, n = shares.sum(axis=2), shares[:-1], n + 1
        sums = [s + x for s, x in zip(sums, (lobe, lobe**2, energy, energy**2), strict=True)]

    def estimate(first: Array, square: Array) -> tuple[Array, Array]:
        mean = first / n
        return mean, np.sqrt(np.maximum(square / n - mean * mean, 0) / (n - 1))

    return Units(estimate(*sums[:2]), estimate(*sums[2:]))


def _walked(scene: Scene, n: int, seed: int, place: int, number: int) -> Array:
    rng = stream(seed, "walk", place, number)
    wi = scene.wi(scene.theta[0])
    return _shares(random_walk(scene.slopes, scene.material, wi, n, rng, MAX_ORDER), n)


def _traced(scene: Scene, resolution: Resolution, n: int, seed: int, number: int) -> Array:
    surface = realisation(resolution, number, seed)
    surface.build()
    tracer = Tracer(surface, surface.stretch(*scene.alpha), scene.material, VIEWS)
    rng = stream(seed, "rays", number, 0)
    return _shares(tracer.trace(scene.wi(scene.theta[0]), n, rng, MAX_ORDER), n)


def _shares(light: Iterator[Light], n: int) -> Array:
    """Energies (sequences and others, sides, bins) of `n` rays or walks."""
    codes = np.full(2 ** (1 + max(map(len, SEQUENCES))), len(SEQUENCES))
    for k, name in enumerate(SEQUENCES):
        codes[int("1" + name.replace("R", "0").replace("T", "1"), 2)] = k
    size = (len(SEQUENCES) + 1, 2, BINS)
    counts = np.zeros(np.prod(size))
    for some in light:
        if not some.resolved or some.sequence is None or some.transmitted is None:
            continue
        known = np.where(some.sequence < codes.size, some.sequence, 0)
        place = (codes[known] * 2 + some.transmitted) * BINS + lobe_bin(some.w)
        counts += np.bincount(place, minlength=counts.size)
    return counts.reshape(size) / n


def side_of(sequence: str) -> int:
    """The side on which light of a history leaves: 1 is transmitted."""
    return sequence.count("T") % 2


def _lobe_rows(scene: Scene, units: Units) -> Iterator[tuple[str | float, ...]]:
    """Without empty bins."""
    polar, azimuth, solid = lobe_axes()
    value, stderr = units.lobes
    for k, name in enumerate(SEQUENCES):
        side = side_of(name)
        for b in np.flatnonzero(value[k, side]):
            i, j = divmod(int(b), PHI_BINS)
            theta = np.pi - polar[i] if side else polar[i]
            figures = (float(f"{x[k, side, b] / solid[i]:.9g}") for x in (value, stderr))
            where = map(float, (scene.theta[0], theta, azimuth[j], solid[i]))
            yield (name, SIDES[side], *where, *figures)


def _energy_rows(scene: Scene, units: Units) -> Iterator[tuple[str | float, ...]]:
    value, stderr = units.energies
    for k, name in enumerate((*SEQUENCES, REST)):
        for s in (0, 1) if name == REST else (side_of(name),):
            yield name, SIDES[s], scene.theta[0], float(value[k, s]), float(stderr[k, s])
