"""Scattering kernels of surfaces with two roughnesses: a grid of directions, folded by symmetry.

The statistics are unchanged by x -> -x and by y -> -y, so that functions even or odd in x and in
y do not mix: four blocks on a quarter of the directions. With signs s_g over the four mirrors g,
the part of f(v, w) in a block is 1/4 of the sum over g of s_g f(v, g w), and an integral over
intermediate directions is a product for each block.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.base import outgoing
from msbsdf_cli.methods.single import first_order
from msbsdf_cli.methods.solver.isotropic import CHUNK
from msbsdf_cli.methods.solver.nodes import (
    Elevations,
    QuarterAzimuths,
    SplitElevations,
    azimuths,
    coordinate,
)
from msbsdf_cli.methods.solver.normalisation import KernelScale, balance
from msbsdf_cli.methods.solver.orders import Discretisation, Kernel, Rows
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot
from surfaces.materials import Material
from surfaces.quadrature import gauss

MIRRORS = np.array([[1, 1], [-1, 1], [1, -1], [-1, -1]])
"""Signs of x and y: the four mirrors, and by their products with each other the four parities."""

FACETS = 4
"""Facets for each node of the directions, along either angle."""

SAME_AZIMUTH = 13
"""Decimals to which azimuths of nodes that share one agree in spite of rounding."""

FINER = 2
"""Elevations on either side of the light's own, for each node, that order 1 is integrated over:
right to 1e-8 with them, up to theta 1.57 at roughness 0.1,1."""


def parities(blocks: int) -> Array:
    """Signs (blocks, 4) of functions of each parity under each mirror."""
    signs = np.array([[1, 1, 1, 1], [1, -1, 1, -1], [1, 1, -1, -1], [1, -1, -1, 1]])
    return signs[:blocks]


@dataclass(frozen=True)
class QuarterGrid:
    """Nodes of a quarter of the hemisphere: all elevations at each of `quarter` azimuths.

    One block is enough for energies.
    """

    slopes: Slopes
    elevations: Elevations | SplitElevations
    quarter: int
    blocks: int

    @cached_property
    def azimuths(self) -> QuarterAzimuths:
        """Azimuths in the first quadrant.

        Two things ask for nodes. At grazing angles projected areas, and with them the probability
        to leave, change with the azimuth about the smoother axis: with r the ratio of roughnesses
        they are smooth up to azimuths whose imaginary part is artanh(r). And lobes are as narrow
        about the rougher axis, across which the smaller roughness lies. Crowding by the root of 2 r
        / (1 + r^2) takes such singularities equally far from the evenly spaced azimuths as the
        crowding's own; half of that, in logarithms, leaves enough nodes in between, and was better
        on the whole. Energies do not show single lobes; where these count, nodes are moved on
        towards the rougher axis, by a power of r that was better on the whole too."""
        ratio = self.slopes.alpha_y / self.slopes.alpha_x
        crowding = (2 * ratio / (1 + ratio * ratio)) ** 0.25
        squeeze = 1.0 if self.blocks == 1 else ratio ** (1 / 6)
        return QuarterAzimuths(self.quarter, crowding, squeeze)

    @cached_property
    def nodes(self) -> Array:
        """Upward directions (3, n), n = elevations x quarter."""
        angle = self.elevations.nodes
        x = np.multiply.outer(angle.sin, np.cos(self.azimuths.nodes)).ravel()
        y = np.multiply.outer(angle.sin, np.sin(self.azimuths.nodes)).ravel()
        return np.stack([x, y, np.repeat(angle.cos, self.quarter)])

    @cached_property
    def weight(self) -> Array:
        """Solid angles (n,) of the nodes and their mirror images."""
        return np.multiply.outer(self.elevations.nodes.weight, self.azimuths.arc).ravel()

    def distinct(self, d: Array) -> tuple[Array, Array]:
        return d, np.arange(d.shape[1])

    def parting(self, a: Array, b: Array) -> Array:
        return np.ones((self.blocks, 1))


@dataclass(frozen=True)
class MirrorGrid(QuarterGrid, Discretisation):
    """Facets that reflect: light goes down, then up."""

    elevations: Elevations
    material: Material

    def kernel(self) -> Kernel:
        """Scattering between the nodes."""
        # One azimuth after the other, and back into the nodes' order.
        order = np.arange(self.nodes.shape[1]).reshape(-1, self.quarter).T.ravel()
        back = np.argsort(order)
        rows = self.rows(self.nodes[:, order])
        down, across = rows.down[:, :, back], rows.across[:, :, back]
        # Projected on the grid's waves in the azimuth after the facet only: restore reciprocity.
        across = (across + np.swapaxes(across, -1, -2)) / 2
        return Kernel(self.nodes[2], rows.sigma[back], self.weight, down, across, None)

    def rows(self, d: Array) -> Rows:
        """Scattering from directions (3, rows) to the nodes; the sign of z is of no account."""
        parts = [self._row(d[:, i]) for i in range(d.shape[1])]
        down, across = (np.stack(part, axis=2) for part in zip(*parts, strict=True))
        up = np.array([d[0], d[1], np.abs(d[2])])
        return Rows(up[2], self.slopes.sigma(up), down, across)

    @cached_property
    def _offsets(self) -> tuple[Array, Array]:
        """Azimuths (p,) relative to the direction before the facet, and weights."""
        phi, weight = azimuths(round(2 * self.quarter / self.azimuths.narrowest))
        return np.concatenate([phi, -phi]), np.concatenate([weight, weight])

    def _around(self, d: Array) -> tuple[Array, Array]:
        """Azimuths (p,), crowded about that of a direction (3,), and weights."""
        phi, weight = self._offsets
        return phi + np.arctan2(d[1], d[0]), weight

    def first_order(self, wi: Array) -> Array:
        """Energy (channels,) of order 1, for light from `wi` (3,).

        A single integral over the closed form, with nodes of its own on either side of the
        light's own elevation: towards grazing angles lobes are narrower than the grid's.
        """
        x = coordinate(np.hypot(wi[0], wi[1]), wi[2])
        elevations = Elevations(FINER * self.elevations.n)
        angle = elevations.between(np.array([0, x]), np.array([x, 1]))
        phi, weight = self._around(-wi)
        wo = outgoing(self.slopes, _directions(angle.sin.ravel(), angle.cos.ravel(), phi))
        value = first_order(self.slopes, self.material, wi, wo)
        return value @ np.multiply.outer(angle.weight, weight).ravel()

    def _row(self, d: Array) -> tuple[Array, Array]:
        """Scattering (channels, blocks, n) from a direction (3,): down (weighted) and up."""
        x = coordinate(np.hypot(d[0], d[1]), np.abs(d[2]))[None]
        angle, nodes = self.elevations.between(0 * x, x), self.elevations.nodes
        sin = np.concatenate([angle.sin[0], nodes.sin])
        cos = np.concatenate([-angle.cos[0], nodes.cos])
        phi, weight = self._around(d)
        w = _directions(sin, cos, phi)
        v = np.broadcast_to(np.array([[d[0]], [d[1]], [-np.abs(d[2])]]), w.shape)
        q = self.material.density(self.slopes, v, w)
        # (channels, elevations, blocks, quarter)
        q = np.tensordot(
            q.reshape(-1, sin.size, phi.size), self._fold(d) * weight[:, None, None], 1
        )
        down, across = q[:, : self.elevations.n], q[:, self.elevations.n :]
        interpolation = self.elevations.interpolation(angle.x[0]) * angle.weight[0][:, None]
        down = np.einsum("ckbj,ki->cbij", down, interpolation, optimize=True)
        across = np.moveaxis(across, 1, 2) / self.azimuths.arc
        shape = (*down.shape[:2], -1)
        return down.reshape(shape), across.reshape(shape)

    @cached_property
    def _folds(self) -> dict[float, Array]:
        return {}

    def _fold(self, d: Array) -> Array:
        """`_interpolant` to the azimuths around a direction (3,), once for all nodes that share
        that of the direction."""
        phi, _ = self._around(d)
        known = self._folds.get(float(np.round(phi[0], SAME_AZIMUTH)))
        if known is None:
            self._folds.clear()
            known = self._interpolant(phi)
            self._folds[float(np.round(phi[0], SAME_AZIMUTH))] = known
        return known

    def _interpolant(self, phi: Array) -> Array:
        """Factors (p, blocks, quarter) from a function of each parity at the nodes' azimuths to
        azimuths (p,): the trigonometric interpolant of 4 quarter points."""
        n = 4 * self.quarter
        phi, even = np.angle(self.azimuths.relax(np.exp(1j * phi))), self.azimuths.even
        images = np.stack([even, np.pi - even, -even, np.pi + even])
        x = (phi[:, None, None] - images) / 2
        sine = np.sin(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            wave = np.where(sine == 0, 1, np.sin(n * x) * np.cos(x) / (n * sine))
        return np.einsum("bg,pgj->pbj", parities(self.blocks), wave)


def _directions(sin: Array, cos: Array, phi: Array) -> Array:
    """Directions (3, elevations x azimuths)."""
    w = np.empty((3, sin.size, phi.size))
    w[0], w[1] = np.multiply.outer(sin, np.cos(phi)), np.multiply.outer(sin, np.sin(phi))
    w[2] = cos[:, None]
    return w.reshape(3, -1)


@dataclass(frozen=True)
class DiffuseGrid(QuarterGrid, Discretisation):
    """Lambertian facets: light may turn down again.

    q is a sum over facets of a product, so that parities of <-d, m> and of <w, m> in the facet's
    azimuth multiply. Facets are spaced evenly after the stretch that makes the roughness 1.
    """

    material: Material

    def kernel(self) -> Kernel:
        """Scattering between the nodes."""
        rows = self.rows(self.nodes)
        scale = self._balance.behind * self.weight
        turn = self._albedo(self._behind * scale * scale[:, None])
        return Kernel(self.nodes[2], rows.sigma, self.weight, rows.down, rows.across, turn)

    def rows(self, d: Array) -> Rows:
        """Scattering from directions (3, rows) to the nodes; the sign of z is of no account."""
        w = np.array([-d[0], -d[1], np.abs(d[2])])
        across, down = self._scatter(w, self.nodes), self._scatter(w, self._mirrored)
        scale = self._balance
        own = scale.rows(across[0], down[0], self.slopes.sigma(-w))[:, None]
        across, down = across * own * scale.front, down * own * scale.behind * self.weight
        return Rows(w[2], self.slopes.sigma(w), self._albedo(down), self._albedo(across))

    @cached_property
    def _mirrored(self) -> Array:
        """The nodes' directions (3, n) below the horizon."""
        return self.nodes * np.array([[1], [1], [-1]])

    @cached_property
    def _behind(self) -> Array:
        """q from upward nodes to downward ones."""
        return self._scatter(-self.nodes, self._mirrored)

    @cached_property
    def _balance(self) -> KernelScale:
        w = self.nodes * np.array([[-1], [-1], [1]])
        across, down = self._scatter(w, self.nodes)[0], self._scatter(w, self._mirrored)[0]
        sigma, sigma_up = self.slopes.sigma(-self.nodes), self.slopes.sigma(self.nodes)
        return balance(across, down, self._behind[0], self.weight, sigma, sigma_up)

    def _albedo(self, q: Array) -> Array:
        """q for each channel."""
        channels: Array = np.multiply.outer(np.array(self.material.albedos), q)
        return channels

    @cached_property
    def _facets(self) -> tuple[Array, Array]:
        """Normals (3, n) of a quarter of the facets, and weights D(m) dm / pi."""
        n = FACETS * self.quarter
        u, du = gauss(FACETS * self.elevations.n)
        theta = np.repeat(np.pi / 2 * u, n)
        phi = np.tile((np.arange(n) + 0.5) * np.pi / (2 * n), u.size)
        area = np.repeat(np.pi / 2 * du, n) * np.sin(theta) * np.pi / (2 * n)
        alpha_x, alpha_y = self.slopes.alpha
        x, y = alpha_x * np.sin(theta) * np.cos(phi), alpha_y * np.sin(theta) * np.sin(phi)
        m = np.stack([x, y, np.cos(theta)])
        length = np.sqrt(dot(m, m))
        m /= length
        return m, self.slopes.D(m) * area * alpha_x * alpha_y / (np.pi * length**3)

    def _scatter(self, before: Array, after: Array) -> Array:
        """q (blocks, n, n') for albedo 1, between directions seen from a facet: towards where
        light comes from (3, n) and where it goes (3, n')."""
        m, weight = self._facets
        q = np.zeros((self.blocks, before.shape[1], after.shape[1]))
        step = max(CHUNK // max(before.shape[1], after.shape[1]), 1)
        for i in range(0, weight.size, step):
            part = slice(i, i + step)
            a, b = self._seen(before, m[:, part]), self._seen(after, m[:, part])
            q += a * (weight[part] / 4) @ np.swapaxes(b, -1, -2)
        return q

    def _seen(self, w: Array, m: Array) -> Array:
        """Parts (blocks, n, facets) of <w, m> of each parity, summed over mirror images of m."""
        x, y, z = (np.multiply.outer(w[i], m[i]) for i in range(3))
        images = np.stack([np.maximum(sx * x + sy * y + z, 0) for sx, sy in MIRRORS])
        return np.tensordot(parities(self.blocks), images, 1)
