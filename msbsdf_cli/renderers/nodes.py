"""Nodes of a table of a BSDF, and where directions lie between them."""

from dataclasses import dataclass

import numpy as np

from surfaces.facet import Array

ELEVATION_CROWDING = 2
"""Elevations over the mean plane are pi/2 (1 - x)^2, so that nodes, even in x, crowd towards the
horizon, where a BSDF depends on the ratio of two."""

AZIMUTH_CROWDING = 0.5
"""Of one roughness: azimuths between the directions have (phi + crowding sin(2 phi) / 2) / pi even
in [0, 1]. Towards grazing angles light is bright next to the plane of incidence, and nodes lie
three times as dense there as half way."""


@dataclass(frozen=True)
class Nodes:
    """Nodes in the elevations of either direction, in the azimuth between the two and in that of
    the incident direction."""

    elevations: int
    azimuths: int
    """Between the directions: in [0, pi] with both ends, or, of two roughnesses, in [0, 2 pi)."""
    incident: int = 1
    """Azimuths of the incident direction, in [0, pi/2] with both ends; 1 of one roughness."""

    @property
    def steepest(self) -> float:
        """x of the last elevation: half an interval above the horizon, at which there is no BSDF.
        Directions below have the values of this one."""
        return (self.elevations - 1) / (self.elevations - 0.5)

    @property
    def theta(self) -> Array:
        """Polar angles (elevations,)."""
        x = np.arange(self.elevations) / (self.elevations - 0.5)
        return np.pi / 2 * (1 - (1 - x) ** ELEVATION_CROWDING)

    @property
    def phi(self) -> Array:
        """Azimuths (azimuths,) from the incident direction to the outgoing one."""
        if self.incident > 1:
            return 2 * np.pi / self.azimuths * np.arange(self.azimuths)
        fine = np.linspace(0, np.pi, 20_001)
        return np.interp(np.linspace(0, 1, self.azimuths), between(fine), fine)

    @property
    def phi_i(self) -> Array:
        """Azimuths (incident,) of the incident direction."""
        return np.linspace(0, np.pi / 2, self.incident) if self.incident > 1 else np.zeros(1)

    def places(self, wi: Array, wo: Array) -> tuple[Array, Array, Array, Array]:
        """In nodes: azimuth of incidence, both elevations and azimuth in between, (n,) each, of
        unit vectors (3, n), z >= 0."""
        if self.incident > 1:
            # Mirror images in both planes of symmetry have the same BSDF.
            mirror = np.where(wi < 0, -1, 1) * np.array([[1], [1], [0]]) + [[0], [0], [1]]
            wi, wo = wi * mirror, wo * mirror
        across, along = wi[0] * wo[1] - wi[1] * wo[0], wi[0] * wo[0] + wi[1] * wo[1]
        phi = np.arctan2(across, along)
        if self.incident == 1:
            place = between(np.abs(phi)) * (self.azimuths - 1)
            return 0 * phi, self._elevation(wi), self._elevation(wo), place
        place = np.mod(phi / (2 * np.pi), 1) * self.azimuths
        turned = np.arctan2(wi[1], wi[0]) / (np.pi / 2) * (self.incident - 1)
        return turned + 0 * phi, self._elevation(wi) + 0 * phi, self._elevation(wo), place

    def _elevation(self, w: Array) -> Array:
        psi = np.arctan2(w[2], np.hypot(w[0], w[1]))
        x = 1 - np.sqrt(psi / (np.pi / 2))
        return np.asarray(np.minimum(x, self.steepest) * (self.elevations - 0.5))


def between(phi: Array) -> Array:
    """Azimuths in [0, pi] on the scale on which nodes are even, from 0 to 1."""
    return (phi + AZIMUTH_CROWDING / 2 * np.sin(2 * phi)) / np.pi
