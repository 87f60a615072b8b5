"""A heightfield as the user has it: heights on a grid, and how far apart they are."""

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from surfaces.facet import Array
from surfaces.heightfield import all_waves, shortened, synthesise
from surfaces.levelling import levelled
from surfaces.marginal import marginal
from surfaces.patch import Patch
from surfaces.spectrum import spectrum
from surfaces.streams import stream
from surfaces.stretch import Stretch
from surfaces.surface import Surface, faces
from surfaces.tracing import morton

if TYPE_CHECKING:
    from trimesh import Trimesh

    from surfaces.describe import Description

LEAST = 4
"""Points along either side, below which there is no surface to speak of."""


@dataclass(frozen=True, eq=False)
class HeightField:
    """A surface that goes on for ever: heights (nx, ny) at the points of a grid, one period of it
    or a patch that its mirror images continue.

    Heights and steps are in one unit, whichever. Raises ValueError for what is no such grid.
    """

    heights: Array
    """heights[i, j] at x = i step_x, y = j step_y."""
    step: tuple[float, float]
    """Distance of the points along x and y."""
    isotropic_grid: bool = False
    """Whether the field is statistically the same in every direction of its grid, as random ones
    are: light then crosses the grid where the period matters least."""
    periodic: bool = True
    """Whether the heights are a whole period. Those of a patch are continued by its mirror images,
    which meet it without a step, and rays start on the patch itself."""
    notes: tuple[str, ...] = ()
    """Sentences on what was made of a file."""
    unit: float | None = None
    """Of heights where light is traced; None: their standard deviation."""

    def __post_init__(self) -> None:
        heights = np.asarray(self.heights, float)
        if heights.ndim != 2 or min(heights.shape) < LEAST:
            raise ValueError(
                f"the heights have the shape {heights.shape}: a grid of at least "
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
        autocorrelation: str = "gaussian",
        heights_of: str = "gaussian",
    ) -> "HeightField":
        """A Gaussian field of height variance 1 and Beckmann slopes of roughness `alpha` (Heitz
        2015), of `extent` times 2 / alpha with `cells` cells each.

        `autocorrelation` is `gaussian`, whose correlation length is 2 / alpha, `exponential`,
        `matern:NU` or `power-law:H`. With `heights_of` as `ridges:S` or `pits:S` heights have the
        skewness S or -S, and slopes are not Beckmann's. The mesh is stretched so that its facets
        have the slope variance alpha^2 / 2. Raises ValueError for a roughness that is not above 0,
        an autocorrelation or a distribution of heights that is none.
        """
        alphas = (alpha, alpha) if isinstance(alpha, int | float) else tuple(alpha)
        if len(alphas) != 2 or not all(0 < a < np.inf for a in alphas):
            raise ValueError(f"alpha is {alpha}: one or two finite numbers above 0 are wanted.")
        kind, heights_are = spectrum(autocorrelation), marginal(heights_of)
        waves = all_waves(extent, stream(seed, "heightfield", 0, extent, 0), kind)
        heights = heights_are.heights(synthesise(waves, extent, cells))
        per_length = shortened(cells, extent, kind, heights_are)
        step_x, step_y = (2 / (a * per_length) for a in alphas)
        return cls(heights, (step_x, step_y), isotropic_grid=True)

    @classmethod
    def load(
        cls,
        path: str | Path,
        step: float | tuple[float, float] | None = None,
        height_unit: float | None = None,
        periodic: bool = False,
        detrend: int = 1,
        filter_length: float | None = None,
    ) -> "HeightField":
        """Heights from a file: an array (.npy, .npz), text, a picture (PNG, TIFF), a mesh (STL,
        PLY, OBJ), or what an instrument wrote.

        `step` is the distance of the points along x and y, and `height_unit` what a height of 1 in
        the file is in the unit of `step`; each is wanted where the file does not say it. A field
        that is not `periodic` is levelled by a polynomial of degree `detrend` (1: a plane), and
        continued by its mirror images. With a `filter_length` what is shorter is smoothed away, by
        the Gaussian filter of ISO 16610. Raises ValueError for what cannot be used.
        """
        from surfaces.files import read

        scan = read(path, step, height_unit)
        assert scan.step is not None
        heights, notes = _one_period(scan.heights) if periodic else (scan.heights, ())
        patch = Patch(heights if periodic else levelled(heights, detrend), scan.step, periodic)
        if not np.ptp(patch.heights) > ROUNDING * np.ptp(heights):
            raise ValueError(
                f"{path}: levelling leaves nothing of its heights: a surface without roughness."
            )
        if filter_length is not None:
            before, patch = patch, patch.filtered(filter_length)
            if not np.ptp(patch.heights) > ROUNDING * np.ptp(before.heights):
                raise ValueError(
                    f"{path}: a filter of length {filter_length:g} leaves nothing of its heights."
                )
        return cls(patch.heights, scan.step, periodic=periodic, notes=scan.notes + notes)

    def piece(self, number: int, of: int) -> tuple[int, int]:
        """Where rays start on the mesh for the piece `number` of `of` equal ones of the surface,
        as `surfaces.tracing.Tracer.trace` takes it."""
        return number, of if self.periodic else 4 * of

    def window(self, number: int, of: int) -> "HeightField":
        """The piece `number` of `of` = 4^m equal ones, with half as much around it on all sides,
        as a period of its own, so that no more need be meshed to trace the light on one piece.

        The piece is its first quarter, as `piece(0, 4)` has it. Where light leaves the window it
        comes to the other end of it, as far away as the window is wide.
        """
        side = round(of**0.5)
        corner = np.rint(morton(np.array([number / of]))[:, 0] * side).astype(int)
        rows = []
        for n, k in zip(self.heights.shape, corner, strict=True):
            cells = n if self.periodic else n - 1
            size = -(-cells // side)
            place = k * cells // side + (np.arange(2 * size) + size // 2) % (2 * size) - size // 2
            turned = place % (cells if self.periodic else 2 * cells)
            rows.append(turned if self.periodic else np.minimum(turned, 2 * cells - turned))
        return HeightField(self.heights[np.ix_(*rows)], self.step, unit=self._scale)

    @property
    def patch(self) -> Patch:
        """The heights, and whether they go on at their sides."""
        return Patch(self.heights, self.step, self.periodic)

    def describe(self, unit: str = "", wavelength: float | None = None) -> "Description":
        """Height parameters, slopes, correlation and fitted slope distributions, with error bars
        that say how far another piece of the same surface may be off; `unit` names that of the
        heights, in which the `wavelength` is, for which warnings say what geometrical optics
        leaves out."""
        from surfaces.describe import describe

        return describe(self.patch, unit, wavelength)

    @cached_property
    def _scale(self) -> float:
        return self.unit or float(self.heights.std()) or 1.0

    @cached_property
    def surface(self) -> Surface:
        """The mesh to trace on, heights in standard deviations."""
        heights = self.heights / self._scale
        if not self.periodic:
            return Surface(continued(heights), 1)
        # A mesh wants an even number of cells; two periods are as good as one.
        return Surface(np.tile(heights, [1 + n % 2 for n in heights.shape]), 1)

    def mesh(self) -> "Trimesh":
        """The heights as a mesh; one of a whole period has its first points at its end again."""
        import trimesh

        h = np.pad(self.heights, (0, 1), mode="wrap") if self.periodic else self.heights
        along = (np.arange(n) * s for n, s in zip(h.shape, self.step, strict=True))
        x, y = np.meshgrid(*along, indexing="ij")
        vertices = np.stack([x, y, h], axis=-1).reshape(-1, 3)
        return trimesh.Trimesh(vertices, faces(*h.shape), process=False, validate=False)

    def stretch(self, phi: float) -> Stretch:
        """From the world to the mesh's grid, for light of azimuth `phi`."""
        cells = self._scale / self.step[0], self._scale / self.step[1]
        return Stretch.of(*cells, phi if self.isotropic_grid else None)

    def fingerprint(self) -> str:
        """A text that tells this field from any other."""
        about = repr((self.heights.shape, self.step, self.periodic)).encode()
        return sha256(self.heights.tobytes() + about).hexdigest()[:16]


def continued(heights: Array) -> Array:
    """A period (2 nx - 2, 2 ny - 2) of a patch continued by its mirror images, which share its
    outermost points: were these there twice, flat facets would lie between them."""
    return np.pad(heights, [(0, n - 2) for n in heights.shape], mode="reflect")


def _one_period(heights: Array) -> tuple[Array, tuple[str, ...]]:
    """Heights less their mean, and without a last row or column that repeats the first, as meshes
    of a whole period have."""
    span, cut = np.ptp(heights), []
    for axis in (0, 1):
        first, last = heights.take(0, axis), heights.take(-1, axis)
        if np.abs(last - first).max() <= REPEATED * span and heights.shape[axis] > LEAST:
            heights = np.delete(heights, -1, axis)
            cut.append("xy"[axis])
    notes = (f"the last points along {' and '.join(cut)} repeat the first and were left out",)
    return heights - heights.mean(), notes if cut else ()


ROUNDING = 1e-12
"""Of heights that were levelled, or transformed and back."""

REPEATED = 1e-6
"""Of the height of a surface: single precision of files."""
