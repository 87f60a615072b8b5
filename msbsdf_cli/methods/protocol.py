"""What every method offers: evaluation per order, and sampling where it can."""

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material


class UnsupportedError(ValueError):
    """A method was asked for a material or slopes it does not hold for; the text says why."""


@dataclass(frozen=True)
class Evaluation:
    """BSDF x cos(theta_o), per steradian, for one incident and n outgoing directions.

    Arrays are (channels, orders + 1, n): orders 1 to `orders`, then all the later ones summed.
    """

    value: Array
    stderr: Array
    """Standard error of each value, from the scatter of walks; 0 where the method has no noise."""
    unresolved: float = 0.0
    """Energy not followed to its end: at most this share of the incident energy is missing."""


class Method(Protocol):
    """A BSDF of given slopes and material, evaluated one way.

    Made by `Method(slopes, material, orders)`, which does all the work that serves every pair of
    directions, and raises `UnsupportedError` for what the method cannot do.
    """

    name: str
    material: Material
    deterministic: bool
    """Whether values have no noise, so that samples make no difference."""
    traits: Traits

    @classmethod
    def check_supported(cls, slopes: Slopes, material: Material) -> None:
        """Raise `UnsupportedError` for what the method cannot do, before any work is done."""

    def __init__(self, slopes: Slopes, material: Material, orders: int) -> None: ...

    @classmethod
    def on(cls, slopes: Slopes, material: Material, orders: int, autocorrelation: str) -> Self:
        """The method for surfaces of this autocorrelation, as `surfaces.spectrum` names it. It
        makes a difference to methods alone that remember surfaces."""

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        """Evaluate for a unit vector `wi` (3,), z > 0, and unit vectors `wo` (3, n), z either sign.

        `samples` is the number of walks or paths; methods without noise ignore it. Arithmetic is
        in the precision of `wi`.
        """

    def undersampling(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Array:
        """Error (channels, n) that paths may leave in all values from order 2 on which none of
        `samples` walks has found; it adds to `stderr` in quadrature. 0 without noise."""

    def albedo(self, wi: Array) -> tuple[Array, Array] | None:
        """Energy that leaves after each order, on both sides, and its error, (channels, orders + 1)
        each, for `wi` (3,); None where the method knows it no better than by adding up values."""

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """Draw outgoing directions (3, n) and their weights (channels, n): BSDF x cos / density."""

    def pdf(self, wi: Array, wo: Array) -> Array:
        """A density (n,) per steradian to weigh samples of `sample` against other strategies."""

    def of_lanes(self, slopes: Slopes, material: Material) -> Self:
        """The same method for lanes (n,) of light, each with slopes and a material of its own.
        Raises UnsupportedError where the trait `pairs` does not hold."""

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        """One estimate of all orders together, (channels, n), for each pair of directions of `wi`
        and `wo` (3, n), as a renderer asks. Raises UnsupportedError likewise."""

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """`sample` with one direction for each of `wi` (3, n)."""

    def pdf_each(self, wi: Array, wo: Array) -> Array:
        """`pdf` for each pair of directions."""
