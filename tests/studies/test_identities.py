"""Every identity can fail: the formula it guards is bent, and its verdict must turn."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from msbsdf_cli.methods import segments, single, walk
from msbsdf_cli.methods.energy_compensated import EnergyCompensated
from msbsdf_cli.methods.position_free import PositionFree
from msbsdf_cli.methods.single import Single
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.smith import kernel, slopes
from msbsdf_cli.smith import walk as smith_walk
from msbsdf_cli.smith.heights import Gaussian
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.studies.identities import (
    bsdf,
    free_paths,
    height_walk,
    histogram,
    intersection,
    phase,
    position_free,
    reciprocity,
    solved,
    visible_normals,
)
from msbsdf_cli.studies.identities.batches import of_batches, of_two
from msbsdf_cli.studies.identities.configurations import Configuration
from msbsdf_cli.studies.identities.evidence import ChiSquare, Exact, Mean, Share
from msbsdf_cli.studies.identities.verdicts import (
    FAILS_AS_EXPECTED,
    Finding,
    holm,
    judge,
)

ABOVE = Configuration("beckmann", (1.0, 1.0), (1.2, 0.0), (1.0, 2.0), heights="gaussian")
DOWN = Configuration("ggx", (1.0, 0.5), (2.2, 0.3), (0.7, 2.0), heights="uniform")
MIRROR = Configuration("ggx", (1.0, 1.0), (1.0, 0.3), (0.8, 2.5), material="conductor")
GLASS = Configuration("beckmann", (1.5, 1.5), (1.2, 0.3), (2.6, 3.3), material="dielectric")
ZENITH = np.array([[0.0], [0.0], [1.0]])
GRAZING = Configuration("beckmann", (1.0, 1.0), (1.5, 0.0), heights="gaussian")


def failing(identity, configuration, samples):
    """Names of the findings that fail."""
    rng = np.random.default_rng(5)
    return {
        r.finding.identity
        for r in judge(list(identity(configuration, samples, rng)), 1e-3)
        if r.failed
    }


def with_(configuration, **changes):
    return replace(configuration, **changes)


def one_percent_more(function):
    return lambda *args, **kwargs: 1.01 * function(*args, **kwargs)


def bend_lambda(monkeypatch):
    """Lambda 1 % too large, above the surface and below it: 1 + Lambda grows by 1 % of Lambda."""
    for cls in (Beckmann, Ggx):
        right = cls.sigma

        def bent(self, d, right=right):
            # sigma = Lambda cos upward, (1 + Lambda) cos downward.
            upward = right(self, np.where(d[2] > 0, d, -d))
            return right(self, d) + 0.01 * upward

        monkeypatch.setattr(cls, "sigma", bent)


def lose_sign(monkeypatch):
    """Rays down take the step of rays up."""
    right = smith_walk.free_path

    def bent(t, d, sigma, E):
        return right(t, np.abs(d), sigma, E)

    for module in (intersection, free_paths, height_walk, smith_walk):
        if hasattr(module, "free_path"):
            monkeypatch.setattr(module, "free_path", bent)


def flip_nothing(monkeypatch):
    for module in (smith_walk, intersection, walk):
        monkeypatch.setattr(module, "flip", lambda t: t)


def flip_sides_of_t(monkeypatch):
    """C1 -> 1 / (1 + C1), a slip of the sign."""
    for module in (smith_walk, intersection, walk):
        monkeypatch.setattr(module, "flip", lambda t: np.log1p(np.exp(-t)))


def half_vector_below(monkeypatch):
    """D as if every normal were above the horizon."""
    for cls in (Beckmann, Ggx):
        right = cls.D
        monkeypatch.setattr(cls, "D", lambda self, m, right=right: right(self, m * np.sign(m[2])))

    def density(slopes, h, length):
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.nan_to_num(slopes.D(h / length))

    monkeypatch.setattr(kernel, "_density_of_normals", density)


def no_jacobian_of_reflection(monkeypatch):
    right = kernel.reflection_density

    def bent(*args):
        density, colour = right(*args)
        return 4 * density, colour

    monkeypatch.setattr(kernel, "reflection_density", bent)


def no_index_in_refraction(monkeypatch):
    right = kernel.refraction_density

    def bent(slopes, material, d, w, inside=False):
        eta = kernel.relative_ior(material, inside)
        return right(slopes, material, d, w, inside) / eta**2

    monkeypatch.setattr(kernel, "refraction_density", bent)


def normals_without_their_cosine(monkeypatch):
    """Normals of the surface instead of those seen."""
    for cls in (Beckmann, Ggx):
        right = cls.visible_normals
        monkeypatch.setattr(
            cls,
            "visible_normals",
            lambda self, wi, n, rng, right=right: right(self, ZENITH, n, rng),
        )


def heights_off(monkeypatch):
    right = Gaussian.t
    monkeypatch.setattr(Gaussian, "t", lambda self, h: 1.01 * right(self, h))


def exponentials_off(monkeypatch):
    right = smith_walk.exponential
    for module in (smith_walk, intersection, free_paths):
        monkeypatch.setattr(module, "exponential", one_percent_more(right))


def always_down_to_the_bottom(monkeypatch):
    def bent(t, d, sigma, E):
        return E * d[2] > t * sigma, t * 0

    monkeypatch.setattr(free_paths, "free_path", bent)


def density_of_normals_off(monkeypatch):
    for cls in (Beckmann, Ggx):
        monkeypatch.setattr(cls, "D", one_percent_more(cls.D))


def masking_product(monkeypatch):
    right = kernel.masking_shadowing

    def bent(slopes, wi, wo, transmitted, correlated=True):
        return right(slopes, wi, wo, transmitted, False)

    monkeypatch.setattr(single, "masking_shadowing", bent)


def escape_one_percent(monkeypatch):
    right = walk._escape
    monkeypatch.setattr(walk, "_escape", lambda t, Lambda: right(1.03 * t, Lambda))


def chances_off(monkeypatch):
    for name in ("leaving_chance", "meeting_chance"):
        monkeypatch.setattr(position_free, name, one_percent_more(getattr(segments, name)))


def correlated_for_uncorrelated(monkeypatch):
    right = PositionFree.__init__

    def bent(self, *args, **kwargs):
        right(self, *args, **kwargs)
        self.correlated = True

    monkeypatch.setattr(PositionFree, "__init__", bent)


def uncorrelated_for_correlated(monkeypatch):
    right = PositionFree.__init__

    def bent(self, *args, **kwargs):
        right(self, *args, **kwargs)
        self.correlated = False

    monkeypatch.setattr(PositionFree, "__init__", bent)


def unlike_phase(monkeypatch):
    """A facet's share of light depends on which way it goes, as Fresnel's must not."""
    right = kernel.scatter_density

    def bent(slopes, material, d, w, *args, **kwargs):
        return right(slopes, material, d, w, *args, **kwargs) * (1 + 1e-6 * d[2])

    monkeypatch.setattr(phase, "scatter_density", bent)


def samples_twice(monkeypatch):
    """Samples of single scattering that forget to be weighed by shadowing."""
    right = Single.sample

    def bent(self, wi, n, rng):
        w, weight = right(self, wi, n, rng)
        return w, (weight > 0).astype(float)

    monkeypatch.setattr(Single, "sample", bent)


def lobe_off(monkeypatch):
    right = EnergyCompensated._lobe
    monkeypatch.setattr(
        EnergyCompensated, "_lobe", lambda self, wi, out: right(self, wi, out) * (1 + 0.2 * wi[2])
    )


def lambda_below(monkeypatch):
    """Lambda below the surface is that of above: the sign of [HHdD16] Eq. 22 is lost."""
    right = slopes.Lambda
    monkeypatch.setattr(position_free, "Lambda", lambda s, w: right(s, w * np.sign(w[2])))


def unbalanced(monkeypatch):
    """Energies that a solution forgets to normalise."""
    right = Solve.energy

    def bent(self, wi):
        found = right(self, wi)
        return replace(found, reflected=1.001 * found.reflected)

    monkeypatch.setattr(Solve, "energy", bent)


def one_way(monkeypatch):
    """Values that depend on where light comes from."""
    right = Solve.evaluate

    def bent(self, wi, wo, *args):
        found = right(self, wi, wo, *args)
        return replace(found, value=found.value * (1 + 1e-3 * wi[2]))

    monkeypatch.setattr(Solve, "evaluate", bent)


SOLVED = solved.hard()[0]

PERTURBATIONS = [
    (unbalanced, solved.solved, SOLVED, 1000, "energy, without noise"),
    (one_way, solved.solved, SOLVED, 1000, "reciprocity, without noise"),
    (one_way, solved.solved, SOLVED, 1000, "first order, without noise"),
    (
        flip_nothing,
        solved.solved,
        solved.hard()[2],
        20_000,
        "energies of orders, walk against solve",
    ),
    # what is bent, the identity that guards it, where, samples, and what must fail
    (bend_lambda, free_paths.extinction, ABOVE, 1, "projected area"),
    (bend_lambda, intersection.masking, ABOVE, 4_000_000, "masking"),
    (bend_lambda, intersection.masking_shadowing, ABOVE, 4_000_000, "masking-shadowing"),
    (
        bend_lambda,
        intersection.masking_shadowing,
        ABOVE,
        4_000_000,
        "masking-shadowing, transmission",
    ),
    (bend_lambda, visible_normals.normalisation, ABOVE, 1, "visible normals, normalisation"),
    (bend_lambda, bsdf.first_order, with_(MIRROR, method="single"), 64, "first order"),
    (bend_lambda, free_paths.visible_heights, GRAZING, 4_000_000, "visible heights"),
    (bend_lambda, position_free.spherical_masking, ABOVE, 1, "distant masking, upward"),
    (bend_lambda, position_free.spherical_masking, DOWN, 1, "distant masking, downward"),
    (bend_lambda, position_free.spherical_masking, DOWN, 1, "distant masking as used, downward"),
    (
        bend_lambda,
        position_free.exceeds_one,
        ABOVE,
        1,
        "distant masking, angle where it exceeds 1",
    ),
    (lambda_below, position_free.spherical_masking, DOWN, 1, "distant masking, downward"),
    (lose_sign, free_paths.table_3, DOWN, 1000, "Table 3, down"),
    (lose_sign, free_paths.table_3, DOWN, 1000, "Table 3, straight down"),
    (lose_sign, free_paths.distribution, DOWN, 10_000, "free path, distribution"),
    (lose_sign, free_paths.distribution, DOWN, 10_000, "free path, Dirac part"),
    (lose_sign, free_paths.visible_heights, ABOVE, 10_000, "visible heights"),
    (lose_sign, intersection.shadowing_given_masking, ABOVE, 10_000, "shadowing given masking"),
    (always_down_to_the_bottom, free_paths.table_3, ABOVE, 1000, "Table 3, level"),
    (always_down_to_the_bottom, free_paths.table_3, ABOVE, 1000, "Table 3, straight down"),
    (heights_off, free_paths.extinction, ABOVE, 1, "extinction coefficient"),
    (heights_off, free_paths.distribution, ABOVE, 1000, "free-path density and Dirac part"),
    (exponentials_off, free_paths.visible_heights, ABOVE, 4_000_000, "visible heights"),
    (
        flip_nothing,
        intersection.masking_shadowing,
        ABOVE,
        100_000,
        "masking-shadowing, transmission",
    ),
    (
        flip_nothing,
        intersection.shadowing_given_masking,
        ABOVE,
        100_000,
        "shadowing given masking, transmission",
    ),
    (
        flip_sides_of_t,
        intersection.masking_shadowing,
        ABOVE,
        100_000,
        "masking-shadowing, transmission",
    ),
    (
        flip_nothing,
        height_walk.height_independence,
        with_(GLASS, heights="gaussian"),
        100_000,
        "independence of the height distribution",
    ),
    (
        density_of_normals_off,
        visible_normals.normalisation,
        DOWN,
        1,
        "visible normals, normalisation",
    ),
    (
        normals_without_their_cosine,
        visible_normals.sampled_slopes,
        ABOVE,
        20_000,
        "visible normals, slopes",
    ),
    (
        normals_without_their_cosine,
        visible_normals.sampled_moments,
        ABOVE,
        20_000,
        "visible normals, E[x]",
    ),
    (half_vector_below, phase.phase_function, MIRROR, 100_000, "phase function, normalisation"),
    (half_vector_below, bsdf.energy_and_samples, with_(MIRROR, method="walk"), 400_000, "energy"),
    (
        no_jacobian_of_reflection,
        phase.phase_function,
        MIRROR,
        20_000,
        "phase function, normalisation",
    ),
    (no_index_in_refraction, phase.phase_function, GLASS, 20_000, "phase function, normalisation"),
    (
        no_index_in_refraction,
        phase.reciprocity,
        GLASS,
        1,
        "phase function, reciprocity through facets",
    ),
    (unlike_phase, phase.reciprocity, MIRROR, 1, "phase function, reciprocity"),
    (
        normals_without_their_cosine,
        phase.phase_function,
        MIRROR,
        100_000,
        "phase function, E[x]",
    ),
    (masking_product, bsdf.first_order, with_(MIRROR, method="single"), 64, "first order"),
    (masking_product, bsdf.first_order, with_(GLASS, method="single"), 64, "first order"),
    (
        escape_one_percent,
        bsdf.first_order,
        with_(MIRROR, method="walk", wi=(1.5, 0.3)),
        2_000_000,
        "first order",
    ),
    (
        samples_twice,
        bsdf.energy_and_samples,
        with_(MIRROR, method="single"),
        100_000,
        "samples against values, E[1]",
    ),
    (
        lobe_off,
        bsdf.energy_and_samples,
        with_(MIRROR, method="energy-compensated"),
        400_000,
        "energy",
    ),
    (
        lobe_off,
        reciprocity.reciprocity,
        with_(MIRROR, method="energy-compensated"),
        64,
        "reciprocity",
    ),
    (
        correlated_for_uncorrelated,
        reciprocity.reciprocity,
        with_(MIRROR, method="position-free-uncorrelated", wi=(0.2, 0.0)),
        200_000,
        "reciprocity, order 2",
    ),
    (
        correlated_for_uncorrelated,
        histogram.differences,
        with_(MIRROR, method="position-free-uncorrelated"),
        20_000,
        "reciprocity, mean of differences",
    ),
    (
        uncorrelated_for_correlated,
        histogram.differences,
        with_(MIRROR, method="position-free-correlated"),
        20_000,
        "reciprocity, mean of differences",
    ),
    (
        uncorrelated_for_correlated,
        reciprocity.failing,
        reciprocity.not_reciprocal()[0],
        20_000,
        "reciprocity, order 2",
    ),
    (chances_off, position_free.correlated, ABOVE, 1, "masking-shadowing from above, last bounce"),
    (chances_off, position_free.correlated, DOWN, 1, "masking-shadowing from below, middle bounce"),
    (
        chances_off,
        position_free.correlated,
        ABOVE,
        1,
        "masking-shadowing from above, last bounce, transmission",
    ),
    (chances_off, position_free.segment_terms, ABOVE, 1, "segment terms, uncorrelated, forward"),
    (chances_off, position_free.segment_terms, ABOVE, 1, "segment terms, correlated, inverse"),
]


@pytest.mark.parametrize(
    ("bend", "identity", "configuration", "samples", "name"),
    PERTURBATIONS,
    ids=[f"{p[0].__name__}-{p[4]}" for p in PERTURBATIONS],
)
def test_a_bent_formula_turns_the_verdict(
    monkeypatch, bend, identity, configuration, samples, name
):
    assert name not in failing(identity, configuration, samples)
    bend(monkeypatch)
    assert name in failing(identity, configuration, samples)


def test_every_identity_is_bent_by_some_test():
    from msbsdf_cli.studies.identities import explicit
    from msbsdf_cli.studies.identities.suite import IDENTITIES

    guarded = {p[1] for p in PERTURBATIONS}
    # On surfaces nothing is judged.
    assert {i.measure for i in IDENTITIES} - guarded == {explicit.on_surfaces}


def finding(evidence, wanted="holds"):
    return Finding("x", "0", ABOVE, evidence, wanted)


def test_holm_by_hand():
    # .01 <= .05 / 4, .015 <= .05 / 3, then .03 > .05 / 2 ends it, whatever .04 would have been.
    p_values = [0.03, 0.01, 0.04, 0.015]
    level = holm(p_values, 0.05)
    assert [p <= level for p in p_values] == [False, True, False, True]
    assert level == pytest.approx(0.05 / 2)
    assert holm([0.2, 0.9], 0.05) == pytest.approx(0.05 / 2)
    assert holm([1e-9], 0.05) == 0.05


def test_holm_keeps_the_rate_of_the_family():
    # 400 families of 30 tests with nothing to find: a failure in 5 % of them.
    rng = np.random.default_rng(1)
    p_values = rng.random((400, 30))
    failed = sum(any(p <= holm(row, 0.05) for p in row) for row in p_values)
    assert stats.binomtest(failed, 400, 0.05).pvalue > 1e-3


def test_verdicts_take_all_measurements_together():
    # A score of 3.5 fails alone at one in a thousand, and holds among a thousand others.
    odd = finding(Mean(0.0, 3.5, 1.0, 1e9))
    even = [finding(Mean(0.0, z, 1.0, 1e9)) for z in stats.norm.ppf(np.linspace(0.01, 0.99, 999))]
    assert judge([odd], 1e-3)[0].failed
    assert not any(row.failed for row in judge([odd, *even], 1e-3))


def test_what_must_fail_is_held_to_it():
    far = finding(Mean(0.0, 20.0, 1.0, 1e9), FAILS_AS_EXPECTED)
    near = finding(Mean(0.0, 1.0, 1.0, 1e9), FAILS_AS_EXPECTED)
    verdicts = [row.verdict for row in judge([far, near], 1e-3)]
    assert verdicts == ["fails as expected", "holds against expectation"]
    assert [row.failed for row in judge([far, near], 1e-3)] == [False, True]


def test_a_constant_is_its_own_mean():
    # GGX of roughness 1, seen from the zenith, scatters evenly: nothing is left but rounding.
    assert of_batches(1.0, np.full(8, 1 - 1e-16)).p_value() == 1
    assert of_batches(1.0, np.full(8, 1 - 1e-9)).p_value() == 0


def test_what_is_not_a_number_fails():
    rows = judge([finding(Exact(1.0, np.nan, 1.0, "")), finding(Mean(0.0, np.nan, 1.0, 9))], 1e-3)
    assert all(row.failed for row in rows)


@pytest.mark.parametrize(
    "evidence",
    [
        Mean(1.0, 1.0, 0.1, 31),
        Mean(1.0, 1.0, 0.1, 31, slack=0.2, because="a table"),
        Share(0.3, 3000, 10_000),
        ChiSquare(40.0, 40),
    ],
    ids=["mean", "slack", "share", "chi-square"],
)
def test_tolerance_is_where_the_verdict_turns(evidence):
    level = 1e-4
    tolerance = evidence.tolerance(level)
    for factor, fails in ((0.98, False), (1.02, True)):
        if isinstance(evidence, Share):
            count = round((evidence.expected + factor * tolerance) * evidence.n)
            moved = replace(evidence, count=count)
        else:
            moved = replace(evidence, measured=evidence.expected + factor * tolerance)
        assert (moved.p_value() <= level) == fails
    assert evidence.detectable(level) > tolerance


@pytest.mark.parametrize(("expected", "n"), [(0.3, 50), (0.002, 400), (0.999, 300)])
def test_shares_fail_no_more_often_than_said(expected, n):
    counts = np.arange(n + 1)
    p = np.array([Share(expected, int(k), n).p_value() for k in counts])
    weight = stats.binom.pmf(counts, n, expected)
    for level in (0.1, 1e-2, 1e-4):
        assert weight[p <= level].sum() <= level


def test_chi_square_of_two_samples_is_uniform_under_the_null():
    rng = np.random.default_rng(3)
    shares = 1 / np.arange(1, 60) ** 2
    shares /= shares.sum()
    p = [
        ChiSquare.of_two(rng.multinomial(40_000, shares), rng.multinomial(10_000, shares)).p_value()
        for _ in range(300)
    ]
    assert stats.kstest(p, "uniform").pvalue > 1e-3


def test_differences_of_batches_have_the_right_error():
    rng = np.random.default_rng(4)
    p = [of_two(rng.normal(size=32), rng.normal(scale=5, size=32)).p_value() for _ in range(300)]
    assert stats.kstest(p, "uniform").pvalue > 1e-3


def test_means_of_skewed_batches_fail_as_often_as_said():
    # Exponential batches: without the correction, one in a hundred below would be three.
    rng = np.random.default_rng(6)
    batches = rng.exponential(size=(20_000, 128)) ** 1.5
    mean = 1.329340388179137  # Gamma(5 / 2)
    corrected = [of_batches(mean, row) for row in batches]
    p = np.array([evidence.p_value() for evidence in corrected])
    plain = np.array([replace(evidence, skewness=0.0).p_value() for evidence in corrected])
    assert np.mean(p < 0.001) < 0.5 * np.mean(plain < 0.001)
    assert np.mean(p < 0.01) < 0.014
