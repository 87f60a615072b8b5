"""heitz_sequences.png"""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.experiments.figures.settings import Tables
from msbsdf_cli.plots.figures.rows import values, where
from msbsdf_cli.plots.lobes import hemisphere, mark
from msbsdf_cli.plots.style import panels, save
from msbsdf_cli.results.files import Table
from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, lobe_axes
from surfaces.facet import Array

ACROSS = 5


def draw_heitz_sequences(tables: Tables, directory: Path) -> None:
    """A map for each sequence, by the walk and, below it, on surfaces; with their energies."""
    lobes, energies = tables["heitz_sequences"], tables["heitz_sequences_energy"]
    names = [(ior, s) for ior in values(lobes, "ior") for s in _shown(energies, ior)]
    lines = -(-len(names) // ACROSS)
    figure, axes = panels(2 * lines, [1.45] * ACROSS, 1.45, (0.2, 0.62), right=0.5)
    for axis in axes.flat:
        axis.set_visible(False)
    for k, (ior, name) in enumerate(names):
        pair = [_density(lobes, ior=ior, source=source, sequence=name) for source in SOURCES]
        top = max(float(density.max()) for density in pair)
        for i, (source, density) in enumerate(zip(SOURCES, pair, strict=True)):
            axis = axes[2 * (k // ACROSS) + i, k % ACROSS]
            axis.set_visible(True)
            found = where(energies, ior=ior, source=source, sequence=name)
            total, error = (found[n][0] for n in ("energy", "stderr"))
            way = "from outside" if ior > 1 else "from inside"
            title = f"{name}, light {way}\n{source}: {total:.5f} ± {error:.1g}"
            hemisphere(axis, density, top, title)
            mark(axis, float(found["theta_i_rad"][0]), 0.0)
    save(figure, directory / "heitz_sequences.png")


SOURCES = ("walk", "surfaces")


LEAST = 1e-4
"""Energy of a sequence that is shown; others are in the tables."""


def _shown(energies: Table, ior: float) -> list[str]:
    rows = where(energies, ior=ior)
    known = (rows["energy"] > LEAST) & (rows["sequence"] != "others")
    return list(dict.fromkeys(rows["sequence"][known].tolist()))


def _density(lobes: Table, **wanted: Any) -> Array:
    rows = where(lobes, **wanted)
    polar, azimuth, _ = lobe_axes()
    theta = np.minimum(rows["theta_o_rad"], np.pi - rows["theta_o_rad"])
    density = np.zeros((THETA_BINS, PHI_BINS))
    row = np.rint((theta - polar[0]) / (polar[1] - polar[0])).astype(int)
    density[row, np.rint(rows["phi_o_rad"] / azimuth[1]).astype(int)] = rows["density_per_sr"]
    return density
