"""Free paths: extinction, their distribution, and what a heightfield demands of them,
[HHdD16] Sections 5.1 to 5.3 (Eqs. 19 to 30, Table 3, figures 7 and 8)."""

from collections.abc import Iterator

import numpy as np
from scipy import stats

from msbsdf_cli.methods.base import outgoing
from msbsdf_cli.methods.forced_collisions import forced_free_path
from msbsdf_cli.methods.walks import escape
from msbsdf_cli.smith.heights import HEIGHTS
from msbsdf_cli.smith.walk import exponential, free_path
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.statistics.test_statistics import ChiSquare, Exact, Share
from msbsdf_cli.validation.batches import of_pairs
from msbsdf_cli.validation.configurations import (
    Configuration,
    hard_anywhere,
    random_anywhere,
)
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.reference import AREA_ERROR, SEEN, projected_area
from surfaces.facet import Array
from surfaces.quadrature import gauss

SECTION = "[HHdD16] Eq. "

START = {"gaussian": 0.3, "uniform": 0.2}
"""Heights that free paths start from: away from the middle, where a lost sign would hide."""

BINS = 40
"""Bins of heights in a chi-square test."""

NODES = 24
"""Gauss-Legendre nodes for the density over a bin, a quantile of the heights met."""

LEVEL = 1e-6
"""Cosine below which a ray counts as level: rounding of the cosine would show in its Lambda."""

LEAST_MET = 1000
"""Facets met below which their number is too skewed for a mean to be judged by its scatter."""

STEP = 1e-4
"""Of the central differences in height; their error is STEP^2 times a third derivative."""


def extinction(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """The area of facets against the ray over the whole sphere, and the density of facets at a
    height that makes it an extinction coefficient (Eqs. 19 to 24, figure 7)."""
    slopes = c.slopes
    w = c.i
    sigma, expected = float(slopes.sigma(w)[0]), projected_area(c, -w)
    slack = AREA_ERROR * expected + float(np.finfo(float).eps)
    because = "rounding, and the error of the integral over slopes"
    evidence = Exact(expected, sigma, slack, because)
    yield Finding("projected area", SECTION + "20-22", c, evidence)
    both = float(slopes.sigma(-w)[0]) - sigma
    slack = 4 * float(np.finfo(float).eps) * (1 + sigma)
    evidence = Exact(float(w[2, 0]), both, slack, "rounding")
    yield Finding("projected area, signs", SECTION + "22", c, evidence)

    # What the program has instead of the density: t = -ln C1(h), whose slope is -P1 / C1.
    heights, law = HEIGHTS[c.heights], height_law(c)
    h = law.ppf(np.linspace(0.05, 0.95, 19))
    slope = (heights.t(h - STEP) - heights.t(h + STEP)) / (2 * STEP)
    found, wanted = slope * sigma, law.pdf(h) / law.cdf(h) * expected
    worst = int(np.argmax(np.abs(found - wanted)))
    because = f"central differences over {2 * STEP:g} in height, at C1 from .05 to .95"
    pair = float(wanted[worst]), float(found[worst])
    evidence = Exact(*pair, pair[0] * 1e-5, because)
    yield Finding("extinction coefficient", SECTION + "24", c, evidence)


def distribution(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Heights of the next facet against the density of Eq. 28, its Dirac part among them; rays
    along wi from a fixed height. Level rays have no density: they are in Table 3."""
    d, start = c.i, START[c.heights]
    if abs(d[2, 0]) < LEVEL:
        return
    C1 = float(height_law(c).cdf(start))
    power = projected_area(c, -d) / float(d[2, 0])
    dirac = float(C1**power) if d[2, 0] > 0 else 0.0
    if dirac == 1:
        # Table 3 has the ray that meets no facet at all.
        return
    edges = _equal_bins(C1, power, 1 - dirac)
    shares = _density_over(edges, C1, power)
    t = HEIGHTS[c.heights].t(np.array([start]))
    if dirac:
        closed = float(escape(t, None, outgoing(c.slopes, d).seen_by(None))[0, 0])
        because = f"rounding, error of Lambda, {NODES} nodes a bin"
        exact = Exact(1.0, float(shares.sum()) + closed, 1e-9, because)
        yield Finding("free-path density and Dirac part", SECTION + "28", c, exact)
    sigma = c.slopes.sigma(d)
    escaped, t = free_path(np.full(n, t), d, sigma, exponential(n, rng, np.float64))
    count = int(np.count_nonzero(escaped))
    evidence = Share(min(dirac, 1.0), count, n, 10 * AREA_ERROR, "error of Lambda")
    yield Finding("free path, Dirac part", SECTION + "26, 28", c, evidence)
    counts = np.append(_histogram(t[~escaped], edges), count)
    statistic = ChiSquare.of_counts(counts, n * np.append(shares, dirac))
    if statistic is not None:
        yield Finding("free path, distribution", SECTION + "25-30", c, statistic)


def optical_depth(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """One facet is met in every unit of optical depth, the integral of the extinction coefficient
    along a ray (Eqs. 19 to 25), wherever rays start and whether or not they leave.

    Facets met less depth passed has the mean 0, and is all that rays know of a common factor in the
    lengths of free paths: it takes half the rays that a test of 40 bins would need to tell one. A
    forced free path meets a facet as often as its probability says.
    """
    d = c.i
    area = projected_area(c, -d)
    if abs(d[2, 0]) < LEVEL or area < SEEN:
        return
    extinction = area / float(d[2, 0])
    # From a height above C1 = U, facets are met by Lambda / (1 + Lambda) of the rays that go up.
    if d[2, 0] > 0 and n * extinction / (1 + extinction) < LEAST_MET:
        return
    sigma = c.slopes.sigma(d)
    t = rng.exponential(size=n)
    leaves, t_next = free_path(t, d, sigma, exponential(n, rng, np.float64))
    forced, probability = forced_free_path(t, d, sigma, rng)
    for name, met, facet in (
        ("", (~leaves).astype(float), t_next),
        (", forced", probability, forced),
    ):
        left = np.where(met < 1, (1 - met) * t, 0)
        depth = extinction * (met * (t - facet) + left)
        slack = 10 * AREA_ERROR * float(depth.mean())
        evidence = of_pairs(met, depth, slack, "error of the integral over slopes")
        yield Finding(f"free path, optical depth{name}", SECTION + "19-25", c, evidence)


def visible_heights(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Heights of the facets that light from above meets first, (1 + Lambda) P1 C1^Lambda:
    Eq. 28 from the top (figure 8)."""
    if c.i[2, 0] < LEVEL:
        return
    power = -projected_area(c, c.i) / float(c.i[2, 0])
    edges = _equal_bins(1.0, power, 1.0)
    sigma = c.slopes.sigma(-c.i)
    t = free_path(np.zeros(n), -c.i, sigma, exponential(n, rng, np.float64))[1]
    evidence = ChiSquare.of_counts(_histogram(t, edges), n * _density_over(edges, 1.0, power))
    if evidence is not None:
        yield Finding("visible heights", SECTION + "28, fig. 8", c, evidence)


def table_3(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """What rays straight up, up, level, down and straight down do: without exception."""
    n = min(n, 1 << 16)
    t0 = rng.exponential(size=n)
    E = exponential(n, rng, np.float64)
    slopes = c.slopes
    polar = {"up": min(c.wi[0], np.pi - c.wi[0]), "straight up": 0.0}
    for name, theta in polar.items():
        up = np.array([[np.sin(theta)], [0.0], [np.cos(theta)]])
        leaves, t = free_path(t0, up, slopes.sigma(up), E)
        rule = leaves if name == "straight up" else leaves | (t <= t0)
        yield _always(f"Table 3, {name}", c, rule)
        leaves, t = free_path(t0, -up, slopes.sigma(-up), E)
        name = name.replace("up", "down")
        yield _always(f"Table 3, {name}", c, ~leaves & (t >= t0) & np.isfinite(t))
    level = np.array([[np.cos(c.wi[1])], [np.sin(c.wi[1])], [0.0]])
    leaves, t = free_path(t0, level, slopes.sigma(level), E)
    yield _always("Table 3, level", c, ~leaves & (t == t0))
    h = height_law(c).ppf(np.linspace(0.02, 0.98, 97))
    thins = np.diff(np.diff(HEIGHTS[c.heights].t(h)) / np.diff(h)) > 0
    yield _always("Table 3, extinction falls with height", c, thins)


def height_law(c: Configuration) -> stats.rv_continuous:
    """The height distribution, P1 and C1, from elsewhere than the program."""
    return stats.norm() if c.heights == "gaussian" else stats.uniform(-1, 2)


def _equal_bins(C1: float, power: float, hits: float) -> Array:
    """Borders of bins in C1(h), from the ray's start on, that the facets met fill evenly, but for
    ever smaller ones at the end of a ray that must hit (Eq. 29 with Lambda = `power`)."""
    u = np.linspace(0, 1, BINS + 1)
    if hits == 1:
        u = np.append(u[:-1], 1 - 0.1 ** np.arange(2, 14))
    return C1 * (1 - hits * u) ** (-1 / power)


def _density_over(edges: Array, C1: float, power: float) -> Array:
    """Eq. 28 over each bin, |Lambda| C1^Lambda / x^(1 + Lambda) dx with P1 dh = dx, by quadrature
    in the logarithm of x."""
    node, weight = gauss(NODES)
    x = np.log(edges / C1)
    width = np.diff(x)[:, None]
    value = abs(power) * np.exp(-power * (x[:-1, None] + width * node))
    return (value * weight * np.abs(width)).sum(axis=1)


def _histogram(t: Array, edges: Array) -> Array:
    """Counts of C1 = exp(-t) in bins, in the order of the borders."""
    if edges[0] > edges[-1]:
        # Far below the last border there still is surface.
        return np.histogram(np.exp(-t), np.append(0, edges[-2::-1]))[0][::-1]
    return np.histogram(np.exp(-t), edges)[0]


def _always(name: str, c: Configuration, rule: Array) -> Finding:
    because = "a property of every ray, without exception"
    share = np.count_nonzero(rule) / rule.size
    return Finding(name, "[HHdD16] Table 3", c, Exact(1.0, share, 0.0, because))


IDENTITIES = (
    Identity(extinction, hard_anywhere, random_anywhere, draws=8, cost=0.1),
    Identity(distribution, hard_anywhere, random_anywhere, draws=6, share=0.5),
    Identity(
        optical_depth, hard_anywhere, random_anywhere, draws=6, thin=2, share=0.25, least=500_000
    ),
    Identity(visible_heights, hard_anywhere, random_anywhere, draws=6, share=0.5),
    Identity(table_3, hard_anywhere, random_anywhere, draws=4, cost=0.1),
)
