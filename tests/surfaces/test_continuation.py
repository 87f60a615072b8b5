"""A patch without an edge: its light is that of the large surface which it was cut from."""

import numpy as np
import pytest

import msbsdf_cli as ms
from msbsdf_cli.experiments.own_surface import number_of_pieces, parts
from msbsdf_cli.statistics.tally import Tally
from surfaces.field import HeightField, continued
from surfaces.free_path import Level
from surfaces.heightfield import all_waves, synthesise
from surfaces.levelling import levelled
from surfaces.streams import stream
from surfaces.tracing import Tracer, morton

EXTENT, SIZE, CELLS, ALPHA = 64, 16, 6, 0.7
PIECES, RAYS = (EXTENT // SIZE) ** 2, 8192
STEP = (2 / (ALPHA * CELLS),) * 2


@pytest.fixture(scope="module")
def whole():
    return synthesise(all_waves(EXTENT, np.random.default_rng(4)), EXTENT, CELLS)


def energies(field, theta, seed, piece):
    """Of orders 1, 2, 3, with the same rays for every field."""
    tracer = Tracer(field.surface, field.stretch(0.3), ms.Conductor())
    tally, wi = Tally(3, independent=False), ms.direction(theta=theta, phi=0.3)
    for light in tracer.trace(wi, RAYS, stream(seed, "rays", seed, 0), 1000, piece):
        tally.add(light)
    return tally.views(tally.sums[0] / RAYS)["energy"][:3, 0]


@pytest.mark.parametrize("theta", [0.0, 1.4])
def test_the_bias_of_mirror_images_is_below_the_error_of_a_patch(whole, theta):
    """Patches of 16 correlation lengths, against the same places of a field of 64. What moves is
    below half of what one patch differs from another; cut off and repeated, it is several times."""
    large, n = HeightField(whole, STEP), SIZE * CELLS
    truth, mirrored, repeated = [], [], []
    for i in range(PIECES):
        x, y = np.rint(morton(np.array([i / PIECES]))[:, 0] * EXTENT * CELLS).astype(int)
        patch = levelled(whole[x : x + n, y : y + n])
        truth.append(energies(large, theta, i, (i, PIECES)))
        mirror = HeightField(patch, STEP, periodic=False)
        mirrored.append(energies(mirror, theta, i, mirror.piece(0, 1)))
        repeated.append(energies(HeightField(patch, STEP), theta, i, (0, 1)))
    spread = np.std(truth, axis=0, ddof=1)
    moved = np.subtract(mirrored, truth)
    noise = moved.std(axis=0, ddof=1) / np.sqrt(PIECES)
    assert np.all(np.abs(moved.mean(axis=0)) < 0.5 * spread + 3 * noise)
    edges = np.abs(np.subtract(repeated, truth).mean(axis=0))
    assert np.max(edges / spread) > 1


def test_pieces_are_all_of_the_surface(whole):
    """Points of departure at a height, piece by piece, weigh as much as all together."""
    surface = HeightField(whole[:192, :96], STEP, periodic=False).surface
    level, d = Level(surface, 0.4), np.array([0.5, 0.1, 0.9])
    rng = np.random.default_rng(1)
    _, measure = level.points(d, 100, rng)
    parts = [level.points(d, 100, rng, piece=(i, 16)) for i in range(16)]
    assert sum(part[1] for part in parts) == pytest.approx(measure)
    # The first quarter of the curve is the patch itself.
    for points, _ in parts[:4]:
        assert (points[0] < 193).all()
        assert (points[1] < 97).all()


@pytest.mark.parametrize("periodic", [True, False])
def test_windows_give_the_light_of_the_whole(whole, periodic, monkeypatch):
    """The same rays, on pieces of 16 correlation lengths with 8 around each. What leaves a window
    meets another place than on the whole: few at 1 radian, and like any other."""
    field = HeightField(whole[:, :318], STEP, periodic=periodic)
    wi = ms.direction(theta=1.0, phi=0.3)
    full = ms.simulate(field, ms.Conductor(), wi, rays=64_000, seed=1)
    monkeypatch.setattr("msbsdf_cli.experiments.own_surface.LARGE", 0)
    monkeypatch.setattr("msbsdf_cli.experiments.own_surface.WINDOW", 200)
    monkeypatch.setattr("msbsdf_cli.experiments.own_surface.AROUND", 6)
    assert number_of_pieces(field) == (16, True)
    part = next(parts(field, 16, True))
    assert part.field.surface.heights.shape == (192, 160)
    pieced = ms.simulate(field, ms.Conductor(), wi, rays=64_000, seed=1)
    moved = np.abs(pieced.energy - full.energy)
    assert 0 < moved.max() < 4 * np.sqrt(0.02 / 64_000)
    monkeypatch.setattr("msbsdf_cli.experiments.own_surface.AROUND", 60)
    assert number_of_pieces(field) == (16, False)


def test_seams_have_no_flat_facets(rng):
    """Mirror images share the outermost points of a patch: no slope of the whole is missing in it,
    and none is there that the patch does not have."""
    heights = rng.standard_normal((7, 9))
    whole = continued(heights)
    assert whole.shape == (12, 16)
    for axis in (0, 1):
        slopes = np.diff(np.concatenate([whole, whole.take([0], axis)], axis), axis=axis)
        assert np.abs(slopes).min() > 0
        mine = np.abs(np.diff(heights, axis=axis))
        assert set(np.round(np.abs(slopes), 12).ravel()) == set(np.round(mine, 12).ravel())
    window = HeightField(heights, (1.0, 1.0), periodic=False).window(0, 4).heights
    assert np.abs(np.diff(window, axis=0)).min() > 0
