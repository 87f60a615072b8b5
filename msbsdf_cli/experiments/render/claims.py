"""What [HHdD16] says of the cost and the worth of many bounces, measured on scenes of the kind.

The paper's scenes are not at hand, nor is its renderer. Here the same small renderer, of arrays and
not of compiled code, makes each picture with and without the later bounces, from as many paths: the
ratio of the two is what is compared. Later bounces are those of `walk-low-variance`, which has the
optimisations of its Section 9.1.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.experiments.render.picture import Picture, Settings, luminance, render
from msbsdf_cli.experiments.render.scenes import stage
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import direction, in_degrees
from msbsdf_cli.smith.slopes import Beckmann, Ggx, Slopes
from surfaces.facet import Array
from surfaces.materials import Conductor, Dielectric, Diffuse, Material

PAIR = "single", "walk-low-variance"
"""Without later bounces, and with them."""

SETTINGS = Settings(96, 64, 64)
REPEATS = 6
"""Independent pairs of pictures, which take turns; their scatter is the standard error."""

GOLD = Conductor.named("gold", rgb=True)


@dataclass(frozen=True)
class Claim:
    """A line of claims.csv."""

    claim: str
    source: str
    published: float
    measured: float
    stderr: float
    verdict: str
    note: str


@dataclass(frozen=True)
class Subject:
    """A scene of which the paper says what later bounces cost."""

    figure: str
    what: str
    scene: str
    texture: str
    slopes: Slopes
    material: Material
    published: float
    """Additional render time as a fraction."""


SUBJECTS = (
    Subject("1", "glass plate, textured", "plate", "roughness", Ggx(1, 1), Dielectric(1.5), 0.19),
    Subject("17", "bottles, gold", "bottle", "none", Ggx(0.5, 0.5), GOLD, 0.87),
    Subject("18", "gold, alpha 0.3", "sphere", "none", Ggx(0.3, 0.3), GOLD, 0.24),
    *(
        Subject(
            "19", f"diffuse, alpha {a}", "sphere", "none", Ggx(a, a), Diffuse((0.9, 0.5, 0.2)), t
        )
        for a, t in ((0.1, 0.06), (0.5, 0.50), (1.0, 0.62))
    ),
    *(
        Subject("19", f"glass, alpha {a}", "sphere", "none", Ggx(a, a), Dielectric(1.5), t)
        for a, t in ((0.4, 1.0), (1.0, 2.0))
    ),
    Subject("20", "gold plate, textured", "plate", "roughness", Ggx(1, 1), GOLD, 0.27),
)

VARIANCE, ABOUT = 0.20, 0.1
DOUBLE_SCATTERING = 0.20
"""Share of light in the second order, at most, of Section 10."""
ALPHAS, THETAS = (0.25, 0.5, 1.0), (0.0, 0.5, 1.0, 1.5)
"""Roughnesses and angles of the papers' lobes."""


def claims(
    seed: int, workers: Workers, quiet: bool, size: Settings = SETTINGS, repeats: int = REPEATS
) -> list[Claim]:
    """All claims, of pictures of this size. Times are those of the processors."""
    found = []
    with Progress("claims", len(SUBJECTS) * repeats, "pairs", quiet) as progress:
        for subject in SUBJECTS:
            pairs = []
            for pair in _pairs(subject, replace(size, seed=seed), repeats, workers):
                pairs.append(pair)
                progress.advance(1)
            found += [_time(subject, pairs), _variance(subject, pairs)]
    return [*found, *_double_scattering(workers)]


def _pairs(
    subject: Subject, size: Settings, repeats: int, workers: Workers
) -> Iterator[tuple[Picture, Picture]]:
    of = stage(subject.scene, subject.texture)
    for repeat in range(repeats):
        settings = replace(size, seed=size.seed + repeat)
        # Turns are taken in both orders, so that neither method is always the one that warms up.
        order = PAIR if repeat % 2 else PAIR[::-1]
        made = render(of, subject.slopes, subject.material, order, settings, workers, True)
        by_name = {p.method: p for p in made}
        yield by_name[PAIR[0]], by_name[PAIR[1]]


def _time(subject: Subject, pairs: list[tuple[Picture, Picture]]) -> Claim:
    more, stderr = _ratio(pairs, lambda p: p.seconds)
    verdict = _verdict(more, stderr, subject.published, 0.0)
    return Claim(
        f"additional render time, {subject.what}",
        f"[HHdD16] Figure {subject.figure}",
        subject.published,
        more,
        stderr,
        verdict,
        "same kind of scene, as many paths, processor time; not the same scene and renderer",
    )


def _variance(subject: Subject, pairs: list[tuple[Picture, Picture]]) -> Claim:
    more, stderr = _ratio(pairs, lambda p: float((luminance(p.stderr) ** 2).mean()))
    verdict = _verdict(more, stderr, VARIANCE, ABOUT)
    return Claim(
        f"additional variance, {subject.what}",
        "[HHdD16] Section 9.2",
        VARIANCE,
        more,
        stderr,
        verdict,
        "of a path through a pixel, with multiple importance sampling; `about` is taken as +- 0.1",
    )


def _verdict(measured: float, stderr: float, published: float, about: float) -> str:
    """Whether what is measured is the published figure, or more or less of it, to two standard
    errors; undecided where these are too large to tell it from none."""
    low, high = measured - 2 * stderr, measured + 2 * stderr
    if low > published + about:
        return "more here"
    if high < published - about:
        return "less here"
    return "holds" if 2 * stderr < max(published, about) else "undecided"


def _ratio(
    pairs: list[tuple[Picture, Picture]], figure: Callable[[Picture], float]
) -> tuple[float, float]:
    """What the second of a pair has more than the first, as a fraction, and its standard error: a
    ratio of sums, by the jackknife over pairs."""
    less, more = np.array([[figure(p) for p in pair] for pair in pairs]).T
    without = (more.sum() - more) / (less.sum() - less) - 1
    n = len(pairs)
    stderr = np.sqrt((n - 1) / n * ((without - without.mean()) ** 2).sum())
    return float(more.sum() / less.sum() - 1), float(stderr)


def _double_scattering(workers: Workers) -> list[Claim]:
    """Share of the second order in what is reflected, or transmitted, at most."""
    jobs = [
        (material, alpha)
        for material in (Conductor(), Diffuse(), Dielectric(1.5))
        for alpha in ALPHAS
    ]
    shares: dict[str, tuple[float, float, str]] = {}
    for (material, alpha), found in zip(jobs, map_ordered(_shares, jobs, workers), strict=True):
        for theta, side, share, error in found:
            name = f"{material.name}, {side}"
            if share > shares.get(name, (-1.0,))[0]:
                shares[name] = share, error, f"alpha {alpha:g}, theta {in_degrees(theta)}"
    return [
        Claim(
            f"double scattering, largest share of the total, {name}",
            "[HHdD16] Section 10",
            DOUBLE_SCATTERING,
            share,
            error,
            "holds" if share + 2 * error >= DOUBLE_SCATTERING else "less here",
            f"can account for 20 % in some cases; Smith model by solve, Beckmann, at {where}",
        )
        for name, (share, error, where) in shares.items()
    ]


def _shares(job: tuple[Material, float]) -> list[tuple[float, str, float, float]]:
    """Angle, side, share of the second order, and its error."""
    material, alpha = job
    solve, found = Solve(Beckmann(alpha, alpha), material, 2), []
    for theta in THETAS:
        energy = solve.energy(direction(theta))
        sides: dict[str, Array] = {"reflected": energy.reflected[0]}
        if material.transmits:
            sides["transmitted"] = energy.transmitted[0]
        for side, orders in sides.items():
            total = float(orders.sum())
            found.append((theta, side, float(orders[1]) / total, float(energy.error[0, 1]) / total))
    return found
