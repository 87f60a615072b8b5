"""sheet.png: how many bounces a surface needs, for an engineer's wall."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import BoundaryNorm

from msbsdf_cli.experiments.recommend.candidates import ORDERS
from msbsdf_cli.plots.style import panels, save

MOST = 7
"""Bounces with a shade of their own."""


def draw_sheet(entries: list[Any], path: Path) -> None:
    """A map over roughness and angle for each material and slope distribution (columns) and each
    tolerance (rows); the number in a cell is that of bounces."""
    kinds = list(dict.fromkeys((e.material, e.slopes) for e in entries))
    tolerances = list(dict.fromkeys(e.tolerance for e in entries))
    figure, axes = panels(len(tolerances), [2.1] * len(kinds), 1.7, (0.25, 0.55))
    norm = BoundaryNorm(np.arange(0.5, MOST + 1.5), 256)
    for row, tolerance in zip(axes, tolerances, strict=True):
        for axis, kind in zip(row, kinds, strict=True):
            mine = [e for e in entries if (e.material, e.slopes, e.tolerance) == (*kind, tolerance)]
            _map(axis, mine, norm)
            axis.set_title(f"{kind[0]}, {kind[1]}: {100 * tolerance:g} %")
        row[0].set_ylabel("theta_i, degrees")
    for axis in axes[-1]:
        axis.set_xlabel("alpha (perceptual roughness below)", fontsize=7)
    title = "Bounces that keep albedo and lobe within the tolerance, of the Smith model of all"
    figure.suptitle(title, fontsize=9, x=0.01, y=0.995, ha="left", va="top")
    save(figure, path)


def _map(axis: Any, entries: list[Any], norm: Any) -> None:
    alphas, thetas = (sorted({getattr(e, n) for e in entries}) for n in ("alpha", "theta_i_rad"))
    bounces = np.zeros((len(thetas), len(alphas)), int)
    for e in entries:
        bounces[thetas.index(e.theta_i_rad), alphas.index(e.alpha)] = e.bounces
    axis.imshow(bounces, cmap="cividis_r", norm=norm, origin="lower", aspect="auto")
    for (i, j), n in np.ndenumerate(bounces):
        colour = "white" if n >= MOST - 2 else "black"
        axis.text(
            j,
            i,
            f"{n}" if n <= ORDERS else f">{ORDERS}",
            ha="center",
            va="center",
            fontsize=6,
            color=colour,
        )
    axis.grid(False)
    shown = range(0, len(alphas), 3)
    names = [f"{alphas[j]:g}\n{np.sqrt(alphas[j]):.2f}" for j in shown]
    axis.set_xticks(list(shown), names)
    axis.set_yticks(range(len(thetas)), [f"{np.degrees(t):.0f}" for t in thetas])
