"""Smooth interfaces between two transparent media."""

from dataclasses import dataclass, replace

import numpy as np

from surfaces.facet import Array, dot, fresnel_dielectric
from surfaces.materials._material import (
    Material,
    Normals,
    Scattered,
    density_of_half_vectors,
    half_vector_reflection,
)


@dataclass(frozen=True)
class Dielectric(Material):
    """A smooth interface that reflects or refracts, chosen by the Fresnel reflectance.

    `ior` is the index inside over the index outside, above 0 and finite. Raises ValueError for any
    other.
    """

    ior: float = 1.5
    options = ("ior",)
    transmits = True

    def __post_init__(self) -> None:
        if not 0 < self.ior < np.inf:
            raise ValueError(f"ior is {self.ior}: an index ratio is a finite number above 0.")

    @property
    def turned_over(self) -> "Dielectric":
        return replace(self, ior=1 / self.ior)

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        m = m * (1 / np.sqrt(dot(m, m)))
        n = m.shape[1]
        dtype = m.dtype.type
        eta, inverse = dtype(self.ior), dtype(1 / self.ior)
        if inside is not None and inside.any():
            # Here and below sums stand in for `np.where`, which costs ten times as much of a choice
            # that nothing predicts.
            other = (inverse - eta) * inside
            eta, inverse = eta + other, inverse - other
        cos_i = np.abs(dot(d, m))
        fresnel, cos_t = fresnel_dielectric(cos_i, eta)
        transmitted = rng.random(n, dtype=dtype) >= fresnel
        # Both leave in the plane of d and m: d + 2 cos_i m, or d / eta + (cos_i / eta - cos_t) m.
        scale = 1 + (inverse - 1) * transmitted
        along_m = scale * cos_i + (cos_i - (cos_i + cos_t) * transmitted)
        return Scattered(scale * d + along_m * m, transmitted=transmitted)

    def reflectance(self, cos_i: Array, inside: bool = False) -> Array:
        return fresnel_dielectric(cos_i, self.relative_ior(inside))[0][None]

    def reflection(
        self, normals: Normals, d: Array, w: Array, inside: bool = False
    ) -> tuple[Array, Array | None]:
        density, cos_i = half_vector_reflection(normals, d, w)
        return density * self.reflectance(cos_i, inside)[0], None

    def refraction(self, normals: Normals, d: Array, w: Array, inside: bool = False) -> Array:
        """In the frame of the far side the normal of [HHdD16] Eq. 35, -(i + eta o), is d + eta w,
        or its opposite where the medium beyond is the thinner; its length is
        |eta_i (i . h) + eta_o (o . h)|.
        """
        eta = self.relative_ior(inside)
        h = (eta * w + d) * (1 if eta > 1 else -1)
        length = np.sqrt(dot(h, h))
        m = h / np.maximum(length, np.finfo(h.dtype).tiny)
        cos_i, cos_t = -dot(d, m), dot(w, m)
        faces = (cos_i > 0) & (cos_t > 0)
        fresnel = fresnel_dielectric(np.clip(cos_i, 0, 1), eta)[0]
        jacobian = eta * eta * cos_i * cos_t / (length * length)
        density = density_of_half_vectors(normals, h, length)
        return np.where(faces, (1 - fresnel) * jacobian * density, 0)
