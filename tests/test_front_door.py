"""`import msbsdf_cli as ms`, as a notebook has it."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import msbsdf_cli as ms
from msbsdf_cli.smith.albedo import first_order_albedo

GOLD = ms.Conductor.named("gold", rgb=True)
MIRROR = ms.Smith(ms.Ggx(0.5, 0.2), ms.Conductor())
WI = ms.direction(theta=1.0, phi=0.3)


def test_importing_it_loads_nothing_heavy():
    code = (
        "import sys, msbsdf_cli as ms; ms.__all__; dir(ms)\n"
        "sys.exit(', '.join({'numpy', 'scipy', 'matplotlib', 'trimesh'} & set(sys.modules)) or 0)"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_every_public_name_is_there_and_documented():
    for name in ms.__all__:
        assert getattr(ms, name).__doc__, name
    with pytest.raises(AttributeError, match="wood"):
        _ = ms.wood


def test_it_is_the_command_line_too():
    result = subprocess.run(
        [sys.executable, "-m", "msbsdf_cli", "--version"], capture_output=True, text=True
    )
    assert result.stdout.startswith("msbsdf")


def test_a_method_gives_values_and_samples():
    wo = ms.hemisphere(800)
    mirror = ms.Smith(ms.Ggx(0.5, 0.5), ms.Conductor())
    solve, walk = (ms.method(name, mirror, orders=3) for name in ("solve", "walk"))
    f = solve.evaluate(WI, wo)
    assert f.value.shape == f.stderr.shape == (1, 4, 800)
    # All of the light comes back; of 800 directions the lobe of roughness .5 asks some percent.
    assert f.value.sum() * 2 * np.pi / 800 == pytest.approx(1, abs=0.02)
    g = walk.evaluate(WI, wo[:, 777], samples=20_000, seed=1)
    assert np.abs(g.value - f.value[..., 777:778]).max() < 5 * g.stderr.max()
    again = walk.evaluate(WI, wo[:, 777], samples=20_000, seed=1)
    assert np.array_equal(g.value, again.value)
    w, weight = walk.sample(WI, 1000, seed=2)
    assert w.shape == (3, 1000)
    assert weight.shape == (1, 1000)
    assert np.all(walk.pdf(WI, w) > 0)


def test_materials_in_one_colour_and_in_three():
    assert GOLD.channels == 3
    assert ms.Conductor.named("gold").eta_k == GOLD.eta_k[1:2]
    assert ms.Diffuse(0.8) == ms.Diffuse((0.8,))
    f = ms.method("single", ms.Smith(ms.Beckmann(0.3, 0.3), GOLD)).evaluate(WI, ms.hemisphere(9))
    red, green, blue = f.value[:, 0].sum(axis=1)
    assert red > green > blue


def test_methods_are_listed_and_refuse_what_they_do_not_hold_for():
    assert "solve" in ms.methods()
    glass = ms.Smith(ms.Beckmann(0.5, 0.5), ms.Dielectric(1.5))
    with pytest.raises(ms.UnsupportedError, match="exact"):
        ms.method("exact", glass)
    with pytest.raises(ValueError, match="'magic' is not a method: one of single, walk"):
        ms.method("magic", glass)


def test_a_walk_is_the_same_on_any_executor():
    here = ms.walk(MIRROR, WI, samples=600_000, seed=3)
    with ThreadPoolExecutor(2) as executor:
        there = ms.walk(MIRROR, WI, samples=600_000, seed=3, executor=executor)
    assert np.array_equal(here.energy, there.energy)
    first = float(first_order_albedo(MIRROR.slopes, MIRROR.material, WI[:, None])[0])
    assert abs(here.energy[0, 0] - first) < 4 * here.energy_stderr[0, 0]
    assert here.energy.sum() + here.absorbed + here.unresolved == pytest.approx(1)


def test_two_halves_merge_to_a_whole_with_the_error_of_the_whole():
    halves = [ms.walk(MIRROR, WI, samples=100_000, seed=seed) for seed in (1, 2)]
    whole = ms.merge(halves)
    assert whole.samples == 200_000
    np.testing.assert_allclose(whole.energy, (halves[0].energy + halves[1].energy) / 2)
    expected = np.sqrt(whole.energy * (1 - whole.energy) / (200_000 - 1) + 1 / 200_000**2)
    np.testing.assert_allclose(whole.energy_stderr, expected, rtol=1e-9)
    with pytest.raises(ValueError, match="the seed 1 is in two results"):
        ms.merge([halves[0], halves[0]])
    other = ms.walk(MIRROR, ms.direction(0.5), samples=1000, seed=9)
    with pytest.raises(ValueError, match="differ in wi"):
        ms.merge([halves[0], other])


@pytest.fixture(scope="module")
def traced():
    field = ms.HeightField.random(alpha=0.5, seed=4, cells=8)
    return field, ms.simulate(field, ms.Conductor(), WI, rays=64_000, seed=0)


def test_a_field_is_traced_and_compared(traced, tmp_path):
    field, truth = traced
    assert truth.energy.sum() + truth.unresolved == pytest.approx(1)
    more = ms.merge([truth, ms.simulate(field, ms.Conductor(), WI, rays=64_000, seed=1)])
    assert more.samples == 128_000
    # Another run of rays on the same pieces of the surface scatters no less between the pieces.
    assert more.energy_stderr[0, 0] == pytest.approx(truth.energy_stderr[0, 0], rel=0.5)
    more.save(tmp_path / "truth.npz")
    loaded = ms.load(tmp_path / "truth.npz")
    assert np.array_equal(loaded.energy_stderr, more.energy_stderr)
    assert loaded.settings == more.settings
    columns = loaded.to_columns()
    assert columns["order"] == [o for o in ("1", "2", "3", "4", ">4") for _ in range(2)]
    assert columns["energy"][2] == loaded.energy[1, 0]
    model = ms.Smith(ms.Beckmann(0.5, 0.5), ms.Conductor())
    smith = ms.walk(model, WI, samples=200_000)
    rows = ms.compare(loaded, smith)
    assert set(rows["quantity"]) == {"energy", "total_variation"}
    late = (rows["quantity"] == "energy") & (rows["order"] == "3")
    # Valleys carry more light to a third facet than the model knows of.
    assert rows["own"][late] < 0
    with pytest.raises(ValueError, match="what is simulated comes first"):
        ms.compare(smith, loaded)
    with pytest.raises(ValueError, match="of `simulate` and of `walk`"):
        ms.merge([loaded, smith])
    with pytest.raises(ValueError, match="different scenes: material"):
        ms.compare(loaded, ms.walk(ms.Smith(model.slopes, ms.Diffuse()), WI, samples=100))


def test_a_flat_field_in_any_unit_is_a_mirror():
    field = ms.HeightField(np.zeros((16, 16)), (2e-6, 2e-6))
    flat = ms.simulate(field, ms.Conductor(), WI, rays=160)
    assert flat.energy[0, 0] == 1


def test_units_of_length_do_not_matter(traced):
    field, truth = traced
    scaled = ms.HeightField(field.heights * 1e-6, tuple(1e-6 * s for s in field.step), True)
    same = ms.simulate(scaled, ms.Conductor(), WI, rays=64_000, seed=0)
    assert np.abs(same.energy - truth.energy).max() < 1e-3


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: ms.walk(MIRROR, [0, 0, 2.0]), "length 2"),
        (lambda: ms.walk(MIRROR, ms.direction(2.0)), "z above 0"),
        (lambda: ms.walk(MIRROR, [0, 0, np.nan]), "not finite"),
        (lambda: ms.walk(MIRROR, np.eye(3)), "shape"),
        (lambda: ms.walk(MIRROR, WI, samples=0), "samples is 0"),
        (lambda: ms.walk(MIRROR, WI, samples=1.5), "whole number"),
        (lambda: ms.walk(MIRROR, WI, seed=-1), "seed is -1"),
        (lambda: ms.method("walk", MIRROR).evaluate(-WI, WI), "z above 0"),
        (lambda: ms.method("walk", MIRROR).evaluate(WI, 2 * WI), "unit vectors"),
        (lambda: ms.method("walk", MIRROR, orders=0), "orders is 0"),
        (lambda: ms.Beckmann(-1, 1), "above 0"),
        (lambda: ms.Diffuse(1.5), "albedo"),
        (lambda: ms.Dielectric(0), "ior is 0"),
        (lambda: ms.Conductor(((1.0, np.inf),)), "index"),
        (lambda: ms.Conductor.named("tin"), "'tin' is not a metal known here: one of gold"),
        (lambda: ms.StudentT(1, 1, 1.0), "gamma"),
        (lambda: ms.HeightField(np.zeros((16, 3)), (1, 1)), "at least 4 x 4"),
        (lambda: ms.HeightField(np.full((8, 8), np.nan), (1, 1)), "not finite"),
        (lambda: ms.HeightField(np.zeros((8, 8)), (0, 1)), "step"),
        (lambda: ms.HeightField.random(alpha=0), "alpha"),
        (lambda: ms.hemisphere(0), "n is 0"),
        (lambda: ms.merge([]), "no results"),
        (lambda: ms.merge([None]), "a result of simulate or walk is wanted, and not NoneType"),
        (lambda: ms.merge(ms.walk(MIRROR, WI, samples=2)), "a list of results"),
        (lambda: ms.walk(MIRROR, WI, samples=2, orders=50), "from 1 to 10"),
        (lambda: ms.walk(MIRROR, WI, samples=2, seed="a"), "seed is 'a'"),
        (lambda: ms.walk(ms.Ggx(1, 1), WI, samples=2), "a model, such as"),
        (lambda: ms.simulate(np.zeros((8, 8)), ms.Conductor(), WI), "a HeightField is wanted"),
        (lambda: ms.Smith(0.5, ms.Conductor()), "a distribution of slopes"),
        (lambda: ms.Smith(ms.Ggx(1, 1), None), "a material"),
        (lambda: ms.Beckmann("a", 1), "alpha_x is a"),
        (lambda: ms.direction(np.nan), "the angles are nan and 0.0"),
    ],
)
def test_what_could_only_give_a_wrong_number_is_refused(call, said):
    with pytest.raises(ValueError, match=said):
        call()


@pytest.mark.parametrize("content", [b"", b"not a result", b"PK\x03\x04" + 100 * b"\0"])
def test_files_that_are_no_results_are_refused(content, tmp_path):
    path = tmp_path / "r.npz"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"r\.npz does not hold a result"):
        ms.load(path)
