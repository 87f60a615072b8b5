"""What a facet does to light as [HHdD16 impl.] Sections 3.2 to 3.4 print it.

Directions are those of the print: `wi` and `wo` point away from the surface. Inside a dielectric
all of them are point-reflected first, which is what the print does term by term.
"""

import numpy as np

from msbsdf_cli.methods.published.areas import visible
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot, unit_circle
from surfaces.materials import Material


def fresnel(cos_i: Array, eta: Array | float) -> Array:
    """Reflectance of a dielectric; 1 where all is reflected."""
    cos2 = 1 - (1 - cos_i * cos_i) / (eta * eta)
    with np.errstate(all="ignore"):
        cos_t = np.sqrt(cos2)
        s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
        p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
        found: Array = np.where(cos2 <= 0, 1, 0.5 * (s * s + p * p))
    return found


def reflected(
    slopes: Slopes, material: Material, wi: Array, wo: Array, area: Array, eta: float
) -> tuple[Array, Array | None]:
    """Phase function (...) of mirrors and of dielectrics on one side, for `wi` (3, ...), `wo`
    (3, ...) and the projected area of `wi`; and the colour of a metal."""
    with np.errstate(all="ignore"):
        h = wi + wo
        h = h / np.sqrt(dot(h, h))
        cos_i = dot(wi, h)
        value = 0.25 * visible(slopes, wi, h, area) / cos_i
    if material.transmits:
        return value * fresnel(cos_i, eta), None
    value = np.where(h[2] < 0, 0, value)
    if not material.absorbs:
        return value, None
    return value, material.reflectance(np.clip(cos_i, 0, 1))


def transmitted(slopes: Slopes, wi: Array, wo: Array, area: Array, eta: float) -> Array:
    """Phase function (...) of dielectrics from one side to the other."""
    with np.errstate(all="ignore"):
        h = -(wi + wo * eta)
        h = h / np.sqrt(dot(h, h))
        h = h * np.sign(h[2])
        cos_i, cos_o = dot(wi, h), dot(wo, h)
        value = eta * eta * (1 - fresnel(cos_i, eta)) * visible(slopes, wi, h, area)
        value = value * np.maximum(-cos_o, 0) / (cos_i + eta * cos_o) ** 2
    return np.where(cos_i < 0, 0, value)


def mirror(wi: Array, m: Array) -> Array:
    """Directions (3, n) after a reflection off unit normals."""
    return -wi + 2 * m * dot(wi, m)


def refract(wi: Array, m: Array, eta: Array) -> Array:
    """Directions (3, n) after a transmission."""
    cos_i = dot(wi, m)
    cos_t = -np.sqrt(np.maximum(1 - (1 - cos_i * cos_i) / (eta * eta), 0))
    w = m * (cos_i / eta + cos_t) - wi / eta
    return w / np.sqrt(dot(w, w))


def diffuse(m: Array, rng: np.random.Generator) -> Array:
    """Directions (3, n) about unit normals, by cosines: the frame of Frisvad 2012."""
    n, dtype = m.shape[1], m.dtype.type
    cos_phi, sin_phi = unit_circle(n, rng, dtype)
    radius = np.sqrt(rng.random(n, dtype=dtype))
    x, y = radius * cos_phi, radius * sin_phi
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    a = 1 / (1 + m[2])
    b = -m[0] * m[1] * a
    first = np.stack([1 - m[0] * m[0] * a, b, -m[0]])
    second = np.stack([b, 1 - m[1] * m[1] * a, -m[1]])
    return x * first + y * second + z * m
