"""Picture of a sweep, from its table alone: small multiples, chosen from what varies."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.cli.terminal import measured
from msbsdf_cli.experiments.parts import PARTS
from msbsdf_cli.plots.style import COLOURS, DASHES, order_colour, panels, save
from surfaces.facet import Array

ANGLES = "theta", "phi"
"""Options that are drawn in degrees."""

MOST_PANELS = 48
"""In one picture; the rest are in the table alone, and the title says how many."""

Row = dict[str, str]


@dataclass(frozen=True)
class Drawn:
    """What is drawn of a main table."""

    value: str
    stderr: str
    words: str
    series: tuple[str, ...]
    """Columns that tell the values of one case apart."""
    only: dict[str, tuple[str, ...]]
    """Rows that are drawn, by what the columns hold."""
    signed: bool = False
    largest: bool = False
    """Whether several values of a case stand for their largest."""
    worst: str = "largest value"
    """Of all cases: what a reader wants to know."""
    lowest: bool = False
    """Whether that is the lowest value, and not the one farthest from 0."""
    beside: tuple[str, ...] = ()
    """First words of series that it is not looked for in."""


DRAWN = {
    "own": Drawn(
        "own",
        "own_stderr",
        "modelled minus simulated, or distance, beyond noise",
        ("quantity", "order", "side"),
        {"quantity": ("energy", "total_variation", *PARTS, "whole")},
        signed=True,
        worst="largest difference or distance beyond noise",
    ),
    "albedo": Drawn(
        "albedo",
        "stderr",
        "directional albedo",
        ("method", "channel"),
        {"order": ("all",)},
        worst="lowest albedo",
        lowest=True,
    ),
    "value_per_sr": Drawn(
        "value_per_sr",
        "stderr_per_sr",
        "largest value of BSDF x cos(theta_o) [1/sr]",
        ("method", "channel"),
        {"order": ("all",)},
        largest=True,
    ),
    "energy": Drawn(
        "energy",
        "stderr",
        "energy",
        ("order", "side"),
        {},
        worst="largest energy after the first order",
        beside=("1", "all"),
    ),
}
"""By a column that only that table has; the first of these that a table has."""

MAIN = "theta_i_rad", "quantity", "method"
"""The first column of a command's main table, before which the options stand."""


@dataclass
class Grid:
    """Values over the options that vary, (series, *axes), not a number where there is none."""

    drawn: Drawn
    names: list[str]
    labels: list[list[str]]
    series: list[str]
    value: Array
    stderr: Array

    def extreme(self) -> str:
        """Where the largest value of what matters is, in a sentence."""
        sign, size = (-1, self.value) if self.drawn.lowest else (1, np.abs(self.value))
        beside = [name.partition(" ")[0] in self.drawn.beside for name in self.series]
        size = np.where(np.reshape(beside, (-1, *[1] * (size.ndim - 1))), np.nan, sign * size)
        if not np.isfinite(size).any():
            return ""
        k, *place = at = np.unravel_index(np.nanargmax(size), size.shape)
        where = [self.series[int(k)]] + [
            _title(name, labels[int(i)])
            for name, labels, i in zip(self.names, self.labels, place, strict=True)
        ]
        found = measured(float(self.value[at]), float(self.stderr[at]))
        return f"The {self.drawn.worst} is {found} ({', '.join(filter(None, where))})."


def draw_sweep(table: Path, path: Path) -> Grid:
    """Draw a table of a sweep: lines with bands over one option that is a number, maps over two;
    everything else has panels of its own. What was drawn."""
    grid = read_grid(table)
    numeric = [i for i, labels in enumerate(grid.labels) if _numbers(grid.names[i], labels)]
    numeric.sort(key=lambda i: -len(grid.labels[i]))
    if len(numeric) > 1 and len(grid.labels[numeric[1]]) > 2:
        _draw_maps(grid, numeric[0], numeric[1], path)
    else:
        _draw_lines(grid, numeric[0] if numeric else None, path)
    return grid


def read_grid(table: Path) -> Grid:
    """What is drawn of a table, which is read row by row; of several seeds the mean."""
    names, drawn = _header(table)
    places: list[dict[str, int]] = [{} for _ in names]
    series: dict[str, int] = {}
    for row in _rows(table):
        for name, place in zip(names, places, strict=True):
            place.setdefault(row[name], len(place))
        if _wanted(row, drawn):
            series.setdefault(_series(row, drawn), len(series))
    shape = len(series), *map(len, places)
    value, square, count = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for row in (row for row in _rows(table) if _wanted(row, drawn)):
        where = (p[row[name]] for p, name in zip(places, names, strict=True))
        at = series[_series(row, drawn)], *where
        found, bar = float(row[drawn.value]), float(row[drawn.stderr])
        if not drawn.largest:
            value[at] += found
            square[at] += bar**2
            count[at] += 1
        elif not count[at] or found > value[at]:
            value[at], square[at], count[at] = found, bar**2, 1
    with np.errstate(invalid="ignore", divide="ignore"):
        mean, stderr = value / count, np.sqrt(square) / count
    # What is 0 everywhere, such as light absorbed by mirrors, is no picture.
    shown = [k for k in range(len(series)) if np.nan_to_num(mean[k]).any()] or [0]
    kept = [list(series)[k] for k in shown]
    labels = [list(place) for place in places]
    return Grid(drawn, names, labels, kept, mean[shown], stderr[shown])


def _header(table: Path) -> tuple[list[str], Drawn]:
    with open(table, newline="", encoding="utf-8") as file:
        header = next(csv.reader(file))
    end = min(header.index(name) for name in MAIN if name in header)
    drawn = next(d for name, d in DRAWN.items() if name in header)
    return [name for name in header[:end] if name != "seed"], drawn


def _rows(table: Path) -> Iterator[Row]:
    with open(table, newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def _wanted(row: Row, drawn: Drawn) -> bool:
    if row["failure"] or not row[drawn.value]:
        return False
    if row.get("quantity") == "total_variation" and row["order"] != "all":
        return False
    return all(row[name] in wanted for name, wanted in drawn.only.items())


def _series(row: Row, drawn: Drawn) -> str:
    words = [row[name] for name in drawn.series]
    # Of energies and distances, the energies are many.
    words = ["" if word == "energy" else word.replace("_", " ") for word in words]
    # Parts of a difference are of all light.
    return " ".join(word for word in words if word).removesuffix(" all all")


def _numbers(name: str, labels: list[str]) -> list[float]:
    """The values of an axis, angles in degrees; none where they are no numbers."""
    try:
        numbers = [float(label) for label in labels]
    except ValueError:
        return []
    return [degrees(x) for x in numbers] if name in ANGLES else numbers


def _axis_words(name: str) -> str:
    return f"{name} [degrees]" if name in ANGLES else name


def _rest(grid: Grid, across: list[int]) -> tuple[list[tuple[int, ...]], list[str], str]:
    """Places on the axes that are not drawn across, their titles, and how many are left out."""
    others = [i for i in range(len(grid.names)) if i not in across]
    places = list(product(*(range(len(grid.labels[i])) for i in others)))
    titles = [
        ", ".join(_title(grid.names[i], grid.labels[i][k]) for i, k in zip(others, p, strict=True))
        for p in places
    ]
    left_out = len(places) - MOST_PANELS
    more = f"; {left_out} more in the table" if left_out > 0 else ""
    return places[:MOST_PANELS], titles[:MOST_PANELS], more


def _title(name: str, label: str) -> str:
    found = _numbers(name, [label])
    if found:
        return f"{name} {found[0]:.4g}{'°' * (name in ANGLES)}"
    return f"{name} {label}" if "," in label else label


def _at(array: Array, across: list[int], place: tuple[int, ...]) -> Array:
    """(series, *across) of an array (series, *axes) where the other axes are at `place`."""
    rest = iter(place)
    index = [slice(None) if i in across else next(rest) for i in range(array.ndim - 1)]
    return array[(slice(None), *index)]


def _draw_lines(grid: Grid, across: int | None, path: Path) -> None:
    """A panel for each combination of the other options, a line with error bars for each series."""
    axes = [] if across is None else [across]
    places, titles, more = _rest(grid, axes)
    columns = min(4, len(places))
    figure, panes = panels(
        -(-len(places) // columns), [2.3] * columns, 1.8, sharex=True, sharey=True
    )
    x = (
        np.zeros(1)
        if across is None
        else np.array(_numbers(grid.names[across], grid.labels[across]))
    )
    order = np.argsort(x)
    for pane, place, title in zip(panes.flat, places, titles, strict=False):
        value, stderr = (_at(a, axes, place).reshape(-1, x.size) for a in (grid.value, grid.stderr))
        for k, name in enumerate(grid.series):
            look = {"color": order_colour(k), "ls": DASHES[k // len(COLOURS) % len(DASHES)]}
            bars = 2 * stderr[k][order]
            pane.errorbar(x[order], value[k][order], bars, label=name, capsize=1.5, **look)
        if grid.drawn.signed:
            pane.axhline(0, color="0.5", lw=0.6)
        pane.set_title(title)
    for pane in panes.flat[len(places) :]:
        pane.set_visible(False)
    if across is not None:
        for pane in panes[-1]:
            pane.set_xlabel(_axis_words(grid.names[across]))
    figure.supylabel(grid.drawn.words, x=0.01, fontsize=8)
    handles, names = panes[0, 0].get_legend_handles_labels()
    room = int(figure.get_figwidth() / 1.5)
    figure.legend(handles, names, loc="upper left", ncols=min(len(names), room))
    figure.text(0.01, 0.01, f"bars: two standard errors{more}", fontsize=6, color="0.35")
    save(figure, path)


def _draw_maps(grid: Grid, x: int, y: int, path: Path) -> None:
    """A row for each combination of the other options, a map for each series; a dot where the value
    is within two standard errors of 0."""
    places, titles, more = _rest(grid, [x, y])
    widths = [2.0] * len(grid.series)
    figure, panes = panels(
        len(places), widths, 1.6, (0.55, 0.5), right=0.5, sharex=True, sharey=True
    )
    across, up = (np.array(_numbers(grid.names[i], grid.labels[i])) for i in (x, y))
    for row, (place, title) in enumerate(zip(places, titles, strict=True)):
        value, stderr = (_at(a, [x, y], place) for a in (grid.value, grid.stderr))
        if x > y:
            value, stderr = (a.swapaxes(1, 2) for a in (value, stderr))
        for k, pane in enumerate(panes[row]):
            scale = _scale(grid.drawn, grid.value[k])
            columns, lines = np.argsort(across), np.argsort(up)
            drawn, bars = (a[k][np.ix_(columns, lines)].T for a in (value, stderr))
            mesh = pane.pcolormesh(across[columns], up[lines], drawn, shading="nearest", **scale)
            at = np.argwhere(np.abs(drawn) < 2 * bars)
            pane.plot(across[columns][at[:, 1]], up[lines][at[:, 0]], "k.", ms=1.5)
            pane.grid(visible=False)
            name = grid.series[k] if row == 0 else ""
            pane.set_title(" | ".join(words for words in (name, title) if words), fontsize=7)
            figure.colorbar(mesh, ax=pane, pad=0.03).ax.tick_params(labelsize=6)
        panes[row, 0].set_ylabel(_axis_words(grid.names[y]))
    for pane in panes[-1]:
        pane.set_xlabel(_axis_words(grid.names[x]))
    figure.suptitle(grid.drawn.words, fontsize=8)
    most = float(np.nanmax(grid.stderr))
    dots = f"dots: within two standard errors of 0; largest standard error {most:.1g}{more}"
    figure.text(0.01, 0.01, dots, fontsize=6, color="0.35")
    save(figure, path)


def _scale(drawn: Drawn, values: Array) -> dict[str, Any]:
    """Colours of one series, the same in all its maps."""
    limit = float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 1.0
    if drawn.signed:
        return {"cmap": "RdBu_r", "vmin": -limit, "vmax": limit}
    return {"cmap": "viridis", "vmin": 0, "vmax": limit}
