"""spectra.png: surfaces that the Smith model takes for one, and how far it is off on each."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from msbsdf_cli.plots.style import COLOURS, in_degrees, save
from msbsdf_cli.plots.surface import lit_view
from surfaces.facet import Array
from surfaces.surface import Surface

MARKS = "osD^vP*X"

STRIP = 0.45
"""Height of a strip over that of a whole view of a surface."""


def draw_spectra(
    path: Path,
    alpha: tuple[float, float],
    surfaces: list[tuple[str, Callable[[], Surface]]],
    errors: list[tuple[Array, Array, Array]],
) -> None:
    """A strip of each surface, lit from a side; below, by how much the model's energy of multiple
    bounces is too high, relative to that on surfaces, over the angle of incidence."""
    number = len(surfaces)
    columns = min(number, 4)
    strips = -(-number // columns)
    size = max(2.2 * columns, 6.2), 0.85 * strips + 3.4
    figure = Figure(size, layout="constrained")
    figure.suptitle(_title(alpha), fontsize=8)
    grid = figure.add_gridspec(strips + 1, columns, height_ratios=[*(0.85,) * strips, 3.2])
    chart = figure.add_subplot(grid[-1, :])
    every = []
    for k, ((name, make), error) in enumerate(zip(surfaces, errors, strict=True)):
        axis = figure.add_subplot(grid[k // columns, k % columns])
        colour = COLOURS[k % len(COLOURS)]
        axis.imshow(_strip(make(), alpha), cmap="gray", vmin=0, vmax=1)
        axis.set_title(name, color=colour)
        axis.axis("off")
        _line(chart, k, number, name, colour, error)
        every.append(error[0])
    chart.axhline(0, color="0.3", lw=0.8)
    chart.set_xticks(sorted(set(np.concatenate(every).tolist())))
    chart.xaxis.set_major_formatter(lambda x, _: in_degrees(x))
    chart.set_xlabel("light from")
    chart.set_ylabel("Smith's energy of multiple bounces\nis too high by, % (bars: 1 std. error)")
    chart.legend(ncols=columns, loc="lower left", bbox_to_anchor=(0, 1))
    save(figure, path)


def _title(alpha: tuple[float, float]) -> str:
    rough = ", ".join(f"{a:.3g}" for a in dict.fromkeys(alpha))
    return f"Surfaces of roughness {rough} and one distribution of slopes; heights correlate as"


def _line(
    axis: Any, k: int, number: int, name: str, colour: str, error: tuple[Array, Array, Array]
) -> None:
    """What is known of it; beside each other, where bars would lie on each other."""
    theta, value, stderr = error
    known = np.isfinite(value)
    x = theta[known] + 0.012 * (k - (number - 1) / 2)
    look = {"color": colour, "marker": MARKS[k % len(MARKS)], "ms": 4, "capsize": 2}
    axis.errorbar(x, 100 * value[known], 100 * stderr[known], label=name, **look)


def _strip(surface: Surface, alpha: tuple[float, float]) -> Array:
    view = lit_view(surface, surface.stretch(*alpha), alpha)
    edge = round(len(view) * (1 - STRIP) / 2)
    return view[edge : len(view) - edge]
