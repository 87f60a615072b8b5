"""The furnace's stated errors cover the truth, also where hardly any walk goes."""

import numpy as np
import pytest

from msbsdf_cli.experiments.furnace import FurnaceJob, run_furnace
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.plots.furnace import _sphere
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from surfaces.materials import Conductor

THETA = (0.0, 1.0, 1.5, 1.57)
SAMPLES = 1024


@pytest.mark.parametrize("alpha", [0.3, 0.5, 1.0])
@pytest.mark.parametrize("slopes", [Beckmann, Ggx])
@pytest.mark.parametrize("method", ["walk", "walk-low-variance", "exact"])
def test_errors_cover_what_no_walk_met(method, slopes, alpha):
    scene = Scene(Conductor(), slopes(alpha, alpha), THETA, 0)
    solve = Solve(scene.slopes, scene.material, scene.orders)
    known = np.array([solve.albedo(scene.wi(theta))[0][0] for theta in THETA])
    truth = np.concatenate([known, known.sum(axis=1, keepdims=True)], axis=1)
    result = run_furnace(FurnaceJob(scene, method, SAMPLES, 0, None))
    z = (result.value[0, :, 0] - truth) / result.stderr[0, :, 0]
    assert np.abs(z).max() < 6
    assert np.sqrt((z * z).mean()) < 1.7
    # No more is promised of any later order than one walk in all of them allows.
    assert (result.stderr[0, :, 0, 1:] >= 1 / SAMPLES).all()


def test_a_method_without_walks_misses_none():
    scene = Scene(Conductor(), Beckmann(0.5, 0.5), (1.0,), 0)
    result = run_furnace(FurnaceJob(scene, "single", SAMPLES, 0, None))
    assert (result.stderr[0, 0, 0, 1:-1] == 0).all()
    assert 0 < result.stderr[0, 0, 0, 0] < 1 / SAMPLES


def test_two_roughnesses_are_seen_from_azimuths_over_the_quarter_turn():
    """Along the rough axis single scattering from 0.8 loses a seventh of the light, across it more
    than a quarter; each azimuth is what it is alone."""
    scene = Scene(Conductor(), Beckmann(1.0, 0.1), (0.8,), 0.3)
    result = run_furnace(FurnaceJob(scene, "single", SAMPLES, 0, None))
    assert result.phi[0] == 0.3
    assert {0.0, np.pi / 2} < set(result.phi)
    albedo = dict(zip(result.phi, result.value[:, 0, 0, -1], strict=True))
    assert albedo[0.0] == pytest.approx(0.858, abs=3e-3)
    assert albedo[np.pi / 2] == pytest.approx(0.721, abs=3e-3)
    w = np.array([np.sin(0.8) * np.cos(0.3), np.sin(0.8) * np.sin(0.3), np.cos(0.8)])[:, None]
    alone = float(first_order_albedo(scene.slopes, scene.material, w)[0])
    assert albedo[0.3] == pytest.approx(alone, abs=5 * float(result.stderr[0, 0, 0, -1]))


def test_the_sphere_shows_the_azimuth_of_each_place():
    azimuths, angles = np.linspace(0, np.pi / 2, 5), np.linspace(0, 1.5, 4)
    image = _sphere([(azimuths, angles, np.outer(0.2 + 0.4 * azimuths, np.ones(4)))])
    middle = len(image) // 2
    right, top = image[middle, -len(image) // 6, 0], image[len(image) // 6, middle, 0]
    assert right**2.2 == pytest.approx(0.2, abs=0.02)
    assert top**2.2 == pytest.approx(0.2 + 0.2 * np.pi, abs=0.02)
