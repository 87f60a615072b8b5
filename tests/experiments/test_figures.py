"""Figures of the papers: their numbers against closed forms, their pictures from tables alone."""

import csv
import math

import numpy as np
import pytest
from command_line import msbsdf, refused
from scipy.integrate import dblquad
from scipy.special import erfc
from scipy.stats import norm

from msbsdf_cli.experiments.figures import (
    areas,
    claims,
    free_paths,
    lobes,
    one_walk,
    reciprocity,
    sequences,
)
from msbsdf_cli.experiments.figures.catalogue import FIGURES
from msbsdf_cli.experiments.figures.settings import Settings
from msbsdf_cli.experiments.walk import walk as one_direction
from msbsdf_cli.experiments.walks import walk
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.model import Smith
from msbsdf_cli.plots import style
from msbsdf_cli.plots.figures import draw
from msbsdf_cli.plots.figures.lobes import lobes_from
from msbsdf_cli.plots.figures.rows import where
from msbsdf_cli.results.files import read_csv, write_csv
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.tables import energy, lobe
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.smith.heights import Gaussian
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.statistics.tally import sequence_names
from surfaces.materials import Conductor, Dielectric

DRAFT = Settings(quick=True)


def big_lambda(theta):
    """Smith's Lambda of Beckmann slopes of roughness 1, as textbooks have it."""
    a = 1 / math.tan(theta)
    return (math.exp(-a * a) / (a * math.sqrt(math.pi)) - erfc(a)) / 2


@pytest.mark.parametrize("theta", [0.5, 1.4, 2.0])
def test_extinction_is_the_projected_area_over_the_height_distribution(theta):
    """Figure 7 against Eq. 24 with the projected area of Eq. 20 integrated over slopes."""
    x, _, z = direction(theta)

    def facing(p, _):
        # A facet of slope p along x faces against the ray by p x - z, over its mean-plane area;
        # the slope across has been integrated out.
        return max(p * x - z, 0) * math.exp(-p * p) / math.sqrt(math.pi)

    sigma = dblquad(facing, 0, 1, z / x if z > 0 else -8, 8, epsabs=1e-10)[0]
    h = np.array([-1.5, 0.0, 2.0])
    expected = sigma * norm.pdf(h) / norm.cdf(h)
    found = areas.extinction(Beckmann(1.0, 1.0), theta, h)
    assert found == pytest.approx(expected, rel=1e-6)


def test_light_lost_on_surfaces_is_told_from_shares():
    """Shares of an exponential extinction give it back, and its error from their scatter."""
    rate = 0.3
    edges = np.concatenate([[areas.EDGES[0] - 1], areas.EDGES])
    share = np.exp(-rate * (edges - edges[0]))
    one = np.append(-np.diff(share), share[-1])
    shares = np.array([one * w for w in (0.9, 1.1, 1.0, 1.0)])
    rows = areas._lost(0.5, shares)
    assert [r[3] for r in rows] == pytest.approx([rate * math.cos(0.5)] * len(rows))
    assert [r[4] for r in rows] == pytest.approx([0.0] * len(rows), abs=1e-12)
    shares[0, -5] *= 1.5
    assert max(r[4] for r in areas._lost(0.5, shares)) > 1e-3


def test_masking_over_the_sphere_meets_its_integral():
    """Figure 2 of the second paper: above, G1 of GGX in closed form; below, the same formula."""
    table = where(areas.wang_2(DRAFT)["wang_2"], slopes="ggx")
    assert table["quadrature"] == pytest.approx(table["closed_form"], rel=1e-6)
    theta = table["theta_rad"]
    root = np.sqrt(1 + np.tan(theta) ** 2)
    lambda_ = (np.where(theta < np.pi / 2, 1, -1) * root - 1) / 2
    assert table["closed_form"] == pytest.approx(np.abs(1 / (1 + lambda_)), rel=1e-9)


@pytest.mark.parametrize(("theta", "start"), [(0.5, -1.0), (1.2, 0.0), (2.0, 1.0)])
def test_the_free_path_density_is_that_of_heitz(theta, start):
    """Eq. 25 with Lambda and C1 as textbooks have them; all of it sums to 1."""
    found = free_paths.free_path_density(theta, start)
    assert found.sum() == pytest.approx(1)
    if theta < np.pi / 2:
        assert found[-1] == pytest.approx(norm.cdf(start) ** big_lambda(theta), rel=1e-9)
        bin_ = int(np.searchsorted(Gaussian.edges, start + 0.3)) - 1
        low, high = (
            (norm.cdf(start) / norm.cdf(h)) ** big_lambda(theta)
            for h in Gaussian.edges[bin_ : bin_ + 2]
        )
        assert found[bin_] == pytest.approx(low - high, rel=1e-9)
    else:
        assert found[-1] == 0
        assert found[:-1][Gaussian.edges[:-1] >= start].sum() == 0


def test_one_walk_goes_where_its_directions_say():
    tables = one_walk.heitz_10(DRAFT)
    walk_, mean = (where(tables[name]) for name in ("heitz_10", "heitz_10_mean"))
    assert walk_["facet"].tolist() == [1, 2, 3, 4, 5]
    assert walk_["theta_r_rad"][0] == pytest.approx(np.pi - one_walk.THETA)
    up = np.cos(walk_["theta_r_rad"][1:]) > 0
    assert (np.diff(walk_["height"]) > 0).tolist() == up.tolist()
    assert (np.diff(walk_["energy"]) < 0).all()
    assert mean["share"][0] == 1
    # Heights of first facets are those that light from there sees: G1 of the heights below it.
    h = np.linspace(-6, 6, 20001)
    seen = norm.pdf(h) * norm.cdf(h) ** big_lambda(one_walk.THETA)
    expected = (h * seen).sum() / seen.sum()
    assert mean["height"][0] == pytest.approx(expected, abs=4 * mean["height_stderr"][0])


def test_sequences_sum_to_the_light_and_begin_with_single_scattering(monkeypatch):
    monkeypatch.setattr(sequences, "plan", lambda *_: sequences.Resolution(4, 8, 4))
    monkeypatch.setattr(sequences, "SCENES", sequences.SCENES[1:])
    tables = sequences.heitz_sequences(DRAFT)
    energies = tables["heitz_sequences_energy"]
    for source in ("walk", "surfaces"):
        # Some paths of coarse meshes leak.
        assert where(energies, source=source)["energy"].sum() == pytest.approx(1, abs=1e-3)
    solved = Solve(Beckmann(1.0, 1.0), Dielectric(1 / 1.5), 2).energy(direction(1.0))
    sums = {"R": solved.reflected[0, 0], "T": solved.transmitted[0, 0]}
    for name, expected in sums.items():
        row = where(energies, source="walk", sequence=name)
        assert row["energy"][0] == pytest.approx(float(expected), abs=4 * row["stderr"][0])
    second = [where(energies, source="walk", sequence=n) for n in ("RR", "TT")]
    total, error = (sum(r[c][0] for r in second) for c in ("energy", "stderr"))
    assert total == pytest.approx(float(solved.reflected[0, 1]), abs=4 * error)
    # All histories against the tally of walks, which names them by itself.
    model = Smith(Beckmann(1.0, 1.0), Dielectric(1 / 1.5))
    tallied = one_direction(model, direction(1.0), 400_000, seed=7, orders=3).estimate("sequence")
    for code, name in enumerate(sequence_names(3)):
        row = where(energies, source="walk", sequence=name)
        if name in sequences.SEQUENCES:
            side = sequences.side_of(name)
            spread = math.hypot(row["stderr"][0], tallied.stderr[code, side])
            assert row["energy"][0] == pytest.approx(tallied.value[code, side], abs=5 * spread)
    part = where(tables["heitz_sequences"], source="walk", sequence="TT")
    assert (part["density_per_sr"] * part["solid_angle_sr"]).sum() == pytest.approx(
        second[1]["energy"][0]
    )


def test_only_the_uncorrelated_model_keeps_its_picture_when_ends_are_swapped():
    table = reciprocity.wang_16(DRAFT)["wang_16"]
    z = {}
    for method in lobes.MODELS:
        rows = where(table, method=method)
        z[method] = rows["difference"].mean() / (
            np.sqrt((rows["stderr"] ** 2).sum()) / rows["stderr"].size
        )
    assert abs(z["position-free-uncorrelated"]) < 4
    assert abs(z["position-free-correlated"]) > 8


def test_a_claim_is_judged_by_its_error_bar():
    assert claims._judged(0.004, 0.002, 0.01) == "holds"
    assert claims._judged(-0.02, 0.002, 0.01) == "does not hold"
    assert claims._judged(0.009, 0.002, 0.01) == "not comparable"


def few_walks(scene, settings):
    """Two walks, one of which stands in for light on surfaces."""
    none = FreePaths((), (), Gaussian.edges)
    for name, seed in (("simulate", 0), ("walk", 1)):
        run = walk(scene, 20_000, none, "gaussian", seed, 1, "float64", 100, True)
        run.kind = name
        yield run.lobes()


def test_lobes_come_back_from_their_tables():
    scene = Scene(Dielectric(1.5), Beckmann(0.4, 0.4), (1.0,), orders=3)
    light = next(few_walks(scene, DRAFT))
    back = lobes_from(lobe(light), energy(light))
    assert back.density == pytest.approx(light.density, rel=1e-6)
    assert back.energy.value == pytest.approx(light.energy.value)
    assert back.energy.stderr == pytest.approx(light.energy.stderr)
    assert back.sides == light.sides


def test_pictures_are_drawn_from_their_tables_alone(tmp_path, monkeypatch):
    """Every value of a table has its error bar, and the same table gives the same bytes."""
    scene = Scene(Conductor(), Ggx(1.0, 1.0), (0.5,), orders=3)
    monkeypatch.setattr(style, "DOTS_PER_INCH", 20)
    monkeypatch.setattr(lobes, "atlas", lambda: [(10, scene)])
    monkeypatch.setattr(lobes, "traced_and_walked", few_walks)
    drawn = ("heitz-10", "heitz-13", "heitz-15", "heitz-18", "wang-4-15", "wang-16")
    out = tmp_path / "figures"
    words = ("figures", *drawn, "--quick", "--quiet", "--threads", "1", "--out", out)
    result = msbsdf(*words, pictures=True)
    assert result.returncode == 0, result.stderr
    assert (out / "index.html").exists()
    tables = {p.stem: p for p in out.glob("*.csv")}
    again = tmp_path / "again"
    again.mkdir()
    for name in drawn:
        stem = name.replace("-", "_")
        mine = [t for t in tables if t.startswith(stem) or (stem == "wang_4_15" and t == "wang_10")]
        for table in mine:
            (again / f"{table}.csv").write_bytes(tables[table].read_bytes())
            with open(tables[table], newline="", encoding="utf-8") as file:
                header = next(csv.reader(file))
            exact = {"heitz_13", "heitz_10"}
            assert table in exact or any("stderr" in column for column in header)
        draw(name, tuple(mine), again)
    pictures = sorted(p.name for p in out.glob("*.png"))
    assert pictures == sorted(p.name for p in again.glob("*.png"))
    assert len(pictures) == len(drawn) + 1
    for name in pictures:
        assert (out / name).read_bytes() == (again / name).read_bytes(), name


def test_a_table_comes_back_from_its_file(tmp_path):
    table = {"name": ["a", "b"], "x": [0.1, math.inf], "n": [1.0, 2.0]}
    write_csv(tmp_path / "t.csv", table)
    assert read_csv(tmp_path / "t.csv") == table


def test_figures_are_listed_with_the_command_that_makes_them():
    said = msbsdf("figures", "--list").stdout
    for name, figure in FIGURES.items():
        assert f"msbsdf figures {name}\n" in said
        assert figure.says in said
    assert "heitz-99" in refused("figures", "heitz-99")
    assert "--gallery" in refused("figures", "compare")
    assert "--all" in refused("figures", "heitz-7", "--all")
    assert "no folder" in refused("figures", "--gallery", "heitz-7")
