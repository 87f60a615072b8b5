"""Lobes of methods in bins: means over the bins, however narrow the lobe."""

import numpy as np
import pytest

from msbsdf_cli.experiments.evaluate import evaluate
from msbsdf_cli.experiments.method_lobes import bins, places
from msbsdf_cli.methods.single import Single
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.binning import lobe_axes
from msbsdf_cli.statistics.tally import Tally
from surfaces.materials import Conductor, Dielectric, Diffuse

GLASS = Scene(Dielectric(), Beckmann(1, 0.1), (0.5,), 0.0, orders=1)


@pytest.mark.parametrize(
    ("scene", "expected"),
    [
        (Scene(Conductor(), Beckmann(0.5, 0.5), (0,), 0), 2),
        (Scene(Conductor(), Beckmann(0.5, 0.5), (0, 1.5), 0), 8),
        (Scene(Conductor(), Beckmann(0.001, 0.001), (0,), 0), 16),
        (Scene(Dielectric(), Beckmann(0.25, 0.5), (0,), 0), 4),
        (GLASS, 16),
        (Scene(Diffuse(), Beckmann(0.1, 0.1), (1.5,), 0), 2),
    ],
)
def test_narrow_lobes_are_seen_in_more_places(scene, expected):
    assert places(scene) == expected


@pytest.mark.parametrize("alpha", [0.1, 0.25])
def test_energy_of_grazing_light_is_that_of_solve(alpha):
    scene = Scene(Conductor(), Beckmann(alpha, alpha), (1.5,), 0.0, orders=1)
    wo, solid_angle = bins(False, places(scene))
    arithmetic = 0, 1, "float64", True
    (found,) = evaluate(scene, ("single",), wo, 1, *arithmetic, solid_angle)
    exact = Solve(scene.slopes, Conductor(), 1).energy(scene.wi(1.5)).reflected[0, 0]
    # At bin centres alone it would be off by 4 % and more; at 0.1, 16 places are too few by half.
    assert found.energy[0, 0, 0, 0] == pytest.approx(exact, rel=0.01 if alpha < 0.2 else 0.001)
    assert found.energy[1, 0, 0, 0] > 0


def test_error_of_an_energy_is_noise_and_not_where_the_parts_look():
    # At grazing incidence the chance to leave makes noise of what is otherwise all the energy.
    scene = Scene(Conductor(), Beckmann(0.1, 0.1), (1.5,), 0.0, orders=1)
    wo, solid_angle = bins(False, 4)
    runs = [
        evaluate(scene, ("walk",), wo, 160, seed, 1, "float64", True, solid_angle)[0].energy
        for seed in range(12)
    ]
    energies = np.array([run[0, 0, 0, 0] for run in runs])
    stated = np.sqrt(np.mean([run[1, 0, 0, 0] ** 2 for run in runs]))
    # 12 runs tell a scatter to 21 %; the places differ by a hundred times as much.
    assert energies.std(ddof=1) == pytest.approx(stated, rel=0.5)


def test_places_fill_the_bins_evenly():
    polar, azimuth, _ = lobe_axes()
    wo, solid = bins(True, 16)
    assert solid.sum() == pytest.approx(4 * np.pi)
    cos = wo[:, 2].reshape(16, 2, polar.size, azimuth.size)
    edges = np.cos(np.linspace(0, np.pi / 2, polar.size + 1))
    assert ((cos[:, 0, :, 0] < edges[:-1]) & (cos[:, 0, :, 0] > edges[1:])).all()
    np.testing.assert_allclose(cos[:, 0, :, 0].mean(axis=0), (edges[1:] + edges[:-1]) / 2)
    np.testing.assert_array_equal(cos[:, 1], -cos[:, 0])
    phi = np.arctan2(wo[:, 1], wo[:, 0]).reshape(16, 2, polar.size, azimuth.size)
    off = np.angle(np.exp(1j * (phi - azimuth)))
    assert (np.abs(off) < np.pi / azimuth.size).all()
    np.testing.assert_allclose(off.mean(axis=0), 0, atol=1e-12)


def test_a_narrow_lobe_is_that_of_counted_light():
    wi, n = GLASS.wi(0.5), 400_000
    tally = Tally(orders=1)
    rng = np.random.default_rng(1)
    for light in random_walk(GLASS.slopes, GLASS.material, wi, n, rng, 1000):
        tally.add(light)
    counted = tally.estimate("lobe")
    wo, solid_angle = bins(True, places(GLASS))
    (found,) = evaluate(GLASS, ("single",), wo, 1, 0, 1, "float64", True, solid_angle)
    centre = Single(GLASS.slopes, GLASS.material, 1).evaluate(wi, bins(True, 1)[0][0], 1, rng)
    shape = counted.value[0].shape
    modelled, at_centres = (
        (v * solid_angle).reshape(shape) for v in (found.value[0, 0], centre.value[0, 0])
    )
    stderr = np.sqrt(modelled / n) + 1 / n
    # 3600 bins: beyond 5 standard errors by chance once in 500; a rule of 16 places is right to a
    # percent of a lobe.
    off = np.abs(counted.value[0] - modelled)
    assert (off <= 5 * stderr + 0.01 * modelled).all()
    assert (np.abs(counted.value[0] - at_centres) / stderr).max() > 30
