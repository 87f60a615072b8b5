"""Scattering kernels of isotropic surfaces, one Fourier mode of the azimuth at a time.

The azimuth enters by its difference alone, so that modes do not mix: with
f_m = integral of f(phi) cos(m phi) over the circle, an integral over intermediate directions is
a product for each m, and f(phi) = sum over m of (2 - [m = 0]) f_m cos(m phi) / (2 pi).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.nodes import (
    DENSE,
    Angles,
    Elevations,
    azimuths,
    coordinate,
    cosine_integrals,
    sparse_modes,
)
from msbsdf_cli.methods.solver.normalisation import KernelScale, balance
from msbsdf_cli.methods.solver.orders import Discretisation, Kernel, Rows
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.quadrature import gauss

CHUNK = 1 << 16
"""Kernel values computed together: arrays that stay in a core's cache."""

FACETS_PER_NODE = 4
"""Gauss nodes for facet inclinations between two neighbouring elevations of directions."""


def upward(angle: Angles) -> Array:
    """The directions (3, ...) of elevations, at azimuth 0."""
    return np.stack([angle.sin, np.zeros_like(angle.sin), angle.cos])


def distinct_elevations(d: Array) -> tuple[Array, Array]:
    """Directions (3, m) that stand for the directions (3, n), and which (n,) stands for which:
    without a kernel that depends on the azimuth, one for each elevation."""
    _, first, which = np.unique(np.abs(d[2]), return_index=True, return_inverse=True)
    return d[:, first], which


def parting(a: Array, b: Array, modes: int) -> Array:
    """Factors (modes, n) that sum modes to values at the azimuths between `a` and `b` (3, n)."""
    difference = np.arctan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])
    m = np.arange(modes)
    factor = np.where(m == 0, 1, 2) / (2 * np.pi)
    values: Array = factor[:, None] * np.cos(np.multiply.outer(m, difference))
    return values


@dataclass(frozen=True)
class Modes(Discretisation):
    """Elevations, and Fourier modes of the azimuth."""

    slopes: Slopes
    material: Material
    elevations: Elevations
    modes: int

    def distinct(self, d: Array) -> tuple[Array, Array]:
        return distinct_elevations(d)


class MirrorModes(Modes):
    """Facets that reflect: light goes down, then up."""

    def kernel(self) -> Kernel:
        """Scattering between the nodes."""
        nodes = self.elevations.nodes
        rows = self.rows(upward(nodes))
        return Kernel(nodes.cos, rows.sigma, nodes.weight, rows.down, rows.across, None)

    def parting(self, a: Array, b: Array) -> Array:
        return self._numbers[1].T @ parting(a, b, self.modes)

    @cached_property
    def _numbers(self) -> tuple[Array, Array]:
        return sparse_modes(self.modes, DENSE)

    def rows(self, d: Array) -> Rows:
        """Scattering from directions (3, rows) to the nodes; the sign of z is of no account."""
        n = self.elevations.n
        step = max(CHUNK // (2 * n * self._azimuths[0].size), 1)
        parts = [self._rows(d[:, i : i + step]) for i in range(0, d.shape[1], step)]
        down, across = (np.concatenate(part, axis=2) for part in zip(*parts, strict=True))
        w = np.array([np.hypot(d[0], d[1]), 0 * d[0], np.abs(d[2])])
        return Rows(w[2], self.slopes.sigma(w), down, across)

    @cached_property
    def _azimuths(self) -> tuple[Array, Array]:
        """Azimuths (p,), and factors (p, k) for the chosen modes of an even function there."""
        if self.modes == 1:
            phi, weight = azimuths(self.modes)
            return phi, 2 * weight[:, None]
        phi, integrals = cosine_integrals(self._numbers[0])
        return phi, 2 * integrals

    def _rows(self, d: Array) -> tuple[Array, Array]:
        """Matrices (channels, k, rows, nodes): to downward and to upward directions."""
        v = np.array([np.hypot(d[0], d[1]), 0 * d[0], -np.abs(d[2])])
        x = coordinate(v[0], -v[2])
        below, nodes = self.elevations.between(0 * x, x), self.elevations.nodes
        sin = np.concatenate([below.sin, np.broadcast_to(nodes.sin, below.sin.shape)], axis=1)
        cos = np.concatenate([-below.cos, np.broadcast_to(nodes.cos, below.cos.shape)], axis=1)
        q = self._modes(v, sin, cos)
        down, across = q[:, :, : self.elevations.n], q[:, :, self.elevations.n :]
        down = np.swapaxes(down * below.weight[..., None], -1, -2)
        down = down @ self.elevations.interpolation(below.x)
        return np.swapaxes(down, 1, 2), np.moveaxis(across, -1, 1)

    def _modes(self, v: Array, sin: Array, cos: Array) -> Array:
        """Modes (channels, rows, n, k) of q from `v` (3, rows) to sines, cosines (rows, n)."""
        step = max(CHUNK // (sin.shape[0] * self._azimuths[0].size), 1)
        parts = (slice(i, i + step) for i in range(0, sin.shape[1], step))
        return np.concatenate([self._some_modes(v, sin[:, i], cos[:, i]) for i in parts], axis=2)

    def _some_modes(self, v: Array, sin: Array, cos: Array) -> Array:
        phi, factors = self._azimuths
        shape = (*sin.shape, phi.size)
        w = np.empty((3, *shape))
        w[0] = sin[..., None] * np.cos(phi)
        w[1] = sin[..., None] * np.sin(phi)
        w[2] = cos[..., None]
        before = np.broadcast_to(v[:, :, None, None], w.shape)
        q = self.material.density(self.slopes, before.reshape(3, -1), w.reshape(3, -1))
        modes: Array = q.reshape(-1, *shape) @ factors
        return modes


class DiffuseModes(Modes):
    """Lambertian facets: light may turn down again.

    A mode of q is an integral over the facets' inclination alone, of a product of the modes of
    <-d, m> and <w, m> in the azimuth of m, and these are elementary.
    """

    def kernel(self) -> Kernel:
        """Scattering between the nodes."""
        nodes = self.elevations.nodes
        rows = self.rows(upward(nodes))
        scale = self._balance.behind * nodes.weight
        turn = self._albedo(self._behind * scale * scale[:, None])
        return Kernel(nodes.cos, rows.sigma, nodes.weight, rows.down, rows.across, turn)

    def parting(self, a: Array, b: Array) -> Array:
        return parting(a, b, self.modes)

    def rows(self, d: Array) -> Rows:
        """Scattering from directions (3, rows) to the nodes; the sign of z is of no account."""
        w = np.array([np.hypot(d[0], d[1]), 0 * d[0], np.abs(d[2])])
        across, down = self._raw_rows(np.arctan2(w[2], w[0]))
        nodes, scale = self.elevations.nodes, self._balance
        own = scale.rows(across[0], down[0], self.slopes.sigma(w * [[1], [1], [-1]]))[:, None]
        across, down = across * own * scale.front, down * own * scale.behind * nodes.weight
        return Rows(w[2], self.slopes.sigma(w), self._albedo(down), self._albedo(across))

    def _raw_rows(self, psi: Array) -> tuple[Array, Array]:
        """Modes of q from elevations psi (rows,) to upward and to downward nodes."""
        nodes, facets = self.elevations.nodes, self._facets(psi)
        psi_nodes = np.arctan2(nodes.cos, nodes.sin)
        seen = self._seen(psi, facets[0])
        front, behind = (self._seen(s * psi_nodes, facets[0]) for s in (1, -1))
        return self._scatter(seen, front, facets), self._scatter(seen, behind, facets)

    @cached_property
    def _behind(self) -> Array:
        """Modes of q from upward to downward nodes."""
        nodes, facets = self.elevations.nodes, self._facets(np.empty(0))
        behind = self._seen(-np.arctan2(nodes.cos, nodes.sin), facets[0])
        return self._scatter(behind, behind, facets)

    @cached_property
    def _balance(self) -> KernelScale:
        nodes = self.elevations.nodes
        across, down = self._raw_rows(np.arctan2(nodes.cos, nodes.sin))
        up = upward(nodes)
        sigma, sigma_up = self.slopes.sigma(up * [[1], [1], [-1]]), self.slopes.sigma(up)
        return balance(across[0], down[0], self._behind[0], nodes.weight, sigma, sigma_up)

    def _albedo(self, q: Array) -> Array:
        """q for each channel."""
        channels: Array = np.multiply.outer(np.array(self.material.albedos), q)
        return channels

    def _facets(self, psi: Array) -> tuple[Array, Array]:
        """Inclinations theta_m and weights D(m) sin(theta_m) d(theta_m) / pi.

        The modes have a kink where facets begin to turn away, at an inclination equal to the
        elevation of the direction: no interval holds one of the nodes' or of `psi`.
        """
        nodes = self.elevations.nodes
        ends = np.union1d(np.concatenate([psi, [0, np.pi / 2]]), np.arctan2(nodes.cos, nodes.sin))
        u, du = gauss(FACETS_PER_NODE)
        theta = (ends[:-1, None] + np.diff(ends)[:, None] * u).ravel()
        weight = (np.diff(ends)[:, None] * du).ravel()
        m = np.array([np.sin(theta), 0 * theta, np.cos(theta)])
        return theta, self.slopes.D(m) * m[0] * weight / np.pi

    def _seen(self, psi: Array, theta: Array) -> Array:
        """Modes (modes, n, facets) of <w, m>, as m goes round the normal, for elevations psi:
        of (a + b cos(phi))+, which is positive up to phi_0 = arccos(-a / b)."""
        a = np.sin(psi)[:, None] * np.cos(theta)
        b = np.cos(psi)[:, None] * np.sin(theta)
        phi_0 = np.arctan2(np.sqrt(np.maximum(b * b - a * a, 0)), -a)
        # sin(k phi_0) / k, the integral of cos(k phi), turned on from k to k + 1: rounding adds up
        # to k times that of one sine, in half the time.
        waves = np.empty((self.modes + 1, *phi_0.shape))
        waves[0], once = phi_0, np.exp(1j * phi_0)
        turned = once
        for k in range(1, self.modes + 1):
            np.divide(turned.imag, k, out=waves[k])
            turned = turned * once
        modes, waves_b = 2 * a * waves[:-1], b * waves
        modes += waves_b[1:]
        modes[0] += waves_b[1]
        modes[1:] += waves_b[:-2]
        return modes

    def _scatter(self, before: Array, after: Array, facets: tuple[Array, Array]) -> Array:
        """Modes (modes, n, n') of q for albedo 1; light travels opposite to where it is seen from,
        and half a turn changes the sign of odd modes."""
        q = before * facets[1] @ np.swapaxes(after, -1, -2)
        q[1::2] *= -1
        return q
