"""A rectangle of a surface, the slopes of its facets, and what it looks like to a coarser eye."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from surfaces.facet import Array


@dataclass(frozen=True, eq=False)
class Patch:
    """Levelled heights (nx, ny), and the distance of their points."""

    heights: Array
    step: tuple[float, float]
    periodic: bool = False

    @cached_property
    def slopes(self) -> Array:
        """Slopes (2, nx, ny) of one facet of each cell: that with the corner (1, 0) of the cell, as
        the mesh has it.

        Diagonals of cells alternate there, so that slopes along x and y do not correlate on their
        account. A patch that is not periodic has one cell less each way.
        """
        h = np.pad(self.heights, (0, 1), mode="wrap") if self.periodic else self.heights
        i, j = np.ogrid[: h.shape[0] - 1, : h.shape[1] - 1]
        along_x, along_y = np.diff(h, axis=0), np.diff(h, axis=1)
        slopes = np.empty((2, h.shape[0] - 1, h.shape[1] - 1))
        slopes[0] = along_x[:, :-1] / self.step[0]
        slopes[1] = np.where((i + j) & 1, along_y[:-1], along_y[1:]) / self.step[1]
        return slopes

    def filtered(self, cutoff: float) -> "Patch":
        """The patch without what is shorter than the wavelength `cutoff`.

        By the areal Gaussian filter of ISO 16610-61 (the profile filter of ISO 16610-21 along each
        axis), which lets half of the amplitude at the cut-off pass. At its sides a patch is
        continued by its mirror images.
        """
        # Here, since scipy.fft takes longer to import than most of what needs no filter.
        from scipy.fft import dctn, fftn, idctn, ifftn

        if not 0 < cutoff < np.inf:
            raise ValueError(f"the filter length is {cutoff}: a finite number above 0 is wanted.")
        shape = self.heights.shape
        if self.periodic:
            waves = [np.fft.fftfreq(n, s) for n, s in zip(shape, self.step, strict=True)]
            passed = np.multiply.outer(*(_transmission(k * cutoff) for k in waves))
            return Patch(ifftn(fftn(self.heights) * passed).real, self.step, True)
        waves = [np.arange(n) / (2 * n * s) for n, s in zip(shape, self.step, strict=True)]
        passed = np.multiply.outer(*(_transmission(k * cutoff) for k in waves))
        return Patch(idctn(dctn(self.heights) * passed), self.step)


def _transmission(waves: Array) -> Array:
    """Of amplitudes, by cut-off over wavelength: one half at 1."""
    return np.exp2(-(waves**2))
