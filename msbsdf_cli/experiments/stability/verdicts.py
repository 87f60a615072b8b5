"""From figures to a verdict and its reasons."""

from collections.abc import Iterator

import numpy as np
from scipy import stats

from msbsdf_cli.experiments.stability.points import UNIFORM
from msbsdf_cli.experiments.stability.probes import DIRECTIONS, DIRECTIONS_SOLVED, REPEATS, Figures
from msbsdf_cli.experiments.stability.truth import Truth
from msbsdf_cli.methods.traits import Traits
from surfaces.facet import Array

WORKS, DEGRADED, FAILS, REFUSED, UNKNOWN = "works", "degraded", "fails", "refused", "unknown"
VERDICTS = (WORKS, DEGRADED, FAILS, REFUSED, UNKNOWN)
"""From the best to the worst, then those of cells that were not, or cannot be, judged."""

VISIBLE, WRONG = 0.01, 0.05
"""Errors of energy, as parts of the incident one: of a picture that somebody would see, and of one
that nobody would take for the material."""

CHANCE = 5e-7
"""Probability of a figure by chance below which it is none: of the 20 000 figures of a map one in a
hundred maps."""

SIGNIFICANT = float(stats.t.isf(CHANCE / 2, REPEATS - 1))
"""That in standard errors, which are themselves known from the spread of `REPEATS` only."""

FOREIGN = 1e-7
"""Likewise, of a chi-square test."""

NARROW = 2 / (REPEATS * DIRECTIONS)
"""Product of the roughnesses below which the lobes of later orders, some pi times that in solid
angle, are narrower than the directions of a hemisphere are dense: most would be missed. The first
order, which is known in closed form, and samples remain."""

ONLY_FIRST = "judged by its first order and its samples: later lobes are too narrow to be found"

FEW = 1
"""Directions in which values may lie apart by chance, as their errors are estimates as well."""

SLOW = 30
"""Times the seconds of the same method at ordinary roughness."""


def judge(
    figures: Figures, truth: Truth, traits: Traits, deterministic: bool, slowdown: float
) -> tuple[str, list[str], float]:
    """Verdict, reasons, and the greatest error of an energy."""
    reasons: list[tuple[str, str]] = []
    if figures.nonfinite:
        reasons.append((FAILS, f"{figures.nonfinite} values are not finite"))
    if figures.negative:
        reasons.append((FAILS, f"{figures.negative} values are negative"))
    extremes = truth.point.parameter == UNIFORM
    worst, known = 0.0, 0
    if not extremes:
        for what, error, noise in _energy_errors(figures, truth, traits, deterministic):
            if np.isfinite(error) and what == "first order" and noise > VISIBLE:
                reasons.append((DEGRADED, f"values of the first order scatter by {noise:.1g}"))
            if not np.isfinite(error) or noise > WRONG / 2:
                continue
            known += 1
            if abs(error) > abs(worst):
                worst = error
            grade = _grade(error, noise)
            if grade != WORKS:
                reasons.append((grade, f"{what} off by {error:+.2g} +- {noise:.1g}"))
    if not traits.samples and figures.stderr is not None and figures.stderr.max() > VISIBLE:
        reasons.append((DEGRADED, f"states an error of {figures.stderr.max():.1g} itself"))
    if figures.chi_square_p < FOREIGN:
        reasons.append(
            (FAILS, f"directions of another distribution (p {figures.chi_square_p:.0e})")
        )
    if figures.one_way_z > SIGNIFICANT and figures.one_way > VISIBLE:
        grade = FAILS if figures.one_way > 10 * VISIBLE else DEGRADED
        reasons.append((grade, f"not reciprocal, by {figures.one_way:.0%} of a value"))
    if figures.uncovered > FEW:
        reasons.append(
            (
                DEGRADED,
                f"stated errors do not cover {figures.covered_by} in {figures.uncovered} of "
                f"{DIRECTIONS_SOLVED} directions",
            )
        )
    if figures.tail_index + 3 * figures.tail_stderr < 2:
        index = f"{figures.tail_index:.1f} +- {figures.tail_stderr:.1f}"
        reasons.append((DEGRADED, f"variance without bound: tail index {index}"))
    if slowdown > SLOW:
        reasons.append((DEGRADED, f"{slowdown:.0f} times slower than at ordinary roughness"))
    for grade in (FAILS, DEGRADED):
        if any(g == grade for g, _ in reasons):
            return grade, [text for _, text in sorted(reasons)], worst
    if not known and not extremes:
        return UNKNOWN, ["no truth of the energies here, or too much noise"], worst
    return WORKS, [ONLY_FIRST] if _narrow(truth, traits) and not extremes else [], worst


def apart(figures: Figures, other: Figures) -> str | None:
    """A sentence where the energies of two precisions differ by more than chance and what is
    visible, or None."""
    pairs = zip(figures.energy, figures.stderr, other.energy, other.stderr, strict=True)  # type: ignore[arg-type]
    for order, (one, error, two, other_error) in enumerate(pairs, 1):
        difference, noise = float(one - two), float(np.hypot(error, other_error))
        if abs(difference) > max(SIGNIFICANT * noise, VISIBLE):
            return f"order {order} differs by {difference:+.2g} from that"
    return None


def _grade(error: float, noise: float) -> str:
    if abs(error) <= SIGNIFICANT * noise or abs(error) <= VISIBLE:
        return WORKS
    return FAILS if abs(error) > WRONG else DEGRADED


def _energy_errors(
    figures: Figures, truth: Truth, traits: Traits, deterministic: bool
) -> Iterator[tuple[str, float, float]]:
    """What, its error, and the standard error of that, both noise and what the truth is off by."""
    assert figures.energy is not None
    assert figures.stderr is not None
    energy, stderr = figures.energy, figures.stderr
    if traits.smith_first:
        first, first_error = truth.first(traits.correlated)
        yield "first order", energy[0] - first, float(np.hypot(stderr[0], first_error))
    if traits.conserves_energy:
        yield "samples", figures.sampled - truth.total, figures.sampled_stderr
    if _narrow(truth, traits):
        return
    if traits.conserves_energy:
        noise = float(np.hypot(_together(stderr), figures.unresolved))
        yield "all orders", float(energy.sum()) - truth.total, noise
    if traits.model not in ("smith", "published"):
        return
    known = truth.walked if deterministic else truth.solved
    if known is None:
        return
    names = [f"order {k}" for k in range(1, energy.size)] + ["later orders"]
    for k in range(1, energy.size):
        noise = float(np.hypot(stderr[k], known.error[k]))
        yield f"{names[k]} ({known.source})", float(energy[k] - known.value[k]), noise


def _narrow(truth: Truth, traits: Traits) -> bool:
    slopes = truth.point.scene.slopes
    return traits.samples and slopes.alpha_x * slopes.alpha_y < NARROW


def _together(stderr: Array) -> float:
    """Of the sum of orders that may be noisy together."""
    return float(stderr.sum())
