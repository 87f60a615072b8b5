"""free_path.png: heights of the next facet ([HHdD16] figure 14)."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.plots.style import COLOURS, panels, save
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.statistics.tally import Estimate
from surfaces.facet import Array


def draw_free_paths(path: Path, paths: FreePaths, modelled: FreePaths | None = None) -> None:
    """A panel for each direction of travel and height of start, with the probability of escape; of
    one run, or of a simulated one and a modelled one."""
    simulated, model = paths.rows(), {} if modelled is None else modelled.rows()
    directions, starts = paths.theta, paths.starts
    figure, axes = panels(len(starts), [1.9] * len(directions), 0.95, (0.4, 0.35), sharex=True)
    for i, start in enumerate(starts):
        for j, theta in enumerate(directions):
            axis, key = axes[i, j], (theta, start)
            _panel(axis, paths.edges, simulated.get(key), model.get(key), modelled is not None)
            name = "outside" if np.isinf(start) else f"h = {start:g}"
            axis.set_title(f"from {name}, theta_r = {theta:.4g}", fontsize=7)
    for axis in axes[-1]:
        axis.set_xlabel("height of the next facet")
    for axis in axes[:, 0]:
        axis.set_ylabel("probability density")
    if modelled is not None:
        handles = axes[0, 0].get_legend_handles_labels()
        figure.legend(*handles, loc="upper right", ncols=2)
    save(figure, path)


def _panel(
    axis: Any, edges: Array, simulated: Estimate | None, modelled: Estimate | None, both: bool
) -> None:
    finite = np.isfinite(edges[:-1]) & np.isfinite(edges[1:])
    width, middle = np.diff(edges)[finite], (edges[:-1] + edges[1:])[finite] / 2
    text = []
    for i, (found, label) in enumerate(((simulated, "simulated"), (modelled, "modelled"))):
        if found is None:
            continue
        density, error = (a[:-1][finite] / width for a in (found.value, found.stderr))
        look = {"color": COLOURS[i], "label": label}
        if both and found is simulated:
            axis.errorbar(middle, density, error, fmt="o", ms=1.6, lw=0.7, **look)
        else:
            axis.plot(middle, density, **look)
            axis.fill_between(middle, density - error, density + error, color=COLOURS[i], alpha=0.3)
        # The last bin holds those that escaped.
        text.append(f"escape {found.value[-1]:.3f}" + (f" {label}" if both else ""))
    small = {"transform": axis.transAxes, "fontsize": 6}
    if simulated is None:
        sentence = "no facet of this height\nfaces this way"
        axis.text(0.5, 0.5, sentence, ha="center", va="center", **small)
    box = {"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1}
    axis.text(0.97, 0.95, "\n".join(text), ha="right", va="top", bbox=box, **small)
    axis.set_ylim(0, max(1.3 * axis.get_ylim()[1], 0.01))
