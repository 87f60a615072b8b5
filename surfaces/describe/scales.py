"""Roughness seen by a coarser and coarser eye: slopes depend on the scale they are measured at."""

import numpy as np

from surfaces.describe.quantities import Quantity
from surfaces.describe.spread import stderr
from surfaces.patch import Patch

MOST_SCALES = 8
"""Octaves of the filter length."""


def over_filter_length(patch: Patch, longest: float, unit: str) -> list[Quantity]:
    """Sdq after filters of growing length: octaves from two steps up to `longest`.

    Where it keeps growing towards the shortest, the surface has no roughness of its own, but one
    for each instrument.
    """
    length, rows = 2 * max(patch.step), list[Quantity]()
    while length <= longest and len(rows) < MOST_SCALES:
        square = (patch.filtered(length).slopes ** 2).sum(axis=0)
        sdq = float(np.sqrt(square.mean()))
        note = f"after a Gaussian filter of length {length:.6g} {unit}".rstrip()
        rows.append(Quantity("sdq_filtered", sdq, stderr(square) / (2 * sdq), "", note))
        length *= 2
    return rows
