"""What all materials have in common: scattering, its density, and data that the methods read.

A material turns the direction of travel `d` (3, n) and the normal `m` (3, n) of the facet it
meets, on the side of the arriving light and of any length, into the direction it leaves in.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from surfaces.facet import Array, dot


class Scattered(NamedTuple):
    """Light that leaves a facet."""

    d: Array
    """Directions of travel, (3, n)."""
    gain: Array | None = None
    """Fraction of the energy that is kept in each channel, (channels, n), in double
    precision whatever that of the directions; None: all of it."""
    transmitted: Array | None = None
    """Whether the light went behind the facet, (n,) of bool; None: never."""


class Scatters(Protocol):
    """What following light asks of a facet: the density is for methods that evaluate."""

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


class Slopes(Protocol):
    """A distribution of slopes, as far as the density of a material needs it."""

    @property
    def alpha_x(self) -> float:
        """Roughness along x."""

    @property
    def alpha_y(self) -> float:
        """Roughness along y."""

    def D(self, m: Array) -> Array:
        """Density of normals (3, ...), per steradian ([HHdD16] Eq. 2)."""


class Material(ABC):
    """A facet's material. What methods and commands need to know of one is data on the class."""

    name: ClassVar[str]
    """As on the command line."""
    options: ClassVar[tuple[str, ...] | None] = None
    """Options of the command line that are for this material; None: the names of its fields."""
    transmits: ClassVar[bool] = False
    """Whether light goes through facets."""
    specular: ClassVar[bool] = True
    """Whether a facet sends light only into the directions of reflection and refraction."""
    lambertian: ClassVar[bool] = False
    """Whether a facet is equally bright from everywhere before it."""
    turns_down: ClassVar[bool] = True
    """Whether light that heads up from a facet may head down again from the next one."""
    ior: float = 1.0
    """Index inside over index outside."""

    @property
    def absorbs(self) -> bool:
        """Whether facets keep some of the energy."""
        return False

    @property
    def channels(self) -> int:
        """Colours or wavelengths followed at once, with one weight each."""
        return 1

    @property
    def albedos(self) -> tuple[float, ...]:
        """Energy that a Lambertian facet returns in each channel, from 0 to 1."""
        return (1.0,) * self.channels

    @property
    def bend(self) -> float:
        """Least angle by which a specular direction turns, over that by which its facet does."""
        return 2.0

    @classmethod
    def option_names(cls) -> tuple[str, ...]:
        """Names of the options that are for this material."""
        if cls.options is not None:
            return cls.options
        return tuple(f.name for f in fields(cls)) if is_dataclass(cls) else ()

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> Self:
        """The material that options by name describe. Raises ValueError for impossible ones."""
        return cls(**{name: options[name] for name in cls.option_names() if name in options})

    @abstractmethod
    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        """Light leaving the facets. `inside` (n,) of bool: who arrives from the inner medium."""

    @abstractmethod
    def density(
        self, slopes: Slopes, d: Array, w: Array, inside: bool = False, transmitted: bool = False
    ) -> tuple[Array, Array | None]:
        """The scattering kernel q(d -> w), (...), and the fraction of it that is kept in each
        channel, (channels, ...) or broadcasting to it; None: all of it.

        q = integral of <-d, m> D(m) f(d, m, w) dm, per steradian of `w`, f being the energy that
        a facet sends into w if it absorbs none. For directions of travel (3, ...) that broadcast
        against each other, each in the frame of the side it travels in: inside, and beyond a
        facet that transmits, point-reflected (see `msbsdf_cli.smith.kernel`).
        """

    def fresnel(self, cos_i: Array) -> Array:
        """Reflectance (channels, n) of a specular facet, from outside, at cosines (n,)."""
        return np.ones((self.channels, cos_i.size))

    def relative_ior(self, inside: bool) -> float:
        """Index behind the facet over the index before it."""
        return 1 / self.ior if inside else self.ior


def reflection_density(slopes: Slopes, d: Array, w: Array) -> tuple[Array, Array]:
    """q (...) of perfect mirrors, D(h) / 4, and the cosine of incidence (...).

    h is the half vector of -d and w; no facet points below the horizon.
    """
    h = w - d
    length = np.sqrt(dot(h, h))
    return density_of_normals(slopes, h, length) / 4, length / 2


def density_of_normals(slopes: Slopes, h: Array, length: Array) -> Array:
    """D of half vectors (3, ...) of the given length, 0 for those below the horizon.

    So near to the horizon that cos^4 of their angle underflows, they count as below.
    """
    horizon = np.finfo(h.dtype).tiny ** 0.25
    above = h[2] > horizon * length
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(above, slopes.D(h / length), 0)
