"""A BSDF plugin of Mitsuba 3 that reads what `msbsdf export` wrote.

    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")          # or scalar_rgb
    from msbsdf_cli.renderers.mitsuba import register
    register()
    bsdf = mi.load_dict({"type": "msbsdf", "filename": "reports/export-.../bsdf.npz"})

Values are those of the Smith model of all bounces; samples come from the visible normals of the
first order or from the cosine, mixed in the proportion of their energies.
"""

from typing import Any

import numpy as np

from msbsdf_cli.renderers.files import read_table


def register() -> None:
    """Make the plugin known as `msbsdf`, for the variant that is set. Raises ImportError where
    Mitsuba is missing."""
    try:
        import drjit as dr
        import mitsuba as mi
    except ImportError:
        raise ImportError(
            "Mitsuba 3 is not installed: pip install 'msbsdf[mitsuba]' brings it."
        ) from None

    class Msbsdf(mi.BSDF):  # type: ignore[misc, name-defined, unused-ignore]
        """Mitsuba's side: where a lobe is asked for, and how it is sampled."""

        def __init__(self, props: Any) -> None:
            mi.BSDF.__init__(self, props)
            self.lobes = Lobes(props["filename"], mi, dr)
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
            self.m_components, self.m_flags = [flags], flags

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            active &= (si.wi.z > 0) & (wo.z > 0)
            return self.lobes.value(si.wi, wo) & active

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            active &= (si.wi.z > 0) & (wo.z > 0)
            return dr.select(active, self.lobes.density(si.wi, wo), 0)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def sample(
            self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            bs = mi.BSDFSample3f()
            bs.wo = self.lobes.direction(si.wi, sample1, sample2)
            bs.eta = 1.0
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_component = mi.UInt32(0)
            bs.pdf = self.pdf(ctx, si, bs.wo, active)
            active &= bs.pdf > 0
            value = self.eval(ctx, si, bs.wo, active) / self.lobes.divisor(bs.pdf)
            return bs, value & active

        def to_string(self) -> str:
            return f"Msbsdf[alpha = {self.lobes.alpha}, ggx = {self.lobes.ggx}]"

    mi.register_bsdf("msbsdf", Msbsdf)


class Lobes:
    """The Smith model of all bounces, in the arithmetic of the variant that is set."""

    def __init__(self, filename: str, mi: Any, dr: Any) -> None:
        """`filename` is that of a table, `mi` and `dr` are Mitsuba and Dr.Jit."""
        content = read_table(filename)
        self.mi, self.dr = mi, dr
        self.ggx, self.alpha = content["slopes"] == "ggx", float(content["alpha"])
        self.specular = bool(content["specular"])
        self.share = float(content["single_share"]) if self.specular else 0.0
        self.eta_k = content["eta_k"].tolist()
        values = np.moveaxis(content["values"], 0, -1)
        if values.shape[-1] == 1:
            values = np.repeat(values, 3, axis=-1)
        # Texture coordinates run the other way round than the axes of an array.
        self.texture = mi.Texture3f(
            mi.TensorXf(np.ascontiguousarray(values, np.float32)),
            wrap_mode=dr.WrapMode.Clamp,
            filter_mode=dr.FilterMode.Linear,
        )
        kind = mi.MicrofacetType.GGX if self.ggx else mi.MicrofacetType.Beckmann
        self.normals = mi.MicrofacetDistribution(kind, self.alpha)

    def at_least(self, x: Any, low: float) -> Any:
        """As `dr.maximum`, which some versions of LLVM cannot translate."""
        return self.dr.select(x > low, x, low)

    def divisor(self, x: Any) -> Any:
        """x, or 1 where it is not above 0 and nothing comes of the quotient."""
        return self.dr.select(x > 0, x, 1)

    def value(self, wi: Any, wo: Any) -> Any:
        """BSDF x cosine of all orders."""
        value = self.later(wi, wo) * wo.z
        return value + self.first(wi, wo) if self.specular else value

    def later(self, wi: Any, wo: Any) -> Any:
        """BSDF of the orders in the table."""
        dr = self.dr
        along = wi.x * wo.x + wi.y * wo.y
        sines = dr.sqrt(self.at_least((1 - wi.z * wi.z) * (1 - wo.z * wo.z), 0))
        cos_phi = self.at_least(dr.select(sines > 0, along / self.divisor(sines), 1), -1)
        cos_phi = -self.at_least(-cos_phi, -1)
        place = self.mi.Point3f(dr.acos(cos_phi) / dr.pi, wo.z, wi.z)
        return self.mi.Color3f(*(self.at_least(c, 0) for c in self.texture.eval(place)))

    def first(self, wi: Any, wo: Any) -> Any:
        """BSDF x cosine of the first order."""
        h = self.dr.normalize(wi + wo)
        masked = 1 / (1 + self.Lambda(wi) + self.Lambda(wo))
        value = self.D(h) * masked / (4 * self.divisor(wi.z))
        return self.fresnel(self.dr.dot(wi, h)) * value

    def D(self, h: Any) -> Any:
        """Distribution of normals."""
        cos2 = h.z * h.z
        tan2 = (1 - cos2) / cos2 / self.alpha**2
        scale = 1 / (self.dr.pi * self.alpha**2 * cos2 * cos2)
        return scale / (1 + tan2) ** 2 if self.ggx else scale * self.dr.exp(-tan2)

    def Lambda(self, w: Any) -> Any:
        """The Smith function."""
        dr = self.dr
        tan = dr.sqrt(self.at_least(1 - w.z * w.z, 0)) / self.divisor(w.z)
        if self.ggx:
            return (dr.sqrt(1 + self.alpha**2 * tan * tan) - 1) / 2
        a = 1 / self.divisor(self.alpha * tan)
        slanted = (dr.exp(-a * a) / (a * float(np.sqrt(np.pi))) + dr.erf(a) - 1) / 2
        return dr.select(tan > 0, slanted, 0)

    def fresnel(self, cos: Any) -> Any:
        """Reflectance of the facet in each channel."""
        if not self.eta_k:
            return self.mi.Color3f(1)
        pairs = self.eta_k * (3 // len(self.eta_k))
        index = self.mi.Complex2f
        return self.mi.Color3f(*(self.mi.fresnel_conductor(cos, index(*pair)) for pair in pairs))

    def direction(self, wi: Any, sample1: Any, sample2: Any) -> Any:
        """A direction to go on in, above the surface or not."""
        m, _ = self.normals.sample(wi, sample2)
        wide = self.mi.warp.square_to_cosine_hemisphere(sample2)
        return self.dr.select(sample1 < self.share, self.mi.reflect(wi, m), wide)

    def density(self, wi: Any, wo: Any) -> Any:
        """Of these directions, per steradian."""
        h = self.dr.normalize(wi + wo)
        facet = self.normals.pdf(wi, h) / (4 * self.divisor(self.dr.dot(wo, h)))
        return self.share * facet + (1 - self.share) * wo.z / self.dr.pi
