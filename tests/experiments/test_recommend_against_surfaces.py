"""Recommendations against light that is traced on explicit surfaces."""

import numpy as np
import pytest

import msbsdf_cli as ms
from msbsdf_cli.experiments.recommend.apart import Place, by_energy, by_lobe
from msbsdf_cli.experiments.recommend.choice import NEAREST, Wanted, recommend_by_surfaces
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.statistics.colour import albedo_difference
from msbsdf_cli.statistics.distances import Histogram
from surfaces.materials import Conductor, Diffuse

ROUGH = ms.Beckmann(1.0, 1.0)


def judged(material, slopes, rays=150_000, theta=(0.0,)):
    it = SceneSurface("it", material, (slopes,), theta)
    (found,) = recommend_by_surfaces([it], Wanted(0.01), rays, 0, 1, True)
    return found


@pytest.fixture(scope="module")
def mirror():
    return judged(Conductor(), ROUGH)


def test_the_floor_is_the_distance_that_another_simulation_finds(mirror):
    """One field and its pieces, where the recommendation has many surfaces and regression."""
    field = ms.HeightField.random(alpha=1.0, seed=5, extent=32)
    truth = ms.simulate(field, Conductor(), ms.direction(0.0), rays=150_000)
    rows = ms.compare(truth, ms.walk(ms.Smith(ROUGH, Conductor()), ms.direction(0.0), 200_000))
    (row,) = np.flatnonzero(
        (rows["quantity"] == "total_variation")
        & (rows["order"] == "all")
        & (rows["side"] == "reflected")
    )
    floor = mirror.floor
    # A bound is two standard errors away.
    off = 3 * np.hypot((floor.bound - floor.error) / 2, rows["own_stderr"][row])
    assert floor.error == pytest.approx(rows["own"][row], abs=off)
    # Known beforehand from much longer runs: 4.5 % (alpha 1, normal incidence).
    assert 0.03 < floor.error < 0.06 < 3 * floor.error
    assert off < 0.03


def test_no_number_of_bounces_beats_the_floor(mirror):
    smith = [c for c in mirror.candidates if c.bounces or c.follows_all]
    assert min(c.least for c in smith) > 0.01
    assert mirror.verdicts.count(NEAREST) == 1
    # The walk that remembers comes nearer than any other.
    assert mirror.chosen.method == "walk-memory"
    assert mirror.chosen.bound < min(c.error for c in smith)
    single = next(c for c in mirror.candidates if c.bounces == 1)
    # What single scattering lacks of a mirror is known in closed form, .54 here.
    assert single.albedo == pytest.approx(0.54, abs=0.01)
    assert single.bound > single.error > mirror.chosen.bound


def test_slopes_that_no_surface_has_are_refused():
    found = judged(Conductor(), ms.Ggx(0.5, 0.5))
    assert found.chosen is None
    assert "slopes are ggx" in found.reason


def test_channels_are_traced_one_by_one():
    """A wall of three albedos: what it returns after one bounce is in proportion to them."""
    albedos = 0.8, 0.4, 0.2
    found = judged(Diffuse(albedos), ms.Beckmann(0.5, 0.5), 8000, (0.5,))
    single = next(c for c in found.candidates if c.bounces == 1)
    walks = [
        ms.walk(ms.Smith(ms.Beckmann(0.5, 0.5), Diffuse((a,))), ms.direction(0.5), 40_000)
        for a in albedos
    ]
    energy = np.array([w.energy.sum(axis=1) for w in walks])
    expected = albedo_difference(energy[:, 0], energy.sum(axis=1))
    # The model and surfaces differ by some percent of what single scattering lacks.
    assert single.colour == pytest.approx(expected, rel=0.2)
    assert single.colour > 0.5


def test_what_is_known_of_an_error_is_part_of_its_bound():
    """Two equal histograms of noise are no further apart than their noise allows, and not nearer
    than it tells: bounds of known differences hold them."""
    rng, place = np.random.default_rng(0), Place(0.0, 0.0, (0.5, 0.5))
    truth = np.full(200, 1 / 200)
    moved = truth * (1 + 0.1 * (-1.0) ** np.arange(200))
    held = 0
    for _ in range(200):
        noise = 0.05 / 200 * rng.standard_normal((2, 200))
        lobes = [
            (
                Histogram(moved + noise[0], np.full(200, 0.05 / 200)),
                Histogram(truth + noise[1], np.full(200, 0.05 / 200)),
                None,
            )
        ]
        one = np.ones(1), np.zeros(1)
        found = by_lobe(place, one, one, lobes)
        held += 2 * found.lobe - found.bound <= 0.05 <= found.bound
    # Two standard errors: 95 % and more, by a binomial's three standard deviations.
    assert held >= 180


def test_energies_alone_bound_a_truncated_model():
    place = Place(0.0, 0.0, (0.5, 0.5))
    truth = np.array([0.9, 0.5, 0.3]), np.full(3, 1e-3)
    found = by_energy(place, (np.array([0.9, 0.45, 0.3]), np.zeros(3)), truth)
    assert found.albedo == pytest.approx(0.1)
    assert found.lobe == pytest.approx(0.05)
    assert found.bound == pytest.approx(0.1 + 1e-3 / 0.5)
    assert found.colour_bound > found.colour > 1
    assert np.isnan(by_energy(place, (truth[0][:1], truth[1][:1]), truth_of_one(truth)).colour)


def truth_of_one(truth):
    return truth[0][:1], truth[1][:1]
