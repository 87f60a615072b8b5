"""The surface along a ray, drawn height by height: given the facet that the ray left and the last
heights that it passed over.

All of these and the height that comes next are jointly Gaussian. All rays step together, so that
what the next height is made of is the same few numbers for all of them. Between two heights the
surface is what it is on the mean, given those about it. Where it rises above the ray the ray has
met it, and its slope and curvature there are drawn as well. So that the ray is free so far is no
probability here, as in `hazard`: it is what the heights are.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from msbsdf_cli.memory.correlation import correlation
from surfaces.batch import Batch, concatenate
from surfaces.facet import Array
from surfaces.spectrum import Spectrum

STEP = 0.6
"""Distance between two heights, where slopes have variance 1 and curvatures 3, as those of a
Gaussian spectrum; shorter where the surface is bent more."""

HEIGHTS = 8
"""Heights remembered: those of three correlation lengths of a Gaussian spectrum."""

BETWEEN = 5
"""Places at which the surface is looked at in a step, the last of them the next height."""

TOP = 6.0
"""Height above which rays that climb meet nothing, but 1e-9 of the time."""

LEVEL = 1e-3
"""Slope of a ray that is as good as level."""

LEAST = 1e-18
"""Share of the power of waves that are left out."""

ANGLES = 24
"""Directions of waves over a right angle."""


@dataclass(frozen=True, eq=False)
class Profile:
    """What is drawn at each step, the last of them for all beyond, where the facet is forgotten."""

    step: float
    """Distance between two heights."""
    next: Array
    """Weights of the facet's height, slope and second derivative and of the last heights, oldest
    first, in the mean of the next height, (steps, 3 + heights)."""
    spread: Array
    """Its deviation, (steps,)."""
    between: Array
    """Weights of these and of the next height in the means of the height and its first three
    derivatives at each place of the step, (steps, places, 4, 4 + heights)."""
    noise: Array
    """What slope and second derivative scatter about that, as lower triangles,
    (steps, places, 2, 2)."""


@dataclass
class Crossings(Batch):
    """Where rays meet the surface, arrays (n,)."""

    slot: Array
    """Number of the ray."""
    x: Array
    """Distance."""
    h: Array
    slope: Array
    second: Array
    """Second derivative along the ray."""


@lru_cache(maxsize=2)
def profile(spectrum: Spectrum) -> Profile:
    """That of surfaces of a spectrum."""
    cor = correlation(spectrum)
    step = STEP * float(np.sqrt(3 / cor.fourth))
    last = int(cor.x[-1] / step) + HEIGHTS + 1
    wave, root = _waves(spectrum)
    rows = [_step(wave, root, step, j, j < last) for j in range(1, last + 1)]
    return Profile(step, *(np.array(a) for a in zip(*rows, strict=True)))


def _waves(spectrum: Spectrum) -> tuple[Array, Array]:
    """Wave numbers along a line and the roots of their shares of the power, (n,)."""
    wave, share = spectrum.waves
    wave, share = wave[share > LEAST], share[share > LEAST]
    cos = np.cos((np.arange(ANGLES) + 0.5) * (np.pi / 2 / ANGLES))
    along = np.multiply.outer(wave * np.sqrt(0.5), cos).ravel()
    return along, np.sqrt(np.repeat(share / ANGLES, ANGLES))


def _vectors(wave: Array, root: Array, x: float) -> list[Array]:
    """Vectors of the height and its first three derivatives at `x`, whose inner products are their
    covariances: in these, heights that are nearly equal differ to all digits."""
    c, s = root * np.cos(wave * x), root * np.sin(wave * x)
    square = wave * wave
    slope = -s * wave, c * wave
    parts = (c, s), slope, (-c * square, -s * square), (-slope[0] * square, -slope[1] * square)
    return [np.concatenate(part) for part in parts]


def _step(
    wave: Array, root: Array, step: float, j: int, facet: bool
) -> tuple[Array, Array, Array, Array]:
    """The rows of `Profile` for step `j`, with or without the `facet`."""
    known = _vectors(wave, root, 0)[:3] if facet else []
    blank = np.zeros(3 - len(known) + HEIGHTS - min(j - 1, HEIGHTS))
    passed = [_vectors(wave, root, i * step)[0] for i in range(max(j - HEIGHTS, 1), j)]
    first, n = len(known), len(known) + len(passed)
    places = [_vectors(wave, root, (j - 1 + (k + 1) / BETWEEN) * step) for k in range(BETWEEN)]
    columns = [*known, *passed, places[-1][0], *(v for place in places for v in place)]
    T = np.linalg.qr(np.stack(columns, axis=1)).R

    def padded(weights: Array) -> Array:
        return np.concatenate([weights[:first], blank, weights[first:]])

    one = padded(np.linalg.solve(T[:n, :n], T[:n, n]))
    n += 1
    mean = np.linalg.solve(T[:n, :n], T[:n, n:])
    between = np.stack([padded(w) for w in mean.T]).reshape(BETWEEN, 4, -1)
    rest = T[n:, n:].reshape(-1, BETWEEN, 4)[..., 1:3]
    low = [np.linalg.qr(rest[:, k]).R.T for k in range(BETWEEN)]
    return one, np.abs(T[n - 1, n - 1]), between, np.stack(low)


def draw(found: Profile, facet: Array, rng: np.random.Generator) -> Crossings:
    """Where rays meet the surface that leave facets at 0 with `facet` (4, n): by how much they are
    steeper than it, its height, its slope and its second derivative."""
    delta, start = facet[0], facet[1:]
    climb = start[1] + delta
    climb = np.where(np.abs(climb) > LEVEL, climb, np.copysign(LEVEL, climb))
    lanes, passed, met, j = np.arange(delta.size), np.zeros((HEIGHTS, delta.size)), [], 0
    while lanes.size:
        i = min(j, found.spread.size - 1)
        known = np.concatenate([start, passed])
        new = found.next[i] @ known + found.spread[i] * rng.standard_normal(lanes.size)
        known = np.concatenate([known, new[None]])
        x = (j + (np.arange(BETWEEN) + 1) / BETWEEN) * found.step
        above = found.between[i, :, 0] @ known - (start[0] + np.multiply.outer(x, climb))
        over = above > 0
        hit = over.any(axis=0)
        some = np.flatnonzero(hit)
        if some.size:
            rays = [a.take(some, axis=-1) for a in (known, start[0], delta, climb, above)]
            met.append(Crossings(lanes.take(some), *_crossings(found, j, rng, *rays)))
        on = np.flatnonzero(~hit & ((climb < 0) | (start[0] + climb * x[-1] < TOP)))
        passed = known[4:]
        if on.size < lanes.size:
            lanes, climb, delta = lanes.take(on), climb.take(on), delta.take(on)
            start, passed = start.take(on, axis=1), passed.take(on, axis=1)
        j += 1
    return concatenate(met) if met else Crossings(lanes, *np.zeros((4, 0)))


def _crossings(
    found: Profile,
    j: int,
    rng: np.random.Generator,
    known: Array,
    h: Array,
    delta: Array,
    climb: Array,
    above: Array,
) -> tuple[Array, ...]:
    """Distances, heights, slopes and second derivatives where rays cross the surface in step `j`:
    `above` (places, n) is how far it rises above them."""
    lanes, length = np.arange(h.size), found.step / BETWEEN
    k = (above > 0).argmax(axis=0)
    last = known[-2] - (h + climb * (j * found.step)) if j else -delta * length
    before = np.where(k > 0, above[k - 1, lanes], last)
    rest = above[k, lanes] / (above[k, lanes] - before) * length
    x = (j * BETWEEN + k + 1) * length - rest
    step = min(j, found.spread.size - 1)
    mean = np.einsum("nmk,kn->mn", found.between[step][k, 1:], known)
    low, z = found.noise[step][k], rng.standard_normal((2, lanes.size))
    second = mean[1] + low[:, 1, 0] * z[0] + low[:, 1, 1] * z[1]
    slope = mean[0] + low[:, 0, 0] * z[0] - rest * (second - rest * mean[2] / 2)
    second -= rest * mean[2]
    # It rises through the ray, which where it all but touches it rounding may hide.
    steeper = np.maximum(slope - climb, np.finfo(np.float32).eps)
    if j == 0:
        near = np.flatnonzero(k == 0)
        bend, gap = known[2, near], delta[near]
        x[near], steeper[near], second[near] = _next_to_facet(gap, bend, above[0, near], length)
    return x, h + climb * x, climb + steeper, second


def _next_to_facet(delta: Array, bend: Array, above: Array, x: float) -> tuple[Array, ...]:
    """Where a ray crosses the surface before `x`, how much steeper than the ray that is there, and
    the second derivative: of the cubic curve that is `above` the ray at `x` and leaves it at 0
    with a slope that is less by `delta`, bent by `bend`."""
    third = 6 * (above + x * (delta - bend * x / 2)) / x**3
    # Without the root at 0 a parabola is left, of which this is the first root.
    root = np.sqrt(np.maximum(bend * bend / 4 + delta * third * (2 / 3), 0))
    where = 2 * delta / (bend / 2 + root)
    steeper = where * (bend + where * third / 2) - delta
    return where, np.maximum(steeper, np.finfo(np.float32).eps), bend + third * where
