"""The files of `msbsdf export`: a table of a BSDF, and albedos for NumPy and for C."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.renderers.tables import BsdfTable
from msbsdf_cli.results import npz
from surfaces.facet import Array

FORMAT = "table of msbsdf 1"

AXES = (
    "values[channel, cos_i, cos_o, phi]: BSDF per steradian at the middles of even parts of "
    "[0, 1], [0, 1] and [0, pi]; of specular facets without the first order"
)


def write_table(path: Path, table: BsdfTable, single_share: float, error: float) -> None:
    """bsdf.npz"""
    material = table.material
    about = {
        "slopes": table.slopes.name,
        "alpha": table.slopes.alpha_x,
        "material": material.name,
        "specular": material.specular,
        "single_share": single_share,
        "interpolation_error": error,
        "axes": AXES,
    }
    eta_k = np.array(getattr(material, "eta_k", ()), float).reshape(-1, 2)
    npz.write(path, FORMAT, about, {"values": table.values.astype(np.float32), "eta_k": eta_k})


def read_table(path: str | Path) -> dict[str, Any]:
    """What `write_table` wrote. Raises ValueError for any other file."""
    about, arrays = npz.read(path, FORMAT)
    return about | arrays


def c_header(slopes: str, directional: Array, mean: Array) -> str:
    """albedo.h"""
    rows, columns = directional.shape
    lines = [
        f"/* Directional albedo of mirrors by single scattering, {slopes} slopes:",
        "   msbsdf_albedo[i][j] at alpha = (i + .5) / rows and cos(theta) = (j + .5) / columns,",
        "   msbsdf_albedo_mean[i] its mean over the hemisphere, weighted by the cosine. */",
        f"static const float msbsdf_albedo[{rows}][{columns}] = {{",
        *("    {" + ", ".join(f"{x:.6f}f" for x in row) + "}," for row in directional),
        "};",
        f"static const float msbsdf_albedo_mean[{rows}] = {{",
        "    " + ", ".join(f"{x:.6f}f" for x in mean),
        "};",
    ]
    return "\n".join(lines) + "\n"
