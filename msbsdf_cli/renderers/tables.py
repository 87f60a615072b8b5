"""A solved BSDF as a table that renderers interpolate.

Of mirrors, metals and glass the first order has a closed form, in which a lobe may be as narrow as
it likes; the table holds the later orders, which are wide. Of diffuse facets it holds all.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.base import outgoing
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.single import first_order
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.renderers.nodes import Nodes
from msbsdf_cli.renderers.splines import REACH, coefficients, spline
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Dielectric, Material

SLOPES = ("beckmann", "ggx")
"""Slope distributions that renderers have."""

CHANNELS = (1, 3)
"""Numbers of channels that renderers have."""

BLOCKS = ("reflected outside", "transmitted inwards", "reflected inside")
"""Blocks of a table; of opaque facets the first alone. What is transmitted outwards follows by
reciprocity."""


@dataclass(frozen=True)
class BsdfTable:
    """BSDF values of the orders that have no closed form."""

    slopes: Slopes
    material: Material
    nodes: Nodes
    values: Array
    """Per steradian, without the cosine, (channels, blocks, azimuths of incidence, elevations in,
    elevations out, azimuths between)."""

    def evaluate(self, wi: Array, wo: Array) -> Array:
        """BSDF x |cos(theta_o)|, (channels, n), for a unit vector (3,) and unit vectors (3, n), on
        either side of the surface: what a renderer makes of the table."""
        found = self.later(wi, wo) * np.abs(wo[2])
        if self.material.specular:
            found = found + first_value(self.slopes, self.material, wi, wo)
        return np.asarray(found)

    def later(self, wi: Array, wo: Array) -> Array:
        """BSDF of the table's orders, (channels, n), for `wi` (3,) or (3, n)."""
        wi = np.broadcast_to(wi.reshape(3, -1), wo.shape)
        inside, crosses = wi[2] < 0, wi[2] * wo[2] < 0
        if not self.material.transmits:
            crosses = np.zeros_like(crosses)
        block, outwards = np.where(crosses, 1, 2 * inside), inside & crosses
        lit, seen = np.where(outwards, wo, wi), np.where(outwards, wi, wo)
        upright = [[1], [1], [-1]]
        lit, seen = (np.where(w[2] < 0, w * upright, w) for w in (lit, seen))
        places = self.nodes.places(lit, seen, crosses)
        found = np.array([self._spline(c, block, places) for c in range(len(self.values))])
        dark = (wi[2] * wo[2] == 0) | ((inside | (wo[2] < 0)) & (not self.material.transmits))
        return np.where(dark, 0, np.maximum(found, 0) / np.where(outwards, self.material.ior**2, 1))

    def _spline(self, channel: int, block: Array, places: tuple[Array, ...]) -> Array:
        found = np.empty(block.size)
        for b in range(self.values.shape[1]):
            lanes = np.flatnonzero(block == b)
            part = tuple(p[lanes] for p in places)
            if self.nodes.incident == 1:
                found[lanes] = spline(self.coefficients[channel, b, 0], part[1:])
            else:
                found[lanes] = spline(self.coefficients[channel, b], part)
        return found

    @cached_property
    def coefficients(self) -> Array:
        """Of the spline through the values, as `values` and with margins at both ends of all but
        the azimuth of incidence of one roughness."""
        return table_coefficients(self.values, self.nodes)


def table_coefficients(values: Array, nodes: Nodes) -> Array:
    """The coefficients of a table's values (channels, blocks, azimuths of incidence, elevations in,
    elevations out, azimuths between), extended by what symmetry says lies beyond the ends."""
    for axis in (3, 4):
        parts = np.split(values, [nodes.before] if nodes.before else [], axis)
        values = np.concatenate([coefficients(part, axis) for part in parts], axis)
    incident, azimuths = values.shape[2], values.shape[5]
    if incident == 1:
        reach = min(REACH, azimuths - 1)
        values = np.pad(values, [(0, 0)] * 5 + [(reach, reach)], mode="reflect")
        return _ended(values, 5, reach)
    # A quarter of a turn further on are mirror images, of which azimuths between run the other way
    # round, and after half a turn the same again.
    mirrored, half = np.roll(values[..., ::-1], 1, axis=-1), 2 * (incident - 1)
    numbers = np.mod(np.arange(-REACH, incident + REACH), half)
    circle = [values[:, :, k] if k < incident else mirrored[:, :, half - k] for k in numbers]
    values = np.pad(np.stack(circle, axis=2), [(0, 0)] * 5 + [(REACH, REACH + 1)], mode="wrap")
    return _ended(_ended(values, 5, REACH), 2, REACH)


def _ended(values: Array, axis: int, reach: int) -> Array:
    """Coefficients along an axis that was extended by `reach` either way, its margins kept."""
    found = coefficients(values, axis)
    # A margin has been put in front.
    kept = np.arange(reach, found.shape[axis] - reach)
    return np.take(found, kept, axis)


def first_value(slopes: Slopes, material: Material, wi: Array, wo: Array) -> Array:
    """BSDF x |cos(theta_o)| of the first order, (channels, n), for `wi` (3,) and `wo` (3, n) on
    either side of the surface."""
    if wi[2] < 0:
        wi, wo, material = wi * [1, 1, -1], wo * [[1], [1], [-1]], other_side(material)
    return first_order(slopes, material, wi, outgoing(slopes, wo))


def other_side(material: Material) -> Material:
    """The material as light from inside meets it."""
    return Dielectric(1 / material.ior)


def check(slopes: Slopes, material: Material) -> None:
    """Raise UnsupportedError for what no table is made of."""
    if slopes.name not in SLOPES:
        raise UnsupportedError(f"renderers have slopes {' and '.join(SLOPES)}, not {slopes.name}")
    if material.channels not in CHANNELS:
        raise UnsupportedError(f"renderers have 1 channel or 3, not {material.channels}")
    if material.transmits and slopes.alpha_x != slopes.alpha_y:
        raise UnsupportedError(
            "tables of facets that transmit have one roughness, and there are two: a core would "
            "take half an hour or more for all pairs of directions"
        )
    Solve.check_supported(slopes, material)
