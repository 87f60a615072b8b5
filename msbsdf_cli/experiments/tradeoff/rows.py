"""Rows of tradeoff.csv: errors, times, slopes, efficiencies and the Pareto front."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from msbsdf_cli.experiments.tradeoff.fits import pareto, slope
from msbsdf_cli.experiments.tradeoff.measuring import Quartiles, Series, quartiles
from msbsdf_cli.experiments.tradeoff.reference import Reference
from msbsdf_cli.experiments.tradeoff.surface_reference import (
    Distance,
    SurfaceReference,
    grouped_noise,
)
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.repetitions import accuracy, root

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
    resolution: float = NAN
    """Of `solve`."""
    seconds_low: float = NAN
    seconds_high: float = NAN
    setup_s: float = 0.0
    efficiency_with_setup: float = NAN
    relative_rmse_stderr: float = NAN
    bias_stderr: float = NAN
    bias_z: float = NAN
    """Squared bias over its standard error."""
    noise: float = NAN
    noise_stderr: float = NAN
    reference: str = "smith"
    """What the error is measured against: the Smith model, or the traced surfaces."""
    model: str = ""
    to_surfaces: float = NAN
    """Distance of the method's model from the surfaces, below which no effort gets."""
    pareto: bool = False
    """Nobody is both faster and more accurate on one lobe, set-up included."""


def method_rows(scene: Scene, series: list[Series], truth: Reference) -> list[Row]:
    """A row for each series, with slopes and the Pareto front angle by angle."""
    rows = []
    for i, theta in enumerate(scene.theta):
        mine = [_row(scene, s, truth.values[i]) for s in series if s.lobe.theta == theta]
        rows += with_front(with_slopes(mine))
    return rows


def _row(scene: Scene, series: Series, truth: np.ndarray) -> Row:
    setting, lobe = series.setting, series.lobe
    square = accuracy(np.array(series.values), truth, lobe.solid_angle)
    return Row(
        method=setting.method,
        samples=setting.samples,
        resolution=setting.resolution,
        bias_z=square.bias / square.bias_stderr if square.bias_stderr > 0 else NAN,
        model=METHODS[setting.method].traits.model,
        **place(scene, lobe.theta),
        **with_stderr(
            relative_rmse=root(square.total, square.total_stderr),
            bias=root(square.bias, square.bias_stderr),
            noise=root(square.noise, square.noise_stderr),
        ),
        **costs(square.total, series.times, series.setup_s[1]),
    )


def simulate_rows(scene: Scene, surfaces: SurfaceReference) -> list[Row]:
    """Rows of `simulate`, whose error is its noise about the mean of all surfaces."""
    rows = []
    for i, theta in enumerate(scene.theta):
        mine = [
            Row(
                method="simulate",
                samples=size * surfaces.rays,
                bias=NAN,
                reference="surfaces",
                model="surfaces",
                **place(scene, theta),
                **with_stderr(relative_rmse=(noise, stderr), noise=(noise, stderr)),
                **costs(
                    noise**2,
                    quartiles([size * s.trace_s for s in surfaces.spent]),
                    size * float(np.median([s.surface_s for s in surfaces.spent])),
                ),
            )
            for size, noise, stderr in grouped_noise(surfaces.units[:, i])
        ]
        rows += with_slopes(mine)
    return rows


def place(scene: Scene, theta: float) -> dict[str, Any]:
    """Columns of the scene."""
    names = ("material", "slopes", "alpha_x", "alpha_y", "theta_i_rad")
    values = scene.material.name, scene.slopes.name, *scene.alpha, theta
    return dict(zip(names, values, strict=True))


def with_stderr(**measured: tuple[float, float]) -> dict[str, Any]:
    """Columns of values and, by the names with `_stderr`, their standard errors."""
    values = {name: value for name, (value, _) in measured.items()}
    return values | {f"{name}_stderr": stderr for name, (_, stderr) in measured.items()}


def costs(square: float, seconds: Quartiles, setup_s: float) -> dict[str, Any]:
    """Columns of times, and of efficiencies from the squared relative error."""
    low, middle, high = seconds
    tiny = np.finfo(float).tiny
    return {
        "seconds_low": low,
        "seconds": middle,
        "seconds_high": high,
        "setup_s": setup_s,
        "efficiency": 1 / max(square * middle, tiny),
        "efficiency_with_setup": 1 / max(square * (middle + setup_s), tiny),
    }


def _columns(rows: list[Row], *names: str) -> Iterator[np.ndarray]:
    return (np.array([getattr(r, name) for r in rows]) for name in names)


def with_slopes(rows: list[Row]) -> list[Row]:
    """The rows with the slope of each method over its settings."""
    done = []
    for name in dict.fromkeys(r.method for r in rows):
        mine = [r for r in rows if r.method == name]
        axes = ("samples", "noise", "noise_stderr")
        if mine[0].resolution == mine[0].resolution:
            axes = ("seconds", "relative_rmse", "relative_rmse_stderr")
        found = slope(*_columns(mine, *axes))[0]
        done += [replace(r, slope=found) for r in mine]
    return done


def with_front(rows: list[Row]) -> list[Row]:
    """The rows with the Pareto front of error and time marked."""
    seconds, setup, error = _columns(rows, "seconds", "setup_s", "relative_rmse")
    front = pareto(seconds + setup, error)
    return [replace(r, pareto=bool(first)) for r, first in zip(rows, front, strict=True)]


def against_surfaces(rows: list[Row], found: list[Distance]) -> list[Row]:
    """The rows with errors against the surfaces: those against the method's own model and, in
    quadrature, the distance of that model; and the Pareto front of these.

    The error against its own model is that against Smith's where that is its model; of any other
    method it is noise.
    """
    apart = {(d.theta, d.model): d for d in found}
    done = []
    for r in rows:
        d = apart.get((r.theta_i_rad, r.model))
        if r.reference != "smith" or d is None:
            done.append(r)
            continue
        own = (r.relative_rmse, r.relative_rmse_stderr)
        value, error = own if r.model == "smith" else (r.noise, r.noise_stderr)
        # Without noise there is none to be known badly.
        parts = [(v, e) for v, e in ((value, error), (d.value, d.stderr)) if v > 0]
        total = float(np.sqrt(sum(v * v for v, _ in parts)))
        stderr = float(np.sqrt(sum((v * e) ** 2 for v, e in parts))) / max(total, 1e-300)
        times = r.seconds_low, r.seconds, r.seconds_high
        changed = costs(total**2, times, r.setup_s)
        measured = with_stderr(relative_rmse=(total, stderr), bias=(d.value, d.stderr))
        # Once noise is below the distance, walks no longer make the error less: slopes go.
        done.append(replace(r, reference="surfaces", slope=NAN, **measured, **changed))
    angles = dict.fromkeys(r.theta_i_rad for r in done)
    fronts = [with_front([r for r in done if r.theta_i_rad == t]) for t in angles]
    return [r for front in fronts for r in front]


def with_distances(rows: list[Row], found: list[Distance]) -> list[Row]:
    """The rows with the distance of each one's model from the surfaces."""
    apart = {(d.theta, d.model): d.value for d in found}
    return [replace(r, to_surfaces=apart.get((r.theta_i_rad, r.model), NAN)) for r in rows]
