"""Uniform random numbers that are now and then at the ends of their range."""

from typing import Any

import numpy as np

from surfaces.facet import Array

SHARE = 0.05
"""Share of numbers at an end: so many that every function meets them, and so few that a rejection
ends."""

ENDS = ("0", "near 1", "both")


class Extremes:
    """A generator whose numbers are those of another, but for a share that is at an end.

    NumPy draws from [0, 1): the ends are 0 and the last number below 1. `closed` adds 1 itself,
    which some libraries of other languages draw.
    """

    def __init__(self, rng: np.random.Generator, ends: str, closed: bool) -> None:
        self.rng, self.ends, self.closed = rng, ends, closed

    def random(self, size: Any = None, dtype: Any = np.float64) -> Array:
        """As NumPy's."""
        u = np.asarray(self.rng.random(size, dtype=dtype))
        chosen = self.rng.random(u.shape)
        last = 1.0 if self.closed else 1 - np.finfo(u.dtype).epsneg
        low = SHARE if self.ends == "0" else SHARE / 2 if self.ends == "both" else 0.0
        u = np.where(chosen < low, 0, u)
        return np.where((chosen >= low) & (chosen < SHARE), last, u).astype(u.dtype)

    def standard_exponential(self, size: Any = None, dtype: Any = np.float64) -> Array:
        """By inversion, so that the ends are met here too."""
        with np.errstate(divide="ignore"):
            return np.asarray(-np.log(1 - self.random(size, dtype)))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.rng, name)
