"""How different two colours look: CIEDE2000.

G. Sharma, W. Wu, E. N. Dalal, The CIEDE2000 color-difference formula: implementation notes,
supplementary test data, and mathematical observations, Color Research and Application 30, 2005.
"""

import numpy as np

from surfaces.facet import Array

XYZ_OF_RGB = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
"""Linear sRGB to CIE XYZ under D65 (IEC 61966-2-1)."""

KNEE = 6 / 29
"""Where CIE's lightness turns from a cube root into a line (CIE 15)."""

MOST_OF_RELATIVE = 100.0
"""A colour difference is at most this times the largest relative difference of a channel, up to a
tenth of it; the tests hold colours of all kinds to it, which reach 86."""


def lab(rgb: Array) -> Array:
    """CIE L*a*b* (3, ...) of albedos (3, ...) in linear sRGB; what returns all light is white."""
    matrix = XYZ_OF_RGB / XYZ_OF_RGB.sum(axis=1, keepdims=True)
    t = np.tensordot(matrix, rgb, axes=1)
    x, y, z = np.where(t > KNEE**3, np.cbrt(t), t / (3 * KNEE**2) + 4 / 29)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def albedo_difference(rgb: Array, other: Array) -> Array:
    """CIEDE2000 (...) between albedos (3, ...) in linear sRGB, lit by white light."""
    return ciede2000(lab(rgb), lab(other))


def ciede2000(lab1: Array, lab2: Array) -> Array:
    """Delta E 2000 (...) of colours (3, ...) in L*a*b*, with weights of 1; 1 is just noticeable."""
    (L1, C1, h1), (L2, C2, h2) = _stretched(lab1, lab2)
    L, C, h = (L1 + L2) / 2, (C1 + C2) / 2, h1 + h2
    apart, grey = h2 - h1, C1 * C2 == 0
    # The short way round from one hue to the other, and the hue half way along it.
    turn = np.where(np.abs(apart) <= np.pi, 0.0, -np.sign(apart)) * 2 * np.pi
    far = np.abs(apart) > np.pi
    h = np.where(grey, h, (h + np.where(far, np.where(h < 2 * np.pi, 1, -1) * 2 * np.pi, 0)) / 2)
    dh = np.where(grey, 0, apart + turn)
    T = (
        1
        - 0.17 * np.cos(h - np.pi / 6)
        + 0.24 * np.cos(2 * h)
        + 0.32 * np.cos(3 * h + np.radians(6))
        - 0.20 * np.cos(4 * h - np.radians(63))
    )
    dL = (L2 - L1) / (1 + 0.015 * (L - 50) ** 2 / np.sqrt(20 + (L - 50) ** 2))
    dC = (C2 - C1) / (1 + 0.045 * C)
    dH = 2 * np.sqrt(C1 * C2) * np.sin(dh / 2) / (1 + 0.015 * C * T)
    blue = np.radians(60) * np.exp(-(((np.degrees(h) - 275) / 25) ** 2))
    rotation = -np.sin(blue) * 2 * _of_seventh_power(C)
    return np.asarray(np.sqrt(dL**2 + dC**2 + dH**2 + rotation * dC * dH))


def _stretched(lab1: Array, lab2: Array) -> tuple[tuple[Array, Array, Array], ...]:
    """Lightness, chroma and hue from 0 to 2 pi of both, a* stretched near grey."""
    C = (np.hypot(lab1[1], lab1[2]) + np.hypot(lab2[1], lab2[2])) / 2
    stretch = 1.5 - 0.5 * _of_seventh_power(C)
    found = []
    for L, a, b in (lab1, lab2):
        hue = np.mod(np.arctan2(b, stretch * a), 2 * np.pi)
        found.append((L, np.hypot(stretch * a, b), hue))
    return tuple(found)


def _of_seventh_power(C: Array) -> Array:
    """From 0 for grey to 1 for strong colours."""
    return np.asarray(np.sqrt(C**7 / (C**7 + 25.0**7)))
