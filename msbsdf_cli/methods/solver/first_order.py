"""Energy of the first order, by an integral over facets with edges where light behaves
otherwise."""

from msbsdf_cli.methods.solver.slope_quadrature import Light, SlopeQuadrature
from msbsdf_cli.smith.masking import masking_shadowing
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material


def first_order_energy(
    slopes: Slopes, material: Material, wi: Array, panel: int, correlated: bool = True
) -> float:
    """Energy on both sides of specular facets, in the first channel, for `wi` (3,), z > 0, with
    `panel` nodes between edges."""
    quadrature = SlopeQuadrature(slopes, panel, slopes.isotropic)
    lights: tuple[Light, ...]
    if material.transmits:
        lights = quadrature.scatter(-wi, material.ior)
    else:
        lights = (quadrature.mirror(-wi, lambda cos_i: material.reflectance(cos_i)[0]),)
    total = 0.0
    for side, light in enumerate(lights):
        up = light.w[2] > 0
        ends = wi[:, None], light.w[:, up], bool(side), correlated
        total += float((light.amount[up] * masking_shadowing(slopes, *ends)).sum())
    return total
