"""free_path.png: heights of the next facet ([HHdD16] figure 14)."""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.plots.style import COLOURS, in_degrees, panels, save, short_ticks
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.statistics.tally import Estimate
from surfaces.facet import Array


def draw_free_paths(path: Path, paths: FreePaths, modelled: FreePaths | None = None) -> None:
    """A panel for each direction of travel and height of start from which some light meets a facet
    and some points of the surface face, with the probability of escape; of one run, or of a
    simulated one and a modelled one."""
    simulated, model = paths.rows(), {} if modelled is None else modelled.rows()
    both = product(paths.starts, paths.theta)
    shown = [(theta, start) for start, theta in both if _meets(simulated.get((theta, start)))]
    columns = min(4, max(len(shown), 1))
    rows = max(-(-len(shown) // columns), 1)
    figure, axes = panels(rows, [1.9] * columns, 1.1, (0.4, 0.5), sharex=True)
    for axis, key in zip(axes.flat, shown, strict=False):
        escapes = _panel(axis, paths.edges, simulated.get(key), model.get(key))
        theta, start = key
        name = "outside" if np.isinf(start) else f"h = {start:g}"
        axis.set_title(f"from {name} towards {in_degrees(theta)}\n{escapes}", fontsize=7)
    for axis in axes.flat[len(shown) :]:
        axis.set_visible(False)
    for axis in axes[-1]:
        axis.set_xlabel("height of the next facet [std. dev.]")
    for axis in axes[:, 0]:
        axis.set_ylabel("density")
    if modelled is not None:
        handles = axes[0, 0].get_legend_handles_labels()
        figure.legend(*handles, loc="upper right", ncols=2)
    left_out = len(paths.starts) * len(paths.theta) - len(shown)
    if left_out:
        words = f"{left_out} more in free_path.csv: all light escapes, or no facet faces that way."
        figure.text(0.01, 0.01, words, fontsize=6, color="0.35")
    save(figure, path)


def _meets(found: Estimate | None) -> bool:
    """Whether more light meets a facet than a panel could show as nothing."""
    return found is not None and float(found.value[-1]) < 0.9995


def _panel(axis: Any, edges: Array, simulated: Estimate | None, modelled: Estimate | None) -> str:
    """Draw what is known; who escapes, in words."""
    finite = np.isfinite(edges[:-1]) & np.isfinite(edges[1:])
    width, middle = np.diff(edges)[finite], (edges[:-1] + edges[1:])[finite] / 2
    escapes = []
    for i, (found, label) in enumerate(((simulated, "simulated"), (modelled, "modelled"))):
        if found is None:
            continue
        density, error = (a[:-1][finite] / width for a in (found.value, found.stderr))
        look = {"color": COLOURS[i], "label": label}
        if modelled is not None and found is simulated:
            axis.errorbar(middle, density, error, fmt="o", ms=1.6, lw=0.7, **look)
        else:
            axis.plot(middle, density, **look)
            axis.fill_between(middle, density - error, density + error, color=COLOURS[i], alpha=0.3)
        # The last bin holds those that escaped.
        escapes.append(f"{found.value[-1]:.3f}")
    axis.set_ylim(bottom=0)
    short_ticks(axis)
    return " / ".join(escapes) + " escape"
