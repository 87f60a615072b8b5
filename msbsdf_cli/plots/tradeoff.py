"""tradeoff.png: error against time, one lobe at a time, and over all angles."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from msbsdf_cli.experiments.tradeoff.floors import Floor
from msbsdf_cli.experiments.tradeoff.rows import Row
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.plots.style import in_degrees, save

SIMULATED = {"simulate-one-mesh": ("#999999", "s")}, ("#000000", "p")
"""Colours and markers of what is traced on explicit surfaces."""


def look(method: str) -> tuple[str, str]:
    """Colour and marker of a method, or of `simulate`, the same on every chart."""
    if method not in METHODS:
        return SIMULATED[0].get(method, SIMULATED[1])
    traits = METHODS[method].traits
    return traits.colour, traits.marker


LEAST_ERROR = 1e-5
"""Errors below are drawn at the lower edge: they do not matter, and the others need the room."""


def draw_tradeoff(
    rows: list[Row],
    floors: list[Floor],
    path: Path,
    quantity: str = "BSDF x cos(theta_o)",
) -> None:
    """A large panel over all angles and a small one for each, times of both axes with set-up."""
    angles = list(dict.fromkeys(r.theta_i_rad for r in rows))
    columns = max(1, -(-len(angles) // 2))
    figure = plt.figure(figsize=(6.2 + 2.5 * columns, 5.6))
    left = 6.0 / (6.2 + 2.5 * columns)
    main = figure.add_gridspec(1, 1, left=0.09 * left / 0.6, right=left, bottom=0.09, top=0.84)
    small = figure.add_gridspec(
        2, columns, left=left + 0.055, right=0.985, bottom=0.09, top=0.84, hspace=0.3, wspace=0.22
    )
    axis = figure.add_subplot(main[0])
    together = over_angles(rows, len(angles))
    limits = _limits(rows, floors)
    _draw_panel(axis, together, _floors_over_angles(floors), limits, large=True)
    axis.set_title(f"all {len(angles)} angles: root mean square error, sum of times")
    axis.set_ylabel(f"relative RMSE of {quantity}")
    for i, theta in enumerate(angles):
        panel = figure.add_subplot(small[i % 2, i // 2])
        mine = [as_point(r) for r in rows if r.theta_i_rad == theta]
        mine_floors = [f for f in floors if f.theta_i_rad == theta]
        _draw_panel(panel, mine, mine_floors, limits, large=False)
        panel.set_title(f"light from {in_degrees(theta)}")
    _legend(figure, rows)
    save(figure, path)


Point = dict[str, Any]
"""What is drawn of a row: method, error, error_stderr, seconds (low, middle, high), setup_s."""


def as_point(row: Row) -> Point:
    """A row as a point."""
    return {
        "method": row.method,
        "setting": (row.samples, row.resolution),
        "error": row.relative_rmse,
        "stderr": row.relative_rmse_stderr,
        "seconds": np.array([row.seconds_low, row.seconds, row.seconds_high]),
        "setup_s": row.setup_s,
        "pareto": row.pareto,
    }


def over_angles(rows: Sequence[Row], angles: int) -> list[Point]:
    """Points with the root of the mean squared error over angles, times added, set up once."""
    from msbsdf_cli.experiments.tradeoff.fits import pareto

    groups: dict[tuple[Any, ...], list[Row]] = {}
    for r in rows:
        groups.setdefault((r.method, r.samples, str(r.resolution)), []).append(r)
    points = []
    for mine in (g for g in groups.values() if len(g) == angles):
        point = as_point(mine[0])
        error = np.array([r.relative_rmse for r in mine])
        stderr = np.array([r.relative_rmse_stderr for r in mine])
        point["error"] = float(np.sqrt((error**2).mean()))
        point["stderr"] = float(np.sqrt(((error * stderr) ** 2).sum()) / angles / point["error"])
        point["seconds"] = sum(as_point(r)["seconds"] for r in mine)
        points.append(point)
    model = [p for p in points if p["method"] != "simulate"]
    total = np.array([p["seconds"][1] + p["setup_s"] for p in model])
    for p, best in zip(model, pareto(total, np.array([p["error"] for p in model])), strict=True):
        p["pareto"] = bool(best)
    return points


def _floors_over_angles(floors: list[Floor]) -> list[Floor]:
    together = []
    for kind, model in dict.fromkeys((f.floor, f.model) for f in floors):
        mine = [f for f in floors if (f.floor, f.model) == (kind, model)]
        value = float(np.sqrt(np.mean([f.relative_rmse**2 for f in mine])))
        error = np.sqrt(sum((f.relative_rmse * f.stderr) ** 2 for f in mine))
        together.append(Floor(0, kind, model, value, float(error / len(mine) / max(value, 1e-300))))
    return together


def _limits(rows: list[Row], floors: list[Floor]) -> tuple[float, float]:
    """Of the errors: the same on all charts that have floors, those of the rows elsewhere."""
    if floors:
        return LEAST_ERROR * 0.7, 2.0
    errors = [r.relative_rmse for r in rows]
    return min(errors) / 2, max(errors) * 2


def _draw_panel(
    axis: Any,
    points: list[Point],
    floors: list[Floor],
    limits: tuple[float, float],
    large: bool,
) -> None:
    size = 5 if large else 3
    for method in dict.fromkeys(p["method"] for p in points):
        mine = [p for p in points if p["method"] == method]
        _draw_method(axis, method, mine, size)
    front = sorted(
        (p["seconds"][1] + p["setup_s"], max(p["error"], LEAST_ERROR))
        for p in points
        if p["pareto"]
    )
    x, y = np.array(front).T
    axis.plot(x, y, color="0.8", lw=5 if large else 3, drawstyle="steps-post", zorder=0)
    axis.scatter(x, y, s=130 if large else 45, facecolor="none", edgecolor="0.2", lw=0.9, zorder=4)
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_ylim(*limits)
    if not large:
        axis.xaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_major_locator(LogLocator(numticks=10))
    axis.set_xlabel("seconds, set-up included" if large else "seconds", labelpad=1)
    for floor in floors:
        _draw_floor(axis, floor, large)


def _draw_method(axis: Any, method: str, points: list[Point], size: float) -> None:
    colour, marker = look(method)
    x = np.array([p["seconds"] + p["setup_s"] for p in points]).T
    y = np.array([p["error"] for p in points])
    low = np.array([min(p["stderr"], 0.9 * p["error"]) for p in points])
    high = np.array([p["stderr"] for p in points])
    shown = np.maximum(y, LEAST_ERROR)
    axis.errorbar(
        x[1],
        shown,
        [np.where(y > LEAST_ERROR, low, 0), np.where(y > LEAST_ERROR, high, 0)],
        [np.maximum(x[1] - x[0], 0), np.maximum(x[2] - x[1], 0)],
        fmt=marker + "-",
        ms=size,
        color=colour,
        elinewidth=0.7,
        zorder=3,
    )
    for p, here in zip(points, shown, strict=True):
        setup, seconds = p["setup_s"], p["seconds"][1]
        if setup > 0.1 * seconds:
            axis.plot([seconds, seconds + setup], [here, here], ":", color=colour, lw=0.9)
            axis.plot([seconds], [here], marker, ms=size, mfc="white", mec=colour, mew=0.8)


def _draw_floor(axis: Any, floor: Floor, large: bool) -> None:
    if floor.floor == "model" and floor.model == "smith":
        axis.axhline(floor.relative_rmse, color="#b2182b", lw=1.6, ls="--", zorder=2)
        axis.axhspan(
            max(floor.relative_rmse - 2 * floor.stderr, LEAST_ERROR),
            floor.relative_rmse + 2 * floor.stderr,
            color="#b2182b",
            alpha=0.15,
            lw=0,
        )
        text = f"Smith model to surfaces: {floor.relative_rmse:.2g}"
        # Below the band: what simulates surfaces comes down to it from above.
        low = max(floor.relative_rmse - 2 * floor.stderr, LEAST_ERROR)
        _write(axis, low / 1.06, text, "#b2182b", large, "top")
    elif floor.floor == "reference":
        value = max(floor.relative_rmse, LEAST_ERROR)
        axis.axhline(value, color="0.4", lw=1.1, ls=":", zorder=2)
        below = ", below this edge" if floor.relative_rmse < LEAST_ERROR else ""
        text = f"noise of the reference: {floor.relative_rmse:.1g}{below}"
        _write(axis, value * 1.06, text, "0.35", large, "bottom")


def _write(axis: Any, y: float, text: str, colour: str, large: bool, side: str) -> None:
    if large:
        axis.text(
            0.99, y, text, color=colour, ha="right", va=side, fontsize=7,
            transform=axis.get_yaxis_transform(),
        )  # fmt: skip


def _legend(figure: Any, rows: list[Row]) -> None:
    handles = []
    for method in dict.fromkeys(r.method for r in rows):
        colour, marker = look(method)
        slopes = [r.slope for r in rows if r.method == method and np.isfinite(r.slope)]
        label = method + (f"  (slope {np.median(slopes):.2f})" if slopes else "")
        handles.append(Line2D([], [], color=colour, marker=marker, ms=5, label=label))
    ring = Line2D(
        [],
        [],
        ls="",
        marker="o",
        ms=9,
        mfc="none",
        mec="0.2",
        label="Pareto front, set-up included",
    )
    hollow = Line2D([], [], ls=":", color="0.3", marker="o", mfc="white", label="after set-up")
    figure.legend(handles=[*handles, ring, hollow], loc="upper left", ncols=4, fontsize=7.5)
