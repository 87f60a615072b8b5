"""Rows of tradeoff.csv: errors, times, slopes, efficiencies, ranks and the Pareto front."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from msbsdf_cli.experiments.tradeoff.fits import pareto, rank_stability, slope
from msbsdf_cli.experiments.tradeoff.measuring import Quartiles, Series, quartiles
from msbsdf_cli.experiments.tradeoff.reference import Reference
from msbsdf_cli.experiments.tradeoff.world import Distance, World, grouped_noise
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.results.directory import Table, columns
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.errors import accuracy, root
from surfaces.streams import stream

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
        mine = [_row(scene, s, truth.values[i]) for s in series if s.lobe.theta == theta]
        rows += with_ranks(with_fronts(with_slopes(mine)))
    return rows


def _row(scene: Scene, series: Series, truth: np.ndarray) -> Row:
    setting, lobe = series.setting, series.lobe
    lumped = METHODS[setting.method].traits.lumps_orders
    found = accuracy(np.array(series.values), truth, lobe.solid_angle, lumped)
    square, energy = found.relative, found.energy
    return Row(
        method=setting.method,
        samples=setting.samples,
        resolution=setting.resolution,
        seconds_per_direction=series.times[1] / lobe.wo.shape[1],
        bias_z=square.bias / square.bias_stderr if square.bias_stderr > 0 else NAN,
        energy_bias=root(energy.bias, energy.bias_stderr)[0],
        model=METHODS[setting.method].traits.model,
        squares=found.each,
        times=tuple(series.seconds),
        **_place(scene, lobe.theta),
        **_with_stderr(
            relative_rmse=root(square.total, square.total_stderr),
            bias=root(square.bias, square.bias_stderr),
            noise=root(square.noise, square.noise_stderr),
            energy_error=root(energy.total, energy.total_stderr),
            total_variation=(found.total_variation, found.total_variation_stderr),
        ),
        **_costs(square.total, series.times, series.setup_s),
    )


def simulate_rows(scene: Scene, world: World) -> list[Row]:
    """Rows of `simulate`, whose error is its noise about the mean of all surfaces."""
    rows = []
    for i, theta in enumerate(scene.theta):
        mine = [
            Row(
                method="simulate",
                samples=size * world.rays,
                bias=NAN,
                reference="surfaces",
                model="surfaces",
                **_place(scene, theta),
                **_with_stderr(relative_rmse=(noise, stderr), noise=(noise, stderr)),
                **_costs(
                    noise**2,
                    quartiles([size * s for s in world.trace_s]),
                    quartiles([size * s for s in world.surface_s]),
                ),
            )
            for size, noise, stderr in grouped_noise(world, i)
        ]
        rows += with_slopes(mine)
    return rows


def _place(scene: Scene, theta: float) -> dict[str, Any]:
    names = ("material", "slopes", "alpha_x", "alpha_y", "theta_i_rad")
    values = scene.material.name, scene.slopes.name, *scene.alpha, theta
    return dict(zip(names, values, strict=True))


def _with_stderr(**measured: tuple[float, float]) -> dict[str, Any]:
    """Columns of values and, by the names with `_stderr`, their standard errors."""
    values = {name: value for name, (value, _) in measured.items()}
    return values | {f"{name}_stderr": stderr for name, (_, stderr) in measured.items()}


def _costs(square: float, seconds: Quartiles, setup_s: Quartiles) -> dict[str, Any]:
    """Columns of times, and of efficiencies from the squared relative error."""
    names = ("seconds_low", "seconds", "seconds_high", "setup_low_s", "setup_s", "setup_high_s")
    tiny = np.finfo(float).tiny
    return {
        **dict(zip(names, (*seconds, *setup_s), strict=True)),
        "efficiency": 1 / max(square * seconds[1], tiny),
        "efficiency_with_setup": 1 / max(square * (seconds[1] + setup_s[1]), tiny),
    }


def _columns(rows: list[Row], *names: str) -> Iterator[np.ndarray]:
    return (np.array([getattr(r, name) for r in rows]) for name in names)


def with_slopes(rows: list[Row]) -> list[Row]:
    """The rows with the slopes of each method over its settings."""
    done = []
    for name in dict.fromkeys(r.method for r in rows):
        mine = [r for r in rows if r.method == name]
        over_time = slope(*_columns(mine, "seconds", "relative_rmse", "relative_rmse_stderr"))
        over_samples = slope(*_columns(mine, "samples", "noise", "noise_stderr"))
        main, stderr = over_time if name == "solve" else over_samples
        done += [replace(r, slope=main, slope_stderr=stderr, slope_time=over_time[0]) for r in mine]
    return done


def with_fronts(rows: list[Row]) -> list[Row]:
    """The rows with the Pareto fronts of error and time marked."""
    seconds, setup, error = _columns(rows, "seconds", "setup_s", "relative_rmse")
    fronts = zip(rows, pareto(seconds + setup, error), pareto(seconds, error), strict=True)
    return [replace(r, pareto=bool(a), pareto_after_setup=bool(b)) for r, a, b in fronts]


def with_ranks(rows: list[Row]) -> list[Row]:
    """The rows with ranks of the dearest settings and how often these keep them."""
    last = {r.method: i for i, r in enumerate(rows)}
    dearest = [rows[i] for i in last.values()]
    rank, kept = rank_stability(
        [r.squares for r in dearest],
        [np.array(r.times) for r in dearest],
        # Of the seed 0 always: ranks are a property of the measurement, not of its seed.
        stream(0, "rank"),
    )
    rows = list(rows)
    for i, place, share in zip(last.values(), rank, kept, strict=True):
        rows[i] = replace(rows[i], rank=int(place), rank_kept=float(share))
    return rows


def with_distances(rows: list[Row], found: list[Distance]) -> list[Row]:
    """The rows with the distance of each one's model from the surfaces."""
    apart = {(d.theta, d.model): d.value for d in found}
    return [replace(r, to_surfaces=apart.get((r.theta_i_rad, r.model), NAN)) for r in rows]


def table(rows: list[Row]) -> Table:
    """tradeoff.csv"""
    return columns(rows, COLUMNS)
