"""How much memory a solution takes, told before any of it is taken."""

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from surfaces.materials import Material

COPIES, COPIES_OF_INTERFACES = 17, 50
"""Memory over that of one kernel between all nodes. Measured: 17 for a mirror of roughness 0.05, 13
of 1,0.1; for glass 53 of roughness 0.1, 36 of 0.05, of 1,0.1 and of 1,0.05."""


def needed_bytes(slopes: Slopes, material: Material) -> float:
    """About how many bytes directional values take, at resolution 1."""
    alpha, wide = sorted((slopes.alpha_x, slopes.alpha_y))
    if material.transmits:
        elevations, modes, copies = 16 + 4 / alpha, 16 + 16 / alpha, COPIES_OF_INTERFACES
    else:
        elevations, modes, copies = 20 + 2.4 / alpha, 40 + 40 / alpha, COPIES
    kernel = (elevations + 10 * np.sqrt(alpha)) ** 2 * modes
    if alpha != wide:
        per_alpha, rough = (0.4, 2) if material.transmits else (1.2, 6)
        elevations = 14 + per_alpha / alpha + rough * np.sqrt(wide)
        kernel = 4 * (elevations * (8 + wide / alpha + 1 / alpha)) ** 2
    return float(8 * copies * kernel)
