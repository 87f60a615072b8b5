"""stability.png, published.png and surfaces.png: verdicts as maps, told apart without colour."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import Patch, Rectangle

from msbsdf_cli.plots.style import in_degrees, key, panels, save

LOOKS = {
    "works": ("#dcefe6", ""),
    "degraded": ("#f2a33c", ""),
    "fails": ("#5b1740", ""),
    "refused": ("#ffffff", "//////"),
    "unknown": ("#ffffff", "...."),
}
"""Fill and hatching: light, middle and dark in grey as well."""

WORST = ("fails", "degraded", "unknown", "works", "refused")
"""Of several materials and slopes a cell shows the worst; what is refused is no fault."""

SHORT = {"uniform numbers": "uniform", "around the horizon": "around", "near 1": "~1"} | {
    angle: f"{angle} [rad]" for angle in ("theta", "phi")
}

Line = tuple[str, float | None]
"""A row of the map: parameter, and the angle of incidence where it is no value itself."""


def draw_stability(rows: Sequence[Any], simulation: str, directory: Path) -> None:
    """All maps that the rows allow."""
    methods = list(dict.fromkeys(r.method for r in rows if r.method != simulation))
    if methods:
        _draw_maps(rows, [(m, None) for m in methods], 4, directory / "stability.png")
    ours = next((m for m in ("walk", *methods) if m in methods and m != "published"), None)
    if "published" in methods and ours:
        pair = [("published", "float32"), (ours, "float32")]
        _draw_maps(rows, pair, 2, directory / "published.png")
    if any(r.method == simulation for r in rows):
        _draw_simulation([r for r in rows if r.method == simulation], directory / "surfaces.png")


def _draw_maps(
    rows: Sequence[Any], maps: Sequence[tuple[str, str | None]], across: int, path: Path
) -> None:
    """A panel for each method: a row for each sweep, a cell for each value, its upper half float64
    and its lower one float32, or one precision alone."""
    shown = {method for method, _ in maps}
    lines = list(dict.fromkeys(_line(r) for r in rows if r.method in shown))
    most = max(len(_values(rows, line)) for line in lines)
    across = min(across, len(maps))
    down = -(-len(maps) // across)
    height = 0.19 * len(lines)
    figure, axes = panels(down, [0.36 * most] * across, height, (1.0, 0.4))
    for k, axis in enumerate(axes.flat):
        axis.set_axis_off()
        if k < len(maps):
            _draw_map(axis, rows, maps[k], lines)
    handles = [
        Patch(facecolor=fill, edgecolor="0.3", hatch=hatch, label=name)
        for name, (fill, hatch) in LOOKS.items()
    ]
    key(figure, handles)
    save(figure, path)


def _line(row: Any) -> Line:
    return row.parameter, None if row.parameter == "theta" else row.theta_i_rad


def _values(rows: Sequence[Any], line: Line) -> list[Any]:
    return list(dict.fromkeys(r.value for r in rows if _line(r) == line))


def _draw_map(
    axis: Any, rows: Sequence[Any], which: tuple[str, str | None], lines: list[Line]
) -> None:
    method, only = which
    mine = [r for r in rows if r.method == method and only in (None, r.precision)]
    precisions = ("float64", "float32") if only is None else (only,)
    for i, line in enumerate(lines):
        angle = "" if line[1] is None else f", {_angle(line[1])}"
        name = SHORT.get(line[0], line[0])
        axis.text(-0.15, i + 0.5, f"{name}{angle}", ha="right", va="center", fontsize=5.5)
        for j, value in enumerate(_values(rows, line)):
            for k, precision in enumerate(precisions):
                verdicts = {
                    r.verdict
                    for r in mine
                    if _line(r) == line and r.value == value and r.precision == precision
                }
                if not verdicts:
                    continue
                verdict = next(v for v in WORST if v in verdicts)
                fill, hatch = LOOKS[verdict]
                part = 1 / len(precisions)
                box = Rectangle((j, i + k * part), 1, part, fc=fill, ec="0.6", hatch=hatch, lw=0.3)
                box.set_clip_on(False)
                axis.add_patch(box)
            axis.text(
                j + 0.5,
                i + 0.5,
                _text(value),
                ha="center",
                va="center",
                fontsize=4.6,
                color="0.0",
                bbox={"fc": "white", "ec": "none", "pad": 0.3, "alpha": 0.7},
            )
    axis.set_xlim(0, max(len(_values(rows, line)) for line in lines))
    axis.set_ylim(len(lines), 0)
    axis.set_title(method if only is None else f"{method}, {only}", loc="left")


def _angle(theta: float) -> str:
    below = np.pi / 2 - theta
    return "horizon" if below < 1e-12 else in_degrees(theta)


def _text(value: Any) -> str:
    if isinstance(value, str):
        return SHORT.get(value, value)
    below = np.pi / 2 - value
    if 0 < below < 1e-12:
        return "horizon"
    beside = value - 1
    return f"1{beside:+.0e}" if 0 < abs(beside) < 1e-4 else f"{value:.4g}"


BLUE = "#0072b2"

NAMES = {
    "cells": "cells a correlation length",
    "lift": "offset of rays, over that in use",
    "hits": "bits of hit points",
    "extent": "period, correlation lengths",
    "waves": "waves",
    "surfaces": "surfaces",
}


def _draw_simulation(rows: list[Any], path: Path) -> None:
    """The greatest error of an order's energy for each setting, and the automatic choice."""
    parameters = list(dict.fromkeys(r.parameter for r in rows))
    figure, axes = panels(2, [1.9] * 3, 1.5, (0.55, 0.62))
    for axis, parameter in zip(axes.flat, parameters, strict=False):
        mine = [r for r in rows if r.parameter == parameter]
        x = np.arange(len(mine))
        labels = [r.value if isinstance(r.value, str) else f"{r.value:g}" for r in mine]
        size = np.array([abs(r.energy_error) for r in mine])
        error = np.array([r.energy_stderr for r in mine])
        if parameter == "surfaces":
            axis.plot(x, error, "s-", ms=3, color=BLUE)
        else:
            noisy = (size <= 2 * error) & (error > 0)
            known = ~noisy & (x < x[-1])
            axis.errorbar(x[known], size[known], error[known], fmt="o-", ms=3, lw=0.8, color=BLUE)
            # Noise says no more than that the error is not larger.
            axis.plot(x[noisy], size[noisy] + 2 * error[noisy], "v", ms=4, mfc="white", color=BLUE)
        automatic = mine[0].note.rsplit(" ", 1)[-1]
        place = _place(automatic, labels)
        axis.axvline(place, color="#d55e00", ls="--", lw=0.9)
        axis.text(
            place,
            1.02,
            "automatic",
            color="#d55e00",
            fontsize=6,
            ha="center",
            transform=axis.get_xaxis_transform(),
        )
        axis.axhline(2e-3, color="0.5", lw=0.7, ls=":")
        axis.set_yscale("symlog", linthresh=1e-4)
        axis.set_ylim(bottom=0)
        axis.set_xticks(x, labels)
        axis.set_xlabel(NAMES[parameter], labelpad=1)
    for axis in axes[:, 0]:
        axis.set_ylabel("error of an order's energy")
    words = (
        "dotted: the accuracy promised; triangles: no more than this, as two standard errors "
        "hide what there is;\nthe value furthest to the right is what the others are held against"
    )
    figure.text(0.02, 0.98, words, va="top", fontsize=6)
    save(figure, path)


def _place(automatic: str, labels: list[str]) -> float:
    """Where a value lies between the labels of an axis that is even in their logarithm."""
    if automatic in labels:
        return float(labels.index(automatic))
    numbers = [float(label) for label in labels if label != "all"]
    return float(np.interp(np.log(float(automatic)), np.log(numbers), np.arange(len(numbers))))
