"""Masking and shadowing of the first order."""

import numpy as np
from scipy.special import beta

from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array


def masking_shadowing(
    slopes: Slopes,
    wi: Array,
    wo: Array,
    transmitted: bool,
    correlated: bool = True,
    sigma_i: Array | None = None,
) -> Array:
    """G2 / cos(theta_i), (n,), for `wi` and `wo` above the surface (`wo` point-reflected if
    transmitted): with q it makes the first order, f cos(theta_o) = q G2 / cos(theta_i).

    Correlated heights: 1 / (1 + Lambda_i + Lambda_o) or the Beta function of [HHdD16 impl.] 3.4,
    which does not overflow as gamma functions do. Otherwise the product of 1 / (1 + Lambda) of
    either direction. `sigma_i` is sigma(-wi), (n,), where that is known.
    """
    sigma_i, cos_o = slopes.sigma(-wi) if sigma_i is None else sigma_i, wo[2]
    if transmitted and correlated:
        # B(L_i, 1 + Lambda_o) with L_i = 1 + Lambda_i.
        L_i, Lambda_o = np.asarray(sigma_i / wi[2], float), np.asarray(slopes.sigma(wo) / cos_o)
        return (beta(L_i, 1 + Lambda_o) / wi[2]).astype(wo.dtype)
    if correlated:
        return cos_o / (sigma_i * cos_o + slopes.sigma(wo) * wi[2])
    return cos_o / (sigma_i * slopes.sigma(-wo))
