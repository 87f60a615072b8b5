"""Tables that shade pictures: of `solve`, and of light traced on explicit surfaces."""

import numpy as np
import pytest

from msbsdf_cli.experiments.render import solved, tables
from msbsdf_cli.experiments.render.tables import SURFACES, check_tabulated, tabulated
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.renderers import tabulate
from msbsdf_cli.renderers.nodes import Nodes
from msbsdf_cli.renderers.tables import BsdfTable
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import Beckmann, Ggx, StudentT
from surfaces.materials import Conductor, Dielectric, Diffuse
from surfaces.materials.diffuse import TexturedDiffuse
from surfaces.streams import stream

RNG = stream(5, "evaluate", "tables")
N = 40_000


def lanes(w):
    return np.tile(w[:, None], N)


@pytest.mark.parametrize("material", [Conductor.named("gold", rgb=True), Diffuse(0.7)])
def test_samples_of_a_table_of_solve_return_its_energy(material, monkeypatch):
    monkeypatch.setattr(tabulate, "nodes_for", lambda slopes, material: Nodes(16, 32))
    slopes = Ggx(0.8, 0.8)
    table, inside = tabulated("solve", slopes, material, False, 0, 1, True)
    assert inside is None
    assert 0 < table.table.error < 1e-3
    for theta in (0.4, 1.2):
        wi = direction(theta)
        known = Solve(slopes, material, 1).energy(wi)
        _, weight = table.sample_each(lanes(wi), RNG)
        stderr = weight.std(axis=1) / np.sqrt(N)
        off = np.abs(weight.mean(axis=1) - known.reflected.sum(axis=1))
        assert (off < 4 * stderr + table.table.error).all()


def test_a_table_of_glass_sends_on_all_light_from_either_side(monkeypatch):
    """Coarser, for the test's time, and so right to some hundredths: what that leaves is in the
    error that the table states, for a mean of directions, and some of them are further off."""
    monkeypatch.setattr(solved, "GLASS_ELEVATIONS", (5, 5))
    monkeypatch.setattr(solved, "GLASS_AZIMUTHS", 8)
    monkeypatch.setattr(solved, "TRUTH", 0.4)
    monkeypatch.setattr(solved, "ELEVATIONS", 2)
    sides = tabulated("solve", Ggx(1.0, 1.0), Dielectric(1.5), False, 0, 1, True)
    assert 0 < sides[0].table.error < 0.03
    for side in sides:
        for theta in (0.4, 1.2):
            _, weight = side.sample_each(lanes(direction(theta)), RNG)
            stderr = weight.std() / np.sqrt(N)
            assert weight.mean() == pytest.approx(1, abs=4 * stderr + 2 * side.table.error)


def test_values_between_roughnesses_are_those_of_solve(monkeypatch):
    """Half way between steps of .2 the second difference leaves 2 % of a value."""
    material = Conductor()
    monkeypatch.setattr(tables, "LEVELS", 6)
    monkeypatch.setattr(tabulate, "nodes_for", lambda slopes, material: Nodes(14, 32))
    table, _ = tabulated("solve", Beckmann(1.0, 1.0), material, True, 0, 1, True)
    assert table.table.error > 0
    wi, wo = direction(0.7), direction(0.9, 2.0)
    for alpha in (0.5, 0.9):
        each = np.full(N, alpha)
        value = table.of_lanes(Beckmann(1.0, 1.0).of_lanes(each, each), material)
        mine = value.evaluate_each(lanes(wi), lanes(wo), RNG)[0, 0]
        known = Solve(Beckmann(alpha, alpha), material, 1).evaluate(wi, wo[:, None])
        assert mine == pytest.approx(known.value.sum(), rel=0.03)


def test_diffuse_facets_without_roughness_are_a_plane():
    nodes = Nodes(6, 8)
    level = BsdfTable(Beckmann(1.0, 1.0), Diffuse(0.5), nodes, np.full((1, 1, 1, 6, 6, 8), 0.4))
    table = solved.SolvedTable((level,), True, 0.0)
    wi = np.tile(direction(0.3)[:, None], 3)
    value = table(np.array([0.01, 0.25, 1.0]), wi, wi, np.zeros(3, bool))
    plane = 0.5 / np.pi
    expected = [0.99 * plane + 0.01 * 0.4, 0.75 * plane + 0.25 * 0.4, 0.4]
    np.testing.assert_allclose(value[0], expected, rtol=1e-9)


@pytest.mark.parametrize("material", [Conductor(), Diffuse((0.8, 0.4)), Dielectric(1.5)])
def test_surfaces_shade_as_they_send_light(material, monkeypatch):
    monkeypatch.setattr(tables, "RAYS", 10_000)
    monkeypatch.setattr(tables, "SAMPLES_OF_SINGLE", 50_000)
    monkeypatch.setattr(tables, "ACCURACY", 0.04)
    monkeypatch.setattr(tables, "THETA_OF_SURFACES", (0.0, 0.8, 1.4))
    slopes = Beckmann(1.0, 1.0)
    table, _ = tabulated(SURFACES, slopes, material, False, 0, 1, True)
    wi = direction(0.8)
    _, weight = table.sample_each(lanes(wi), RNG)
    stderr = weight.std(axis=1) / np.sqrt(N)
    if not material.absorbs:
        # Surfaces lose nothing: 3 % for bins that are interpolated and noisy values below 0 that
        # are left out.
        assert weight.mean() == pytest.approx(1, abs=4 * stderr[0] + 0.03)
        return
    single = METHODS["single"](slopes, material, 1).sample_each(lanes(wi), RNG)[1].mean(axis=1)
    # Several bounces return more than one, and less of the darker channel's.
    added = weight.mean(axis=1) / single
    assert (added > 1).all()
    assert added[0] > added[1]


def test_what_no_table_is_made_of_is_refused():
    for name, slopes, said in (
        ("solve", Ggx(0.5, 0.1), "room for one roughness"),
        (SURFACES, Beckmann(0.5, 0.1), "room for one roughness"),
        (SURFACES, Ggx(0.5, 0.5), "are Gaussian"),
    ):
        with pytest.raises(UnsupportedError, match=said):
            check_tabulated(name, slopes, Conductor())
    with pytest.raises(UnsupportedError, match="student-t"):
        check_tabulated("solve", StudentT(0.5, 0.5, 3.0), Conductor())


def test_a_table_has_one_albedo_and_one_roughness():
    slopes = Beckmann(0.5, 0.5)
    table, _ = tabulated("solve", slopes, Conductor(), False, 0, 1, True)
    one = np.full(2, 0.5)
    with pytest.raises(UnsupportedError, match="one albedo"):
        table.of_lanes(slopes, TexturedDiffuse(lanes=np.ones((3, 2))))
    with pytest.raises(UnsupportedError, match="not two"):
        table.of_lanes(slopes.of_lanes(one, one / 2), Conductor())
