"""slice.png: methods side by side along a slice, order by order, from slice.csv."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.lines import Line2D

from msbsdf_cli.plots.style import in_degrees, key, look, method_lines, panels, save, short_ticks
from msbsdf_cli.results.files import Table
from surfaces.facet import Array

NUMBERS = ("theta_i_rad", "theta_o_rad", "phi_o_rad", "value_per_sr", "stderr_per_sr")


def draw_slices(table: Table, path: Path) -> None:
    """From slice.csv: a row for each incident angle, a column for each order; a line for each
    method, with bars of two standard errors here and there. Of three channels the line is the
    luminance, and strips below show the colour that each method sends there, in their order."""
    columns = {name: np.array(table[name]) for name in table}
    angles, orders, methods = (
        list(dict.fromkeys(table[name])) for name in ("theta_i_rad", "order", "method")
    )
    raised = 0.07 * len(methods) if len(set(table["channel"])) == len(RGB) else 0.0
    figure, axes = panels(len(angles), [2.0] * len(orders), 1.5, (0.52, 0.55 + raised))
    # Each method's bars are elsewhere: bands would hide one another.
    turns = [(k, len(methods)) for k in range(len(methods))]
    for i, theta in enumerate(angles):
        for j, order in enumerate(orders):
            axis = axes[i, j]
            here = (columns["theta_i_rad"] == theta) & (columns["order"] == order)
            lines = [_channels(columns, here & (columns["method"] == m)) for m in methods]
            largest = max(_draw(axis, *pair) for pair in zip(lines, methods, turns, strict=True))
            axis.set_title(f"light from {in_degrees(theta)}, order {order}", pad=6 + 72 * raised)
            short_ticks(axis)
            axis.set_ylim(0, 1.15 * largest if largest > 0 else 1)
            axis.set_xticks(TICKS[TRANSMITS if _transmits(lines) else 0])
            if raised:
                _swatches(axis, lines)
            if i == len(angles) - 1:
                axis.set_xlabel("angle from the zenith, degrees")
        axes[i, 0].set_ylabel("BSDF x cos(theta_o)  [1/sr]")
    handles = method_lines(methods)
    if raised:
        handles.append(Line2D([], [], ls="", label="strips: colour of that light, in this order"))
    key(figure, handles, raised)
    save(figure, path)


RGB = np.array([0.2126, 0.7152, 0.0722])
"""Luminance of linear red, green and blue (ITU-R BT.709)."""

TICKS = ([-90, -45, 0, 45, 90], [-180, -90, 0, 90, 180])
TRANSMITS = 1
"""Ticks of a slice with light below the surface."""


class Line(NamedTuple):
    """One method in one panel: angles (n,) in degrees, values and errors (channels, n)."""

    angle: Array
    value: Array
    stderr: Array


def _channels(columns: dict[str, Array], mine: Array) -> Line:
    """The far half of the slice is at positive angles, transmission beyond 90 degrees."""
    names = list(dict.fromkeys(columns["channel"][mine].tolist()))
    found = []
    for name in names:
        rows = mine & (columns["channel"] == name)
        data = {k: columns[k][rows] for k in NUMBERS}
        behind = np.cos(data["phi_o_rad"] - data["phi_o_rad"][-1]) < 0
        angle = np.degrees(np.where(behind, -data["theta_o_rad"], data["theta_o_rad"]))
        order = np.argsort(angle)
        found.append([a[order] for a in (angle, data["value_per_sr"], data["stderr_per_sr"])])
    if not found:
        return Line(np.zeros(0), np.zeros((1, 0)), np.zeros((1, 0)))
    angle, value, stderr = (np.array(a) for a in zip(*found, strict=True))
    return Line(angle[0], value, stderr)


def _transmits(lines: list[Line]) -> bool:
    return any(line.angle.size and np.abs(line.angle).max() > 90 for line in lines)


def _draw(axis: Any, line: Line, method: str, turn: tuple[int, int]) -> float:
    """Draw the luminance, or the one channel that there is; its largest value."""
    if line.angle.size == 0:
        return 0.0
    weights = RGB if len(line.value) == len(RGB) else np.full(len(line.value), 1 / len(line.value))
    value = weights @ line.value
    # Channels follow the same paths: their errors go together.
    bars = 2 * weights @ line.stderr
    every = max(line.angle.size // 12, 1)
    place = turn[0] * every // turn[1], every
    here = {"errorevery": place, "markevery": place}
    axis.errorbar(line.angle, value, bars, **look(method), ms=3, elinewidth=0.6, **here)
    return float(value.max())


def _swatches(axis: Any, lines: list[Line]) -> None:
    """Strips above with the colour of the light that each method sends each way, as bright as can
    be, the first method on top; white where it sends none."""
    height = 0.045
    for k, line in enumerate(reversed(lines)):
        if line.angle.size == 0:
            continue
        brightest = line.value.max(axis=0)
        colours = np.where(brightest > 0, line.value / np.maximum(brightest, 1e-300), 1)
        strip = axis.inset_axes((0, 1.02 + height * k, 1, 0.9 * height))
        strip.imshow(colours.T[None] ** (1 / 2.2), aspect="auto", interpolation="nearest")
        strip.axis("off")
