"""Height distributions: needed only where somebody looks at heights, as t = -ln C1(h)."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import log_ndtr

from surfaces.facet import Array
from surfaces.marginal import Marginal, marginal


class Heights(Protocol):
    """A distribution of heights. The BSDF does not depend on it ([HHdD16], section 5)."""

    @property
    def starts(self) -> tuple[float, ...]:
        """Heights worth starting a free path from."""

    @property
    def edges(self) -> Array:
        """Edges of bins for heights, from -inf to inf."""

    def t(self, h: Array | float) -> Array:
        """-ln C1(h): infinite below the surface, 0 above it."""


@dataclass(frozen=True)
class Uniform:
    """Uniform between -1 and 1."""

    starts = (-0.8, -0.4, 0.0, 0.4, 0.8, np.inf)
    edges = np.concatenate([[-np.inf], np.linspace(-1, 1, 33), [np.inf]])

    def t(self, h: Array | float) -> Array:
        with np.errstate(divide="ignore"):
            return -np.log(np.clip((h + 1) / 2, 0, 1))


@dataclass(frozen=True)
class Gaussian:
    """Gaussian of mean 0 and variance 1, as on explicit Beckmann surfaces."""

    starts = (-2.0, -1.0, 0.0, 1.0, 2.0, np.inf)
    edges = np.concatenate([[-np.inf], np.linspace(-4, 4, 33), [np.inf]])

    def t(self, h: Array | float) -> Array:
        return -log_ndtr(h)


@dataclass(frozen=True)
class Skewed:
    """Of the surfaces that `surfaces.marginal` makes of a Gaussian field."""

    marginal: Marginal
    edges = Gaussian.edges

    @property
    def starts(self) -> tuple[float, ...]:
        finite = self.marginal.heights(np.array(Gaussian.starts[:-1]))
        return *finite.tolist(), np.inf

    def t(self, h: Array | float) -> Array:
        return -log_ndtr(self.marginal.gaussian(h))


HEIGHTS: dict[str, Heights] = {"uniform": Uniform(), "gaussian": Gaussian()}


def height_distribution(name: str) -> Heights:
    """One of `HEIGHTS`, or those of ridges or pits. Raises ValueError for a name that is none."""
    return HEIGHTS[name] if name in HEIGHTS else Skewed(marginal(name))
