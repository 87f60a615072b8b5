"""A sweep's pieces add up to what one long run gives."""

from dataclasses import replace

import numpy as np
import pytest

from msbsdf_cli import HeightField
from msbsdf_cli.experiments import furnace, realisations, walks
from msbsdf_cli.experiments.evaluate import evaluate
from msbsdf_cli.experiments.fitted_walks import models_of, walks_on
from msbsdf_cli.experiments.method_lobes import method_lobes
from msbsdf_cli.experiments.own_surface import simulate_surface
from msbsdf_cli.experiments.random_surfaces import Resolution
from msbsdf_cli.experiments.slices import slice_directions
from msbsdf_cli.experiments.sweep.albedos import AlbedoCase
from msbsdf_cli.experiments.sweep.files import FileCase, Source, digest_of, own_slopes
from msbsdf_cli.experiments.sweep.fitted import FittedCase, RandomFacets
from msbsdf_cli.experiments.sweep.methods import MethodCase
from msbsdf_cli.experiments.sweep.plan import Axis, Cases
from msbsdf_cli.experiments.sweep.states import total
from msbsdf_cli.experiments.sweep.surfaces import SurfaceCase
from msbsdf_cli.experiments.sweep.sweep import Sweep
from msbsdf_cli.experiments.sweep.values import ValueCase
from msbsdf_cli.experiments.sweep.walks import WalkCase
from msbsdf_cli.experiments.sweep.work import Alone, Failure, seed_of
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import load_run
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann, Ggx, _visible_cells
from surfaces.materials import Conductor, Dielectric

PATHS = FreePaths((0.5, 2.0), (0.0, np.inf), np.linspace(-4, 4, 9))
COARSE = Resolution(cells=8, extent=6, realisations=10)
GLASS = Scene(Dielectric(1.5), Beckmann(0.7, 0.4), (1.0,), 0.3)
ROUNDING = 1e-12
"""Sums of the same numbers in another order."""


def close(a, b, scale=1.0):
    np.testing.assert_allclose(a, b, rtol=1e-9, atol=ROUNDING * scale)


def same_estimates(a, b):
    """Estimates and errors to rounding; an error from a difference of squares keeps half of the
    digits."""
    for name in ("energy", "side", "moments", "lobe", "sequence", "absorbed", "unresolved"):
        mine, other = a.estimate(name), b.estimate(name)
        np.testing.assert_allclose(mine.value, other.value, rtol=1e-9, atol=1e-13)
        np.testing.assert_allclose(mine.stderr, other.stderr, rtol=1e-6, atol=1e-10)


def surfaces(scene, directions=True, place=0, seed=3):
    return SurfaceCase(scene, 3000, COARSE, PATHS, seed, place, 1000, directions)


def measured(case):
    parts = [type(case).measure([case], part)[0] for part in range(case.parts)]
    # In whatever order they end.
    return total(reversed(parts))


def test_parts_of_surfaces_add_up_to_one_simulation():
    case = surfaces(GLASS)
    assert case.parts == 3
    rays = case.rays * COARSE.realisations
    whole = realisations.simulate(GLASS, rays, COARSE, PATHS, 3, 1, 1000, quiet=True)
    found = case.run(measured(case))
    same_estimates(found.tallies[0], whole.tallies[0])
    close(found.free_paths.estimate().value, whole.free_paths.estimate().value)
    close(found.free_paths.estimate().stderr, whole.free_paths.estimate().stderr)
    np.testing.assert_allclose(found.lobe_groups, whole.lobe_groups, rtol=1e-6)


def test_parts_of_a_file_add_up_to_one_simulation(tmp_path):
    field, path = HeightField.random(0.6, extent=6, cells=6), tmp_path / "scan.npy"
    np.save(path, field.heights)
    source = Source(str(path), digest_of(str(path)), field.step, None, True, 1, None)
    scene = Scene(Conductor(), own_slopes(source), (1.0,))
    case = FileCase.of(scene, source, 800, 5, 1000, directions=True)
    none = FreePaths((), (), np.array([-np.inf, np.inf]))
    whole = simulate_surface(scene, source.field(), 800, none, 5, 1, 1000, quiet=True)
    found = case.run(measured(case))
    same_estimates(found.tallies[0], whole.tallies[0])
    np.testing.assert_allclose(found.lobe_groups, whole.lobe_groups, rtol=1e-6)
    np.save(path, field.heights + 1)
    with pytest.raises(ValueError, match="not the file with which"):
        replace(source, detrend=2).field()


def test_fitted_walks_are_those_of_a_comparison_in_parts_and_seeds_add_up(monkeypatch):
    # Tables of counted slopes that are made in no time, at a few more rejections.
    monkeypatch.setattr(_visible_cells, "POLAR_BINS", 8)
    monkeypatch.setattr(_visible_cells, "AZIMUTH_BINS", 16)
    ridges = replace(COARSE, cells=6, realisations=8, heights_of="ridges:1")
    scene = Scene(Conductor(), Beckmann(0.5, 0.5), (1.0,))
    states, wholes = [], []
    for seed in (1, 2):
        facets = RandomFacets(ridges, seed)
        case = FittedCase(scene, facets, "ggx", None, 1600, seed, "float64", 1000)
        states.append(measured(case))
        models = models_of(facets.slopes(scene))
        wholes.append(walks_on(scene, models, 1600, seed, 1, "float64", 1000, True))
    walks, judged = case.walks(total(states))
    assert judged == "ggx"
    for name, split in walks.items():
        one, other = (whole[name] for whole in wholes)
        close(split.value, (one.value + other.value) / 2)
        close(split.pieces, (one.pieces + other.pieces) / 2)
        close(split.stderr, np.hypot(one.stderr, other.stderr) / 2)
        assert split.paths == 3200


def test_lobes_of_methods_have_less_noise_from_more_seeds_and_solutions_the_same_error():
    scene = Scene(Conductor(), Beckmann(0.7, 0.7), (1.0,))
    names = "walk", "solve"
    cases = [MethodCase(scene, names, 40_000, seed, "float64") for seed in (1, 2)]
    found = cases[0].lobes(total(map(measured, cases)))
    for name, both in zip(names, found, strict=True):
        one, other = (
            method_lobes(scene, (name,), 40_000, s, 1, "float64", True)[0] for s in (1, 2)
        )
        close(both.energy.value, (one.energy.value + other.energy.value) / 2)
        expected = np.hypot(one.bins.stderr, other.bins.stderr) / 2
        close(both.bins.stderr, one.bins.stderr if name == "solve" else expected)


def test_energies_alone_are_those_of_the_whole():
    lobes, alone = (measured(surfaces(GLASS, directions)) for directions in (True, False))
    assert sum(a.nbytes for a in alone.values()) < 0.02 * sum(a.nbytes for a in lobes.values())
    a = surfaces(GLASS, True).run(lobes).tallies[0]
    b = surfaces(GLASS, False).run(alone).tallies[0]
    for name in ("energy", "side", "absorbed", "unresolved"):
        close(a.estimate(name).value, b.estimate(name).value)
        close(a.estimate(name).stderr, b.estimate(name).stderr)


def test_cases_share_the_surfaces_and_not_the_rays():
    rough, smooth = (
        surfaces(Scene(Conductor(), Beckmann(a, a), (1.0,)), place=i)
        for i, a in enumerate((1.0, 0.5))
    )
    together = SurfaceCase.measure([rough, smooth], 0)
    for case, state in zip((rough, smooth), together, strict=True):
        (alone,) = SurfaceCase.measure([case], 0)
        for name in alone:
            np.testing.assert_array_equal(state[name], alone[name])
    elsewhere = SurfaceCase.measure([surfaces(rough.scene, place=1)], 0)[0]
    # Of one surface, so near; by other rays, so not the same.
    first = [state["sums"][0, 0] for state in (together[0], elsewhere)]
    assert 0 < abs(first[0] - first[1]) < 0.05 * first[0]


def test_walks_of_a_part_are_those_of_a_long_walk(monkeypatch):
    monkeypatch.setattr("msbsdf_cli.experiments.walk.WALKS", 2000)
    monkeypatch.setattr("msbsdf_cli.experiments.sweep.walks.WALKS", 2000)
    monkeypatch.setattr("msbsdf_cli.experiments.sweep.walks.JOBS", 2)
    case = WalkCase(GLASS, 11_000, PATHS, "gaussian", 5, "float64", 1000, True)
    assert case.parts == 3
    whole = walks.walk(GLASS, 11_000, PATHS, "gaussian", 5, 1, "float64", 1000, quiet=True)
    found = case.run(measured(case))
    same_estimates(found.tallies[0], whole.tallies[0])
    close(found.free_paths.estimate().value, whole.free_paths.estimate().value)


@pytest.mark.parametrize("samples", [1, 500])
def test_values_add_up_to_those_of_evaluate(samples):
    scene = Scene(Conductor(), Ggx(0.6, 0.6), (0.8,))
    slice_ = slice_directions(scene, None, 6)
    methods = "walk", "solve"
    case = ValueCase(scene, methods, slice_, samples, 4, "float64", False)
    table = Alone(case).table({case.kind: measured(case)})
    wanted = evaluate(scene, methods, slice_.wo, samples, 4, 1, "float64", quiet=True)
    close(table["value_per_sr"], np.concatenate([v.value.ravel() for v in wanted]))
    found = np.array(table["stderr_per_sr"])
    np.testing.assert_allclose(found, np.concatenate([v.stderr.ravel() for v in wanted]), 1e-6)


def test_albedos_add_up_to_those_of_furnace():
    scene = Scene(Conductor(), Ggx(0.6, 0.3), (0.3, 1.2))
    cases = [
        AlbedoCase(Scene(scene.material, scene.slopes, (theta,)), ("walk", "solve"), 64, 4, None)
        for theta in scene.theta
    ]
    parts = [AlbedoCase.measure(cases, part) for part in range(2)]
    (wanted,) = furnace.furnace(scene, ((0.6, 0.3),), ("solve",), 64, 4, None, 1, quiet=True)
    walked, solved = furnace.furnace(
        scene, ((0.6, 0.3),), ("walk", "solve"), 64, 4, None, 1, quiet=True
    )
    for i, case in enumerate(cases):
        table = case.table(total([parts[0][i], parts[1][i]]))
        both = (walked, solved)
        for column, name in (("albedo", "value"), ("stderr", "stderr")):
            close(table[column], np.concatenate([getattr(r, name)[:, i].ravel() for r in both]))
    close(wanted.value, solved.value)


def test_merged_seeds_are_one_run_of_all_their_surfaces(tmp_path):
    """From the reports' own files, against one tally that took every surface in."""
    scene, few = Scene(Conductor(), Beckmann(0.8, 0.8), (0.0, 1.0)), Resolution(8, 6, 3)
    whole = realisations.simulate(scene, 3000, few, PATHS, 0, 1, 1000, quiet=True)
    for seed in range(8):
        run = realisations.simulate(scene, 3000, few, PATHS, seed, 1, 1000, quiet=True)
        run.save(tmp_path / f"{seed}.npz")
        for number in range(3 if seed else 0):
            job = realisations.SurfaceJob(
                *(scene, few, number, 1000, PATHS.theta, PATHS.starts, tuple(PATHS.edges), seed),
                1000,
                tuple(realisations.expected(scene.slopes, scene.wi(t)) for t in scene.theta),
                on_all_meshes=True,
            )
            for tally, light in zip(
                whole.tallies, realisations.trace_surface(job).light, strict=True
            ):
                tally.add_surface(light)
    merged = load_run(tmp_path / "0.npz")
    for seed in range(1, 8):
        merged.merge(load_run(tmp_path / f"{seed}.npz"))
    assert merged.tallies[0].units == 24
    assert merged.group_units.sum() == 24
    for mine, other in zip(merged.tallies, whole.tallies, strict=True):
        same_estimates(mine, other)


AXES = Cases((Axis("a", (1, 2), (1, 2)), Axis("b", "xyz", ("x", "y", "z"))))


def test_cases_are_numbered_and_grouped_by_what_they_do_not_share():
    assert [AXES.labels(i) for i in (0, 1, 5)] == [[1, "x"], [1, "y"], [2, "z"]]
    assert list(AXES.groups(frozenset("b"))) == [[0, 1, 2], [3, 4, 5]]
    assert list(AXES.groups(frozenset("a"))) == [[0, 3], [1, 4], [2, 5]]
    assert list(AXES.groups(frozenset("ab"))) == [[0, 1, 2, 3, 4, 5]]
    assert list(Cases(()).groups(frozenset("a"))) == [[0]]


def test_pieces_have_numbers_of_their_own_and_failed_cases_none():
    def setting(case, seed):
        if case == 4:
            return Failure("it cannot be")
        scene = Scene(Conductor(), Beckmann(0.5, 0.5), (0.1 * case,))
        return Alone(WalkCase(scene, 10, PATHS, "gaussian", seed, "float64", 100, False))

    sweep = Sweep(AXES, (0, 7), (WalkCase,), setting)
    pieces = list(sweep.pieces())
    assert [(p.seed, p.number) for p in pieces] == [(s, k) for s in (0, 7) for k in range(5)]
    done = {(p.seed, p.number): p.do() for p in pieces[:-1]}
    rows = list(sweep.rows(lambda p: done.get((p.seed, p.number)), together=False))
    assert [(case, seed) for case, seed, _ in rows] == [
        (case, seed) for case in range(6) for seed in (0, 7) if (case, seed) != (5, 7)
    ]
    assert [table.reason for _, _, table in rows if isinstance(table, Failure)] == [
        "it cannot be"
    ] * 2


def test_seeds_of_pieces_do_not_meet():
    seeds = {seed_of(seed, f"piece {k}") for seed in (0, 1) for k in range(5000)}
    assert len(seeds) == 10_000
    assert max(seeds) < 1 << 62
