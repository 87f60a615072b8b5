"""What a slope distribution is, and what follows from its projected area alone.

Everything is written for the whole sphere of directions and has no threshold: the projected area
sigma(d) of the facets that face a direction of travel `d` stands in for Lambda and for the
normalisation of visible normals at once ([HHdD16] Eqs. 21 and 22).
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from surfaces.facet import Array, unit_circle


@dataclass(frozen=True)
class Slopes(ABC):
    """A distribution of slopes with roughness `alpha_x`, `alpha_y`, above 0 and finite.

    Raises ValueError for a roughness that is not. Under a texture a roughness is an array (n,), one
    number for each lane of light (`of_lanes`, `at`).
    """

    alpha_x: float
    alpha_y: float

    def __post_init__(self) -> None:
        for name in ("alpha_x", "alpha_y"):
            alpha = np.asarray(getattr(self, name))
            if alpha.dtype.kind not in "fiu" or not np.all((alpha > 0) & (alpha < np.inf)):
                raise ValueError(f"{name} is {alpha}: a roughness is a finite number above 0.")

    @property
    def name(self) -> str:
        """As on the command line: that of the file."""
        return type(self).__module__.rpartition(".")[2].replace("_", "-")

    @property
    def alpha(self) -> tuple[float, float]:
        """Roughness along x and y."""
        return self.alpha_x, self.alpha_y

    @property
    def isotropic(self) -> bool:
        """Whether slopes are alike in every direction."""
        return self.alpha_x == self.alpha_y

    @property
    def textured(self) -> bool:
        """Whether each lane has a roughness of its own."""
        return np.ndim(self.alpha_x) > 0

    def of_lanes(self, alpha_x: Array, alpha_y: Array) -> Self:
        """The same distribution with roughnesses (n,) of n lanes."""
        lanes: dict[str, Any] = {"alpha_x": alpha_x, "alpha_y": alpha_y}
        return replace(self, **lanes)

    def at(self, lanes: Array | None) -> Self:
        """The slopes that some of the lanes meet: the same for all of them without a texture."""
        if not self.textured or lanes is None:
            return self
        x, y = np.asarray(self.alpha_x), np.asarray(self.alpha_y)
        return self.of_lanes(x.take(lanes), y.take(lanes))

    @abstractmethod
    def D(self, m: Array) -> Array:
        """Distribution of normals over unit vectors (3, ...), per steradian; of a vector of any
        other length that of its direction over the length to the fourth power."""

    @abstractmethod
    def sigma(self, d: Array) -> Array:
        """Area of the facets, projected on the plane normal to `d`, that face against the unit
        direction of travel `d` (3, n), per unit of mean-plane area.

        For d upward it is Lambda(d) cos(theta_d), for d downward (1 + Lambda(-d)) cos(theta_-d).
        """

    @abstractmethod
    def visible_normals(self, wi: Array, n: int, rng: np.random.Generator) -> Array:
        """Normals (3, n), not normalised, distributed as <wi, m> D(m) / sigma(-wi).

        `wi` is a unit vector for each lane (3, n), or one for all (3, 1), anywhere on the sphere.
        """

    @abstractmethod
    def slope_density(self, x: Array, y: Array) -> Array:
        """The textbook's density of slopes, each over its roughness: what `validate` integrates
        to check all else against."""

    @abstractmethod
    def marginal_density(self, x: Array) -> Array:
        """The same of one slope, the other integrated out."""


def Lambda(slopes: Slopes, w: Array) -> Array:
    """The Smith function Lambda over the whole sphere; -1 - Lambda(-w) below the horizon."""
    return slopes.sigma(w) / w[2]


def stretched(slopes: Slopes, w: Array) -> tuple[Array, Array, Array]:
    """Horizontal and vertical part of directions (3, n) over unit roughness, and the vertical over
    the horizontal one, infinite at the poles."""
    x, y, z = slopes.alpha_x * w[0], slopes.alpha_y * w[1], w[2]
    s = np.sqrt(x * x + y * y)
    with np.errstate(divide="ignore"):
        return s, z, z / s


class Mirrored(Slopes):
    """Base of distributions whose slopes, each over its roughness, have a density that depends on
    their distance from the origin only: exact visible normals by mirroring slopes.

    Along the stretched direction (s, z) the visible slope has density (z - s x)+ p(x), p that of
    one slope. The densities at x and -x sum to 2z where s|x| < z and to z + s|x| beyond, so that a
    slope of p, its sign chosen by its share, serves the part 2z; the rest, (s r - z)+ p(r) at
    x = -r, is what a ray from the other side would see.
    """

    @abstractmethod
    def radius2(self, u: Array) -> Array:
        """Squared radii (n,) of slopes, from uniform numbers."""

    @abstractmethod
    def area(self, s: Array, z: Array, a: Array) -> Array:
        """Integral of (s x - z)+ p(x) over x, for s >= 0 and a = z / s."""

    @abstractmethod
    def beyond(self, a: Array, rng: np.random.Generator) -> Array:
        """Samples r > a >= 0 of density proportional to (r - a) p(r), (n,)."""

    @abstractmethod
    def across(self, x: Array, y: Array, rng: np.random.Generator) -> Array:
        """The slope across one of x (n,); `y` (n,) belongs to another slope along."""

    def sigma(self, d: Array) -> Array:
        return self._seen(*stretched(self, d))

    def _seen(self, s: Array, z: Array, a: Array) -> Array:
        """`area`; next to a pole the square of `a` overflows to infinity, which is right there."""
        with np.errstate(over="ignore"):
            return self.area(s, z, a)

    def visible_normals(self, wi: Array, n: int, rng: np.random.Generator) -> Array:
        dtype = wi.dtype.type
        s, z, a = stretched(self, wi)
        cos_phi, sin_phi = unit_circle(n, rng, dtype)
        radius = np.sqrt(self.radius2(rng.random(n, dtype=dtype)))
        r = np.abs(radius * cos_phi)
        y = radius * sin_phi

        upper = np.maximum(z, 0)
        share = 2 * (upper + self._seen(s, np.abs(z), np.abs(a)))
        share = share * rng.random(n, dtype=dtype)
        x = np.where(share < z - s * r, r, -r)
        from_below = np.flatnonzero(share >= 2 * upper)
        if from_below.size:
            offset = np.broadcast_to(np.abs(a), (n,)).take(from_below)
            x[from_below] = -self.beyond(offset, rng)
            y[from_below] = self.across(x[from_below], y[from_below], rng)

        # Slopes turn back from the stretched direction's azimuth; at the zenith any will do.
        scale = np.divide(1, s, out=np.zeros_like(s), where=s > 0)
        along_x = np.where(s > 0, self.alpha_x * wi[0] * scale, 1)
        along_y = self.alpha_y * wi[1] * scale
        m = np.empty((3, n), dtype)
        m[0] = -self.alpha_x * (along_x * x - along_y * y)
        m[1] = -self.alpha_y * (along_y * x + along_x * y)
        m[2] = 1
        return m
