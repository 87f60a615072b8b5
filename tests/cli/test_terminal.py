"""What commands print: sentences first, tables that fit, angles in degrees, help."""

import json
import math
import re
import shlex
from importlib import import_module

import click
import numpy as np
import pytest
from click.shell_completion import ShellComplete
from command_line import msbsdf, refused, table

from msbsdf_cli.cli import COMMANDS, group, terminal
from msbsdf_cli.cli.help import EXAMPLES, GROUPS
from msbsdf_cli.cli.terminal import in_percent, show_table
from surfaces.facet import fresnel_dielectric

WALK = ["walk", "--theta", "0.5,80deg", "--samples", "2e4", "--free-path-theta", 1]
WALK += ["--free-path-height", 0]


@pytest.mark.parametrize("width", [80, 120])
def test_tables_fit_and_say_what_is_left_out(width, monkeypatch, capsys):
    monkeypatch.setattr(terminal, "screen", lambda: (width, 24))
    header = ["method", *(f"a column {k}" for k in range(12))]
    show_table(header, [[f"row{i}", *["0.4692(7)"] * 12] for i in range(40)], "all.csv", 100)
    *lines, last = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= width
    rows = [line for line in lines if line.startswith("row")]
    assert len(rows) == 24 - terminal.AROUND
    columns = lines[0].count("column")
    # The width is used up: one more column would not have fitted.
    assert len(lines[0].rstrip()) + 2 + len("a column 10") > width
    left = ", ".join(f"a column {k}" for k in range(columns, 12))
    assert last == f"{100 - len(rows)} more in all.csv, with {left}."


def test_without_a_terminal_a_line_has_100_columns(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "300")
    show_table(["x"] * 60, [["1234"] * 60], "all.csv")
    assert 90 < len(capsys.readouterr().out.splitlines()[0]) <= 100


def test_percent_has_the_digits_of_its_error():
    assert in_percent(0.469201, 0.0004) == "46.92(4) %"
    assert in_percent(0.1032718, 1e-9) == "10.3 %"
    assert in_percent(3e-12, 1e-12) == "0 %"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--theta", "45"], "Is it 45deg?"),
        (["--theta", "30,200"], "200deg"),
        (["--theta", "90deg"], "meets nothing"),
        (["--theta", "150deg"], "nothing is inside of --material conductor"),
        (["--theta", "1,150deg", "--material", "dielectric"], "each side by itself"),
    ],
)
def test_angles_that_cannot_be_are_explained(words, said, tmp_path):
    sentence = refused("walk", *words, "--out", tmp_path / "r")
    assert (said in sentence) == (said != "200deg")


def test_verdict_first_then_degrees(tmp_path):
    out = tmp_path / "r"
    result = msbsdf(*WALK, "--out", out)
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    summary = json.loads((out / "run.json").read_text())["summary"]
    assert lines[0] == summary
    assert "28.65°" in summary
    assert "80°" in summary
    assert lines[-1] == f"Report: {out}"
    assert re.fullmatch(r"walk: 4e\+04 walks in [0-9.e-]+ s\.", result.stderr.strip())
    # The shares of the sentence are sums over rows of energy.csv.
    for theta, name in ((0.5, "28.65°"), (math.radians(80), "80°")):
        rows = [r for r in table(out / "energy.csv") if float(r["theta_i_rad"]) == theta]
        once = next(r for r in rows if r["order"] == "1")
        of = in_percent(float(once["energy"]), float(once["stderr"]))
        assert re.search(rf"{name} {re.escape(of)}", summary), summary
        # What does not leave after one bounce leaves later, and is known as well.
        more = 1 - float(once["energy"])
        assert in_percent(more, float(once["stderr"])) in summary


def test_light_from_inside_glass(tmp_path):
    """Almost smooth, energies are those of Fresnel's equations; a rough surface seen from below is
    one of the inverse index seen from above."""
    few = ["--material", "dielectric", "--samples", "2e4", "--json"]
    angles = "150deg,120deg,180deg"
    result = msbsdf("walk", *few, "--alpha", "1e-4", "--theta", angles, "--out", tmp_path / "a")
    assert result.returncode == 0, result.stderr
    record = json.loads(result.stdout)
    for entry, theta in zip(record["energies"], (150, 120, 180), strict=True):
        assert entry["theta_i_rad"] == math.radians(theta)
        cos = np.array([-math.cos(math.radians(theta))])
        fresnel = float(fresnel_dielectric(cos, 1 / 1.5)[0][0])
        assert abs(entry["reflected"] - fresnel) <= 4 * entry["reflected_stderr"] + 1e-3
    assert record["options"]["ior"] == 1.5
    assert record["energies"][1]["reflected"] == pytest.approx(1, abs=1e-3)
    both = []
    for command, words in (
        ("simulate", ["--theta", "150deg", "--realisations", 6, "--extent", 8, "--cells", 8]),
        ("walk", ["--theta", "30deg", "--ior", 1 / 1.5]),
    ):
        words = [command, *words, *few, "--alpha", 0.5, "--out", tmp_path / command]
        result = msbsdf(*words)
        assert result.returncode == 0, result.stderr
        both.append(json.loads(result.stdout)["energies"][0])
    apart = both[0]["reflected"] - both[1]["reflected"]
    # The model itself is off by up to .01 from a surface of roughness 0.5.
    assert abs(apart) <= 4 * math.hypot(*(e["reflected_stderr"] for e in both)) + 0.01
    # Seen from above it would be a third of that.
    assert both[0]["reflected"] > 0.25


def test_skewed_surfaces_are_not_turned_over(tmp_path):
    words = ["--heights-of", "ridges", "--material", "dielectric", "--theta", "150deg"]
    assert "turn it over" in refused("simulate", *words, "--out", tmp_path / "r")


def test_how_wrong_single_scattering_is(tmp_path):
    words = ["evaluate", "--method", "single,walk,solve", "--metal", "gold", "--rgb"]
    words += ["--slopes", "ggx", "--alpha", 0.6, "--theta", "1", "--samples", "2e4"]
    result = msbsdf(*words, "--points", 12, "--out", tmp_path / "r")
    assert result.returncode == 0, result.stderr
    first = result.stdout.splitlines()[0]
    assert first.startswith("Against solve, of the light along the slice: single by ")
    values = table(tmp_path / "r" / "slice.csv")
    errors = table(tmp_path / "r" / "errors.csv")
    assert [row["method"] for row in errors] == ["single"] * 3 + ["walk"] * 3

    def column(method, channel):
        rows = (r for r in values if (r["method"], r["channel"]) == (method, channel))
        return np.array([float(r["value_per_sr"]) for r in rows if r["order"] == "all"])

    for row in errors[:3]:
        assert row["against"] == "solve"
        single, solved = (column(name, row["channel"]) for name in ("single", "solve"))
        wrong = np.abs(single - solved).sum() / solved.sum()
        assert float(row["error"]) == pytest.approx(wrong, rel=1e-6)
        assert in_percent(float(row["error"]), float(row["stderr"])) in result.stdout
        assert 0.1 < wrong < 0.4
    for row in errors[3:]:
        # The walk is the same model: what is left is noise.
        assert abs(float(row["error"])) <= 4 * float(row["stderr"])
        assert 0 < float(row["stderr"]) < 0.05
    # Red is kept by every bounce, blue is not, and the more are missed.
    assert float(errors[0]["error"]) > float(errors[2]["error"])


@pytest.mark.parametrize("form", ["png", "svg", "pdf"])
def test_pictures_of_any_format_are_in_the_page_alone(form, tmp_path):
    result = msbsdf(*WALK, "--format", form, "--threads", 1, "--out", tmp_path, pictures=True)
    assert result.returncode == 0, result.stderr
    assert [p.name for p in tmp_path.glob("lobes.*")] == [f"lobes.{form}"]
    page = (tmp_path / "index.html").read_text()
    assert "data:image/png;base64," in page
    assert f"<code>lobes.{form}</code>" in page


def test_names_of_methods_complete():
    completes = ShellComplete(group, {}, "msbsdf", "_MSBSDF_COMPLETE")

    def found(*words):
        return [item.value for item in completes.get_completions(list(words[:-1]), words[-1])]

    assert found("evaluate", "--method", "single,walk-l") == ["single,walk-low-variance"]
    assert "gold" in found("walk", "--metal", "g")
    assert found("tr") == ["tradeoff"]


@pytest.mark.parametrize("name", COMMANDS)
def test_examples_are_commands(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = import_module(f"msbsdf_cli.cli.{name}").command
    shown = command.get_help(click.Context(command, info_name=name))
    for example in EXAMPLES[name]:
        assert f"  msbsdf {example}\n" in f"{shown}\n"
        first, *words = shlex.split(example)
        assert first == name
        command.make_context(name, words)
    known = {name for names in GROUPS.values() for name in names}
    # What is in no group is the command's own, and few.
    own = [p.name for p in command.params if isinstance(p, click.Option) and p.name not in known]
    assert len(own) <= 5, own


def test_every_group_is_of_options_that_exist():
    commands = [import_module(f"msbsdf_cli.cli.{name}").command for name in COMMANDS]
    known = {str(p.name) for command in commands for p in command.params}
    assert known.issuperset(name for names in GROUPS.values() for name in names)
