"""What a surface is like: its roughness in the field's own figures, each with an error bar."""

from dataclasses import dataclass

import numpy as np

from surfaces.describe.correlation import correlation_lengths
from surfaces.describe.fits import fits
from surfaces.describe.moments import height_parameters, slope_parameters
from surfaces.describe.optics import optics_warnings
from surfaces.describe.quantities import Quantity
from surfaces.describe.scales import over_filter_length
from surfaces.patch import Patch

__all__ = ["Description", "Patch", "Quantity", "describe"]

FEW_AREAS = 100
"""Correlation areas below which the error bars themselves are in doubt."""


@dataclass(frozen=True)
class Description:
    """The rows of roughness.csv, and sentences on what does not hold."""

    rows: list[Quantity]
    warnings: list[str]

    def __getitem__(self, quantity: str) -> Quantity:
        return next(row for row in self.rows if row.quantity == quantity)

    def to_columns(self) -> dict[str, list[str | float]]:
        """The rows as columns by name; no text where a figure is not known."""
        names = ("quantity", "value", "stderr", "unit", "note")
        columns = {name: [getattr(row, name) for row in self.rows] for name in names}
        return {name: ["" if x != x else x for x in column] for name, column in columns.items()}


def describe(patch: Patch, unit: str = "", wavelength: float | None = None) -> Description:
    """Height parameters, slopes, correlation and fitted distributions of a patch.

    `unit` names that of heights and steps; error bars say how far another patch of the same
    surface may be off. With a `wavelength`, in the same unit, warnings say where geometrical
    optics does not hold.
    """
    lengths = correlation_lengths(patch, unit)
    length = lengths[0].value
    area = np.prod(np.array(patch.heights.shape) * patch.step)
    areas = float(area / length**2)
    slopes_both_ways = min(float(slope.std()) for slope in patch.slopes) > 0
    scale = f"facets of {patch.step[0]:.6g} by {patch.step[1]:.6g} {unit}".rstrip()
    rows = [
        *height_parameters(patch, unit),
        *slope_parameters(patch),
        *lengths,
        Quantity("correlation_areas", areas, float("nan"), "", "of the patch"),
        *(fits(patch.slopes) if slopes_both_ways else ()),
        *over_filter_length(patch, length, unit),
    ]
    warnings = []
    if not slopes_both_ways:
        warnings.append("slopes along one axis are all the same: no distribution is fitted.")
    if not areas >= FEW_AREAS:
        warnings.append(
            f"the patch has {areas:.2g} correlation areas: with fewer than {FEW_AREAS} its error "
            "bars are too short."
            if areas == areas
            else "heights correlate over more than half of the patch: it is too small to describe."
        )
    if wavelength is not None:
        warnings += optics_warnings(patch, length, wavelength)
    rows = [row if row.quantity != "sdq" else _with_scale(row, scale) for row in rows]
    return Description(rows, warnings)


def _with_scale(row: Quantity, scale: str) -> Quantity:
    return Quantity(row.quantity, row.value, row.stderr, row.unit, f"{row.note}, of {scale}")
