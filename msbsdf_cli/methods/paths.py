"""Paths under way between facets: how they scatter, and what they send towards given directions.

Directions are in the frame of the side they travel in, see `msbsdf_cli.smith.kernel`.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Self, TypeVar

import numpy as np

from msbsdf_cli.methods.directions import Exits
from msbsdf_cli.methods.estimate import BLOCK
from msbsdf_cli.smith.kernel import reflection_density, refraction_density, relative_ior
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot
from surfaces.materials import Dielectric, Diffuse, Material


@dataclass(kw_only=True)
class Paths:
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
    m: Array | None = None
    """Normal of the facet that was met, (3, n), of any length; of length 1 if it is diffuse."""

    @property
    def n(self) -> int:
        return self.slot.size

    def each(self, pick: Callable[[Array], Array]) -> Self:
        """The same selection from each column that is there."""
        columns: dict[str, Any] = vars(self)
        return type(self)(**{k: None if a is None else pick(a) for k, a in columns.items()})

    def compress(self, keep: Array) -> Self:
        """The paths for which `keep` holds."""
        if keep.all():
            return self
        lanes = np.flatnonzero(keep)
        return self.each(lambda a: a.take(lanes, axis=-1))

    def blocks(self, size: int) -> Iterator[Self]:
        """Pieces of at most `size` paths."""
        for start in range(0, self.n, size):
            yield self.each(lambda a, start=start: a[..., start : start + size])


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


def meet(slopes: Slopes, material: Material, paths: Paths, rng: np.random.Generator) -> Array:
    """Normals of the facets that the paths meet, visible to them."""
    m = slopes.visible_normals(-paths.d, paths.n, rng)
    return m / np.sqrt(dot(m, m)) if isinstance(material, Diffuse) else m


def scatter(
    slopes: Slopes, material: Material, paths: P, m: Array, rng: np.random.Generator
) -> tuple[P, Array | None]:
    """The paths after their facets `m`, and who of them changed sides."""
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
    slopes: Slopes, material: Material, paths: Paths, out: Exits
) -> tuple[Array, Array | None]:
    """What the facet sends towards all the exits: the phase function, per steradian, (n, exits),
    and the share of each channel, (channels, n, exits) or broadcasting to it.

    For diffuse facets it is that of the one normal that was met, an unbiased stand-in.
    """
    if isinstance(material, Diffuse):
        assert paths.m is not None
        phase = np.maximum(paths.m.T @ out.w, 0) / np.pi
        return np.where(out.inside, 0, phase), np.array(material.albedo, phase.dtype)[:, None, None]
    d, w = paths.d[:, :, None], out.w[:, None, :]
    sigma = paths.sigma[:, None]
    if paths.inside is None:
        density, colour = reflection_density(slopes, material, d, w)
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
                    density, _ = reflection_density(slopes, material, *pair, here)
                else:
                    density = refraction_density(slopes, material, *pair, here)
                phase[ends_of_lanes] = density / sigma[lanes]
    return phase, None


def coloured(phase: Array, colour: Array | None, weight: Array | None) -> Array:
    """Values (n, exits) in each channel, (channels, n, exits)."""
    value = phase[None]
    if colour is not None:
        value = value * colour
    return value if weight is None else value * weight[:, :, None]


def lanes_for(out: Exits) -> int:
    """How many paths fill a block when each looks towards all the exits."""
    return max(1, BLOCK // out.n)


def concatenate(parts: list[P]) -> P:
    """The pieces, put together again."""
    if len(parts) == 1:
        return parts[0]
    columns: dict[str, Any] = {
        name: None if first is None else np.concatenate([vars(p)[name] for p in parts], axis=-1)
        for name, first in vars(parts[0]).items()
    }
    return type(parts[0])(**columns)


def reversed_phase(
    slopes: Slopes, material: Material, before: Paths, after: Paths, transmitted: Array | None
) -> Array:
    """The phase function (n,) of light that comes back along the paths `after` a facet, for
    where the paths came from `before` it; colour aside, and for diffuse facets that of the
    normal that was met."""
    d, w = before.d, after.d
    if isinstance(material, Diffuse):
        assert before.m is not None
        return -dot(d, before.m) / np.pi
    sigma = slopes.sigma(-w)
    if transmitted is None or before.inside is None:
        return reflection_density(slopes, material, d, w)[0] / sigma
    assert isinstance(material, Dielectric)
    density = np.empty_like(sigma)
    for inside in (False, True):
        for through in (False, True):
            lanes = np.flatnonzero((before.inside == inside) & (transmitted == through))
            pair = d[:, lanes], w[:, lanes]
            if through:
                # Energy per steradian, and steradians widen with the square of the index.
                eta = relative_ior(material, inside)
                density[lanes] = refraction_density(slopes, material, *pair, inside) / eta**2
            else:
                density[lanes] = reflection_density(slopes, material, *pair, inside)[0]
    return density / sigma
