"""What a facet's height, slope and curvature say of the surface at a distance, on a lattice.

Lengths are such that slopes, as heights, have variance 1: R''(0) = -1. The facet is a vector of
four numbers: delta = c - s > 0, by which the ray that leaves it is steeper than it is, its height
h, its slope s along the ray, and its curvature along the ray above that which its height lets one
expect, in deviations. Given these, height, slope and curvature of the surface at distance x are
Gaussian, and so is the height behind, at x - tau, to which the hazard looks back. Means are linear
in the four numbers; the distances of the ray from them, in standard deviations, are what is
tabulated:

    b     of the ray above the surface, at x
    k     of its slope above the surface's, given that the surface is as high as the ray
    back  of the ray above the surface, at x - tau
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from surfaces.facet import Array
from surfaces.spectrum import Spectrum

STEP = 0.01
"""Relative step of the lattice: distances are rounded to it, and nothing else is."""

NEAREST = 1e-4
SERIES = 0.1
"""Below, differences of nearly equal numbers lose their digits: the surface is a parabola, and how
far it is off goes with the cube of the distance."""

FORGOTTEN = 3e-3
"""What the surface remembers so little of as this, it does not."""

FARTHEST = 60.0
"""Some correlation lengths of any spectrum: what goes on beyond for ever is a ringing of slopes."""

LAGS = np.geomspace(0.2, 8, 80)
"""Distances to look back that are tried."""


@dataclass(frozen=True, eq=False)
class Correlation:
    """Coefficients at the lattice's distances `x` (n,), the last for all beyond."""

    x: Array
    distances: Array
    """b, k and back from the four numbers of the facet, (3, 4, n)."""
    curvature: Array
    """Mean curvature of the facet that is met, in deviations and above what its height lets one
    expect, from the four numbers and what its slope is above the ray's, (5, n)."""
    rest: Array
    """Its deviation from that mean, (n,)."""
    slope: Array
    """Deviation of the slope, given the height, (n,)."""
    across: Array
    """Correlation of slopes across the ray, (n,)."""
    behind: Array
    """Correlation of the height behind with the height, and with the slope given the height; the
    deviation of the slope over that of the height, (3, n)."""
    lag: float
    """How far it is looked back beyond the lattice."""
    far: Array
    """`behind` there, (3,)."""
    bend: float
    """Deviation of the curvature, given height and slope."""
    fourth: float
    """Mean fourth power of wave numbers along a line."""

    def index(self, x: Array) -> Array:
        """The lattice's place next to distances `x`."""
        place = np.log(np.maximum(x, NEAREST) * (1 / NEAREST)) * (1 / np.log1p(STEP))
        return np.minimum((place + 0.5).astype(np.intp), self.x.size - 1)


@lru_cache(maxsize=4)
def correlation(spectrum: Spectrum, dtype: type = np.float32) -> Correlation:
    """That of a surface of this spectrum."""
    number = int(np.log(farthest(spectrum) / NEAREST) / np.log1p(STEP)) + 1
    x = NEAREST * (1 + STEP) ** np.arange(number)
    fourth = float(derivatives(spectrum, np.zeros(1))[4, 0])
    bend, tau = np.sqrt(fourth - 1), look_back(spectrum)
    # Nearer than that all is as there, but for a scale.
    far = np.maximum(x, SERIES)
    first = int(np.searchsorted(x, SERIES)) - 1
    known = ahead(spectrum, far[first:], np.minimum(tau, far[first:] / 2), fourth)
    mean, C = (np.concatenate([np.repeat(a[:1], first, axis=0), a]) for a in known)
    lag = np.minimum(tau, far / 2)
    # The ray, its slope and its height behind, less those means; the curvature's mean itself.
    own = np.zeros((x.size, 4, 4))
    own[:, 0] = np.stack([far, np.ones_like(far), far, np.zeros_like(far)], 1)
    own[:, 1] = [1, 0, 1, 0]
    own[:, 2] = np.stack([far - lag, np.ones_like(far), far - lag, np.zeros_like(far)], 1)
    above = own - mean
    height, behind = np.sqrt(C[:, 0, 0]), np.sqrt(C[:, 2, 2])
    turn = C[:, 0, 1] / C[:, 0, 0]
    slope = np.sqrt(C[:, 1, 1] - turn * C[:, 0, 1])
    steeper = above[:, 1] - turn[:, None] * above[:, 0]
    shared = (C[:, 1, 2] - turn * C[:, 0, 2]) / slope
    # A parabola comes back to the ray as much steeper than that as it was less steep.
    near = x < SERIES
    scale = np.where(near, x / SERIES, 1.0)
    above[near, 0] = np.stack([x, x * x / 2, 0 * x, -x * x / 2 * bend], 1)[near]
    steeper[near] = [-1, 0, 0, 0]
    height, slope = height * scale**3, slope * scale**3
    rows = above[:, 0] / height[:, None], steeper / slope[:, None], above[:, 2] / behind[:, None]
    curvature, rest = _curvature(mean, C, above[:, 0], steeper, bend)
    across = np.concatenate([np.ones(first), -derivatives(spectrum, x[first:])[1] / x[first:]])
    # Only upward crossings are there while the surface is a parabola.
    rate = np.where(near, 0, slope / height)
    parts = (
        x,
        np.stack(rows).transpose(0, 2, 1),
        curvature.T,
        rest,
        slope,
        across,
        np.stack([C[:, 0, 2] / np.sqrt(C[:, 0, 0]) / behind, shared / behind, rate]),
    )
    names = "x", "distances", "curvature", "rest", "slope", "across", "behind", "far"
    far = np.append(derivatives(spectrum, np.array([tau]))[:2, 0], 1)
    arrays: dict[str, Any] = {
        name: np.ascontiguousarray(a, dtype) for name, a in zip(names, (*parts, far), strict=True)
    }
    return Correlation(lag=tau, bend=float(bend), fourth=fourth, **arrays)


def ahead(spectrum: Spectrum, x: Array, lag: Array, fourth: float) -> tuple[Array, Array]:
    """Means (n, 4, 4) of the surface's height and slope at distances `x`, its height `lag` before,
    and its curvature above what the height lets one expect, from the four numbers of the facet, and
    their covariance (n, 4, 4)."""
    R, back, between = (derivatives(spectrum, a) for a in (x, x - lag, lag))
    # Of h, h' and h'' at 0 with h, h' at x, h at x - lag, and h'' + h at x: (-1)^b R^(a + b).
    sign = np.array([1, -1, 1])
    cross = np.stack([R[:3], R[1:4], back[:3], R[2:5] + R[:3]], 0).transpose(2, 0, 1) * sign
    start = np.linalg.inv(np.array([[1, 0, -1], [0, 1, 0], [-1, 0, fourth]]))
    C = np.zeros((x.size, 4, 4))
    C[:, 0, 0] = C[:, 1, 1] = C[:, 2, 2] = 1
    C[:, 3, 3] = fourth - 1
    C[:, 0, 2] = C[:, 2, 0] = between[0]
    C[:, 1, 2] = C[:, 2, 1] = between[1]
    C[:, 2, 3] = C[:, 3, 2] = between[0] + between[2]
    slopes = cross @ start
    C -= slopes @ cross.transpose(0, 2, 1)
    # From (h, s, h'') to (delta, h, s, curvature): h'' = -h + bend u.
    bend = np.sqrt(fourth - 1)
    mean = np.zeros((x.size, 4, 4))
    mean[:, :, 1], mean[:, :, 2] = slopes[..., 0] - slopes[..., 2], slopes[..., 1]
    mean[:, :, 3] = slopes[..., 2] * bend
    return mean, C


def _curvature(
    mean: Array, C: Array, above: Array, steeper: Array, bend: float
) -> tuple[Array, Array]:
    """The curvature of the facet that is met, in deviations: its mean from the four numbers and
    what its slope is above the ray's, and what it scatters about that."""
    seen = np.linalg.solve(C[:, :2, :2], C[:, :2, 3:])[..., 0]
    turn = C[:, 0, 1] / C[:, 0, 0]
    # The slope less its mean, where the surface is as high as the ray: what it is above the ray's,
    # and `steeper` and `turn` times `above`.
    of_height = seen[:, 0] + seen[:, 1] * turn
    rows = mean[:, 3] + of_height[:, None] * above + seen[:, 1, None] * steeper
    rest = C[:, 3, 3] - (seen * C[:, :2, 3]).sum(axis=1)
    rows = np.concatenate([rows, seen[:, 1, None]], axis=1) / bend
    return rows, np.sqrt(np.maximum(rest, 0)) / bend


def derivatives(spectrum: Spectrum, x: Array) -> Array:
    """The autocorrelation in these units at `x` (n,), and its first four derivatives, (5, n)."""
    scale = 0.5 ** (np.arange(5) / 2)
    found: Array = spectrum.derivatives(x / np.sqrt(2)) * scale[:, None]
    return found


def farthest(spectrum: Spectrum) -> float:
    """Where the surface has forgotten what it was."""
    x = np.linspace(0, FARTHEST, 600)
    return float(
        x[np.flatnonzero(np.abs(derivatives(spectrum, x)[:3]).max(axis=0) > FORGOTTEN)[-1]]
    )


def look_back(spectrum: Spectrum) -> float:
    """The distance at which the height behind a level ray at the mean height says most: the one
    that makes most of Smith's hazard, by orthant probabilities of three normal numbers."""
    R, R1, _, _, _ = derivatives(spectrum, LAGS)
    # Given a crossing at 0 with slope s: the height behind is below with mean R1 s and variance
    # 1 - R^2 - R1^2; s has Rayleigh's distribution.
    ratio = -R1 / np.sqrt(1 - R * R)
    crossing = (1 + ratio) / 2
    below = 0.5 + np.arcsin(R) / np.pi
    return float(LAGS[np.argmax(crossing / below)])
