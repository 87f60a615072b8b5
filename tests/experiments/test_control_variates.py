"""Control variates of a surface: their expected values, and what they are worth."""

import numpy as np
import pytest

from msbsdf_cli.experiments.control_variates import NUMBER, controls, expected
from msbsdf_cli.experiments.random_surfaces import Resolution, realisation
from msbsdf_cli.experiments.realisations import simulate
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.statistics.tally import Tally
from surfaces.materials import Conductor
from surfaces.views import Views


def incident(theta, phi=0.3):
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


@pytest.mark.parametrize("alpha", [(1.0, 1.0), (0.5, 0.5), (1.0, 0.1)])
@pytest.mark.parametrize("theta", [0.0, 1.0, 1.5])
def test_expected_values_are_those_of_gaussian_slopes(rng, alpha, theta):
    """By sampling, in plain words: the mirror's direction is 2 (wi . m) m - wi."""
    wi, n = incident(theta), 400_000
    x, y = (a / np.sqrt(2) * rng.standard_normal(n) for a in alpha)
    m = np.array([-x, -y, np.ones(n)]) / np.sqrt(1 + x * x + y * y)
    seen = np.maximum(wi @ m, 0) / m[2]
    up = 2 * (wi @ m) * m[2] - wi[2]
    parts = np.array([seen, seen * (up > 0), seen * np.maximum(up, 0)])
    stderr = parts.std(axis=1) / np.sqrt(n)
    # The quadrature itself is right to some 1e-6 of the largest value.
    assert np.all(np.abs(expected(Beckmann(*alpha), wi) - parts.mean(axis=1)) < 4 * stderr + 1e-5)


def test_controls_of_surfaces_are_near_their_expected_values():
    """Over 64 surfaces of 16 correlation lengths; the slopes of a sum of waves with fixed
    amplitudes are not quite Gaussian, by some 1e-3 at most."""
    wi, resolution = incident(1.0), Resolution(8, 16, 64)
    found = []
    for number in range(64):
        surface = realisation(resolution, number, 5)
        found.append(controls(surface, Views(surface.stretch(0.5, 0.5, 0.3)), wi))
    offset = np.mean(found, axis=0) - expected(Beckmann(0.5, 0.5), wi)
    stderr = np.std(found, axis=0, ddof=1) / 8
    assert np.all(np.abs(offset) < 4 * stderr + 1e-3)
    assert np.all(stderr < 1e-3)


def test_simulations_merge_as_if_they_were_one():
    scene = Scene(Conductor(), Beckmann(1, 1), (0.5,), 0.3)
    paths = FreePaths((), (), np.array([0.0, 1.0]))
    one, other = (
        simulate(scene, 20_000, Resolution(8, 6, 8), paths, seed, 1, 1000, True).tallies[0]
        for seed in (1, 2)
    )
    alone = one.estimate("energy").value.copy()
    mean = (Tally.figures(one)[0] + Tally.figures(other)[0]) / 2
    one.merge(other)
    assert (one.units, one.more.units, one.controls[0, 0]) == (16, 16, 16)
    np.testing.assert_allclose(Tally.figures(one)[0], mean, atol=1e-12)
    # What was estimated before the merge is estimated anew.
    assert np.abs(one.estimate("energy").value - alone).max() > 1e-6
    with pytest.raises(AssertionError, match="add_surface"):
        one.merge(Tally(4))


def test_controls_explain_most_of_what_surfaces_differ_in():
    """Vertical light, which sees one surface in all views."""
    scene = Scene(Conductor(), Beckmann(1, 1), (0.0,), 0.3)
    paths = FreePaths((), (), np.array([0.0, 1.0]))
    run = simulate(scene, 400_000, Resolution(8, 8, 64), paths, 1, 1, 1000, True)
    (tally,) = run.tallies
    assert tally.products.shape[0] == NUMBER
    alone = tally.views(Tally.figures(tally)[1])["energy"][:2, 0]
    # The noise of rays and of the extrapolation is in it as well.
    noise = tally.views(tally.figures()[1] - tally.systematic)["energy"][:2, 0]
    assert np.all(noise < 0.25 * alone)
