"""The jackknife."""

import numpy as np

from surfaces.facet import Array


def jackknife(left_out: Array) -> float:
    """Standard error from the values (r,) that are left when one of r is left out."""
    r = len(left_out)
    return float(np.sqrt((r - 1) / r * ((left_out - left_out.mean()) ** 2).sum()))
