"""`msbsdf compare --surface FILE`: three parts of the difference, as a user has them."""

import json

import numpy as np
import pytest
from command_line import msbsdf, refused, table

from msbsdf_cli.scene import direction
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.field import HeightField
from surfaces.materials import Conductor

FEW = ["--samples", "5e4", "--free-path-theta", "1", "--free-path-height", "0"]
ANGLES = ["--theta", "0.3,1.2", "--step", "1", "--periodic", "--height-unit"]


def saved(field, path):
    """The file of a field, and words that say of which units it is: steps of 1."""
    np.save(path, field.heights)
    return ["compare", "--surface", path, *ANGLES, str(1 / field.step[0]), *FEW]


def parts(out, quantity, name="own"):
    return np.array(
        [
            float(row[name])
            for row in table(out / "agreement.csv")
            if row["quantity"] == quantity and row["order"] == "all"
        ]
    )


@pytest.fixture(scope="module")
def field():
    return HeightField.random(alpha=0.7, seed=3, extent=16, cells=4)


@pytest.fixture(scope="module")
def words(field, tmp_path_factory):
    return saved(field, tmp_path_factory.mktemp("fields") / "beckmann.npy")


@pytest.fixture(scope="module")
def report(words, tmp_path_factory):
    out = tmp_path_factory.mktemp("reports") / "r"
    result = msbsdf(*words, "--out", out, pictures=True)
    assert result.returncode == 0, result.stderr
    return out, result


def test_slopes_of_a_gaussian_field_are_beckmanns(report):
    out, result = report
    own, stderr = (parts(out, "part_distribution", name) for name in ("own", "own_stderr"))
    # 3 standard errors at two angles.
    assert (np.abs(own) < 3 * stderr).all()
    assert (stderr < 0.05).all()
    record = json.loads((out / "run.json").read_text())
    assert record["options"]["slopes"] == "beckmann"
    assert "because heights are correlated" in record["summary"]
    assert record["summary"] in result.stdout
    assert "the least model that is within" in record["summary"]
    for name in ("parts.png", "surface.png"):
        assert (out / name).stat().st_size > 10_000
    assert (out / "simulate" / "sums.npz").exists()


def test_what_single_scattering_leaves_out_is_what_a_quadrature_says(report):
    out, _ = report
    alpha = json.loads((out / "run.json").read_text())["options"]["alpha"]
    wi = np.array([direction(theta) for theta in (0.3, 1.2)]).T
    albedo = first_order_albedo(Beckmann(*alpha), Conductor(), wi)
    # Noise of the walks alone, whose number is known: no surface is in it.
    noise = np.sqrt(albedo * (1 - albedo) / 1e5)
    np.testing.assert_array_less(np.abs(parts(out, "part_bounces") - (1 - albedo)), 4 * noise)
    later = [
        row
        for row in table(out / "agreement.csv")
        if row["quantity"] == "part_bounces_energy" and row["order"] != "1"
    ]
    assert all(float(row["modelled"]) == 0 for row in later)
    total = sum(float(row["simulated"]) for row in later)
    assert total == pytest.approx(parts(out, "part_bounces").sum())


def test_the_surface_is_that_of_simulate(words, report, tmp_path):
    out, _ = report
    alone = ["simulate", *words[1:], "--out", tmp_path / "s", "--quiet"]
    assert msbsdf(*alone).returncode == 0
    for name in ("energy.csv", "lobe.csv"):
        assert (tmp_path / "s" / name).read_bytes() == (out / "simulate" / name).read_bytes()
    assert (tmp_path / "s" / "roughness.csv").read_bytes() == (out / "roughness.csv").read_bytes()
    energy = {(r["theta_i_rad"], r["order"]): r for r in table(tmp_path / "s" / "energy.csv")}
    for row in table(out / "agreement.csv"):
        if row["quantity"] == "part_correlation_energy":
            mine = float(energy[row["theta_i_rad"], row["order"]]["energy"])
            # Groups are saved in single precision, sums in double.
            assert float(row["simulated"]) == pytest.approx(mine, abs=1e-6)


def test_slopes_with_long_tails_are_not_beckmanns(field, tmp_path):
    # Rough here and smooth there, the same in each of 4 x 4 pieces.
    wave = np.sin(8 * np.pi * np.arange(64) / 64)
    tailed = field.heights * np.exp(1.6 * wave[:, None] * wave) / 1.6
    words = [*saved(HeightField(tailed, field.step), tmp_path / "tails.npy"), "--quiet"]
    forced, free = tmp_path / "forced", tmp_path / "free"
    assert msbsdf(*words, "--slopes", "beckmann", "--out", forced).returncode == 0
    assert msbsdf(*words, "--out", free).returncode == 0
    assert (parts(forced, "part_distribution", "z") > 5).all()
    assert (parts(free, "part_distribution") < parts(forced, "part_distribution") / 2).all()
    options = json.loads((free / "run.json").read_text())["options"]
    assert options["slopes"] in ("ggx", "student-t")
    # Whatever is judged, heights are correlated alike.
    same = (parts(out, "part_correlation") for out in (forced, free))
    np.testing.assert_array_equal(*same)


def test_threads_do_not_change_the_numbers(words, tmp_path):
    few = [*words[: words.index("--samples")], "--samples", "2000", "--quiet"]
    for threads in (1, 2):
        more = ["--threads", threads, "--out", tmp_path / f"r{threads}"]
        assert msbsdf(*few, *FEW[2:], *more).returncode == 0
    first, second = ((tmp_path / r / "agreement.csv").read_bytes() for r in ("r1", "r2"))
    assert first == second


def test_the_gamma_that_is_given_is_judged(words, tmp_path):
    more = ["--slopes", "student-t", "--gamma", "2", "--quiet", "--out", tmp_path / "r"]
    assert msbsdf(*words, *more, "--material", "dielectric").returncode == 0
    options = json.loads((tmp_path / "r" / "run.json").read_text())["options"]
    about = {row["quantity"]: float(row["value"]) for row in table(tmp_path / "r/roughness.csv")}
    assert options["gamma"] == 2
    # At a gamma of 2 it is GGX.
    assert options["alpha"][0] == pytest.approx(about["ggx_alpha_x"], rel=1e-6)
    sides = {row["side"] for row in table(tmp_path / "r" / "agreement.csv")}
    assert sides == {"all", "reflected", "transmitted"}


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--alpha", "0.5"], "--alpha beside --surface"),
        (["--cells", "8"], "--cells beside --surface"),
        (["--autocorrelation", "exponential"], "--autocorrelation beside --surface"),
        (["--method", "walk"], "--method beside --surface"),
        (["--gamma", "3"], "--gamma without --slopes student-t"),
        (["--slopes", "ggx", "--gamma", "3"], "--gamma without --slopes student-t"),
        (["a", "b"], "reports beside --surface"),
        (["--filter", "0"], "'0' is not a length above 0"),
        (["--slopes", "surface"], "'surface' is not one of"),
    ],
)
def test_what_does_not_apply_is_refused(words, more, said, tmp_path):
    assert said in refused(*words, *more, "--out", tmp_path / "r")
    assert not (tmp_path / "r").exists()


def test_without_a_surface_all_is_beckmann(tmp_path):
    assert "random surfaces are beckmann" in refused("compare", "--slopes", "ggx")
    for more in (["--step", "1"], ["--periodic"], ["--wavelength", "1um"]):
        assert f"{more[0]} without --surface" in refused("compare", *more)
    path = tmp_path / "flat.npy"
    np.save(path, np.ones((8, 8)))
    few = tmp_path / "few.npy"
    np.save(few, HeightField.random(extent=4, cells=4).heights[:10])
    assert "9 x 15 facets are too few" in refused("compare", "--surface", few, "--step", "1")
    assert "without roughness" in refused("compare", "--surface", path, "--step", "1")
