"""heitz_10.png"""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.experiments.figures.settings import Tables
from msbsdf_cli.plots.figures.rows import where
from msbsdf_cli.plots.style import COLOURS, HALO, panels, save

OUTSIDE = 3.2
"""Height, in standard deviations, at which light from outside is drawn to begin and to end."""


def draw_heitz_10(tables: Tables, directory: Path) -> None:
    """The path in the plane of incidence, its heights and energies, and their means over walks."""
    one, mean = where(tables["heitz_10"]), where(tables["heitz_10_mean"])
    figure, axes = panels(1, [3.0, 1.9, 1.9], 2.4, (0.6, 0.6))
    _path(axes[0, 0], one)
    facets = one["facet"][:-1]
    for axis, name in zip(axes[0, 1:], ("height", "energy"), strict=True):
        axis.plot(facets, one[name][:-1], "o-", ms=4, color=COLOURS[1], label="this walk")
        means = mean["facet"], mean[name], mean[f"{name}_stderr"]
        axis.errorbar(*means, fmt="s", ms=3, lw=1, color=COLOURS[0], label="mean of all walks")
        axis.set_xlabel("facet")
        axis.set_xticks(facets)
    axes[0, 1].set_title("height [standard deviations]")
    axes[0, 2].set_title("energy before the facet")
    axes[0, 2].set_ylim(0, 1.05)
    figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="upper right", ncols=2)
    save(figure, directory / "heitz_10.png")


def _path(axis: Any, one: dict[str, Any]) -> None:
    """Rays from facet to facet; the horizontal way follows from height and direction."""
    finite = np.isfinite(one["height"])
    heights = np.concatenate([[OUTSIDE], one["height"][finite], [OUTSIDE]])
    slope = np.tan(one["theta_r_rad"]) * np.cos(one["phi_r_rad"])
    x = np.concatenate([[0.0], np.cumsum(np.diff(heights) * slope)])
    low = min(x.min(), 0) - 1.5
    axis.set_xlim(low, x.max() + 0.6)
    axis.set_ylim(-3.2, OUTSIDE + 0.1)
    way = np.diff(axis.transData.transform(np.stack([x, heights], axis=1)), axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    near: dict[str, Any] = {
        "textcoords": "offset points",
        "ha": "center",
        "va": "center",
        "path_effects": HALO,
    }
    for k, energy in enumerate(one["energy"]):
        ends = {"xy": (x[k + 1], heights[k + 1]), "xytext": (x[k], heights[k])}
        arrow = {"arrowstyle": "->", "lw": 0.4 + 2 * energy, "color": COLOURS[1]}
        arrow |= {"shrinkA": 0, "shrinkB": 0}
        axis.annotate("", **ends, arrowprops=arrow)
        middle = (x[k] + x[k + 1]) / 2, (heights[k] + heights[k + 1]) / 2
        # Beside the ray.
        axis.annotate(f"{energy:.2g}", middle, 10 * way[k, ::-1] * [1, -1], fontsize=6, **near)
    axis.plot(x[1:-1], heights[1:-1], "o", ms=4, color="0.1")
    for k, at in enumerate(zip(x[1:-1], heights[1:-1], strict=True)):
        # Where neither ray is.
        away = way[k] - way[k + 1]
        offset = 9 * away / max(float(np.linalg.norm(away)), 1e-9)
        axis.annotate(f"$h_{k + 1}$", at, offset, fontsize=7, **near)
    h = np.linspace(-3, 3, 60)
    axis.fill_betweenx(h, low, low + 1.2 * np.exp(-h * h / 2), color=COLOURS[0], alpha=0.25)
    axis.set_xlabel("way along the plane of incidence [std. dev. of height]")
    axis.set_ylabel("height [standard deviations]")
    axis.set_title("one walk; numbers: its energy; shade: density of heights")
