"""Metals and perfect mirrors."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from surfaces.facet import Array, absorptance_conductor, dot, reflect
from surfaces.materials._material import Material, Normals, Scattered, half_vector_reflection
from surfaces.materials._metals import GREEN, METALS

MOST_INDEX = 1e4
"""Indices of metals grow with the root of the wavelength (Hagen and Rubens): copper has some 1300
at a millimetre, and where they are 10 000, at centimetres, light does not meet microfacets one by
one."""


@dataclass(frozen=True)
class Conductor(Material):
    """A mirror, perfect or with the Fresnel reflectance of a complex index n + i k per channel.

    `eta_k` are pairs (n, k), n above 0 and k from 0, at most `MOST_INDEX`; none for a perfect
    mirror. Raises ValueError for what is no index.
    """

    eta_k: tuple[tuple[float, float], ...] = ()
    options = ("metal", "eta_k", "rgb")

    def __post_init__(self) -> None:
        for pair in self.eta_k:
            n, k = pair if len(pair) == 2 else (np.nan, np.nan)
            if not (0 < n <= MOST_INDEX and 0 <= k <= MOST_INDEX):
                raise ValueError(
                    f"{','.join(f'{x:g}' for x in pair)} is not a metal's index: N above 0, K 0 or "
                    f"more, both at most {MOST_INDEX:g}."
                )

    @classmethod
    def named(cls, metal: str, rgb: bool = False) -> "Conductor":
        """A metal of `METALS` at 549 nm, or in red, green and blue; ValueError for any other."""
        if metal not in METALS:
            raise ValueError(f"{metal!r} is not a metal known here: one of {', '.join(METALS)}.")
        return cls(METALS[metal] if rgb else METALS[metal][GREEN : GREEN + 1])

    @classmethod
    def of(cls, **options: Any) -> Self:
        metal, numbers = options["metal"], options["eta_k"] or ()
        if metal is not None and numbers:
            raise ValueError("both give the metal's index; give one of them.")
        if metal is not None:
            return cls(cls.named(metal, bool(options["rgb"])).eta_k)
        if len(numbers) % 2:
            raise ValueError(f"{','.join(f'{x:g}' for x in numbers)} are not pairs N,K.")
        return cls(tuple(zip(numbers[::2], numbers[1::2], strict=True)))

    @property
    def absorbs(self) -> bool:
        return bool(self.eta_k)

    @property
    def channels(self) -> int:
        return max(len(self.eta_k), 1)

    @property
    def lossless(self) -> "Conductor":
        return Conductor()

    def reflectance(self, cos_i: Array, inside: bool = False) -> Array:
        """In double precision always: what was absorbed is what a weight lacks of 1."""
        if not self.absorbs:
            return super().reflectance(cos_i)
        eta, k = np.array(self.eta_k, cos_i.dtype).T[..., None]
        kept = 1 - absorptance_conductor(cos_i.ravel(), eta, k).astype(float, copy=False)
        # What is absorbed altogether comes to 1 but for rounding.
        kept = np.maximum(kept, 0)
        return kept.reshape(self.channels, *cos_i.shape)

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        if not self.absorbs:
            return Scattered(reflect(d, m))
        cos_i = np.abs(dot(d, m)) / np.sqrt(dot(m, m))
        return Scattered(reflect(d, m), gain=self.reflectance(cos_i))

    def reflection(
        self, normals: Normals, d: Array, w: Array, inside: bool = False
    ) -> tuple[Array, Array | None]:
        density, cos_i = half_vector_reflection(normals, d, w)
        return density, self.reflectance(cos_i) if self.absorbs else None
