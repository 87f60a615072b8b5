"""Mitsuba with the exported BSDF: its values, its samples, a furnace."""

import numpy as np
import pytest
from chi_square import chi_square_p

import msbsdf_cli as ms
from msbsdf_cli.renderers.files import write_table
from msbsdf_cli.renderers.mitsuba import register
from msbsdf_cli.renderers.tables import albedos, make_table
from surfaces.materials import Conductor, Diffuse

mi = pytest.importorskip("mitsuba")

GOLD = Conductor.named("gold", rgb=True)
CASES = {
    "mirror": (ms.Ggx(0.5, 0.5), Conductor()),
    "gold": (ms.Beckmann(0.3, 0.3), GOLD),
    "diffuse": (ms.Ggx(0.4, 0.4), Diffuse()),
}


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """The tables and the files that they are in."""
    made = {}
    for name, (slopes, material) in CASES.items():
        table = make_table(slopes, material, 2, True)
        path = tmp_path_factory.mktemp("tables") / f"{name}.npz"
        mean = albedos(slopes)[1]
        write_table(path, table, float(np.interp(slopes.alpha_x, np.linspace(0, 1, 32), mean)), 0.0)
        made[name] = table, str(path)
    return made


@pytest.fixture(params=["scalar_rgb", "llvm_ad_rgb"])
def variant(request):
    try:
        mi.set_variant(request.param)
    except ImportError as missing:
        # LLVM is a library of the system.
        pytest.skip(str(missing))
    register()
    return request.param


def vector(w):
    return mi.Vector3f(*map(float, w))


def interaction(wi):
    si = mi.SurfaceInteraction3f()
    si.wi = vector(wi)
    return si


@pytest.mark.parametrize("name", CASES)
def test_values_are_ours(variant, tables, name):
    table, path = tables[name]
    bsdf = mi.load_dict({"type": "msbsdf", "filename": path})
    rng = np.random.default_rng(1)
    for _ in range(20):
        cos = rng.uniform(np.cos(1.4), 1, 2)
        phi = rng.uniform(0, 2 * np.pi, 2)
        sin = np.sqrt(1 - cos**2)
        wi, wo = np.array([sin * np.cos(phi), sin * np.sin(phi), cos]).T
        found = bsdf.eval(mi.BSDFContext(), interaction(wi), vector(wo))
        mine = table.evaluate(wi, wo[:, None])[:, 0]
        np.testing.assert_allclose(np.ravel(found), np.broadcast_to(mine, 3), rtol=2e-3, atol=1e-5)


def test_nothing_comes_from_below(variant, tables):
    bsdf = mi.load_dict({"type": "msbsdf", "filename": tables["mirror"][1]})
    si, up, down = interaction([0, 0, 1]), mi.Vector3f(0, 0.6, 0.8), mi.Vector3f(0, 0.6, -0.8)
    ctx = mi.BSDFContext()
    assert np.ravel(bsdf.eval(ctx, si, up)).min() > 0
    assert np.ravel(bsdf.eval(ctx, si, down)).max() == 0
    assert np.ravel(bsdf.pdf(ctx, si, down)).max() == 0


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("theta", [0.3, 1.2])
def test_samples_follow_the_density_and_carry_the_albedo(tables, name, theta):
    """In 8 x 12 bins of even solid angle; the density's integrals by 6 x 6 midpoints of each."""
    mi.set_variant("scalar_rgb")
    register()
    table, path = tables[name]
    bsdf, ctx = mi.load_dict({"type": "msbsdf", "filename": path}), mi.BSDFContext()
    si = interaction([np.sin(theta), 0, np.cos(theta)])
    rng, n = np.random.default_rng(2), 20_000
    found, weights = [], []
    for u in rng.random((n, 3)).tolist():
        bs, weight = bsdf.sample(ctx, si, u[0], mi.Point2f(u[1], u[2]))
        found.append(list(bs.wo))
        weights.append(np.ravel(weight)[0] if bs.pdf > 0 else 0.0)
        if bs.pdf > 0 and len(found) % 100 == 0:
            assert bsdf.pdf(ctx, si, bs.wo) == pytest.approx(bs.pdf, rel=1e-4)
    w, weights = np.array(found).T, np.array(weights)
    above = w[2] > 0
    cos = np.minimum((w[2, above] * 8).astype(int), 7)
    phi = np.floor((np.arctan2(w[1], w[0])[above] / (2 * np.pi) + 0.5) * 12).astype(int) % 12
    counts = np.bincount(cos * 12 + phi, minlength=96)
    z, azimuth = (np.arange(48) + 0.5) / 48, 2 * np.pi * ((np.arange(72) + 0.5) / 72 - 0.5)
    density = [
        [
            bsdf.pdf(ctx, si, vector([np.sqrt(1 - c * c) * f(p) for f in (np.cos, np.sin)] + [c]))
            for p in azimuth
        ]
        for c in z
    ]
    share = np.array(density).reshape(8, 6, 12, 6).mean(axis=(1, 3)).ravel() * 2 * np.pi / 96
    expected = n * np.append(share, 1 - share.sum())
    assert chi_square_p(np.append(counts, n - counts.sum()), expected) > 1e-4
    energy = ms.walk(ms.Smith(table.slopes, table.material), ms.direction(theta), 400_000).energy
    stderr = weights.std() / np.sqrt(n)
    assert abs(weights.mean() - energy[:, 0].sum()) < 4 * stderr + 0.01


@pytest.mark.parametrize(("name", "albedo"), [("mirror", 1.0), ("diffuse", 1.0)])
def test_a_white_furnace_stays_white(tables, name, albedo):
    """The energy of a sphere's pixels under constant light, to the error of its table."""
    mi.set_variant("scalar_rgb")
    register()
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "light": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
            "ball": {"type": "sphere", "bsdf": {"type": "msbsdf", "filename": tables[name][1]}},
            "camera": {
                "type": "perspective",
                "fov": 10,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 8], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}},
            },
        }
    )
    image = np.array(mi.render(scene, spp=64))[..., :3]
    # 64 pixels of 64 samples each, whose weights scatter by less than 1.
    assert image.mean() == pytest.approx(albedo, abs=0.01)
