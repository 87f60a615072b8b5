"""What takes long is said beforehand, with what makes it long."""

import pytest
from command_line import msbsdf

from msbsdf_cli.cli.common import duration, facet_warnings, long_warnings, solve_warnings
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.materials import Conductor, Dielectric

FEW = ("--samples", 64, "--theta", 0.5, "--quiet", "--threads", 1)
ROUGH = ("--alpha", 40, "--material", "conductor", *FEW)


@pytest.mark.parametrize(
    "words",
    [
        ("walk", *ROUGH),
        ("evaluate", "--method", "walk", "--points", 4, *ROUGH),
        ("furnace", "--method", "walk", *ROUGH),
    ],
    ids=lambda words: words[0],
)
def test_many_facets_are_told_of(words, tmp_path):
    result = msbsdf(*words, "--out", tmp_path / "report")
    assert result.returncode == 0, result.stderr
    assert "facets in the mean at roughness 40,40" in result.stderr


def test_methods_of_compare_and_tradeoff_are_told_of(tmp_path, monkeypatch):
    # Before anything is run: the first thing that a run does ends it.
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("msbsdf_cli.cli.compare.simulated_run", stop)
    monkeypatch.setattr("msbsdf_cli.experiments.tradeoff.study.study", stop)
    for command in (("compare", "--method", "walk"), ("tradeoff", "--method", "walk")):
        words = [w for w in ROUGH if command[0] != "tradeoff" or w not in ("--theta", 0.5)]
        result = msbsdf(*command, *words, "--out", tmp_path / command[0])
        assert result.returncode != 0
        assert "facets in the mean at roughness 40,40" in result.stderr, result.stderr


def test_a_long_run_says_for_what():
    options = {"threads": 2, "samples": 1e9}
    assert long_warnings(options, 119, "1e+09 walks") == []
    (said,) = long_warnings(options, 400, "1e+09 walks")
    assert said == "this will take about 3 minutes, for 1e+09 walks; fewer --samples take less."
    (said,) = long_warnings(options | {"realisations": 3}, 400, "3 surfaces")
    assert "a coarser --accuracy" in said


def test_an_index_near_one_at_grazing_incidence_is_told_of():
    near = Scene(Dielectric(1 + 1e-6), Beckmann(0.5, 0.5), (1.57,))
    (said,) = facet_warnings(near)
    assert "facets in the mean" in said
    assert facet_warnings(Scene(Conductor(), Beckmann(0.5, 0.5), (1.57,))) == []


def test_solve_says_beforehand_that_it_takes_long():
    smooth = Scene(Conductor(), Beckmann(0.005, 0.005), (0.5,))
    (said,) = solve_warnings(smooth, ("walk", "solve"))
    assert "method solve needs about" in said
    assert solve_warnings(smooth, ("walk",)) == []
    assert solve_warnings(smooth.of_roughness((0.5, 0.5)), ("solve",)) == []


def test_durations_are_words():
    assert [duration(s) for s in (75, 600, 10_000, 400_000)] == [
        *("75 seconds", "10 minutes", "2.8 hours", "4.63 days")
    ]
