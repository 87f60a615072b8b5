"""What the methods are judged by: the Smith model, better known than any of them knows it."""

import time
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from msbsdf_cli.experiments.tradeoff.directions import Lobe
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.repetitions import inner_products, taken_apart
from surfaces.facet import Array
from surfaces.streams import stream

RESOLUTIONS = (0.5, 0.7, 1.0)
"""Of `solve`, tried in turn; 1 is what the method itself takes for enough. The coarser solution
that tells the error of the first, 3/4 as fine, is still finer than all that it judges."""

TRIAL = 0.25
"""Of two roughnesses before these: 0.2 s tell what 20 s would not do better, see `GAIN`."""

ENOUGH = 1e-6
"""Wanted relative error of a solved reference where `solve` itself is judged: a hundred times below
what is worth a chart."""

ENOUGH_FOR_A_WALK = 0.01
"""The same where only walks are judged, over the root of their number: the least noise of a walk is
ten times that."""

TOLERABLE = 2e-3
"""Beyond it, walks may do better."""

GAIN = 3
"""Where walks do so many times better than `solve`, no finer resolution catches up: of roughness
0.5,0.05 it is off by .04, .025 and .0065, after 1, 6 and 25 s, and walks are by .0026."""

PATIENCE_S = 4
"""After so many seconds no finer resolution is tried."""

PARTS = 8
"""Independent parts of a reference by chance; their spread is its noise."""

MORE_WALKS = 32
"""Walks of a reference by chance for one of the dearest setting it judges: if that has no less
variance, it is sqrt(MORE_WALKS), nearly 6 times, further from the truth."""


@dataclass(frozen=True)
class Reference:
    """Values (channels, orders + 1, n) for each lobe, and how far they may be from the truth."""

    method: str
    resolution: float
    """Of `solve`; not a number for another method."""
    values: list[Array]
    noise: list[float]
    """Relative error of the sum over orders: for `solve` the difference of two resolutions."""
    seconds: float


def reference(
    scene: Scene,
    lobes: list[Lobe],
    methods: tuple[str, ...],
    samples: int,
    seed: int,
    purpose: str = "chart",
) -> Reference:
    """By `solve`, ever finer until its own estimate is enough to judge `methods` of at most
    `samples` walks, or it takes too long; where it does not hold, or not well, by many walks from
    both ends."""
    started = time.perf_counter()
    enough = ENOUGH if Solve.name in methods else ENOUGH_FOR_A_WALK / np.sqrt(samples)
    chance = lru_cache(partial(_by_walks, scene, lobes, MORE_WALKS * samples, seed, purpose))
    try:
        Solve.check_supported(scene.slopes, scene.material)
    except UnsupportedError:
        return chance()
    isotropic = len(set(scene.alpha)) == 1
    for resolution in RESOLUTIONS if isotropic else (TRIAL, *RESOLUTIONS):
        best = found = _solved(scene, lobes, resolution)
        if max(found.noise) >= TOLERABLE:
            best = min(found, chance(), key=lambda r: max(r.noise))
        seconds = time.perf_counter() - started
        hopeless = GAIN * max(best.noise) < max(found.noise)
        if max(best.noise) < enough or hopeless or seconds > PATIENCE_S:
            break
    return replace(best, seconds=seconds)


def _solved(scene: Scene, lobes: list[Lobe], resolution: float) -> Reference:
    solve = Solve(scene.slopes, scene.material, scene.orders, resolution)
    found = [solve.evaluate(lobe.wi, lobe.wo) for lobe in lobes]
    # Errors of orders need not have one sign: their sum is an upper bound.
    noise = [
        relative(e.stderr, e.value, lobe.solid_angle) for e, lobe in zip(found, lobes, strict=True)
    ]
    return Reference("solve", resolution, [e.value for e in found], noise, 0.0)


def references(
    scene: Scene,
    lobes: list[Lobe],
    others: list[Lobe],
    methods: tuple[str, ...],
    samples: int,
    seed: int,
) -> tuple[Reference, Reference]:
    """References for two sets of lobes, set up once."""
    both = reference(scene, [*lobes, *others], methods, samples, seed)
    n = len(lobes)
    first, second = (
        replace(both, values=both.values[part], noise=both.noise[part])
        for part in (slice(n), slice(n, None))
    )
    return first, second


def relative(difference: Array, truth: Array, weight: Array) -> float:
    """Root mean square over directions of orders' `difference`, over that of the truth."""
    over, under = (float((a.sum(axis=1) ** 2 * weight).sum()) for a in (difference, truth))
    return float(np.sqrt(over / under))


def _by_walks(
    scene: Scene, lobes: list[Lobe], samples: int, seed: int, purpose: str = "chart"
) -> Reference:
    started = time.perf_counter()
    method = METHODS["walk-low-variance"](scene.slopes, scene.material, scene.orders)
    values, noise = [], []
    for i, lobe in enumerate(lobes):
        rng = stream(seed, "reference walks", purpose, i)
        size = max(2, samples // PARTS)
        parts = np.stack([method.evaluate(lobe.wi, lobe.wo, size, rng).value for _ in range(PARTS)])
        mean = parts.mean(axis=0)
        gram = inner_products((parts - mean).sum(axis=2), lobe.solid_angle)
        scale = (mean.sum(axis=1) ** 2 * lobe.solid_angle).sum()
        # Deviations from their own mean: r - 1 of r are free.
        variance = taken_apart(gram).total * PARTS / (PARTS - 1) / PARTS
        values.append(mean)
        noise.append(float(np.sqrt(variance / scale)))
    seconds = time.perf_counter() - started
    return Reference("walk-low-variance", np.nan, values, noise, seconds)
