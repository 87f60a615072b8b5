"""`msbsdf evaluate` and `msbsdf furnace` as a user meets them."""

import json

import numpy as np
import pytest
from command_line import msbsdf, refused, table

from msbsdf_cli.experiments.slices import slice_directions
from msbsdf_cli.methods.walk import Walk
from msbsdf_cli.plots.slices import draw_slices
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.materials import Conductor

CONTRACT = [
    *("method", "theta_i_rad", "phi_i_rad", "theta_o_rad", "phi_o_rad", "order"),
    *("value_per_sr", "stderr_per_sr"),
]
PLACE = CONTRACT[1:6]
ORDERS = ["1", "2", ">2", "all"]


def numbers(rows, name):
    return np.array([float(row[name]) for row in rows])


def rows_of(rows, **wanted):
    return [row for row in rows if all(row[k] == v for k, v in wanted.items())]


def test_a_slice_that_misses_the_light_says_so(tmp_path):
    """A mirror so smooth that nothing goes to any direction of the slice."""
    words = ["--alpha", "1e-4", "--theta", "0.5", "--points", 6, "--samples", 200, "--quiet"]
    out = tmp_path / "r"
    result = msbsdf("evaluate", *words, "--method", "walk,single", "--out", out)
    assert result.returncode == 0, result.stderr
    assert "theta 28.65° goes between the directions of the slice" in result.stderr
    assert not (out / "errors.csv").exists()


@pytest.mark.parametrize("material", ["conductor", "diffuse", "dielectric"])
def test_methods_agree_in_the_table(material, tmp_path):
    out = tmp_path / "report"
    methods = ["walk", "walk-low-variance", "solve"]
    words = ["--method", ",".join(methods), "--material", material, "--theta", "0.3,1.5"]
    words += ["--points", 6, "--samples", "2e4", "--orders", 2, "--out", out, "--json"]
    result = msbsdf("evaluate", *words, pictures=material == "dielectric")
    assert result.returncode == 0, result.stderr
    record = json.loads(result.stdout)
    assert [m["method"] for m in record["methods"]] == methods * 2
    assert all(m["unresolved"] < 1e-12 for m in record["methods"])
    if material == "dielectric":
        assert (out / "slice.png").stat().st_size > 10_000
    rows = table(out / "slice.csv")
    assert list(rows[0])[: len(CONTRACT)] == CONTRACT
    assert list(dict.fromkeys(row["order"] for row in rows)) == ORDERS
    known = rows_of(rows, method="solve")
    for method in methods[:2]:
        mine = rows_of(rows, method=method)
        assert [[r[k] for k in PLACE] for r in mine] == [[r[k] for k in PLACE] for r in known]
        off = numbers(mine, "value_per_sr") - numbers(known, "value_per_sr")
        stderr = np.hypot(numbers(mine, "stderr_per_sr"), numbers(known, "stderr_per_sr"))
        # Up to 96 values; the sums over orders have an error from 16 parts, which is beyond 5 once
        # in 6000. Where there is no noise, a table of a float32's digits.
        assert (np.abs(off) <= 5 * stderr + 1e-7 * numbers(known, "value_per_sr").max()).all()
    for order in rows_of(rows, order="all"):
        parts = [r for r in rows if all(r[k] == order[k] for k in ["method", *PLACE[:-1]])]
        total = numbers(parts, "value_per_sr")[:-1].sum()
        assert total == pytest.approx(float(order["value_per_sr"]), rel=1e-6)


def test_what_no_walk_has_found_counts_once_for_all_parts(tmp_path):
    # Hardly a walk of so smooth a surface meets more than four facets.
    words = ["--method", "walk", "--alpha", 0.1, "--theta", 0, "--points", 8]
    found = []
    for samples in (1600, 160000):
        out = tmp_path / str(samples)
        assert msbsdf("evaluate", *words, "--samples", samples, "--out", out).returncode == 0
        found.append(rows_of(table(out / "slice.csv"), order=">4"))
    few, many = (numbers(rows, "stderr_per_sr") for rows in found)
    assert (numbers(found[1], "value_per_sr") == 0).all()
    # The brightest of the paths tried, whose number is the same: 100 but for chance.
    assert np.median(few / many) == pytest.approx(100, rel=0.5)
    # As for one method that does all the walks; the brightest of 256 paths is brighter than that
    # of 16, but not by the 16 that counting it in every part would give.
    wo = slice_directions(Scene(Conductor(), Beckmann(0.1, 0.1), (0,), 0), None, 8).wo
    walk = Walk(Beckmann(0.1, 0.1), Conductor(), 4)
    alone = walk.undersampling(np.array([0.0, 0, 1]), wo, 1600, np.random.default_rng(1))[0]
    assert 0.5 < np.median(few / alone) < 4


def test_the_same_bytes_whatever_the_threads(tmp_path):
    for command, few in (("evaluate", ["--points", 6]), ("furnace", ["--alpha", 1])):
        # Spheres by solve, which have a table made, take longer than all the rest.
        methods = "walk,exact,solve" if command == "evaluate" else "walk,exact"
        words = [*few, "--theta", "1", "--samples", 640, "--method", methods]
        for threads in (1, 2):
            out = tmp_path / f"{command}{threads}"
            assert msbsdf(command, *words, "--threads", threads, "--out", out).returncode == 0
        name = {"evaluate": "slice.csv", "furnace": "furnace.csv"}[command]
        one, two = ((tmp_path / f"{command}{n}" / name).read_bytes() for n in (1, 2))
        assert one == two


def test_both_estimators_of_a_position_free_model(tmp_path):
    words = ["--method", "position-free-uncorrelated", "--theta", 1, "--points", 6]
    words += ["--alpha", 1, "--samples", "4e4"]
    values = []
    for flags in ([], ["--bidirectional"]):
        out = tmp_path / f"report{len(flags)}"
        assert msbsdf("evaluate", *words, *flags, "--out", out).returncode == 0
        rows = table(out / "slice.csv")
        values.append((numbers(rows, "value_per_sr"), numbers(rows, "stderr_per_sr")))
    (one, one_stderr), (two, two_stderr) = values
    assert (one != two).any()
    assert (np.abs(one - two) <= 5 * np.hypot(one_stderr, two_stderr) + 1e-12).all()


def test_energies_of_the_position_free_models(tmp_path, monkeypatch):
    spheres = "msbsdf_cli.experiments.white_sphere.white_spheres"
    monkeypatch.setattr(spheres, lambda *arguments: ([], []))
    out = tmp_path / "report"
    methods = ["walk", "position-free-uncorrelated", "position-free-correlated", "solve"]
    words = ["--method", ",".join(methods), "--alpha", 1, "--theta", "10deg", "--orders", 3]
    result = msbsdf(
        "furnace", *words, "--samples", "2e4", "--accuracy", "1e-6", "--out", out, "--json"
    )
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["warnings"] == []
    # Wang et al. 2022 and two independent programs; to the digits given.
    published = [[0.471, 0.448, 0.076], [0.471, 0.464, 0.062], [0.471, 0.477, 0.049]]
    rows = table(out / "furnace.csv")
    for method, expected in zip(methods, [*published, published[0]], strict=True):
        mine = rows_of(rows, method=method)
        assert [row["order"] for row in mine] == ["1", "2", "3", ">3", "all"]
        value, stderr = numbers(mine, "albedo"), numbers(mine, "stderr")
        assert (np.abs(value[:3] - expected) <= 4 * stderr[:3] + 0.0008).all()
        assert abs(value[4] - 1) <= 4 * stderr[4] + 1e-9
        assert value[:4].sum() == pytest.approx(value[4], abs=1e-6)
    assert (numbers(rows_of(rows, method="solve"), "stderr")[:4] <= 1e-6).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["evaluate", "--method", "exact", "--material", "dielectric"], "conductors and diffuse"),
        (["evaluate", "--method", "magic"], "magic"),
        (["evaluate", "--points", "1"], "--points"),
        (["furnace", "--accuracy", "0"], "--accuracy"),
        (["furnace", "--method", "energy-compensated", "--material", "diffuse"], "dielectrics"),
    ],
)
def test_what_a_method_cannot_do_is_refused(words, said, tmp_path):
    assert said in refused(*words, "--out", tmp_path / "report")
    assert not (tmp_path / "report").exists()


@pytest.mark.parametrize(
    "words",
    [["evaluate", "--bidirectional", "--points", 4], ["furnace", "--accuracy", 0.1, "--alpha", 1]],
)
def test_options_without_effect_are_said(words, tmp_path):
    words = [*words, "--method", "single", "--theta", 1, "--out", tmp_path / "report"]
    result = msbsdf(*words, pictures=True)
    assert f"{words[1]} has no effect" in result.stderr
    pictures = {"evaluate": ["slice"], "furnace": ["furnace", "sphere"]}[words[0]]
    for name in pictures:
        assert (tmp_path / "report" / f"{name}.png").stat().st_size > 10_000


@pytest.mark.parametrize("largest", [0.0, 5e-324, 1e-300, 1e300])
def test_slices_of_any_size_are_drawn(largest, tmp_path):
    theta = np.linspace(0, 1.5, 9)
    rows = {
        "method": ["walk"] * 9,
        "order": ["1"] * 9,
        "channel": ["all"] * 9,
        "theta_i_rad": [0.5] * 9,
        "theta_o_rad": theta,
        "phi_o_rad": np.zeros(9),
        "value_per_sr": largest * np.cos(theta),
        "stderr_per_sr": 0.1 * largest * np.cos(theta),
    }
    draw_slices(rows, tmp_path / "slice.png")
    assert (tmp_path / "slice.png").exists()
