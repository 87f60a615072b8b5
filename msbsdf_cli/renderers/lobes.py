"""The Smith model of all bounces in the arithmetic of a renderer: Mitsuba's variants.

Arguments `wi` and `wo` are Mitsuba's vectors. Where light passes through facets both may be on
either side, and a value is the BSDF for light that carries energy, as everywhere here; what a
radiance meets is another thing, which the plugin sees to.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from msbsdf_cli.renderers.files import read_table
from msbsdf_cli.renderers.nodes import TINY
from msbsdf_cli.renderers.splines import MARGIN
from msbsdf_cli.renderers.tables import table_coefficients

CUBIC: tuple[Callable[[Any], Any], ...] = (
    lambda t: (1 - t) ** 3 / 6,
    lambda t: (3 * t * t * t - 6 * t * t + 4) / 6,
    lambda t: (3 * t + 3 * t * t - 3 * t * t * t + 1) / 6,
    lambda t: t * t * t / 6,
)
"""Uniform cubic B-splines of the four nodes about a place, t behind the second."""


class Lobes:
    """Values of a table, and sampling by the visible normals of the first order or by the cosine,
    mixed in the proportion of their energies."""

    def __init__(self, filename: str, mi: Any, dr: Any) -> None:
        """`filename` is that of a table, `mi` and `dr` are Mitsuba, its variant set, and Dr.Jit."""
        content = read_table(filename)
        self.mi, self.dr = mi, dr
        self.ggx, self.alpha = content["slopes"] == "ggx", content["alpha"]
        self.specular, self.ior = bool(content["specular"]), content["ior"]
        self.share = float(content["single_share"])
        self.eta_k = content["eta_k"].tolist()
        self.nodes = content["nodes"]
        kind = mi.MicrofacetType.GGX if self.ggx else mi.MicrofacetType.Beckmann
        self.normals = mi.MicrofacetDistribution(kind, *self.alpha)
        values = table_coefficients(content["values"].astype(float), self.nodes)
        self._load(np.moveaxis(values, 0, -1))

    def _load(self, values: Any) -> None:
        """A texture has three axes: blocks and azimuths of incidence lie one behind the other."""
        blocks, self.slices, self.depth, height, width, channels = values.shape
        self.channels = channels
        if channels > 1 and not self.mi.is_rgb:
            raise ValueError(
                f"the table has {channels} channels, red, green and blue: it is for Mitsuba's rgb "
                "variants."
            )
        if self.mi.is_polarized:
            raise ValueError("the table knows nothing of polarisation: take another variant.")
        self.shape = blocks * self.slices * self.depth, height, width
        self.texture = self.mi.Texture3f(
            self.mi.TensorXf(values.reshape(*self.shape, channels).astype(np.float32)),
            use_accel=False,
            wrap_mode=self.dr.WrapMode.Clamp,
            filter_mode=self.dr.FilterMode.Linear,
        )

    def at_least(self, x: Any, low: float) -> Any:
        """As `dr.maximum`, which some versions of LLVM cannot translate."""
        return self.dr.select(x > low, x, low)

    def divisor(self, x: Any) -> Any:
        """x, or 1 where it is not above 0 and nothing comes of the quotient."""
        return self.dr.select(x > 0, x, 1)

    def upright(self, w: Any) -> Any:
        """w, or its image in the mean plane if it points down."""
        return self.mi.Vector3f(w.x, w.y, self.dr.abs(w.z))

    def value(self, wi: Any, wo: Any) -> Any:
        """BSDF x cosine of all orders."""
        value = self.later(wi, wo) * self.dr.abs(wo.z)
        return value + self.first(wi, wo) if self.specular else value

    def later(self, wi: Any, wo: Any) -> Any:
        """BSDF of the orders in the table."""
        dr = self.dr
        inside, crosses = wi.z < 0, wi.z * wo.z < 0
        outwards = inside & crosses
        lit, seen = self.upright(wi), self.upright(wo)
        lit, seen = dr.select(outwards, seen, lit), dr.select(outwards, lit, seen)
        block = dr.select(crosses, 1.0, dr.select(inside, 2.0, 0.0)) if self.ior else 0.0
        values = self._spline(block, lit, seen, crosses)
        scale = dr.select(outwards, 1 / self.ior**2, 1.0) if self.ior else 1.0
        return self.spectrum([self.at_least(v, 0) * scale for v in values])

    def spectrum(self, channels: list[Any]) -> Any:
        """Mitsuba's colour of one channel or three."""
        return self.mi.Spectrum(*channels)

    def _spline(self, block: Any, wi: Any, wo: Any, crosses: Any) -> list[Any]:
        """The table's channels."""
        dr, nodes = self.dr, self.nodes
        if nodes.incident > 1:
            # Mirror images in both planes of symmetry have the same BSDF.
            x, y = dr.select(wi.x < 0, -1, 1), dr.select(wi.y < 0, -1, 1)
            wi, wo = (self.mi.Vector3f(x * w.x, y * w.y, w.z) for w in (wi, wo))
        phi = dr.atan2(wi.x * wo.y - wi.y * wo.x, wi.x * wo.x + wi.y * wo.y)
        if nodes.incident == 1:
            phi = dr.abs(phi)
            crowded = phi + nodes.crowding / 2 * dr.sin(2 * phi)
            place = crowded / dr.pi * (nodes.azimuths - 1)
        else:
            place = dr.select(phi < 0, phi + 2 * dr.pi, phi) / (2 * dr.pi) * nodes.azimuths
        into, out = self._elevations(wi, wo, crosses)
        rest = place, out, into
        if nodes.incident == 1:
            return self._look_up(block, *rest)
        turned = dr.atan2(wi.y, wi.x) / (dr.pi / 2) * (nodes.incident - 1)
        before = self.at_least(dr.floor(turned), 0)
        before = -self.at_least(-before, 2 - nodes.incident)
        total = [0.0] * self.channels
        for tap, cubic in enumerate(CUBIC):
            found = self._look_up(block * self.slices + before + tap, *rest)
            weight = cubic(turned - before)
            total = [t + weight * f for t, f in zip(total, found, strict=True)]
        return total

    def _look_up(self, number: Any, phi: Any, out: Any, into: Any) -> list[Any]:
        """Channels at places between the nodes, in the part `number` of the texture."""
        places = phi, out, number * self.depth + into
        centre = MARGIN + 0.5
        sizes = self.shape[::-1]
        uvw = [(p + centre) / size for p, size in zip(places, sizes, strict=True)]
        found: list[Any] = self.texture.eval_cubic(self.mi.Point3f(*uvw))
        return found

    def _elevations(self, wi: Any, wo: Any, crosses: Any) -> list[Any]:
        """Places between the nodes of upward directions, as `Nodes` has it."""
        dr, nodes = self.dr, self.nodes
        if not nodes.before:
            places = (1 - dr.sqrt(self.at_least(self._psi(w) / (dr.pi / 2), 0)) for w in (wi, wo))
            least = 1 - nodes.elevations
            return [-self.at_least(-x * (nodes.elevations - 0.5), least) for x in places]
        low = dr.pi / 2 - nodes.split
        dense = wo if nodes.dense_inside else wi
        # The arc sine of 1 or less.
        sine = -self.at_least(-self.at_least(dense.z, 0) / float(np.cos(nodes.split)), -1)
        corner = dr.select(crosses & (self._psi(dense) < low), dr.asin(sine), low)
        lows = (corner, low) if nodes.dense_inside else (low, corner)
        return [self._parted(w, of) for w, of in zip((wi, wo), lows, strict=True)]

    def _psi(self, w: Any) -> Any:
        """Elevation over the mean plane."""
        return self.dr.atan2(w.z, self.dr.sqrt(w.x * w.x + w.y * w.y))

    def _parted(self, w: Any, low: Any) -> Any:
        """Of elevations in two parts that meet at `low`."""
        dr, nodes = self.dr, self.nodes
        after, psi = nodes.elevations - nodes.before, self._psi(w)
        ratio = self.at_least(psi / self.at_least(low, TINY), 0)
        x = dr.sqrt(self.at_least(1 - dr.sqrt(ratio), 0))
        beyond = -self.at_least(-x * (after - 0.5), 1 - after) + nodes.before + 2 * MARGIN
        part = (psi - low) / self.at_least(dr.pi / 2 - low, TINY)
        return dr.select(psi < low, beyond, (1 - part) * (nodes.before - 1))

    def first(self, wi: Any, wo: Any) -> Any:
        """BSDF x cosine of the first order."""
        dr = self.dr
        h = self.half(wi, wo)
        cos_i = dr.dot(wi, h) * dr.sign(wi.z)
        Lambda_i, Lambda_o = self.Lambda(wi), self.Lambda(wo)
        shown = self.D(h) / self.divisor(dr.abs(wi.z))
        mirrored = self.fresnel(wi, h) * (shown / (4 * (1 + Lambda_i + Lambda_o)))
        if not self.ior:
            return mirrored
        # B(1 + Lambda_i, 1 + Lambda_o) is the height-correlated term ([HHdD16 impl.] 3.4).
        a, b = 1 + Lambda_i, 1 + Lambda_o
        correlated = dr.exp(dr.lgamma(a) + dr.lgamma(b) - dr.lgamma(a + b))
        cos_o = -dr.dot(wo, h) * dr.sign(wi.z)
        faces = (cos_i > 0) & (cos_o > 0)
        bent = (1 - self.fresnel(wi, h)) * (shown * correlated * self.refraction(wi, wo, h))
        return dr.select(wi.z * wo.z > 0, mirrored, dr.select(faces, bent, 0))

    def eta(self, wi: Any) -> Any:
        """Index beyond over the index on the side of wi."""
        return self.dr.select(wi.z > 0, self.ior, 1 / self.ior)

    def half(self, wi: Any, wo: Any) -> Any:
        """Normal, upward, of facets that send light from wi to wo."""
        dr = self.dr
        if not self.ior:
            return dr.normalize(wi + wo)
        h = wi + wo * dr.select(wi.z * wo.z > 0, 1, self.eta(wi))
        return dr.normalize(h * dr.select(h.z < 0, -1, 1))

    def refraction(self, wi: Any, wo: Any, h: Any) -> Any:
        """Solid angle of normals for that of refracted directions, times the cosine of incidence
        (Walter et al. 2007, Eq. 21)."""
        eta = self.eta(wi)
        cos_i, cos_o = self.dr.dot(wi, h), self.dr.dot(wo, h)
        length = cos_i + eta * cos_o
        return self.dr.abs(eta * eta * cos_i * cos_o) / self.divisor(length * length)

    def D(self, h: Any) -> Any:
        """Distribution of normals."""
        dr, (a_x, a_y) = self.dr, self.alpha
        cos2 = self.divisor(h.z * h.z)
        tan2 = ((h.x / a_x) ** 2 + (h.y / a_y) ** 2) / cos2
        scale = 1 / (dr.pi * a_x * a_y * cos2 * cos2)
        return scale / (1 + tan2) ** 2 if self.ggx else scale * dr.exp(-tan2)

    def Lambda(self, w: Any) -> Any:
        """The Smith function of a direction, or of its image if it points down."""
        dr, (a_x, a_y) = self.dr, self.alpha
        slope2 = ((a_x * w.x) ** 2 + (a_y * w.y) ** 2) / self.divisor(w.z * w.z)
        if self.ggx:
            return (dr.sqrt(1 + slope2) - 1) / 2
        a = 1 / dr.sqrt(self.divisor(slope2))
        slanted = (dr.exp(-a * a) / (a * float(np.sqrt(np.pi))) + dr.erf(a) - 1) / 2
        return dr.select(slope2 > 0, slanted, 0)

    def fresnel(self, wi: Any, h: Any) -> Any:
        """Reflectance of the facet in each channel."""
        cos = self.dr.abs(self.dr.dot(wi, h))
        if self.ior:
            # Mitsuba tells the sides by the sign of the cosine.
            signed = self.dr.select(wi.z > 0, cos, -cos)
            return self.mi.Spectrum(self.mi.fresnel(signed, self.ior)[0])
        if not self.eta_k:
            return self.mi.Spectrum(1)
        index = self.mi.Complex2f
        return self.spectrum([self.mi.fresnel_conductor(cos, index(*p)) for p in self.eta_k])

    def direction(self, wi: Any, sample1: Any, sample2: Any) -> tuple[Any, Any]:
        """A direction to go on in, and whether light that a facet has sent there is on its side."""
        dr, mi = self.dr, self.mi
        up = self.upright(wi)
        m, _ = self.normals.sample(up, sample2)
        wide, narrow = mi.warp.square_to_cosine_hemisphere(sample2), mi.reflect(up, m)
        by_facet = sample1 < self.share
        if not self.ior:
            w = dr.select(by_facet, narrow, wide)
            return w, w.z > 0
        wide.z *= dr.select((sample1 - self.share) < (1 - self.share) / 2, 1, -1)
        fresnel, cos_t, _, eta_ti = mi.fresnel(dr.dot(up, m), self.eta(wi))
        reflected = sample1 < self.share * fresnel
        narrow = dr.select(reflected, narrow, mi.refract(up, m, cos_t, eta_ti))
        apart = dr.select(reflected, narrow.z > 0, narrow.z < 0)
        w = dr.select(by_facet, narrow, wide)
        return w * mi.Vector3f(1, 1, dr.select(wi.z < 0, -1, 1)), apart | (sample1 >= self.share)

    def density(self, wi: Any, wo: Any) -> Any:
        """Of these directions, per steradian."""
        dr = self.dr
        cosine = dr.abs(wo.z) / dr.pi * (0.5 if self.ior else 1)
        wide = (1 - self.share) * cosine
        if self.share == 0:
            return wide
        h = self.half(wi, wo)
        up = self.upright(wi)
        n = dr.select(wi.z < 0, self.mi.Vector3f(-h.x, -h.y, h.z), h)
        lit = dr.abs(dr.dot(wi, h))
        shown = self.normals.pdf(up, n)
        mirrored = shown / (4 * self.divisor(lit))
        if not self.ior:
            return self.share * mirrored + wide
        reflected = self.mi.fresnel(dr.select(wi.z > 0, lit, -lit), self.ior)[0]
        faces = (dr.dot(wi, h) * wi.z > 0) & (dr.dot(wo, h) * wo.z > 0)
        bent = shown / self.divisor(lit) * self.refraction(wi, wo, h)
        facet = dr.select(wi.z * wo.z > 0, reflected * mirrored, (1 - reflected) * bent)
        return self.share * dr.select(faces, facet, 0) + wide
