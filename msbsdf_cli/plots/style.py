"""How pictures look: for print, and told apart without colour where it matters."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.collections import QuadMesh

from msbsdf_cli.plots import FORMAT
from msbsdf_cli.scene import in_degrees as in_degrees

plt.rcParams.update(
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
    }
)

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Wong's palette, told apart by colour-blind eyes; one for each order."""
DASHES = ("-", "--", "-.", ":")
DOTS_PER_INCH = 130


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
    figure, axes = plt.subplots(
        rows, len(widths), figsize=(across, up), squeeze=False, width_ratios=widths, **keywords
    )
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


def method_look(index: int) -> dict[str, Any]:
    """Colour and dashes of the line of the method in place `index`."""
    return {"color": order_colour(index), "ls": DASHES[index // len(COLOURS)]}


def save(figure: Any, path: Path) -> None:
    """Write a PNG, or what is wanted instead, and free the figure; beside a PDF, which no page can
    show, a PNG too. Dense maps are bitmaps in every format."""
    wanted = os.environ.get(FORMAT, "png")
    # A PNG is a bitmap anyway, and to seek maps makes every tick of every axis.
    for mesh in figure.findobj(QuadMesh) if wanted != "png" else ():
        mesh.set_rasterized(True)
    for suffix in {"pdf": ("pdf", "png")}.get(wanted, (wanted,)):
        place = path.with_suffix(f".{suffix}")
        figure.savefig(place, dpi=DOTS_PER_INCH, facecolor="white")
    plt.close(figure)
