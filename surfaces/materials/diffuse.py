"""Lambertian facets."""

from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from surfaces.facet import Array, dot, lambertian
from surfaces.materials._material import Material, Normals, Scattered
from surfaces.materials._visible_facets import lambertian_density

QUADRATURE_BLOCK = 64
"""Directions integrated over at once: a few thousand slopes for each of them."""


@dataclass(frozen=True)
class Diffuse(Material):
    """A Lambertian facet, of one albedo per channel; a number stands for one channel.

    Raises ValueError for an albedo that is not from 0 to 1.
    """

    albedo: tuple[float, ...] | float = (1.0,)
    options = ("albedo",)
    specular = False

    def __post_init__(self) -> None:
        if isinstance(self.albedo, int | float):
            object.__setattr__(self, "albedo", (float(self.albedo),))
        if not self.albedos or not all(0 <= a <= 1 for a in self.albedos):
            raise ValueError(f"{self.albedo} is not an albedo: numbers from 0 to 1 are wanted.")

    @property
    def albedos(self) -> tuple[float, ...]:
        assert isinstance(self.albedo, tuple)
        return self.albedo

    @property
    def absorbs(self) -> bool:
        return min(self.albedos) < 1

    @property
    def channels(self) -> int:
        return len(self.albedos)

    @property
    def lossless(self) -> "Diffuse":
        return Diffuse()

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        n = m.shape[1]
        out = lambertian(m * (1 / np.sqrt(dot(m, m))), n, rng)
        if not self.absorbs:
            return Scattered(out)
        return Scattered(out, gain=self.kept())

    def lobe(self, cos_o: Array) -> Array:
        return np.maximum(cos_o, 0) / np.pi

    def reflection(
        self, normals: Normals, d: Array, w: Array, inside: bool = False
    ) -> tuple[Array, Array | None]:
        """Without noise: by quadrature over the facets that face both ways ([HHdD16] Eq. 17)."""
        n = max(d.shape[1], w.shape[1])
        d, w = np.broadcast_to(d, (3, n)), np.broadcast_to(w, (3, n))
        density = np.empty(n, w.dtype)
        for start in range(0, n, QUADRATURE_BLOCK):
            block = slice(start, start + QUADRATURE_BLOCK)
            density[block] = lambertian_density(normals, d[:, block], w[:, block])
        return density, self.kept(density.dtype)


@dataclass(frozen=True, eq=False)
class TexturedDiffuse(Diffuse):
    """Lambertian facets under a texture: `lanes` (channels, n) are albedos of n lanes of light."""

    lanes: Array = field(default_factory=lambda: np.ones((1, 1)))

    def kept(self, dtype: Any = float) -> Array:
        return self.lanes.astype(dtype, copy=False)

    def at(self, lanes: Array | None) -> Self:
        return self if lanes is None else replace(self, lanes=self.lanes.take(lanes, axis=1))

    @property
    def absorbs(self) -> bool:
        return True

    @property
    def channels(self) -> int:
        return len(self.lanes)

    @property
    def lossless(self) -> Diffuse:
        return Diffuse()
