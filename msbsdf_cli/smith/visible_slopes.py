"""Quadrature over visible slopes: the integrals that have no closed form, without noise.

The slopes of a distribution, each divided by its roughness, are written in polar coordinates
(tan psi, phi). Those visible from a direction are a half plane. Between the azimuths where its
border goes to infinity, the integrand is smooth in phi, and along each azimuth it is smooth in psi
up to the border: Gauss-Legendre nodes serve both.
"""

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot
from surfaces.quadrature import gauss

RADIAL_NODES = 20
AZIMUTH_NODES = 20
"""With these, diffuse scattering is right to 3e-6 of its largest value, roughness 0.05 to 20."""

CLUSTERED = 3
"""Power of the distance from the border of `split`, in which its nodes are evenly spaced."""


def visible_slopes(
    slopes: Slopes,
    d: Array,
    radial_nodes: int = RADIAL_NODES,
    azimuth_nodes: int = AZIMUTH_NODES,
    split: bool = False,
    half: bool = False,
) -> tuple[Array, Array]:
    """Unit normals m (3, nodes, n) and weights (nodes, n) for directions of travel `d` (3, n):

        sum of weights f(m) = integral of <-d, m> D(m) f(m) dm

    The weights alone sum to sigma(d). `split` has twice the radial nodes and puts a border
    between them where mirrors would send `d` to the horizon, for the sake of kinks there. `half`
    has the nodes on one side of the plane of `d`, for one roughness and f the same on both sides.
    """
    a, b_x, b_y = -d[2], slopes.alpha_x * d[0], slopes.alpha_y * d[1]
    phi, weight = _nodes_on_circle(np.mod(np.arctan2(b_x, -b_y), np.pi), azimuth_nodes, half)
    cos_phi, sin_phi = np.cos(phi), np.sin(phi)

    # Seen where a cos(psi) + b sin(psi) > 0; a border that is never met is put at the end.
    b = b_x * cos_phi + b_y * sin_phi
    border = np.minimum(np.arctan2(np.abs(a), np.where(a >= 0, -b, b)), np.pi / 2)
    low, high = np.where(a >= 0, 0, border), np.where(a >= 0, border, np.pi / 2)
    x, x_weight = gauss(radial_nodes)
    x, x_weight = x[:, None, None], x_weight[:, None, None]
    if split:
        middle = np.clip(_mirrored_to_horizon(slopes, d, cos_phi, sin_phi), low, high)
        # Powers cluster the nodes at the middle: at grazing incidence shadowing falls off within
        # cos(theta_i) of it.
        near, near_weight = x**CLUSTERED, CLUSTERED * x ** (CLUSTERED - 1) * x_weight
        psi = np.concatenate([middle + (end - middle) * near for end in (low, high)])
        ends = np.concatenate([np.abs(end - middle) * near_weight for end in (low, high)])
        weight = weight * ends
    else:
        psi = low + (high - low) * x
        weight = weight * (high - low) * x_weight

    cos_psi, sin_psi = np.cos(psi), np.sin(psi)
    m = np.stack(
        [-slopes.alpha_x * sin_psi * cos_phi, -slopes.alpha_y * sin_psi * sin_phi, cos_psi]
    )
    m /= np.sqrt(dot(m, m))
    # dm = cos^3(theta_m) dx dy, and dx dy = alpha_x alpha_y tan(psi) / cos^2(psi) dpsi dphi.
    over = m[2] / cos_psi
    weight *= slopes.alpha_x * slopes.alpha_y * sin_psi * over * over * over
    weight *= slopes.D(m) * np.maximum(-dot(d[:, None, None, :], m), 0)
    n = d.shape[1]
    return m.reshape(3, -1, n), weight.reshape(-1, n)


def _mirrored_to_horizon(slopes: Slopes, d: Array, cos_phi: Array, sin_phi: Array) -> Array:
    """Radial angle psi of the facets that mirror `d` to the horizon, for each azimuth.

    With -d . (-x, -y, 1) = a + b r and x^2 + y^2 = A^2 r^2: a A^2 r^2 - 2 b r - a = 0.
    """
    A_x, A_y = slopes.alpha_x * cos_phi, slopes.alpha_y * sin_phi
    a, b = -d[2], d[0] * A_x + d[1] * A_y
    A2 = A_x * A_x + A_y * A_y
    root = np.sqrt(b * b + a * a * A2)
    # Of the two forms of the root, the one that adds terms of one sign.
    return np.where(b > 0, np.arctan2(b + root, a * A2), np.arctan2(a, root - b))


def _nodes_on_circle(turn: Array, nodes: int, mirrored: bool) -> tuple[Array, Array]:
    """Nodes and weights (2 nodes, n) on the two half circles between `turn` (n,) and the azimuth
    opposite, denser towards the ends, where a grazing direction has its border swing round; of each
    the first half alone, at twice the weight, if the others are its mirror images."""
    x, weight = gauss(nodes)
    x, weight = x * x * (3 - 2 * x), weight * 6 * x * (1 - x)
    if mirrored:
        x, weight = x[: nodes // 2], 2 * weight[: nodes // 2]
    half = turn + np.pi * x[:, None]
    weight = np.repeat(np.pi * weight[:, None], turn.size, axis=1)
    return np.concatenate([half, half + np.pi]), np.concatenate([weight, weight])
