"""Tables for renderers, against the methods that they come from and against walks."""

import re

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

import msbsdf_cli as ms
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.renderers.albedos import albedos, first_share, nodes
from msbsdf_cli.renderers.files import c_header, read_table, write_table
from msbsdf_cli.renderers.nodes import Nodes
from msbsdf_cli.renderers.splines import coefficients, spline
from msbsdf_cli.renderers.tables import BsdfTable, check
from msbsdf_cli.renderers.tabulate import make_table, table_error
from surfaces.materials import Conductor, Dielectric, Diffuse

GOLD = Conductor.named("gold", rgb=True)


@pytest.fixture(scope="module")
def table():
    return make_table(ms.Ggx(0.5, 0.5), GOLD, 2, True)


@pytest.fixture(scope="module")
def two():
    return make_table(ms.Beckmann(0.5, 1), Conductor(), 2, True, Nodes(6, 16, 3))


@pytest.fixture(scope="module")
def glass():
    return make_table(
        ms.Beckmann(1, 1), Dielectric(1.5), 2, True, Nodes.of_glass(1.5, 4, 4, 8), 0.4
    )


def test_splines_are_those_of_the_textbook():
    """Through values at uneven data, "not a knot", one axis after the other."""
    values = np.random.default_rng(0).normal(size=(6, 9))
    places = np.array([0.0, 0.3, 2.5, 4.9, 5.0]), np.array([8.0, 0.1, 4.4, 7.7, 0.0])
    found = spline(coefficients(coefficients(values, 0), 1), places)
    along = make_interp_spline(np.arange(6), values, k=3)(places[0])
    expected = [
        make_interp_spline(np.arange(9), v, k=3)(y) for v, y in zip(along, places[1], strict=True)
    ]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_table_is_within_a_thousandth_of_the_model(table):
    errors, known = table_error(table, 2)
    assert errors.shape == known.shape == (2 * 8 * 8 * 8,)
    assert errors.max() < 1e-3
    assert known.max() < 1e-3


def test_a_diffuse_table_has_all_orders():
    made = make_table(ms.Ggx(1, 1), Diffuse((0.8, 0.5, 0.2)), 2, True, Nodes(8, 8))
    wi, wo = of_nodes(made.nodes, 2, 6, 3)
    expected = Solve(made.slopes, made.material, 1).evaluate(wi, wo).value.sum(axis=1)
    np.testing.assert_allclose(made.evaluate(wi, wo), expected, rtol=1e-5)


def test_a_table_has_the_values_of_walks(table):
    wi, wo = ms.direction(1.0, 0.4), np.array([ms.direction(0.5, 2.0), ms.direction(1.2, 3.0)]).T
    walks = METHODS["walk-low-variance"](table.slopes, table.material, 1)
    found = walks.evaluate(wi, wo, 40_000, np.random.default_rng(0))
    mine, truth = table.evaluate(wi, wo), found.value.sum(axis=1)
    stderr = np.sqrt((found.stderr**2).sum(axis=1))
    assert np.all(np.abs(mine - truth) < 4 * stderr + 0.001 * truth)


def test_a_table_is_reciprocal_and_saved(table, tmp_path):
    np.testing.assert_array_equal(table.values, table.values.swapaxes(3, 4))
    assert np.isfinite(table.values).all()
    write_table(tmp_path / "bsdf.npz", table, np.array([0.1, 0.3]), np.zeros(2))
    content = read_table(tmp_path / "bsdf.npz")
    np.testing.assert_allclose(content["values"], table.values, rtol=1e-6)
    np.testing.assert_allclose(content["eta_k"], table.material.eta_k)
    assert (content["slopes"], content["specular"], content["ior"]) == ("ggx", True, None)
    assert content["alpha"] == [0.5, 0.5]
    assert content["nodes"] == table.nodes
    assert content["error"] == {"largest": 0.3, "mean": pytest.approx(0.2)}


def of_nodes(nodes, i, o, p, q=0):
    """The pair of directions of nodes."""
    theta, phi_i = nodes.theta, nodes.phi_i[q]
    wo = ms.direction(theta[o], phi_i + nodes.phi[p])
    return ms.direction(theta[i], phi_i), wo[:, None]


@pytest.mark.parametrize("q", [0, 1, 2])
def test_two_roughnesses_have_the_values_of_solve_and_its_symmetry(two, q):
    """At nodes, but for the rounding of splines; off them, from all four quadrants alike."""
    solve = Solve(two.slopes, two.material, 1)
    for i, o, p in ((1, 4, 3), (3, 2, 9), (5, 0, 14)):
        wi, wo = of_nodes(two.nodes, i, o, p, q)
        expected = solve.evaluate(wi, wo).value.sum(axis=1)
        np.testing.assert_allclose(two.evaluate(wi, wo), expected, rtol=1e-5, atol=1e-7)
    wi, wo = ms.direction(0.9, 0.3), ms.direction(0.7, 2.0)[:, None]
    first = two.evaluate(wi, wo)
    for mirror in ([-1, 1, 1], [1, -1, 1], [-1, -1, 1]):
        other = two.evaluate(wi * mirror, wo * np.array(mirror)[:, None])
        np.testing.assert_allclose(other, first, rtol=1e-9)


def test_two_roughnesses_are_smooth_across_their_planes_of_symmetry(two):
    """Coefficients beyond either plane are those on its other side, azimuths turned round."""
    around = two.coefficients[0, 0][..., 1:17]
    turned = np.roll(around[..., ::-1], 1, axis=-1)
    np.testing.assert_allclose(around[0], turned[2], rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(around[-1], turned[-3], rtol=1e-5, atol=1e-7)
    assert np.abs(around[0] - around[2]).max() > 1e-3


@pytest.mark.parametrize("side", [1, -1])
def test_glass_has_the_values_of_solve_on_either_side(glass, side):
    """At nodes, which of transmitted light are others outside; reciprocity gives one of the four
    blocks, and light either way differs by .006 on a grid as coarse as this."""
    solve = Solve(glass.slopes, Dielectric(1.5 if side == 1 else 1 / 1.5), 1, 0.4)
    nodes, down = glass.nodes, np.array([[1], [1], [-1]])
    for i, o, p in ((1, 3, 2), (4, 1, 5), (2, 6, 3), (7, 6, 1)):
        outside, inside = nodes.thin_theta(o)[i], nodes.theta[o]
        into, out = (outside, inside) if side == 1 else (inside, outside)
        through = ms.direction(into), ms.direction(out, nodes.phi[p])[:, None] * down
        for wi, wo in (of_nodes(nodes, i, o, p), through):
            expected = solve.evaluate(wi, wo).value.sum(axis=1)
            mine = glass.evaluate(wi * down[:, 0] if side == -1 else wi, wo * [[1], [1], [side]])
            np.testing.assert_allclose(mine, expected, rtol=0.01, atol=1e-5)


@pytest.mark.parametrize("ior", [1.5, 1 / 1.5])
def test_transmission_has_a_corner_where_only_upright_facets_connect(ior):
    """A function with a corner there is found on either side, from either medium, whichever of the
    two has the higher index."""
    nodes = Nodes.of_glass(ior, 8, 10, 8)

    def corner(outside, inside):
        over = np.cos(outside) - ior * np.cos(inside)
        return 1 + np.cos(outside) * np.cos(inside) + np.abs(over)

    n = nodes.elevations
    theta, values = np.tile(nodes.theta, (n, 1)), np.ones((1, 3, 1, n, n, 8))
    thin = np.array([nodes.thin_theta(k) for k in range(n)])
    outside, inside = (thin.T, theta) if ior > 1 else (theta.T, thin)
    values[0, 1, 0] = corner(outside, inside)[..., None]
    table = BsdfTable(ms.Ggx(1, 1), Dielectric(ior), nodes, values)
    theta = np.linspace(0.01, 1.5, 150)
    wo = np.stack([np.sin(theta), 0 * theta, -np.cos(theta)])
    for into in (0.3, 0.75, 1.0, 1.3):
        inwards, out = table.later(ms.direction(into), wo)[0], -ms.direction(into)
        np.testing.assert_allclose(inwards, corner(into, theta), rtol=5e-3)
        outwards = table.later(out, -wo)[0] * ior**2
        np.testing.assert_allclose(outwards, corner(theta, into), rtol=5e-3)


def test_elevations_split_at_the_angle_where_total_reflection_ends():
    """Functions with a corner there are found to a thousandth, and the angle itself twice."""
    nodes = Nodes.of_glass(1.5, 10, 10, 8)
    assert nodes.theta[9] == pytest.approx(nodes.theta[10])
    assert nodes.split == pytest.approx(np.pi / 2 - np.arcsin(1 / 1.5))
    np.testing.assert_array_less(0, np.delete(np.diff(nodes.theta), 9))

    def corner(theta):
        return np.cos(theta) + np.abs(theta - nodes.split)

    values = (corner(nodes.theta) * corner(nodes.theta)[:, None])[..., None]
    table = BsdfTable(ms.Ggx(1, 1), Dielectric(1.5), nodes, np.tile(values, (1, 3, 1, 1, 1, 8)))
    theta = np.linspace(0.001, nodes.theta[-1], 200)
    wi, wo = ms.direction(0.3), np.stack([np.sin(theta), 0 * theta, np.cos(theta)])
    np.testing.assert_allclose(table.later(wi, wo)[0], corner(0.3) * corner(theta), rtol=2e-3)


def test_an_opaque_surface_has_nothing_below(table):
    up, down = np.array([[0.6], [0], [0.8]]), np.array([[0.6], [0], [-0.8]])
    assert (table.evaluate(up[:, 0], down) == 0).all()
    assert (table.later(down[:, 0], up) == 0).all()


@pytest.mark.parametrize(
    ("slopes", "material", "reason"),
    [
        (ms.Ggx(0.5, 0.2), Dielectric(1.5), "one roughness"),
        (ms.Ggx(0.5, 0.5), Diffuse((0.5, 0.6)), "1 channel or 3"),
        (ms.StudentT(0.5, 0.5, 3.0), Conductor(), "student-t"),
    ],
)
def test_what_no_table_holds_is_refused(slopes, material, reason):
    with pytest.raises(UnsupportedError, match=reason):
        check(slopes, material)


def test_albedos_are_the_energy_of_first_orders():
    directional, mean = albedos(ms.Beckmann(0.5, 0.5))
    alpha, cos = nodes(32)[20], nodes(32)[10]
    walk = ms.walk(ms.Smith(ms.Beckmann(alpha, alpha), Conductor()), ms.direction(np.arccos(cos)))
    assert abs(directional[20, 10] - walk.energy[0, 0]) < 4 * walk.energy_stderr[0, 0] + 1e-5
    assert mean[20] == pytest.approx((directional[20] * 2 * nodes(32)).mean())
    # Of the metal's colour nothing is taken into account; sums of few directions are right to .001.
    share = first_share(ms.Beckmann(alpha, alpha), GOLD)
    assert share == pytest.approx(mean[20], abs=0.002)
    assert first_share(ms.Beckmann(alpha, alpha), Diffuse()) == 0


def test_the_header_holds_the_numbers_in_c():
    directional, mean = np.arange(6).reshape(2, 3) / 7, np.array([0.25, 0.75])
    text = c_header("ggx", directional, mean)
    numbers = [float(x) for x in re.findall(r"([0-9.]+)f\b", text)]
    np.testing.assert_allclose(numbers, [*directional.ravel(), *mean], atol=1e-6)
    assert "msbsdf_albedo[2][3]" in text
