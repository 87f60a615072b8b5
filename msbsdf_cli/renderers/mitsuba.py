"""A BSDF plugin of Mitsuba 3 that reads what `msbsdf export` wrote.

    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")          # or any scalar or LLVM variant without polarisation
    from msbsdf_cli.renderers.mitsuba import register
    register()
    bsdf = mi.load_dict({"type": "msbsdf", "filename": "reports/export-.../bsdf.npz"})

Values are those of the Smith model of all bounces. The x axis of a surface of two roughnesses is
that of Mitsuba's shading frame, and facets that transmit have their inside below it.
"""

from typing import Any

from msbsdf_cli.renderers.lobes import Lobes


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
            F = mi.BSDFFlags
            parts, sides = [F.GlossyReflection], F.FrontSide
            if self.lobes.ior:
                parts, sides = [*parts, F.GlossyTransmission], F.FrontSide | F.BackSide
            if self.lobes.alpha[0] != self.lobes.alpha[1]:
                sides |= F.Anisotropic
            if self.lobes.ior:
                sides |= F.NonSymmetric
            self.m_components = [part | sides for part in parts]
            self.m_flags = self.m_components[0] | self.m_components[-1]

        def reached(self, wi: Any, wo: Any, active: Any) -> Any:
            """Whether light goes between the directions at all."""
            if self.lobes.ior:
                return active & (wi.z * wo.z != 0)
            return active & (wi.z > 0) & (wo.z > 0)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            value = self.lobes.value(si.wi, wo)
            if self.lobes.ior and ctx.mode == mi.TransportMode.Radiance:
                # Radiance seen through an interface: energy is spread over other solid angles.
                eta = self.lobes.eta(si.wi)
                value *= dr.select(si.wi.z * wo.z < 0, 1 / (eta * eta), 1)
            return dr.select(self.reached(si.wi, wo, active), value, 0)

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            reached = self.reached(si.wi, wo, active)
            return dr.select(reached, self.lobes.density(si.wi, wo), 0)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def sample(
            self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            bs = mi.BSDFSample3f()
            bs.wo, apart = self.lobes.direction(si.wi, sample1, sample2)
            bs.pdf = self.pdf(ctx, si, bs.wo, active & apart)
            through, F = si.wi.z * bs.wo.z < 0, mi.BSDFFlags
            bs.eta = dr.select(through, self.lobes.eta(si.wi), 1.0) if self.lobes.ior else 1.0
            kind = dr.select(through, +F.GlossyTransmission, +F.GlossyReflection)
            bs.sampled_type = mi.UInt32(kind)
            bs.sampled_component = mi.UInt32(dr.select(through, 1, 0))
            active &= bs.pdf > 0
            value = self.eval(ctx, si, bs.wo, active) / self.lobes.divisor(bs.pdf)
            return bs, dr.select(active, value, 0)

        def to_string(self) -> str:
            return f"Msbsdf[alpha = {self.lobes.alpha}, ggx = {self.lobes.ggx}]"

    mi.register_bsdf("msbsdf", Msbsdf)
