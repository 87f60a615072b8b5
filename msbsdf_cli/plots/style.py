"""How pictures look: for print, and told apart without colour where it matters."""

import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.plots import FOR_PAGE, FORMAT, PAGE_OF
from msbsdf_cli.scene import in_degrees as in_degrees

mpl.rcParams.update(
    {
        "font.size": 8,
        "axes.titlesize": 8,
        # At a place of its own, or it is sought for anew whenever anything is drawn.
        "axes.titley": 1.0,
        "axes.labelsize": 8,
        "legend.fontsize": 7,
        "xtick.labelsize": 7,
        "ytick.labelsize": 7,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "0.92",
        "axes.axisbelow": True,
        "lines.linewidth": 1.1,
        "legend.frameon": False,
        # Equal pictures are equal files.
        "svg.hashsalt": "msbsdf",
    }
)

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Wong's palette, told apart by colour-blind eyes; one for each order."""
DASHES = ("-", "--", "-.", ":")
SIMULATED = (
    {"simulate-one-mesh": ("#999999", "s"), "walk-memory-2": ("#b15bd8", "*")},
    ("#000000", "p"),
)
"""Colours and markers of what is no method: of light traced on explicit surfaces, and of light that
is only counted."""
HALO = [withStroke(linewidth=1.5, foreground="white")]
"""About text that stands on lines or pictures."""
DOTS_PER_INCH = 130
BOTH = "png", "svg"
"""What the page may show of a picture of lines: a bitmap where there are too many of them."""


def panels(
    rows: int,
    widths: Sequence[float],
    height: float,
    gap: tuple[float, float] = (0.45, 0.62),
    right: float = 0.15,
    **keywords: Any,
) -> tuple[Any, Any]:
    """A figure and its axes (rows, columns), sizes in inches, laid out at once: Matplotlib's own
    layout draws everything three times."""
    left, bottom, top = 0.85, 0.5, 0.6
    across = left + sum(widths) + gap[0] * (len(widths) - 1) + right
    up = bottom + rows * height + gap[1] * (rows - 1) + top
    figure = Figure((across, up))
    axes = figure.subplots(rows, len(widths), squeeze=False, width_ratios=widths, **keywords)
    figure.subplots_adjust(
        left / across,
        bottom / up,
        1 - right / across,
        1 - top / up,
        gap[0] * len(widths) / sum(widths),
        gap[1] / height,
    )
    return figure, axes


def order_colour(index: int) -> str:
    """Colour of the order in place `index`."""
    return COLOURS[index % len(COLOURS)]


def look(name: str) -> dict[str, Any]:
    """Colour and marker of the line of a method, or of `simulate`, the same on every chart."""
    if name not in METHODS:
        colour, marker = SIMULATED[0].get(name, SIMULATED[1])
    else:
        colour, marker = METHODS[name].traits.colour, METHODS[name].traits.marker
    return {"color": colour, "marker": marker}


def short_ticks(axis: Any) -> None:
    """Few numbers up the axis, as short as can be: none reaches into the panel to its left."""
    axis.yaxis.set_major_locator(MaxNLocator(4))
    axis.yaxis.set_major_formatter(lambda x, _: re.sub(r"^(-?)0\.", r"\1.", f"{x:g}"))


def method_lines(names: Iterable[str]) -> list[Line2D]:
    """A line of each method, for a legend."""
    return [Line2D([], [], label=name, **look(name)) for name in dict.fromkeys(names)]


def key(figure: Any, handles: Sequence[Any], raised: float = 0) -> None:
    """A legend above all panels in as many columns as fit; the figure grows where it has more than
    the two lines that `panels` leaves room for, and where titles are raised by some inches."""
    longest = max(len(handle.get_label()) for handle in handles)
    columns = max(1, int(figure.get_figwidth() / (0.45 + 0.055 * longest)))
    figure.legend(handles=handles, loc="upper left", ncols=columns)
    height, edges = figure.get_figheight(), figure.subplotpars
    more = raised + 0.155 * max(-(-len(handles) // columns) - 2, 0)
    figure.set_figheight(height + more)
    bottom, top = (edge * height / (height + more) for edge in (edges.bottom, edges.top))
    figure.subplots_adjust(bottom=bottom, top=top)


def save(figure: Any, path: Path) -> None:
    """Write a PNG, or what is wanted instead. Beside it lies, until the page of the report is
    written, what is for that alone: a PNG, and an SVG of a picture of lines."""
    wanted = os.environ.get(FORMAT, "png")
    # To seek with `findobj` makes every tick of every axis.
    axes = [*figure.axes, *(inset for axis in figure.axes for inset in axis.child_axes)]
    drawn = (artist for axis in axes for artist in (*axis.collections, *axis.images))
    maps = [artist for artist in drawn if isinstance(artist, (QuadMesh, AxesImage))]
    for mesh in maps:
        # Dense maps are bitmaps in every format.
        mesh.set_rasterized(True)
    in_page = () if os.environ.get(PAGE_OF) != str(path.parent) else ("png",) if maps else BOTH
    for suffix in dict.fromkeys((wanted, *in_page)):
        place = path.with_suffix(f".{suffix}" if suffix == wanted else f"{FOR_PAGE}.{suffix}")
        made = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(suffix)
        figure.savefig(place, dpi=DOTS_PER_INCH, facecolor="white", metadata=made)
