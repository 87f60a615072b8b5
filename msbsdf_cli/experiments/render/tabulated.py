"""Tables in place of methods that do not take pairs of directions one by one.

A table holds what is to be added to single scattering, whose lobe may be as narrow as it likes: the
later orders of `solve`, or what light traced on explicit surfaces does otherwise than the closed
form. That of surfaces is linear between nodes in roughness, polar angles and azimuth; a surface of
roughness 0 is smooth, and nothing is to be added there.
"""

from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from msbsdf_cli.methods.base import outgoing
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.single import Single, first_order_of_each
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, unit_circle
from surfaces.materials import Material

WIDE = 0.25
"""Share of samples that are spread as the cosine, for the sake of what the table adds; it biases
nothing, as in `methods.sampling`."""


class Adds(Protocol):
    """A table: values (channels, n) to add for lanes of light, how far it is off, and whether it
    holds the first order too."""

    @property
    def error(self) -> float: ...

    @property
    def whole(self) -> bool: ...

    def __call__(self, alpha: Array | float, wi: Array, w: Array, inside: Array) -> Array: ...


@dataclass(frozen=True)
class Table:
    """BSDF per steradian, without the cosine, (sides, roughness, theta_i, theta_o, azimuth,
    channels) over ascending nodes; beyond the last ones it is as there."""

    alpha: Array
    theta_i: Array
    theta_o: Array
    azimuth: Array
    """Between the two directions, 0 to pi."""
    values: Array
    error: float
    """What the table is off by, relative to the mean of what it stands for."""
    whole = False

    def __call__(self, alpha: Array | float, wi: Array, w: Array, inside: Array) -> Array:
        """Values (channels, n) for directions (3, n) above the surface, `w` point-reflected where
        they leave `inside`."""
        cos = np.cos(np.arctan2(w[1], w[0]) - np.arctan2(wi[1], wi[0]))
        nodes = self.alpha, self.theta_i, self.theta_o, self.azimuth
        places = (
            np.broadcast_to(alpha, inside.shape),
            *(np.arccos(np.minimum(d[2], 1)) for d in (wi, w)),
            np.arccos(np.where(inside, -cos, cos)),
        )
        x = np.stack([np.clip(p, n[0], n[-1]) for p, n in zip(places, nodes, strict=True)], axis=-1)
        found = np.empty((len(x), self.values.shape[-1]))
        for side, values in enumerate(self.values):
            mine = np.flatnonzero(inside == bool(side))
            found[mine] = RegularGridInterpolator(nodes, values)(x[mine])
        return found.T


@dataclass(frozen=True)
class Tabulated:
    """Single scattering and a table, as a method for lanes of light."""

    name: str
    slopes: Slopes
    material: Material
    table: Adds

    def of_lanes(self, slopes: Slopes, material: Material) -> Self:
        """The same for other slopes, of one roughness each. Raises UnsupportedError for two, and
        for albedos that the table does not know."""
        if not np.array_equal(slopes.alpha_x, slopes.alpha_y):
            raise UnsupportedError(f"method {self.name} is a table here, of one roughness, not two")
        if material != self.material:
            raise UnsupportedError(f"method {self.name} is a table here, of one albedo")
        return replace(self, slopes=slopes)

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        """As `Method.evaluate_each`; what a table takes away leaves nothing below 0."""
        out = outgoing(self.slopes, wo)
        first: Array | float = 0.0
        if not self.table.whole:
            first = first_order_of_each(self.slopes, self.material, wi, out, rng)
        reached = self.material.transmits | ~out.inside
        later = self.table(self.slopes.alpha_x, wi, out.w, out.inside & reached) * out.w[2]
        return np.maximum(first + np.where(reached, later, 0), 0)

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """As `Method.sample_each`: the first facet, or the cosine."""
        n = wi.shape[1]
        m = self.slopes.visible_normals(wi, n, rng)
        w, _, transmitted = self.material.scatter(-wi, m, None, rng)
        through = np.zeros(n, bool) if transmitted is None else transmitted
        hidden = through == (w[2] > 0)
        wide = np.flatnonzero(rng.random(n) < self._wide)
        cos_phi, sin_phi = unit_circle(wide.size, rng)
        radius2 = rng.random(wide.size)
        w[:, wide] = np.sqrt(radius2) * cos_phi, np.sqrt(radius2) * sin_phi, np.sqrt(1 - radius2)
        if self.material.transmits:
            w[2, wide] *= np.where(rng.random(wide.size) < 0.5, -1, 1)
        hidden[wide] = False
        weight = self.evaluate_each(wi, w, rng) / np.where(hidden, 1, self.pdf_each(wi, w))
        return w, np.where(hidden, 0, weight)

    def pdf_each(self, wi: Array, wo: Array) -> Array:
        """The density of `sample_each`."""
        cosine = np.abs(wo[2]) / np.pi
        cosine = cosine / 2 if self.material.transmits else np.where(wo[2] > 0, cosine, 0)
        first = Single(self.slopes, self.material, 1).pdf_each(wi, wo)
        return (1 - self._wide) * first + self._wide * cosine

    @property
    def _wide(self) -> float:
        return WIDE if self.material.specular else 1.0
