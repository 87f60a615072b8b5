"""The bins of lobes: which one a direction falls into, where they lie, and how they merge."""

import numpy as np

from surfaces.facet import Array

THETA_BINS = 30
PHI_BINS = 60
"""Lobes are binned over a hemisphere evenly in polar angle (3 degrees) and azimuth (6 degrees);
the first bin of azimuth is centred on phi = 0, so that the plane of incidence has bins of its own.
"""


class Bins:
    """Bins of numbers from `low` to `high` between ascending `edges`, by a table.

    The range is cut into even cells, so small that no two edges lie in one: a number's cell, and
    whether the number is beyond the edge there, tell its bin.
    """

    def __init__(self, edges: Array, low: float, high: float, names: Array) -> None:
        """`names` (edges + 1,) are the bins' numbers."""
        cells = int(np.ceil((high - low) / np.diff(edges).min())) + 1
        starts = low + (high - low) / cells * np.arange(cells + 1)
        first = np.searchsorted(edges, starts, side="right")
        self._low, self._per_unit = low, cells / (high - low)
        edge = np.append(edges, np.inf)[first]
        # In single precision the least number that is not below the edge, which bins alike.
        single = edge.astype(np.float32)
        single = np.where(single < edge, np.nextafter(single, np.float32(np.inf)), single)
        self._edges = {edge.dtype: edge, single.dtype: single}
        self._names = names[np.minimum(first[:, None] + [0, 1], edges.size)].ravel()

    def __call__(self, x: Array) -> Array:
        """Numbers (n,) of the bins of `x` (n,); that of an edge is the bin which starts there."""
        place = x - self._low
        place *= self._per_unit
        cell = place.astype(np.intp)
        beyond = x >= self._edges[x.dtype].take(cell)
        cell *= 2
        cell += beyond
        found: Array = self._names.take(cell)
        return found


def _azimuth(phi: Array) -> Array:
    """What stands in for an azimuth from -pi/2 to 3 pi/2, and rises with it from -1 to 3."""
    x, y = np.cos(phi), np.sin(phi)
    side = y / (np.abs(x) + np.abs(y))
    return np.where(phi > np.pi / 2, 2 - side, side)


_ROW = Bins(
    np.cos(np.pi / 2 / THETA_BINS * np.arange(THETA_BINS - 1, 0, -1)),
    0.0,
    1.0,
    np.arange(THETA_BINS)[::-1] * PHI_BINS,
)
_QUARTER = PHI_BINS // 4
_COLUMN = Bins(
    _azimuth(2 * np.pi / PHI_BINS * (np.arange(-_QUARTER, 3 * _QUARTER) + 0.5)),
    -1.0,
    3.0,
    np.arange(-_QUARTER, 3 * _QUARTER + 1) % PHI_BINS,
)


def lobe_bin(w: Array) -> Array:
    """Bin numbers (n,) of directions (3, n), each hemisphere counted from its own pole."""
    x, y = w[0], w[1]
    width = np.abs(x) + np.abs(y)
    # At the pole, where there is no azimuth, the first bin.
    np.maximum(width, np.finfo(w.dtype).tiny, out=width)
    # y / width, or 2 less that where x < 0: signs at random are no good to `np.where`.
    azimuth = y / width
    azimuth -= 1
    azimuth *= np.copysign(w.dtype.type(1), x)
    azimuth += 1
    bins = _ROW(np.minimum(np.abs(w[2]), 1))
    bins += _COLUMN(azimuth)
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
