"""The whole domain of the models, for tests of properties."""

import numpy as np
from hypothesis import strategies as st

from msbsdf_cli.smith.slopes import Beckmann, Ggx, StudentT

LAST = float(np.nextafter(np.pi / 2, 0))

roughness = st.floats(-4, 2).map(lambda power: 10.0**power)
"""From 1e-4 to 100, evenly in its logarithm."""

anisotropy = st.floats(-3, 3).map(lambda power: 10.0**power)


@st.composite
def slopes(draw, kinds=(Beckmann, Ggx, StudentT)):
    """Any distribution of slopes, up to 1000 times as rough one way as the other."""
    alpha, ratio = draw(roughness), draw(anisotropy)
    alphas = alpha * min(ratio, 1), alpha * min(1 / ratio, 1)
    kind = draw(st.sampled_from(kinds))
    if kind is StudentT:
        return StudentT(*alphas, gamma=draw(st.floats(1.500001, 50)))
    return kind(*alphas)


polar = st.one_of(
    st.floats(0, LAST), st.sampled_from([0.0, 1e-8, 1e-4, 1.5707, LAST]), st.floats(1.55, LAST)
)
azimuth = st.floats(-np.pi, np.pi)
precision = st.sampled_from([np.float64, np.float32])


@st.composite
def above(draw, dtype=np.float64):
    """A unit vector (3, 1) above the horizon, down to the last one."""
    theta, phi = draw(polar), draw(azimuth)
    s, z = np.sin(theta), np.cos(theta)
    return np.array([[s * np.cos(phi)], [s * np.sin(phi)], [z]]).astype(dtype)


index = st.one_of(st.floats(1 / 3, 4), st.sampled_from([1 - 1e-6, 1 + 1e-6, 1 / 3, 4.0])).filter(
    lambda n: n != 1
)
