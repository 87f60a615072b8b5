"""Rows of tradeoff.csv: errors, times, slopes, efficiencies, ranks and the Pareto front."""

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from msbsdf_cli.report.directory import Table
from msbsdf_cli.scene import Scene
from msbsdf_cli.studies.tradeoff.errors import Accuracy, accuracy, root
from msbsdf_cli.studies.tradeoff.fits import pareto, rank_stability, slope
from msbsdf_cli.studies.tradeoff.measuring import Series, quartiles
from msbsdf_cli.studies.tradeoff.reference import Reference
from msbsdf_cli.studies.tradeoff.world import MODEL_OF, MODELS, Distance, World, grouped_noise

NAN = float("nan")


@dataclass(frozen=True)
class Row:
    """A setting of a method for one incident angle. The first columns are those of the contract."""

    method: str
    material: str
    slopes: str
    alpha_x: float
    alpha_y: float
    theta_i_rad: float
    samples: int
    seconds: float
    """Median of evaluating the lobe, set-up apart."""
    relative_rmse: float
    bias: float
    efficiency: float
    """1 / (relative_rmse^2 seconds)."""
    slope: float = NAN
    """Of the noise over samples; of the error of `solve` over its time."""
    slope_stderr: float = NAN
    slope_time: float = NAN
    """Of relative_rmse over seconds."""
    resolution: float = NAN
    seconds_low: float = NAN
    seconds_high: float = NAN
    setup_s: float = 0.0
    setup_low_s: float = 0.0
    setup_high_s: float = 0.0
    seconds_per_direction: float = NAN
    efficiency_with_setup: float = NAN
    relative_rmse_stderr: float = NAN
    bias_stderr: float = NAN
    bias_z: float = NAN
    """Squared bias over its standard error."""
    noise: float = NAN
    noise_stderr: float = NAN
    energy_error: float = NAN
    energy_error_stderr: float = NAN
    energy_bias: float = NAN
    total_variation: float = NAN
    total_variation_stderr: float = NAN
    reference: str = "smith"
    """What the error is measured against: the Smith model, or the traced surfaces."""
    model: str = ""
    to_surfaces: float = NAN
    """Distance of the method's model from the surfaces, below which no effort gets."""
    pareto: bool = False
    """Nobody is both faster and more accurate on one lobe, set-up included."""
    pareto_after_setup: bool = False
    rank: int = 0
    """Among the dearest settings, by efficiency; 0 for the others."""
    rank_kept: float = NAN
    squares: np.ndarray = field(default_factory=lambda: np.zeros(0), repr=False)
    """Squared relative errors of the repetitions; not a column."""
    times: tuple[float, ...] = field(default=(), repr=False)
    """Seconds of the repetitions; not a column."""


COLUMNS = [f.name for f in fields(Row) if f.name not in ("squares", "times")]


def method_rows(scene: Scene, series: list[Series], truth: Reference) -> list[Row]:
    """A row for each series, with slopes, fronts and ranks angle by angle."""
    rows = []
    for i, theta in enumerate(scene.theta):
        here = [s for s in series if s.lobe.theta == theta]
        mine = [_row(scene, s, truth.values[i]) for s in here]
        mine = with_slopes(mine)
        rows += with_ranks(with_fronts(mine))
    return rows


def _row(scene: Scene, series: Series, truth: np.ndarray) -> Row:
    setting = series.setting
    lumped = setting.method == "energy-compensated"
    found = accuracy(np.array(series.values), truth, series.lobe.solid_angle, lumped)
    low, middle, high = series.times
    setup_low, setup, setup_high = series.setup_s
    return Row(
        setting.method,
        *_scene_columns(scene, series.lobe.theta),
        samples=setting.samples,
        seconds=middle,
        resolution=setting.resolution,
        seconds_low=low,
        seconds_high=high,
        setup_s=setup,
        setup_low_s=setup_low,
        setup_high_s=setup_high,
        seconds_per_direction=middle / series.lobe.wo.shape[1],
        **_errors(found, middle, setup),
        model=MODELS[MODEL_OF[setting.method]],
        squares=found.each,
        times=tuple(series.seconds),
    )


def _scene_columns(scene: Scene, theta: float) -> tuple[str, str, float, float, float]:
    return scene.material, scene.slopes, *scene.alpha, theta


def _errors(found: Accuracy, seconds: float, setup: float) -> dict[str, Any]:
    square = found.relative
    rmse, rmse_stderr = root(square.total, square.total_stderr)
    bias, bias_stderr = root(square.bias, square.bias_stderr)
    noise, noise_stderr = root(square.noise, square.noise_stderr)
    energy, energy_stderr = root(found.energy.total, found.energy.total_stderr)
    tiny = np.finfo(float).tiny
    return {
        "relative_rmse": rmse,
        "relative_rmse_stderr": rmse_stderr,
        "bias": bias,
        "bias_stderr": bias_stderr,
        "bias_z": square.bias / square.bias_stderr if square.bias_stderr > 0 else NAN,
        "noise": noise,
        "noise_stderr": noise_stderr,
        "efficiency": 1 / max(square.total * seconds, tiny),
        "efficiency_with_setup": 1 / max(square.total * (seconds + setup), tiny),
        "energy_error": energy,
        "energy_error_stderr": energy_stderr,
        "energy_bias": root(found.energy.bias, found.energy.bias_stderr)[0],
        "total_variation": found.total_variation,
        "total_variation_stderr": found.total_variation_stderr,
    }


def with_slopes(rows: list[Row]) -> list[Row]:
    """The rows with the slopes of each method over its settings."""
    done = []
    for name in dict.fromkeys(r.method for r in rows):
        mine = [r for r in rows if r.method == name]
        seconds = np.array([r.seconds for r in mine])
        rmse, rmse_stderr, noise, noise_stderr, samples = (
            np.array([getattr(r, column) for r in mine])
            for column in (
                "relative_rmse", "relative_rmse_stderr", "noise", "noise_stderr", "samples",
            )
        )  # fmt: skip
        over_time = slope(seconds, rmse, rmse_stderr)
        main = over_time if name == "solve" else slope(samples, noise, noise_stderr)
        done += [
            replace(r, slope=main[0], slope_stderr=main[1], slope_time=over_time[0]) for r in mine
        ]
    return done


def with_fronts(rows: list[Row]) -> list[Row]:
    """The rows with the Pareto fronts of error and time marked."""
    seconds, setup, error = (
        np.array([getattr(r, column) for r in rows])
        for column in ("seconds", "setup_s", "relative_rmse")
    )
    fronts = zip(rows, pareto(seconds + setup, error), pareto(seconds, error), strict=True)
    return [replace(r, pareto=bool(a), pareto_after_setup=bool(b)) for r, a, b in fronts]


def with_ranks(rows: list[Row]) -> list[Row]:
    """The rows with ranks of the dearest settings and how often these keep them."""
    last = {r.method: i for i, r in enumerate(rows)}
    dearest = [rows[i] for i in last.values()]
    rank, kept = rank_stability(
        [r.squares for r in dearest],
        [np.array(r.times) for r in dearest],
        np.random.default_rng(0),
    )
    rows = list(rows)
    for i, place, share in zip(last.values(), rank, kept, strict=True):
        rows[i] = replace(rows[i], rank=int(place), rank_kept=float(share))
    return rows


def simulate_rows(scene: Scene, world: World) -> list[Row]:
    """Rows of `simulate`, whose error is its noise about the mean of all surfaces."""
    rows = []
    trace_low, trace, trace_high = quartiles(world.trace_s)
    surface_low, surface, surface_high = quartiles(world.surface_s)
    for i, theta in enumerate(scene.theta):
        mine = []
        for size, noise, stderr in grouped_noise(world, i):
            mine.append(
                Row(
                    "simulate",
                    *_scene_columns(scene, theta),
                    samples=size * world.rays,
                    seconds=size * trace,
                    seconds_low=size * trace_low,
                    seconds_high=size * trace_high,
                    setup_s=size * surface,
                    setup_low_s=size * surface_low,
                    setup_high_s=size * surface_high,
                    relative_rmse=noise,
                    relative_rmse_stderr=stderr,
                    bias=NAN,
                    noise=noise,
                    noise_stderr=stderr,
                    efficiency=1 / (noise**2 * size * trace),
                    efficiency_with_setup=1 / (noise**2 * size * (trace + surface)),
                    reference="surfaces",
                    model="surfaces",
                )
            )
        rows += with_slopes(mine)
    return rows


def with_distances(rows: list[Row], found: list[Distance]) -> list[Row]:
    """The rows with the distance of each one's model from the surfaces."""
    apart = {(d.theta, d.model): d.value for d in found}
    return [replace(r, to_surfaces=apart.get((r.theta_i_rad, r.model), NAN)) for r in rows]


def table(rows: list[Row]) -> Table:
    """tradeoff.csv"""
    return {name: [getattr(r, name) for r in rows] for name in COLUMNS}
