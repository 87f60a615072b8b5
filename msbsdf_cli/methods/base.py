"""Outgoing directions as the methods see them, and what all methods ask of a material."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material


@dataclass(frozen=True)
class Outgoing:
    """Directions of leaving, each in the frame of the side it leaves on.

    A direction at the horizon counts as out of reach: its cosine is 0, and so is every value.
    """

    w: Array
    """Unit vectors (3, n), point-reflected if `inside`, so that z >= 0."""
    inside: Array
    """Who leaves into the inner medium, (n,) of bool."""
    Lambda: Array
    """Lambda(w), (n,)."""
    each: bool = False
    """Whether every path looks towards one direction of its own, which its `start` numbers; else
    towards all of them."""

    @property
    def n(self) -> int:
        return self.w.shape[1]

    @property
    def per_path(self) -> int:
        """Directions that a path looks towards."""
        return 1 if self.each else self.n

    def seen_by(self, start: Array | None) -> "Outgoing":
        """The directions as they broadcast against paths (n, 1): (3, 1, directions), or (3, n, 1)
        where path k has the direction `start[k]`."""
        if not self.each:
            return Outgoing(self.w[:, None], self.inside[None], self.Lambda[None])
        w, inside, Lambda = self.w[:, start, None], self.inside[start], self.Lambda[start]
        return Outgoing(w, inside[..., None], Lambda[..., None], each=True)


def outgoing(slopes: Slopes, wo: Array, each: bool = False) -> Outgoing:
    """Directions `wo` (3, n) on either side of the surface."""
    inside = wo[2] < 0
    w = np.where(inside, -wo, wo)
    # Finite at the horizon, closer to which than rounding no direction is: times t = 0 it is 0.
    cos_o = np.maximum(w[2], np.finfo(w.dtype).eps ** 2)
    return Outgoing(w, inside, slopes.sigma(w) / cos_o, each)


ONE_WI = "method {} evaluates many outgoing directions of one incident direction, not pairs"


class MethodBase:
    """Base of the methods: says which slopes and materials a method supports, before any work."""

    name: str
    slopes: Slopes
    material: Material
    orders: int
    deterministic = False
    """Whether values have no noise, so that samples make no difference."""
    traits: Traits

    def __init__(self, slopes: Slopes, material: Material, orders: int) -> None:
        self.check_supported(slopes, material)
        self.slopes, self.material, self.orders = slopes, material, orders

    @classmethod
    def on(cls, slopes: Slopes, material: Material, orders: int, autocorrelation: str) -> Self:
        """The method for surfaces of this autocorrelation, of which the Smith model knows
        nothing."""
        return cls(slopes, material, orders)

    def undersampling(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Array:
        """Error (channels, n) that paths may leave in all values from order 2 on which none of
        `samples` walks has found; it adds to `stderr` in quadrature. 0 without noise."""
        return np.zeros((1, wo.shape[1]))

    def albedo(self, wi: Array) -> tuple[Array, Array] | None:
        """Energy that leaves after each order, on both sides, and its error, (channels, orders + 1)
        each, for `wi` (3,); None where the method knows it no better than by adding up values."""
        return None

    def of_lanes(self, slopes: Slopes, material: Material) -> Self:
        """The same method for lanes (n,) of light, each with slopes and a material of its own.
        Raises UnsupportedError where the trait `pairs` does not hold."""
        if not self.traits.pairs:
            raise UnsupportedError(ONE_WI.format(self.name))
        return type(self)(slopes, material, self.orders)

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        """One estimate of all orders together, (channels, n), for each pair of directions of `wi`
        and `wo` (3, n), as a renderer asks. Raises UnsupportedError likewise."""
        raise UnsupportedError(ONE_WI.format(self.name))

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """`sample` with one direction for each of `wi` (3, n)."""
        raise UnsupportedError(ONE_WI.format(self.name))

    def pdf_each(self, wi: Array, wo: Array) -> Array:
        """`pdf` for each pair of directions."""
        raise UnsupportedError(ONE_WI.format(self.name))

    @classmethod
    def check_supported(cls, slopes: Slopes, material: Material) -> None:
        """Raise `UnsupportedError` for what the method cannot do."""
        if material.transmits and material.ior == 1:
            raise UnsupportedError(
                f"method {cls.name} needs an index other than 1: light that goes straight on has "
                "no density"
            )
        if material.transmits and (material.absorbs or not material.specular):
            raise UnsupportedError(
                f"method {cls.name} is not for {material.name} facets: those that transmit have to "
                "be specular and absorb nothing, as light through them is followed in one channel"
            )


def adjoint_weight(material: Material, out: Outgoing) -> Array:
    """What a path that is found from its outgoing direction counts for that direction, (n,), but
    for its near end: cos(theta_o) times the squared index there; 0 where no light gets to."""
    reached = ~out.inside | material.transmits
    return np.where(reached, out.w[2] * material.squared_index(out.inside), 0)
