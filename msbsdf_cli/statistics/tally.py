"""One accumulator for both producers: batches of leaving light become energies, moments and lobes.

A tally keeps, for every quantity, the sum over independent units and the sum of squares, and
nothing else; so its size does not depend on the number of samples. For the random walk a unit is a
walk; on explicit surfaces rays that met the same surface are not independent, and a unit is a
realisation of the surface (`Tally.as_unit`).
"""

from dataclasses import dataclass

import numpy as np

from surfaces.facet import Array
from surfaces.light import Light, sequence_name

THETA_BINS = 30
PHI_BINS = 60
"""Lobes are binned over a hemisphere evenly in polar angle (3 degrees) and azimuth (6 degrees);
the first bin of azimuth is centred on phi = 0, so that the plane of incidence has bins of its own.
"""

MOMENTS = ("x", "y", "z", "xx", "yy", "zz")
SIDES = ("reflected", "transmitted")


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
            "lobe": (orders + 1, 2, THETA_BINS * PHI_BINS),
            "sequence": (2 ** (orders + 1), 2),
            "side": (2,),
            "absorbed": (),
            "unresolved": (),
        }
        size = sum(int(np.prod(shape)) for shape in self._shapes.values())
        self.sums = np.zeros((2, size))
        self.systematic = np.zeros(size)
        """Squares of errors that more units would not make smaller, as `sums`."""
        self._sum, self._square = (self.views(row) for row in self.sums)

    def views(self, row: Array) -> dict[str, Array]:
        """Parts of a row of all figures, by name, in the shapes of `estimate`."""
        views, start = {}, 0
        for name, shape in self._shapes.items():
            end = start + int(np.prod(shape))
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
        if light.transmitted is None:
            self._add_side(light.order, 0, light.w, weight, None)
            return
        for side, here in enumerate((~light.transmitted, light.transmitted)):
            some = None if weight is None else weight.compress(here)
            sequence = None if light.sequence is None else light.sequence.compress(here)
            self._add_side(light.order, side, light.w.compress(here, axis=1), some, sequence)

    def _add(self, name: str, place: tuple[int, ...], values: Array) -> None:
        self._sum[name][place] += values.sum()
        if self.independent:
            self._square[name][place] += values @ values

    def _add_side(
        self, order: int, side: int, w: Array, weight: Array | None, sequence: Array | None
    ) -> None:
        row = min(order, self.orders + 1) - 1
        bins = lobe_bin(w)
        for views, power in ((self._sum, 1), (self._square, 2))[: 1 + self.independent]:
            share = None if weight is None else weight**power
            energy = w.shape[1] if share is None else share.sum()
            views["energy"][row, side] += energy
            views["side"][side] += energy
            views["moments"][row, side] += _moments(w, share, power)
            views["lobe"][row, side] += np.bincount(bins, share, THETA_BINS * PHI_BINS)
            if sequence is not None:
                codes = np.where(order > self.orders, 0, sequence)
                counts = np.bincount(codes, share, 2 ** (self.orders + 1))
                views["sequence"][:, side] += counts

    def as_unit(self) -> "Tally":
        """All rays so far as one independent unit: their mean."""
        unit = Tally(self.orders)
        unit.sums[0] = self.sums[0] / self.rays
        unit.sums[1] = unit.sums[0] ** 2
        unit.units, unit.rays, unit.facets = 1, self.rays, self.facets
        return unit

    def less(self, other: "Tally") -> "Tally":
        """What one unit has more than another of the same light, as a unit."""
        apart = Tally(self.orders)
        apart.sums[0] = self.sums[0] - other.sums[0]
        apart.sums[1] = apart.sums[0] ** 2
        apart.units, apart.rays = 1, self.rays
        return apart

    def merge(self, other: "Tally") -> None:
        """Take in another tally's units."""
        self.sums += other.sums
        self.units += other.units
        self.rays += other.rays
        self.facets += other.facets

    def estimate(self, name: str) -> Estimate:
        """Mean over units and its standard error, with what is `systematic` in it, for one of
        `energy` (orders + 1, sides), `side` (sides), `moments` (orders + 1, sides, 6), `lobe`
        (orders + 1, sides, bins), `sequence` (codes, sides), `absorbed`, `unresolved` (scalars).
        """
        mean = self._sum[name] / self.units
        spread = np.maximum(self._square[name] / self.units - mean * mean, 0)
        # Never having seen something in n rays leaves it uncertain by 1 / n.
        unseen = 1 / self.rays**2 if mean.ndim else 0.0
        with np.errstate(divide="ignore"):
            variance = np.divide(spread, self.units - 1) if self.units > 1 else np.inf + spread
        return Estimate(mean, np.sqrt(variance + unseen + self.views(self.systematic)[name]))


def _moments(w: Array, share: Array | None, power: int) -> Array:
    """Sums of share x (x, y, z, xx, yy, zz)^power over directions (3, n)."""
    first = w if power == 1 else w * w
    second = w * w if power == 1 else first * first
    if share is None:
        return np.concatenate([first.sum(axis=1), second.sum(axis=1)])
    return np.concatenate([first @ share, second @ share])


def lobe_bin(w: Array) -> Array:
    """Bin numbers (n,) of directions (3, n), each hemisphere counted from its own pole."""
    theta = np.arccos(np.minimum(np.abs(w[2]), 1))
    phi = np.arctan2(w[1], w[0])
    row = np.minimum((theta * (2 / np.pi * THETA_BINS)).astype(np.int32), THETA_BINS - 1)
    column = np.floor(phi * (PHI_BINS / (2 * np.pi)) + 0.5).astype(np.int32) % PHI_BINS
    bins: Array = row * PHI_BINS + column
    return bins


def lobe_axes() -> tuple[Array, Array, Array]:
    """Bin centres in polar angle (THETA_BINS,), measured from the pole of the hemisphere, and in
    azimuth (PHI_BINS,), in radians, and solid angles (THETA_BINS,) in steradians."""
    edges = np.linspace(0, np.pi / 2, THETA_BINS + 1)
    solid_angle = -np.diff(np.cos(edges)) * 2 * np.pi / PHI_BINS
    return (edges[1:] + edges[:-1]) / 2, 2 * np.pi / PHI_BINS * np.arange(PHI_BINS), solid_angle


MERGED = 3
"""Bins of a lobe, along each axis, that are put together where noise would drown a difference."""


def merge_bins(values: Array) -> Array:
    """Sums over blocks of bins (theta, phi), the first block centred on the first bin of phi."""
    rows, columns = values.shape
    values = np.roll(values, MERGED // 2, axis=1)
    blocks = values.reshape(rows // MERGED, MERGED, columns // MERGED, MERGED)
    return np.asarray(blocks.sum(axis=(1, 3)))


def merge_sides(lobe: Array) -> Array:
    """Energies (n,) in merged bins of both sides, from those in all bins (2, bins)."""
    return np.concatenate([merge_bins(side.reshape(THETA_BINS, PHI_BINS)).ravel() for side in lobe])


def merged_solid_angle() -> Array:
    """Solid angles (n,) of the bins of `merge_sides`."""
    return merge_sides(np.tile(np.repeat(lobe_axes()[2], PHI_BINS), (2, 1)))


def spread_bins(values: Array) -> Array:
    """Blocks of `merge_bins` as bins (theta, phi) again, each with its block's value."""
    fine = np.repeat(np.repeat(values, MERGED, axis=0), MERGED, axis=1)
    return np.roll(fine, -(MERGED // 2), axis=1)


def sequence_names(orders: int) -> list[str]:
    """Name of each row of `sequence`: `>K` for row 0, then `R`, `T`, `RR`, ... up to K facets."""
    return [f">{orders}", ""] + [sequence_name(code) for code in range(2, 2 ** (orders + 1))]
