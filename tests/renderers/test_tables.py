"""Tables for renderers, against the methods that they come from and against walks."""

import re

import numpy as np
import pytest

import msbsdf_cli as ms
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.renderers.files import c_header, read_table, write_table
from msbsdf_cli.renderers.tables import (
    albedos,
    interpolation_error,
    make_table,
    nodes,
)
from surfaces.materials import Conductor, Dielectric


@pytest.fixture(scope="module")
def table():
    return make_table(ms.Ggx(0.5, 0.5), Conductor(((0.2, 3.4), (0.4, 2.4))), 2, True)


def test_a_table_is_within_a_percent_of_the_model(table):
    errors = interpolation_error(table)
    assert errors.shape == (512,)
    assert errors.max() < 0.01


def test_a_table_has_the_values_of_walks(table):
    wi, wo = ms.direction(1.0, 0.4), np.array([ms.direction(0.5, 2.0), ms.direction(1.2, 3.0)]).T
    walks = METHODS["walk-low-variance"](table.slopes, table.material, 1)
    found = walks.evaluate(wi, wo, 40_000, np.random.default_rng(0))
    mine, truth = table.evaluate(wi, wo), found.value.sum(axis=1)
    stderr = np.sqrt((found.stderr**2).sum(axis=1))
    assert np.all(np.abs(mine - truth) < 4 * stderr + 0.01 * truth)


def test_a_table_is_reciprocal_and_saved(table, tmp_path):
    np.testing.assert_array_equal(table.values, table.values.swapaxes(1, 2))
    assert np.isfinite(table.values).all()
    write_table(tmp_path / "bsdf.npz", table, 0.8, 0.004)
    content = read_table(tmp_path / "bsdf.npz")
    np.testing.assert_allclose(content["values"], table.values, rtol=1e-6)
    np.testing.assert_allclose(content["eta_k"], table.material.eta_k)
    assert (content["slopes"], content["alpha"], content["specular"]) == ("ggx", 0.5, True)


@pytest.mark.parametrize(
    ("slopes", "material"),
    [
        (ms.Ggx(0.5, 0.2), Conductor()),
        (ms.Ggx(0.5, 0.5), Dielectric(1.5)),
        (ms.StudentT(0.5, 0.5, 3.0), Conductor()),
    ],
)
def test_what_no_table_holds_is_refused(slopes, material):
    with pytest.raises(UnsupportedError):
        make_table(slopes, material, 1, True)


def test_albedos_are_the_energy_of_first_orders():
    directional, mean = albedos(ms.Beckmann(0.5, 0.5))
    alpha, cos = nodes(32)[20], nodes(32)[10]
    walk = ms.walk(ms.Smith(ms.Beckmann(alpha, alpha), Conductor()), ms.direction(np.arccos(cos)))
    assert abs(directional[20, 10] - walk.energy[0, 0]) < 4 * walk.energy_stderr[0, 0] + 1e-5
    assert mean[20] == pytest.approx((directional[20] * 2 * nodes(32)).mean())


def test_the_header_holds_the_numbers_in_c():
    directional, mean = np.arange(6).reshape(2, 3) / 7, np.array([0.25, 0.75])
    text = c_header("ggx", directional, mean)
    numbers = [float(x) for x in re.findall(r"([0-9.]+)f\b", text)]
    np.testing.assert_allclose(numbers, [*directional.ravel(), *mean], atol=1e-6)
    assert "msbsdf_albedo[2][3]" in text
