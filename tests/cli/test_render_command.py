"""`msbsdf render` as a user meets it."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command_line import msbsdf, refused, table

from msbsdf_cli.cli.render import what_happened
from msbsdf_cli.experiments.render.picture import Picture

TINY = ["--width", "12", "--samples", "2", "--threads", "1"]


def test_a_report_has_pictures_tables_and_linear_data(tmp_path):
    out = tmp_path / "plate"
    words = [*TINY, "--method", "single,walk", "--out", out, "--json"]
    result = msbsdf("render", *words, pictures=True)
    assert result.returncode == 0, result.stderr
    names = {"render.png", "render.csv", "run.json", "index.html"}
    arrays = {f"{m}{s}.npy" for m in ("single", "walk") for s in ("", "_stderr")}
    assert {p.name for p in out.iterdir()} == names | arrays
    rows = table(out / "render.csv")
    image = np.load(out / "walk.npy")
    assert image.shape == (8, 12, 3)
    assert image.dtype == np.float32
    assert float(rows[1]["luminance"]) == pytest.approx(
        image.mean(axis=(0, 1)) @ [0.2126, 0.7152, 0.0722], rel=1e-5
    )
    said = json.loads(result.stdout)
    assert said["options"]["texture"] == "roughness"
    assert said["options"]["material"] == "dielectric"


def test_scenes_have_surfaces_of_their_own_that_options_change(tmp_path):
    def options(*words):
        out = tmp_path / str(len(list(tmp_path.iterdir())))
        result = msbsdf("render", *words, *TINY, "--method", "single", "--out", out, "--json")
        assert result.returncode == 0, result.stderr
        return json.loads(result.stdout)["options"]

    assert options("sphere")["metal"] == "gold"
    assert options("sphere", "--material", "diffuse")["metal"] is None
    copper = options("sphere", "--metal", "copper", "--alpha", "0.3,0.1")
    assert (copper["metal"], copper["rgb"], copper["alpha"]) == ("copper", True, [0.3, 0.1])
    assert options("plate", "--texture", "none")["texture"] == "none"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["kitchen"], "kitchen"),
        (["sphere", "--texture", "roughness"], "has no texture"),
        (["plate", "--texture", "albedo"], "albedo is of diffuse facets"),
        (["plate", "--method", "exact"], "conductors and diffuse"),
        (["--samples", "1"], "too few"),
        (["--width", "1e6"], "too many"),
        (["--material", "conductor", "--eta-k", "1,2,3"], "not pairs"),
    ],
)
def test_what_cannot_be_rendered_is_refused(words, said):
    assert said in refused("render", *words)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["plate", "--texture", "albedo", "--material", "diffuse", "--method", "solve"],
            "one albedo",
        ),
        (
            ["--texture", "anisotropy", "--material", "conductor", "--method", "turquin"],
            "not of two",
        ),
        (
            ["--material", "conductor", "--alpha", "1,0.1", "--method", "energy-compensated"],
            "not of two",
        ),
        (["--claims", "--width", "50"], "--width beside --claims"),
        (["sphere", "--claims"], "SCENE beside --claims"),
    ],
)
def test_what_would_come_to_nothing_is_refused_at_once(words, said):
    assert said in refused("render", *words)


def test_what_paths_did_not_carry_is_said():
    nothing = np.ones((3, 2, 2))
    picture = Picture("published", nothing, nothing, 10, 1.0, 40, 0)
    assert what_happened([picture]) == []
    lost, nonfinite, cut = what_happened([replace(picture, lost=1, nonfinite=2, cut=3)])
    assert lost.startswith("1 of 40 paths by published were lost")
    assert nonfinite.startswith("2 values by published were not finite")
    assert cut.startswith("3 walks by published were cut off")


def test_what_has_no_effect_is_said_and_a_metal_is_a_conductor(tmp_path):
    words = ["--texture", "albedo", "--material", "diffuse", "--albedo", "0.5", "--gamma", "3"]
    result = msbsdf("render", *words, *TINY, "--method", "single", "--out", tmp_path / "a")
    assert "--albedo has no effect" in result.stderr
    assert "--gamma has no effect: it is for --slopes student-t" in result.stderr
    words = ["--metal", "silver", "--method", "single", "--json"]
    result = msbsdf("render", *words, *TINY, "--out", tmp_path / "b")
    assert json.loads(result.stdout)["options"]["material"] == "conductor"
