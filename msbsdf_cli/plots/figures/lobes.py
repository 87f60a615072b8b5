"""heitz_15.png, the pages wang_4.png to wang_15.png, and wang_4_15.png, which sums them up."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D

from msbsdf_cli.experiments.figures.settings import Tables
from msbsdf_cli.plots.figures.rows import values, where
from msbsdf_cli.plots.lobes import draw_slice, grid, legend, map_trio
from msbsdf_cli.plots.style import in_degrees, look, method_lines, panels, save, short_ticks
from msbsdf_cli.results.files import Table
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, lobe_axes
from msbsdf_cli.statistics.tally import SIDES, Estimate
from surfaces.facet import Array


def draw_heitz_15(tables: Tables, directory: Path) -> None:
    """A row for each material and side: the plane of incidence, both lobes, and the difference."""
    lobes, energies = tables["heitz_15"], tables["heitz_15_energy"]
    pairs = [
        (m, [lobes_from(lobes, energies, material=m, source=s) for s in ("simulate", "walk")])
        for m in values(lobes, "material")
    ]
    shown = [(m, pair, s) for m, pair in pairs for s in range(len(pair[0].sides))]
    figure, axes = grid(len(shown), 3)
    for line, (material, (simulated, walked), side) in zip(axes, shown, strict=True):
        draw_slice(line[0], simulated, 0, side, walked)
        map_trio(line[1:], simulated, walked, 0, side)
        line[0].set_title(f"{material}, {SIDES[side]}   [1/sr]")
    names = pairs[0][1][0].names
    handles = legend(names)
    figure.legend(handles=handles, loc="upper left", ncols=len(handles), columnspacing=1)
    save(figure, directory / "heitz_15.png")


def lobes_from(lobes: Table, energies: Table, **wanted: Any) -> Lobes:
    """Light of one angle of incidence from rows of lobe.csv and energy.csv."""
    rows, totals = where(lobes, **wanted), where(energies, **wanted)
    light = np.isin(totals["side"], SIDES)
    orders = list(dict.fromkeys(totals["order"][light].tolist()))
    polar, azimuth, solid = lobe_axes()
    bins, energy = (
        np.zeros((2, 1, len(orders), 2, THETA_BINS * PHI_BINS)),
        np.zeros((2, 1, len(orders), 2)),
    )
    theta = np.minimum(rows["theta_o_rad"], np.pi - rows["theta_o_rad"])
    place = (
        0,
        np.array([orders.index(o) for o in rows["order"]], int),
        np.array([SIDES.index(s) for s in rows["side"]], int),
        np.rint((theta - polar[0]) / (polar[1] - polar[0])).astype(int) * PHI_BINS
        + np.rint(rows["phi_o_rad"] / azimuth[1]).astype(int),
    )
    for part, name in zip(bins, ("density_per_sr", "stderr_per_sr"), strict=True):
        part[place] = rows[name] * np.repeat(solid, PHI_BINS)[place[-1]]
    for part, name in zip(energy, ("energy", "stderr"), strict=True):
        for order, side, value in zip(
            totals["order"][light], totals["side"][light], totals[name][light], strict=True
        ):
            part[0, orders.index(order), SIDES.index(side)] = value
    transmits = SIDES[1] in totals["side"]
    angles = (float(totals["theta_i_rad"][0]),), float(totals["phi_i_rad"][0])
    both = Estimate(*energy), Estimate(*bins)
    return Lobes(str(wanted.get("source")), *angles, len(orders) - 1, transmits, *both)


def draw_wang_4_15(tables: Tables, directory: Path) -> None:
    """The pages of the atlas, and how far each model is from surfaces."""
    sums = tables["wang_4_15"]
    for figure in values(sums, "figure"):
        name = f"wang_{figure:g}"
        rows = where(sums, figure=figure)
        what = f"{rows['material'][0]}, alpha {rows['alpha_x'][0]:g}"
        if rows["alpha_y"][0] != rows["alpha_x"][0]:
            what += f", {rows['alpha_y'][0]:g}"
        _draw_page(tables[name], what, directory / f"{name}.png")
    _draw_summary(sums, directory / "wang_4_15.png")


ORDERS = ("1", "2", "3", "all")


def _draw_page(table: Table, what: str, path: Path) -> None:
    """A row for each angle and side, a column for each order: points are simulated."""
    models = [name for name in values(table, "source") if name != "simulate"]
    rows = [(t, s) for s in values(table, "side") for t in values(table, "theta_i_rad")]
    figure, axes = panels(len(rows), [1.58] * len(ORDERS), 0.95, (0.5, 0.55))
    for line, (theta, side) in zip(axes, rows, strict=True):
        for axis, order in zip(line, ORDERS, strict=True):
            part = where(table, theta_i_rad=theta, side=side, order=order)
            _page_panel(axis, part, models)
            axis.set_title(f"from {in_degrees(theta)}, {side[:-2]}., order {order}", fontsize=6.5)
        line[0].set_ylabel("1/sr")
    for axis in axes[-1]:
        axis.set_xlabel("theta_o [degrees]")
    handles = method_lines(models)
    handles.append(Line2D([], [], color="0.1", marker="o", ms=2, ls="", label="surfaces"))
    figure.legend(handles=handles, loc="upper left", ncols=4, title=what, alignment="left")
    save(figure, path)


def _page_panel(axis: Any, part: dict[str, Array], models: list[str]) -> None:
    top = 0.0
    short_ticks(axis)
    for k, name in enumerate(("simulate", *models)):
        mine = where(part, source=name)
        angle, value, error = (mine[n] for n in ("theta_o_rad", "density_per_sr", "stderr_per_sr"))
        style: dict[str, Any] = {"fmt": "o", "ms": 1.3, "color": "0.1"}
        if k:
            every = k, 4 * len(models)
            style = look(name) | {"ms": 2.5, "lw": 0.9, "errorevery": every, "markevery": every}
        # Where no more than noise is known there is no point.
        seen = (value > error) | (k > 0)
        axis.errorbar(np.degrees(angle[seen]), value[seen], error[seen], elinewidth=0.5, **style)
        top = max(top, float(value.max()))
    axis.set_xlim(-90, 90)
    axis.set_xticks([-90, -45, 0, 45, 90])
    axis.set_ylim(0, 1.15 * top if top > 0 else 1)


def _draw_summary(table: Table, path: Path) -> None:
    """How far each model is off the energy of the order that it misses most: a row for each surface
    and side, a column for each angle."""
    rows = where(table, quantity="energy")
    methods, thetas = values(rows, "method"), values(rows, "theta_i_rad")
    light = np.isin(rows["side"], SIDES)
    places = list(dict.fromkeys(zip(rows["figure"][light], rows["side"][light], strict=True)))
    figure, axes = panels(
        1, [2.0] * len(methods), 0.27 * len(places), (0.2, 0.5), right=0.9, sharey=True
    )
    figure.subplots_adjust(left=0.27)
    for axis, method in zip(axes[0], methods, strict=True):
        own, error = np.zeros((2, len(places), len(thetas)))
        for i, (number, side) in enumerate(places):
            for j, theta in enumerate(thetas):
                at = where(rows, method=method, figure=number, side=side, theta_i_rad=theta)
                k = int(np.abs(at["own"]).argmax())
                own[i, j], error[i, j] = abs(at["own"][k]), at["own_stderr"][k]
        drawn = axis.imshow(
            np.maximum(own, LEAST), aspect="auto", cmap="viridis", norm=LogNorm(LEAST, 0.3)
        )
        for (i, j), x in np.ndenumerate(own):
            colour = "white" if x < 0.05 else "black"
            text = f"{x:.3f}\n± {error[i, j]:.3f}"
            axis.text(j, i, text, ha="center", va="center", fontsize=5.5, color=colour)
        axis.set_title(method)
        axis.set_xticks(range(len(thetas)), [in_degrees(t) for t in thetas])
        axis.set_xlabel("light from")
        axis.grid(False)
    axes[0, 0].set_yticks(range(len(places)), list(_names(rows, places)))
    bar = figure.colorbar(drawn, cax=axes[0, -1].inset_axes((1.05, 0, 0.06, 1)), extend="both")
    bar.set_label("energy of the order that is off most")
    save(figure, path)


LEAST = 1e-3
"""Distance at which colours begin."""


def _names(rows: dict[str, Array], places: list[tuple[float, str]]) -> Iterator[str]:
    for number, side in places:
        mine = where(rows, figure=number, side=side)
        alpha = dict.fromkeys((mine["alpha_x"][0], mine["alpha_y"][0]))
        roughness = ",".join(f"{a:g}" for a in alpha)
        yield f"{number:g}: {mine['material'][0]} {roughness}, {side[:-2]}."
