"""Facet materials: what a facet does with light, for tracing and for the random walk alike.

A material turns the direction of travel `d` (3, n) and the normal `m` (3, n) of the facet it
meets, on the side of the arriving light and of any length, into the direction it leaves in.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from surfaces.facet import (
    Array,
    absorptance_conductor,
    dot,
    fresnel_dielectric,
    lambertian,
    reflect,
)


class Scattered(NamedTuple):
    """Light that leaves a facet."""

    d: Array
    """Directions of travel, (3, n)."""
    gain: Array | None = None
    """Share of the energy that is kept in each channel, (channels, n), in double precision whatever
    that of the directions; None: all of it."""
    transmitted: Array | None = None
    """Whether the light went behind the facet, (n,) of bool; None: never."""


class Material(Protocol):
    """A facet's material."""

    @property
    def name(self) -> str:
        """As on the command line."""

    @property
    def absorbs(self) -> bool:
        """Whether facets keep some of the energy."""

    @property
    def transmits(self) -> bool:
        """Whether light goes through facets."""

    @property
    def channels(self) -> int:
        """Colours or wavelengths followed at once, with one weight each."""

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        """Light leaving the facets. `inside` (n,) of bool: who arrives from the inner medium."""


MOST_INDEX = 1e4
"""Indices of metals grow with the root of the wavelength (Hagen and Rubens): copper has some 1300
at a millimetre, and where they are 10 000, at centimetres, light does not meet microfacets one by
one."""


@dataclass(frozen=True)
class Conductor:
    """A mirror, perfect or with the Fresnel reflectance of a complex index n + i k per channel.

    `eta_k` are pairs (n, k), n above 0 and k from 0, at most `MOST_INDEX`; none for a perfect
    mirror. Raises ValueError for what is no index.
    """

    eta_k: tuple[tuple[float, float], ...] = ()
    name = "conductor"
    transmits = False

    def __post_init__(self) -> None:
        for pair in self.eta_k:
            n, k = pair if len(pair) == 2 else (np.nan, np.nan)
            if not (0 < n <= MOST_INDEX and 0 <= k <= MOST_INDEX):
                raise ValueError(
                    f"{pair} is not the index n, k of a metal: n above 0 and k from 0, both at "
                    f"most {MOST_INDEX:g}."
                )

    @classmethod
    def named(cls, metal: str, rgb: bool = False) -> "Conductor":
        """A metal of `METALS` at 549 nm, or in red, green and blue; ValueError for any other."""
        if metal not in METALS:
            raise ValueError(f"{metal!r} is not a metal known here: one of {', '.join(METALS)}.")
        return cls(METALS[metal] if rgb else METALS[metal][GREEN : GREEN + 1])

    @property
    def absorbs(self) -> bool:
        return bool(self.eta_k)

    @property
    def channels(self) -> int:
        return max(len(self.eta_k), 1)

    def fresnel(self, cos_i: Array) -> Array:
        """Reflectance (channels, n) for cosines (n,) of incidence; only where light is absorbed.

        In double precision always: what was absorbed is what a weight lacks of 1.
        """
        eta, k = np.array(self.eta_k, cos_i.dtype).T[..., None]
        return 1 - absorptance_conductor(cos_i, eta, k).astype(float, copy=False)

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        if not self.absorbs:
            return Scattered(reflect(d, m))
        cos_i = np.abs(dot(d, m)) / np.sqrt(dot(m, m))
        return Scattered(reflect(d, m), gain=self.fresnel(cos_i))


@dataclass(frozen=True)
class Diffuse:
    """A Lambertian facet, of one albedo per channel; a number stands for one channel.

    Raises ValueError for an albedo that is not from 0 to 1.
    """

    albedo: tuple[float, ...] | float = (1.0,)
    name = "diffuse"
    transmits = False

    def __post_init__(self) -> None:
        if isinstance(self.albedo, int | float):
            object.__setattr__(self, "albedo", (float(self.albedo),))
        if not self.albedos or not all(0 <= a <= 1 for a in self.albedos):
            raise ValueError(f"{self.albedo} is not an albedo: numbers from 0 to 1 are wanted.")

    @property
    def albedos(self) -> tuple[float, ...]:
        """The albedo of each channel."""
        assert isinstance(self.albedo, tuple)
        return self.albedo

    @property
    def absorbs(self) -> bool:
        return min(self.albedos) < 1

    @property
    def channels(self) -> int:
        return len(self.albedos)

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        n = m.shape[1]
        out = lambertian(m * (1 / np.sqrt(dot(m, m))), n, rng)
        if not self.absorbs:
            return Scattered(out)
        return Scattered(out, gain=np.array(self.albedos)[:, None])


@dataclass(frozen=True)
class Dielectric:
    """A smooth interface that reflects or refracts, chosen by the Fresnel reflectance.

    `ior` is the index inside over the index outside, above 0 and finite. Raises ValueError for any
    other.
    """

    ior: float = 1.5
    name = "dielectric"
    absorbs = False
    transmits = True
    channels = 1

    def __post_init__(self) -> None:
        if not 0 < self.ior < np.inf:
            raise ValueError(f"ior is {self.ior}: an index ratio is a finite number above 0.")

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        m = m * (1 / np.sqrt(dot(m, m)))
        n = m.shape[1]
        dtype = m.dtype.type
        eta, inverse = dtype(self.ior), dtype(1 / self.ior)
        if inside is not None and inside.any():
            eta, inverse = np.where(inside, inverse, eta), np.where(inside, eta, inverse)
        cos_i = np.abs(dot(d, m))
        fresnel, cos_t = fresnel_dielectric(cos_i, eta)
        transmitted = rng.random(n, dtype=dtype) >= fresnel
        # Both leave in the plane of d and m: d + 2 cos_i m, or d / eta + (cos_i / eta - cos_t) m.
        scale = np.where(transmitted, inverse, dtype(1))
        along_m = np.where(transmitted, cos_i * inverse - cos_t, 2 * cos_i)
        return Scattered(scale * d + along_m * m, transmitted=transmitted)


def material(name: str) -> type[Any]:
    """The class of a material by name. Raises ValueError for a name that is none."""
    for cls in (Conductor, Diffuse, Dielectric):
        if cls.name == name:
            return cls
    raise ValueError(f"{name!r} is not a material: one of conductor, diffuse, dielectric.")


METALS: dict[str, tuple[tuple[float, float], ...]] = {
    "gold": ((0.21, 3.272), (0.43, 2.455), (1.31, 1.849)),
    "silver": ((0.06, 4.152), (0.06, 3.586), (0.05, 2.869)),
    "copper": ((0.30, 3.205), (1.02, 2.577), (1.25, 2.483)),
    "aluminium": ((1.350, 7.371), (1.009, 6.611), (0.709, 5.712)),
    "chromium": ((3.17, 3.30), (3.18, 3.33), (2.51, 3.24)),
}
"""Complex indices n + i k of metals at 617, 549 and 471 nm: red, green and blue.

Gold, silver, copper: Johnson & Christy, Phys. Rev. B 6, 4370 (1972); chromium: Johnson & Christy,
Phys. Rev. B 9, 5056 (1974); aluminium: Rakic, Appl. Opt. 34, 4755 (1995), interpolated linearly.
"""

GREEN = 1
"""The channel that stands for all where only one is followed."""
