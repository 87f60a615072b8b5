"""slice.png: methods side by side along a slice, order by order, from slice.csv."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from msbsdf_cli.plots.style import BAND_ROOM, DASHES, method_look, panels, save
from msbsdf_cli.results.files import Table
from surfaces.facet import Array

NUMBERS = ("theta_i_rad", "theta_o_rad", "phi_o_rad", "value_per_sr", "stderr_per_sr")


def draw_slices(table: Table, path: Path) -> None:
    """From slice.csv: a row for each incident angle, a column for each order; a line for each
    method with a band of two standard errors. Three channels are drawn in their colours, each
    method with its own dashes.
    """
    columns = {name: np.array(table[name]) for name in table}
    angles, orders, methods, channels = (
        list(dict.fromkeys(table[name])) for name in ("theta_i_rad", "order", "method", "channel")
    )
    figure, axes = panels(len(angles), [2.0] * len(orders), 1.5, (0.45, 0.55))
    for i, theta in enumerate(angles):
        for j, order in enumerate(orders):
            axis = axes[i, j]
            here = (columns["theta_i_rad"] == theta) & (columns["order"] == order)
            for m, method in enumerate(methods):
                for channel in channels:
                    mine = here & (columns["method"] == method) & (columns["channel"] == channel)
                    _line(axis, {k: columns[k][mine] for k in NUMBERS}, m, channel)
            axis.set_title(f"theta_i = {theta:.4g}, order {order}")
            # Bands of what hardly a walk has found are wide; the lines are what is to be seen.
            largest = columns["value_per_sr"][here].max()
            axis.set_ylim(0, BAND_ROOM * largest if largest > 0 else 1)
            if i == len(angles) - 1:
                axis.set_xlabel("angle from the zenith, degrees")
        axes[i, 0].set_ylabel("BSDF x cos(theta_o)  [1/sr]")
    handles = [
        Line2D([], [], **_look(m, channels[0]), label=method) for m, method in enumerate(methods)
    ]
    figure.legend(handles=handles, loc="upper left", ncols=4)
    save(figure, path)


def _line(axis: Any, data: dict[str, Array], method: int, channel: str) -> None:
    """The far half of the slice is drawn at positive angles, transmission beyond 90 degrees."""
    if data["theta_o_rad"].size == 0:
        return
    behind = np.cos(data["phi_o_rad"] - data["phi_o_rad"][-1]) < 0
    angle = np.degrees(np.where(behind, -data["theta_o_rad"], data["theta_o_rad"]))
    order = np.argsort(angle)
    value, error = (data[name][order] for name in ("value_per_sr", "stderr_per_sr"))
    look, band = _look(method, channel), (value - 2 * error, value + 2 * error)
    axis.plot(angle[order], value, **look)
    axis.fill_between(angle[order], *band, color=look["color"], alpha=0.2, lw=0)


def _look(method: int, channel: str) -> dict[str, Any]:
    """A channel's colour and the method's dashes; where there is one, the look of the method."""
    named = {"red": "#c1272d", "green": "#2e8b3d", "blue": "#1f4fbf"}
    if not channel:
        return method_look(method)
    colour = named.get(channel, method_look(method)["color"])
    return {"color": colour, "ls": DASHES[method % len(DASHES)]}
