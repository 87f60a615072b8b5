"""The two formats of ISO 25178: SDF of part 71, by sdfio, and X3P of part 72, by x3pio.

Both packages are in `msbsdf[metrology]`.
"""

from pathlib import Path
from typing import Any

import numpy as np

from surfaces.files._scan import FileError, Scan, check_size, extra

SUFFIXES = (".sdf", ".x3p")


def read(path: Path) -> Scan:
    """Heights and steps in metres, as the standards have them."""
    kind = path.suffix.lower()
    reader: Any = extra(f"{kind[1:]}io", kind)
    if kind == ".sdf":
        file = reader.read(path)
        rows, step = file.data, (file.header.x_scale, file.header.y_scale)
    else:
        check_size(*reader.info(path).shape)
        file = reader.read(path)
        if file.feature_type.name != "SURFACE" or len(file.layers) != 1:
            raise FileError(
                f"it holds a {file.feature_type.name.lower()} of {len(file.layers)} layers: a "
                "surface of one is wanted"
            )
        rows, step = file.layers[0].z, file.layers[0].spacing
    # Rows run along x, the first at the least y.
    return Scan(np.ascontiguousarray(rows.T, float), (float(step[0]), float(step[1])))
