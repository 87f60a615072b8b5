"""The scattering kernel of a Smith microsurface, and what masking and shadowing make of it.

q(d -> w) = integral of <-d, m> D(m) f(d, m, w) dm, per steradian of `w`, f being the energy that a
facet sends into w (its BSDF times |w . m|). Over all `w` it sums to sigma(d), less what is
absorbed, so that q(d -> w) / sigma(d) is the phase function of [HHdD16] (Section 6); but q needs no
division by an area that vanishes, and for a mirror it is the same seen from both ends.

Inside a dielectric everything is point-reflected, as in `msbsdf_cli.smith.walk`: a direction is
given in the frame of the side it travels in, where light that heads away from the surface
has z > 0. Arrays of directions are (3, ...), and broadcast against each other.
"""

import numpy as np
from scipy.special import betaln

from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material


def scatter_density(
    slopes: Slopes,
    material: Material,
    d: Array,
    w: Array,
    inside: bool = False,
    transmitted: bool = False,
) -> Array:
    """q(d -> w) per steradian, (channels, n), for directions of travel (3, n) or (3, 1)."""
    density, colour = material.density(slopes, d, w, inside, transmitted)
    return density[None] if colour is None else density * colour


def masking_shadowing(
    slopes: Slopes, wi: Array, wo: Array, transmitted: bool, correlated: bool = True
) -> Array:
    """G2 / cos(theta_i), (n,), for `wi` and `wo` above the surface (`wo` point-reflected if
    transmitted): with q it makes the first order, f cos(theta_o) = q G2 / cos(theta_i).

    Correlated heights: 1 / (1 + Lambda_i + Lambda_o) or the Beta function of [HHdD16 impl.] 3.4,
    by logarithms of the gamma function, which do not overflow. Otherwise the product of
    1 / (1 + Lambda) of either direction.
    """
    sigma_i, cos_o = slopes.sigma(-wi), wo[2]
    if transmitted and correlated:
        # B(L_i, 1 + Lambda_o) with L_i = 1 + Lambda_i.
        L_i, Lambda_o = np.asarray(sigma_i / wi[2], float), np.asarray(slopes.sigma(wo) / cos_o)
        return (np.exp(betaln(L_i, 1 + Lambda_o)) / wi[2]).astype(wo.dtype)
    if correlated:
        return cos_o / (sigma_i * cos_o + slopes.sigma(wo) * wi[2])
    return cos_o / (sigma_i * slopes.sigma(-wo))
