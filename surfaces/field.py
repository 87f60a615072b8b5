"""A heightfield as the user has it: heights on a grid, and how far apart they are."""

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256

import numpy as np

from surfaces.facet import Array
from surfaces.heightfield import all_waves, synthesise
from surfaces.streams import stream
from surfaces.stretch import Stretch
from surfaces.surface import Surface, shortened

LEAST = 4
"""Points along either side, below which there is no surface to speak of."""


@dataclass(frozen=True, eq=False)
class HeightField:
    """One period of a surface that goes on for ever: heights (n, n) at the points of a square grid.

    Heights and steps are in one unit, whichever. Raises ValueError for what is no such grid.
    """

    heights: Array
    """heights[i, j] at x = i step_x, y = j step_y."""
    step: tuple[float, float]
    """Distance of the points along x and y."""
    isotropic_grid: bool = False
    """Whether the field is statistically the same in every direction of its grid, as random ones
    are: light then crosses the grid where the period matters least."""

    def __post_init__(self) -> None:
        heights = np.asarray(self.heights, float)
        if heights.ndim != 2 or heights.shape[0] != heights.shape[1] or len(heights) < LEAST:
            raise ValueError(
                f"the heights have the shape {heights.shape}: a square grid of at least "
                f"{LEAST} x {LEAST} points is wanted."
            )
        if not np.isfinite(heights).all():
            missing = np.count_nonzero(~np.isfinite(heights))
            raise ValueError(f"{missing} of {heights.size} heights are not finite.")
        if len(self.step) != 2 or not all(0 < s < np.inf for s in self.step):
            raise ValueError(f"the step is {self.step}: two finite numbers above 0 are wanted.")
        object.__setattr__(self, "heights", heights)

    @classmethod
    def random(
        cls,
        alpha: float | tuple[float, float] = 0.5,
        seed: int = 0,
        extent: int = 12,
        cells: int = 16,
    ) -> "HeightField":
        """A Gaussian field of height variance 1 and Beckmann slopes of roughness `alpha` (Heitz
        2015), of `extent` correlation lengths with `cells` cells each.

        The mesh is shortened by a trifle, so that its facets have the slope variance alpha^2 / 2.
        Raises ValueError for a roughness that is not above 0.
        """
        alphas = (alpha, alpha) if isinstance(alpha, int | float) else tuple(alpha)
        if len(alphas) != 2 or not all(0 < a < np.inf for a in alphas):
            raise ValueError(f"alpha is {alpha}: one or two finite numbers above 0 are wanted.")
        waves = all_waves(extent, stream(seed, "heightfield", 0, extent, 0))
        heights = synthesise(waves, extent, cells)
        step_x, step_y = (2 / (a * shortened(cells)) for a in alphas)
        return cls(heights, (step_x, step_y), isotropic_grid=True)

    @cached_property
    def _scale(self) -> float:
        """Standard deviation of the heights; tracing has it as the unit."""
        return float(self.heights.std()) or 1.0

    @cached_property
    def surface(self) -> Surface:
        """The mesh to trace on, heights in standard deviations."""
        heights = self.heights / self._scale
        # A mesh wants an even number of cells; two periods are as good as one.
        return Surface(np.tile(heights, (2, 2)) if len(heights) % 2 else heights, 1)

    def stretch(self, phi: float) -> Stretch:
        """From the world to the mesh's grid, for light of azimuth `phi`."""
        cells = self._scale / self.step[0], self._scale / self.step[1]
        return Stretch.of(*cells, phi if self.isotropic_grid else None)

    def fingerprint(self) -> str:
        """A text that tells this field from any other."""
        return sha256(self.heights.tobytes() + repr(self.step).encode()).hexdigest()[:16]
