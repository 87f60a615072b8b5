"""Random surfaces of several kinds: `--heights-of`, and several `--autocorrelation`."""

import json

import numpy as np
import pytest
from command_line import msbsdf, refused, table

FEW = ["--theta", "0.5,80deg", "--free-path-theta", "1", "--free-path-height", "0", "--cells", "4"]
FEW += ["--extent", "8", "--samples", "1e4", "--realisations", "8"]


@pytest.fixture(scope="module")
def ridges(tmp_path_factory):
    out = tmp_path_factory.mktemp("reports") / "r"
    words = ["simulate", "--heights-of", "ridges:2", "--material", "dielectric", *FEW]
    result = msbsdf(*words, "--out", out)
    assert result.returncode == 0, result.stderr
    return out, result


def test_ridges_are_simulated(ridges):
    out, result = ridges
    options = json.loads((out / "run.json").read_text())["options"]
    assert (options["heights_of"], options["alpha"]) == ("ridges:2", [0.5, 0.5])
    energy = table(out / "energy.csv")
    for theta in (0.5, np.radians(80)):
        rows = [r for r in energy if float(r["theta_i_rad"]) == theta]
        assert sum(float(row["energy"]) for row in rows) == pytest.approx(1)
    about = {row["quantity"]: float(row["value"]) for row in table(out / "roughness.csv")}
    # Slopes of the stated variance, and with longer tails than Beckmann's.
    assert about["beckmann_alpha_x"] == pytest.approx(0.5, rel=1e-6)
    assert about["student_t_misfit"] < about["beckmann_misfit"] / 2
    assert "student_t_gamma" in result.stdout


def test_ridges_are_compared_with_a_walk_on_their_slopes(ridges, tmp_path):
    out, _ = ridges
    result = msbsdf("compare", out, "--samples", "2e4", "--out", tmp_path / "c", "--quiet")
    assert result.returncode == 0, result.stderr
    record = json.loads((tmp_path / "c" / "run.json").read_text())
    assert "the slopes that were counted on the surface" in record["summary"]
    found = {row["quantity"] for row in table(tmp_path / "c" / "agreement.csv")}
    assert {"energy", "free_path_ks"} <= found
    for more in (["--heights-of", "pits"], ["--cells", "8"]):
        assert f"{more[0]} beside {out}: its surfaces" in msbsdf("compare", out, *more).stderr
    walk = tmp_path / "w"
    words = ["walk", "--material", "dielectric", *FEW[:6], "--samples", "1e4", "--out", walk]
    assert msbsdf(*words).returncode == 0
    refusal = msbsdf("compare", walk, out, "--out", tmp_path / "d")
    assert "leave it out, and a walk is made" in refusal.stderr


def test_the_parts_of_ridges(tmp_path):
    words = ["compare", "--heights-of", "pits:2", "--quiet", *FEW, "--out", tmp_path / "r"]
    result = msbsdf(*words)
    assert result.returncode == 0, result.stderr
    record = json.loads((tmp_path / "r" / "run.json").read_text())
    assert "because heights are correlated" in record["summary"]
    assert record["options"]["slopes"] != "beckmann"
    rows = table(tmp_path / "r" / "agreement.csv")
    assert {"part_distribution", "part_correlation", "whole"} <= {r["quantity"] for r in rows}
    for name in ("roughness.csv", "simulate/sums.npz"):
        assert (tmp_path / "r" / name).exists()
    assert "--method beside --heights-of" in refused(*words[:3], "--method", "walk")


@pytest.fixture(scope="module")
def spectra(tmp_path_factory):
    out = tmp_path_factory.mktemp("reports") / "r"
    words = ["compare", "--autocorrelation", "gaussian,matern:1.5", *FEW]
    result = msbsdf(*words, "--out", out, pictures=True)
    assert result.returncode == 0, result.stderr
    return out, result


def test_one_model_for_surfaces_of_several_autocorrelations(spectra):
    out, result = spectra
    rows = table(out / "agreement.csv")
    assert {r["autocorrelation"] for r in rows} == {"gaussian", "matern:1.5"}
    energy = [r for r in rows if r["quantity"] == "energy" and r["side"] == "reflected"]
    for row in (r for r in rows if r["quantity"] == "multiple_bounces"):
        same = [
            r
            for r in energy
            if all(r[k] == row[k] for k in ("theta_i_rad", "autocorrelation")) and r["order"] != "1"
        ]
        for side in ("simulated", "modelled"):
            assert float(row[side]) == pytest.approx(sum(float(r[side]) for r in same))
        # Mirrors lose nothing: what is known of the first order is known of the rest.
        first = [r for r in energy if r["order"] == "1" and r["theta_i_rad"] == row["theta_i_rad"]]
        stated = {r["autocorrelation"]: r["simulated_stderr"] for r in first}
        expected = float(stated[row["autocorrelation"]])
        assert float(row["simulated_stderr"]) == pytest.approx(expected, rel=1e-3)
    models = [[r["modelled"] for r in energy if r["autocorrelation"] == name] for name in
              ("gaussian", "matern:1.5")]  # fmt: skip
    assert models[0] == models[1]
    summary = json.loads((out / "run.json").read_text())["summary"]
    assert "one BSDF for all of them" in summary
    assert summary in result.stdout
    assert (out / "spectra.png").stat().st_size > 10_000
    for name in ("gaussian", "matern-1.5"):
        assert (out / f"simulate-{name}" / "sums.npz").exists()


def test_the_surfaces_are_those_of_simulate(spectra, tmp_path):
    out, _ = spectra
    words = ["simulate", "--autocorrelation", "matern:1.5", *FEW, "--quiet"]
    assert msbsdf(*words, "--out", tmp_path / "s").returncode == 0
    mine, theirs = (p / "energy.csv" for p in (tmp_path / "s", out / "simulate-matern-1.5"))
    assert mine.read_bytes() == theirs.read_bytes()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--autocorrelation", "gaussian,gaussian"], "names an autocorrelation twice"),
        (["--autocorrelation", "gaussian,wood"], "'wood' is not an autocorrelation"),
        (["--autocorrelation", "gaussian,exponential", "--method", "walk"], "--method beside"),
        (
            ["--autocorrelation", "gaussian,exponential", "--heights-of", "pits"],
            "--heights-of besi",
        ),
        (["--autocorrelation", "gaussian,exponential", "--save-mesh", "a.ply"], "--save-mesh besi"),
        (["--autocorrelation", "gaussian,exponential", "a"], "reports beside"),
        (["--heights-of", "hills"], "'hills' is not a distribution of heights"),
        (["--heights-of", "ridges:9"], "from 0.01 to 4"),
    ],
)
def test_what_does_not_apply_is_refused(words, said, tmp_path):
    assert said in refused("compare", *words, "--out", tmp_path / "r")
    assert not (tmp_path / "r").exists()


def test_sweeps_of_skewed_heights(tmp_path):
    words = ["sweep", "simulate", "--heights-of", "pits:2,gaussian", *FEW, "--quiet"]
    assert msbsdf(*words, "--out", tmp_path / "s").returncode == 0
    alone = [*FEW, "--heights-of", "pits:2", "--quiet", "--out", tmp_path / "r"]
    assert msbsdf("simulate", *alone).returncode == 0
    swept = [r for r in table(tmp_path / "s" / "sweep.csv") if r["heights_of"] == "pits:2"]
    # Other rays on the same surfaces.
    key = ("theta_i_rad", "order", "side")
    mine, theirs = (
        {tuple(row[k] for k in key): [float(row[k]) for k in ("energy", "stderr")] for row in rows}
        for rows in (swept, table(tmp_path / "r" / "energy.csv"))
    )
    assert mine.keys() == theirs.keys()
    for place, (energy, stderr) in mine.items():
        noise = stderr + theirs[place][1] + 1e-9
        assert abs(energy - theirs[place][0]) < 4 * noise


def test_simulate_takes_one_autocorrelation():
    words = ["simulate", "--autocorrelation", "gaussian,exponential"]
    assert "is not an autocorrelation" in refused(*words)
    assert "--heights-of beside --surface" in refused(
        "simulate", "--surface", __file__, "--heights-of", "pits"
    )
