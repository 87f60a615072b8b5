"""What a paper says of noise, measured on the image of a slab.

[WJFYHY22 supp.] Figure 17: error over time of the correlated position-free model and of the walk of
[HHdD16], on a slab under a directional light, over roughness. Each pixel is one pair of directions
with walks of its own. Text there: two samples a pixel come very close to the truth, and the
position-free estimator is consistently better.
"""

from dataclasses import dataclass
from itertools import count

import numpy as np

from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.experiments.tradeoff.directions import Lobe
from msbsdf_cli.experiments.tradeoff.measuring import timed
from msbsdf_cli.experiments.tradeoff.roughness import ALPHAS
from msbsdf_cli.methods.position_free import PositionFreeCorrelated
from msbsdf_cli.methods.protocol import Method
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.results.files import Table, from_rows
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.smith.slopes import Ggx
from msbsdf_cli.statistics.repetitions import inner_products
from surfaces.facet import Array
from surfaces.materials import Conductor
from surfaces.streams import seed_sequence

LIGHT = 0.7
"""Polar angle of the light in radians; the paper does not give its own."""
VIEW = 0.7
"""Polar angle of the view's middle, on the side to which a mirror would send the light."""
FIELD_OF_VIEW = 0.7
PIXELS = 8
"""Of the slab's image, each way."""
SAMPLES = (1, 2, 4, 8, 16, 32, 64)
"""Walks for each pixel."""

WALKS = 1024
"""Walks whose mean tells the variance of one; and of a pixel when one is timed."""
TIMED_WALKS = 8192
REPLICATES = 12

COLUMNS = (
    *("method", "alpha_x", "alpha_y", "samples", "seconds_per_pixel", "relative_mse"),
    *("relative_mse_stderr", "gain_over_walk", "gain_stderr"),
)
ESTIMATORS = (
    "walk",
    "walk-low-variance",
    "position-free-correlated",
    "position-free-correlated-bidirectional",
    "exact",
)


def make(name: str, scene: Scene) -> Method:
    """An estimator by name; the paper's own is the bidirectional one."""
    arguments = scene.slopes, scene.material, scene.orders
    if name == "position-free-correlated-bidirectional":
        return PositionFreeCorrelated(*arguments, bidirectional=True)
    return METHODS[name](*arguments)


@dataclass(frozen=True)
class Noise:
    """What one walk to one pixel is worth."""

    variance: float
    """Relative to the mean square of the image, of one walk a pixel."""
    stderr: float
    seconds: float
    """Of one walk to one pixel, where there are many."""
    seconds_stderr: float
    """From the scatter of the times whose median it is."""
    image: Array
    """Sum of all orders, mean of all walks, (channels, pixels)."""


def noise(method: Method, lobe: Lobe, seed: int, replicates: int, *place: str) -> Noise:
    """Variance and time of one walk to each of the directions of `lobe`, from repetitions; `place`
    is that of the random stream.

    The directions share walks here, which correlates them and leaves each one's variance as it is;
    the time is of one direction alone.
    """
    seeds = (seed_sequence(seed, "slab", *place, r) for r in count())
    values = np.stack(
        [timed(method, WALKS, lobe, next(seeds))[0].sum(axis=1) for _ in range(replicates)]
    )
    image = values.mean(axis=0)
    scale = float((image**2 * lobe.solid_angle).sum())
    gram = inner_products(values - image, lobe.solid_angle) / scale
    # Deviations from their own mean: all but one are free.
    each = np.diag(gram) * replicates / (replicates - 1) * WALKS
    middle = lobe.wo.shape[1] // 2
    one = Lobe(lobe.theta, lobe.wi, lobe.wo[:, middle : middle + 1], lobe.solid_angle[:1])
    seconds = [timed(method, TIMED_WALKS, one, next(seeds))[1] for _ in range(5)]
    return Noise(
        float(each.mean()),
        float(each.std(ddof=1) / np.sqrt(replicates)),
        float(np.median(seconds)) / TIMED_WALKS,
        # A median of normal noise scatters by sqrt(pi / 2) of what a mean does.
        float(np.std(seconds, ddof=1) * np.sqrt(np.pi / 2 / len(seconds))) / TIMED_WALKS,
        image,
    )


def slab(scene: Scene) -> Lobe:
    """The pixels of a slab's image as a lobe; each has the same weight."""
    across = (np.arange(PIXELS) + 0.5) / PIXELS - 0.5
    up, side = np.meshgrid(across, across, indexing="ij")
    azimuth = scene.phi + np.pi
    middle = direction(VIEW, azimuth)
    right = direction(np.pi / 2, azimuth + np.pi / 2)
    above = np.cross(middle, right)
    half = 2 * np.tan(FIELD_OF_VIEW / 2)
    wo = middle[:, None] + half * (np.outer(above, up.ravel()) + np.outer(right, side.ravel()))
    wo /= np.linalg.norm(wo, axis=0)
    return Lobe(LIGHT, scene.wi(LIGHT), wo, np.full(PIXELS**2, 1.0))


SCENE = Scene(Conductor(), Ggx(1.0, 1.0), (LIGHT,))


def wang_17(settings: Settings) -> Tables:
    """`error_over_time` of mirror facets of GGX slopes."""
    replicates = settings.pick(4, REPLICATES)
    return {"wang_17": error_over_time(SCENE, settings.seed, replicates)}


def error_over_time(scene: Scene, seed: int, replicates: int = REPLICATES) -> Table:
    """Relative error of the slab's image for each roughness, estimator and number
    of samples. Errors are of the noise alone, each estimator about its own model's truth."""
    rows = []
    for alpha in ALPHAS:
        there = _of_roughness(scene, alpha)
        found = {
            name: noise(make(name, there), slab(there), seed, replicates, name, repr(there.alpha))
            for name in ESTIMATORS
            if name != "exact" or not there.material.transmits
        }
        walk = found["walk"]
        for name, one in found.items():
            gain = walk.variance * walk.seconds / (one.variance * one.seconds)
            spread = np.hypot(walk.stderr / walk.variance, one.stderr / one.variance)
            spread = np.hypot(spread, walk.seconds_stderr / walk.seconds)
            spread = np.hypot(spread, one.seconds_stderr / one.seconds)
            # A walk that never met a second facet has only rounding for an error.
            known = min(walk.variance, one.variance) > np.finfo(float).eps
            for n in SAMPLES:
                error = n * one.seconds, one.variance / n, one.stderr / n
                gains = (gain, gain * spread) if known else (np.nan, np.nan)
                rows.append((name, *there.alpha, n, *map(float, (*error, *gains))))
    return from_rows(COLUMNS, rows)


def _of_roughness(scene: Scene, alpha: float) -> Scene:
    scale = alpha / max(scene.alpha)
    return scene.of_roughness((scale * scene.alpha[0], scale * scene.alpha[1]))
