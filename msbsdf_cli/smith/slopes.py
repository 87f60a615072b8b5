"""Slope distributions: projected areas, densities and exact samplers of visible normals.

Everything is written for the whole sphere of directions and has no threshold: the projected area
sigma(d) of the facets that face a direction of travel `d` stands in for Lambda and for the
normalisation of visible normals at once ([HHdD16] Eqs. 21 and 22).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import erfc

from surfaces.facet import Array, unit_circle

SQRT_PI = float(np.sqrt(np.pi))


class Slopes(Protocol):
    """A distribution of slopes with roughness `alpha_x`, `alpha_y`."""

    @property
    def alpha_x(self) -> float:
        """Roughness along x."""

    @property
    def alpha_y(self) -> float:
        """Roughness along y."""

    def D(self, m: Array) -> Array:
        """Distribution of normals over unit vectors (3, ...), per steradian; of a vector of any
        other length that of its direction over the length to the fourth power."""

    def sigma(self, d: Array) -> Array:
        """Area of the facets, projected on the plane normal to `d`, that face against the unit
        direction of travel `d` (3, n), per unit of mean-plane area.

        For d upward it is Lambda(d) cos(theta_d), for d downward (1 + Lambda(-d)) cos(theta_-d).
        """

    def visible_normals(self, wi: Array, n: int, rng: np.random.Generator) -> Array:
        """Normals (3, n), not normalised, distributed as <wi, m> D(m) / sigma(-wi).

        `wi` is a unit vector for each lane (3, n), or one for all (3, 1), anywhere on the sphere.
        """


def Lambda(slopes: Slopes, w: Array) -> Array:
    """The Smith function Lambda over the whole sphere; -1 - Lambda(-w) below the horizon."""
    return slopes.sigma(w) / w[2]


@dataclass(frozen=True)
class Beckmann:
    """Gaussian slopes, of variance alpha^2 / 2 along each axis."""

    alpha_x: float
    alpha_y: float

    def D(self, m: Array) -> Array:
        cos2 = m[2] * m[2]
        slope2 = ((m[0] / self.alpha_x) ** 2 + (m[1] / self.alpha_y) ** 2) / cos2
        density = np.exp(-slope2) / (np.pi * self.alpha_x * self.alpha_y * cos2 * cos2)
        return np.where(m[2] > 0, density, 0)

    def sigma(self, d: Array) -> Array:
        return _beckmann_sigma(*_stretch(self, d))

    def visible_normals(self, wi: Array, n: int, rng: np.random.Generator) -> Array:
        """Exact, by mirroring slopes rather than by inverting their distribution function.

        Along the stretched direction (s, z) the slope has density (z - s x)+ exp(-x^2). The
        densities at x and -x sum to 2z where s|x| < z and to z + s|x| beyond, so that
        a Gaussian slope, its sign chosen by its share, serves the part 2z; the rest,
        (s r - z)+ exp(-r^2) at x = -r, is what a ray from the other side would see.
        """
        dtype = wi.dtype.type
        s, z, a = _stretch(self, wi)
        cos_phi, sin_phi = unit_circle(n, rng, dtype)
        radius = np.sqrt(-np.log(1 - rng.random(n, dtype=dtype)))
        r = np.abs(radius * cos_phi)
        y = radius * sin_phi

        upper = np.maximum(z, 0)
        share = 2 * (upper + _beckmann_sigma(s, np.abs(z), np.abs(a)))
        share = share * rng.random(n, dtype=dtype)
        x = np.where(share < z - s * r, r, -r)
        from_below = np.flatnonzero(share >= 2 * upper)
        if from_below.size:
            offset = np.broadcast_to(np.abs(a), (n,)).take(from_below)
            x[from_below] = -_sample_beyond(offset, rng)

        # Slopes turn back from the stretched direction's azimuth; at the zenith any will do.
        scale = np.divide(1, s, out=np.zeros_like(s), where=s > 0)
        along_x = np.where(s > 0, self.alpha_x * wi[0] * scale, 1)
        along_y = self.alpha_y * wi[1] * scale
        m = np.empty((3, n), dtype)
        m[0] = -self.alpha_x * (along_x * x - along_y * y)
        m[1] = -self.alpha_y * (along_y * x + along_x * y)
        m[2] = 1
        return m


@dataclass(frozen=True)
class Ggx:
    """The distribution of Trowbridge and Reitz: normals of a stretched ellipsoid."""

    alpha_x: float
    alpha_y: float

    def D(self, m: Array) -> Array:
        length2 = (m[0] / self.alpha_x) ** 2 + (m[1] / self.alpha_y) ** 2 + m[2] * m[2]
        density = 1 / (np.pi * self.alpha_x * self.alpha_y * length2 * length2)
        return np.where(m[2] > 0, density, 0)

    def sigma(self, d: Array) -> Array:
        x, y, z = self.alpha_x * d[0], self.alpha_y * d[1], d[2]
        s2 = x * x + y * y
        sum_ = np.sqrt(s2 + z * z) + np.abs(z)
        # sqrt(s^2 + z^2) - z, without cancellation where z > 0.
        return np.where(z > 0, s2 / sum_, sum_) / 2

    def visible_normals(self, wi: Array, n: int, rng: np.random.Generator) -> Array:
        """By spherical caps (Dupuy & Benyoub 2023): on the stretched sphere the visible normal is
        the half vector of `wi` and a direction uniform on the cap z > -wi_z.

        All is measured from the pole opposite to `wi`, by 1 + wi_z = s^2 / (1 - wi_z), so that no
        digit is lost towards it.
        """
        dtype = wi.dtype.type
        x, y, z = self.alpha_x * wi[0], self.alpha_y * wi[1], wi[2]
        s2 = x * x + y * y
        length = np.sqrt(s2 + z * z)
        x, y = x / length, y / length
        cap = np.where(z > 0, (length + z) / length, s2 / (length * (length + np.abs(z))))
        u = rng.random(n, dtype=dtype)
        below = u * cap
        sin_theta = np.sqrt(below * (2 - below))
        cos_phi, sin_phi = unit_circle(n, rng, dtype)
        m = np.empty((3, n), dtype)
        m[0] = self.alpha_x * (x + sin_theta * cos_phi)
        m[1] = self.alpha_y * (y + sin_theta * sin_phi)
        m[2] = cap - below
        return m


SLOPES: dict[str, type[Beckmann] | type[Ggx]] = {"beckmann": Beckmann, "ggx": Ggx}


def _stretch(slopes: Beckmann, w: Array) -> tuple[Array, Array, Array]:
    """Horizontal and vertical part of a direction over unit roughness, and their ratio."""
    x, y, z = slopes.alpha_x * w[0], slopes.alpha_y * w[1], w[2]
    s = np.sqrt(x * x + y * y)
    with np.errstate(divide="ignore"):
        return s, z, z / s


def _beckmann_sigma(s: Array, z: Array, a: Array) -> Array:
    """Projected area of Gaussian slopes towards (s, z), a = z / s (`z * erfc` and not `s * a *
    erfc`, so that the vertical s = 0 is no special case)."""
    return (s * np.exp(-a * a) / SQRT_PI - z * erfc(a)) / 2


def _sample_beyond(a: Array, rng: np.random.Generator) -> Array:
    """Samples r > a >= 0 of density proportional to (r - a) exp(-r^2).

    Rejection from a gamma density: with y = r - a, exp(-y^2) <= exp(k^2 - 2 k y), and
    k (a + k) = 1 makes the loss smallest: at least 2 / e of the proposals are accepted, for any a.
    """
    r = np.empty_like(a)
    lanes = np.arange(a.size)
    dtype = a.dtype.type
    while lanes.size:
        k = (np.sqrt(a * a + 4) - a) / 2
        u = rng.random((3, lanes.size), dtype=dtype)
        y = -np.log((1 - u[0]) * (1 - u[1])) / (2 * (a + k))
        accepted = u[2] < np.exp(-((y - k) ** 2))
        r[lanes.compress(accepted)] = (a + y).compress(accepted)
        rejected = ~accepted
        lanes, a = lanes.compress(rejected), a.compress(rejected)
    return r
