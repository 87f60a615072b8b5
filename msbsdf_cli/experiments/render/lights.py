"""Light from all around, in closed form, so that it can be sampled by its very density.

A sky that brightens towards the zenith, and lamps: lobes exp(kappa (cos - 1)) about a direction,
of von Mises and Fisher, wide as a soft box or narrow as the sun.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from surfaces.facet import Array, unit_circle

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Of linear red, green and blue (ITU-R BT.709)."""


@dataclass(frozen=True)
class Lamp:
    """A lobe of light from the unit vector `direction`, of radiance `colour` at its middle."""

    direction: tuple[float, float, float]
    kappa: float
    colour: tuple[float, float, float]

    @property
    def solid_angle(self) -> float:
        """Integral of the lobe over all directions."""
        return float(-2 * np.pi * np.expm1(-2 * self.kappa) / self.kappa)

    def shape(self, w: Array) -> Array:
        """The lobe at directions (3, n), 1 in the middle."""
        return np.exp(self.kappa * (np.array(self.direction) @ w - 1))

    def sample(self, n: int, rng: np.random.Generator) -> Array:
        """Directions (3, n) distributed as the lobe."""
        below = -np.log1p(rng.random(n) * np.expm1(-2 * self.kappa)) / self.kappa
        sin = np.sqrt(below * (2 - below))
        cos_phi, sin_phi = unit_circle(n, rng)
        axis = np.array(self.direction)
        # Any two directions across will do, the lobe being round.
        across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
        across /= np.linalg.norm(across)
        other = np.cross(axis, across)
        return (
            np.outer(axis, 1 - below)
            + np.outer(across, sin * cos_phi)
            + np.outer(other, sin * sin_phi)
        )


@dataclass(frozen=True)
class Lights:
    """Radiance from all around."""

    zenith: tuple[float, float, float] = (1.0, 1.0, 1.0)
    nadir: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Of the sky straight above and straight below, and between them as the cosine goes."""
    lamps: tuple[Lamp, ...] = ()
    squares: float = 0.0
    """How much darker every other square of the sky is, a pattern to look at through glass."""

    def radiance(self, w: Array) -> Array:
        """Red, green and blue (3, n) from directions (3, n)."""
        low, high = np.array(self.nadir)[:, None], np.array(self.zenith)[:, None]
        found = low + (high - low) * ((1 + w[2]) / 2)
        if self.squares:
            found = found * (1 - self.squares * _squares(w))
        for lamp in self.lamps:
            found = found + np.array(lamp.colour)[:, None] * lamp.shape(w)
        return np.asarray(found)

    def sample(self, n: int, rng: np.random.Generator) -> Array:
        """Directions (3, n) of density `pdf`."""
        w = np.empty((3, n))
        which = np.searchsorted(np.cumsum(self._shares), rng.random(n), side="right")
        which = np.minimum(which, len(self.lamps))
        sky = np.flatnonzero(which == 0)
        z = 1 - 2 * rng.random(sky.size)
        cos_phi, sin_phi = unit_circle(sky.size, rng)
        radius = np.sqrt(1 - z * z)
        w[:, sky] = np.stack([radius * cos_phi, radius * sin_phi, z])
        for k, lamp in enumerate(self.lamps, 1):
            mine = np.flatnonzero(which == k)
            w[:, mine] = lamp.sample(mine.size, rng)
        return w

    def pdf(self, w: Array) -> Array:
        """Density (n,) per steradian: that of even light from the whole sky, and of each lamp, in
        the proportion of their powers."""
        sky, *lamps = self._shares.tolist()
        density = np.full(w.shape[1], sky / (4 * np.pi))
        for share, lamp in zip(lamps, self.lamps, strict=True):
            density += share / lamp.solid_angle * lamp.shape(w)
        return density

    @cached_property
    def _shares(self) -> Array:
        sky = 2 * np.pi * LUMINANCE @ (np.array(self.zenith) + self.nadir)
        lamps = [LUMINANCE @ lamp.colour * lamp.solid_angle for lamp in self.lamps]
        power = np.array([sky, *lamps])
        return np.asarray(power / power.sum())


SQUARES = 30
"""Squares of the pattern around the horizon, each half as high as it is wide at the horizon."""


def _squares(w: Array) -> Array:
    """1 in every other square of the pattern, else 0, (n,)."""
    azimuth = np.floor(np.arctan2(w[1], w[0]) * (SQUARES / np.pi))
    height = np.floor(w[2] * SQUARES / 2)
    return np.mod(azimuth + height, 2)
