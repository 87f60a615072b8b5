"""Mirrors and metals."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from surfaces.facet import Array, absorptance_conductor, dot, reflect
from surfaces.materials._material import Material, Scattered, Slopes, reflection_density
from surfaces.metals import GREEN, METALS

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
    name = "conductor"
    options = ("metal", "eta_k")
    turns_down = False  # A mirror always raises d_z.

    def __post_init__(self) -> None:
        for pair in self.eta_k:
            n, k = pair if len(pair) == 2 else (np.nan, np.nan)
            if not (0 < n <= MOST_INDEX and 0 <= k <= MOST_INDEX):
                raise ValueError(
                    f"{pair} is not the index n, k of a metal: n above 0 and k from 0, both at "
                    f"most {MOST_INDEX:g}."
                )

    @classmethod
    def named(cls, metal: str, rgb: bool = False) -> Self:
        """A metal of `METALS` at 549 nm, or in red, green and blue; ValueError for any other."""
        if metal not in METALS:
            raise ValueError(f"{metal!r} is not a metal known here: one of {', '.join(METALS)}.")
        return cls(METALS[metal] if rgb else METALS[metal][GREEN : GREEN + 1])

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> Self:
        """A mirror, a metal by name, in colour where `rgb` is on, or one of given n,k[,n,k...]."""
        metal, given = options["metal"], tuple(options["eta_k"] or ())
        if metal is not None and given:
            raise ValueError("--metal and --eta-k both give the metal's index; give one of them.")
        if metal is not None:
            return cls.named(metal, options.get("rgb", False))
        return cls(tuple(given[i : i + 2] for i in range(0, len(given), 2)))

    @property
    def absorbs(self) -> bool:
        return bool(self.eta_k)

    @property
    def channels(self) -> int:
        return max(len(self.eta_k), 1)

    def fresnel(self, cos_i: Array) -> Array:
        """Reflectance (channels, n) for cosines (n,) of incidence.

        In double precision always: what was absorbed is what a weight lacks of 1.
        """
        if not self.absorbs:
            return np.ones((1, cos_i.size))
        eta, k = np.array(self.eta_k, cos_i.dtype).T[..., None]
        return 1 - absorptance_conductor(cos_i, eta, k).astype(float, copy=False)

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        if not self.absorbs:
            return Scattered(reflect(d, m))
        cos_i = np.abs(dot(d, m)) / np.sqrt(dot(m, m))
        return Scattered(reflect(d, m), gain=self.fresnel(cos_i))

    def density(
        self, slopes: Slopes, d: Array, w: Array, inside: bool = False, transmitted: bool = False
    ) -> tuple[Array, Array | None]:
        density, cos_i = reflection_density(slopes, d, w)
        if not self.absorbs:
            return density, None
        return density, self.fresnel(cos_i.ravel()).reshape(self.channels, *cos_i.shape)
