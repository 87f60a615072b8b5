"""`msbsdf recommend`: report, words, refusals."""

import json

from command_line import msbsdf, refused, table

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


def test_a_scene_gets_a_sentence_a_table_and_a_picture(tmp_path):
    (tmp_path / "kitchen.toml").write_text(SCENE)
    result = msbsdf("recommend", "kitchen.toml", "--threads", "1", cwd=tmp_path, pictures=True)
    assert result.returncode == 0, result.stderr
    tap, bowl, _ = result.stdout.splitlines()
    assert tap.startswith("tap (alpha 0.02, perceptual 0.141): single scattering is enough, ")
    assert bowl.startswith("bowl")
    assert "bounces of exact" in bowl
    report = tmp_path / "reports" / "recommend-kitchen"
    rows = table(report / "recommendation.csv")
    assert {row["surface"] for row in rows} == {"tap", "bowl"}
    assert [row["verdict"] for row in rows].count("chosen") == 2
    assert (report / "recommendation.png").stat().st_size > 10_000
    assert json.loads((report / "run.json").read_text())["summary"] == [tap, bowl]


def test_what_is_no_scene_is_refused(tmp_path):
    (tmp_path / "empty.toml").write_text("")
    assert "no [[surface]]" in refused("recommend", tmp_path / "empty.toml")
    assert "cannot be read" in refused("recommend", tmp_path / "none.toml")
    (tmp_path / "kitchen.toml").write_text(SCENE)
    assert "tolerance" in refused("recommend", tmp_path / "kitchen.toml", "--tolerance", "0")
