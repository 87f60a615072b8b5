"""One accumulator for both producers: batches of leaving light become energies, moments and lobes.

A tally keeps, for every quantity, the sum over independent units and the sum of squares, and
nothing else; so its size does not depend on the number of samples. For the random walk a unit is a
walk; on explicit surfaces rays that met the same surface are not independent, and a unit is a
realisation of the surface (`Tally.as_unit`).
"""

from dataclasses import dataclass
from math import prod

import numpy as np

from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, lobe_bin
from surfaces.facet import Array
from surfaces.light import Light, sequence_name

BINS = THETA_BINS * PHI_BINS
"""Of the lobe on one side."""

MOST_ORDERS = 10
"""Told apart: there are 2 to that power histories of reflection and transmission, and more."""

MOMENTS = ("x", "y", "z", "xx", "yy", "zz")
SIDES = ("reflected", "transmitted")
REST = ("absorbed", "unresolved")
"""What else becomes of light than that it leaves."""


@dataclass(frozen=True)
class Estimate:
    """A mean and its standard error, arrays of one shape."""

    value: Array
    stderr: Array


class Tally:
    """Sums over units of what leaves, per order 1..`orders` and all later ones, and side.

    `independent` says that each ray is a unit of its own; otherwise `as_unit` makes one of all.
    """

    def __init__(self, orders: int, independent: bool = True) -> None:
        self.orders = orders
        self.independent = independent
        self.units = 0
        """Independent units summed."""
        self.rays = 0
        """Rays or walks, each of energy 1."""
        self.facets = 0
        """Facets hit by all of them."""
        self._shapes = {
            "energy": (orders + 1, 2),
            "moments": (orders + 1, 2, len(MOMENTS)),
            "lobe": (orders + 1, 2, BINS),
            "sequence": (2 ** (orders + 1), 2),
            "side": (2,),
            "absorbed": (),
            "unresolved": (),
        }
        size = sum(prod(shape) for shape in self._shapes.values())
        self.sums = np.zeros((2, size))
        self._sum, self._square = (self.views(row) for row in self.sums)

    def views(self, row: Array) -> dict[str, Array]:
        """Parts of a row of all figures, by name, in the shapes of `estimate`."""
        views, start = {}, 0
        for name, shape in self._shapes.items():
            end = start + prod(shape)
            views[name] = row[start:end].reshape(shape)
            start = end
        return views

    def add(self, light: Light) -> None:
        """Count light of one order; every ray must come once, with its first channel's weight."""
        n = light.w.shape[1]
        self.rays += n
        self.facets += n * light.order
        if self.independent:
            self.units += n
        weight = None if light.weight is None else light.weight[0]
        if weight is not None:
            self._add("absorbed", (), 1 - weight)
        if not light.resolved:
            self._add("unresolved", (), np.ones(n) if weight is None else weight)
            return
        self._add_resolved(light, weight)

    def _add(self, name: str, place: tuple[int, ...], values: Array) -> None:
        self._sum[name][place] += values.sum()
        if self.independent:
            self._square[name][place] += values @ values

    def _add_resolved(self, light: Light, weight: Array | None) -> None:
        row, below = min(light.order, self.orders + 1) - 1, light.transmitted
        bins, codes = lobe_bin(light.w), light.sequence
        if below is not None:
            bins += below * BINS
        if codes is not None and below is not None:
            codes = 2 * (codes if light.order <= self.orders else np.zeros_like(codes)) + below
        rows = _powers(light.w)
        for views, power in ((self._sum, 1), (self._square, 2))[: 1 + self.independent]:
            if power == 1 or weight is not None:
                share = weight if weight is None or power == 1 else weight * weight
                sides, sums = _sums(rows, share, below)
                lobe = np.bincount(bins, share, 2 * BINS).reshape(2, -1)
                if codes is not None:
                    count = np.bincount(codes, share, 2 ** (self.orders + 2)).reshape(-1, 2)
            views["energy"][row] += sides
            views["side"] += sides
            first = len(light.w) * (power - 1)
            views["moments"][row] += sums[:, first : first + len(MOMENTS)]
            views["lobe"][row] += lobe
            if codes is not None:
                views["sequence"][:] += count

    def as_unit(self) -> "Tally":
        """All rays so far as one independent unit: their mean."""
        unit = Tally(self.orders)
        unit.sums[0] = self.sums[0] / self.rays
        unit.sums[1] = unit.sums[0] ** 2
        unit.units, unit.rays, unit.facets = 1, self.rays, self.facets
        return unit

    def merge(self, other: "Tally") -> None:
        """Take in another tally's units."""
        self.sums += other.sums
        self.units += other.units
        self.rays += other.rays
        self.facets += other.facets

    def arrays(self) -> dict[str, Array]:
        """All that it holds, to be saved."""
        return {"counts": np.array([self.units, self.rays, self.facets]), "sums": self.sums}

    def restore(self, arrays: dict[str, Array]) -> None:
        """Take in what `arrays` gave. Raises KeyError or ValueError where it does not fit."""
        self.units, self.rays, self.facets = arrays["counts"].tolist()
        self.sums[:] = arrays["sums"]

    def estimate(self, name: str) -> Estimate:
        """Mean over units and its standard error, for one of `energy` (orders + 1, sides), `side`
        (sides), `moments` (orders + 1, sides, 6), `lobe` (orders + 1, sides, bins), `sequence`
        (codes, sides), `absorbed`, `unresolved` (scalars).
        """
        value, variance = (self.views(row)[name] for row in self.figures())
        return Estimate(value, np.sqrt(variance))

    def figures(self) -> tuple[Array, Array]:
        """Means of all figures over units, and their squared standard errors: rows for `views`."""
        mean = self.sums[0] / self.units
        spread = np.maximum(self.sums[1] / self.units - mean * mean, 0)
        with np.errstate(divide="ignore"):
            variance = np.divide(spread, self.units - 1) if self.units > 1 else np.inf + spread
        return mean, variance + self.unseen()

    def unseen(self) -> Array:
        """Squared errors of never having seen something: in n rays 1 / n."""
        squares = np.full(self.sums.shape[1], 1 / self.rays**2)
        for name in REST:
            self.views(squares)[name][...] = 0
        return squares


def combination(*parts: tuple[float, Tally]) -> Tally:
    """A unit of the sum of factors times the figures of units, all of the same rays."""
    first = parts[0][1]
    unit = Tally(first.orders)
    unit.sums[0] = sum(factor * part.sums[0] for factor, part in parts)
    unit.sums[1] = unit.sums[0] ** 2
    unit.units, unit.rays = 1, first.rays
    return unit


def _powers(w: Array) -> Array:
    """Components of directions (3, n), their squares, and the squares of these, (9, n): moments are
    sums of the first six, and their squares of the last six."""
    rows = np.empty((9, w.shape[1]), w.dtype)
    rows[:3] = w
    np.multiply(rows[:3], rows[:3], out=rows[3:6])
    np.multiply(rows[3:6], rows[3:6], out=rows[6:])
    return rows


def _sums(rows: Array, share: Array | None, below: Array | None) -> tuple[Array, Array]:
    """Sums of `share` (n,), 1 if None, by side (2,), and of its products with `rows` (9, n) by side
    (2, 9); `below` tells the side."""
    sides, sums = np.zeros(2), np.zeros((2, len(rows)))
    if below is None:
        sides[0] = rows.shape[1] if share is None else share.sum()
        sums[0] = rows.sum(axis=1) if share is None else rows @ share
        return sides, sums
    shares = np.empty((2, rows.shape[1]), rows.dtype)
    shares[1] = below if share is None else below * share
    np.subtract(1 if share is None else share, shares[1], out=shares[0])
    return shares.sum(axis=1), shares @ rows.T


def sequence_names(orders: int) -> list[str]:
    """Name of each row of `sequence`: `>K` for row 0, then `R`, `T`, `RR`, ... up to K facets."""
    return [f">{orders}", ""] + [sequence_name(code) for code in range(2, 2 ** (orders + 1))]
