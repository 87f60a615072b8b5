"""What follows from projected areas: extinction, and masking over the whole sphere."""

from functools import partial

import numpy as np
from scipy.special import log_ndtr

from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.experiments.random_surfaces import Resolution, realisation
from msbsdf_cli.results.files import from_rows
from msbsdf_cli.run.executors import map_ordered
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import Beckmann, Ggx, Slopes
from surfaces.facet import Array
from surfaces.free_path import FreePathTracer
from surfaces.streams import stream
from surfaces.views import VIEWS, Views

ALPHA = 1.0
THETAS = tuple(np.radians([30.0, 60.0, 80.0, 100.0, 120.0, 150.0]).tolist())
"""Of travel: from the facets up, and from outside down."""
FROM = -2.0
"""Height from which light travels up on surfaces."""
HEIGHTS = np.linspace(-3, 3, 61)
EDGES = np.linspace(-3, 3, 25)

EXTINCTION = ("source", "theta_r_rad", "height", "extinction", "stderr")


def heitz_7(settings: Settings) -> Tables:
    """Extinction, per length in standard deviations of height, of Eq. 24, and as light on explicit
    surfaces of Beckmann slopes is seen to be lost from one height to the next."""
    slopes = Beckmann(ALPHA, ALPHA)
    rows = [
        ("model", theta, float(h), float(x), 0.0)
        for theta in THETAS
        for h, x in zip(HEIGHTS, extinction(slopes, theta, HEIGHTS), strict=True)
    ]
    resolution = Resolution(settings.pick(16, 32), 12, settings.pick(16, 32))
    trace = partial(_next_heights, resolution, settings.pick(20_000, 40_000), settings.seed)
    found = list(map_ordered(trace, range(resolution.realisations), settings.workers))
    for i, theta in enumerate(THETAS):
        rows += _lost(theta, np.array([each[i] for each in found]))
    return {"heitz_7": from_rows(EXTINCTION, rows)}


def extinction(slopes: Slopes, theta: float, heights: Array) -> Array:
    """[HHdD16] Eq. 24 with Gaussian heights: sigma P1(h) / C1(h)."""
    log_density = -heights * heights / 2 - np.log(2 * np.pi) / 2
    sigma = slopes.sigma(direction(theta)[:, None])
    return np.asarray(sigma * np.exp(log_density - log_ndtr(heights)))


def _next_heights(resolution: Resolution, n: int, seed: int, number: int) -> Array:
    """Weighted shares (thetas, bins + 2) of light that meets one surface below, in and above
    `EDGES`, the last with what escapes."""
    surface = realisation(resolution, number, seed)
    surface.build()
    tracer = FreePathTracer(surface, Views(surface.stretch(ALPHA, ALPHA), VIEWS))
    rng = stream(seed, "free-path rays", number, 0)
    edges = np.concatenate([[-np.inf], EDGES, [np.inf]])
    shares = []
    for theta in THETAS:
        start = FROM if theta < np.pi / 2 else np.inf
        paths = tracer.next_heights(direction(theta), start, n, rng)
        share = np.histogram(paths.heights, edges, weights=paths.shares)[0]
        share[-1] += paths.escaped
        shares.append(paths.weight * share)
    return np.array(shares)


def _lost(theta: float, shares: Array) -> list[tuple[str, float, float, float, float]]:
    """Extinction in each bin that enough light crosses; errors by the jackknife over surfaces."""
    if theta > np.pi / 2:
        shares = shares[:, ::-1]
    n, total = len(shares), shares.sum(axis=0)
    middle = (EDGES[1:] + EDGES[:-1]) / 2
    if theta > np.pi / 2:
        middle = middle[::-1]
    to_length = abs(np.cos(theta)) / (EDGES[1] - EDGES[0])
    # Light crosses a bin in part where it starts there, and hardly any is left at the end.
    left = 1 - np.cumsum(total[:-1])[:-1] / total.sum()
    whole = (np.abs(middle - FROM) > EDGES[1] - EDGES[0]) | (theta > np.pi / 2)
    shown = (left > LEAST_LEFT) & whole & ((theta > np.pi / 2) | (middle > FROM))
    value, without = _rate(total)[shown], _rate(total - shares)[:, shown]
    stderr = np.sqrt((n - 1) * ((without - without.mean(axis=0)) ** 2).mean(axis=0))
    return [
        ("surfaces", theta, float(h), float(x * to_length), float(e * to_length))
        for h, x, e in zip(middle[shown], value, stderr, strict=True)
    ]


LEAST_LEFT = 0.01
"""Share of light that has to cross a bin for its extinction to be told."""


def _rate(shares: Array) -> Array:
    """ln(light before / light after) of each bin (..., bins + 2) but the first and the last."""
    after = np.cumsum(shares[..., ::-1], axis=-1)[..., ::-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(after[..., 1:-1] / after[..., 2:]))


MASKING = ("slopes", "alpha_x", "alpha_y", "theta_rad", "closed_form", "quadrature", "stderr")


def wang_2(settings: Settings) -> Tables:
    """Distant masking |cos theta| / projected area: closed form ([WJFYHY22 supp.] Eq. 3) and the
    integral of its Eq. 4, whose error is what half the nodes change."""
    rows = []
    # Few facets face down: those of Beckmann slopes as exp(-cot^2), beyond any number's range.
    for slopes, last in ((Ggx(ALPHA, ALPHA), 178), (Beckmann(ALPHA, ALPHA), 166)):
        for theta in np.radians(np.linspace(0, last, settings.pick(46, 179))).tolist():
            w = direction(theta)
            closed = abs(w[2]) / float(slopes.sigma(-w[:, None])[0])
            coarse, fine = (abs(w[2]) / projected_area(slopes, theta, n) for n in (100, 200))
            cells = closed, fine, abs(fine - coarse)
            rows.append((slopes.name, *slopes.alpha, theta, *map(float, cells)))
    return {"wang_2": from_rows(MASKING, rows)}


def projected_area(slopes: Slopes, theta: float, nodes: int) -> float:
    """Integral of <w, m> D(m) over normals m of isotropic slopes, for w of polar angle `theta`: in
    closed form over azimuth, by Gauss's rule over the polar angle on both sides of its kink."""
    x, weight = np.polynomial.legendre.leggauss(nodes)
    kink, total = abs(np.pi / 2 - theta), 0.0
    for low, high in ((0.0, kink), (kink, np.pi / 2)):
        # Next to the kink the integrand has a power of 3/2, which a square in u takes away.
        u = (x + 1) / 2
        at, toward = (high, low) if low == 0 else (low, high)
        polar = at + (toward - at) * u * u
        step = weight * np.abs(toward - at) * u
        a, b = np.cos(theta) * np.cos(polar), np.sin(theta) * np.sin(polar)
        edge = np.arccos(np.clip(np.divide(-a, b, out=-np.sign(a), where=b > 0), -1, 1))
        m = np.stack([np.sin(polar), np.zeros(nodes), np.cos(polar)])
        inner = 2 * (a * edge + b * np.sin(edge))
        total += float(step @ (inner * slopes.D(m) * np.sin(polar)))
    return total
