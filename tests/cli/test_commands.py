"""The command line as a user meets it."""

import json
import math
import shutil
import subprocess
import sys
from functools import cache

import pytest
from command_line import RUN, msbsdf, refused, table

FEW = ["--theta", "0.5,80deg", "--free-path-theta", "1,2", "--free-path-height", "-1,0,inf"]
QUICK = {
    "walk": ["walk", "--samples", "2e4", *FEW],
    "simulate": ["simulate", "--samples", "1e4", *FEW, "--realisations", "4", "--extent", "8",
                 "--cells", "4"],
}  # fmt: skip


DRAWN = "simulate", "dielectric"
"""Whose pictures, the same of either command, are looked at."""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The directory and the summary of a quick run, made once for all that only read them."""

    @cache
    def made(command, material="conductor"):
        out = tmp_path_factory.mktemp("reports") / command
        words = ["--material", material, "--threads", 2, "--out", out, "--json"]
        result = msbsdf(*QUICK[command], *words, pictures=(command, material) == DRAWN)
        assert result.returncode == 0, result.stderr
        return out, json.loads(result.stdout)

    return made


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--alpha", "0"], "roughness"),
        (["--alpha", "-1"], "roughness"),
        (["--alpha", "nan"], "nan"),
        (["--alpha", "1,2,3"], "roughness"),
        (["--alpha", "rough"], "rough"),
        (["--theta", "1.6"], "1.6"),
        (["--theta", "90deg"], "90deg"),
        (["--theta", "-0.1"], "-0.1"),
        (["--theta", "1,1"], "twice"),
        (["--alpha", "0.3", "--alpha=0.5"], "--alpha is given twice"),
        (["--phi", "1,2"], "one angle"),
        (["--ior", "1"], "index"),
        (["--ior", "-2"], "index"),
        (["--albedo", "1.5"], "albedo"),
        (["--samples", "0"], "0"),
        (["--samples", "1.5"], "whole"),
        (["--samples", "many"], "many"),
        (["--threads", "0"], "0"),
        (["--orders", "0"], "0"),
        (["--metal", "tin"], "tin"),
        (["--metal", "gold", "--eta-k", "1,2"], "--eta-k"),
        (["--eta-k", "1"], "2 numbers"),
        (["--eta-k", "0,3"], "metal"),
        (["--eta-k", "1,inf"], "metal"),
        (["--eta-k", "1e200,1e200"], "metal"),
        (["--ior", "1e9"], "index"),
        (["--material", "wood"], "wood"),
        (["--colour", "red"], "--colour"),
    ],
)
@pytest.mark.parametrize("command", ["walk", "simulate"])
def test_bad_input_is_refused_in_a_sentence(command, words, said, tmp_path):
    sentence = refused(command, *words, "--out", tmp_path / "r")
    assert said in sentence
    assert words[0] in sentence
    assert not (tmp_path / "r").exists()


@pytest.mark.parametrize(
    "words",
    [
        ["--cells", "5"],
        ["--cells", "2"],
        ["--extent", "0"],
        ["--realisations", "1"],
        ["--accuracy", "0"],
        ["--slopes", "ggx"],
        ["--save-mesh", "surface.txt"],
        ["--save-mesh", "no/such/place.ply"],
    ],
)
def test_bad_surfaces_are_refused(words, tmp_path):
    assert words[0] in refused("simulate", *words, "--out", tmp_path / "r")


def test_heights_below_the_surface_are_refused(tmp_path):
    words = ["--heights", "uniform", "--free-path-height", "-2", "--out", tmp_path / "r"]
    assert "--free-path-height" in refused("walk", *words)


@pytest.mark.parametrize("command", sorted(QUICK))
@pytest.mark.parametrize("material", ["conductor", "diffuse", "dielectric"])
def test_a_report_holds_what_the_contract_says(command, material, report):
    out, summary = report(command, material)
    run = json.loads((out / "run.json").read_text())
    for key in ("command", "options", "seed", "versions", "started", "wall_s", "rate_per_s"):
        assert run[key] == summary[key]
    assert run["bounces_mean"] >= 1
    energy = table(out / "energy.csv")
    for theta in {row["theta_i_rad"] for row in energy}:
        total = sum(float(row["energy"]) for row in energy if row["theta_i_rad"] == theta)
        assert total == pytest.approx(1, abs=1e-12)
    assert {row["order"] for row in energy} == {"1", "2", "3", "4", ">4", "all"}
    assert {float(row["theta_i_rad"]) for row in energy} == {0.5, math.radians(80)}
    lobe = table(out / "lobe.csv")
    inside = sum(float(r["density_per_sr"]) * float(r["solid_angle_sr"]) for r in lobe)
    # Nine digits a bin.
    assert inside == pytest.approx(2, abs=1e-6)
    assert {"stderr_xx", "mean_z", "side"} <= set(table(out / "moments.csv")[0])
    rows = table(out / "free_path.csv")
    assert {row["height_start"] for row in rows} >= {"-1.0", "0.0", "inf"}
    for key in {(row["theta_r_rad"], row["height_start"]) for row in rows}:
        mine = [r for r in rows if (r["theta_r_rad"], r["height_start"]) == key]
        assert sum(float(r["probability"]) for r in mine) == pytest.approx(1, abs=1e-9)
        escapes = [r for r in mine if r["height_low"] == r["height_high"] == "inf"]
        assert len(escapes) == 1
    assert (out / "sequence.csv").exists() == (material == "dielectric")
    if material == "dielectric":
        rows = table(out / "sequence.csv")
        assert {"R", "T"} <= {row["sequence"] for row in rows}
        assert all(
            (row["sequence"].count("T") % 2 == 1) == (row["side"] == "transmitted")
            for row in rows
            if not row["sequence"].startswith(">")
        )
        assert sum(float(row["energy"]) for row in rows) == pytest.approx(2, abs=1e-12)
    if (command, material) == DRAWN:
        for name in ("lobes.png", "lobes_transmitted.png", "free_path.png"):
            assert (out / name).stat().st_size > 10_000


@pytest.mark.parametrize("command", sorted(QUICK))
def test_the_same_bytes_whatever_the_threads(command, report, tmp_path):
    two, one = report(command, "dielectric")[0], tmp_path / "one"
    words = [*QUICK[command], "--threads", 1, "--material", "dielectric"]
    assert msbsdf(*words, "--out", one, "--quiet").returncode == 0
    for name in ("energy.csv", "moments.csv", "lobe.csv", "free_path.csv", "sequence.csv"):
        assert (one / name).read_bytes() == (two / name).read_bytes()


def test_another_seed_gives_other_numbers(report, tmp_path):
    out = tmp_path / "other"
    assert msbsdf(*QUICK["walk"], "--seed", 1, "--out", out).returncode == 0
    assert (out / "energy.csv").read_bytes() != (report("walk")[0] / "energy.csv").read_bytes()


def test_a_report_is_not_overwritten_unless_forced(report, tmp_path):
    out = shutil.copytree(report("walk")[0], tmp_path / "report")
    before = (out / "energy.csv").read_bytes()
    (out / "notes.txt").write_text("mine")
    again = [*QUICK["walk"], "--seed", 9, "--out", out]
    assert "--force" in refused(*again)
    assert (out / "energy.csv").read_bytes() == before
    assert msbsdf(*again, "--force").returncode == 0
    assert (out / "energy.csv").read_bytes() != before
    assert (out / "notes.txt").read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["report"]


def test_a_directory_of_other_files_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    refused(*QUICK["walk"], "--out", tmp_path, "--force")
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_what_takes_long_is_said_beforehand(tmp_path):
    words = ["walk", "--samples", "1e12", "--out", str(tmp_path / "r")]
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, *words], stderr=subprocess.PIPE, text=True
    )
    line = process.stderr.readline()
    process.terminate()
    process.communicate(timeout=20)
    assert "Warning" in line
    assert "days" in line


def test_an_option_without_effect_is_said(tmp_path):
    words = [*QUICK["walk"], "--albedo", "0.5", "--out", tmp_path / "r"]
    assert "--albedo has no effect" in msbsdf(*words).stderr


def test_mesh_is_saved_and_not_overwritten(tmp_path):
    import trimesh

    mesh = tmp_path / "surface.ply"
    words = [*QUICK["simulate"], "--save-mesh", mesh, "--alpha", "1,0.1", "--out", tmp_path / "r"]
    assert msbsdf(*words).returncode == 0
    loaded = trimesh.load_mesh(mesh)
    # 8 correlation lengths of 2 / alpha, shortened to keep the facets' slopes: 2 (1/2) / 4^2.
    size = loaded.bounds[1] - loaded.bounds[0]
    assert size[0] == pytest.approx(16, rel=0.04)
    assert size[1] == pytest.approx(160, rel=0.04)
    assert len(loaded.faces) == 2 * 32**2
    assert "--save-mesh" in refused(*words[:-1], tmp_path / "r2")


def test_what_is_not_finite_is_counted(tmp_path):
    """A single walk has no standard error that is known."""
    out = tmp_path / "r"
    result = msbsdf("walk", "--samples", "1", "--theta", "0.5", "--out", out)
    assert result.returncode == 0
    rows = table(out / "energy.csv")
    count = sum(not math.isfinite(float(r["stderr"])) for r in rows)
    sentence = f"energy.csv: {count} of {len(rows)} values in the column stderr are not finite."
    assert count > 0
    assert sentence in result.stderr
    assert sentence in json.loads((out / "run.json").read_text())["warnings"]


def test_compare_runs_both_and_compares_reports(tmp_path):
    out = tmp_path / "both"
    words = [*QUICK["simulate"][1:], "--alpha", "1", "--out", out]
    result = msbsdf("compare", *words)
    assert result.returncode == 0, result.stderr
    assert "Beyond noise" in result.stdout
    rows = table(out / "agreement.csv")
    assert {"energy", "total_variation", "free_path_ks"} <= {row["quantity"] for row in rows}
    for row in rows:
        if row["quantity"] == "energy":
            apart = float(row["modelled"]) - float(row["simulated"])
            assert float(row["difference"]) == pytest.approx(apart, abs=1e-12)
    # The same from the two reports, in either order.
    again = msbsdf("compare", out / "walk", out / "simulate", "--out", tmp_path / "again")
    assert again.returncode == 0, again.stderr
    assert (tmp_path / "again" / "agreement.csv").read_bytes() == (
        out / "agreement.csv"
    ).read_bytes()
    # And with one handed over, the other is run for its scene.
    one = msbsdf("compare", out / "simulate", "--samples", 1e4, "--out", tmp_path / "one")
    assert one.returncode == 0, one.stderr


def test_reports_of_different_scenes_are_refused(report, tmp_path):
    simulated = shutil.copytree(report("simulate")[0], tmp_path / "s")
    for i, change in enumerate((["--alpha", "0.7"], ["--slopes", "ggx"], ["--metal", "gold"])):
        model = tmp_path / f"w{i}"
        assert msbsdf(*QUICK["walk"], *change, "--out", model).returncode == 0
        result = msbsdf("compare", simulated, model, "--out", tmp_path / "c")
        assert result.returncode == 1
        assert "different scenes" in result.stderr
    other = msbsdf("compare", tmp_path / "w0", tmp_path / "w1", "--out", tmp_path / "c")
    assert other.returncode == 1
    assert "walk" in other.stderr
    (simulated / "energy.csv").write_text("not,a\ntable")
    result = msbsdf("compare", simulated, report("walk")[0], "--out", tmp_path / "c")
    assert result.returncode == 1
    assert "energy.csv" in result.stderr
    assert "Traceback" not in result.stderr
    assert not (tmp_path / "c").exists()


def test_compare_refuses_what_is_not_a_report(tmp_path):
    result = msbsdf("compare", tmp_path / "nothing", "--out", tmp_path / "c")
    assert result.returncode == 1
    assert "not a report" in result.stderr
    refused("compare", "a", "b", "c", "--out", tmp_path / "c")


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from click.testing import CliRunner; from msbsdf_cli.cli import group\n"
        "from msbsdf_cli.cli import COMMANDS\n"
        "for words in ([], ['--help'], ['--version'], *([name, '-h'] for name in COMMANDS)):\n"
        "    assert CliRunner().invoke(group, words).exit_code in (0, 2)\n"
        "heavy = {'numpy', 'scipy', 'matplotlib', 'trimesh', 'embreex', 'rich'}\n"
        "heavy &= set(sys.modules)\n"
        "sys.exit(', '.join(heavy) or 0)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr


def test_a_full_disk_is_a_sentence():
    result = msbsdf(*QUICK["walk"], "--out", "/proc/nowhere/report")
    assert result.returncode == 1
    assert "Traceback" not in result.stderr
    assert "/proc/nowhere" in result.stderr


def test_random_surfaces_of_another_autocorrelation(tmp_path):
    words = [*QUICK["simulate"], "--autocorrelation", "power-law:0.8"]
    assert msbsdf(*words, "--out", tmp_path / "r", "--quiet").returncode == 0
    run = json.loads((tmp_path / "r" / "run.json").read_text())
    assert run["options"]["autocorrelation"] == "power-law:0.8"
    other = [*QUICK["simulate"], "--out", tmp_path / "s", "--quiet"]
    assert msbsdf(*other).returncode == 0
    first, second = (table(tmp_path / name / "energy.csv") for name in "rs")
    assert [row["energy"] for row in first] != [row["energy"] for row in second]
    sentence = refused("simulate", "--autocorrelation", "matern", "--out", tmp_path / "t")
    assert "--autocorrelation" in sentence
    assert "matern:NU" in sentence
