"""Paths under way between facets: how they scatter, and what they send towards given directions.

Directions are in the frame of the side they travel in, see `surfaces.materials`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from msbsdf_cli.methods.base import Outgoing
from msbsdf_cli.methods.estimate import Estimate
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import BLOCK
from surfaces.batch import Batch, concatenate
from surfaces.facet import Array, dot
from surfaces.materials import Material


@dataclass(kw_only=True)
class Paths(Batch):
    """Paths on their way to a facet, or at it. One entry for each, or None where of no use."""

    d: Array
    """Direction of travel, (3, n)."""
    sigma: Array
    """sigma(d), (n,)."""
    slot: Array
    """Number within the batch, (n,)."""
    weight: Array | None = None
    """Energy left in each channel, (channels, n)."""
    inside: Array | None = None
    """Who travels in the inner medium, (n,) of bool."""
    start: Array | None = None
    """Number of the direction that the path starts from, where they differ, (n,); with a texture
    roughness differs alike."""
    m: Array | None = None
    """Normal of the facet that was met, (3, n), of length 1 unless facets are specular."""

    @property
    def n(self) -> int:
        """The number of paths."""
        return self.slot.size


P = TypeVar("P", bound=Paths)


def arriving(slopes: Slopes, material: Material, d: Array, inside: Array) -> dict[str, Any]:
    """The columns of paths about to meet their first facet, along `d` (3, n)."""
    n = d.shape[1]
    return {
        "d": d,
        "sigma": slopes.sigma(d),
        "slot": np.arange(n),
        "weight": np.ones((material.channels, n), d.dtype) if material.absorbs else None,
        "inside": inside if material.transmits else None,
    }


def follow(
    slopes: Slopes,
    material: Material,
    paths: P,
    directions: int,
    estimate: Estimate,
    rng: np.random.Generator,
    value: Callable[[P], Array],
    go_on: Callable[[P], P],
    order: int = 1,
) -> None:
    """Add `value` (channels, n, directions) of paths at their facet number `order`, and at all
    later ones, until none is left. `go_on` leads to the next facet those that meet one."""
    while paths.n:
        if order > estimate.orders and estimate.tail is None:
            paths.slot = np.arange(paths.n)
            estimate.open_tail(paths.n, directions, paths.start)
        staying = []
        for block in paths.blocks(BLOCK):
            block.m = meet(slopes, material, block, rng)
            for piece in block.blocks(lanes_for(directions)):
                estimate.add(order, value(piece), piece.slot, piece.start)
            staying.append(go_on(block))
        paths = concatenate(staying)
        order += 1


def meet(slopes: Slopes, material: Material, paths: Paths, rng: np.random.Generator) -> Array:
    """Normals of the facets that the paths meet, visible to them."""
    slopes = slopes.at(paths.start)
    m = slopes.visible_normals(-paths.d, paths.n, rng)
    return m if material.specular else m / np.sqrt(dot(m, m))


def scatter(
    slopes: Slopes, material: Material, paths: P, m: Array, rng: np.random.Generator
) -> tuple[P, Array | None]:
    """The paths after their facets `m`, and who of them changed sides."""
    slopes, material = slopes.at(paths.start), material.at(paths.start)
    d, gain, transmitted = material.scatter(paths.d, m, paths.inside, rng)
    weight, inside = paths.weight, paths.inside
    if gain is not None and weight is not None:
        weight = weight * gain
    if transmitted is not None and inside is not None:
        d = np.where(transmitted, -d, d)
        inside = inside ^ transmitted
    after = replace(paths, d=d, sigma=slopes.sigma(d), weight=weight, inside=inside, m=None)
    return after, transmitted


def next_event(
    slopes: Slopes, material: Material, paths: Paths, out: Outgoing
) -> tuple[Array, Array | None]:
    """What the facet sends towards all outgoing directions: the phase function, per steradian, (n,
    directions), and the share of each channel, (channels, n, directions) or broadcasting to it.

    For diffuse facets it is that of the one normal that was met, an unbiased stand-in.
    """
    if out.each:
        return _own_event(slopes, material, paths, out)
    if not material.specular:
        assert paths.m is not None
        phase = material.lobe(paths.m.T @ out.w)
        return np.where(out.inside, 0, phase), material.kept(phase.dtype)[:, None]
    d, w = paths.d[:, :, None], out.w[:, None, :]
    sigma = paths.sigma[:, None]
    if paths.inside is None:
        density, colour = material.reflection(slopes, d, w)
        return np.where(out.inside, 0, density / sigma), colour
    phase = np.empty((paths.n, out.n), d.dtype)
    for here in (False, True):
        for there in (False, True):
            lanes = np.flatnonzero(paths.inside == here)
            ends = np.flatnonzero(out.inside == there)
            if lanes.size and ends.size:
                ends_of_lanes = np.ix_(lanes, ends)
                pair = d[:, lanes], w[:, :, ends]
                if here == there:
                    density, _ = material.reflection(slopes, *pair, here)
                else:
                    density = material.refraction(slopes, *pair, here)
                phase[ends_of_lanes] = density / sigma[lanes]
    return phase, None


def _own_event(
    slopes: Slopes, material: Material, paths: Paths, out: Outgoing
) -> tuple[Array, Array | None]:
    """`next_event` where each path looks towards a direction of its own, (n, 1)."""
    w, inside = out.w[:, paths.start], out.inside[paths.start]
    if not material.specular:
        assert paths.m is not None
        phase = material.lobe(dot(paths.m, w))
        colour: Array | None = material.at(paths.start).kept(phase.dtype)
    else:
        density, colour = pair_density(slopes, material, paths, w, inside)
        phase = density * material.squared_index(inside) / paths.sigma
    if paths.inside is None:
        phase = np.where(inside, 0, phase)
    return phase[:, None], None if colour is None else colour[:, :, None]


def coloured(phase: Array, colour: Array | None, weight: Array | None) -> Array:
    """Values (n, directions) in each channel, (channels, n, directions)."""
    value = phase[None]
    if colour is not None:
        value = value * colour
    return value if weight is None else value * weight[:, :, None]


def lanes_for(directions: int) -> int:
    """How many paths fill a block when each looks towards so many directions."""
    return max(1, BLOCK // directions)


def pair_density(
    slopes: Slopes, material: Material, paths: Paths, w: Array, inside: Array | None
) -> tuple[Array, Array | None]:
    """q of specular facets from the paths' directions to `w` (3, n), on the sides `inside`, over
    the squared index on that side: the same from both ends; and a metal's colour.

    Light carries energy, whose density per steradian grows with the square of the index.
    """
    slopes = slopes.at(paths.start)
    if paths.inside is None or inside is None:
        return material.reflection(slopes, paths.d, w)
    density = np.empty(paths.n, w.dtype)
    for here in (False, True):
        for there in (False, True):
            lanes = np.flatnonzero((paths.inside == here) & (inside == there))
            pair = slopes.at(lanes), paths.d[:, lanes], w[:, lanes]
            if here == there:
                part = material.reflection(*pair, here)[0]
            else:
                part = material.refraction(*pair, here)
            density[lanes] = part / material.squared_index(there)
    return density, None


def reversed_phase(slopes: Slopes, material: Material, before: Paths, after: Paths) -> Array:
    """The phase function (n,) of light that comes back along the paths `after` a facet, for
    where the paths came from `before` it; colour aside, and for diffuse facets that of the
    normal that was met."""
    if not material.specular:
        assert before.m is not None
        return material.lobe(-dot(before.d, before.m))
    density, _ = pair_density(slopes, material, before, after.d, after.inside)
    if before.inside is not None:
        density = density * material.squared_index(before.inside)
    return density / slopes.at(before.start).sigma(-after.d)
