"""What a walk remembers, told without loading what that takes."""

from typing import NamedTuple

from surfaces.spectrum import GAUSSIAN, Spectrum

MOST = 2
"""The most that walks remember."""

TAKES = 1, 10, 40
"""Times as long as Smith's a walk takes that remembers so much, about."""


class Remembered(NamedTuple):
    """The surface that is remembered, and how much of it."""

    spectrum: Spectrum = GAUSSIAN
    number: int = 1
    """1 for the last facet, 2 for the heights that rays have passed since, too."""
