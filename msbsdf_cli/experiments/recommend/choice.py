"""Of the candidates for a surface, the cheapest within the tolerance."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from msbsdf_cli.experiments.recommend.candidates import (
    Candidate,
    compensated,
    single_bound,
    truncated,
)
from msbsdf_cli.experiments.recommend.cases import cases
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.experiments.recommend.surfaces import against_surfaces
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress

CHOSEN, TOO_FAR, CLOSE, NOT_NEEDED = "chosen", "too far", "close", "not needed"
"""Verdicts: `close` is too far by less than the error of its error."""

NEAREST = "nearest"
"""The verdict on the cheapest candidate of those that nothing is known to beat, where none is
within the tolerance: more work is pointless."""


@dataclass(frozen=True)
class Wanted:
    """What a model of a surface must reach."""

    tolerance: float
    """Largest error of directional albedo and lobe, over the light that a surface returns."""
    colour: float = 1.0
    """Largest colour difference, CIEDE2000."""

    @property
    def scale(self) -> float:
        """What a colour difference is times, so that both reach the tolerance together."""
        return self.tolerance / self.colour


@dataclass(frozen=True)
class Recommendation:
    """What a surface needs; or, without candidates, why that cannot be said."""

    surface: SceneSurface
    candidates: list[Candidate]
    """The cheapest first."""
    verdicts: list[str]
    reason: str = ""
    bound_only: bool = False
    """Whether errors are upper bounds, which were enough."""

    @property
    def chosen(self) -> Candidate | None:
        """The cheapest candidate within the tolerance, or the one that comes nearest to it."""
        pairs = zip(self.candidates, self.verdicts, strict=True)
        return next((c for c, verdict in pairs if verdict in (CHOSEN, NEAREST)), None)

    @property
    def floor(self) -> Candidate | None:
        """The Smith model of all bounces."""
        return next((c for c in self.candidates if c.follows_all), None)


def recommend(
    surfaces: list[SceneSurface], wanted: Wanted, seed: int, workers: Workers, quiet: bool
) -> list[Recommendation]:
    """What each surface needs, against the Smith model of all bounces."""
    work = partial(_against_smith, wanted=wanted, seed=seed)
    return _each(surfaces, work, workers, quiet)


def recommend_by_surfaces(
    surfaces: list[SceneSurface],
    wanted: Wanted,
    rays: int,
    seed: int,
    workers: Workers,
    quiet: bool,
) -> list[Recommendation]:
    """What each surface needs, against light traced on explicit surfaces; `rays` for each angle,
    roughness and channel."""

    def work(surface: SceneSurface) -> Recommendation:
        return judged(
            surface, wanted, lambda: against_surfaces(surface, rays, seed, workers, wanted.scale)
        )

    # All workers trace one surface after the other.
    return _each(surfaces, work, 1, quiet)


def _each(
    surfaces: list[SceneSurface],
    work: Callable[[SceneSurface], Recommendation],
    workers: Workers,
    quiet: bool,
) -> list[Recommendation]:
    found = []
    with Progress("recommend", len(surfaces), "surfaces", quiet) as progress:
        for one in map_ordered(work, surfaces, workers):
            found.append(one)
            progress.advance(1)
    return found


def _against_smith(surface: SceneSurface, wanted: Wanted, seed: int) -> Recommendation:
    bound = single_bound(surface, wanted.scale)
    if bound.bound <= wanted.tolerance:
        # Nothing is cheaper: no work on what is dearer.
        return Recommendation(surface, [bound], [CHOSEN], bound_only=True)

    def candidates() -> list[Candidate]:
        solved = cases(surface)
        found = truncated(solved, wanted.scale)
        # No walks where single scattering, than which nothing is cheaper, turns out to be enough.
        enough = found[0].bound <= wanted.tolerance
        return found if enough else found + compensated(solved, wanted.scale, seed)

    return judged(surface, wanted, candidates)


def judged(
    surface: SceneSurface, wanted: Wanted, candidates: Callable[[], list[Candidate]]
) -> Recommendation:
    """The verdict on candidates, the cheapest first; or why there are none."""
    try:
        found = sorted(candidates(), key=lambda c: (c.cost, c.bounces != 1, c.error))
    except (UnsupportedError, ArithmeticError) as reason:
        return Recommendation(surface, [], [], str(reason))
    return Recommendation(surface, found, _verdicts(found, wanted.tolerance))


def _verdicts(candidates: list[Candidate], tolerance: float) -> list[str]:
    least = min(c.bound for c in candidates)
    reached = least <= tolerance
    verdicts: list[str] = []
    for candidate in candidates:
        if CHOSEN in verdicts or NEAREST in verdicts:
            verdicts.append(NOT_NEEDED)
        elif reached and candidate.bound <= tolerance:
            verdicts.append(CHOSEN)
        elif not reached and candidate.error <= least:
            verdicts.append(NEAREST)
        else:
            verdicts.append(CLOSE if candidate.least <= tolerance else TOO_FAR)
    return verdicts
