"""The files of `msbsdf export`: a table of a BSDF, and albedos for NumPy and for C."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.renderers.albedos import first_share
from msbsdf_cli.renderers.nodes import Nodes
from msbsdf_cli.renderers.tables import BLOCKS, BsdfTable
from msbsdf_cli.results import npz
from surfaces.facet import Array

FORMAT = "table of msbsdf 4"

AXES = (
    "values[channel, block, phi_i, theta_i, theta_o, phi]: BSDF per steradian, without the cosine, "
    "at the polar angles `theta` of either direction, the azimuths `phi_i` of incidence and `phi` "
    "from there to the outgoing direction; of specular facets without the first order. Cubic "
    "splines interpolate, as msbsdf_cli.renderers.nodes has it: of glass one on either side of the "
    "polar angle `split`; of light transmitted to or from beyond it in the medium of higher index, "
    "one on either side of where cosines in the two media are as their indices in reverse."
)

MEASURE = (
    "differences of BSDF x cosine in any channel, as parts of it, or of 0.01 / (2 pi) where that "
    "is more, in random directions up to theta 1.4 (even in solid angle)"
)


def write_table(path: Path, table: BsdfTable, errors: Array, known: Array) -> None:
    """bsdf.npz; `errors` of the table and what is known of the solution, as `table_error` says."""
    material, nodes = table.material, table.nodes
    about = {
        "slopes": table.slopes.name,
        "alpha": (table.slopes.alpha_x, table.slopes.alpha_y),
        "material": material.name,
        "specular": material.specular,
        "ior": material.ior if material.transmits else None,
        "nodes": asdict(nodes),
        "single_share": first_share(table.slopes, material),
        "error": {"largest": float(errors.max()), "mean": float(errors.mean())},
        "error_of_solution": {"largest": float(known.max()), "mean": float(known.mean())},
        "error_measure": MEASURE,
        "axes": AXES,
        "blocks": BLOCKS[: table.values.shape[1]],
    }
    arrays = {
        "values": table.values.astype(np.float32),
        "eta_k": np.array(getattr(material, "eta_k", ()), float).reshape(-1, 2),
        "theta": nodes.theta,
        "phi_i": nodes.phi_i,
        "phi": nodes.phi,
    }
    npz.write(path, FORMAT, about, arrays)


def read_table(path: str | Path) -> dict[str, Any]:
    """What `write_table` wrote, `nodes` as `Nodes`. Raises ValueError for any other file."""
    about, arrays = npz.read(path, FORMAT)
    return about | arrays | {"nodes": Nodes(**about["nodes"])}


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
