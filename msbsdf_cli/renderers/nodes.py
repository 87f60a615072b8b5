"""Nodes of a table of a BSDF, and where directions lie between them."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from msbsdf_cli.renderers.splines import MARGIN
from surfaces.facet import Array

ELEVATION_CROWDING = 2
"""Elevations over the mean plane are pi/2 (1 - x)^2, so that nodes, even in x, crowd towards the
horizon, where a BSDF depends on the ratio of two."""

AZIMUTH_CROWDING = 0.5
"""Of one roughness: azimuths between the directions have (phi + crowding sin(2 phi) / 2) / pi even
in [0, 1]. Towards grazing angles light is bright next to the plane of incidence, and nodes of
opaque surfaces lie three times as dense there as half way; those of glass are even, since it is
half way that total reflection begins between grazing directions inside."""

TINY = 1e-30
"""In place of an angle of 0, by which nothing but 0 is divided."""


@dataclass(frozen=True)
class Nodes:
    """Nodes in the elevations of either direction, in the azimuth between the two and in that of
    the incident direction."""

    elevations: int
    azimuths: int
    """Between the directions: in [0, pi] with both ends, or, of two roughnesses, in [0, 2 pi)."""
    incident: int = 1
    """Azimuths of the incident direction, in [0, pi/2] with both ends; 1 of one roughness."""
    before: int = 0
    """Elevations of those nearer to the normal than `split`, which both parts have; else 0."""
    split: float = 0.0
    """A polar angle at which a BSDF is not smooth. Nodes before it are evenly spaced; elevations
    over the mean plane beyond it are (1 - x^2)^2 of the highest, and crowd at both ends."""
    crowding: float = AZIMUTH_CROWDING
    dense_inside: bool = True
    """Whether the higher index is inside."""

    @classmethod
    def of_glass(cls, ior: float, before: int, after: int, azimuths: int) -> Self:
        """Split where a direction is as far from the mean plane as the critical angle is from the
        normal: what steep facets show of total reflection ends there."""
        split = float(np.arccos(min(ior, 1 / ior)))
        return cls(before + after, azimuths, 1, before, split, 0.0, bool(ior > 1))

    @property
    def steepest(self) -> float:
        """x of the last elevation: half an interval above the horizon, at which there is no BSDF.
        Directions below have the values of this one."""
        after = self.elevations - self.before
        return (after - 1) / (after - 0.5)

    @property
    def theta(self) -> Array:
        """Polar angles (elevations,)."""
        after = self.elevations - self.before
        x = np.arange(after) / (after - 0.5)
        if not self.before:
            return np.pi / 2 * (1 - (1 - x) ** ELEVATION_CROWDING)
        return self._split_at(np.pi / 2 - self.split)

    def thin_theta(self, k: int) -> Array:
        """Polar angles (elevations,) in the medium of lower index, of light that is transmitted to
        or from elevation `k` in that of higher index."""
        sin = np.array(np.sin(np.pi / 2 - self.theta[k]))
        # The first elevation beyond the split is as far from the normal as the last before it.
        return self._split_at(float(self._thin_low(sin, np.array(k >= self.before))))

    def _split_at(self, low: float) -> Array:
        after = self.elevations - self.before
        x = np.arange(after) / (after - 0.5)
        near = np.linspace(0, np.pi / 2 - low, self.before)
        return np.append(near, np.pi / 2 - low * (1 - x * x) ** 2)

    def _thin_low(self, cos: Array, beyond: Array) -> Array:
        """Elevation over the mean plane at which transmission has a corner, in the medium of lower
        index, of directions in the other with these cosines, of which some are `beyond` the split:
        where none but facets that stand upright connect the two. GGX slopes have such facets, and
        the first order jumps to 0 there."""
        low = np.arcsin(np.minimum(cos / np.cos(self.split), 1))
        return np.where(beyond, low, np.pi / 2 - self.split)

    @property
    def phi(self) -> Array:
        """Azimuths (azimuths,) from the incident direction to the outgoing one."""
        if self.incident > 1:
            return 2 * np.pi / self.azimuths * np.arange(self.azimuths)
        fine = np.linspace(0, np.pi, 20_001)
        return np.interp(np.linspace(0, 1, self.azimuths), self.between(fine), fine)

    @property
    def phi_i(self) -> Array:
        """Azimuths (incident,) of the incident direction."""
        return np.linspace(0, np.pi / 2, self.incident) if self.incident > 1 else np.zeros(1)

    def places(
        self, wi: Array, wo: Array, crosses: Array | bool = False
    ) -> tuple[Array, Array, Array, Array]:
        """In nodes, or rather coefficients, of which there are `MARGIN` more at either end of each
        part: azimuth of incidence, both elevations and azimuth in between, (n,) each, of unit
        vectors (3, n), z >= 0; `wi` is outside where light `crosses`."""
        if self.incident > 1:
            # Mirror images in both planes of symmetry have the same BSDF.
            mirror = np.where(wi < 0, -1, 1) * np.array([[1], [1], [0]]) + [[0], [0], [1]]
            wi, wo = wi * mirror, wo * mirror
        across, along = wi[0] * wo[1] - wi[1] * wo[0], wi[0] * wo[0] + wi[1] * wo[1]
        phi = np.arctan2(across, along)
        if self.incident == 1:
            place = self.between(np.abs(phi)) * (self.azimuths - 1)
            if not self.before:
                return 0 * phi, self._elevation(wi), self._elevation(wo), place
            low = np.asarray(np.pi / 2 - self.split)
            dense = wo if self.dense_inside else wi
            beyond = np.arctan2(dense[2], np.hypot(dense[0], dense[1])) < low
            thin_low = np.where(crosses, self._thin_low(dense[2], beyond), low)
            lows = (thin_low, low) if self.dense_inside else (low, thin_low)
            into, out = (self._parted(w, of) for w, of in zip((wi, wo), lows, strict=True))
            return 0 * phi, into, out, place
        place = np.mod(phi / (2 * np.pi), 1) * self.azimuths
        turned = np.arctan2(wi[1], wi[0]) / (np.pi / 2) * (self.incident - 1)
        return turned + 0 * phi, self._elevation(wi) + 0 * phi, self._elevation(wo), place

    def _elevation(self, w: Array) -> Array:
        psi = np.arctan2(w[2], np.hypot(w[0], w[1]))
        x = 1 - np.sqrt(psi / (np.pi / 2))
        return np.asarray(np.minimum(x, self.steepest) * (self.elevations - 0.5))

    def _parted(self, w: Array, low: Array) -> Array:
        """Of elevations in two parts that meet at `low`."""
        psi = np.arctan2(w[2], np.hypot(w[0], w[1]))
        after = self.elevations - self.before
        x = np.sqrt(1 - np.sqrt(np.minimum(psi / np.maximum(low, TINY), 1)))
        beyond = np.minimum(x, self.steepest) * (after - 0.5) + self.before + 2 * MARGIN
        part = (psi - low) / np.maximum(np.pi / 2 - low, TINY)
        return np.where(psi < low, beyond, (1 - part) * (self.before - 1))

    def between(self, phi: Array) -> Array:
        """Azimuths in [0, pi] on the scale on which nodes of one roughness are even, 0 to 1."""
        return (phi + self.crowding / 2 * np.sin(2 * phi)) / np.pi
