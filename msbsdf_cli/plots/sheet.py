"""sheet.png: how many bounces a surface needs, for an engineer's wall."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import BoundaryNorm
from matplotlib.patches import Polygon

from msbsdf_cli.experiments.recommend.cases import ORDERS
from msbsdf_cli.plots.recommendation import SHORT
from msbsdf_cli.plots.style import COLOURS, panels, save

MOST = 7
"""Bounces with a shade of their own."""

KINDS = {"conductor": "mirror", "diffuse": "white diffuse", "dielectric": "glass 1.5"}
NAMES = {"beckmann": "Beckmann", "ggx": "GGX"}
"""Materials and slopes as they are said."""

TITLE = (
    "How many bounces keep albedo and lobe within a tolerance, "
    "against the Smith model of all bounces"
)


def draw_sheet(entries: list[Any], path: Path) -> None:
    """A map over roughness and angle for each material and slope distribution (columns) and each
    tolerance (rows); the number in a cell is that of bounces. In the last row, how far the model
    itself is from traced surfaces, and how to read it all."""
    kinds = list(dict.fromkeys((e.material, e.slopes) for e in entries))
    tolerances = list(dict.fromkeys(e.tolerance for e in entries))
    figure, axes = panels(len(tolerances) + 1, [2.5] * len(kinds), 1.8, (0.3, 0.55))
    for column, kind in enumerate(kinds):
        mine = [e for e in entries if (e.material, e.slopes) == kind]
        name = f"{KINDS[kind[0]]}, {NAMES[kind[1]]}"
        for axis, tolerance in zip(axes[:-1, column], tolerances, strict=True):
            _bounces(axis, [e for e in mine if e.tolerance == tolerance])
            axis.set_title(f"{name}: within {100 * tolerance:g} %")
        traced = _floor(axes[-1, column], [e for e in mine if e.tolerance == tolerances[0]], name)
        axes[-1 if traced else -2, column].set_xlabel("alpha; below it its root", fontsize=7)
    for axis in axes[:, 0]:
        axis.set_ylabel("angle of incidence, degrees")
    free = [axis for axis in axes[-1] if not axis.axison]
    if free:
        free[0].text(0, 0.98, LEGEND, fontsize=7.2, ha="left", va="top", linespacing=1.35)
    figure.suptitle(TITLE, fontsize=12, x=0.01, y=0.99, ha="left", va="top")
    save(figure, path)


LEGEND = """Number: bounces that are enough.
T, K: so is, and cheaper, a single bounce with
Turquin's or Kulla and Conty's compensation.
Orange corner: the Smith model itself is further
than the tolerance from traced surfaces; more
bounces come no nearer to them. How far it is,
this row says; < is as much as noise allows.
Surfaces have Beckmann slopes.
The root of alpha is the perceptual roughness
of many renderers."""
"""How to read it."""

CORNER = COLOURS[1]


def _bounces(axis: Any, entries: list[Any]) -> None:
    alphas, thetas, place = _grid(axis, entries)
    bounces = np.zeros((len(thetas), len(alphas)), int)
    for e in entries:
        bounces[place(e)] = e.bounces
    norm = BoundaryNorm(np.arange(0.5, MOST + 1.5), 256)
    axis.imshow(bounces, cmap="cividis_r", norm=norm, origin="lower", aspect="auto")
    for e in entries:
        i, j = place(e)
        dark = "white" if e.bounces >= MOST - 2 else "black"
        number = f"{e.bounces}" if e.bounces <= ORDERS else f">{ORDERS}"
        if e.instead:
            number += SHORT[e.instead][0]
        axis.text(j, i, number, ha="center", va="center", fontsize=6, color=dark)
        if e.of_use != "":
            corner = [(j + 0.5, i + 0.5), (j + 0.15, i + 0.5), (j + 0.5, i + 0.05)]
            axis.add_patch(Polygon(corner, facecolor=CORNER, edgecolor="white", lw=0.4))


def _floor(axis: Any, entries: list[Any], name: str) -> bool:
    """The distance from surfaces in percent; whether any were traced."""
    known = [e for e in entries if e.smith_from_surfaces == e.smith_from_surfaces]
    if not known:
        axis.set_axis_off()
        return False
    alphas, thetas, place = _grid(axis, entries)
    values = np.full((len(thetas), len(alphas)), np.nan)
    for e in known:
        values[place(e)] = 100 * e.smith_from_surfaces
    axis.imshow(values, cmap="Greys", vmin=0, vmax=15, origin="lower", aspect="auto")
    for e in known:
        i, j = place(e)
        noise = 200 * e.smith_from_surfaces_stderr
        sure = values[i, j] > noise
        text = f"{values[i, j]:.1f}" if sure else f"<{values[i, j] + noise:.1f}"
        colour = "white" if values[i, j] > 8 else "black"
        axis.text(j, i, text, ha="center", va="center", fontsize=5.5, color=colour)
    axis.set_title(f"{name}: model from surfaces, %")
    return True


def _grid(axis: Any, entries: list[Any]) -> tuple[list[float], list[float], Any]:
    """Roughnesses, angles, and the function that says where an entry stands; the axes to match."""
    alphas, thetas = (sorted({getattr(e, n) for e in entries}) for n in ("alpha", "theta_i_rad"))
    axis.grid(False)
    names = [f"{a:.2g}\n{np.sqrt(a):.2f}".replace("0.", ".") for a in alphas]
    axis.set_xticks(range(len(alphas)), names, fontsize=6)
    axis.set_yticks(range(len(thetas)), [f"{np.degrees(t):.0f}" for t in thetas])
    return alphas, thetas, lambda e: (thetas.index(e.theta_i_rad), alphas.index(e.alpha))
