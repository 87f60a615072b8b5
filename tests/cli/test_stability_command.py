"""`msbsdf stability` as a user meets it."""

import json

import pytest
from command_line import msbsdf, refused, table

CELL = "single,float32,roughness,0.001,conductor,ggx,1.5707"
COLUMNS = (
    *("method", "precision", "parameter", "value", "material", "slopes", "alpha_x", "alpha_y"),
    *("theta_i_rad", "verdict", "nonfinite", "energy_error", "bounces_mean", "slowdown", "note"),
)


def test_one_cell_alone(tmp_path):
    result = msbsdf("stability", "--cell", CELL, "--json", "--out", tmp_path / "r")
    assert result.returncode == 0, result.stderr
    (row,) = table(tmp_path / "r" / "stability.csv")
    assert list(row)[: len(COLUMNS)] == list(COLUMNS)
    assert row["cell"] == CELL
    # Directions in single precision are no finer than this: see `reports/trust.md`.
    assert row["verdict"] == "degraded"
    assert "first order off by" in row["note"]
    found = json.loads(result.stdout)
    assert found["verdicts"]["single float32"]["degraded"] == 1
    assert sorted(p.name for p in (tmp_path / "r").iterdir()) == [
        "index.html",
        "run.json",
        "stability.csv",
    ]


@pytest.mark.parametrize(
    "cell",
    ["", "walk", "walk,float16,roughness,0.001,conductor,ggx,1", "surfaces,cells,5", "a,b,c,d"],
)
def test_a_cell_that_is_none_is_refused(cell, tmp_path):
    said = refused("stability", "--cell", cell, "--out", tmp_path / "r")
    assert "--cell" in said
    assert not (tmp_path / "r").exists()
