"""furnace.png: what directional albedos lack, of two roughnesses at the azimuths of the axes."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from msbsdf_cli.plots.style import key, look, method_lines, panels, save
from msbsdf_cli.results.files import Table
from surfaces.facet import Array

FAR = 1.0
"""Percent of the light: methods that are off by more somewhere have rows of their own."""
LEAST = 0.01
"""Percent; on the logarithmic axis of those rows less is drawn at the edge."""

Curve = tuple[Array, Array]
"""How far an albedo is off, and the standard error of that, in percent of the light that comes in,
over angles."""


def draw_furnace(table: Table, path: Path, against: str | None = None) -> None:
    """From furnace.csv: how far each method's albedo is from that of the method `against`, or else
    from 1, with bars of two standard errors. A column for each roughness; for each channel a row of
    methods that are far off, on a logarithmic axis, and one of the others, side by side."""
    columns = {name: np.array(values) for name, values in table.items()}
    columns = {name: values[columns["order"] == "all"] for name, values in columns.items()}
    alphas = dict.fromkeys(zip(columns["alpha_x"], columns["alpha_y"], strict=True))
    shown = [(alpha, phi) for alpha in alphas for phi in _axes_of(columns, alpha)]
    methods, channels = (dict.fromkeys(columns[name].tolist()) for name in ("method", "channel"))
    curves = {
        (method, channel): [_off(columns, *place, method, channel, against) for place in shown]
        for channel in channels
        for method in methods
        if method != against
    }
    far = {method for (method, _), row in curves.items() if any(_is_far(*c) for c in row)}
    rows = [
        (channel, is_far, [m for m in methods if m != against and (m in far) == is_far])
        for channel in channels
        for is_far in (True, False)
    ]
    rows = [row for row in rows if row[2]]
    figure, axes = panels(
        len(rows), [2.2] * len(shown), 1.4, (0.12, 0.16), sharex=True, sharey="row"
    )
    near = [curves[m, channel] for channel, is_far, members in rows if not is_far for m in members]
    widest = max((float((np.abs(off) + 2 * s).max()) for row in near for off, s in row), default=1)
    for line, (channel, is_far, members) in zip(axes, rows, strict=True):
        for j, axis in enumerate(line):
            (_draw_far if is_far else _draw_near)(axis, {m: curves[m, channel][j] for m in members})
        if not is_far:
            line[0].set_ylim(-1.05 * widest, 1.05 * widest)
        off = f"albedo - {against or 1}"
        line[0].set_ylabel(f"{channel} {f'|{off}|' if is_far else off}, %".strip())
    theta = [f"{np.degrees(t):.3g}" for t in dict.fromkeys(columns["theta_i_rad"].tolist())]
    axes[0, 0].set_xticks(range(len(theta)), theta)
    for j, (alpha, phi) in enumerate(shown):
        turned = "" if alpha[0] == alpha[1] else f", phi = {np.degrees(phi):g}°"
        axes[0, j].set_title(f"alpha = {alpha_name(alpha)}{turned}")
        axes[-1, j].set_xlabel("theta_i, degrees", labelpad=1)
    handles = method_lines(m for m in methods if m != against)
    if far:
        gain: dict[str, Any] = {"color": "0.3", "marker": "o", "mfc": "white", "ls": ""}
        handles.append(Line2D([], [], label="hollow: more light than that", **gain))
    key(figure, handles)
    save(figure, path)


def _off(
    columns: dict[str, Array], alpha: Any, phi: float, method: str, channel: str, truth: str | None
) -> Curve:
    value, stderr = _albedo(columns, alpha, phi, method, channel)
    of, doubt = (1.0, 0.0) if truth is None else _albedo(columns, alpha, phi, truth, channel)
    return 100 * (value - of), 100 * np.hypot(stderr, doubt)


def _is_far(off: Array, stderr: Array) -> bool:
    # Five standard errors: there are hundreds of points, of which noise is to move none.
    return bool((np.abs(off) - 5 * stderr > FAR).any())


def _draw_far(axis: Any, curves: dict[str, Curve]) -> None:
    """Points of what is lost; those of what is won are hollow."""
    axis.set_yscale("log")
    axis.set_ylim(LEAST * 0.8, 130)
    axis.yaxis.set_major_formatter("{x:g}")
    for method, (off, stderr) in curves.items():
        size, place = np.maximum(np.abs(off), LEAST), np.arange(len(off))
        low = np.minimum(2 * stderr, size - LEAST)
        bars = np.where(size > LEAST, [low, 2 * stderr], 0)
        axis.errorbar(place, size, bars, elinewidth=0.7, ms=3.5, **look(method))
        won = off > LEAST
        axis.plot(place[won], size[won], ms=3.5, mfc="white", zorder=3, **look(method) | {"ls": ""})


def _draw_near(axis: Any, curves: dict[str, Curve]) -> None:
    axis.axhline(0, color="0.5", lw=0.6)
    for i, (method, (off, stderr)) in enumerate(curves.items()):
        place = np.arange(len(off)) + 0.8 * ((i + 0.5) / len(curves) - 0.5)
        style = look(method) | {"ls": ""}
        axis.errorbar(place, off, 2 * stderr, elinewidth=0.7, ms=2.5, **style)


def _axes_of(columns: dict[str, Array], alpha: Any) -> list[float]:
    """The azimuths to draw curves at: of the x and y axes, or the only one."""
    mine = (columns["alpha_x"] == alpha[0]) & (columns["alpha_y"] == alpha[1])
    azimuths = np.unique(columns["phi_i_rad"][mine])
    return azimuths.tolist() if len(azimuths) == 1 else [0.0, np.pi / 2]


def _albedo(columns: dict[str, Array], alpha: Any, phi: float, method: str, channel: str) -> Any:
    mine = (
        (columns["alpha_x"] == alpha[0])
        & (columns["alpha_y"] == alpha[1])
        & (columns["phi_i_rad"] == phi)
        & (columns["method"] == method)
        & (columns["channel"] == channel)
    )
    return columns["albedo"][mine], columns["stderr"][mine]


def alpha_name(alpha: tuple[float, float]) -> str:
    """One roughness, or two."""
    return ", ".join(f"{a:g}" for a in dict.fromkeys(alpha))
