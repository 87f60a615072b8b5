import numpy as np
import pytest

from msbsdf_cli.experiments.random_surfaces import Resolution
from msbsdf_cli.experiments.resolution import multiple_share, plan, rays
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.materials import Conductor


@pytest.mark.parametrize("accuracy", [2e-3, 1e-3, 3e-4, 1e-4])
@pytest.mark.parametrize("alpha", [0.2, 0.5, 1.0])
def test_rays_are_less_noisy_than_the_accuracy(alpha, accuracy):
    scene = Scene(Conductor(), Beckmann(alpha, alpha), (0.0, 1.0), 0.0)
    n = rays(plan(scene, accuracy, None, None, None, None))
    # The first order's energy is the mean of zeros and ones.
    share = multiple_share(scene, Conductor())
    assert np.sqrt(share * (1 - share) / n) < 0.6 * accuracy


def test_a_surface_has_rays_for_its_cost_and_its_variance():
    each = {c: rays(Resolution(*c, 10_000)) / 10_000 for c in ((16, 16), (32, 16), (16, 32))}
    assert each[32, 16] == pytest.approx(2 * each[16, 16])
    assert each[16, 32] == pytest.approx(4 * each[16, 16])
