"""Directions and comparisons that the tests of the methods share."""

from dataclasses import replace

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


def evaluated(model, wi, wo, samples, rng):
    """An evaluation whose standard errors count paths that no walk has found."""
    found = model.evaluate(wi, wo, samples, rng)
    stderr = found.stderr.astype(float)
    unseen = model.undersampling(wi, wo, samples, rng)
    stderr[:, 1:] = np.hypot(stderr[:, 1:], unseen[:, None])
    return replace(found, stderr=stderr)


def largest_z(a, b, scale=1.0):
    """Largest difference of evaluation `a` from `scale` times `b`, in standard errors."""
    value, other, stderr = a.value, b.value * scale, np.hypot(a.stderr, b.stderr * scale)
    assert np.isfinite(value).all()
    assert np.isfinite(other).all()
    exact = stderr <= 1e-12 * value
    np.testing.assert_allclose(value[exact], other[exact], rtol=1e-9, atol=1e-12 * value.max())
    return np.max(np.abs(value - other)[~exact] / stderr[~exact])
