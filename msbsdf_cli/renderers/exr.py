"""OpenEXR pictures, by the package OpenEXR, an optional extra."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np

from surfaces.facet import Array

MISSING = "OpenEXR is not installed: pip install 'msbsdf[exr]' brings it."


def has_exr() -> bool:
    """Whether OpenEXR is installed."""
    return find_spec("OpenEXR") is not None


def write_exr(path: str | Path, image: Array, names: tuple[str, ...] = ("R", "G", "B")) -> None:
    """Write a linear picture (height, width, channels), a name for each channel, in single
    precision. Raises ImportError where OpenEXR is missing, ValueError for another shape."""
    if image.ndim != 3 or image.shape[2] != len(names):
        raise ValueError(f"a picture of shape {image.shape} has no channels {', '.join(names)}")
    if not has_exr():
        raise ImportError(MISSING)
    import OpenEXR

    channels = {
        name: np.ascontiguousarray(image[..., i], np.float32) for i, name in enumerate(names)
    }
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(str(path))
