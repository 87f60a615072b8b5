"""What a material is: how a facet scatters light, and how all facets of a surface do together.

A material turns the direction of travel `d` (3, n) and the normal `m` (3, n) of the facet it
meets, on the side of the arriving light and of any length, into the direction it leaves in. That is
all that tracing and the random walk need.

Methods that evaluate need the scattering kernel of a surface of such facets as well,

    q(d -> w) = integral of <-d, m> D(m) f(d, m, w) dm

per steradian of `w`, f being the energy that a facet sends into w (its BSDF times |w . m|). Over
all `w` it sums to sigma(d), less what is absorbed, so that q(d -> w) / sigma(d) is the phase
function of [HHdD16] (Section 6); but q needs no division by an area that vanishes, and for a mirror
it is the same seen from both ends. Inside a dielectric everything is point-reflected, as in
`msbsdf_cli.smith.walk`: a direction is given in the frame of the side it travels in, where light
that heads away from the surface has z > 0. Arrays of directions are (3, ...), and broadcast against
each other.
"""

from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from surfaces.facet import Array, dot


class Scattered(NamedTuple):
    """Light that leaves a facet."""

    d: Array
    """Directions of travel, (3, n)."""
    gain: Array | None = None
    """Fraction of the energy that is kept in each channel, (channels, n), in double precision
    whatever that of the directions; None: all of it."""
    transmitted: Array | None = None
    """Whether the light went behind the facet, (n,) of bool; None: never."""


class Normals(Protocol):
    """A distribution of normals: what the kernel needs to know of a surface."""

    @property
    def alpha_x(self) -> float:
        """Roughness along x."""

    @property
    def alpha_y(self) -> float:
        """Roughness along y."""

    def D(self, m: Array) -> Array:
        """Distribution over vectors (3, ...), of any length as `density_of_half_vectors` says."""


class Material(ABC):
    """A facet's material, whose class says by data what it can do."""

    options: ClassVar[tuple[str, ...]] = ()
    """Options of the command line that it takes."""
    transmits: bool = False
    """Whether light goes through facets."""
    ior: float = 1.0
    """Index of refraction inside over outside, where facets transmit."""
    specular: bool = True
    """Whether a facet sends light of one direction into one or two others; else into a lobe that
    depends on the cosine to its normal alone (`lobe`)."""

    @property
    def name(self) -> str:
        """As on the command line: that of the file."""
        return type(self).__module__.rpartition(".")[2]

    @classmethod
    def of(cls, **options: Any) -> Self:
        """The material that its `options` describe, None where an option is not given; raises
        ValueError for what is none."""
        return cls(**options)

    @property
    def absorbs(self) -> bool:
        """Whether facets keep some of the energy."""
        return False

    @property
    def channels(self) -> int:
        """Colours or wavelengths followed at once, with one weight each."""
        return 1

    @property
    def lossless(self) -> "Material":
        """The same facets, absorbing nothing, in one channel."""
        return self

    @property
    def turned_over(self) -> "Material":
        """The facets as they are from inside."""
        return self

    @property
    def albedos(self) -> tuple[float, ...]:
        """Of facets that are not specular: the fraction of energy kept in each channel."""
        return (1.0,) * self.channels

    def kept(self, dtype: Any = float) -> Array:
        """The same as an array, (channels, 1), or (channels, n) where lanes differ."""
        return np.array(self.albedos, dtype)[:, None]

    def at(self, lanes: Array | None) -> Self:
        """The material of some of the lanes of light: the same for all without a texture."""
        return self

    @abstractmethod
    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        """Light leaving the facets. `inside` (n,) of bool: who arrives from the inner medium."""

    @abstractmethod
    def reflection(
        self, normals: Normals, d: Array, w: Array, inside: bool = False
    ) -> tuple[Array, Array | None]:
        """q of light that stays on its side, per steradian, (...), and what each channel keeps of
        it, (channels, ...), or None where that is all."""

    def refraction(self, normals: Normals, d: Array, w: Array, inside: bool = False) -> Array:
        """q of light that changes sides, (...): `d` on the side of arrival, `w` point-reflected
        beyond; an opaque facet sends nothing there."""
        return np.zeros(np.broadcast_shapes(d.shape, w.shape)[1:], w.dtype)

    def reflectance(self, cos_i: Array, inside: bool = False) -> Array:
        """Of specular facets for cosines (n,) of incidence, (channels, n)."""
        return np.ones((self.channels, *cos_i.shape), cos_i.dtype)

    def lobe(self, cos_o: Array) -> Array:
        """Of facets that are not specular: what one sends per steradian at this cosine to its
        normal, over what it keeps; of specular ones nothing that has a density."""
        return np.zeros_like(cos_o)

    def density(
        self, normals: Normals, d: Array, w: Array, inside: bool = False, transmitted: bool = False
    ) -> Array:
        """q(d -> w) per steradian, (channels, n), for directions of travel (3, n) or (3, 1)."""
        if transmitted:
            return self.refraction(normals, d, w, inside)[None]
        density, colour = self.reflection(normals, d, w, inside)
        return density[None] if colour is None else density * colour

    def relative_ior(self, inside: bool) -> float:
        """Index behind the facet over the index before it."""
        return 1 / self.ior if inside else self.ior

    def squared_index(self, inside: Array | bool) -> Array | float:
        """The squared index of the side, that outside being 1.

        Light carries energy here, not radiance: seen from its other end, a path counts the ratio
        of the squared indices at its ends.
        """
        return np.where(inside, self.ior**2, 1.0) if self.transmits else 1.0


def half_vector_reflection(normals: Normals, d: Array, w: Array) -> tuple[Array, Array]:
    """D(h) / 4, (...), h being the half vector of -d and w, and the cosine of incidence at facets
    of that normal: q of mirrors; no facet points below the horizon."""
    h = w - d
    length = np.sqrt(dot(h, h))
    return density_of_half_vectors(normals, h, length) / 4, length / 2


def density_of_half_vectors(normals: Normals, h: Array, length: Array) -> Array:
    """D of half vectors (3, ...) of the given length, 0 for those below the horizon."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(length > 0, normals.D(h / length), 0)
