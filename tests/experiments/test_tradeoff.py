"""The measures of the study, held against what is planted in synthetic data."""

import numpy as np
import pytest

from msbsdf_cli.experiments.figures import slab as figure_17
from msbsdf_cli.experiments.figures.slab import slab
from msbsdf_cli.experiments.random_surfaces import Resolution
from msbsdf_cli.experiments.tradeoff import counted
from msbsdf_cli.experiments.tradeoff import reference as module
from msbsdf_cli.experiments.tradeoff.directions import lobe_directions
from msbsdf_cli.experiments.tradeoff.energies import ONE, THREE, energy_rows
from msbsdf_cli.experiments.tradeoff.fits import pareto, slope
from msbsdf_cli.experiments.tradeoff.floors import floors, margin
from msbsdf_cli.experiments.tradeoff.measuring import Protocol, Setting, ladder, measure, timed
from msbsdf_cli.experiments.tradeoff.quasirandom import (
    DIMENSIONS,
    QuasiRandom,
    evaluate_quasirandom,
)
from msbsdf_cli.experiments.tradeoff.reference import MORE_WALKS, _by_walks, reference
from msbsdf_cli.experiments.tradeoff.roughness import FEW
from msbsdf_cli.experiments.tradeoff.rows import Row, method_rows
from msbsdf_cli.experiments.tradeoff.surface_reference import (
    SurfaceReference,
    distance,
    grouped_noise,
    own_noise,
    trace_surfaces,
)
from msbsdf_cli.experiments.tradeoff.time_to_accuracy import seconds_to, times_to_accuracy
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, merge_sides, merged_solid_angle
from msbsdf_cli.statistics.repetitions import accuracy, inner_products, taken_apart
from surfaces.materials import Conductor, Dielectric

SCENE = Scene(Conductor(), Beckmann(0.5, 0.5), (0.5,), 0.0)
REPLICATES, DIRECTIONS = 16, 50


def errors_with(bias, rng, replicates=REPLICATES):
    return bias + rng.standard_normal((replicates, 1, DIRECTIONS))


def apart(errors):
    return taken_apart(inner_products(errors, np.full(DIRECTIONS, 1 / DIRECTIONS)))


def test_bias_is_found_where_planted(rng):
    found = apart(errors_with(0.5, rng))
    assert found.bias == pytest.approx(0.25, abs=4 * found.bias_stderr)
    assert found.bias > 4 * found.bias_stderr
    assert found.noise == pytest.approx(1, abs=5 * found.noise_stderr)
    assert found.total == pytest.approx(found.bias + found.noise)


def test_no_bias_is_found_where_none_is(rng):
    z = np.array([(f := apart(errors_with(0, rng))).bias / f.bias_stderr for _ in range(300)])
    assert abs(z.mean()) < 4 / np.sqrt(300)
    assert np.abs(z).max() < 5
    # A stated error that is too large would hide a bias, one too small would invent it.
    assert 0.6 < z.std() < 1.3


def test_stated_errors_are_the_spread_over_repetitions(rng):
    found = [apart(errors_with(0.3, rng)) for _ in range(300)]
    for name in ("total", "bias", "noise"):
        values = np.array([getattr(f, name) for f in found])
        stated = np.sqrt(np.mean([getattr(f, f"{name}_stderr") ** 2 for f in found]))
        assert stated == pytest.approx(values.std(), rel=0.25)


def test_error_measures_of_a_known_error():
    """A lobe that is a tenth too bright in order 1."""
    weight = np.full(DIRECTIONS, 2 * np.pi / DIRECTIONS)
    truth = np.zeros((1, 3, DIRECTIONS))
    truth[0, 0], truth[0, 2] = 0.1, 0.05
    wrong = truth.copy()
    wrong[0, 0] *= 1.1
    found = accuracy(np.stack([wrong] * 4), truth, weight)
    assert found.total == pytest.approx((0.01 / 0.15) ** 2)
    assert found.bias == pytest.approx(found.total)


@pytest.mark.parametrize("power", [-0.5, -1, -4])
def test_slope_of_synthetic_data(power, rng):
    x = 4.0 ** np.arange(6)
    value, stderr = zip(
        *(slope(x, x**power * np.exp(0.05 * rng.standard_normal(6)), 0.05 * x**power)
          for _ in range(200)), strict=True,
    )  # fmt: skip
    assert np.mean(value) == pytest.approx(power, abs=0.01)
    assert 0.9 < np.mean(stderr) / np.std(value) < 1.4


def test_slope_needs_two_points():
    assert np.isnan(slope(np.ones(1), np.ones(1), np.ones(1))[0])
    assert np.isnan(slope(np.zeros(3), np.ones(3), np.ones(3))[0])


def test_pareto_front():
    seconds = np.array([1.0, 2, 3, 2, 4, 1])
    error = np.array([3.0, 2, 1, 2.5, 1, np.nan])
    assert pareto(seconds, error).tolist() == [True, True, True, False, False, False]
    twins = np.ones(2)
    assert pareto(twins, twins).all()


def test_ranks_by_efficiency_are_kept_when_repetitions_are_drawn_again(rng):
    """Of methods whose noise is clearly apart, walk for walk: a rank is no accident of a run."""
    lobe = lobe_directions(SCENE, 0.5, 48, 0)
    truth = reference(SCENE, [lobe], ("solve",), 64, 0)
    settings = [Setting(name, 256) for name in ("walk", "walk-low-variance")]
    series = measure(SCENE, settings, [lobe], Protocol(16, 0))
    errors = [np.array(s.values) - truth.values[0] for s in series]
    squares = [np.diag(inner_products(e.sum(axis=2), lobe.solid_angle)) for e in errors]
    again = [e[rng.integers(16, size=(200, 16))].mean(axis=1) for e in squares]
    assert (again[1] < again[0]).mean() > 0.99


@pytest.mark.parametrize("material", [Conductor, Dielectric])
@pytest.mark.parametrize(("theta", "alpha"), [(0.0, 0.1), (1.5, 0.1), (0.7, 1.0)])
def test_directions_are_a_quadrature_of_the_lobe(material, theta, alpha):
    """Energy of the first order, by 1024 directions and by 32768."""
    scene = Scene(material(), Beckmann(alpha, alpha), (theta,), 0.3)
    single = METHODS["single"](scene.slopes, scene.material, 1)
    energies = []
    for n in (1024, 32768):
        lobe = lobe_directions(scene, theta, n, 0)
        value = single.evaluate(lobe.wi, lobe.wo, 0, np.random.default_rng(0)).value[0, 0]
        energies.append(value @ lobe.solid_angle)
    assert energies[0] == pytest.approx(energies[1], rel=0.03)
    assert energies[1] <= 1.005


def test_quasirandom_points_serve_whole_sets_of_paths_only():
    rng = QuasiRandom(np.random.SeedSequence(1))
    first = rng.random(64)
    assert first.dtype == np.float64
    # One point in each of 64 strata: what no pseudo-random set does.
    assert np.array_equal(np.sort((first * 64).astype(int)), np.arange(64))
    assert rng.random(63).size == 63
    assert rng.used == 1
    for _ in range(DIMENSIONS + 3):
        assert 0 <= rng.random(64, dtype=np.float32).min() <= rng.random() < 1
    assert rng.used == DIMENSIONS


@pytest.mark.parametrize("method", ["walk", "walk-low-variance", "exact"])
def test_quasirandom_estimates_are_unbiased(method):
    lobe = lobe_directions(SCENE, 0.5, 24, 0)
    settings = SCENE.slopes, SCENE.material, SCENE.orders
    truth = Solve(*settings, resolution=0.3).evaluate(lobe.wi, lobe.wo).value
    chosen = METHODS[method](*settings)
    values = [
        evaluate_quasirandom(
            chosen, lobe.wi, lobe.wo, 512, QuasiRandom(np.random.SeedSequence([7, r]))
        )
        for r in range(32)
    ]
    found = accuracy(np.array(values), truth, lobe.solid_angle)
    assert abs(found.bias) < 4 * found.bias_stderr


def test_walks_agree_with_the_reference_and_single_scattering_does_not():
    lobe = lobe_directions(SCENE, 0.5, 48, 0)
    truth = reference(SCENE, [lobe], ("solve",), 64, 0)
    assert truth.method == "solve"
    settings = [Setting("walk", 256), Setting("exact", 256), Setting("single")]
    series = measure(SCENE, settings, [lobe], Protocol(8, 0))
    rows = method_rows(SCENE, series, truth)
    walk, exact, single = rows
    assert abs(walk.bias_z) < 5
    assert abs(exact.bias_z) < 5
    assert single.bias == single.relative_rmse > 0.05
    for row in rows:
        assert row.efficiency == pytest.approx(1 / (row.relative_rmse**2 * row.seconds))
        assert row.seconds_low <= row.seconds <= row.seconds_high
    assert margin(rows, truth, SCENE.theta) > 100
    (floor,) = floors(SCENE, truth, None, [])
    assert floor.relative_rmse == truth.noise[0] < 1e-5


def test_a_reference_by_walks_knows_its_noise():
    scene = Scene(Dielectric(), Beckmann(0.5, 0.3), (0.5,), 0.0)
    lobe = lobe_directions(scene, 0.5, 24, 0)
    values = [_by_walks(scene, [lobe], MORE_WALKS * 16, seed) for seed in range(8)]
    assert values[0].method == "walk-low-variance"
    totals = np.array([v.values[0].sum(axis=1) for v in values])
    scale = (totals.mean(axis=0) ** 2 * lobe.solid_angle).sum()
    spread = np.sqrt((totals.var(axis=0, ddof=1) * lobe.solid_angle).sum() / scale)
    stated = np.sqrt(np.mean([v.noise[0] ** 2 for v in values]))
    assert stated == pytest.approx(spread, rel=0.5)


def test_ladder_goes_from_cheap_to_dear():
    settings = ladder(("single", "walk", "solve"), 1000)
    assert [s.samples for s in settings if s.method == "walk"] == [62, 250, 1000]
    assert [s.samples for s in ladder(("walk",), 4)] == [4]
    assert sum(s.method == "single" for s in settings) == 1
    resolutions = [s.resolution for s in settings if s.method == "solve"]
    assert resolutions == sorted(resolutions)


def lobes_of(mean, noise, count, rng):
    size = merged_solid_angle()
    return (mean + noise * rng.standard_normal((count, size.size))) * size


def test_distance_of_lobes_is_free_of_noise(rng):
    """Two means a tenth apart under noise of their own size; and none apart."""
    for factor, expected in ((1.1, 0.01), (1.0, 0.0)):
        found = [
            distance(lobes_of(1, 1, 16, rng), lobes_of(factor, 0.5, 8, rng), merged_solid_angle())
            for _ in range(40)
        ]
        square, stderr = np.array(found).T
        assert square.mean() == pytest.approx(expected, abs=4 * square.std() / np.sqrt(40))
        assert 0.6 < np.sqrt((stderr**2).mean()) / square.std() < 2


def test_noise_of_surfaces_falls_with_their_number(rng):
    world = SurfaceReference(lobes_of(1, 0.4, 32, rng)[:, None], [], [], 100)
    sizes, noise, stderr = zip(*grouped_noise(world.units[:, 0]), strict=True)
    assert sizes == (1, 2, 4, 8)
    for size, value, error in zip(sizes, noise, stderr, strict=True):
        assert value == pytest.approx(0.4 / np.sqrt(size), abs=5 * error)
    assert own_noise(world, 0)[0] == pytest.approx(0.4 / np.sqrt(32), rel=0.1)


def test_counted_walks_are_as_far_off_as_the_surfaces_they_are_held_against(monkeypatch):
    """Surfaces that are the walks themselves, and such as send a tenth more everywhere."""
    monkeypatch.setattr(counted, "WALKS", 1024)
    scene = Scene(Conductor(), Beckmann(1, 1), (0.5,), 0.0)
    walks, others = (counted.count(scene, "gaussian", seed) for seed in (1, 2))
    assert walks.units.sum(axis=2) == pytest.approx(1, abs=1e-12)
    assert walks.setup_s > 0
    assert (walks.seconds > 0).all()
    for factor, apart in ((1.0, 0.0), (1.1, 0.1 / 1.1)):
        world = SurfaceReference(factor * others.units, [], [], 100)
        rows, (found,) = counted.counted_rows(scene, walks, world)
        assert [row.samples for row in rows] == [1024, 2048, 4096]
        assert found.value == pytest.approx(apart, abs=4 * max(found.stderr, 0.01))
        for row in rows:
            assert row.bias == found.value
            assert row.relative_rmse == pytest.approx(np.hypot(row.noise, found.value))
            assert row.seconds == pytest.approx(
                row.samples / 1024 * float(np.median(walks.seconds))
            )
    noise = [row.noise for row in rows]
    assert noise[0] / noise[-1] == pytest.approx(2, rel=0.2)


def simulated(cells, surfaces):
    """Rows of energies of a rough mirror in vertical light."""
    scene = Scene(Conductor(), Beckmann(1, 1), (0.0,), 0.0)
    resolution = Resolution(cells, 12, surfaces)
    found = trace_surfaces(scene, resolution, surfaces * 8000, 0, 1, True)
    return energy_rows(scene, found.steps, found.spent, found.rays)


def test_energies_by_ever_more_surfaces():
    rows = simulated(8, 24)
    assert [(r.method, r.samples) for r in rows] == [
        (method, n * 8000) for method in (ONE, THREE) for n in (8, 16, 24)
    ]
    one, three = rows[2], rows[5]
    # Measured .55; both are known to a seventh.
    assert three.noise < 0.8 * one.noise
    assert three.seconds > one.seconds
    assert three.setup_s == one.setup_s
    for r in rows:
        assert r.relative_rmse == pytest.approx(np.hypot(r.noise, r.bias))
        assert r.efficiency == pytest.approx(1 / (r.relative_rmse**2 * r.seconds))


def test_the_bias_of_one_mesh_is_that_of_its_cells():
    """The .011 of `reports/trust.md` of an order on 4 cells, of energies of .47 and .46."""
    _, one, _, three = simulated(4, 16)
    step = np.sqrt(one.bias**2 - three.bias**2)
    assert step * np.hypot(0.47, 0.46) == pytest.approx(0.011, rel=0.3)


def test_walks_stand_in_where_solving_does_much_worse(monkeypatch):
    """Two roughnesses, of which coarse solutions know directions to some percent."""
    tried = []
    solved = module._solved
    monkeypatch.setattr(module, "_solved", lambda *a: tried.append(a[2]) or solved(a[0], a[1], 0.1))
    scene = Scene(Conductor(), Beckmann(1.0, 0.3), (0.5,), 0.0)
    found = reference(scene, [lobe_directions(scene, 0.5, 24, 0)], ("walk", "solve"), 4096, 0)
    assert found.method == "walk-low-variance"
    assert tried == [module.TRIAL]


def test_merged_bins_keep_energy_and_centre():
    lobe = np.zeros((2, THETA_BINS * PHI_BINS))
    lobe[0, [0, 1, PHI_BINS - 1]] = 1
    coarse = merge_sides(lobe)
    assert coarse[0] == coarse.sum() == 3
    assert merged_solid_angle().sum() == pytest.approx(4 * np.pi)


def row(method, samples, seconds, noise, bias=0.0, **more):
    rmse = np.hypot(noise, bias)
    known = dict(bias_z=100.0 if bias else 0.0, model="smith", bias_stderr=0.0, noise_stderr=0.0)
    return Row(method, "conductor", "beckmann", 0.5, 0.5, 1.0, samples, seconds, rmse, bias,
               1 / (rmse**2 * seconds), noise=noise, **known | more)  # fmt: skip


def test_seconds_to_an_error():
    walk = [row("walk", FEW, 0.01, 0.4), row("walk", 1600, 1.0, 0.04)]
    assert seconds_to(walk, 0.02)[0] == pytest.approx(4)
    assert seconds_to(walk, 0.9)[0] == 0.01
    biased = [row("position-free-correlated", 1600, 1.0, 0.03, bias=0.04)]
    assert seconds_to(biased, 0.05)[0] == pytest.approx(1)
    assert seconds_to(biased, 0.04)[0] == np.inf
    # Another model whose bias is lost in noise is not taken for unbiased.
    unknown = [row("position-free-correlated", 9, 1.0, 0.03, bias_stderr=0.02, model="other")]
    assert seconds_to(unknown, 0.02)[0] == np.inf
    solve = [row("solve", 0, 0.5, 0, 0.01, setup_s=2.0), row("solve", 0, 1, 0, 1e-6, setup_s=3.0)]
    assert seconds_to(solve, 0.02) == (2.5, 0.5)
    assert seconds_to(solve, 0.001) == (4, 1)
    found = {(r.method, r.relative_rmse): r for r in times_to_accuracy(walk + solve, (0.01, 0.001))}
    assert found["solve", 0.001].gain == pytest.approx(1600 / 4)
    assert found["solve", 0.001].best
    assert not found["walk", 0.001].best


def test_the_slab_is_seen_from_where_a_mirror_would_send_the_light():
    lobe = slab(SCENE)
    assert np.linalg.norm(lobe.wo, axis=0) == pytest.approx(1)
    assert (lobe.wo[2] > 0).all()
    middle = lobe.wo.mean(axis=1)
    assert middle[0] < 0 < lobe.wi[0]
    assert middle[1] == pytest.approx(0, abs=1e-12)


def test_figure_17_says_what_a_walk_is_worth(monkeypatch):
    """Errors of single walks, foretold, against those of repetitions with sixteen."""
    monkeypatch.setattr(figure_17, "ALPHAS", (0.5,))
    monkeypatch.setattr(figure_17, "ESTIMATORS", ("walk", "exact"))
    table = figure_17.error_over_time(SCENE, 0)
    told = [
        (mse, stderr)
        for name, n, mse, stderr in zip(
            table["method"], table["samples"], table["relative_mse"],
            table["relative_mse_stderr"], strict=True,
        )
        if (name, n) == ("exact", 16)
    ]  # fmt: skip
    lobe = slab(SCENE)
    exact = METHODS["exact"](SCENE.slopes, SCENE.material, SCENE.orders)
    values = np.stack(
        [timed(exact, 16, lobe, np.random.SeedSequence([7, r]))[0].sum(axis=1) for r in range(200)]
    )
    mse = values.var(axis=0, ddof=1).sum() / (values.mean(axis=0) ** 2).sum()
    ((foretold, stderr),) = told
    assert mse == pytest.approx(foretold, abs=5 * stderr + 0.2 * foretold)
