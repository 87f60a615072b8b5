"""How far skewness and kurtosis of a patch may be off where its heights are Gaussian.

The figures themselves are made by few peaks, and so are errors told from the patch: where peaks
are missing, both come out small, and deviations over such errors are large. Of Gaussian heights the
autocorrelation rho, which all points tell, says it: the variance of Ssk is 6 / N times the sum of
rho^3 over all lags, that of Sku 24 / N times the sum of rho^4 (I. N. Lobato & C. Velasco, A simple
test of normality for time series, Econometric Theory 20, 2004).
"""

import numpy as np

from surfaces.facet import Array

MOST = 1 << 20
"""Points whose autocorrelation is taken, evenly spaced: what lies between is like them."""


def errors_of_gaussian(h: Array, periodic: bool) -> Array:
    """Standard errors (2,) of Ssk and Sku for heights (nx, ny) of mean 0."""
    every = int(np.ceil(np.sqrt(h.size / MOST)))
    h = h[::every, ::every]
    # Lags of more than half a patch are of few pairs, and those of a period are the same again.
    size = h.shape if periodic else tuple(2 * n for n in h.shape)
    power = np.abs(np.fft.rfft2(h, size)) ** 2
    found = np.fft.irfft2(power, size)
    share = np.ones(found.shape)
    if not periodic:
        lags = (np.minimum(np.arange(m), m - np.arange(m)) / (m / 2) for m in size)
        share = np.multiply.outer(*(np.where(lag <= 0.5, 1 - lag, 0) for lag in lags))
    rho = np.divide(found / found[0, 0], share, out=np.zeros_like(found), where=share > 0)
    cubes, fourths = ((share * rho**power).sum() / h.size for power in (3, 4))
    return np.sqrt([6 * max(cubes, 0), 24 * fourths])


def helped(own: Array, figures: Array, gaussian: Array) -> Array:
    """Standard errors of Ssk and Sku, of these `figures`: the root mean square of what a patch has
    of its `own` and of those of `gaussian` heights, where neither figure tells by two of the latter
    that heights are not Gaussian; else its own."""
    tells = np.abs(figures - [0, 3]) >= 2 * gaussian
    return own if tells.any() else np.hypot(own, gaussian) / np.sqrt(2)
