"""The random walk against closed forms and against a second walk written from the paper alone."""

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from msbsdf_cli.smith.heights import HEIGHTS
from msbsdf_cli.smith.slopes import NAMES, Beckmann, Ggx, Lambda, distribution
from msbsdf_cli.smith.walk import flip, free_path, random_walk
from msbsdf_cli.statistics.tally import Tally
from surfaces.materials import Conductor, Dielectric, Diffuse
from surfaces.materials._metals import METALS


def run(slopes, material, theta, n=400_000, orders=4, dtype=np.float64, max_order=10_000, seed=1):
    wi = np.array([np.sin(theta), 0, np.cos(theta)], dtype)
    tally = Tally(orders)
    rng = np.random.Generator(np.random.SFC64(seed))
    for light in random_walk(slopes, material, wi, n, rng, max_order):
        tally.add(light)
    return tally


def within(estimate, expected, sigmas=4.0):
    return np.all(np.abs(estimate.value - expected) < sigmas * estimate.stderr)


def test_ggx_first_order_in_closed_form():
    # Heitz et al. 2016: at alpha 1 and normal incidence E_1 = 1 - ln 2.
    energy = run(Ggx(1, 1), Conductor(), 0.0, 2_000_000).estimate("energy")
    assert abs(energy.value[0, 0] - (1 - np.log(2))) < 4 * energy.stderr[0, 0]


@pytest.mark.parametrize("name", sorted(NAMES))
@pytest.mark.parametrize(
    "material", [Conductor(METALS["copper"][1:2]), Diffuse((0.7,)), Dielectric(1.5)]
)
@pytest.mark.parametrize("theta", [0.0, 1e-5, 0.8, 1.5707, np.nextafter(np.pi / 2, 0)])
def test_energy_is_conserved_to_rounding(name, material, theta):
    tally = run(distribution(name)(0.5, 0.5), material, theta, 20_000)
    parts = [tally.estimate(k).value.sum() for k in ("energy", "absorbed", "unresolved")]
    assert sum(parts) == pytest.approx(1, abs=1e-12)
    assert parts[2] == 0


def paper_walk(slopes, material, theta, n, rng, bounces=40):
    """[HHdD16] Algorithms 1 and 7 with Gaussian heights and visible normals by rejection: nothing
    here but NumPy, SciPy's normal distribution and the definition of the model.

    Returns energies (order, side).
    """
    d = np.tile([[-np.sin(theta)], [0.0], [-np.cos(theta)]], n)
    h = np.full(n, 40.0)
    inside = np.zeros(n, bool)
    energy = np.zeros((bounces + 1, 2))
    for order in range(bounces + 1):
        flipped = np.where(inside, -1, 1)
        w = d * flipped
        big_lambda = np.array(slopes.sigma(w) / w[2])
        c1 = ndtr(h * flipped)
        u = rng.random(h.size)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            reached = c1 / (1 - u) ** (1 / big_lambda)
        leaves = reached >= 1
        for side in (0, 1):
            energy[order, side] = np.count_nonzero(leaves & (inside == side)) / n
        d, inside, flipped = d[:, ~leaves], inside[~leaves], flipped[~leaves]
        h = ndtri(reached[~leaves]) * flipped
        if h.size == 0:
            return energy
        m = by_rejection(slopes, -d * flipped, rng) * flipped
        cos_i = -(d * m).sum(axis=0)
        if material == "diffuse":
            z = rng.standard_normal(d.shape)
            z /= np.sqrt((z * z).sum(axis=0))
            d = m + z
            d /= np.sqrt((d * d).sum(axis=0))
            continue
        reflected = d + 2 * cos_i * m
        if material == "dielectric":
            eta = np.where(inside, 1 / 1.5, 1.5)
            sin2 = (1 - cos_i**2) / eta**2
            cos_t = np.sqrt(np.maximum(1 - sin2, 0))
            r_s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
            r_p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
            through = rng.random(h.size) > np.where(sin2 < 1, (r_s**2 + r_p**2) / 2, 1)
            refracted = d / eta + (cos_i / eta - cos_t) * m
            d = np.where(through, refracted, reflected)
            inside = inside ^ through
        else:
            d = reflected
    raise AssertionError("paths are left")


def by_rejection(slopes, wi, rng):
    """Visible normals of Gaussian slopes: a slope is kept with probability (wi . m / m_z) / bound.

    The bound is that of a slope seven standard deviations steep, of probability exp(-49 / 2).
    """
    out = np.empty_like(wi)
    lanes = np.arange(wi.shape[1])
    bound = np.hypot(1, 7 * max(slopes.alpha_x, slopes.alpha_y) / np.sqrt(2))
    while lanes.size:
        # Of the few lanes that are left, each tries many slopes at once, and the first one counts.
        tries = max(4096 // lanes.size, 1)
        x, y = rng.standard_normal((2, tries, lanes.size)) / np.sqrt(2)
        seen = wi[2, lanes] - slopes.alpha_x * x * wi[0, lanes] - slopes.alpha_y * y * wi[1, lanes]
        accepted = rng.random(x.shape) * bound < seen
        done = accepted.any(axis=0)
        first = accepted.argmax(axis=0)[done], np.flatnonzero(done)
        m = np.stack([-slopes.alpha_x * x[first], -slopes.alpha_y * y[first], 1 + 0 * x[first]])
        out[:, lanes[done]] = m / np.sqrt((m * m).sum(axis=0))
        lanes = lanes[~done]
    return out


@pytest.mark.parametrize("material", ["conductor", "diffuse", "dielectric"])
@pytest.mark.parametrize(("alpha", "theta"), [((0.5, 0.5), 1.0), ((1.0, 0.4), 0.3)])
def test_energies_against_a_walk_in_heights(material, alpha, theta, rng):
    slopes = Beckmann(*alpha)
    n = 44_000
    reference = paper_walk(slopes, material, theta, n, rng)
    facets = {"conductor": Conductor(), "diffuse": Diffuse(), "dielectric": Dielectric(1.5)}
    tally = run(slopes, facets[material], theta)
    ours = tally.estimate("energy")
    expected = np.vstack([reference[1:5], reference[5:].sum(axis=0)])
    noise = np.sqrt(expected * (1 - expected) / n + ours.stderr**2 + 1 / n**2)
    assert np.all(np.abs(ours.value - expected) < 4.5 * noise)
    assert reference[0].sum() == 0


def test_grazing_dielectric_that_the_published_rule_misses():
    # |cos| < 1e-4 keeps the height there; right is E_r .208, E_t1 .627, 1.17 facets.
    tally = run(Beckmann(0.5, 0.5), Dielectric(1.5), 1.5707)
    energy = tally.estimate("energy").value
    assert energy[:, 0].sum() == pytest.approx(0.208, abs=0.003)
    assert energy[0, 1] == pytest.approx(0.627, abs=0.004)
    assert tally.facets / tally.rays == pytest.approx(1.17, abs=0.01)


@pytest.mark.parametrize("name", sorted(NAMES))
def test_masking_from_walked_heights(name, rng):
    """1 / (1 + Lambda): points of random height, seen from a direction."""
    slopes = distribution(name)(0.8, 0.8)
    w = np.array([[np.sin(1.2)], [0], [np.cos(1.2)]])
    n = 500_000
    t = HEIGHTS["gaussian"].t(rng.standard_normal(n))
    escaped, _ = free_path(t, w, slopes.sigma(w), rng.standard_exponential(n))
    expected = 1 / (1 + Lambda(slopes, w)[0])
    stderr = np.sqrt(expected * (1 - expected) / n)
    assert abs(escaped.mean() - expected) < 4 * stderr


def test_height_distributions_invert_to_the_same_t(rng):
    u = rng.random(1000)
    np.testing.assert_allclose(HEIGHTS["gaussian"].t(ndtri(u)), -np.log(u), rtol=1e-9)
    np.testing.assert_allclose(HEIGHTS["uniform"].t(2 * u - 1), -np.log(u), rtol=1e-9)


def test_flip_is_its_own_inverse_at_both_ends():
    t = np.array([1e-300, 1e-20, 1e-3, 0.6, np.log(2), 0.8, 3.0, 30.0, 600.0])
    np.testing.assert_allclose(flip(flip(t)), t, rtol=1e-12)
    # C1 + (1 - C1) = 1
    np.testing.assert_allclose(np.exp(-t) + np.exp(-flip(t)), 1, rtol=1e-15)


def test_single_precision_agrees():
    for material in (Conductor(), Diffuse(), Dielectric(1.5)):
        for slopes in (Beckmann(0.5, 0.5), Ggx(0.5, 0.1)):
            a = run(slopes, material, 1.2, dtype=np.float32, seed=5).estimate("energy")
            b = run(slopes, material, 1.2, seed=6).estimate("energy")
            noise = np.hypot(a.stderr, b.stderr)
            assert np.all(np.abs(a.value - b.value) < 4.5 * noise)


def test_what_is_cut_off_is_named():
    tally = run(Ggx(5, 5), Conductor(), 0.0, 50_000, max_order=3)
    assert tally.estimate("unresolved").value > 0.1
    total = tally.estimate("energy").value.sum() + tally.estimate("unresolved").value
    assert total == pytest.approx(1, abs=1e-12)


def test_very_rough_conductor_keeps_its_energy():
    # A cap of 16 facets would leave .896 of it.
    tally = run(Ggx(5, 5), Conductor(), 0.0, 50_000)
    assert tally.estimate("energy").value.sum() == pytest.approx(1, abs=1e-12)


def test_standard_errors_are_the_spread(rng):
    estimates = [
        run(Beckmann(1, 1), Diffuse((0.5,)), 0.7, 5_000, seed=s).estimate("energy")
        for s in range(60)
    ]
    values = np.array([e.value[:2, 0] for e in estimates])
    stated = np.array([e.stderr[:2, 0] for e in estimates]).mean(axis=0)
    # The spread of 60 is known to 1 / sqrt(2 * 59) = 9 %: 4 of these.
    np.testing.assert_allclose(values.std(axis=0, ddof=1), stated, rtol=0.37)


@pytest.mark.parametrize("material", [Conductor(((0.001, 10.0),)), Diffuse((1 - 1e-6,))])
def test_what_is_hardly_absorbed_is_counted_in_single_precision(material):
    single, double = (
        run(Beckmann(0.5, 0.5), material, 0.5, 50_000, dtype=dtype).estimate("absorbed")
        for dtype in (np.float32, np.float64)
    )
    assert 0 < double.value < 1e-4
    noise = np.hypot(single.stderr, double.stderr)
    assert abs(single.value - double.value) < 5 * noise + 1e-6 * double.value
