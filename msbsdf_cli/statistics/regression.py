"""Estimates by regression on control variates, figures of each unit whose means are known.

Units with too much of a control stand for too much of what goes along with it; a regression over
the units tells how much, and takes it off (R. Y. Rubinstein & R. Marcus, Efficiency of multivariate
control variates in Monte Carlo simulation, Operations Research 33, 1985).
"""

import numpy as np

from surfaces.facet import Array

INDEPENDENT = 1e-9
"""Eigenvalues of the controls' covariances over the greatest, below which controls do not vary, or
only together."""


def regress(
    sums: Array, products: Array, controls: Array, judged: slice
) -> tuple[Array, Array] | None:
    """Estimates of figures and the squares of their standard errors, (figures,) each.

    From sums over units: of the figures and of their squares (2, figures), of their products with
    each control (controls, figures), and of the products of 1 and the controls, each less its known
    mean, among themselves (controls + 1, controls + 1). None where there are too few units, or
    where the controls explain less of the figures `judged` than they cost.
    """
    n, number = controls[0, 0], len(products)
    if n <= number + 2:
        return None
    mean, offset = sums[0] / n, controls[0, 1:] / n
    scatter = np.maximum(sums[1] - n * mean * mean, 0)
    inverse = np.linalg.pinv(
        controls[1:, 1:] - n * np.outer(offset, offset), rcond=INDEPENDENT, hermitian=True
    )
    together = products - np.outer(n * offset, mean)
    slopes = inverse @ together
    left = np.maximum(scatter - (slopes * together).sum(axis=0), 0) / (n - 1 - number)
    variance = left * (1 / n + offset @ inverse @ offset)
    if not variance[judged].sum() < scatter[judged].sum() / (n * (n - 1)):
        return None
    return mean - offset @ slopes, variance
