"""Quadrature for one hemisphere: elevations, azimuths and how to interpolate between them.

Elevations psi are measured from the mean plane, not from its normal, so that no digit is lost at
grazing angles; a direction of travel and its image in the mean plane share one.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.special import eval_legendre, spherical_jn

from surfaces.facet import Array
from surfaces.quadrature import gauss

CROWDING = 2
"""Elevations are psi = pi/2 x^2 with x a Gauss-Legendre node: what scatters between grazing
directions depends on the ratio of their elevations, so that the nodes must crowd there."""

AZIMUTH_CROWDING = 3
"""Azimuths are phi = pi x^3: the kernel peaks at phi = 0 with a width as small as the difference
of the elevations, and every scale of that is resolved alike."""

DENSE = 16
"""Modes up to which all are taken, and for each doubling of the number beyond, or nearly; with it,
values of mirrors of roughness .05 to 1 differ by at most 3e-7 of the largest from all modes'."""

PEAK = 96
"""Azimuths for the kernel itself, beside those that its modes need."""

NARROWEST = 2.0**-20
"""Azimuths below which, in parts of half the circle, kernels do not change any more."""
PANEL = 12
"""Gauss nodes in azimuth for each doubling of it."""


@dataclass(frozen=True)
class Angles:
    """Elevations of any shape with the weights of an integral over them."""

    x: Array
    cos: Array
    """|cos theta| = sin psi."""
    sin: Array
    weight: Array
    """sin(theta) d(theta): times an azimuth, a solid angle."""


def angles(x: Array, dx: Array) -> Angles:
    """Elevations psi = pi/2 x^CROWDING."""
    psi = np.pi / 2 * x**CROWDING
    slope = np.pi / 2 * CROWDING * x ** (CROWDING - 1)
    return Angles(x, np.sin(psi), np.cos(psi), np.cos(psi) * slope * dx)


def abscissa(psi: Array) -> Array:
    """x of elevations."""
    x: Array = (psi / (np.pi / 2)) ** (1 / CROWDING)
    return x


def coordinate(sin: Array, cos: Array) -> Array:
    """x of directions: exact towards the horizon and towards the normal."""
    return abscissa(np.arctan2(cos, sin))


@dataclass(frozen=True)
class Elevations:
    """`n` elevations between the horizon and the normal, and interpolation between them."""

    n: int

    @cached_property
    def nodes(self) -> Angles:
        """The nodes, shape (n,)."""
        return angles(*gauss(self.n))

    def between(self, low: Array, high: Array) -> Angles:
        """Nodes between `low` and `high` (m,) in x, shape (m, n).

        A mirror never lowers a direction: seen from elevation x, the kernel between downward
        directions is smooth up to x and zero beyond, so that an integral that ends there
        converges as fast as any other, jump or not.
        """
        x, dx = gauss(self.n)
        width = (high - low)[:, None]
        return angles(low[:, None] + width * x, width * dx)

    def interpolation(self, x: Array) -> Array:
        """Matrices (..., n) from values at the nodes to values at x (...)."""
        return interpolation(self.n, x)


@dataclass(frozen=True)
class SplitElevations:
    """Elevations below and above an abscissa where functions of them are not smooth."""

    below: int
    above: int
    split: float

    @property
    def n(self) -> int:
        """Number of nodes."""
        return self.below + self.above

    @cached_property
    def nodes(self) -> Angles:
        """The nodes, shape (n,)."""
        (low, d_low), (high, d_high) = gauss(self.below), gauss(self.above)
        rest = 1 - self.split
        x = np.concatenate([self.split * low, self.split + rest * high])
        return angles(x, np.concatenate([self.split * d_low, rest * d_high]))

    def interpolation(self, x: Array) -> Array:
        """Matrices (..., n) from values at the nodes to values at x (...)."""
        matrix = np.zeros((*x.shape, self.n))
        low = x < self.split
        matrix[low, : self.below] = interpolation(self.below, x[low] / self.split)
        high = (x[~low] - self.split) / (1 - self.split)
        matrix[~low, self.below :] = interpolation(self.above, high)
        return matrix


def interpolation(n: int, x: Array) -> Array:
    """Matrices (..., n) from values at `n` Gauss nodes on [0, 1] to values at x (...), by the
    barycentric formula (Wang & Xiang 2012)."""
    nodes, weight = gauss(n)
    factor = np.sqrt(nodes * (1 - nodes) * weight)
    factor[1::2] *= -1
    matrix: Array = x[..., None] - nodes
    # At a node the formula is 0 / 0; a tiny distance gives its limit, the value there.
    matrix[matrix == 0] = np.finfo(float).tiny ** 0.5
    np.divide(factor, matrix, out=matrix)
    matrix /= matrix.sum(-1, keepdims=True)
    return matrix


@dataclass(frozen=True)
class QuarterAzimuths:
    """`n` azimuths between the axes x and y, none of them on an axis, for functions that are even
    or odd about both: images of evenly spaced ones under a smooth map of the circle."""

    n: int
    crowding: float
    """Spacing at both axes over that midway between them, or rather its root: the slope of
    tan(2 azimuth)."""
    squeeze: float
    """Further factor of tan(azimuth): above 1 it moves nodes towards y."""

    @cached_property
    def even(self) -> Array:
        """Evenly spaced (n,), before they are moved."""
        return (np.arange(self.n) + 0.5) * np.pi / (2 * self.n)

    @cached_property
    def nodes(self) -> Array:
        """The azimuths (n,)."""
        return np.arctan2(self.squeeze * np.sin(self._crowded), np.cos(self._crowded))

    @cached_property
    def _crowded(self) -> Array:
        return np.arctan2(self.crowding * np.sin(2 * self.even), np.cos(2 * self.even)) / 2

    @cached_property
    def arc(self) -> Array:
        """Azimuth (n,) that a node and its three mirror images stand for."""
        slope = _slope(self.crowding, 2 * self.even) * _slope(self.squeeze, self._crowded)
        return 2 * np.pi / self.n * slope

    @property
    def narrowest(self) -> float:
        """The least spacing of nodes over an even one."""
        return self.crowding * min(self.squeeze, 1 / self.squeeze)

    def relax(self, turns: Array) -> Array:
        """Move azimuths, as exp(i phi) (...), by the inverse of the map."""
        turns = _unit(self.squeeze * turns.real + 1j * turns.imag)
        double = turns * turns
        moved = _unit(self.crowding * double.real + 1j * double.imag)
        # It moves none by more than half the way to an axis, where the root has its branch.
        relaxed: Array = turns * np.sqrt(moved * double.conj())
        return relaxed


def _slope(factor: float, angle: Array) -> Array:
    """d(image) / d(angle) of tan(image) = factor tan(angle)."""
    slope: Array = factor / (np.cos(angle) ** 2 + (factor * np.sin(angle)) ** 2)
    return slope


def _unit(z: Array) -> Array:
    unit: Array = z / np.abs(z)
    return unit


def azimuths(modes: int) -> tuple[Array, Array]:
    """Azimuths on (0, pi) and weights that integrate cos(m phi), m < modes, against a kernel that
    is peaked at 0 on any scale.

    The widest gap, near pi, is 2.4 times the mean one, and Gauss nodes want more than two for
    each half period; PEAK nodes are added for the kernel itself.
    """
    x, weight = gauss(5 * modes // 2 + PEAK)
    phi = np.pi * x**AZIMUTH_CROWDING
    return phi, np.pi * AZIMUTH_CROWDING * x ** (AZIMUTH_CROWDING - 1) * weight


def cosine_integrals(modes: Array) -> tuple[Array, Array]:
    """Azimuths (p,) on (0, pi) and factors (p, k): the integrals of cos(m phi) for the mode numbers
    `modes` (k,), against a kernel that is peaked at 0 on any scale.

    How many azimuths depends on the kernel alone, and not on how fast the cosine oscillates: on
    panels that double in width from 0 on, the kernel is taken for a polynomial, and the integrals
    of its Legendre parts times the cosine are spherical Bessel functions (Filon's method).
    """
    ends = np.pi * np.append(0, 2.0 ** np.arange(np.log2(NARROWEST), 1))
    centre, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    x, weight = gauss(PANEL)
    t = 2 * x - 1
    phi = centre[:, None] + half[:, None] * t
    degree = np.arange(PANEL)
    expansion = (2 * degree + 1) * eval_legendre(degree, t[:, None]) * weight[:, None]
    bessel = spherical_jn(degree[:, None], np.multiply.outer(half, modes)[:, None])
    turned = np.exp(1j * np.multiply.outer(centre, modes))[:, None] * 1j ** degree[:, None]
    factors = 2 * half[:, None, None] * (expansion @ (turned.real * bessel))
    return phi.ravel(), factors.reshape(phi.size, -1)


def sparse_modes(modes: int, dense: int) -> tuple[Array, Array]:
    """Numbers (k,) of the modes that stand for all of them, and the matrix (modes, k) of values
    between these.

    A lobe that is narrow in azimuth has modes that change slowly with their number, the more
    slowly the higher they are: of those from DENSE on, one for each DENSE-th part of the number is
    enough for splines of the fifth degree. The kernel of mirrors has no edge in azimuth, which
    would make its modes swing.
    """
    numbers = [0]
    while numbers[-1] < modes - 1:
        numbers.append(min(numbers[-1] + max(numbers[-1] // dense, 1), modes - 1))
    if len(numbers) == modes:
        return np.array(numbers), np.eye(modes)
    spline = make_interp_spline(numbers, np.eye(len(numbers)), 5)
    return np.array(numbers), spline(np.arange(modes))
