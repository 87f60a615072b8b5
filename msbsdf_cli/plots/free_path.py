"""Pictures of free paths, from free_path.csv ([HHdD16] figure 14)."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.plots.style import COLOURS, panels, save
from msbsdf_cli.results.directory import read_csv

NUMBERS = (
    "theta_r_rad",
    "height_start",
    "height_low",
    "height_high",
    "probability",
    "stderr",
)

Rows = dict[tuple[float, float], Any]
"""By direction of travel and height of start: low, high, probability, stderr, (bins + 1,) each."""


def load_free_paths(directory: Path) -> Rows:
    """The free paths of a report; raises click.ClickException for a file that is not one."""
    table = read_csv(directory / "free_path.csv", NUMBERS)
    columns = np.array([table[name] for name in NUMBERS])
    rows: Rows = {}
    for key in dict.fromkeys(zip(table["theta_r_rad"], table["height_start"], strict=True)):
        mine = (columns[0] == key[0]) & (columns[1] == key[1])
        rows[key] = columns[2:, mine]
    return rows


def draw_free_paths(directory: Path, modelled: Path | None = None, out: Path | None = None) -> None:
    """free_path.png: a panel for each direction of travel and height of start, with the share of
    rays that escape; of one report, or of a simulated one and a modelled one."""
    ours = load_free_paths(directory)
    theirs = load_free_paths(modelled) if modelled is not None else {}
    directions = list(dict.fromkeys(theta for theta, _ in ours))
    starts = list(dict.fromkeys(start for _, start in ours))
    figure, axes = panels(len(starts), [1.9] * len(directions), 0.95, (0.4, 0.35), sharex=True)
    for i, start in enumerate(starts):
        for j, theta in enumerate(directions):
            axis = axes[i, j]
            _panel(axis, ours.get((theta, start)), theirs.get((theta, start)), modelled is not None)
            name = "outside" if np.isinf(start) else f"h = {start:g}"
            axis.set_title(f"from {name}, theta_r = {theta:.4g}", fontsize=7)
    for axis in axes[-1]:
        axis.set_xlabel("height of the next facet")
    for axis in axes[:, 0]:
        axis.set_ylabel("probability density")
    if modelled is not None:
        handles = axes[0, 0].get_legend_handles_labels()
        figure.legend(*handles, loc="upper right", ncols=2)
    save(figure, (out or directory) / "free_path.png")


def _panel(axis: Any, ours: Any, theirs: Any, both: bool) -> None:
    text = []
    for rows, label, colour in ((ours, "simulated", COLOURS[0]), (theirs, "modelled", COLOURS[1])):
        if rows is None:
            if label == "simulated":
                axis.text(
                    0.5,
                    0.5,
                    "no facet of this height\nfaces this way",
                    ha="center",
                    va="center",
                    transform=axis.transAxes,
                    fontsize=6,
                )
            continue
        low, high, probability, stderr = rows
        escape = np.isinf(low) & np.isinf(high) & (low > 0)
        inner = np.isfinite(low) & np.isfinite(high)
        width = high[inner] - low[inner]
        density, error = probability[inner] / width, stderr[inner] / width
        middle = (low + high)[inner] / 2
        if label == "simulated" and both:
            axis.errorbar(
                middle, density, error, fmt="o", ms=1.6, lw=0.7, color=colour, label=label
            )
        else:
            colour = colour if both else COLOURS[0]
            axis.plot(middle, density, color=colour, label=label)
            axis.fill_between(middle, density - error, density + error, color=colour, alpha=0.3)
        text.append(f"escape {probability[escape][0]:.3f}" + (f" {label}" if both else ""))
    axis.text(
        0.97,
        0.95,
        "\n".join(text),
        ha="right",
        va="top",
        transform=axis.transAxes,
        fontsize=6,
        bbox={"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1},
    )
    axis.set_ylim(0, max(1.3 * axis.get_ylim()[1], 0.01))
