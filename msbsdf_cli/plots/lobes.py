"""Pictures of lobes: the plane of incidence and hemisphere maps."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import PowerNorm, SymLogNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.ticker import NullLocator

from msbsdf_cli.plots.style import (
    in_degrees,
    key,
    look,
    method_lines,
    order_colour,
    panels,
    save,
    short_ticks,
)
from msbsdf_cli.results.lobes import Lobes, plane_of_incidence
from msbsdf_cli.scene import from_normal
from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, lobe_axes, merge_bins, spread_bins
from surfaces.facet import Array

PIXELS = 181
"""Of a hemisphere map, each way."""

SYMBOLS = "E_r", "E_t"
"""Of the energy on either side."""


def draw_lobes(lobes: Lobes, directory: Path) -> None:
    """lobes.png of one run: plane of incidence, and a map for each order."""
    for side in range(len(lobes.sides)):
        figure, axes = grid(len(lobes.theta), len(lobes.names))
        for row in range(len(lobes.theta)):
            draw_slice(axes[row, 0], lobes, row, side)
            for i, order in enumerate(lobes.names):
                density = lobes.density[row, i, side]
                energy = lobes.bins.value[row, i, side].sum()
                title = f"order {order}   E = {energy:.4f}"
                hemisphere(axes[row, 1 + i], density, density.max(), title)
                mark(axes[row, 1 + i], lobes.theta[row], lobes.phi)
            axes[row, 0].set_title(row_title(lobes, row, side))
        handles = legend(lobes.names)[: len(lobes.names)]
        figure.legend(handles=handles, loc="upper left", ncols=len(handles))
        save(figure, directory / ("lobes_transmitted.png" if side else "lobes.png"))


def lobe_comparison(simulated: Lobes, modelled: Lobes, directory: Path) -> list[Callable[[], None]]:
    """What draws lobes.png, all orders together, and a page for each angle with a map for each
    order, into `directory`."""
    pair = simulated, modelled
    pages = [directory / f"lobes_theta_{theta:.4g}.png" for theta in simulated.theta]
    return [
        partial(_draw_all_orders, *pair, directory),
        *(partial(_draw_orders, *pair, row, page) for row, page in enumerate(pages)),
    ]


def _draw_all_orders(simulated: Lobes, modelled: Lobes, directory: Path) -> None:
    for side in range(len(simulated.sides)):
        figure, axes = grid(len(simulated.theta), 3)
        for row in range(len(simulated.theta)):
            draw_slice(axes[row, 0], simulated, row, side, modelled)
            map_trio(axes[row, 1:], simulated, modelled, row, side)
            axes[row, 0].set_title(row_title(simulated, row, side))
        handles = legend(simulated.names)
        figure.legend(handles=handles, loc="upper left", ncols=len(handles), columnspacing=1)
        save(figure, directory / ("lobes_transmitted.png" if side else "lobes.png"))


def draw_methods(simulated: Lobes, modelled: list[Lobes], directory: Path) -> None:
    """methods.png: the plane of incidence, a row for each angle and a column for each order; points
    are simulated, lines the methods by name; both with their standard errors."""
    columns = {name: slice(i, i + 1) for i, name in enumerate(simulated.names)}
    columns["all"] = slice(None)
    for side in range(len(simulated.sides)):
        figure, axes = panels(len(simulated.theta), [2.0] * len(columns), 1.5, (0.55, 0.55))
        for row, theta in enumerate(simulated.theta):
            for axis, (order, orders) in zip(axes[row], columns.items(), strict=True):
                _methods_panel(axis, simulated, modelled, row, orders, side)
                axis.set_title(f"light from {in_degrees(theta)}, order {order}   [1/sr]")
        for axis in axes[-1]:
            axis.set_xlabel("theta_o in the plane, degrees", labelpad=1)
        handles = method_lines(lobes.label for lobes in modelled)
        handles.append(Line2D([], [], color="0.1", marker="o", ms=2, ls="", label="simulated"))
        key(figure, handles)
        save(figure, directory / ("methods_transmitted.png" if side else "methods.png"))


def _methods_panel(
    axis: Any, simulated: Lobes, modelled: list[Lobes], row: int, orders: slice, side: int
) -> None:
    angle, values, errors = plane_of_incidence(simulated, row, orders, side)
    # Where no more than noise is known there is no point.
    seen = values > errors
    axis.errorbar(angle[seen], values[seen], errors[seen], fmt="o", ms=1.8, lw=0.7, color="0.1")
    largest, each = values.max(), len(modelled)
    for k, lobes in enumerate(modelled):
        angle, values, errors = plane_of_incidence(lobes, row, orders, side)
        # Bars here and there, each method's elsewhere: bands would hide one another.
        axis.errorbar(
            angle,
            values,
            errors,
            **look(lobes.label),
            ms=2.5,
            lw=0.9,
            elinewidth=0.6,
            errorevery=(k, 4 * each),
            markevery=(k, 4 * each),
        )
        largest = max(largest, values.max())
    _plane_axis(axis)
    short_ticks(axis)
    axis.set_xlabel("")
    axis.set_ylim(0, 1.15 * largest if largest > 0 else 1)


def _draw_orders(simulated: Lobes, modelled: Lobes, row: int, path: Path) -> None:
    orders, sides = simulated.names, simulated.sides
    figure, axes = grid(len(orders) * len(sides), 3)
    for side, name in enumerate(sides):
        for i, order in enumerate(orders):
            line = axes[side * len(orders) + i]
            draw_slice(line[0], simulated, row, side, modelled, only=i)
            line[0].set_title(f"order {order}, {name}   [1/sr]")
            map_trio(line[1:], simulated, modelled, row, side, slice(i, i + 1))
    y, title = 1 - 0.15 / figure.get_figheight(), f"Light from {in_degrees(simulated.theta[row])}"
    figure.suptitle(title, fontsize=9, x=0.02, y=y, ha="left")
    save(figure, path)


def draw_slice(
    axis: Any,
    lobes: Lobes,
    row: int,
    side: int,
    model: Lobes | None = None,
    only: int | None = None,
) -> None:
    """Density in the plane of incidence, order by order: points with error bars where a model's
    lines go with them."""
    for i in range(len(lobes.names)) if only is None else (only,):
        order = slice(i, i + 1)
        angle, density, stderr = plane_of_incidence(lobes, row, order, side)
        label, colour = lobes.names[i], order_colour(i)
        if model is None:
            axis.plot(angle, density, color=colour, label=f"order {label}")
            axis.fill_between(angle, density - stderr, density + stderr, color=colour, alpha=0.25)
        else:
            # Where no more than noise is known there is no point.
            seen = density > stderr
            points = angle[seen], density[seen], stderr[seen]
            axis.errorbar(*points, fmt="o", ms=1.8, lw=0.7, color=colour)
            line, bar = plane_of_incidence(model, row, order, side)[1:]
            axis.plot(angle, np.where(line > bar, line, np.nan), color=colour, lw=0.9)
    _plane_axis(axis)
    if only is None:
        _over_decades(axis, lobes, row, side)


DECADES = 1e-4
"""Densities of single orders are drawn down to this share of the largest."""


def _over_decades(axis: Any, lobes: Lobes, row: int, side: int) -> None:
    """Later orders, which a linear axis would press onto the line of 0, beside the first."""
    top = max(
        plane_of_incidence(lobes, row, slice(i, i + 1), side)[1].max()
        for i in range(len(lobes.names))
    )
    if top > 0:
        axis.set_yscale("log")
        axis.set_ylim(DECADES * top, 1.5 * top)
        # Nine ticks a decade are grey noise in a panel of this size, and half the time it takes.
        axis.yaxis.set_minor_locator(NullLocator())


def _plane_axis(axis: Any) -> None:
    axis.set_xlim(-90, 90)
    axis.set_ylim(bottom=0)
    axis.set_xticks([-90, -45, 0, 45, 90])
    axis.set_xlabel("theta_o in the plane of incidence, degrees", labelpad=1)


def legend(orders: list[str]) -> list[Any]:
    """Lines and points of the orders, simulated and modelled."""
    handles = [
        Line2D([], [], color=order_colour(i), label=f"order {o}") for i, o in enumerate(orders)
    ]
    handles.append(Line2D([], [], color="0.3", marker="o", ms=2, ls="", label="simulated"))
    handles.append(Line2D([], [], color="0.3", label="modelled"))
    return handles


def row_title(lobes: Lobes, row: int, side: int) -> str:
    """Of a row: where the light is from, and how much of it leaves."""
    energy = lobes.energy.value[row, :, side].sum()
    return f"light from {in_degrees(lobes.theta[row])}   {SYMBOLS[side]} = {energy:.4f}   [1/sr]"


def grid(rows: int, maps: int) -> tuple[Any, Any]:
    """Axes for a slice and `maps` hemisphere maps in each row."""
    return panels(rows, [2.3] + [1.45] * maps, 1.45, gap=(0.2, 0.72), right=0.55)


def map_trio(
    axes: Any, simulated: Lobes, modelled: Lobes, row: int, side: int, orders: slice = slice(None)
) -> None:
    """Maps of the sum over some orders: simulated, modelled, and what they differ in."""
    place = row, orders, side
    pair = [lobes.density[place].sum(axis=0) for lobes in (simulated, modelled)]
    squares = [(lobes.density_stderr[place] ** 2).sum(axis=0) for lobes in (simulated, modelled)]
    top = max(density.max() for density in pair)
    named = zip(("simulated", "modelled"), (simulated, modelled), pair, strict=True)
    for axis, (name, lobes, density) in zip(axes, named, strict=False):
        energy = lobes.energy.value[place].sum()
        hemisphere(axis, density, top, f"{name}   {SYMBOLS[side]} = {energy:.4f}")
        mark(axis, lobes.theta[row], lobes.phi)
    difference = _significant(pair[1] - pair[0], np.sqrt(squares[0] + squares[1]))
    # The same share of the peak in every row: rows are compared by their colours.
    hemisphere(axes[2], difference, SHARE * top, "modelled - simulated, > 2 s.e.", signed=True)
    mark(axes[2], simulated.theta[row], simulated.phi)


SHARE = 0.2
"""Of the peak of a lobe, at which the colour of a difference is fullest."""


def mark(axis: Any, theta: float, phi: float) -> None:
    """Rings at polar angles of 30 and 60 degrees, and a triangle where the light comes from."""
    middle = (PIXELS - 1) / 2
    for angle in (30, 60):
        ring = Circle((middle, middle), middle * angle / 90, fill=False, color="0.6", lw=0.4)
        axis.add_patch(ring)
    radius = from_normal(theta) / (np.pi / 2)
    x, y = (middle * (1 + 0.95 * radius * part) for part in (math.cos(phi), math.sin(phi)))
    # A triangle that points from there to the pole.
    axis.plot(x, y, marker=(3, 0, math.degrees(phi) + 90), ms=5, color="#2a9d2a", ls="")


def _significant(difference: Array, noise: Array) -> Array:
    """A difference averaged over blocks of bins, 0 where it is below two standard errors."""
    solid_angle = np.repeat(lobe_axes()[2][:, None], PHI_BINS, axis=1)
    block = merge_bins(solid_angle)
    mean = merge_bins(difference * solid_angle) / block
    stderr = np.sqrt(merge_bins((noise * solid_angle) ** 2)) / block
    return spread_bins(np.where(np.abs(mean) > 2 * stderr, mean, 0))


def hemisphere(axis: Any, density: Array, top: float, title: str, signed: bool = False) -> None:
    """Draw a density (THETA_BINS, PHI_BINS), up to `top`, as a hemisphere seen from its pole: the
    radius is the polar angle, x points right.

    Brightness is the root of the density; of a difference, red is more and blue is less.
    """
    scale = float(top) or 1.0
    image = np.append(density.ravel(), np.nan)[_disc()]
    norm: Any = SymLogNorm(scale / 30, vmin=-scale, vmax=scale)
    drawn = axis.imshow(
        image,
        origin="lower",
        cmap="RdBu_r" if signed else "magma",
        norm=norm if signed else PowerNorm(0.5, 0, scale),
        interpolation="nearest",
    )
    # A bar for what may be of either sign; that of a density is its two ends in words.
    axis.set_title(title if signed else f"{title}\n0 to {top:.2g}")
    axis.axis("off")
    if signed:
        bar = axis.figure.colorbar(drawn, cax=axis.inset_axes((1.02, 0.15, 0.05, 0.7)))
        bar.set_ticks([-scale, 0, scale], labels=[f"{x:.2g}" for x in (-scale, 0, scale)])
        bar.ax.tick_params(labelsize=5.5)
        bar.ax.minorticks_off()


def _disc() -> Array:
    """Bin number of each pixel of a map, and the number past the last outside the disc."""
    x = np.linspace(-1, 1, PIXELS)
    radius, angle = np.hypot(x, x[:, None]), np.arctan2(x[:, None], x)
    row = (radius * THETA_BINS).astype(int)
    column = np.floor(angle / (2 * np.pi) * PHI_BINS + 0.5).astype(int) % PHI_BINS
    return np.where(row < THETA_BINS, row * PHI_BINS + column, THETA_BINS * PHI_BINS)
