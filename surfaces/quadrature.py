"""Gauss-Legendre quadrature on the unit interval."""

from functools import cache

from scipy.special import roots_legendre

from surfaces.facet import Array


@cache
def gauss(n: int) -> tuple[Array, Array]:
    """Nodes and weights (n,) on [0, 1], not to be written to."""
    x, weight = roots_legendre(n)
    x, weight = (x + 1) / 2, weight / 2
    x.flags.writeable = weight.flags.writeable = False
    return x, weight
