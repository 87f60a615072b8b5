"""The facet that a ray meets, given the one that it left.

Its slope along the ray has the density (s - c)+ of what faces the ray times a Gaussian, that of the
slope given that the surface is as high as the ray; across the ray it is Gaussian, its correlation
with the last facet's -R'(x) / x. So is its curvature along the ray, given height and slope at both
ends. From outside, and where nothing is remembered, slopes are those of Smith's visible normals,
and curvatures those that heights let one expect, as they are across the ray always.
"""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.memory import march, normal
from msbsdf_cli.memory.correlation import Correlation
from msbsdf_cli.memory.frame import ROOT_HALF, Directions, slopes_along
from msbsdf_cli.memory.hazard import linear
from msbsdf_cli.smith.slopes import Beckmann, Slopes
from surfaces.batch import Batch
from surfaces.facet import Array

UNIT = Beckmann(1.0, 1.0)


@dataclass
class Facets(Batch):
    """The distribution of the facets that rays meet, (n,) or as they broadcast."""

    mean: Array
    """Of the slope along the ray, before it is weighed by what faces the ray."""
    spread: Array
    """Its deviation."""
    k: Array
    """The ray's slope less that mean, over the deviation."""
    across: Array
    """Mean slope across the ray."""
    spread_across: Array
    bend: Array
    """Mean curvature along the ray, in deviations and above what the height lets one expect, of a
    facet that is as steep as the ray."""
    bend_slope: Array
    """How that grows with the slope."""
    spread_bend: Array
    noise: Array
    """Three normal numbers for what curvatures scatter, (3, n)."""

    def column(self) -> "Facets":
        """They as they broadcast against outgoing directions, (n, 1)."""
        return self.each(lambda a: a[..., None])

    def draw(self, rng: np.random.Generator) -> tuple[Array, Array]:
        """Slopes along the rays and across (n,)."""
        other = rng.standard_normal(self.k.size, dtype=self.k.dtype)
        along = self.mean + self.spread * facing(self.k, rng)
        return along, self.across + self.spread_across * other

    def bends(self, correlation: Correlation, steeper: Array) -> Array:
        """Curvatures along the ray, twice mixed, and across (3, ...) of facets whose slopes are
        `steeper` than the ray."""
        along = self.bend + self.bend_slope * steeper + self.spread_bend * self.noise[0]
        return spread_out(correlation, along, self.noise[1:])


def spread_out(correlation: Correlation, along: Array, noise: Array) -> Array:
    """Curvatures (3, ...) along a ray, twice mixed and across, from that along it and two normal
    numbers: those of an isotropic Gaussian surface, given its height."""
    total = correlation.fourth - 1
    shared = np.float32((correlation.fourth / 3 - 1) / total)
    mixed = np.float32(2 * np.sqrt(correlation.fourth / 3 / total))
    across = shared * along + np.sqrt(1 - shared * shared) * noise[1]
    return np.stack(np.broadcast_arrays(along, mixed * noise[0], across))


def visible(ray: Directions, n: int, rng: np.random.Generator) -> Facets:
    """Of rays that remember nothing."""
    zero, one = np.zeros((4, n), ray.c.dtype), np.ones((3, n), ray.c.dtype)
    noise = rng.standard_normal((3, n), dtype=np.float32)
    mean, across, bend, slope = zero
    return Facets(mean, one[0], ray.c * one[0], across, one[1], bend, slope, one[2], noise)


def remembered(
    correlation: Correlation,
    place: Array,
    ray: Directions,
    facet: Array,
    across: Array,
    rng: np.random.Generator,
) -> Facets:
    """Of rays that left a facet of the four numbers `facet` (4, n), whose slope across was
    `across`, and met the surface at the lattice's `place`."""
    found = visible(ray, place.size, rng)
    near = np.flatnonzero(place != march.NOWHERE)
    i, facet = place.take(near), facet.take(near, axis=1)
    spread = correlation.slope.take(i)
    k = linear(correlation.distances[1], i, facet)
    found.k[near], found.spread[near], found.mean[near] = k, spread, ray.c.take(near) - spread * k
    rho = correlation.across.take(i)
    found.across[near] = rho * across.take(near)
    found.spread_across[near] = np.sqrt(1 - rho * rho)
    found.bend[near] = linear(correlation.curvature[:4], i, facet)
    found.bend_slope[near] = correlation.curvature[4].take(i)
    found.spread_bend[near] = correlation.rest.take(i)
    return found


def facing(k: Array, rng: np.random.Generator) -> Array:
    """Numbers y of density proportional to (y - k)+ times the normal one, for `k` (n,).

    As in `smith.slopes.Mirrored`: for k < 0 the density at y and at -y sums to -2k where |y| < -k,
    and else to -2k and (|y| + k), which is what a ray from the other side would see.
    """
    r = np.abs(rng.standard_normal(k.size, dtype=k.dtype))
    toward = np.maximum(-k, 0)
    y = np.where(rng.random(k.size, dtype=k.dtype) * 2 * toward < toward + r, r, -r)
    share = rng.random(k.size, dtype=k.dtype) * (toward + normal.excess(np.abs(k)))
    other = np.flatnonzero(share >= toward)
    offset = np.abs(k.take(other)) * k.dtype.type(ROOT_HALF)
    y[other] = UNIT.beyond(offset, rng) * k.dtype.type(1 / ROOT_HALF)
    return y


@dataclass(frozen=True)
class Conditional:
    """The normals that rays may meet, as a distribution for each of them: what a material's
    scattering kernel asks for."""

    slopes: Slopes
    ray: Directions
    facets: Facets

    @property
    def alpha_x(self) -> float:
        return self.slopes.alpha_x

    @property
    def alpha_y(self) -> float:
        return self.slopes.alpha_y

    def D(self, m: Array) -> Array:
        """Per steradian; of a vector of any other length over that to the fourth power."""
        f = self.facets
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            along, across = slopes_along(self.slopes, self.ray, m)
            y = (along - f.mean) / f.spread
            z = (across - f.across) / f.spread_across
            root = np.exp((y * y + z * z) * -0.125) / m[2]
            square = root * root
            area = f.spread * f.spread_across * (np.pi * self.alpha_x * self.alpha_y)
            return np.where(m[2] > 0, square * square / area, 0)

    @property
    def sigma(self) -> Array:
        """Projected area of these facets."""
        f = self.facets
        total: Array = self.ray.run * f.spread * normal.excess(f.k)
        return total
