"""A figure with its standard error, and figures made of others."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from surfaces.facet import Array

SMALL = 1e-4
"""Steps of derivatives, over the size of what is varied: half the digits of a double, and some."""


@dataclass(frozen=True)
class Quantity:
    """A row of roughness.csv."""

    quantity: str
    value: float
    stderr: float
    unit: str = ""
    note: str = ""


def propagated(
    function: Callable[[Array], Array], x: Array, covariance: Array
) -> tuple[Array, Array]:
    """Values of `function` at `x` (m,), and their standard errors, to first order in those of x."""
    value = function(x)
    gradient = np.zeros((value.size, x.size))
    for i, h in enumerate(SMALL * np.maximum(np.abs(x), np.sqrt(np.diag(covariance)))):
        # What is 0 without an error is varied by nothing.
        if h > 0:
            step = h * (np.arange(x.size) == i)
            gradient[:, i] = (function(x + step) - function(x - step)) / (2 * h)
    variance = np.einsum("ki,ij,kj->k", gradient, covariance, gradient)
    return value, np.sqrt(np.maximum(variance, 0))
