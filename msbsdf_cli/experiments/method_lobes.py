"""Lobes of methods in the bins of a simulation, so that they can be held against it."""

import math

import numpy as np
from scipy.stats import qmc

from msbsdf_cli.experiments.evaluate import evaluate
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.run.executors import Workers
from msbsdf_cli.scene import Scene, from_normal
from msbsdf_cli.statistics.binning import PHI_BINS, lobe_axes
from msbsdf_cli.statistics.tally import Estimate
from surfaces.facet import Array

MOST_PLACES = 16
"""At most so many places in a bin: as many as there are parts of the samples to take them."""

SAMPLES_OF_RAYS = 1 / 100
"""Walks of a method for each ray of the simulation: every walk serves all the bins."""


def method_lobes(
    scene: Scene,
    methods: tuple[str, ...],
    rays: int,
    seed: int,
    workers: Workers,
    precision: str,
    quiet: bool,
    autocorrelation: str = "gaussian",
) -> list[Lobes]:
    """Lobes of methods in the bins of a simulation of surfaces of this autocorrelation that has
    `rays` rays for each incident angle.

    Methods that evaluate do not say what was absorbed. Raises `UnsupportedError` where a method
    does not hold for the scene.
    """
    transmits = scene.material.transmits
    wo, solid_angle = bins(transmits, places(scene))
    samples = max(round(rays * SAMPLES_OF_RAYS), 32)
    arithmetic = seed, workers, precision, quiet
    values = evaluate(
        *(scene, methods, wo, samples, *arithmetic),
        solid_angle=solid_angle,
        autocorrelation=autocorrelation,
    )
    shape = len(scene.theta), scene.orders + 1, 1 + transmits, -1
    place = scene.theta, scene.phi, scene.orders, transmits
    found = []
    for name in methods:
        mine = [v for v in values if v.method == name]
        energy = np.array([v.energy[:, 0] for v in mine if v.energy is not None])
        both = ([getattr(v, part)[0, :-1] * solid_angle for v in mine] for part in VALUES)
        light = (np.array(each).reshape(shape) for each in both)
        found.append(
            Lobes(name, *place, Estimate(energy[:, 0], energy[:, 1]), Estimate(*map(_sides, light)))
        )
    return found


VALUES = ("value", "stderr")


def _sides(bins: Array) -> Array:
    """Bins (theta, order, side, bin) of both sides, empty on the far one if it is missing."""
    return np.pad(bins, [(0, 0), (0, 0), (0, 2 - bins.shape[2]), (0, 0)])


def places(scene: Scene) -> int:
    """In how many places of a bin to evaluate: a power of 2, so many that the steps of azimuth are
    below half a lobe's standard deviation, but from 2 to `MOST_PLACES`.

    A facet's slope has the standard deviation alpha / sqrt(2). Reflection doubles it as an angle,
    refraction from index 1 to n > 1 or back takes it times 1 - 1 / n, and an azimuth near the
    horizon times cos(theta). Lobes of diffuse facets are wide.
    """
    material = scene.material
    if not material.specular:
        return 2
    bend = 1 - min(material.ior, 1 / material.ior) if material.transmits else 2.0
    width = bend * min(scene.alpha) * math.cos(max(map(from_normal, scene.theta))) / math.sqrt(2)
    wanted = 2 * (2 * math.pi / PHI_BINS) / width
    return min(2 ** max(math.ceil(math.log2(wanted)), 1), MOST_PLACES)


def bins(transmits: bool, k: int) -> tuple[Array, Array]:
    """Directions (k, 3, n) in the bins, each row in the same place of all of them, and the bins'
    solid angles (n,): one hemisphere, then the other. Places are the first `k` of Sobol's points,
    even in solid angle."""
    polar, azimuth, solid_angle = lobe_axes()
    half = (polar[1] - polar[0]) / 2
    # Without scrambling each axis is at the lower ends of k equal parts.
    points = qmc.Sobol(2, scramble=False).random(k) + 0.5 / k
    w = np.empty((k, 3, polar.size, azimuth.size))
    for place, (u, v) in zip(w, points, strict=True):
        top, bottom = np.cos(polar - half), np.cos(polar + half)
        cos = top + u * (bottom - top)
        phi = azimuth + (v - 0.5) * (azimuth[1] - azimuth[0])
        sin = np.sqrt(1 - cos * cos)
        place[0] = np.multiply.outer(sin, np.cos(phi))
        place[1] = np.multiply.outer(sin, np.sin(phi))
        place[2] = cos[:, None]
    wo = w.reshape(k, 3, -1)
    solid = np.repeat(solid_angle, azimuth.size)
    if not transmits:
        return wo, solid
    return np.concatenate([wo, wo * np.array([[1], [1], [-1]])], axis=2), np.tile(solid, 2)
