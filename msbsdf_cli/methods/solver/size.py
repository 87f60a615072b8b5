"""How much memory a solution takes, told before any of it is taken."""

import numpy as np

from msbsdf_cli.methods.solver.interpolation import DENSE_WITH_EDGES
from msbsdf_cli.methods.solver.nodes import DENSE
from msbsdf_cli.smith.slopes import Slopes
from surfaces.materials import Material

COPIES, COPIES_OF_INTERFACES = 20, 50
"""Memory over that of one kernel between all nodes. Measured: 17 for a mirror of roughness 0.02, 13
of 0.01 and of 1,0.1; for glass 41 of roughness 0.05, 38 of 0.02, 36 of 1,0.1 and of 1,0.05."""


EVALUATION_S, PRODUCT_S = 5e-5, 3.5e-9
"""Seconds for all azimuths of the kernel of a mirror between two elevations, and for each product
of two elevations and a third in one mode, of all orders."""


def chosen_modes(modes: float, dense: int) -> float:
    """About how many of the modes are computed, see `nodes.sparse_modes`."""
    return float(min(modes, dense * (1 + np.log(max(modes / dense, 1)))))


def needed_bytes(slopes: Slopes, material: Material) -> float:
    """About how many bytes directional values take, at resolution 1."""
    alpha, wide = sorted(slopes.alpha)
    if material.transmits:
        modes = chosen_modes(16 + 16 / alpha, DENSE_WITH_EDGES)
        elevations, copies = 16 + 4 / alpha, COPIES_OF_INTERFACES
    else:
        modes = chosen_modes(40 + 40 / alpha, DENSE)
        elevations, copies = 20 + 2.4 / alpha, COPIES
    kernel = (elevations + 10 * np.sqrt(alpha)) ** 2 * modes
    if alpha != wide:
        per_alpha, rough = (0.4, 2) if material.transmits else (1.2, 6)
        elevations = 14 + per_alpha / alpha + rough * np.sqrt(wide)
        kernel = 4 * (elevations * (8 + wide / alpha + 1 / alpha)) ** 2
    return float(8 * copies * kernel)


def energy_seconds(slopes: Slopes, material: Material) -> float:
    """About how many seconds one core needs for the energies of all orders, at resolution 1."""
    alpha, wide = sorted(slopes.alpha)
    if alpha != wide:
        nodes = (14 + 1.2 / alpha + 6 * np.sqrt(wide)) * (4 + 1.4 * wide / alpha)
        return float((2e-8 if material.transmits else 1e-8) * nodes**3 + 0.1)
    nodes = 20 + 2.4 / alpha + 10 * np.sqrt(alpha)
    return float(5e-8 * nodes**3 + 1e-5 * nodes**2) * (6 if material.transmits else 1)


def value_seconds(slopes: Slopes, material: Material) -> float:
    """About how many seconds one core needs for directional values, at resolution 1: fits to what
    was measured at roughness 0.01 to 100 and 1,0.1."""
    alpha, wide = sorted(slopes.alpha)
    if alpha != wide:
        per_alpha, wider, each = (0.4, 2, 6e-8) if material.transmits else (1.2, 6, 8e-9)
        lobes = 8 + wide / alpha + 1 / alpha
        return float(each * ((14 + per_alpha / alpha + wider * np.sqrt(wide)) * lobes) ** 3)
    rough = max(alpha - 1, 0)
    if material.transmits:
        nodes, modes = 16 + 4 / alpha, chosen_modes(16 + 16 / alpha, DENSE_WITH_EDGES)
        many_orders = 3e-5 * rough * (nodes + 10 * np.sqrt(alpha)) ** 2
        return float(1.3 + many_orders + 5e-6 * (nodes + 2 * np.sqrt(alpha)) ** 2 * modes)
    nodes = 20 + 2.4 / alpha + 10 * np.sqrt(alpha)
    if not material.specular:
        return float(0.4 + 8e-7 * nodes**3 * (1 + rough))
    each = EVALUATION_S + PRODUCT_S * nodes * chosen_modes(40 + 40 / alpha, DENSE)
    return float(0.03 * rough + each * nodes**2)
