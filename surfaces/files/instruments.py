"""Formats of profilers, interferometers, confocal and atomic force microscopes, by
SurfaceTopography, which is in `msbsdf[metrology]`.
"""

from pathlib import Path
from typing import Any

import numpy as np

from surfaces.facet import Array
from surfaces.files._scan import FileError, Scan, check_size, extra

# fmt: off
SUFFIXES = (
    ".al3d", ".bcr", ".bcrf", ".datx", ".ezd", ".frt", ".gwy", ".ibw", ".jpk", ".lext", ".mi",
    ".mnt", ".nid", ".nms", ".oir", ".opd", ".opdx", ".os3d", ".plu", ".plux", ".spm",
    ".sur", ".tmd", ".vk3", ".vk4", ".vk6", ".vk7", ".zmg", ".zon",
)
# fmt: on
METRES = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "um": 1e-6, "nm": 1e-9, "Å": 1e-10, "pm": 1e-12}


def read(path: Path) -> Scan:
    """Heights and steps in metres, where the file names its unit."""
    package: Any = extra("SurfaceTopography", path.suffix)
    try:
        with package.open_topography(str(path)) as reader:
            if path.suffix.lower()[1:] not in reader.file_extensions():
                raise FileError(f"it is a file of the format {reader.format()!r}")
            return _scan(reader)
    except FileError:
        raise
    except Exception as error:
        # Its readers raise whatever their formats make of a damaged file.
        reason = f"{error}" or type(error).__name__
        raise FileError(
            f"SurfaceTopography makes nothing of it ({reason.splitlines()[0]})"
        ) from None


def _scan(reader: Any) -> Scan:
    channel = reader.default_channel
    if channel.dim != 2:
        raise FileError("it holds a profile: a grid of heights is wanted")
    check_size(*channel.nb_grid_pts)
    topography = reader.topography(channel_index=channel.index)
    heights: Array = np.ma.filled(np.ma.asarray(topography.heights(), float), np.nan)
    steps = tuple(float(s) for s in topography.pixel_size)
    unit = METRES.get(topography.unit)
    notes = () if unit else (f"its unit is {topography.unit!r}, and lengths are left in it",)
    scale = unit or 1.0
    step = (steps[0] * scale, steps[1] * scale)
    return Scan(heights * scale, step, notes=notes)
