"""Metals by name."""

METALS: dict[str, tuple[tuple[float, float], ...]] = {
    "gold": ((0.21, 3.272), (0.43, 2.455), (1.31, 1.849)),
    "silver": ((0.06, 4.152), (0.06, 3.586), (0.05, 2.869)),
    "copper": ((0.30, 3.205), (1.02, 2.577), (1.25, 2.483)),
    "aluminium": ((1.350, 7.371), (1.009, 6.611), (0.709, 5.712)),
    "chromium": ((3.17, 3.30), (3.18, 3.33), (2.51, 3.24)),
}
"""Complex indices n + i k of metals at 617, 549 and 471 nm: red, green and blue.

Gold, silver, copper: Johnson & Christy, Phys. Rev. B 6, 4370 (1972); chromium: Johnson & Christy,
Phys. Rev. B 9, 5056 (1974); aluminium: Rakic, Appl. Opt. 34, 4755 (1995), interpolated linearly.
"""

GREEN = 1
"""The channel that stands for all where only one is followed."""
