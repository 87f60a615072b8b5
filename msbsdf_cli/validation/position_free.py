"""Masking and shadowing over the whole sphere, and what follows for reciprocity,
[WJFYHY22 supp.] Sections 1 and 2."""

from collections.abc import Iterator

import numpy as np
from scipy import integrate
from scipy.optimize import brentq

from msbsdf_cli.methods.path_factors import leaving_probability, meeting_probability
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.integrated_heights import extinction_of
from msbsdf_cli.smith.slopes import Beckmann, Ggx, Lambda
from msbsdf_cli.statistics.multiple_testing import FAILS_AS_EXPECTED, HOLDS, Finding
from msbsdf_cli.statistics.test_statistics import Exact
from msbsdf_cli.validation.configurations import (
    Configuration,
    hard_above,
    hard_anywhere,
    random_above,
    random_anywhere,
)
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.reference import SEEN, big_lambda, projected_area
from surfaces.facet import Array

SECTION = "[WJFYHY22 supp.] Eq. "

INTEGRAL_ERROR = 1e-8
"""Relative error of integrals over slopes and heights, and of differences of nearly equal terms."""

LEVEL = 1e-6
"""Cosine below which Lambda is rounding."""


def spherical_masking(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """|1 / (1 + Lambda(w))| over the sphere against |cos| over the integral of <w, m> D(m)."""
    w = c.i
    area = projected_area(c, w)
    if abs(w[2, 0]) < LEVEL or area < SEEN:
        return
    expected = abs(float(w[2, 0])) / area
    one_plus = 1 + float(Lambda(c.slopes, w)[0])
    # 1 + Lambda is small below the surface, where digits cancel.
    slack = INTEGRAL_ERROR * expected + 8 * np.finfo(float).eps * expected / abs(one_plus)
    because = "integral over slopes, and rounding where 1 + Lambda cancels"
    where = "upward" if w[2, 0] > 0 else "downward"
    evidence = Exact(expected, abs(1 / one_plus), slack, because)
    yield Finding(f"distant masking, {where}", SECTION + "2-4", c, evidence)
    short = float(1 / extinction_of(-w, c.slopes.sigma(-w))[0])
    evidence = Exact(expected, short, INTEGRAL_ERROR * expected, "integral over slopes")
    yield Finding(f"distant masking as used, {where}", SECTION + "3", c, evidence)


def exceeds_one(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """The polar angle below the horizon beyond which distant masking exceeds 1: where Lambda(-w)
    falls to 1 (figure 2)."""

    def excess(theta: float, phi: float) -> float:
        up = direction(np.pi - theta, phi)[:, None]
        return 1 - float(abs(1 + Lambda(c.slopes, -up)[0]))

    def wanted(theta: float) -> float:
        up = direction(np.pi - theta)[:, None]
        return projected_area(c, -up) / float(up[2, 0]) - 1

    bracket = np.pi / 2 + 1e-3, np.pi - 1e-3
    expected = brentq(wanted, *bracket, xtol=1e-13)
    measured = brentq(excess, *bracket, args=(0.0,), xtol=1e-13)
    evidence = Exact(float(expected), float(measured), INTEGRAL_ERROR, "root of a smooth function")
    yield Finding("distant masking, angle where it exceeds 1", SECTION + "3, fig. 2", c, evidence)


def correlated(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Masking and shadowing at one height, for the last bounce and, as arriving without leaving,
    for the middle one; also from below (Eqs. 5 to 17), against the integral over heights."""
    if min(abs(c.i[2, 0]), c.o[2, 0]) < LEVEL or projected_area(c, c.i) < SEEN:
        return
    slopes, d, o = c.slopes, -c.i, c.o
    # Arriving along d there are L of them in t, leaving along o the probability is exp(-Lambda t).
    L = projected_area(c, c.i) / abs(float(d[2, 0]))
    Lambda_o = projected_area(c, -o) / float(o[2, 0])
    ours_L, ours_o = extinction_of(d, slopes.sigma(d)), extinction_of(o, slopes.sigma(o))
    arrive = "from above" if c.i[2, 0] > 0 else "from below"
    for through, beyond in ((False, ""), (True, ", transmission")):
        last = _over_heights(L, Lambda_o, through)
        middle = 1 / L - last
        leaving = leaving_probability(ours_L, o, ours_o, through, True) / ours_L
        meeting = meeting_probability(ours_L, o, ours_o, through, True) / ours_L
        for name, number, value, expected in (
            ("last bounce", "5-13", leaving, last),
            ("middle bounce", "14-17", meeting, middle),
        ):
            slack = INTEGRAL_ERROR * max(1 / L, 1e-12)
            evidence = Exact(expected, float(value[0]), slack, "integrals over heights and slopes")
            name = f"masking-shadowing {arrive}, {name}{beyond}"
            yield Finding(name, SECTION + number, c, evidence)
    down = (
        meeting_probability(ours_L, -o, extinction_of(-o, slopes.sigma(-o)), False, True) / ours_L
    )
    evidence = Exact(1 / L, float(down[0]), INTEGRAL_ERROR / L, "integral over slopes")
    yield Finding(f"masking-shadowing {arrive}, downward", SECTION + "14", c, evidence)


def _over_heights(L: float, Lambda_o: float, through: bool) -> float:
    """Integral of G1(wi, h) G1(wo, h) P1(h) dh (Eq. 15), with C1(h) as the variable x: of
    x^(L - 1) and x^Lambda_o, or (1 - x)^Lambda_o on the other side. With y = x^L no end is
    singular."""

    def value(y: float) -> float:
        # In one power, which does not underflow on the way.
        return float((1 - y ** (1 / L)) ** Lambda_o if through else y ** (Lambda_o / L))

    # Steep powers live at an end: borders towards both.
    borders = [1e-9, 1e-6, 1e-4, 1e-2, 0.5, 1 - 1e-2, 1 - 1e-4, 1 - 1e-6]
    total = integrate.quad(value, 0, 1, points=borders, limit=400, epsabs=0, epsrel=1e-11)[0]
    return float(total) / L


def segment_terms(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """The segment terms of figure 3, seen from both ends: the same where heights are uncorrelated
    (Eqs. 18 to 24), and not where they are correlated (Eqs. 25 and 26).

    The path comes down along d0, goes down along d1 and up along d2.
    """
    slopes, up0, up1, o = c.slopes, c.i, _third(c), c.o
    if projected_area(c, -up1) / float(up1[2, 0]) < SEEN:
        return
    forward, inverse = (
        _path(slopes, [-up0, -up1, o], False),
        _path(slopes, [-o, up1, up0], False),
    )
    # [WJFYHY22 supp.] Eqs. 20 and 24, and the ends, of which each has one masking term.
    expected = _g1(c, up0) * _g1(c, up1) * _g1(c, o)
    because = "integrals over slopes"
    slack = INTEGRAL_ERROR * expected
    for name, value in (("forward", forward), ("inverse", inverse)):
        evidence = Exact(expected, value, slack, because)
        yield Finding(f"segment terms, uncorrelated, {name}", SECTION + "18-24", c, evidence)
    forward, inverse = (
        _path(slopes, [-up0, -up1, o], True),
        _path(slopes, [-o, up1, up0], True),
    )
    Lambdas = [big_lambda(c, w) for w in (up0, up1, o)]
    wanted = 1 / (1 + Lambdas[0]) / (1 + Lambdas[1] + Lambdas[2])
    evidence = Exact(wanted, forward, INTEGRAL_ERROR * wanted, because)
    yield Finding("segment terms, correlated, forward", SECTION + "25", c, evidence)
    backward = Lambdas[1] / ((1 + Lambdas[2]) * (1 + Lambdas[2] + Lambdas[1]))
    backward /= Lambdas[1] + Lambdas[0]
    evidence = Exact(backward, inverse, INTEGRAL_ERROR * backward, because)
    yield Finding("segment terms, correlated, inverse", SECTION + "26", c, evidence)
    same = abs(wanted - backward) <= INTEGRAL_ERROR * wanted
    evidence = Exact(forward, inverse, INTEGRAL_ERROR * wanted, because)
    kind = HOLDS if same else FAILS_AS_EXPECTED
    yield Finding("segment terms, correlated, both ways", SECTION + "25, 26", c, evidence, kind)


def _path(slopes: object, directions: list[Array], correlated: bool) -> float:
    """Product of the probabilities along directions of travel (3, 1), each over L of the one
    before."""
    product = 1.0
    L = [extinction_of(d, slopes.sigma(d)) for d in directions]  # type: ignore[attr-defined]
    for k in range(1, len(directions)):
        probability = leaving_probability if k == len(directions) - 1 else meeting_probability
        after = probability(L[k - 1], directions[k], L[k], False, correlated) / L[k - 1]
        product *= float(after[0])
    return product


def _g1(c: Configuration, w: Array) -> float:
    return float(w[2, 0]) / projected_area(c, w)


def _third(c: Configuration) -> Array:
    """One more direction above the surface, from the other two."""
    theta = 0.3 + 0.4 * (c.wi[0] + (c.wo or c.wi)[0])
    return direction(min(theta, 1.4), 1 + c.wi[1])[:, None]


def isotropic() -> list[Configuration]:
    """For the angle of figure 2, whose roughness is 1."""
    return [
        Configuration(slopes(alpha, alpha), (np.pi / 2, 0.0))
        for slopes in (Beckmann, Ggx)
        for alpha in (0.3, 1.0, 2.0)
    ]


IDENTITIES = (
    Identity(spherical_masking, hard_anywhere, random_anywhere, draws=12, cost=0.1),
    Identity(exceeds_one, isotropic, cost=0.1),
    Identity(correlated, hard_anywhere, random_anywhere, draws=9, cost=0.1),
    Identity(segment_terms, hard_above, random_above, draws=6, cost=0.1),
)
