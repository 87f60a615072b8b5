"""Height maps as pictures of one channel: PNG and TIFF, of 8, 16 or 32 bits.

A grey level is no height, and a pixel no length: both are for the user to say. x goes to the right
of the picture, and y up.
"""

import warnings
from pathlib import Path

import numpy as np

from surfaces.files._scan import FileError, Scan, as_seen, check_size

SUFFIXES = (".png", ".tif", ".tiff")
BITS = {"L": 8, "I;16": 16, "I;16B": 16, "I;16L": 16, "I;16N": 16, "I": 32, "F": 32}
"""Of a pixel, by Pillow's name of the mode."""


def read(path: Path) -> Scan:
    """Grey levels; floating-point ones are heights already."""
    from PIL import Image

    kind = "PNG" if path.suffix.lower() == ".png" else "TIFF"
    with warnings.catch_warnings():
        # Of many pixels, which are refused below, before any is read.
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        image = Image.open(path, formats=[kind])
    with image:
        check_size(*image.size)
        if image.mode not in BITS:
            raise FileError(
                f"its pixels are of the mode {image.mode}: a height map has one channel of grey"
            )
        if (frames := getattr(image, "n_frames", 1)) > 1:
            raise FileError(f"it holds {frames} pictures: one is wanted")
        levels = np.asarray(image, float)
        notes = []
        if BITS[image.mode] == 8:
            notes.append("it has 256 grey levels only, and slopes come in steps of one")
        return Scan(as_seen(levels), None, 1.0 if image.mode == "F" else None, tuple(notes))
