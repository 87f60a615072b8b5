"""Directions and comparisons that the tests of the methods share."""

import numpy as np


def direction(theta, phi=0.0):
    """Unit vectors (3,) or (3, n)."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    s = np.sin(theta)
    return np.stack([s * np.cos(phi), s * np.sin(phi), np.cos(theta)])


def hemisphere(n=32):
    """Directions (3, 2 n^2) and solid angles, finer towards the horizon."""
    x, weight = np.polynomial.legendre.leggauss(n)
    u = (1 + x) / 2
    phi = (np.arange(2 * n) + 0.5) * np.pi / n
    z, phi = (a.ravel() for a in np.meshgrid(u * u, phi, indexing="ij"))
    s = np.sqrt(1 - z * z)
    solid_angle = np.repeat(weight * u, 2 * n) * np.pi / n
    return np.stack([s * np.cos(phi), s * np.sin(phi), z]), solid_angle


def sphere(n=32):
    """The same for both sides."""
    w, solid_angle = hemisphere(n)
    return np.concatenate([w, -w], axis=1), np.concatenate([solid_angle, solid_angle])


def largest_z(a, a_stderr, b, b_stderr):
    """Largest difference in standard errors, over values that either side knows to a quarter.

    Where one walk in a million goes, a standard error knows nothing of that one, and is no
    measure of anything; but such values must not be the rule.
    """
    stderr = np.hypot(a_stderr, b_stderr)
    assert np.isfinite(a).all()
    assert np.isfinite(b).all()
    exact = stderr <= 1e-12 * a
    np.testing.assert_allclose(a[exact], b[exact], rtol=1e-9, atol=1e-12 * a.max())
    known = ~exact & (a_stderr < a / 4) & (b_stderr < b / 4)
    assert known.sum() > 0.5 * (~exact).sum()
    return np.max(np.abs(a - b)[known] / stderr[known])
