"""What a run of either producer comes to, and the free paths in it."""

from dataclasses import dataclass, field

import numpy as np

from msbsdf_cli.tally import Estimate, Tally
from surfaces.facet import Array


@dataclass
class FreePaths:
    """Distribution of the next facet's height, for directions of travel and heights of start."""

    theta: tuple[float, ...]
    """Polar angles of travel in radians."""
    starts: tuple[float, ...]
    """Heights of start, in standard deviations or as the height distribution has them."""
    edges: Array
    """Edges (bins + 1,) of the height bins."""
    sums: Array = field(init=False)
    """Sum and sum of squares over units, (2, theta, starts, bins + 1); last bin: escaped."""
    units: int = 0
    rays: int = 0
    """Rays of each row."""

    def __post_init__(self) -> None:
        shape = (len(self.theta), len(self.starts), len(self.edges))
        self.sums = np.zeros((2, *shape))

    def add_unit(self, share: Array, rays: int) -> None:
        """Take in one unit's shares (theta, starts, bins + 1) of `rays` rays each."""
        self.sums += share, share * share
        self.units += 1
        self.rays += rays

    def estimate(self) -> Estimate:
        """Probabilities (theta, starts, bins + 1) and their standard errors."""
        mean, square = self.sums / self.units
        spread = np.maximum(square - mean * mean, 0)
        return Estimate(mean, np.sqrt(spread / (self.units - 1) + 1 / self.rays**2))


@dataclass
class Outcome:
    """Tallies, one for each incident angle, free paths, and how the run went."""

    tallies: list[Tally]
    free_paths: FreePaths
    wall_s: float = 0.0
    notes: dict[str, float] = field(default_factory=dict)
    """Figures of the run worth keeping beside the results."""
    warnings: list[str] = field(default_factory=list)

    @property
    def paths(self) -> int:
        """Rays or walks finished."""
        return sum(tally.rays for tally in self.tallies)

    @property
    def bounces_mean(self) -> float:
        """Facets hit by a ray or walk, in the mean."""
        return sum(tally.facets for tally in self.tallies) / self.paths
