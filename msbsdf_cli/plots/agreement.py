"""agreement.png: energies of each order, simulated beside modelled, and their difference."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.plots.style import COLOURS, in_degrees, panels, save
from surfaces.facet import Array

LEAST = 1e-6
"""Energies are drawn from here on."""


def draw_agreement(rows: list[Any], path: Path) -> None:
    """From the energy rows of an agreement (order, side, theta, values and standard errors): above,
    both energies, an arrow where two standard errors reach down to nothing; below, what they differ
    in, with z beside."""
    rows = [r for r in rows if r.quantity == "energy" and r.order != "all"]
    angles = list(dict.fromkeys(r.theta_i_rad for r in rows))
    figure, axes = panels(2, [2.1] * len(angles), 1.7, (0.3, 0.2), sharex=True, sharey="row")
    for column, theta in enumerate(angles):
        mine = [r for r in rows if r.theta_i_rad == theta]
        upper, lower = axes[:, column]
        labels = [r.order if r.side == "reflected" else f"{r.order} t" for r in mine]
        x = np.arange(len(mine))
        for shift, name, colour, marker in (
            (-0.12, "simulated", COLOURS[0], "o"),
            (0.12, "modelled", COLOURS[1], "s"),
        ):
            values = np.array([getattr(r, name) for r in mine])
            errors = 2 * np.array([getattr(r, f"{name}_stderr") for r in mine])
            _points(upper, x + shift, values, errors, color=colour, marker=marker, label=name)
        upper.set_yscale("log")
        upper.set_ylim(LEAST, 1.5)
        upper.set_title(f"light from {in_degrees(theta)}")
        _differences(lower, x, mine)
        lower.set_xticks(x, labels)
        lower.set_xlabel("order" + (" (t: transmitted)" if any("t" in n for n in labels) else ""))
    axes[0, 0].set_ylabel("energy, fraction of the incident")
    axes[1, 0].set_ylabel("modelled - simulated")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="upper left", ncols=2)
    words = "Bars: two standard errors. Beside the differences: z."
    figure.text(0.01, 0.01, words, fontsize=6, color="0.35")
    save(figure, path)


def _points(axis: Any, x: Array, values: Array, errors: Array, **look: Any) -> None:
    """Values with bars; where a bar reaches down to nothing, the upper end of it as a limit."""
    limit = values <= errors
    known = ~limit
    axis.errorbar(x[known], values[known], errors[known], ls="none", ms=3.5, lw=1, **look)
    top = np.maximum(values + errors, 1.5 * LEAST)[limit]
    axis.errorbar(
        x[limit], top, 0.6 * top, uplims=True, ls="none", lw=0.8, ms=0, color=look["color"]
    )


def _differences(axis: Any, x: Array, rows: list[Any]) -> None:
    axis.axhline(0, color="0.4", lw=0.7)
    differences, noise = (np.array([getattr(r, n) for r in rows]) for n in ("difference", "noise"))
    axis.errorbar(x, differences, 2 * noise, fmt="o", ms=3, color="0.15", lw=1)
    for place, difference, row in zip(x, differences, rows, strict=True):
        if abs(row.z) >= 2:
            axis.annotate(
                f"{row.z:.0f}", (place, difference), (4, 0), textcoords="offset points", fontsize=6
            )
