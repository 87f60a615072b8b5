"""tradeoff.png: error against time, one lobe at a time, and over all angles."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from msbsdf_cli.experiments.tradeoff.floors import Floor
from msbsdf_cli.experiments.tradeoff.rows import Row
from msbsdf_cli.plots.labels import LETTER, name_curves
from msbsdf_cli.plots.style import in_degrees, look, save
from surfaces.facet import Array

SMITH = "#b2182b"
WIDTH = 5.45
"""Inches of the large panel."""
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
    together = over_angles(rows, len(angles))
    points = {theta: [as_point(r) for r in rows if r.theta_i_rad == theta] for theta in angles}
    times = _times([*together, *(p for mine in points.values() for p in mine)])
    limits = times + _errors(rows, floors)
    small = [] if len(angles) == 1 else angles
    columns = -(-len(small) // 2)
    width = 6.4 + 2.3 * columns
    figure = Figure((width, 5.2))
    edges = {"bottom": 0.09, "top": 0.89}
    main = figure.add_gridspec(1, 1, left=0.75 / width, right=(0.75 + WIDTH) / width, **edges)
    axis = figure.add_subplot(main[0])
    _draw_panel(axis, together, _floors_over_angles(floors), limits, large=True)
    axis.set_title(
        f"all {len(angles)} angles: root mean square error, sum of times"
        if small
        else f"light from {in_degrees(angles[0])}"
    )
    axis.set_ylabel(f"relative RMSE of {quantity}")
    if small:
        grid = {"left": 6.75 / width, "right": 1 - 0.15 / width, "hspace": 0.15, "wspace": 0.1}
        places = figure.add_gridspec(2, columns, **grid, **edges)
    for i, theta in enumerate(small):
        panel = figure.add_subplot(places[i % 2, i // 2])
        mine = [f for f in floors if f.theta_i_rad == theta]
        _draw_panel(panel, points[theta], mine, limits, large=False)
        panel.set_title(f"light from {in_degrees(theta)}")
        panel.tick_params(labelleft=i < 2)
        if i % 2 == 0 and i + 1 < len(small):
            panel.set_xlabel("")
            panel.tick_params(labelbottom=False)
    _legend(figure)
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
        point["error"], point["stderr"] = _root_mean_square(error, stderr)
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
        values, errors = (
            np.array([getattr(f, n) for f in mine]) for n in ("relative_rmse", "stderr")
        )
        together.append(Floor(0, kind, model, *_root_mean_square(values, errors)))
    return together


def _root_mean_square(values: Array, stderr: Array) -> tuple[float, float]:
    """Root of the mean square, and its standard error; where all values are 0, as if all were the
    same, which has no more."""
    weights = values if values.any() else np.ones(len(values))
    error = np.sqrt(((weights * stderr) ** 2).sum() / (weights**2).sum() / len(values))
    return float(np.sqrt((values**2).mean())), float(error)


def _times(points: list[Point]) -> tuple[float, float]:
    """Limits of the times of all panels, from what is least without set-up."""
    least = min(float(p["seconds"][1 if p["setup_s"] else 0]) for p in points)
    return least / 1.5, 1.5 * max(float(p["seconds"][2]) + p["setup_s"] for p in points)


def _errors(rows: list[Row], floors: list[Floor]) -> tuple[float, float]:
    """Limits of the errors: the same on all charts with floors, those of the rows elsewhere."""
    if floors:
        return LEAST_ERROR * 0.7, 2.0
    errors = [r.relative_rmse for r in rows]
    return min(errors) / 2, max(errors) * 2


def _draw_panel(
    axis: Any,
    points: list[Point],
    floors: list[Floor],
    limits: tuple[float, ...],
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
    axis.set_xlim(*limits[:2])
    axis.set_ylim(*limits[2:])
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_major_locator(LogLocator(numticks=10))
    axis.set_xlabel("seconds, set-up included", labelpad=1)
    named: dict[str, tuple[float, str]] = {}
    for floor in floors:
        named |= _draw_floor(axis, floor)
    if large:
        _name(axis, points, named)


def _name(axis: Any, points: list[Point], floors: dict[str, tuple[float, str]]) -> None:
    """Each method's name at an end of its curve, and those of floors somewhere along them."""
    curves: dict[str, tuple[Array, str]] = {}
    left, right = np.log10(axis.get_xlim())
    lines = [np.transpose([(p["seconds"][1], max(p["error"], LEAST_ERROR)) for p in points])]
    for text, (y, colour) in floors.items():
        lines.append(np.array([np.logspace(left, right, 200), np.full(200, y)]))
        # Half of the text is to either side.
        inset = (0.6 * LETTER * len(text)) / WIDTH * (right - left)
        curves[text] = np.array([10.0 ** np.array([left + inset, right - inset]), [y, y]]), colour
    for method in dict.fromkeys(p["method"] for p in points):
        mine = [p for p in points if p["method"] == method]
        x, y = np.transpose([(p["seconds"][1] + p["setup_s"], p["error"]) for p in mine])
        curves[method] = np.array([x, np.maximum(y, LEAST_ERROR)]), look(method)["color"]
    name_curves(axis, curves, np.concatenate(lines, axis=1))


def _draw_method(axis: Any, method: str, points: list[Point], size: float) -> None:
    style = look(method)
    colour, marker = style["color"], style["marker"]
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


def _draw_floor(axis: Any, floor: Floor) -> dict[str, tuple[float, str]]:
    """Draw it; what it says, where and in which colour, if it is drawn."""
    value, shown = floor.relative_rmse, max(floor.relative_rmse, LEAST_ERROR)
    if floor.floor == "model" and floor.model == "smith":
        low = max(value - 2 * floor.stderr, LEAST_ERROR)
        axis.axhline(value, color=SMITH, lw=1.6, ls="--", zorder=2)
        axis.axhspan(low, value + 2 * floor.stderr, color=SMITH, alpha=0.15, lw=0)
        known = f"{value:.2g}" if value > 0 else f"below {2 * floor.stderr:.2g}"
        return {f"Smith model to surfaces: {known}": (shown, SMITH)}
    if floor.floor == "reference":
        axis.axhline(shown, color="0.4", lw=1.1, ls=":", zorder=2)
        below = ", below this edge" if value < LEAST_ERROR else ""
        return {f"noise of the reference: {value:.1g}{below}": (shown, "0.35")}
    return {}


def _legend(figure: Any) -> None:
    style: dict[str, Any] = {"marker": "o", "color": "0.2"}
    ring = Line2D([], [], **style, ls="", ms=9, mfc="none", label="Pareto front, set-up included")
    hollow = Line2D([], [], **style, ls=":", mfc="white", label="without set-up")
    figure.legend(handles=[ring, hollow], loc="upper left", ncols=2)
