"""`--memory` and `--against surfaces` on the command line."""

import json

import pytest
from command_line import msbsdf, refused, table

SMALL = ["--alpha", "1", "--theta", "1", "--samples", "4000", "--threads", "1", "--quiet"]
COARSE = ["--cells", "8", "--extent", "8", "--realisations", "4"]


def first_order(place):
    return float(table(place / "energy.csv")[0]["energy"])


def test_a_walk_that_remembers_makes_a_report_like_any_other(tmp_path):
    for memory in (0, 1, 2):
        words = [*SMALL, "--memory", memory, "--out", tmp_path / str(memory)]
        result = msbsdf("walk", *words, "--free-path-theta", "1.0")
        assert result.returncode == 0, result.stderr
    names = [{p.name for p in (tmp_path / place).iterdir()} for place in ("0", "1")]
    assert names[0] == names[1]
    # .746 and .772, known from long runs; four standard errors of .007 each.
    for place, energy in (("0", 0.746), ("1", 0.772), ("2", 0.772)):
        assert first_order(tmp_path / place) == pytest.approx(energy, abs=0.028)
    assert len({first_order(tmp_path / place) for place in ("0", "1", "2")}) == 3
    options = json.loads((tmp_path / "1" / "run.json").read_text())["options"]
    assert (options["memory"], options["autocorrelation"]) == (1, "gaussian")


def test_the_walk_compared_remembers_the_surface_that_was_traced(tmp_path):
    traced = tmp_path / "traced"
    words = [*SMALL, *COARSE, "--autocorrelation", "exponential", "--out", traced]
    words += ["--free-path-theta", "1", "--free-path-height", "0"]
    assert msbsdf("simulate", *words).returncode == 0
    words = [traced, "--memory", "1", "--samples", "4000", "--quiet", "--threads", "1"]
    result = msbsdf("compare", *words, "--out", tmp_path / "c")
    assert result.returncode == 0, result.stderr
    assert {r["method"] for r in table(tmp_path / "c" / "agreement.csv")} == {"walk-memory"}
    record = json.loads((tmp_path / "c" / "walk" / "run.json").read_text())
    assert record["options"]["autocorrelation"] == "exponential"


def test_the_chart_against_surfaces_has_the_distance_in_each_error(tmp_path):
    words = [
        "--theta",
        "1",
        "--alpha",
        "1",
        "--samples",
        "64",
        "--replicates",
        "4",
        "--rays",
        "2e3",
    ]
    words += ["--directions", "16", *COARSE[:4], "--realisations", "8", "--threads", "1", "--quiet"]
    words += ["--method", "walk,walk-memory", "--against", "surfaces", "--out", tmp_path / "r"]
    result = msbsdf("tradeoff", *words)
    assert result.returncode == 0, result.stderr
    rows = [r for r in table(tmp_path / "r" / "tradeoff.csv") if r["method"] != "simulate"]
    assert {r["reference"] for r in rows} == {"surfaces"}
    assert all(float(r["relative_rmse"]) >= float(r["to_surfaces"]) for r in rows)
    assert (
        "remembers the last facet"
        in json.loads((tmp_path / "r" / "run.json").read_text())["summary"]
    )


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["walk", "--memory", "1", "--slopes", "ggx"], "beckmann"),
        (["walk", "--memory", "1", "--heights", "uniform"], "gaussian"),
        (["walk", "--memory", "3"], "--memory"),
        (["compare", "--memory", "1", "--method", "walk"], "walk-memory"),
        (["compare", "--memory", "1", "--autocorrelation", "gaussian,exponential"], "--memory"),
        (["compare", "--memory", "1", "--heights-of", "pits:1"], "--memory"),
        (["tradeoff", "--against", "surfaces", "--slopes", "ggx"], "Beckmann"),
        (["tradeoff", "--against", "surfaces", "--no-surfaces"], "--no-surfaces"),
        (
            ["tradeoff", "--autocorrelation", "exponential", "--method", "walk-memory"],
            "remembers gaussian ones",
        ),
        (["evaluate", "--method", "walk-memory", "--slopes", "ggx"], "beckmann"),
    ],
)
def test_what_it_is_not_for_is_refused(words, says):
    assert says in refused(*words)
