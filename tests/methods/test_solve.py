"""The deterministic solution: closed forms, conservation, reciprocity, and the random walk."""

from functools import cache

import numpy as np
import pytest

from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.methods.solver.dielectric import DielectricSolution
from msbsdf_cli.methods.solver.nodes import cosine_integrals
from msbsdf_cli.smith.slopes import Beckmann, StudentT, distribution
from msbsdf_cli.smith.walk import random_walk
from surfaces.materials import Conductor, Dielectric, Diffuse

METAL = Conductor(((0.2, 3.9), (1.5, 1.9)))


def direction(theta, phi=0.0):
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def sphere(n_z, n_phi):
    """Nodes (3, n) and solid angles of both hemispheres, crowded at the horizon."""
    x, weight = np.polynomial.legendre.leggauss(n_z)
    psi, weight = np.pi / 2 * ((x + 1) / 2) ** 2, np.pi / 2 * (x + 1) / 2 * weight
    phi = np.arange(n_phi) * 2 * np.pi / n_phi
    w = np.stack(
        [
            np.outer(np.cos(psi), np.cos(phi)),
            np.outer(np.cos(psi), np.sin(phi)),
            np.outer(np.sin(psi), np.ones(n_phi)),
        ]
    ).reshape(3, -1)
    area = np.repeat(np.cos(psi) * weight, n_phi) * 2 * np.pi / n_phi
    return np.concatenate([w, w * [[1], [1], [-1]]], axis=1), np.tile(area, 2)


def walked(slopes, material, wi, n, orders):
    """Sums over walks of 1, x, y^2 and z, for each order and for all the later ones, on either
    side, in the first channel, and their standard errors: (moments, sides, orders + 1)."""
    total, square = np.zeros((2, 4, 2, orders + 1))
    for light in random_walk(slopes, material, wi, n, np.random.default_rng(7), 300):
        weight = np.ones(light.w.shape[1]) if light.weight is None else light.weight[0]
        values = weight * np.stack([1 + 0 * weight, light.w[0], light.w[1] ** 2, light.w[2]])
        for side, lanes in enumerate((light.w[2] > 0, light.w[2] < 0)):
            k = min(light.order, orders + 1) - 1
            total[:, side, k] += values[:, lanes].sum(1)
            square[:, side, k] += (values[:, lanes] ** 2).sum(1)
    mean = total / n
    # A bin without a single walk is not known better than to one walk.
    return mean, np.sqrt(np.maximum(square / n - mean**2, 1 / n) / n)


@cache
def fine(slopes, alpha, material):
    """The solution of three orders, made once for all that ask for energies: at resolution 1, of
    glass of two roughnesses at .7, whose energies are right to 2e-4."""
    dear = material.transmits and alpha[0] != alpha[1]
    return Solve(distribution(slopes)(*alpha), material, 3, 0.7 if dear else 1.0).fine


def both_sides(energy):
    return np.stack([energy.reflected, energy.transmitted], axis=1)


def test_single_scattering_of_ggx_at_normal_incidence_has_a_closed_form():
    energy = Solve(distribution("ggx")(1.0, 1.0), Conductor(), 3).energy(direction(0))
    # Converges exponentially: what is left is rounding.
    assert energy.reflected[0, 0] == pytest.approx(1 - np.log(2), abs=1e-11)


@pytest.mark.parametrize(
    ("slopes", "material", "alpha"),
    [
        *(
            (slopes, material, alpha)
            for slopes in ("beckmann", "ggx")
            for material, alpha in (
                *((Conductor(), (a, a)) for a in (5.0, 1.0, 0.2, 0.05)),
                *((Diffuse(), (a, a)) for a in (5.0, 1.0, 0.2, 0.05)),
                *((m, (0.6, 0.3)) for m in (Conductor(), Diffuse())),
                *((Dielectric(ior), (1.0, 1.0)) for ior in (1.5, 0.7)),
            )
        ),
        ("beckmann", Dielectric(1.5), (1.0, 0.2)),
        ("ggx", Dielectric(0.7), (0.4, 0.8)),
    ],
)
def test_no_energy_is_lost_over_all_orders(slopes, material, alpha):
    for theta in (0, 0.7, 1.5, 1.57):
        energy = fine(slopes, alpha, material).energy(direction(theta, 0.4))
        # Nothing normalises a mirror's kernel: its sum shows the error of the quadrature, worst
        # where lobes are narrow or the surface is very rough.
        assert abs(energy.sum() - 1) < (1e-5 if isinstance(material, Conductor) else 1e-11)


@pytest.mark.parametrize(
    ("material", "slopes"),
    [(Conductor(), "beckmann"), (METAL, "ggx"), (Diffuse(), "ggx"), (Dielectric(), "ggx")],
)
def test_energy_error_is_what_a_finer_solution_shows(slopes, material):
    surface = distribution(slopes)(1.0, 1.0)
    solve, reference = (Solve(surface, material, 3, r) for r in (1, 1.3))
    for theta in (0.3, 1.5):
        wi = direction(theta)
        energy, finer = solve.energy(wi), reference.fine.energy(wi)
        error = np.abs(both_sides(energy) - finer).max()
        # 1e-6 is promised for half spaces, some 1e-6 for interfaces; the estimate is no smaller
        # than a third of the error, unless both are rounding.
        assert error < (4e-6 if material.transmits else 1e-6)
        assert error < 3 * energy.error.max() + 1e-12


@pytest.mark.parametrize(
    ("material", "slopes", "alpha", "theta"),
    [
        (Conductor(), "beckmann", (1.0, 1.0), 0.8),
        (METAL, "ggx", (0.5, 0.5), 1.3),
        (METAL, "ggx", (0.4, 0.8), 1.0),
        (Diffuse((0.8, 1.0)), "ggx", (1.0, 1.0), 1.3),
        (Diffuse((0.8, 1.0)), "beckmann", (0.4, 0.8), 1.0),
        (Dielectric(1.5), "beckmann", (1.0, 1.0), 0.8),
        (Dielectric(1.5), "ggx", (1.0, 1.0), 1.3),
        (Dielectric(0.7), "ggx", (0.4, 0.8), 1.3),
        (Dielectric(1.5), "beckmann", (1.0, 0.2), 1.0),
    ],
)
def test_energies_of_the_random_walk(material, slopes, alpha, theta):
    surface, wi = distribution(slopes)(*alpha), direction(theta, 0.7)
    mean, stderr = walked(surface, material, wi, 100_000, 3)
    energy = fine(slopes, alpha, material).energy(wi)[0]
    # Eight numbers each: 4.5 standard errors are passed once in 1e4 runs of all of them.
    assert np.all(np.abs(mean[0] - energy) < 4.5 * stderr[0])


@pytest.mark.parametrize(
    ("material", "slopes", "alpha", "theta"),
    [
        (METAL, "beckmann", (1.0, 1.0), 0.8),
        (METAL, "ggx", (0.4, 0.8), 1.0),
        (Diffuse((0.8,)), "ggx", (0.5, 0.5), 1.2),
        (Diffuse((0.8,)), "beckmann", (0.4, 0.8), 1.0),
        (Dielectric(1.5), "beckmann", (1.0, 1.0), 0.8),
        (Dielectric(0.7), "ggx", (1.0, 1.0), 1.2),
    ],
)
def test_directions_of_the_random_walk(material, slopes, alpha, theta):
    surface, wi = distribution(slopes)(*alpha), direction(theta, 0.7)
    mean, stderr = walked(surface, material, wi, 100_000, 2)
    wo, area = sphere(*(10, 18) if material.transmits else (14, 24))
    # Of glass, resolutions .6 and .8 differ by 1e-6 of the incident light here.
    resolution = 0.6 if material.transmits else 0.8
    value = Solve(surface, material, 2, resolution).fine.evaluate(wi, wo)[0][0]
    for side, lanes in enumerate((wo[2] > 0, wo[2] < 0)):
        moments = np.stack([1 + 0 * area, wo[0], wo[1] ** 2, wo[2]])[:, lanes] * area[lanes]
        solved = moments @ value[:, lanes].T
        # Order 1 has edges for the product quadrature to stumble on; the others are smooth.
        np.testing.assert_array_less(
            np.abs(solved - mean[:, side])[:, 1:], 4.5 * stderr[:, side, 1:] + 1e-4
        )


@pytest.mark.parametrize("material", [METAL, Diffuse((0.8, 1.0))], ids=lambda m: m.name)
@pytest.mark.parametrize("alpha", [(0.5, 0.5), (0.5, 0.3)])
def test_reciprocity(material, alpha):
    solve = Solve(distribution("ggx")(*alpha), material, 3, resolution=0.7).fine
    a, b = direction(0.4, 0.3), direction(1.3, 2.0)
    forth = solve.evaluate(a, b[:, None])[0] / b[2]
    back = solve.evaluate(b, a[:, None])[0] / a[2]
    # Exact by construction, but for the grid's and the facets' quadrature.
    np.testing.assert_allclose(forth, back, rtol=1e-9 if material is METAL else 1e-5)


def test_reciprocity_of_an_interface():
    solve = Solve(distribution("beckmann")(1.0, 1.0), Dielectric(1.5), 2).fine
    a, b = direction(0.4, 0.3), direction(1.2, 2.0)
    forth = solve.evaluate(a, b[:, None])[0] / b[2]
    back = solve.evaluate(b, a[:, None])[0] / a[2]
    # Up to order 2 both ends are treated alike, but for what happens between heights; then they
    # are discretised differently, and this is the error of the solution.
    np.testing.assert_allclose(forth[0, :2], back[0, :2], rtol=1e-6)
    np.testing.assert_allclose(forth[0, 2:], back[0, 2:], rtol=5e-3)


@pytest.mark.parametrize("material", [Conductor(), Diffuse(), Dielectric()], ids=lambda m: m.name)
def test_the_last_row_is_the_sum_of_all_later_orders(material):
    surface, wi = distribution("ggx")(1.0, 1.0), direction(0.9)
    wo = np.stack([direction(1.0, 2.0), direction(2.5, 0.3)], axis=1)
    few, many = (Solve(surface, material, n, resolution=0.6) for n in (1, 7))
    # The same sums in another order, at any resolution.
    expected = many.fine.evaluate(wi, wo)[0]
    value = few.fine.evaluate(wi, wo)[0]
    np.testing.assert_allclose(value[:, 1], expected[:, 1:].sum(1), rtol=1e-9, atol=1e-15)
    energies = both_sides(few.energy(wi)), both_sides(many.energy(wi))
    np.testing.assert_allclose(energies[0][..., 1], energies[1][..., 1:].sum(-1), rtol=1e-9)


@pytest.mark.parametrize("material", [METAL, Diffuse()], ids=lambda m: m.name)
def test_grid_and_fourier_modes_agree(material):
    wi, wo = direction(1.0, 0.3), np.stack([direction(0.5, 2.0), direction(1.3, -1)], axis=1)
    modes = Solve(distribution("ggx")(0.7, 0.7), material, 3)
    grid = Solve(distribution("ggx")(0.7, 0.7 * (1 + 1e-12)), material, 3)
    np.testing.assert_allclose(grid.energy(wi).reflected, modes.energy(wi).reflected, atol=2e-5)
    value, expected = (s.fine.evaluate(wi, wo)[0] for s in (grid, modes))
    # The grid's azimuths and facets are the coarser ones.
    np.testing.assert_allclose(value, expected, rtol=1e-3)


@pytest.mark.parametrize("slopes", ["beckmann", "ggx"])
def test_grid_and_fourier_modes_agree_for_an_interface(slopes):
    wi = direction(1.0, 0.3)
    wo = np.stack([direction(0.5, 2.0), direction(1.3, -1), direction(2.5, -2.3)], axis=1)
    modes, grid = (
        Solve(distribution(slopes)(0.7, alpha_y), Dielectric(), 3, resolution=0.7).fine
        for alpha_y in (0.7, 0.7 * (1 + 1e-12))
    )
    # Energies by different nodes in every angle: the errors of both, at less than resolution 1.
    np.testing.assert_allclose(grid.energy(wi), modes.energy(wi), atol=2e-5)
    value, expected = (s.evaluate(wi, wo)[0][0, 1:] for s in (grid, modes))
    # Order 2 is not spread over nodes; later orders, each compared with its largest value, are.
    np.testing.assert_allclose(value[0], expected[0], rtol=2e-3)
    error = np.abs(value - expected).max(axis=1) / expected.max(axis=1)
    assert np.all(error < 2e-2)


@pytest.mark.parametrize("ior", [1.0001, 1 / 1.0001])
def test_an_index_near_1_lets_light_pass(ior):
    with np.errstate(all="raise", under="ignore"):
        energy = Solve(distribution("beckmann")(0.5, 0.5), Dielectric(ior), 2).energy(
            direction(0.8)
        )
    # At normal incidence 2.5e-9 is reflected, and few facets are seen edge-on from 0.8. Light
    # that then is grazing passes many, which the error estimate has to own up to.
    assert energy.reflected.sum() < 1e-5 + energy.error.sum() < 1e-2
    assert abs(both_sides(energy).sum() - 1) < 1e-11


@pytest.mark.parametrize("alpha", [(0.1, 0.1), (1.0, 1.0), (0.7, 0.2)])
def test_coarse_nodes_are_no_trouble_to_arithmetic(alpha):
    wi, wo = direction(0.8, 0.3), np.stack([direction(1.2), direction(2.8)], axis=1)
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        solve = Solve(distribution("beckmann")(*alpha), Dielectric(1.5), 2, resolution=0.3)
        energy, result = solve.energy(wi), solve.evaluate(wi, wo)
    assert abs(both_sides(energy).sum() - 1) < 1e-11
    assert np.all(np.isfinite(result.value))


@pytest.mark.parametrize("slopes", ["beckmann", "ggx"])
def test_grazing_to_grazing(slopes):
    surface = distribution(slopes)(0.5, 0.5)
    wi = direction(1.57, np.pi)
    wo = np.stack([direction(1.57), direction(1.57, 0.5), direction(1.57, 3.1)], axis=1)
    result = Solve(surface, Conductor(), 2).evaluate(wi, wo)
    value = Solve(surface, Conductor(), 2, resolution=2).evaluate(wi, wo).value
    assert np.all(result.stderr[:, 0] == 0)
    # The lobe is narrower than any mode there, but next to nothing is scattered twice.
    np.testing.assert_allclose(result.value.sum(1), value.sum(1), atol=1e-5 * value.max())


@pytest.mark.parametrize(("slopes", "phi"), [("beckmann", np.pi / 2), ("ggx", 0)])
def test_error_of_a_coarse_grid_of_directions(slopes, phi):
    surface = distribution(slopes)(1, 0.4)
    wi = direction(1.5, phi)
    wo = direction([0.2, 1.1, 1.4, 1.5, 1.4], [0, 1, phi, phi + 3, phi + np.pi])
    found = Solve(surface, Conductor(), 2).evaluate(wi, wo)
    value = Solve(surface, Conductor(), 2, resolution=1.3).fine.evaluate(wi, wo)[0]
    found.value[:, 0] = 0  # The first order is not solved for.
    # Lobes are narrower than the grid: values ripple about the right ones, and a distance between
    # two ripples is the scale of the error, not a bound. From the nearer grid alone it would be up
    # to 8 times too small.
    assert (np.abs(found.value - value) <= 2 * found.stderr + 1e-9 * value.max()).all()


def test_a_wanted_accuracy_is_refined_to():
    arguments, wi = (distribution("ggx")(1, 1), Diffuse(), 2), direction(1.0)
    wanted = Solve(*arguments).energy(wi).error.max() / 2
    found = Solve.accurate(*arguments, wi[:, None], wanted).energy(wi)
    assert found.error.max() <= wanted
    assert (found.reflected + found.transmitted).sum() == pytest.approx(1, abs=1e-12)


def test_reflection_only_leaves_nothing_below():
    wi, wo = direction(0.5), direction(2.0)[:, None]
    assert np.all(Solve(distribution("ggx")(0.5, 0.5), Conductor(), 2).evaluate(wi, wo).value == 0)


def test_precision_of_the_result_is_that_of_the_direction():
    wi, wo = direction(0.5).astype(np.float32), direction(1.0)[:, None].astype(np.float32)
    result = Solve(distribution("beckmann")(0.5, 0.5), Conductor(), 2).evaluate(wi, wo)
    assert result.value.dtype == result.stderr.dtype == np.float32
    assert result.unresolved < 1e-15


@pytest.mark.parametrize("slopes", ["beckmann", "ggx"])
def test_few_modes_stand_for_all(slopes, monkeypatch):
    wi, wo = direction(1.2), np.array([direction(1.1, 3.0), direction(0.9, 2.5), direction(1.5)]).T
    few = Solve(distribution(slopes)(0.15, 0.15), Conductor(), 2).fine
    found, _ = few.evaluate(wi, wo)
    assert few._directional[1].kernel.down.shape[1] < 120
    monkeypatch.setattr("msbsdf_cli.methods.solver.isotropic.DENSE", 10**6)
    every = Solve(distribution(slopes)(0.15, 0.15), Conductor(), 2).fine
    expected, _ = every.evaluate(wi, wo)
    assert every._directional[1].kernel.down.shape[1] == 307
    # Of the largest value of each order; 3e-7 was found over roughness .05 to 1.
    np.testing.assert_allclose(found, expected, atol=1e-6 * expected.max())


def test_few_modes_stand_for_all_of_glass(monkeypatch):
    wi, wo = direction(1.0), np.array([direction(0.9, 3.0), direction(2.4), direction(1.3)]).T
    arguments = Beckmann(0.15, 0.15), Dielectric(1.5), 2, 1.0
    found, _ = DielectricSolution(*arguments).evaluate(wi, wo)
    monkeypatch.setattr("msbsdf_cli.methods.solver.interpolation.DENSE_WITH_EDGES", 10**6)
    expected, _ = DielectricSolution(*arguments).evaluate(wi, wo)
    assert not np.array_equal(found, expected)
    # Total reflection leaves a little: 1.5e-5 of the largest was found at roughness .1.
    np.testing.assert_allclose(found, expected, atol=3e-5 * expected.max())


def test_light_that_hardly_leaves_is_refused_and_not_followed_for_ever():
    walls = Solve(StudentT(0.5, 0.5, 1.500001), Diffuse(), 2)
    with pytest.raises(ArithmeticError, match="hundreds of thousands of facets"):
        walls.energy(direction(1.0))
    steep = Solve(StudentT(0.5, 0.5, 1.501), Diffuse(), 2).energy(direction(1.0))
    assert steep.reflected.sum() == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("width", [1e-3, 0.02, 0.3])
def test_integrals_over_azimuth_are_those_of_gaussians_and_poles(width):
    m = np.array([0, 1, 10, 200, 4000])
    phi, factors = cosine_integrals(m)
    gaussian = np.exp(-((phi / width) ** 2)) @ factors
    exact = width * np.sqrt(np.pi) / 2 * np.exp(-((m * width) ** 2) / 4)
    # Twelve nodes for each doubling of the azimuth: 4e-9 of the integral was found.
    np.testing.assert_allclose(gaussian, exact, atol=2e-8 * exact[0])
    # A Poisson kernel, whose modes are r^m, is peaked like a pole at distance -ln r.
    r = np.exp(-width)
    poisson = (1 - r * r) / ((1 - r) ** 2 + 4 * r * np.sin(phi / 2) ** 2)
    np.testing.assert_allclose(poisson @ factors, np.pi * r**m, atol=1e-8)


@pytest.mark.parametrize("theta", [1.570796, np.nextafter(np.pi / 2, 0)])
def test_stated_errors_cover_the_first_order_at_the_horizon(theta):
    slopes = distribution("beckmann")(0.5, 0.5)
    energy = Solve(slopes, Dielectric(1.5), 2).energy(direction(theta))
    found = float(energy.reflected[0, 0] + energy.transmitted[0, 0])
    walks = 100_000
    lights = random_walk(
        slopes, Dielectric(1.5), direction(theta), walks, np.random.default_rng(0), 500
    )
    first = sum(light.w.shape[1] for light in lights if light.order == 1) / walks
    # A binomial share, 4 standard errors.
    assert abs(found - first) < energy.error[0, 0] + 4 * np.sqrt(first * (1 - first) / walks)
