"""`--memory` and `--against surfaces` on the command line."""

import json

import click
import pytest
from command_line import msbsdf, refused, table

from msbsdf_cli.experiments.tradeoff import study
from msbsdf_cli.methods.walk_memory import WalkMemory

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


def test_the_chart_against_surfaces_has_the_distance_in_each_error(tmp_path, monkeypatch):
    # Time over anything else is no part of it.
    monkeypatch.setattr(study, "scale", lambda *arguments: [])
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


FEW = ["--alpha", "1", "--theta", "1.4", "--samples", "200"]


@pytest.fixture
def asked(monkeypatch):
    """Autocorrelations that the method is asked for, which then ends the command."""
    found = set()

    def on(slopes, material, orders, autocorrelation):
        found.add(autocorrelation)
        raise click.ClickException("that is enough")

    monkeypatch.setattr(WalkMemory, "on", on)
    return found


SWEPT = "evaluate", "furnace", "compare"


@pytest.mark.parametrize("command", [*SWEPT, "tradeoff", *(f"sweep {name}" for name in SWEPT)])
def test_methods_remember_the_surface_that_is_meant(command, tmp_path, asked):
    more = [] if command.endswith(("evaluate", "furnace")) else COARSE
    words = [*command.split(), *FEW, *more, "--method", "walk-memory"]
    result = msbsdf(*words, "--autocorrelation", "exponential", "--out", tmp_path / "r")
    assert "no effect" not in result.stderr
    assert asked == {"exponential"}


def test_a_report_of_surfaces_says_what_methods_remember(tmp_path, asked):
    of = "--autocorrelation", "exponential", "--out", tmp_path / "s"
    assert msbsdf("simulate", *FEW, *COARSE, *of).returncode == 0
    msbsdf("compare", tmp_path / "s", "--method", "walk-memory", "--out", tmp_path / "c")
    assert asked == {"exponential"}


@pytest.mark.parametrize("command", ["evaluate", "furnace", "sweep evaluate", "sweep furnace"])
def test_an_autocorrelation_that_nothing_remembers_is_told(command, tmp_path):
    words = [*FEW, "--method", "single", "--autocorrelation", "exponential"]
    result = msbsdf(*command.split(), *words, "--out", tmp_path / "e")
    assert "--autocorrelation has no effect" in result.stderr


def test_what_remembers_nothing_is_the_same_numbers_on_any_surface(tmp_path):
    found = []
    for kind in "gaussian", "exponential":
        words = [*FEW, "--points", "8", "--method", "walk", "--autocorrelation", kind]
        assert msbsdf("sweep", "evaluate", *words, "--out", tmp_path / kind).returncode == 0
        found.append(table(tmp_path / kind / "sweep.csv"))
    assert found[0] == found[1]


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
        (["evaluate", "--method", "walk-memory", "--slopes", "ggx"], "beckmann"),
    ],
)
def test_what_it_is_not_for_is_refused(words, says):
    assert says in refused(*words)
