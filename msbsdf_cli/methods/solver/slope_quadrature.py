"""Facets seen from a direction of travel: an integral over them, and where they send light.

A facet sends light in one direction after reflection and in one after transmission, so that to
scatter is to integrate over facets, however narrow the lobes are. On both sides of some edges
light behaves differently: total reflection begins at an angle to the facet, and what leaves just
above the horizon and just below it belongs to different nodes. In the plane of slopes, with x
along the light's azimuth and y across, these are conics about the axis y = 0, so that y^2 at an
edge is elementary, and between edges all is smooth but for square roots.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, fresnel_dielectric
from surfaces.quadrature import gauss


@dataclass(frozen=True)
class Edge:
    """A curve in the plane of slopes."""

    inclinations: Array
    """arctan(x) where the curve meets the axis y = 0, or another curve."""
    square: Callable[[Array], Array]
    """y^2 of the curve as a function of arctan(x); negative where it does not go."""


@dataclass(frozen=True)
class Light:
    """Directions of travel (3, n), and how much light goes there (n,)."""

    w: Array
    amount: Array


@dataclass(frozen=True)
class SlopeQuadrature:
    """Integrals over the facets that face a direction, with `panel` nodes between neighbouring
    edges along either axis. With `half` the facets on one side of the plane of incidence stand
    for both: all that matters to a surface of one roughness."""

    slopes: Slopes
    panel: int
    half: bool

    def scatter(self, d: Array, eta: float) -> tuple[Light, Light]:
        """What is reflected and what is transmitted of light that travels along `d` (3,) to
        facets of index `eta` behind over before: the integrals of <-d, m> F D(m) dm and of
        <-d, m> (1 - F) D(m) dm. Transmitted light is point-reflected."""
        theta = float(np.arctan2(np.hypot(d[0], d[1]), -d[2]))
        m, weight = self.facing(d, _edges(theta, eta, _mirror_horizon(theta), 2))
        cos_i, reflectance, _ = _fresnel(d, m, eta)
        reflected = _lit(d[:, None] + 2 * cos_i * m, weight * reflectance)
        m, weight = self.facing(d, _edges(theta, eta, _refraction_horizon(theta, eta), 1))
        cos_i, reflectance, cos_t = _fresnel(d, m, eta)
        w = (cos_t - cos_i / eta) * m - d[:, None] / eta
        return reflected, _lit(w, weight * (1 - reflectance))

    def mirror(self, d: Array, reflectance: Callable[[Array], Array]) -> Light:
        """What mirrors of a reflectance (n,) of the cosine reflect of light along `d` (3,)."""
        theta = float(np.arctan2(np.hypot(d[0], d[1]), -d[2]))
        m, weight = self.facing(d, [_mirror_horizon(theta)])
        cos_i = np.clip(-(d @ m), np.finfo(float).tiny, 1)
        return _lit(d[:, None] + 2 * cos_i * m, weight * reflectance(cos_i))

    def facing(self, d: Array, edges: list[Edge]) -> tuple[Array, Array]:
        """Unit normals (3, n) that face a direction of travel (3,), and weights <-d, m> D(m) dm.

        In units of the roughness slopes are u along the light's azimuth, and v across once their
        correlation is taken off; u = tan(omega) and v = sqrt(1 + u^2) tan(chi) make the plane
        finite, and GGX a product of cosines.
        """
        s, c = float(np.hypot(d[0], d[1])), -float(d[2])
        cos_phi, sin_phi = (d[0] / s, d[1] / s) if s > 0 else (1.0, 0.0)
        a_x, a_y = self.slopes.alpha
        along = np.hypot(a_x * cos_phi, a_y * sin_phi)
        across = a_x * a_y / along
        shear = cos_phi * sin_phi * (a_x - a_y) * (a_x + a_y) / along**2

        ends = np.concatenate([np.empty(0), *(e.inclinations for e in edges)])
        ends = np.arctan2(np.sin(ends), along * np.cos(ends))
        low = max(np.arctan2(-c, s * along), -self._tail)
        omega, d_omega = _panels(low, max(low, self._tail), ends, self.panel)
        u = np.tan(omega)
        x, stretch = along * u, np.sqrt(1 + u * u)

        y = np.sqrt(np.maximum([e.square(np.arctan(x)) for e in edges], 0)).T
        y = y if self.half else np.concatenate([-y, y], axis=1)
        ends = np.arctan((y - shear * x[:, None]) / (across * stretch)[:, None])
        bottom = 0 if self.half else -self._tail
        chi, d_chi = _panels(bottom, self._tail, ends, self.panel)
        tan_chi = np.tan(chi)
        y = (across * stretch)[:, None] * tan_chi + shear * x[:, None]

        x = np.broadcast_to(x[:, None], y.shape)
        length = np.sqrt(1 + x * x + y * y)
        m = np.stack([-x * cos_phi - y * sin_phi, y * cos_phi - x * sin_phi, np.ones_like(x)])
        m = (m / length).reshape(3, -1)
        area = a_x * a_y * (stretch**3 * d_omega)[:, None] * (1 + tan_chi * tan_chi) * d_chi
        weight = ((c + s * x) * area / length**4).ravel() * self.slopes.D(m)
        return m, (2 if self.half else 1) * weight

    @cached_property
    def _tail(self) -> float:
        """The omega beyond which the area of all facets together is lost in rounding."""

        def beyond(omega: float) -> float:
            d = np.array([np.cos(omega) / self.slopes.alpha_x, 0, np.sin(omega)])
            area = self.slopes.sigma(d[:, None] / np.hypot(d[0], d[2]))
            return float(area[0] / d[0] * np.hypot(d[0], d[2])) - float(np.finfo(float).eps)

        end = np.pi / 2 - float(np.finfo(float).eps) ** 0.5
        return np.pi / 2 if beyond(end) > 0 else float(brentq(beyond, 0, end))


def _lit(w: Array, amount: Array) -> Light:
    some = amount > 0
    return Light(w[:, some], amount[some])


def _fresnel(d: Array, m: Array, eta: float) -> tuple[Array, Array, Array]:
    """Cosine of incidence, reflectance and cosine of refraction."""
    cos_i = np.clip(-(d @ m), np.finfo(float).tiny, 1)
    return cos_i, *fresnel_dielectric(cos_i, eta)


def _panels(low: float, high: float, ends: Array, n: int) -> tuple[Array, Array]:
    """Nodes (..., m) and weights of an integral from `low` to `high` that is smooth but for
    square roots at `ends` (..., k): Gauss nodes between neighbours, crowded at the ends."""
    t, dt = gauss(n)
    count = ends.shape[-1]
    maps = [(t, dt)]
    if count:
        both = t * t * (3 - 2 * t), 6 * t * (1 - t) * dt
        before, after = (t * (2 - t), 2 * (1 - t) * dt), (t * t, 2 * t * dt)
        maps = [before, *(count - 1) * [both], after]
    place, share = (np.stack(part) for part in zip(*maps, strict=True))
    pad = [(0, 0)] * (ends.ndim - 1)
    ends = np.sort(np.clip(ends, low, high), axis=-1)
    ends = np.pad(ends, [*pad, (1, 0)], constant_values=low)
    ends = np.pad(ends, [*pad, (0, 1)], constant_values=high)
    start, width = ends[..., :-1, None], np.diff(ends)[..., None]
    flat = (*ends.shape[:-1], -1)
    return (start + width * place).reshape(flat), (width * share).reshape(flat)


def _edges(theta: float, eta: float, horizon: Edge, k: int) -> list[Edge]:
    """The edges for light at `theta` from the normal: of total reflection, and of the horizon.

    They cross where both conditions on cos_i m_z hold, k cos_i m_z = cos(theta) at the horizon.
    """
    if eta >= 1:
        return [horizon]
    s, c = np.sin(theta), np.cos(theta)
    crossing = np.arctan2(k * (1 - eta) * (1 + eta) - c * c, s * c)
    return [_total(theta, eta), Edge(np.append(horizon.inclinations, crossing), horizon.square)]


def _total(theta: float, eta: float) -> Edge:
    """Where total reflection begins: facets at the critical angle to the light."""
    critical = np.arcsin(eta)

    def square(a: Array) -> Array:
        inside = np.sin(critical - a + theta) * np.sin(critical + a - theta)
        y2: Array = inside / (np.cos(critical) * np.cos(a)) ** 2
        return y2

    return Edge(theta + np.array([-critical, critical]), square)


def _mirror_horizon(theta: float) -> Edge:
    """Facets that reflect light into the horizon."""

    def square(a: Array) -> Array:
        y2: Array = np.cos(2 * a - theta) / (np.cos(theta) * np.cos(a) ** 2)
        return y2

    return Edge(theta / 2 + np.array([-np.pi / 4, np.pi / 4]), square)


def _refraction_horizon(theta: float, eta: float) -> Edge:
    """Facets that refract light into the horizon: none but those that bend it that way."""
    s, c = np.sin(theta), np.cos(theta)

    def square(a: Array) -> Array:
        offset = np.sin(a - theta) / np.cos(a)
        y2: Array = (eta - offset) * (eta + offset) / c**2
        return y2

    return Edge(np.arctan((s + np.array([-eta, eta])) / c), square)
