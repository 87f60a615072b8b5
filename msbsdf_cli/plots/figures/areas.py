"""heitz_7.png and wang_2.png"""

from pathlib import Path

import numpy as np
from matplotlib.lines import Line2D

from msbsdf_cli.experiments.figures.settings import Tables
from msbsdf_cli.plots.figures.rows import values, where
from msbsdf_cli.plots.style import COLOURS, in_degrees, panels, save


def draw_heitz_7(tables: Tables, directory: Path) -> None:
    """Extinction over height: lines are Eq. 24, points light lost on explicit surfaces."""
    table = tables["heitz_7"]
    figure, axes = panels(1, [3.0, 3.0], 2.4)
    for axis, down in zip(axes[0], (False, True), strict=True):
        some = [t for t in values(table, "theta_r_rad") if (t > np.pi / 2) == down]
        for k, theta in enumerate(some):
            model = where(table, source="model", theta_r_rad=theta)
            axis.plot(model["height"], model["extinction"], color=COLOURS[k])
            found = where(table, source="surfaces", theta_r_rad=theta)
            bars = found["height"], found["extinction"], found["stderr"]
            axis.errorbar(*bars, fmt="o", ms=2, lw=0.7, color=COLOURS[k], label=in_degrees(theta))
        axis.set_yscale("log")
        axis.set_ylim(1e-3, 10)
        axis.set_xlabel("height [standard deviations]")
        axis.set_title(
            "light that travels " + ("down, from outside" if down else "up, from h = -2")
        )
        axis.legend(title="theta_r", loc="upper right", title_fontsize=7)
    axes[0, 0].set_ylabel("extinction [1 / std. dev. of height]")
    handles = [
        Line2D([], [], color="0.3", label="Smith model, Eq. 24"),
        Line2D([], [], color="0.3", marker="o", ms=2, ls="", label="Beckmann surfaces, alpha 1"),
    ]
    figure.legend(handles=handles, loc="upper left", ncols=2)
    save(figure, directory / "heitz_7.png")


def draw_wang_2(tables: Tables, directory: Path) -> None:
    """Distant masking over the sphere, and how far closed form and quadrature are apart."""
    table = tables["wang_2"]
    figure, axes = panels(1, [3.4, 2.6], 2.4, (0.75, 0.6))
    for k, slopes in enumerate(values(table, "slopes")):
        rows = where(table, slopes=slopes)
        angle = np.degrees(rows["theta_rad"])
        axes[0, 0].plot(angle, rows["closed_form"], color=COLOURS[k], label=f"{slopes}, Eq. 3")
        axes[0, 0].plot(
            angle[:: max(angle.size // 30, 1)],
            rows["quadrature"][:: max(angle.size // 30, 1)],
            "o", ms=2.5, mfc="none", color=COLOURS[k], label=f"{slopes}, integral of Eq. 4",
        )  # fmt: skip
        apart = np.abs(rows["quadrature"] / rows["closed_form"] - 1)
        axes[0, 1].plot(angle, np.maximum(apart, np.finfo(float).eps), ".", ms=3, color=COLOURS[k])
    axes[0, 0].axhline(1, color="0.6", lw=0.6)
    for axis, label in zip(axes[0], ("G1 distant", "relative difference of the two"), strict=True):
        axis.set_yscale("log")
        axis.set_xticks([0, 45, 90, 135, 180])
        axis.set_xlabel("theta [degrees]; beyond 90 from below")
        axis.set_title(label)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="upper left", ncols=4)
    save(figure, directory / "wang_2.png")
