"""Mitsuba with the exported BSDF: its values, its samples, a furnace."""

import numpy as np
import pytest
from chi_square import chi_square_p

import msbsdf_cli as ms
from msbsdf_cli.renderers.files import write_table
from msbsdf_cli.renderers.mitsuba import register
from msbsdf_cli.renderers.nodes import Nodes
from msbsdf_cli.renderers.tabulate import make_table
from surfaces.materials import Conductor, Dielectric, Diffuse

mi = pytest.importorskip("mitsuba")
dr = pytest.importorskip("drjit")

LEAST_LLVM = 17

GOLD = Conductor.named("gold", rgb=True)
CASES = {
    "mirror": (ms.Ggx(0.5, 0.5), Conductor(), None),
    "gold": (ms.Beckmann(0.3, 0.3), GOLD, None),
    "diffuse": (ms.Ggx(0.4, 0.4), Diffuse(), Nodes(16, 16)),
    "two": (ms.Beckmann(0.3, 0.6), GOLD, Nodes(6, 16, 3)),
    "glass": (ms.Ggx(0.4, 0.4), Dielectric(1.5), Nodes.of_glass(1.5, 5, 5, 8)),
}
OPAQUE = [name for name in CASES if name != "glass"]


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """The tables and the files that they are in: coarse ones, where that is enough."""
    made, folder = {}, tmp_path_factory.mktemp("tables")
    for name, (slopes, material, nodes) in CASES.items():
        table = make_table(slopes, material, 2, True, nodes)
        path = folder / f"{name}.npz"
        write_table(path, table, np.zeros(1), np.zeros(1))
        made[name] = table, str(path)
    return made


def variant(name):
    try:
        mi.set_variant(name)
    except ImportError as missing:
        # LLVM is a library of the system.
        pytest.skip(str(missing))
    if "llvm" in name and dr.detail.llvm_version()[0] < LEAST_LLVM:
        pytest.skip("this LLVM cannot translate minimum and maximum, and would end the process")
    register()


def vector(w):
    return mi.Vector3f(*map(float, w))


def interaction(wi):
    si = mi.SurfaceInteraction3f()
    si.wi = vector(wi)
    return si


def lanes(w):
    """Mitsuba's vectors of directions (3, n), and an interaction there."""
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*(mi.Float(np.ascontiguousarray(x, np.float32)) for x in w))
    return si


def importance():
    """What carries energy, as values here do, and not radiance."""
    return mi.BSDFContext(mi.TransportMode.Importance)


def pairs(n, both_sides, steepest=1.4):
    """Incident directions, and three outgoing ones for each."""
    rng = np.random.default_rng(1)
    for _ in range(n):
        cos = rng.uniform(np.cos(steepest), 1, 4)
        if both_sides:
            cos *= rng.choice([-1, 1], 4)
        phi, sin = rng.uniform(0, 2 * np.pi, 4), np.sqrt(1 - cos**2)
        w = np.array([sin * np.cos(phi), sin * np.sin(phi), cos])
        yield w[:, 0], w[:, 1:]


@pytest.mark.parametrize("of", ["scalar_rgb", "scalar_spectral", "llvm_ad_rgb"])
@pytest.mark.parametrize("name", CASES)
def test_values_are_those_of_the_table(tables, of, name):
    """To single precision, in which coefficients of either sign are added up."""
    variant(of)
    table, path = tables[name]
    if "spectral" in of and table.material.channels == 3:
        with pytest.raises(Exception, match="red, green and blue"):
            mi.load_dict({"type": "msbsdf", "filename": path})
        return
    bsdf = mi.load_dict({"type": "msbsdf", "filename": path})
    w = np.concatenate([wo for _, wo in pairs(12, name == "glass")], axis=1)
    d = np.concatenate([np.tile(wi[:, None], 3) for wi, _ in pairs(12, name == "glass")], axis=1)
    mine = np.concatenate([table.evaluate(*pair) for pair in pairs(12, name == "glass")], axis=1)
    if "llvm" in of:
        found = np.array(bsdf.eval(importance(), lanes(d), lanes(w).wi))
    else:
        each = zip(d.T, w.T, strict=True)
        values = [bsdf.eval(importance(), interaction(wi), vector(wo)) for wi, wo in each]
        found = np.array([np.ravel(value) for value in values]).T
    wanted = np.broadcast_to(mine, found.shape)
    np.testing.assert_allclose(found, wanted, rtol=1e-3, atol=1e-5)


def test_radiance_is_compressed_where_light_enters_glass(tables):
    """As `roughdielectric` has it, whose first order this is."""
    variant("scalar_rgb")
    bsdf = mi.load_dict({"type": "msbsdf", "filename": tables["glass"][1]})
    theirs = {"type": "roughdielectric", "distribution": "ggx", "alpha": 0.4, "int_ior": 1.5}
    single = mi.load_dict(theirs | {"ext_ior": 1.0})
    si, wo = interaction([0.6, 0, 0.8]), vector([-0.4, 0.0, -np.sqrt(0.84)])
    for plugin in (bsdf, single):
        radiance = np.ravel(plugin.eval(mi.BSDFContext(), si, wo))
        energy = np.ravel(plugin.eval(importance(), si, wo))
        np.testing.assert_allclose(radiance, energy / 1.5**2, rtol=1e-5)
    # Their masking is uncorrelated: a tenth less than ours; later orders add to ours.
    ratio = np.ravel(bsdf.eval(importance(), si, wo))[0] / energy[0]
    assert 0.85 < ratio < 1.3


@pytest.mark.parametrize("name", OPAQUE)
def test_nothing_comes_from_below(tables, name):
    variant("scalar_rgb")
    bsdf = mi.load_dict({"type": "msbsdf", "filename": tables[name][1]})
    si, up, down = interaction([0, 0, 1]), mi.Vector3f(0, 0.6, 0.8), mi.Vector3f(0, 0.6, -0.8)
    ctx = mi.BSDFContext()
    assert np.ravel(bsdf.eval(ctx, si, up)).min() > 0
    assert np.ravel(bsdf.eval(ctx, si, down)).max() == 0
    assert np.ravel(bsdf.pdf(ctx, si, down)).max() == 0


def drawn(bsdf, wi, n):
    """Directions, densities and weights of n samples, one after the other or all at once."""
    u, ctx = np.random.default_rng(2).random((n, 3)).astype(np.float32), importance()
    if mi.variant().startswith("scalar"):
        si = interaction(wi)
        found = [bsdf.sample(ctx, si, x, mi.Point2f(y, z)) for x, y, z in u.tolist()]
        w, pdf = np.array([bs.wo for bs, _ in found]).T, np.array([bs.pdf for bs, _ in found])
        return w.reshape(3, n), pdf, np.array([np.ravel(weight) for _, weight in found]).T
    x, y, z = (mi.Float(np.ascontiguousarray(column)) for column in u.T)
    bs, weight = bsdf.sample(ctx, lanes(np.tile(wi[:, None], n)), x, mi.Point2f(y, z))
    return np.array(bs.wo), np.array(bs.pdf), np.array(weight)


def densities(bsdf, wi, w):
    if mi.variant().startswith("scalar"):
        si = interaction(wi)
        return np.array([bsdf.pdf(importance(), si, mi.Vector3f(*x)) for x in w.T.tolist()])
    si = lanes(np.tile(wi[:, None], w.shape[1]))
    return np.array(bsdf.pdf(importance(), si, lanes(w).wi))


@pytest.mark.parametrize("name", CASES)
def test_samples_follow_the_density_for_mitsuba(tables, name, tmp_path, monkeypatch):
    variant("llvm_ad_rgb")
    # Where a test fails, Mitsuba leaves a file in the working directory.
    monkeypatch.chdir(tmp_path)
    from mitsuba.chi2 import BSDFAdapter, ChiSquareTest, SphericalDomain

    file = f'<string name="filename" value="{tables[name][1]}"/>'
    sample, density = BSDFAdapter("msbsdf", file, wi=[0.48, 0.36, 0.8])
    test = ChiSquareTest(SphericalDomain(), sample, density, 3, 200_000, ires=16)
    # A false alarm in a thousand runs of all the cases.
    assert test.run(significance_level=1e-3, test_count=len(CASES))


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("theta", [0.3, 1.2])
@pytest.mark.parametrize(
    ("of", "n", "rows"), [("scalar_rgb", 10_000, 8), ("llvm_ad_rgb", 10**5, 16)]
)
def test_samples_follow_the_density_and_carry_the_energy(tables, name, theta, of, n, rows):
    """In bins of even solid angle of the whole sphere, half as many again in azimuth as rows; the
    density's integrals by 40 x 10 midpoints of each, as lobes are narrow in the cosine."""
    variant(of)
    table, path = tables[name]
    bsdf, columns = mi.load_dict({"type": "msbsdf", "filename": path}), 3 * rows // 2
    high, wide = 40, 10
    z = 2 * (np.arange(high * rows) + 0.5) / (high * rows) - 1
    phi = 2 * np.pi * (np.arange(wide * columns) + 0.5) / (wide * columns)
    sin = np.sqrt(1 - z * z)
    across = [np.outer(sin, f(phi)).ravel() for f in (np.cos, np.sin)]
    grid = np.array([*across, np.repeat(z, phi.size)])
    for side in (1, -1) if name == "glass" else (1,):
        wi = ms.direction(theta, 0.5) * [1, 1, side]
        w, pdf, weight = drawn(bsdf, wi, n)
        kept = pdf > 0
        row = np.minimum((w[2, kept] + 1) * rows / 2, rows - 1).astype(int)
        turn = np.mod(np.arctan2(w[1], w[0])[kept] / (2 * np.pi), 1)
        column = np.minimum((turn * columns).astype(int), columns - 1)
        counts = np.bincount(row * columns + column, minlength=rows * columns)
        density = densities(bsdf, wi, grid).reshape(rows, high, columns, wide)
        share = density.mean(axis=(1, 3)).ravel() * 4 * np.pi / (rows * columns)
        expected = n * np.append(share, 1 - share.sum())
        assert chi_square_p(np.append(counts, n - counts.sum()), expected) > 1e-4
        again = densities(bsdf, wi, w[:, kept][:, :1000])
        np.testing.assert_allclose(again, pdf[kept][:1000], rtol=1e-3, atol=1e-6)
        model = ms.Smith(table.slopes, table.material)
        # Glass absorbs nothing, from whichever side.
        energy = 1.0 if name == "glass" else ms.walk(model, wi, 400_000).energy.sum()
        # A walk tells the energy of the first channel. Coarse tables are off by some .005.
        weight = np.where(kept, weight[0], 0)
        assert abs(weight.mean() - energy) < 4 * weight.std() / np.sqrt(n) + 0.01


def furnace(path, depth):
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth, "rr_depth": 1000},
            "light": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
            "ball": {"type": "sphere", "bsdf": {"type": "msbsdf", "filename": path}},
            "camera": {
                "type": "perspective",
                "fov": 10,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 8], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}},
            },
        }
    )


@pytest.mark.parametrize("name", ["mirror", "diffuse"])
def test_a_white_furnace_stays_white(tables, name):
    """The energy of a sphere's pixels under constant light, to the error of its table."""
    variant("scalar_rgb")
    image = np.array(mi.render(furnace(tables[name][1], 2), spp=64))[..., :3]
    # 64 pixels of 64 samples each, whose weights scatter by less than 1.
    assert image.mean() == pytest.approx(1, abs=0.01)


def test_a_ball_of_glass_disappears(tables):
    """A closed body in constant light, all of which comes out again."""
    variant("scalar_rgb")
    image = np.array(mi.render(furnace(tables["glass"][1], 100), spp=24))[..., :3]
    pixels = image.mean(axis=2).ravel()
    # Tables of so few nodes are off by some .005, and light crosses several surfaces.
    assert abs(pixels.mean() - 1) < 4 * pixels.std() / 8 + 0.02
