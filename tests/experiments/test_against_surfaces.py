"""The table of what remembering a facet is worth, and the chart against surfaces."""

from dataclasses import replace

import numpy as np
import pytest

from msbsdf_cli.experiments.against_surfaces import rows
from msbsdf_cli.experiments.realisations import Resolution, simulate
from msbsdf_cli.experiments.tradeoff.rows import Row, against_surfaces
from msbsdf_cli.experiments.tradeoff.surface_reference import Distance
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.heights import Gaussian
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.materials import Conductor
from surfaces.spectrum import GAUSSIAN


@pytest.fixture(scope="module")
def table():
    scene = Scene(Conductor(), Beckmann(1, 1), (1.0,))
    paths = FreePaths((1.0,), (-1.0,), Gaussian().edges)
    run = simulate(scene, 100_000, Resolution(8, 12, 16), paths, 3, 1, 1000, True)
    return rows(run, GAUSSIAN, 60_000, 0)


def test_each_quantity_has_a_row_for_each_place(table):
    assert [(r.quantity, r.theta_rad, r.start) for r in table] == [
        ("wrong_order", 1.0, ""),
        ("total_variation", 1.0, ""),
        ("free_path_ks", 1.0, "-1"),
    ]
    for r in table:
        assert (r.material, r.alpha_x, r.alpha_y) == ("conductor", 1, 1)
        assert np.isfinite([r.smith, r.memory, r.memory_2, r.stderr]).all()
        assert 0 < r.cpu_smith_s < min(r.cpu_memory_s, r.cpu_memory_2_s)


def test_memory_is_nearer_to_surfaces_than_smith(table):
    """Known beforehand from simulations that took minutes: .033 and .002, .027 and .005, .094 and
    .002."""
    wrong, lobe, paths = table
    assert wrong.smith == pytest.approx(0.034, abs=4 * wrong.stderr)
    assert wrong.memory < wrong.smith / 3 + 2 * wrong.stderr
    assert wrong.memory_2 < wrong.smith / 3 + 2 * wrong.stderr
    assert max(lobe.memory, lobe.memory_2) < lobe.smith
    assert paths.smith == pytest.approx(0.094, abs=4 * paths.stderr + 0.01)
    assert max(paths.memory, paths.memory_2) < paths.smith / 3 + 2 * paths.stderr


SCENE = ("conductor", "beckmann", 1.0, 1.0, 1.0)
ROW = Row("walk", *SCENE, 64, 1.0, 0.03, 0.0, 1.0, noise=0.03, noise_stderr=0.003, model="smith")


def test_errors_against_surfaces_add_the_distance_of_the_model():
    walk = replace(ROW, seconds_low=1.0, seconds_high=1.0, relative_rmse_stderr=0.003)
    # Against Smith it would be off by .4; against its own model it has noise only.
    memory = replace(walk, method="walk-memory", model="memory", relative_rmse=0.4)
    traced = replace(walk, method="simulate", reference="surfaces", model="surfaces")
    found = [Distance(1.0, "smith", 0.04, 0.004), Distance(1.0, "memory", 0.0, 0.0)]
    a, b, c = against_surfaces([walk, memory, traced], found)
    assert (a.relative_rmse, a.bias) == pytest.approx((0.05, 0.04))
    assert a.efficiency == pytest.approx(1 / 0.05**2)
    assert a.relative_rmse_stderr == pytest.approx(np.hypot(0.6 * 0.003, 0.8 * 0.004))
    assert (b.relative_rmse, b.reference) == (pytest.approx(0.03), "surfaces")
    assert c.relative_rmse == 0.03
    assert [r.pareto for r in (a, b, c)].count(True) >= 1
    assert not a.pareto
