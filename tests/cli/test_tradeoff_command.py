"""`msbsdf tradeoff` as a user meets it."""

import json

import pytest
from command_line import msbsdf, refused, table

QUICK = ["--theta", "0.5", "--samples", "64", "--replicates", "4", "--directions", "16"]
SURFACES = ["--rays", "2e3", "--cells", "4", "--extent", "8", "--realisations", "8"]
CONTRACT = [
    *("method", "material", "slopes", "alpha_x", "alpha_y", "theta_i_rad", "samples"),
    *("seconds", "relative_rmse", "bias", "efficiency", "slope"),
]


@pytest.fixture(autouse=True)
def haste(monkeypatch):
    """A reference may be coarse here: what it is worth, `test_tradeoff.py` sees."""
    monkeypatch.setattr("msbsdf_cli.experiments.tradeoff.reference.PATIENCE_S", 0)


def test_a_report_holds_what_the_contract_says(tmp_path):
    out = tmp_path / "report"
    methods = "single,walk,exact,solve"
    words = [*QUICK, *SURFACES, "--method", methods, "--out", out, "--json"]
    result = msbsdf("tradeoff", *words, pictures=True)
    assert result.returncode == 0, result.stderr
    record = json.loads(result.stdout)
    assert record["command"] == "tradeoff"
    assert record["reference"]["margin"] > 3
    rows = table(out / "tradeoff.csv")
    assert list(rows[0])[: len(CONTRACT)] == CONTRACT
    assert {r["method"] for r in rows} == {*methods.split(","), "simulate"}
    for r in rows:
        rmse, seconds = float(r["relative_rmse"]), float(r["seconds"])
        assert float(r["efficiency"]) == pytest.approx(1 / (rmse**2 * seconds))
    assert any(r["pareto"] == "True" for r in rows)
    floors = table(out / "floors.csv")
    assert {(r["floor"], r["model"]) for r in floors} >= {
        ("reference", "smith"), ("model", "smith"), ("model", "single"), ("surfaces", "surfaces"),
    }  # fmt: skip
    parameters = {r["parameter"] for r in table(out / "scaling.csv")}
    assert parameters == {"samples", "threads", "orders", "roughness"}
    assert {"reach.csv", "pairs.csv", "run.json"} <= {p.name for p in out.iterdir()}
    energies = table(out / "energies.csv")
    assert list(energies[0]) == list(rows[0])
    assert {r["method"] for r in energies} == {"simulate-one-mesh", "simulate-three-meshes"}
    for name in ("tradeoff.png", "scaling.png", "energies.png"):
        assert (out / name).stat().st_size > 10_000
    assert "--force" in refused("tradeoff", *QUICK, "--out", out)


def test_dielectrics_and_ggx_with_quasirandom_points_and_no_surfaces(tmp_path):
    words = ["--material", "dielectric", "--slopes", "ggx", "--method", "walk,walk-low-variance"]
    words += ["--alpha", "1,0.8", "--qmc", "--out", tmp_path / "r"]
    result = msbsdf("tradeoff", *QUICK, *words)
    assert result.returncode == 0, result.stderr
    assert "Beckmann slopes only" in result.stderr
    assert not any(r["method"] == "simulate" for r in table(tmp_path / "r" / "tradeoff.csv"))


@pytest.mark.parametrize(
    "words",
    [["--replicates", "1"], ["--directions", "3"], ["--rays", "0"], ["--method", "guess"]],
)
def test_bad_input_is_refused_in_a_sentence(words, tmp_path):
    assert words[0] in refused("tradeoff", *words, "--out", tmp_path / "r")
    assert not (tmp_path / "r").exists()
