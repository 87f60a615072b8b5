"""Pictures of lobes, from lobe.csv and energy.csv: the plane of incidence and hemisphere maps."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.colors import PowerNorm, SymLogNorm
from matplotlib.lines import Line2D

from msbsdf_cli.plots.style import BAND_ROOM, method_look, order_colour, panels, save
from msbsdf_cli.results.directory import read_csv
from msbsdf_cli.statistics.tally import (
    PHI_BINS,
    SIDES,
    THETA_BINS,
    lobe_axes,
    merge_bins,
    spread_bins,
)
from surfaces.facet import Array

PIXELS = 181
"""Of a hemisphere map, each way."""


@dataclass
class Lobes:
    """Densities and standard errors (theta, order, side, theta bin, phi bin), per steradian."""

    theta: list[float]
    phi: float
    orders: list[str]
    density: Array
    stderr: Array
    energy: Array
    """Energy of each side, (theta, side)."""

    @property
    def transmits(self) -> bool:
        """Whether anything is on the far side."""
        return bool(self.energy[:, 1].any())


def load_lobes(directory: Path) -> Lobes:
    """The lobes of a report; raises click.ClickException for a file that is not one."""
    energy = read_csv(directory / "energy.csv", ("theta_i_rad", "phi_i_rad", "energy"))
    theta = list(dict.fromkeys(energy["theta_i_rad"]))
    orders = [o for o in dict.fromkeys(energy["order"]) if o != "all"]
    numbers = ("theta_i_rad", "theta_o_rad", "phi_o_rad", "density_per_sr", "stderr_per_sr")
    table = read_csv(directory / "lobe.csv", numbers)
    shape = (len(theta), len(orders), 2, THETA_BINS, PHI_BINS)
    lobes = Lobes(
        theta, energy["phi_i_rad"][0], orders, np.zeros(shape), np.zeros(shape), np.zeros(0)
    )
    polar = np.array(table["theta_o_rad"])
    polar = np.minimum(polar, np.pi - polar)
    place = (
        [theta.index(t) for t in table["theta_i_rad"]],
        [orders.index(o) for o in table["order"]],
        [SIDES.index(s) for s in table["side"]],
        (polar / (np.pi / 2) * THETA_BINS).astype(int),
        np.rint(np.array(table["phi_o_rad"]) / (2 * np.pi) * PHI_BINS).astype(int),
    )
    lobes.density[place] = table["density_per_sr"]
    lobes.stderr[place] = table["stderr_per_sr"]
    lobes.energy = np.zeros((len(theta), 2))
    rows = zip(energy["theta_i_rad"], energy["side"], energy["energy"], strict=True)
    for t, side, value in rows:
        if side in SIDES:
            lobes.energy[theta.index(t), SIDES.index(side)] += value
    return lobes


GROUPS = "lobe_groups.npy"
"""Lobes of independent groups of surfaces (theta, group, order, side, merged bin), as energies."""


def load_groups(directory: Path) -> Array | None:
    """The lobes of groups of surfaces, if the report has them; raises click.ClickException for a
    file that is not one."""
    path = directory / GROUPS
    if not path.exists():
        return None
    try:
        return np.asarray(np.load(path, allow_pickle=False), float)
    except (OSError, ValueError) as error:
        raise click.ClickException(f"{path} does not hold lobes: {error}.") from None


def draw_lobes(directory: Path) -> None:
    """lobes.png of one run: plane of incidence, and a map for each order."""
    lobes = load_lobes(directory)
    for side in range(1 + lobes.transmits):
        figure, axes = _grid(len(lobes.theta), len(lobes.orders))
        for row, theta in enumerate(lobes.theta):
            draw_slice(axes[row, 0], lobes, row, side)
            for i, order in enumerate(lobes.orders):
                density = lobes.density[row, i, side]
                energy = (density * lobe_axes()[2][:, None]).sum()
                title = f"order {order}   E = {energy:.4f}"
                _map(axes[row, 1 + i], density, density.max(), title)
            axes[row, 0].set_title(_title(theta, lobes, row, side))
        handles = _legend(lobes.orders)[: len(lobes.orders)]
        figure.legend(handles=handles, loc="upper left", ncols=len(handles))
        save(figure, directory / ("lobes_transmitted.png" if side else "lobes.png"))


def draw_lobe_comparison(simulated: Path, modelled: Path, directory: Path) -> None:
    """lobes.png: all orders together, and a page for each angle with a map for each order, into
    `directory`."""
    ours, theirs = load_lobes(simulated), load_lobes(modelled)
    for side in range(1 + ours.transmits):
        figure, axes = _grid(len(ours.theta), 3)
        for row, theta in enumerate(ours.theta):
            draw_slice(axes[row, 0], ours, row, side, theirs)
            total = ours.density[row, :, side].sum(axis=0), theirs.density[row, :, side].sum(axis=0)
            noise = np.sqrt(
                (ours.stderr[row, :, side] ** 2 + theirs.stderr[row, :, side] ** 2).sum(axis=0)
            )
            energies = ours.energy[row, side], theirs.energy[row, side]
            _map_trio(axes[row, 1:], *total, noise, side, *energies)
            axes[row, 0].set_title(_title(theta, ours, row, side))
        handles = _legend(ours.orders)
        figure.legend(handles=handles, loc="upper left", ncols=len(handles), columnspacing=1)
        save(figure, directory / ("lobes_transmitted.png" if side else "lobes.png"))
    for row, theta in enumerate(ours.theta):
        _draw_orders(ours, theirs, row, directory / f"lobes_theta_{theta:.4g}.png")


def draw_methods(simulated: Path, modelled: dict[str, Path], directory: Path) -> None:
    """methods.png: the plane of incidence, a row for each angle and a column for each order; points
    are simulated, lines the methods by name; both with their standard errors."""
    ours = load_lobes(simulated)
    theirs = {name: load_lobes(path) for name, path in modelled.items()}
    for side in range(1 + ours.transmits):
        columns = {name: slice(i, i + 1) for i, name in enumerate(ours.orders)}
        columns["all"] = slice(None)
        figure, axes = panels(len(ours.theta), [2.0] * len(columns), 1.5, (0.45, 0.7))
        for row, theta in enumerate(ours.theta):
            for axis, (order, i) in zip(axes[row], columns.items(), strict=True):
                angle, values, errors = _plane(ours, row, i, side)
                axis.errorbar(angle, values, errors, fmt="o", ms=1.8, lw=0.7, color="0.1")
                largest = values.max()
                for k, lobes in enumerate(theirs.values()):
                    angle, values, errors = _plane(lobes, row, i, side)
                    look, band = method_look(k), (values - errors, values + errors)
                    axis.plot(angle, values, **look, lw=0.9)
                    axis.fill_between(angle, *band, color=look["color"], alpha=0.15, lw=0)
                    largest = max(largest, values.max())
                _plane_axis(axis)
                axis.set_ylim(0, BAND_ROOM * largest if largest > 0 else 1)
                axis.set_title(f"theta_i = {theta:.4g}, order {order}   [1/sr]")
        handles = [Line2D([], [], **method_look(k), label=name) for k, name in enumerate(theirs)]
        handles.append(Line2D([], [], color="0.1", marker="o", ms=2, ls="", label="simulated"))
        figure.legend(handles=handles, loc="upper left", ncols=5)
        save(figure, directory / ("methods_transmitted.png" if side else "methods.png"))


def _draw_orders(ours: Lobes, theirs: Lobes, row: int, path: Path) -> None:
    sides = range(1 + ours.transmits)
    figure, axes = _grid(len(ours.orders) * len(sides), 3)
    solid_angle = lobe_axes()[2][:, None]
    for side in sides:
        for i, order in enumerate(ours.orders):
            line = axes[side * len(ours.orders) + i]
            pair = ours.density[row, i, side], theirs.density[row, i, side]
            draw_slice(line[0], ours, row, side, theirs, only=i)
            line[0].set_title(f"order {order}, {SIDES[side]}   [1/sr]")
            energies = [(density * solid_angle).sum() for density in pair]
            noise = np.hypot(ours.stderr[row, i, side], theirs.stderr[row, i, side])
            _map_trio(line[1:], *pair, noise, side, *energies)
    y = 1 - 0.15 / figure.get_figheight()
    figure.suptitle(
        f"Incident at theta = {ours.theta[row]:.4g} rad", fontsize=9, x=0.02, y=y, ha="left"
    )
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
    for i in range(len(lobes.orders)) if only is None else (only,):
        order = slice(i, i + 1)
        angle, density, stderr = _plane(lobes, row, order, side)
        label, colour = lobes.orders[i], order_colour(i)
        if model is None:
            axis.plot(angle, density, color=colour, label=f"order {label}")
            axis.fill_between(angle, density - stderr, density + stderr, color=colour, alpha=0.25)
        else:
            axis.errorbar(angle, density, stderr, fmt="o", ms=1.8, lw=0.7, color=colour)
            axis.plot(angle, _plane(model, row, order, side)[1], color=colour, lw=0.9)
    _plane_axis(axis)


def _plane_axis(axis: Any) -> None:
    axis.set_xlim(-90, 90)
    axis.set_ylim(bottom=0)
    axis.set_xticks([-90, -45, 0, 45, 90])
    axis.set_xlabel("theta_o in the plane of incidence, degrees", labelpad=1)


def _plane(lobes: Lobes, row: int, orders: slice, side: int) -> tuple[Array, Array, Array]:
    """Angles in degrees, densities and standard errors in the plane of incidence, of the sum over
    some orders."""
    polar, azimuth, _ = lobe_axes()
    backward, forward = (_window(polar, azimuth, lobes.phi + turn) for turn in (0, np.pi))
    values = lobes.density[row, orders, side].sum(axis=0)
    errors = np.sqrt((lobes.stderr[row, orders, side] ** 2).sum(axis=0))
    halves = [(values * window).sum(axis=1) for window in (backward, forward)]
    # Errors of bins outside may be infinite.
    squares = [
        (np.where(window > 0, errors, 0) ** 2 * window**2).sum(axis=1)
        for window in (backward, forward)
    ]
    return (
        np.degrees(np.concatenate([-polar[::-1], polar])),
        np.concatenate([halves[0][::-1], halves[1]]),
        np.sqrt(np.concatenate([squares[0][::-1], squares[1]])),
    )


def _window(polar: Array, azimuth: Array, phi: float) -> Array:
    """Weights (polar, azimuth) of the bins near azimuth `phi`: a bin wide, and towards the pole,
    where bins are slivers, as wide as a bin is high."""
    half_bin = np.pi / 4 / THETA_BINS
    reach = np.maximum(np.pi / PHI_BINS, half_bin / np.sin(polar))
    apart = np.abs(np.angle(np.exp(1j * (azimuth - math.remainder(phi, 2 * math.pi)))))
    near = apart[None] <= reach[:, None] * (1 + 1e-9)
    return near / near.sum(axis=1, keepdims=True)


def _legend(orders: list[str]) -> list[Any]:
    handles = [
        Line2D([], [], color=order_colour(i), label=f"order {o}") for i, o in enumerate(orders)
    ]
    handles.append(Line2D([], [], color="0.3", marker="o", ms=2, ls="", label="simulated"))
    handles.append(Line2D([], [], color="0.3", label="modelled"))
    return handles


def _title(theta: float, lobes: Lobes, row: int, side: int) -> str:
    name = "E_t" if side else "E_r"
    return f"theta_i = {theta:.4g}   {name} = {lobes.energy[row, side]:.4f}   [1/sr]"


def _grid(rows: int, maps: int) -> tuple[Any, Any]:
    """Axes for a slice and `maps` hemisphere maps in each row."""
    return panels(rows, [2.3] + [1.45] * maps, 1.45, gap=(0.2, 0.72))


def _map_trio(
    axes: Any,
    simulated: Array,
    modelled: Array,
    noise: Array,
    side: int,
    e_simulated: float,
    e_modelled: float,
) -> None:
    top = max(simulated.max(), modelled.max())
    name = "E_t" if side else "E_r"
    _map(axes[0], simulated, top, f"simulated   {name} = {e_simulated:.4f}")
    _map(axes[1], modelled, top, f"modelled   {name} = {e_modelled:.4f}")
    difference = _significant(modelled - simulated, noise)
    top = float(np.abs(difference).max())
    _map(axes[2], difference, top, "modelled - simulated, > 2 s.e.", signed=True)


def _significant(difference: Array, noise: Array) -> Array:
    """A difference averaged over blocks of bins, 0 where it is below two standard errors."""
    solid_angle = np.repeat(lobe_axes()[2][:, None], PHI_BINS, axis=1)
    block = merge_bins(solid_angle)
    mean = merge_bins(difference * solid_angle) / block
    stderr = np.sqrt(merge_bins((noise * solid_angle) ** 2)) / block
    return spread_bins(np.where(np.abs(mean) > 2 * stderr, mean, 0))


def _map(axis: Any, density: Array, top: float, title: str, signed: bool = False) -> None:
    """A hemisphere seen from its pole: the radius is the polar angle, x points right.

    Brightness is the root of the density; of a difference, red is more and blue is less.
    """
    scale = float(top) or 1.0
    image = np.append(density.ravel(), np.nan)[_disc()]
    norm: Any = SymLogNorm(scale / 30, vmin=-scale, vmax=scale)
    axis.imshow(
        image,
        origin="lower",
        cmap="RdBu_r" if signed else "magma",
        norm=norm if signed else PowerNorm(0.5, 0, scale),
        interpolation="nearest",
    )
    axis.set_title(
        f"{title}\n{'-' if signed else '0'}{f'{top:.2g}' if signed else ''} to {top:.2g}"
    )
    axis.axis("off")


def _disc() -> Array:
    """Bin number of each pixel of a map, and the number past the last outside the disc."""
    x = np.linspace(-1, 1, PIXELS)
    radius, angle = np.hypot(x, x[:, None]), np.arctan2(x[:, None], x)
    row = (radius * THETA_BINS).astype(int)
    column = np.floor(angle / (2 * np.pi) * PHI_BINS + 0.5).astype(int) % PHI_BINS
    return np.where(row < THETA_BINS, row * PHI_BINS + column, THETA_BINS * PHI_BINS)
