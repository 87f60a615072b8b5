"""agreement.png: energies of each order, simulated beside modelled, and their difference."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.plots.style import COLOURS, panels, save


def draw_agreement(rows: list[Any], path: Path) -> None:
    """From the energy rows of an agreement (order, side, theta, values and standard errors)."""
    rows = [r for r in rows if r.quantity == "energy" and r.order != "all"]
    angles = list(dict.fromkeys(r.theta_i_rad for r in rows))
    figure, axes = panels(2, [1.9] * len(angles), 1.7, (0.5, 0.2), sharex=True)
    for column, theta in enumerate(angles):
        mine = [r for r in rows if r.theta_i_rad == theta]
        upper, lower = axes[:, column]
        labels = [r.order if r.side == "reflected" else f"{r.order} t" for r in mine]
        x = np.arange(len(mine))
        for shift, name, colour in (
            (-0.2, "simulated", COLOURS[0]),
            (0.2, "modelled", COLOURS[1]),
        ):
            values = np.array([getattr(r, name) for r in mine])
            errors = np.array([getattr(r, f"{name}_stderr") for r in mine])
            upper.bar(x + shift, values, 0.4, color=colour, alpha=0.8, label=name)
            upper.errorbar(x + shift, values, errors, fmt="none", ecolor="0.2", lw=0.9)
        upper.set_yscale("log")
        upper.set_ylim(1e-6, 1.5)
        upper.set_title(f"theta_i = {theta:.4g}")
        noise = np.array([r.noise for r in mine])
        lower.axhline(0, color="0.4", lw=0.7)
        lower.errorbar(
            x, [r.difference for r in mine], 2 * noise, fmt="o", ms=3, color="0.15", lw=1
        )
        lower.set_xticks(x, labels)
        lower.set_xlabel("order" + (" (t: transmitted)" if any("t" in n for n in labels) else ""))
    axes[0, 0].set_ylabel("energy, fraction of the incident")
    axes[1, 0].set_ylabel("modelled - simulated\n(bars: 2 std. errors)")
    axes[0, 0].legend(loc="upper right")
    save(figure, path)
