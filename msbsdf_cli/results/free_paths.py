"""Distributions of the next facet's height, from independent units."""

from dataclasses import dataclass, field

import numpy as np

from msbsdf_cli.statistics.tally import Estimate
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
    """Sums over units of W x, W^2 x, W^2 x^2, (3, theta, starts, bins + 1), where x is the share of
    rays in a bin, the last bin for those that escaped, and W the weight of the unit."""
    weights: Array = field(init=False)
    """Sums over units of W and W^2, (2, theta, starts)."""
    units: Array = field(init=False)
    """Units with a weight, (theta, starts)."""
    rays: int = 0
    """Rays of each row."""
    moved: "FreePaths | None" = None
    """Of the units that are on a mesh of half the cells too: what they have more on their own, in
    the place of shares."""

    def __post_init__(self) -> None:
        rows = len(self.theta), len(self.starts)
        self.sums = np.zeros((3, *rows, len(self.edges)))
        self.weights = np.zeros((2, *rows))
        self.units = np.zeros(rows, int)

    def empty(self) -> "FreePaths":
        """The same directions, heights and bins, and nothing in them."""
        return FreePaths(self.theta, self.starts, self.edges)

    def add_unit(
        self, share: Array, weight: Array, rays: int, coarser: tuple[Array, Array] | None = None
    ) -> None:
        """Take in one unit: shares (theta, starts, bins + 1) of `rays` rays a row, and weights
        (theta, starts), in proportion to the points that the rays stand for; 0 where none; and
        `coarser`, both on a mesh of half the cells, where they are known."""
        w = weight[..., None]
        self.sums += w * share, w**2 * share, w**2 * share**2
        self.weights += weight, weight**2
        self.units += weight > 0
        self.rays += rays
        if coarser is not None:
            self.moved = self.moved or self.empty()
            self.moved.add_unit(share - coarser[0], np.where(coarser[1] > 0, weight, 0), rays)

    def estimate(self) -> Estimate:
        """Probabilities (theta, starts, bins + 1) and standard errors, those of a ratio of means
        and of the mesh together; not a number for rows with fewer than two units."""
        first, linear, square = self.sums
        total, total2 = self.weights[..., None]
        units = self.units[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            mean = first / total
            spread = np.maximum(square - 2 * mean * linear + mean**2 * total2, 0) / total**2
            square = spread * units / (units - 1) + 1 / self.rays**2 + self._of_mesh()
        return Estimate(mean, np.where(units > 1, np.sqrt(square), np.nan))

    def _of_mesh(self) -> Array | float:
        """Squares of the errors that the mesh makes. They fall with the width of a cell, or faster:
        so it is off by about as much as it differs from a mesh of half as many cells. What is met
        too early is missing in the next bin, and next to the start a coarse mesh can do no worse
        than to meet all there: of neighbouring bins the largest step counts for each."""
        if self.moved is None or self.moved.rays == 0:
            return 0.0
        # With its noise, which is no error of the mesh, but hides what may be one.
        square = np.nan_to_num(self.moved.estimate().value) ** 2
        largest = square.copy()
        # The last of the bins is for those that escape, and has no neighbour.
        bins, near = square[..., :-1], largest[..., :-1]
        np.maximum(near[..., 1:], bins[..., :-1], out=near[..., 1:])
        np.maximum(near[..., :-1], bins[..., 1:], out=near[..., :-1])
        return np.where(self.sums[0] > 0, largest, square)

    def rows(self) -> dict[tuple[float, float], Estimate]:
        """Probabilities (bins + 1,) by direction and height of start, where two units or more had
        points of that height that face that way."""
        found = self.estimate()
        return {
            (theta, start): Estimate(found.value[i, j], found.stderr[i, j])
            for i, theta in enumerate(self.theta)
            for j, start in enumerate(self.starts)
            if not np.isnan(found.stderr[i, j]).any()
        }

    def merge(self, other: "FreePaths") -> None:
        """Take in the units of other free paths. Raises ValueError where directions, heights or
        bins differ."""
        if (self.theta, self.starts) != (other.theta, other.starts) or not np.array_equal(
            self.edges, other.edges
        ):
            raise ValueError("the free paths are of other directions, heights or bins.")
        self.sums += other.sums
        self.weights += other.weights
        self.units += other.units
        self.rays += other.rays
        if other.moved is not None:
            self.moved = self.moved or self.empty()
            self.moved.merge(other.moved)
