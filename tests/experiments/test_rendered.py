"""Scenes of `render` that are recommended for, and the error of their pictures."""

import numpy as np
import pytest

from msbsdf_cli.experiments.recommend.rendered import _error, scene_of
from msbsdf_cli.experiments.render.picture import Picture
from msbsdf_cli.experiments.render.scenes import NAMES

SHAPE = 3, 32, 48


def noisy(method, radiance, noise, rng):
    mean = np.broadcast_to(radiance, SHAPE) + noise * rng.standard_normal((1, *SHAPE[1:]))
    return Picture(method, mean, np.full(SHAPE, noise), 4, 1.0, 1, 0)


def test_noise_is_no_error(rng):
    whole, other = (noisy(name, 1.0, 0.3, rng) for name in ("walk", "single"))
    found = _error("plate", whole, other)
    # Of 1536 pixels the mean square is known to .18 sqrt(2 / 1536) = .0065, the root to .08.
    assert found.error < 0.12
    assert 0.05 < found.error_bound < 0.2


def test_an_error_is_found_through_noise(rng):
    pattern = np.where(np.arange(48) % 2, 1.5, 0.5)
    whole, other = noisy("walk", pattern, 0.1, rng), noisy("single", 0.8 * pattern, 0.1, rng)
    found = _error("plate", whole, other)
    assert found.error == pytest.approx(0.2, abs=0.01)
    assert 0.2 < found.error_bound < 0.23


@pytest.mark.parametrize("name", NAMES)
def test_scenes_have_one_surface(name):
    (surface,) = scene_of(name).surfaces
    assert surface.name == name
    assert (len(surface.slopes) > 1) == (name == "plate")
