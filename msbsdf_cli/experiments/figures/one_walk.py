"""One random walk, facet by facet, and what walks do in the mean."""

import numpy as np
from scipy.special import ndtri_exp

from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.results.files import from_rows
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.smith.walk import exponential, free_path
from surfaces.facet import Array
from surfaces.materials import Conductor
from surfaces.streams import stream

SLOPES, MATERIAL = Beckmann(1.0, 1.0), Conductor.named("copper")
THETA = 1.0
FACETS = 4
"""Of the walk that is shown: of those that meet so many, the one with facets furthest apart."""

ONE = ("facet", "height", "theta_r_rad", "phi_r_rad", "energy")
MEAN = ("facet", "share", "share_stderr", "height", "height_stderr", "energy", "energy_stderr")


def heitz_10(settings: Settings) -> Tables:
    """A walk on copper ([HHdD16] Algorithm 7): height of each facet, in
    standard deviations, direction of the ray that meets it, and its energy then; in the last row
    the ray that leaves. Beside it the mean of all walks that meet a facet of each number."""
    n, rng = settings.pick(50_000, 1_000_000), stream(settings.seed, "walk", 0)
    d, t, energy = np.repeat(-direction(THETA)[:, None], n, axis=1), np.zeros(n), np.ones(n)
    lanes, shown, means = np.arange(n), [], []
    histories: list[tuple[Array, Array, Array, Array]] = []
    while lanes.size:
        facet = len(histories) + 1
        leaves, t = free_path(t, d, SLOPES.sigma(d), exponential(lanes.size, rng, np.float64))
        histories.append((lanes, np.where(leaves, np.inf, height(t)), d, energy))
        if facet <= FACETS:
            means.append((facet, *_means(n, height(t[~leaves]), energy[~leaves])))
        gone = lanes[leaves]
        if facet == FACETS + 1 and gone.size:
            lane = _widest(histories, gone)
            shown = [_step(k + 1, one, lane) for k, one in enumerate(histories)]
        lanes, d, t, energy = lanes[~leaves], d[:, ~leaves], t[~leaves], energy[~leaves]
        m = SLOPES.visible_normals(-d, lanes.size, rng)
        d, gain, _ = MATERIAL.scatter(d, m, None, rng)
        energy = energy if gain is None else energy * gain[0]
    return {"heitz_10": from_rows(ONE, shown), "heitz_10_mean": from_rows(MEAN, means)}


def height(t: Array) -> Array:
    """Height, in standard deviations, of t = -ln C1(h)."""
    return np.asarray(ndtri_exp(-t))


def _widest(histories: list[tuple[Array, Array, Array, Array]], gone: Array) -> int:
    """Of the walks `gone`, which ended together, the one whose least way between facets, in height,
    is largest."""
    heights = [values[np.searchsorted(lanes, gone)] for lanes, values, _, _ in histories[:-1]]
    return int(gone[np.abs(np.diff(heights, axis=0)).min(axis=0).argmax()])


def _step(
    facet: int, history: tuple[Array, Array, Array, Array], lane: int
) -> tuple[int, float, float, float, float]:
    """A row of the walk `lane`."""
    lanes, heights, d, energy = history
    k = int(np.searchsorted(lanes, lane))
    x, y, z = d[:, k]
    angles = float(np.arccos(np.clip(z, -1, 1))), float(np.arctan2(y, x))
    return facet, float(heights[k]), *angles, float(energy[k])


def _means(n: int, heights: Array, energy: Array) -> list[float]:
    """Share of walks, mean height and mean energy, each with its standard error."""
    share = heights.size / n
    found = [share, float(np.sqrt(share * (1 - share) / n))]
    for values in (heights, energy):
        found += [float(values.mean()), float(values.std(ddof=1) / np.sqrt(values.size))]
    return found
