"""heitz_8.png, heitz_13.png and heitz_14.png"""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LightSource
from matplotlib.lines import Line2D

from msbsdf_cli.experiments.figures.settings import Tables
from msbsdf_cli.plots.figures.rows import values, where
from msbsdf_cli.plots.style import COLOURS, in_degrees, panels, save, short_ticks
from msbsdf_cli.results.files import Table


def draw_heitz_8(tables: Tables, directory: Path) -> None:
    """The density of the next facet's height, and as the walk draws it."""
    words = {"model": "density of Eq. 28", "walk": "random walks"}
    _draw(tables["heitz_8"], words, directory / "heitz_8.png")


def draw_heitz_14(tables: Tables, directory: Path) -> None:
    """Free paths on explicit surfaces, and of the model."""
    words = {"walk": "Smith model", "surfaces": "Beckmann surfaces"}
    _draw(tables["heitz_14"], words, directory / "heitz_14.png")


def _draw(table: Table, words: dict[str, str], path: Path) -> None:
    """A row for each height of start, a column for each direction; `words` names the line, then
    the points."""
    both = product(values(table, "height_start"), values(table, "theta_r_rad"))
    shown = [(theta, start) for start, theta in both if _meets(table, theta, start)]
    rows = -(-len(shown) // ACROSS)
    figure, axes = panels(rows, [1.85] * ACROSS, 1.05, (0.35, 0.62), sharex=True)
    for axis in axes.flat[len(shown) :]:
        axis.set_visible(False)
    for axis, place in zip(axes.flat, shown, strict=False):
        _panel(axis, table, list(words), *place)
    for axis in axes[-1]:
        axis.set_xlabel("next height [std. dev.]")
    for axis in axes[:, 0]:
        axis.set_ylabel("density")
    left_out = len(values(table, "height_start")) * len(values(table, "theta_r_rad")) - len(shown)
    if left_out:
        words_of_rest = f"{left_out} more are in the table: less than 1 in 1000 meets a facet."
        figure.text(0.98, 0.99, words_of_rest, fontsize=7, ha="right", va="top")
    points: dict[str, Any] = {"color": COLOURS[1], "marker": "o", "ms": 2, "ls": ""}
    kinds: tuple[dict[str, Any], ...] = {"color": COLOURS[0]}, points
    named = zip(kinds, words.values(), strict=True)
    handles = [Line2D([], [], **look, label=label) for look, label in named]
    figure.legend(handles=handles, loc="upper left", ncols=2)
    save(figure, path)


ACROSS = 4


def _meets(table: Table, theta: float, start: float) -> bool:
    """Whether more than a thousandth of the light meets a facet."""
    rows = where(table, theta_r_rad=theta, height_start=start)
    escapes = rows["probability"][rows["height_low"] == np.inf]
    return bool(escapes.size and escapes.min() < 0.999)


def _panel(axis: Any, table: Table, sources: list[str], theta: float, start: float) -> None:
    escapes = []
    for k, source in enumerate(sources):
        rows = where(table, source=source, theta_r_rad=theta, height_start=start)
        finite = np.isfinite(rows["height_low"]) & np.isfinite(rows["height_high"])
        low, high, value, error = (
            rows[name][finite] for name in ("height_low", "height_high", "probability", "stderr")
        )
        middle, width = (low + high) / 2, high - low
        if k == 0:
            axis.stairs(value / width, np.append(low, high[-1:]), color=COLOURS[0])
        else:
            look: dict[str, Any] = {"fmt": "o", "ms": 1.6, "lw": 0.7, "color": COLOURS[1]}
            # Where no more than noise is known there is no point.
            seen = value > error
            axis.errorbar(middle[seen], (value / width)[seen], (error / width)[seen], **look)
        escaped = rows["probability"][rows["height_low"] == np.inf]
        escapes += [f"{escaped[0]:.3f}"] if escaped.size else ["unknown"]
    place = "outside" if np.isinf(start) else f"h = {start:g}"
    title = f"from {place} towards {in_degrees(theta)}\nescape {' / '.join(escapes)}"
    axis.set_title(title, fontsize=6.5)
    axis.set_xlim(-4, 4)
    axis.set_ylim(bottom=0)
    short_ticks(axis)


def draw_heitz_13(tables: Tables, directory: Path) -> None:
    """The surface from above, lit from the upper left."""
    table = tables["heitz_13"]
    x, y, z = (np.asarray(table[name]) for name in ("x", "y", "height"))
    side = round(np.sqrt(z.size))
    heights, step = z.reshape(side, side).T, x.max() / (side - 1)
    figure, axes = panels(1, [3.2, 3.2], 3.2, (0.6, 0.5), right=0.75)
    around = {"origin": "lower", "extent": (0, x.max(), 0, y.max())}
    light = LightSource(azdeg=315, altdeg=40).hillshade(heights, dx=step, dy=step)
    axes[0, 0].imshow(light, cmap="gray", **around)
    axes[0, 0].set_title("lit from the upper left, 40° above the horizon")
    drawn = axes[0, 1].imshow(heights, cmap="viridis", **around)
    axes[0, 1].set_title("height")
    for axis in axes[0]:
        axis.grid(False)
        axis.set_xlabel("x [standard deviations of height]")
    bar = figure.colorbar(drawn, cax=axes[0, 1].inset_axes((1.03, 0, 0.05, 1)))
    bar.set_label("standard deviations")
    save(figure, directory / "heitz_13.png")
