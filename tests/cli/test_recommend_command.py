"""`msbsdf recommend`: report, words, refusals."""

import json

import pytest
from command_line import msbsdf, refused, table

from msbsdf_cli.cli.recommend import time_warnings
from msbsdf_cli.experiments.recommend import rendered
from msbsdf_cli.experiments.recommend.choice import Wanted
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.experiments.render.picture import Settings
from msbsdf_cli.smith.slopes import Ggx
from surfaces.materials import Conductor

SCENE = """
[[surface]]
name = "tap"
material = "conductor"
metal = "gold"
slopes = "ggx"
alpha = 0.02
theta = [0, "45deg"]

[[surface]]
name = "bowl"
material = "conductor"
slopes = "ggx"
alpha = 0.6
"""


@pytest.mark.parametrize(("alpha", "warned"), [((1e-6, 1e-6), False), ((0.001, 0.7), True)])
def test_what_its_bound_ends_at_once_is_not_said_to_take_long(alpha, warned):
    tap = SceneSurface("tap", Conductor.named("gold"), (Ggx(*alpha),), (0.0, 0.8))
    said = time_warnings([tap], Wanted(0.01), {"threads": 1, "against": "smith"})
    assert any("will take about" in sentence for sentence in said) == warned


def test_a_scene_gets_a_sentence_a_table_and_a_picture(tmp_path):
    (tmp_path / "kitchen.toml").write_text(SCENE)
    result = msbsdf("recommend", "kitchen.toml", "--threads", "1", cwd=tmp_path, pictures=True)
    assert result.returncode == 0, result.stderr
    tap, bowl, _ = result.stdout.splitlines()
    assert tap.startswith("tap (alpha 0.02, perceptual 0.141): single scattering is enough, ")
    assert "colour difference" in tap
    assert bowl.startswith("bowl")
    assert "bounces of exact" in bowl
    report = tmp_path / "reports" / "recommend-kitchen"
    rows = table(report / "recommendation.csv")
    assert {row["surface"] for row in rows} == {"tap", "bowl"}
    assert list(rows[0])[:12] == CONTRACT
    chosen = [row for row in rows if row["chosen"] == "True"]
    assert [row["surface"] for row in chosen] == ["tap", "bowl"]
    for row in chosen:
        assert (row["verdict"], row["meets_tolerance"]) == ("chosen", "True")
        assert float(row["error"]) <= float(row["error_bound"]) <= 0.01
        assert float(row["cost_ns"]) > 0
        assert float(row["perceptual_x"]) ** 2 == pytest.approx(float(row["alpha_x"]))
    assert {row["colour_difference"] for row in rows if row["surface"] == "bowl"} == {""}
    assert (report / "recommendation.png").stat().st_size > 10_000
    assert json.loads((report / "run.json").read_text())["summary"] == [tap, bowl]


CONTRACT = [
    *("surface", "material", "slopes", "alpha_x", "alpha_y", "method", "orders", "error"),
    *("error_bound", "cost_ns", "meets_tolerance", "chosen"),
]


def test_a_scene_against_traced_surfaces(tmp_path):
    """The model is 4 % off a mirror of roughness 1; foil's slopes no surface has."""
    scene = (
        'tolerance = 0.015\n[[surface]]\nname = "bowl"\nmaterial = "conductor"\nalpha = 1\n'
        'theta = 0\n[[surface]]\nname = "foil"\nmaterial = "conductor"\nslopes = "ggx"\n'
        "alpha = 0.5\n"
    )
    (tmp_path / "kitchen.toml").write_text(scene)
    words = "recommend", "kitchen.toml", "--against", "surfaces", "--samples", "6e4"
    result = msbsdf(*words, "--threads", "1", "--out", "r", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    bowl, foil, _ = result.stdout.splitlines()
    assert "no number of bounces of the Smith model gets below" in bowl
    assert (
        foil
        == "foil is not judged: its slopes are ggx, and the surfaces that are traced are "
        + ("Gaussian ones: against them slopes beckmann can be judged.")
    )
    assert foil in result.stderr
    rows = table(tmp_path / "r" / "recommendation.csv")
    assert [row["verdict"] for row in rows if row["chosen"] == "True"] == ["nearest"]
    assert {row["meets_tolerance"] for row in rows} == {"False"}
    (tmp_path / "foil.toml").write_text("[[surface]]" + scene.rpartition("[[surface]]")[2])
    words = "recommend", tmp_path / "foil.toml", "--against", "surfaces"
    alone = msbsdf(*words, "--out", "s", cwd=tmp_path)
    assert alone.returncode == 1
    assert "no surface that can be judged" in alone.stderr
    assert not (tmp_path / "s").exists()


def test_what_is_no_scene_is_refused(tmp_path):
    (tmp_path / "empty.toml").write_text("")
    assert "no [[surface]]" in refused("recommend", tmp_path / "empty.toml")
    said = refused("recommend", tmp_path / "none.toml")
    assert "is no file, and none of the scenes bottle, furnace, plate, slab, sphere" in said
    (tmp_path / "kitchen.toml").write_text(SCENE)
    assert "tolerance" in refused("recommend", tmp_path / "kitchen.toml", "--tolerance", "0")
    words = "recommend", tmp_path / "kitchen.toml", "--colour-tolerance", "0"
    assert "a number above 0" in refused(*words)


def test_a_scene_of_render_has_its_picture_judged_too(tmp_path, monkeypatch):
    monkeypatch.setattr(rendered, "SETTINGS", Settings(16, 16, 4))
    out = tmp_path / "slab"
    result = msbsdf("recommend", "slab", "--threads", "1", "--out", out)
    assert result.returncode == 0, result.stderr
    assert "The picture of slab is off by" in result.stdout
    rows = table(out / "picture.csv")
    assert [row["method"] for row in rows] == ["single", "energy-compensated", "turquin"]
    assert all(float(row["error"]) <= float(row["error_bound"]) for row in rows)
