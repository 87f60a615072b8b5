"""What light does at a single facet: reflection, refraction, Fresnel, diffuse scattering.

Shared by both producers of light, the tracing of explicit surfaces and the Smith random walk.
Directions `d` are directions of travel, unit vectors of shape (3, n); facet normals `m` face the
arriving light (d . m < 0) and need not be normalised unless said otherwise.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def dot(a: Array, b: Array) -> Array:
    """Dot product over the first axis of two (3, n) arrays."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit_circle(n: int, rng: np.random.Generator, dtype: type = np.float64) -> tuple[Array, Array]:
    """Cosine and sine of a uniform angle.

    The angle is one of 2^24, in single precision, in which NumPy has fast trigonometric functions;
    for others, two terms of a series make cos^2 + sin^2 = 1 to the rounding of `dtype`.
    """
    angle = (rng.random(n, dtype=np.float32) - np.float32(0.5)) * np.float32(2 * np.pi)
    cos, sin = np.cos(angle), np.sin(angle)
    if dtype == np.float32:
        return cos, sin
    cos, sin = cos.astype(dtype), sin.astype(dtype)
    excess = cos * cos + sin * sin - dtype(1)
    scale = 1 - excess * (dtype(0.5) - dtype(0.375) * excess)
    return cos * scale, sin * scale


def reflect(d: Array, m: Array) -> Array:
    """Direction of travel after a mirror reflection off a facet of normal `m` (any length)."""
    along_m = (2 * dot(d, m) / dot(m, m)) * m
    reflected: Array = np.subtract(d, along_m, out=along_m)
    return reflected


def fresnel_dielectric(cos_i: Array, eta: Array | float) -> tuple[Array, Array]:
    """Fresnel reflectance of unpolarised light, and the cosine of refraction.

    `eta` is the index behind the facet over the index before it. Total internal reflection
    gives reflectance 1 and cosine 0. [HHdD16 impl., 3.4]
    """
    cos_t = np.sqrt(np.maximum(1 - (1 - cos_i * cos_i) / (eta * eta), 0))
    eta_i, eta_t = eta * cos_i, eta * cos_t
    # Of light that arrives along the facet and is reflected totally both cosines are 0.
    tiny = np.finfo(cos_i.dtype).tiny
    r_s = (cos_i - eta_t + tiny) / (cos_i + eta_t + tiny)
    r_p = (eta_i - cos_t + tiny) / (eta_i + cos_t + tiny)
    return (r_s * r_s + r_p * r_p) / 2, cos_t


def absorptance_conductor(cos_i: Array, eta: Array | float, k: Array | float) -> Array:
    """Share of unpolarised light that a metal of complex index eta + i k absorbs: 1 less the
    Fresnel reflectance, and to nearly all digits however little it is.

    Exact, in real arithmetic: with (a + i b)^2 = (eta + i k)^2 - sin^2 (Born & Wolf, Principles of
    Optics, 14.2) s-polarised light reflects (M - X) / (M + X), and p-polarised light that times
    (P - X sin^2) / (P + X sin^2), where M, X and P are as below. Their mean, taken from 1, is a
    fraction of terms of one sign.
    """
    cos2 = cos_i * cos_i
    sin2 = 1 - cos2
    product = eta * k
    real = eta * eta - k * k - sin2
    modulus = np.sqrt(real * real + 4 * product * product)
    # a b = eta k gives the smaller of the two without a difference. Both are 0 only without
    # absorption, at the critical angle.
    larger = np.sqrt((modulus + np.abs(real)) / 2)
    smaller = product / np.maximum(larger, np.finfo(cos_i.dtype).tiny)
    X = 2 * cos_i * np.where(real > 0, larger, smaller)
    sum_ = modulus + cos2 + X
    P = cos2 * modulus + sin2 * sin2
    return X * (2 * P + sin2 * sum_) / (sum_ * (P + X * sin2))


def lambertian(m: Array, n: int, rng: np.random.Generator) -> Array:
    """Cosine-distributed directions about unit normals `m` with m_z > 0.

    The frame about `m` is that of Duff et al. 2017, whose only singular normal is (0, 0, -1).
    """
    cos_phi, sin_phi = unit_circle(n, rng, m.dtype.type)
    radius2 = rng.random(n, dtype=m.dtype)
    radius, height = np.sqrt(radius2), np.sqrt(1 - radius2)
    x, y = radius * cos_phi, radius * sin_phi
    k = (m[0] * x + m[1] * y) / (1 + m[2])
    out = np.empty((3, n), m.dtype)
    out[0] = x + m[0] * (height - k)
    out[1] = y + m[1] * (height - k)
    out[2] = m[2] * height - m[0] * x - m[1] * y
    return out
