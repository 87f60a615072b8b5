"""`energy-compensated` returns all energy, down to the last angle above the horizon."""

import numpy as np
import pytest

from msbsdf_cli.experiments import furnace
from msbsdf_cli.experiments.furnace import FurnaceJob, run_furnace
from msbsdf_cli.methods.energy_compensated import EnergyCompensated
from msbsdf_cli.methods.single import Single
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from surfaces.materials import Conductor, Dielectric

LAST = float(np.nextafter(np.pi / 2, 0))
THETA = (0.0, 1.2, 1.57, LAST)


@pytest.mark.parametrize("alpha", [(0.1, 0.1), (0.3, 0.3), (0.5, 0.5), (1, 1), (1, 0.1)])
@pytest.mark.parametrize("slopes", [Beckmann, Ggx])
@pytest.mark.parametrize("material", [Dielectric, Conductor])
def test_the_furnace_sees_all_energy(material, slopes, alpha, monkeypatch):
    monkeypatch.setattr(furnace, "QUARTER", 1)
    scene = Scene(material(), slopes(*alpha), THETA, 0.3)
    result = run_furnace(FurnaceJob(scene, "energy-compensated", 4096, 0, None))
    # Of two roughnesses at two azimuths, along one of them too.
    assert result.phi == ((0.3,) if alpha[0] == alpha[1] else (0.3, 0.0))
    albedo, stderr = result.value[:, :, 0, -1], result.stderr[:, :, 0, -1]
    assert (stderr < 0.02).all()
    assert (np.abs(albedo - 1) < 5 * stderr).all(), (albedo, stderr)


@pytest.mark.parametrize("slopes", [Beckmann(0.5, 0.5), Ggx(0.3, 0.3), Ggx(1, 0.1)], ids=str)
@pytest.mark.parametrize("material", [Conductor(), Dielectric(1.5)], ids=lambda m: m.name)
def test_the_table_knows_its_error(slopes, material, rng):
    """At directions of its own choosing, the table is off by no more than a few times that."""
    E = EnergyCompensated(slopes, material, 1).E
    w = np.stack([direction(t, p) for t, p in rng.uniform(0, [[1.57, np.pi]], (32, 2))], axis=1)
    off = np.abs(E(w) - first_order_albedo(slopes, material, w)).max()
    assert off <= 4 * E.error < 0.01
    if slopes.alpha_x == slopes.alpha_y:
        assert E.error < 1e-4


@pytest.mark.parametrize("slopes", [Beckmann(0.5, 0.5), Ggx(0.5, 0.5)], ids=str)
def test_first_order_albedo_at_grazing_is_that_of_samples(slopes, rng):
    for material in (Conductor(), Dielectric(1.5)):
        for theta in (1.5, 1.57, LAST):
            wi = direction(theta, 0)
            weight = Single(slopes, material, 1).sample(wi, 200_000, rng)[1][0]
            error = weight.mean() - first_order_albedo(slopes, material, wi[:, None])[0]
            assert abs(error) < 4 * weight.std() / np.sqrt(weight.size) + 1e-5


@pytest.mark.parametrize("material", [Conductor(), Dielectric(1.5)])
def test_smooth_surfaces_lose_no_negative_energy(material):
    method = EnergyCompensated(Beckmann(0.02, 0.02), material, 1)
    theta = np.linspace(0, np.pi / 2, 200, endpoint=False)
    wo = np.stack([np.sin(theta), 0 * theta, np.cos(theta)])
    for angle in (0.0, 0.8, 1.5):
        wi = np.array([np.sin(angle), 0, np.cos(angle)])
        assert (method.evaluate(wi, wo, 0, np.random.default_rng(0)).value >= 0).all()
