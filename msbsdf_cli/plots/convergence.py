"""convergence.png: how far energies lie from those of the finest mesh and longest period."""

from pathlib import Path

import numpy as np

from msbsdf_cli.plots.style import in_degrees, order_colour, panels, save
from msbsdf_cli.results.files import Table

AXES = {
    "cells": "cells a correlation length",
    "extent": "period, correlation lengths",
    "waves": "waves",
    "lift": "offset of rays, over that in use",
}


def draw_convergence(table: Table, directory: Path) -> None:
    """A row for each incident angle, a column for each parameter, a colour for each order of
    reflected (discs) and transmitted light (triangles)."""
    rows = [dict(zip(table, values, strict=True)) for values in zip(*table.values(), strict=True)]
    angles = list(dict.fromkeys(r["theta_i_rad"] for r in rows))
    orders = list(dict.fromkeys(r["order"] for r in rows))
    figure, axes = panels(len(angles), [1.9] * len(AXES), 1.3, (0.25, 0.55), sharey="row")
    for i, theta in enumerate(angles):
        for j, (parameter, label) in enumerate(AXES.items()):
            axis = axes[i, j]
            mine = [r for r in rows if r["theta_i_rad"] == theta and r["parameter"] == parameter]
            values = list(dict.fromkeys(r["value"] for r in mine))
            for k, order in enumerate(orders):
                for side, marker in (("reflected", "o"), ("transmitted", "^")):
                    line = [r for r in mine if r["order"] == order and r["side"] == side]
                    if not line:
                        continue
                    x = np.arange(len(line)) + 0.06 * (k - len(orders) / 2)
                    y, error = (
                        [r[name] for r in line] for name in ("difference", "difference_stderr")
                    )
                    name = f"order {order}" if side == "reflected" else None
                    axis.errorbar(
                        x,
                        y,
                        error,
                        fmt=marker,
                        ms=2.5,
                        lw=0.8,
                        color=order_colour(k),
                        label=name,
                    )
            axis.axhline(0, color="0.4", lw=0.6)
            axis.set_xticks(range(len(values)), [v if v == "all" else f"{v:g}" for v in values])
            axis.set_title(f"light from {in_degrees(theta)}")
            axis.set_xlabel(label, labelpad=1)
        axes[i, 0].set_ylabel("energy, less that\nof the last value")
    handles = axes[0, 0].get_legend_handles_labels()
    figure.legend(*handles, loc="upper left", ncols=len(orders))
    save(figure, directory / "convergence.png")
