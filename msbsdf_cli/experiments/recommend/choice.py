"""Of the candidates for a surface, the cheapest within the tolerance."""

from dataclasses import dataclass
from functools import partial

from msbsdf_cli.experiments.recommend.candidates import (
    Candidate,
    cases,
    compensated,
    single_bound,
    truncated,
)
from msbsdf_cli.experiments.recommend.scene_file import SceneSurface
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress

CHOSEN, TOO_FAR, CLOSE, NOT_NEEDED = "chosen", "too far", "close", "not needed"
"""Verdicts: `close` is too far by less than the error of its error."""


@dataclass(frozen=True)
class Recommendation:
    """What a surface needs; or, without candidates, why that cannot be said."""

    surface: SceneSurface
    candidates: list[Candidate]
    """The cheapest first."""
    verdicts: list[str]
    reason: str = ""

    @property
    def chosen(self) -> Candidate | None:
        """The cheapest candidate within the tolerance."""
        pairs = zip(self.candidates, self.verdicts, strict=True)
        return next((c for c, verdict in pairs if verdict == CHOSEN), None)


def recommend(
    surfaces: list[SceneSurface], tolerance: float, workers: Workers, quiet: bool
) -> list[Recommendation]:
    """What each surface needs for errors of at most `tolerance`, a number above 0."""
    found = []
    with Progress("recommend", len(surfaces), "surfaces", quiet) as progress:
        work = partial(_recommend, tolerance=tolerance)
        for one in map_ordered(work, surfaces, workers):
            found.append(one)
            progress.advance(1)
    return found


def _recommend(surface: SceneSurface, tolerance: float) -> Recommendation:
    bound = single_bound(surface)
    if bound.error + bound.uncertainty <= tolerance:
        # Nothing is cheaper: no work on what is dearer.
        return Recommendation(surface, [bound], [CHOSEN])
    try:
        solved = cases(surface)
        candidates = [*truncated(solved), *compensated(solved)]
    except (UnsupportedError, ArithmeticError) as reason:
        return Recommendation(surface, [], [], str(reason))
    candidates.sort(key=lambda c: (c.facets, c.bounces != 1, c.error))
    return Recommendation(surface, candidates, _verdicts(candidates, tolerance))


def _verdicts(candidates: list[Candidate], tolerance: float) -> list[str]:
    verdicts: list[str] = []
    for candidate in candidates:
        if CHOSEN in verdicts:
            verdicts.append(NOT_NEEDED)
        elif candidate.error + candidate.uncertainty <= tolerance:
            verdicts.append(CHOSEN)
        else:
            near = candidate.error - candidate.uncertainty <= tolerance
            verdicts.append(CLOSE if near else TOO_FAR)
    return verdicts
