"""What a set of points of error and time says: slopes, and the Pareto front."""

import numpy as np

from surfaces.facet import Array


def slope(x: Array, y: Array, y_stderr: Array) -> tuple[float, float]:
    """Slope of log y over log x and its standard error, weighted by the errors of y; where points
    scatter more than these explain, the error is larger accordingly. Not a number for fewer than
    two points."""
    good = (x > 0) & (y > 0) & np.isfinite(y_stderr)
    x, y, y_stderr = x[good], y[good], y_stderr[good]
    if len(x) < 2 or np.ptp(np.log(x)) == 0:
        return np.nan, np.nan
    sigma = np.maximum(y_stderr / y, 1e-6)
    weight = 1 / sigma**2
    u, v = np.log(x), np.log(y)
    u_mean, v_mean = np.average(u, weights=weight), np.average(v, weights=weight)
    spread = (weight * (u - u_mean) ** 2).sum()
    value = (weight * (u - u_mean) * (v - v_mean)).sum() / spread
    if len(x) == 2:
        return float(value), float(np.sqrt(1 / spread))
    left = (weight * (v - v_mean - value * (u - u_mean)) ** 2).sum() / (len(x) - 2)
    return float(value), float(np.sqrt(max(left, 1) / spread))


def pareto(seconds: Array, error: Array) -> Array:
    """Who (n,) is beaten by nobody: no other point is at least as fast and as right, and better in
    one of the two."""
    faster = seconds[:, None] <= seconds
    better = error[:, None] <= error
    strictly = (seconds[:, None] < seconds) | (error[:, None] < error)
    beaten = (faster & better & strictly).any(axis=0)
    return ~beaten & np.isfinite(error) & np.isfinite(seconds)
