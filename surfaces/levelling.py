"""Taking out of a measured patch what is no roughness: its tilt, or its form."""

from itertools import product

import numpy as np

from surfaces.facet import Array

MOST_DEGREE = 8
"""Of the form: a higher one takes out roughness."""


def levelled(heights: Array, degree: int = 1) -> Array:
    """Heights (nx, ny) less their least-squares polynomial of total degree `degree`: 0 takes out
    the mean, 1 the plane, 2 a bow as well. Raises ValueError for a degree out of range.

    The polynomials are products of Legendre's, which are nearly orthogonal on the grid, so that
    the normal equations keep their digits.
    """
    if degree != int(degree) or not 0 <= degree <= MOST_DEGREE:
        raise ValueError(
            f"the degree is {degree}: a whole number from 0 to {MOST_DEGREE} is wanted."
        )
    x, y = (_legendre(n, int(degree)) for n in heights.shape)
    terms = [(p, q) for p, q in product(range(degree + 1), repeat=2) if p + q <= degree]
    p, q = np.array(terms).T
    # All terms are products, so the sums over the grid are products of sums along the axes.
    normal = (x @ x.T)[np.ix_(p, p)] * (y @ y.T)[np.ix_(q, q)]
    coefficients = np.zeros((degree + 1, degree + 1))
    coefficients[p, q] = np.linalg.solve(normal, (x @ heights @ y.T)[p, q])
    return heights - (x.T @ coefficients) @ y


def _legendre(n: int, degree: int) -> Array:
    """Legendre polynomials (degree + 1, n) at n points of [-1, 1]."""
    return np.polynomial.legendre.legvander(np.linspace(-1, 1, n), degree).T
