"""`msbsdf simulate --surface FILE`, as a user has it."""

import json
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from command_line import msbsdf, refused, table

from surfaces.field import HeightField

TERRAIN = Path(matplotlib.get_data_path()) / "sample_data" / "jacksboro_fault_dem.npz"
"""A real measurement: heights of hills in Tennessee, 92.6 m by 74.2 m apart."""

FEW = ["--samples", "2e4", "--free-path-theta", "1,2", "--free-path-height", "-1,0,inf"]
HILLS = ["simulate", "--surface", TERRAIN, "--step", "92.6,74.2", *FEW]


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    out = tmp_path_factory.mktemp("reports") / "r"
    result = msbsdf(
        *HILLS, "--theta", "0.5,80deg", "--wavelength", "1000", "--out", out, pictures=True
    )
    assert result.returncode == 0, result.stderr
    return out, result


def test_a_real_measurement_from_end_to_end(report):
    out, result = report
    about = {row["quantity"]: row for row in table(out / "roughness.csv")}
    # By NumPy alone: heights less their plane, and differences of neighbours.
    with np.load(TERRAIN) as file:
        z = file["elevation"].astype(float)
    x, y = np.meshgrid(*(np.arange(n) for n in z.shape), indexing="ij")
    plane = np.column_stack([np.ones(z.size), x.ravel(), y.ravel()])
    z -= (plane @ np.linalg.lstsq(plane, z.ravel(), rcond=None)[0]).reshape(z.shape)
    assert float(about["sq"]["value"]) == pytest.approx(z.std(), rel=1e-9)
    slope = np.diff(z, axis=0) / 92.6
    assert float(about["alpha_x"]["value"]) == pytest.approx(
        np.sqrt(2 * (slope**2).mean()), rel=0.01
    )
    assert about["sq"]["unit"] == "m"
    assert {"sa", "ssk", "sku", "sdq", "direction_rad", "correlation_length"} <= set(about)
    for name in ("beckmann", "ggx", "student_t"):
        assert 0 < float(about[f"{name}_misfit"]["value"]) < 0.1
    for theta in (0.5, np.radians(80)):
        rows = [r for r in table(out / "energy.csv") if float(r["theta_i_rad"]) == theta]
        assert sum(float(row["energy"]) for row in rows) == pytest.approx(1)
    assert "63 correlation areas" in result.stderr
    assert "light is diffracted" not in result.stderr
    assert "mirror image is left" in result.stderr
    assert "beckmann_misfit" in result.stdout
    run = json.loads((out / "run.json").read_text())
    assert run["options"]["alpha"] == pytest.approx([0.285, 0.303], abs=0.001)
    assert run["pieces"] == 16
    assert (out / "surface.png").stat().st_size > 10_000


def test_the_report_is_compared_with_any_walk(report, tmp_path):
    """That it makes is on the surface's own slopes; what is handed over is called what it is."""
    out, _ = report
    few, angles = ["--samples", "1e4", "--quiet"], ["--theta", "0.5,80deg", *FEW[2:]]
    of_file = ["--surface", TERRAIN, "--step", "92.6,74.2"]
    said = {
        "own": (["--slopes", "surface", *of_file], "counted on the surface"),
        "coarse": (["--slopes", "surface", *of_file, "--filter", "400"], "or of another step"),
        "ggx": (["--slopes", "ggx", "--alpha", "0.2"], "are GGX 0.2, and not those of the surface"),
    }
    for name, (slopes, words) in said.items():
        walk, place = tmp_path / name, tmp_path / f"{name}-compared"
        assert msbsdf("walk", *slopes, *angles, *few, "--out", walk).returncode == 0
        result = msbsdf("compare", walk, out, "--quiet", "--out", place)
        assert result.returncode == 0, result.stderr
        assert words in json.loads((place / "run.json").read_text())["summary"]
    other = tmp_path / "other"
    msbsdf("walk", "--theta", "0.6", *FEW[2:], *few, "--out", other)
    assert "theta" in msbsdf("compare", other, out, "--out", tmp_path / "no").stderr
    result = msbsdf("compare", out, "--samples", "1e4", "--out", tmp_path / "c", "--quiet")
    assert result.returncode == 0, result.stderr
    record = json.loads((tmp_path / "c" / "run.json").read_text())
    assert "the slopes that were counted on the surface" in record["summary"]
    energy = [r for r in table(tmp_path / "c" / "agreement.csv") if r["quantity"] == "energy"]
    simulated = {(r["theta_i_rad"], r["order"]): r["energy"] for r in table(out / "energy.csv")}
    assert all(simulated[r["theta_i_rad"], r["order"]] == r["simulated"] for r in energy)


def test_threads_do_not_change_the_numbers(tmp_path):
    field = HeightField.random(alpha=0.7, seed=3, extent=12, cells=6)
    np.save(tmp_path / "a.npy", field.heights)
    words = ["simulate", "--surface", tmp_path / "a.npy", "--step", "2um", "--height-unit", "3um"]
    for threads in (1, 2):
        more = ["--threads", threads, "--theta", "1", "--out", tmp_path / f"r{threads}", "--quiet"]
        assert msbsdf(*words, *FEW, *more).returncode == 0
    for name in ("energy.csv", "free_path.csv", "roughness.csv"):
        first, second = ((tmp_path / r / name).read_bytes() for r in ("r1", "r2"))
        assert first == second
    about = {row["quantity"]: float(row["value"]) for row in table(tmp_path / "r1/roughness.csv")}
    assert about["sq"] == pytest.approx(3e-6 * field.heights.std(), rel=0.05)


def test_the_input_is_never_overwritten_and_a_saved_mesh_is_read_again(tmp_path):
    field = HeightField.random(alpha=0.7, seed=3, extent=8, cells=6)
    mesh = tmp_path / "a.ply"
    np.save(tmp_path / "a.npy", field.heights)
    words = ["simulate", "--surface", tmp_path / "a.npy", "--step", "1", "--periodic", *FEW]
    more = ["--theta", "1", "--quiet", "--out"]
    assert msbsdf(*words, "--save-mesh", mesh, *more, tmp_path / "r").returncode == 0
    again = HeightField.load(mesh, periodic=True)
    np.testing.assert_allclose(again.heights, field.heights - field.heights.mean(), atol=1e-6)
    before = mesh.read_bytes()
    words = ["simulate", "--surface", mesh, "--save-mesh", mesh, "--force"]
    assert "is the surface that is read" in refused(*words, "--out", tmp_path / "r2")
    words = ["simulate", "--surface", mesh, "--force"]
    assert "which is read" in refused(*words, "--out", tmp_path)
    assert mesh.read_bytes() == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--alpha", "0.5"], "--alpha beside --surface"),
        (["--cells", "8"], "--cells beside --surface"),
        (["--step", "0"], "'0' is not one or two lengths above 0"),
        (["--step", "2ft"], "'2ft' is in no unit that is known: nm, um"),
        (["--step", "1parsec"], "a number alone is in metres"),
        (["--step", "um"], "'um' is not a number"),
        (["--filter", "1e9"], "leaves nothing of its heights"),
        (["--step", "1nm"], "in different units"),
        (["--step", "1,2,3"], "one or two lengths"),
        (["--height-unit", "1,2"], "a length above 0"),
        (["--detrend", "9"], "9"),
        (["--filter", "-1um"], "a length above 0"),
        (["--wavelength", "green"], "green"),
    ],
)
def test_bad_options_are_refused(words, said, tmp_path):
    # An option that is given twice is refused for that.
    step = [] if words[0] == "--step" else ["--step", "92.6,74.2"]
    assert said in refused(*HILLS[:3], *step, *words, "--out", tmp_path / "r")


def test_what_belongs_to_a_file_is_refused_without_one(tmp_path):
    for words in (["--step", "1"], ["--periodic"], ["--detrend", "2"]):
        assert f"{words[0]} without --surface" in refused("simulate", *words)
    np.save(tmp_path / "a.npy", np.ones((8, 8)))
    path = tmp_path / "a.npy"
    assert "without roughness" in refused("simulate", "--surface", path, "--step", "1")
    # A plane, but for rounding.
    np.save(path, 1e-7 * np.add.outer(np.arange(64), np.arange(64)))
    assert "levelling leaves nothing" in refused("simulate", "--surface", path, "--step", "1um")
    np.save(path, np.sin(np.arange(64.0))[:, None] + np.zeros(64))
    words = ["--surface", path, "--step", "1", "--out", tmp_path / "r"]
    assert "no slopes along y" in refused("simulate", *words)
    assert "does not exist" in refused("simulate", "--surface", tmp_path / "b.npy")
    assert not (tmp_path / "r").exists()


def test_a_walk_on_the_slopes_of_the_surface(tmp_path):
    words = ["walk", "--slopes", "surface", "--surface", TERRAIN, "--step", "92.6,74.2", *FEW]
    result = msbsdf(*words, "--theta", "1", "--out", tmp_path / "r", "--quiet")
    assert result.returncode == 0, result.stderr
    run = json.loads((tmp_path / "r" / "run.json").read_text())
    assert run["options"]["alpha"] == pytest.approx([0.285, 0.303], abs=0.001)
    energy = table(tmp_path / "r" / "energy.csv")
    assert sum(float(row["energy"]) for row in energy) == pytest.approx(1)
    assert float(energy[0]["energy"]) > 0.9
    for half in (words[:3], ["walk", *words[3:7]]):
        assert "go together" in refused(*half, "--out", tmp_path / "r2")
    assert "--alpha beside --surface" in refused(*words, "--alpha", "1", "--out", tmp_path / "r2")
    flat = tmp_path / "flat.npy"
    np.save(flat, np.sin(np.arange(64.0))[:, None] + np.zeros(64))
    words = ["walk", "--slopes", "surface", "--surface", flat, "--step", "1"]
    assert "no rough surface" in refused(*words, "--out", tmp_path / "r2")
