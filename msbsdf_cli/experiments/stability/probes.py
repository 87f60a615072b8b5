"""What is measured of one method at one point, in one precision."""

import itertools
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from msbsdf_cli.experiments.outgoing_directions import outgoing_directions
from msbsdf_cli.experiments.stability.extremes import ENDS, Extremes
from msbsdf_cli.experiments.stability.points import HORIZON
from msbsdf_cli.experiments.stability.truth import Truth
from msbsdf_cli.methods.base import outgoing
from msbsdf_cli.methods.protocol import Method
from msbsdf_cli.methods.single import Single, first_order
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.walk import random_walk
from surfaces.facet import Array
from surfaces.streams import stream

DIRECTIONS, DIRECTIONS_SOLVED = 32, 8
"""Outgoing directions of a repetition, half from the first facet and half from cosine lobes; fewer
of `solve`, whose values cost most, and whose energies are known without them."""
REPEATS = 16
"""Independent repetitions, whose spread is the error."""
WALKS = 256
"""Walks of a repetition, of as few facets as at ordinary roughness; fewer where they are longer."""
SAMPLES = 4_096
"""Directions drawn by the method's own sampler."""
COSINES, AZIMUTHS = 10, 4
"""Bins of the chi-square test: quantiles of long walks in the cosine, and quarters in azimuth,
turned so that the plane of incidence is no border."""
RESOLVED = 1e-5
"""Least width of a bin: a hundred times the spacing of cosines in single precision."""
FAR = 6.0
"""Stated errors by which two values may differ; what may have been missed is in them."""
TAILED = "outgoing"
TAIL_DIRECTIONS, TAIL_SUMS, TAIL_WALKS, TAIL_SHARE = 8, 100, 8, 0.08
"""Where tails are looked at, and in how many directions and sums, of how many walks; the share of
the sums that is tail."""
PAIRS = 3
"""Pairs of directions that are exchanged."""
GRAZING_OUT = (
    *(1.5, 1.57, HORIZON - 1e-7, HORIZON, np.pi / 2),
    *(np.pi - HORIZON, np.pi / 2 + 1e-7, 1.5709, 1.6),
)
"""Polar angles of outgoing directions around the horizon."""


@dataclass
class Figures:
    """What was measured; NaN where a method does not have it."""

    walks: int
    """Walks of a repetition."""
    nonfinite: int = 0
    negative: int = 0
    energy: Array | None = None
    """Of each order, both sides, (orders + 1,)."""
    stderr: Array | None = None
    sampled: float = float("nan")
    """Energy of the method's own samples."""
    sampled_stderr: float = 0.0
    chi_square_p: float = float("nan")
    """Probability that samples of the truth differ so much from long walks."""
    one_way: float = float("nan")
    """Greatest relative difference of a value from that of exchanged directions, and how many
    standard errors it is."""
    one_way_z: float = 0.0
    uncovered: int = 0
    """Outgoing directions in which two independent values differ by more than their errors say."""
    covered_by: str = ""
    """What they were held against."""
    tail_index: float = float("nan")
    """Of what walks add to a value, from the second order on: below 2 the variance has no
    bound."""
    tail_stderr: float = 0.0
    unresolved: float = 0.0
    seconds: float = 0.0
    """Of the last evaluation for energies."""


def measure(method: Method, truth: Truth, dtype: type, seed: int) -> Figures:
    """All figures of a method at a point, in a precision."""
    figures = Figures(walks=walks_for(truth))
    place = method.name, np.dtype(dtype).name, *truth.point.place
    count = itertools.count()
    before: int = getattr(method, "hidden", 0)

    def rng() -> Any:
        found = stream(seed, "stability", *place, next(count))
        ends = truth.point.value
        if ends in ENDS and not method.deterministic:
            return Extremes(found, str(ends), closed=method.name == "published")
        return found

    with np.errstate(all="ignore"):
        _energies(figures, method, truth, dtype, rng, seed)
        if method.traits.samples:
            _samples(figures, method, truth, dtype, rng, seed)
        # Each incident direction costs `solve` seconds, and its F is symmetric by construction.
        if method.traits.reciprocal and truth.point.value not in ENDS and method.traits.samples:
            _exchanged(figures, method, truth, dtype, rng)
        if not method.deterministic and truth.point.value not in ENDS:
            _covered(figures, method, truth, dtype, rng, seed)
            if truth.point.parameter == TAILED:
                _tail(figures, method, truth, dtype, rng)
    hidden: int = getattr(method, "hidden", 0)
    figures.nonfinite += hidden - before
    return figures


def walks_for(truth: Truth) -> int:
    """Walks of a repetition: a power of two, fewer where they are longer."""
    return int(2 ** round(np.log2(max(WALKS / (1 + truth.bounces / 4), 16))))


def seconds(method: Method, truth: Truth, dtype: type, walks: int, seed: int) -> float:
    """The lesser of two evaluations of the directions of one repetition."""
    wo: Array = directions(truth, 0, seed)[0].astype(dtype)
    took = []
    for k in range(2):
        rng = stream(seed, "stability timing", method.name, walks, k)
        started = time.perf_counter()
        method.evaluate(truth.wi.astype(dtype), wo, walks, rng)
        took.append(time.perf_counter() - started)
    return min(took)


def _count(figures: Figures, array: Array, error: Array | float = 0.0) -> None:
    """Count what is not finite, and what is negative by more than its own error and rounding."""
    finite = np.isfinite(array)
    figures.nonfinite += int(array.size - finite.sum())
    largest = np.abs(np.where(finite, array, 0)).max(initial=0)
    rounding = np.finfo(array.dtype).eps * largest
    figures.negative += int((array < -np.maximum(error, rounding)).sum())


def _energies(
    figures: Figures, method: Method, truth: Truth, dtype: type, rng: Any, seed: int
) -> None:
    """Energy of each order, by values in directions whose density is known; of the first order
    only what it has more than the closed form in double precision."""
    scene, wi = truth.point.scene, truth.wi
    walks = figures.walks
    known = method.albedo(wi)
    if known is not None:
        # A method that knows its energies without adding up values is asked.
        figures.energy, figures.stderr = (a.mean(axis=0) for a in known)
        _count(figures, *known)
        wo = directions(truth, 0, seed, DIRECTIONS_SOLVED)[0]
        solved = truth.values(wo) if method.name == Solve.name else None
        if solved is not None:
            values, figures.seconds = solved
        else:
            started = time.perf_counter()
            values = method.evaluate(wi.astype(dtype), wo.astype(dtype), walks, rng())
            figures.seconds = time.perf_counter() - started
        _count(figures, values.value, values.stderr)
        return
    correlated = method.traits.correlated
    first, _ = truth.first(correlated)
    found = []
    for repeat in range(1 if method.deterministic else REPEATS):
        wo, share = directions(truth, repeat, seed)
        if method.deterministic:
            more = [directions(truth, r, seed) for r in range(1, REPEATS)]
            wo = np.hstack([wo, *(w for w, _ in more)])
            share = np.concatenate([share, *(s for _, s in more)])
        rounded: Array = wo.astype(dtype)
        started = time.perf_counter()
        values = method.evaluate(wi.astype(dtype), rounded, walks, rng())
        figures.seconds = time.perf_counter() - started
        figures.unresolved = max(figures.unresolved, values.unresolved)
        _count(figures, values.value, values.stderr)
        _count(figures, values.stderr)
        value = np.nan_to_num(values.value.astype(float), nan=0, posinf=0, neginf=0).mean(axis=0)
        out = outgoing(scene.slopes, _exact(rounded))
        arriving = _exact(wi.astype(dtype))
        closed = first_order(scene.slopes, scene.material, arriving, out, correlated).mean(axis=0)
        value[0] -= np.nan_to_num(closed)
        parts = value * share
        if method.deterministic:
            found += [part.sum(axis=1) for part in np.split(parts, REPEATS, axis=1)]
        else:
            found.append(parts.sum(axis=1))
    runs = np.array(found)
    runs[:, 0] += first
    figures.energy = runs.mean(axis=0)
    figures.stderr = runs.std(axis=0, ddof=1) / np.sqrt(len(runs))


def _exact(w: Array) -> Array:
    """Directions as they were rounded, of length 1 in double precision."""
    w = w.astype(float)
    unit: Array = w / np.sqrt((w * w).sum(axis=0))
    return unit


def directions(
    truth: Truth, repeat: int, seed: int, number: int = DIRECTIONS
) -> tuple[Array, Array]:
    """Outgoing directions (3, n) of a repetition and their weights in a sum over all directions,
    the same for all methods and precisions."""
    scene = truth.point.scene
    rng = stream(seed, "stability directions", *truth.point.place, repeat)
    single = Single(scene.slopes, scene.material.lossless, 1)
    wo, share = outgoing_directions(single, truth.wi, number, rng)
    if truth.point.parameter == TAILED:
        asked = _extreme_directions(str(truth.point.value))
        wo, share = np.hstack([wo, asked]), np.append(share, np.zeros(asked.shape[1]))
    return wo, share


def _extreme_directions(where: str) -> Array:
    """Outgoing directions (3, n) that are only asked to have values."""
    zenith = (0.0, 1e-9, 1e-8, 1e-4, np.pi - 1e-8, np.pi)
    angles = {"zenith": zenith, "horizon": (HORIZON, np.pi / 2, np.pi - HORIZON)}
    polar = angles.get(where, GRAZING_OUT)
    found = np.stack([direction(t, p) for t in polar for p in (0.3, 0.3 + np.pi, 2.0)], axis=1)
    level = np.array([[1.0, -1, 0], [0, 0, 1], [0, -0.0, 0]])
    return np.hstack([found, level]) if where != "zenith" else found


def _samples(
    figures: Figures, method: Method, truth: Truth, dtype: type, rng: Any, seed: int
) -> None:
    """The method's own samples: their energy, and their directions against long walks."""
    n = int(max(SAMPLES / (1 + truth.bounces / 8), 1024))
    wi: Array = truth.wi.astype(dtype)
    w, weight = method.sample(wi, n, rng())
    _count(figures, weight)
    figures.nonfinite += int(w.size - np.isfinite(w).sum())
    density = method.pdf(wi, w[:, :DIRECTIONS].astype(dtype))
    _count(figures, density)
    figures.sampled = float(weight.mean())
    figures.sampled_stderr = float(weight.mean(axis=0).std() / np.sqrt(n))
    walked = method.traits.model in ("smith", "published") and np.all(weight == 1)
    same_code = method.traits.model == "smith" and dtype is np.float64
    if walked and not same_code and truth.point.value not in ENDS:
        figures.chi_square_p = _chi_square(truth, w, n, seed)


def _chi_square(truth: Truth, w: Array, n: int, seed: int) -> float:
    """Two samples of directions, of the method and of long walks in double precision, in bins."""
    scene = truth.point.scene
    rng = stream(seed, "stability reference", *truth.point.place)
    lights = random_walk(scene.slopes, scene.material, truth.wi, n, rng, 100_000)
    reference = np.concatenate([light.w for light in lights], axis=1)
    edges = np.quantile(reference[2], np.linspace(0, 1, COSINES + 1)[1:-1])
    # No bin is so narrow that rounding moves samples into another one, nor one's border where
    # cosines gather, at 0 and 1.
    edges = (np.unique(np.floor(edges / RESOLVED)) + 0.5) * RESOLVED
    counts, bins = [], (edges.size + 1) * AZIMUTHS
    for v in (w, reference):
        quarter = ((np.arctan2(v[1], v[0]) - scene.phi + np.pi / 4) // (np.pi / 2)).astype(
            int
        ) % AZIMUTHS
        row = np.searchsorted(edges, v[2].astype(float))
        counts.append(np.bincount(row * AZIMUTHS + quarter, minlength=bins))
    a, b = counts
    filled = a + b > 20
    statistic = ((a - b) ** 2 / np.maximum(a + b, 1))[filled].sum()
    return float(stats.chi2.sf(statistic, max(int(filled.sum()) - 1, 1)))


def _exchanged(figures: Figures, method: Method, truth: Truth, dtype: type, rng: Any) -> None:
    """Values of pairs of directions, both ways, over the cosine of the outgoing one."""
    walks, wi = figures.walks, truth.wi
    polar = np.linspace(0.2, 1.3, PAIRS)
    wo = np.stack([direction(t, 0.3 + 2.2 * k) for k, t in enumerate(polar)], axis=1)
    forth, forth_error = _summed(method, wi.astype(dtype), wo.astype(dtype), walks, rng)
    forth, forth_error = forth / wo[2], forth_error / wo[2]
    worst = (0.0, 0.0)
    for k in range(PAIRS):
        ends: tuple[Array, Array] = wo[:, k].astype(dtype), wi[:, None].astype(dtype)
        value, error = (float(a[0]) / wi[2] for a in _summed(method, *ends, walks, rng))
        if not np.isfinite(value):
            figures.nonfinite += 1
            continue
        noise = float(np.hypot(error, forth_error[k]))
        scale = max(abs(value), abs(float(forth[k])), np.finfo(dtype).tiny)
        apart = abs(value - float(forth[k]))
        if apart < np.finfo(dtype).eps:
            continue
        apart /= scale
        z = apart * scale / noise if noise > 0 else (np.inf if apart > 0 else 0.0)
        worst = max(worst, (min(z, 1e9), apart))
    figures.one_way_z, figures.one_way = worst


def _covered(
    figures: Figures, method: Method, truth: Truth, dtype: type, rng: Any, seed: int
) -> None:
    """Values against the truth, direction by direction, in units of the error that they state:
    against `solve` where it may be asked, else against a second, independent value."""
    wo = directions(truth, 0, seed, DIRECTIONS_SOLVED)[0]
    wi: Array = truth.wi.astype(dtype)
    solved = truth.affordable_values(wo) if method.traits.model in ("smith", "published") else None
    rounded: Array = wo.astype(dtype)
    one, error = _summed(method, wi, rounded, figures.walks, rng)
    if solved is not None:
        other, other_error = solved.value[0].sum(axis=0), solved.stderr[0].sum(axis=0)
    else:
        other, other_error = _summed(method, wi, rounded, figures.walks, rng)
    # Errors of orders add up, as the same walks make them; rounding is that of the largest value or
    # of 1, and where directions are rounded lobes move by as much.
    scene = truth.point.scene
    narrow = max(1.0, 1 / min(scene.alpha))
    rounding = np.finfo(dtype).eps * max(np.abs(one).max(), 1.0) * narrow
    apart = np.abs(one - other) - rounding
    figures.uncovered = int((apart > FAR * np.hypot(error, other_error)).sum())
    figures.covered_by = "solve" if solved is not None else "a second value"


def _tail(figures: Figures, method: Method, truth: Truth, dtype: type, rng: Any) -> None:
    """Hill's estimator over sums of few walks, whose tail is that of one walk, in directions that
    are up to grazing; each direction in units of its mean."""
    polar = np.linspace(0.3, 1.5, TAIL_DIRECTIONS)
    wo: Array = np.stack([direction(t, 0.3 + k) for k, t in enumerate(polar)], axis=1)
    wi: Array = truth.wi.astype(dtype)
    sums = np.array(
        [
            method.evaluate(wi, wo.astype(dtype), TAIL_WALKS, rng()).value[0, 1:].sum(axis=0)
            for _ in range(TAIL_SUMS)
        ],
        float,
    )
    mean = sums.mean(axis=0)
    scaled = np.sort((sums[:, mean > 0] / mean[mean > 0]).ravel())
    top = scaled[-max(int(TAIL_SHARE * scaled.size), 2) :]
    if scaled.size and top[0] > 0:
        inverse = np.log(top / top[0])[1:].mean()
        figures.tail_index = float(1 / inverse) if inverse > 0 else float("inf")
        figures.tail_stderr = figures.tail_index / np.sqrt(top.size - 1)


def _summed(method: Method, wi: Array, wo: Array, walks: int, rng: Any) -> tuple[Array, Array]:
    """Values (n,) of all orders and their errors, what walks may have missed included."""
    found = method.evaluate(wi, wo, walks, rng())
    missed = method.undersampling(wi, wo, walks, rng())[0]
    value: Array = found.value[0].sum(axis=0).astype(float)
    return value, np.hypot(found.stderr[0].sum(axis=0), missed)
