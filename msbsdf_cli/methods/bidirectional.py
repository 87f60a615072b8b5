"""Bidirectional estimation of the position-free models: all connections of two sub-paths.

Let g_0 ... g_n be the directions of a path, g_0 = -wi and g_n = wo. The strategy s samples
g_1 ... g_s from wi and the others from wo, and connects the two at facet s + 1. With the symmetric
kernel q (that of energy over the squared index of the side it goes to), L_i = sigma(g_i) / |z_i|,
L'_i = sigma(-g_i) / |z_i| and probabilities r, r' to go on, its density times |z_1| ... |z_n-1| is

    (q_1 ... q_n) / q_(s+1) |z_s| |z_(s+1)|  P_s  P'_(s+1)
    P_s = product of 1 / L_i, i < s, and r_i, 1 <= i <= s       (P' likewise from the other end)

up to a factor of the ends alone. The balance heuristic divides by the sum over all s. Each end
keeps the part of that sum whose connections lie on its own side as a running sum X.
"""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.methods.base import Outgoing, adjoint_weight
from msbsdf_cli.methods.estimate import Estimate
from msbsdf_cli.methods.path_factors import leaving_probability, meeting_probability
from msbsdf_cli.methods.paths import Paths, arriving, meet, pair_density, scatter
from msbsdf_cli.smith.integrated_heights import extinction_of
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import BLOCK
from surfaces.facet import Array, dot
from surfaces.materials import Material


@dataclass(kw_only=True)
class SubPath(Paths):
    """One end of paths, up to the direction `d` (g_s, or -g_(s+1) from the other end)."""

    L: Array
    """sigma(d) / |d_z|, (n,)."""
    back: Array
    """sigma(-d) / |d_z|, (n,)."""
    P: Array
    """P_s of the module's text, (n,)."""
    X: Array
    """Sum over the strategies that connect on this side, up to what lies beyond `d`, (n,)."""
    S: Array
    """Segment factors of the facets passed, (n,): probabilities over L of the direction before."""


@dataclass(frozen=True)
class Model:
    """What both ends need to know."""

    slopes: Slopes
    material: Material
    correlated: bool


def connect_bidirectionally(
    slopes: Slopes,
    material: Material,
    correlated: bool,
    wi: Array,
    n: int,
    out: Outgoing,
    estimate: Estimate,
    rng: np.random.Generator,
) -> None:
    """Add `n` sub-paths from `wi` (3,), each connected with one sub-path from each outgoing
    direction."""
    model = Model(slopes, material, correlated)
    lanes = max(1, BLOCK // out.n)
    for first in range(0, n, lanes):
        _connect_block(model, wi, min(lanes, n - first), out, estimate, rng)


def _connect_block(
    model: Model, wi: Array, n: int, out: Outgoing, estimate: Estimate, rng: np.random.Generator
) -> None:
    pairs = n * out.n
    start = np.tile(np.arange(out.n), n)
    d = np.tile(-wi[:, None], n)
    from_wi = _walk(model, d, np.zeros(n, bool), False, rng)
    from_wo = _walk(model, -out.w[:, start], out.inside[start], True, rng)
    scale = adjoint_weight(model.material, out)[start]
    total = np.zeros((model.material.channels, estimate.orders + 1, pairs))
    where = np.full(n, -1)
    for s, one in enumerate(from_wi):
        where[:] = -1
        where[one.slot] = np.arange(one.n)
        for t, other in enumerate(from_wo):
            position = where[other.slot // out.n]
            both = np.flatnonzero(position >= 0)
            if s + t and both.size:
                a = one.take(position[both])
                b = other.take(both)
                row = min(s + t, estimate.orders)
                total[:, row, b.slot] += _connect(model, a, b, last=t == 0) * scale[b.slot]
    estimate.open_tail(pairs, 1, start)
    for order in range(2, estimate.orders + 2):
        estimate.add(order, total[:, order - 1, :, None], np.arange(pairs), start)
    estimate.close_batch()


def _walk(
    model: Model, d: Array, inside: Array, reverse: bool, rng: np.random.Generator
) -> list[SubPath]:
    """Sub-paths along `d`, one entry for each length, with the facet met at their end."""
    slopes, n = model.slopes, d.shape[1]
    columns = arriving(slopes, model.material, d, inside)
    one = np.ones(n, d.dtype)
    path = SubPath(
        **columns,
        L=extinction_of(d, columns["sigma"]),
        back=extinction_of(d, slopes.sigma(-d)),
        P=one,
        X=np.zeros(n, d.dtype),
        S=one,
    )
    path.m = meet(slopes, model.material, path, rng)
    lengths = [path]
    while True:
        path = _step(model, path, reverse, len(lengths) == 1, rng)
        if path.n == 0:
            return lengths
        path.m = meet(slopes, model.material, path, rng)
        lengths.append(path)


def _step(
    model: Model, path: SubPath, reverse: bool, first: bool, rng: np.random.Generator
) -> SubPath:
    """One facet further; an upward direction is followed with the probability Lambda / (1 + Lambda)
    of the uncorrelated model, so that sub-paths end, and always by the same rule."""
    slopes, material = model.slopes, model.material
    assert path.m is not None
    after, transmitted = scatter(slopes, material, path, path.m, rng)
    through: Array | bool = False if transmitted is None else transmitted
    d = after.d
    after.L = extinction_of(d, after.sigma)
    after.back = extinction_of(d, slopes.sigma(-d))
    survives = np.where(d[2] > 0, after.L / (1 + after.L), 1)
    # A direction that goes up here goes down seen from the other end, and the reverse.
    survives_back = np.where(d[2] < 0, after.back / (1 + after.back), 1)
    density = _sampled_density(model, path, after, reverse)
    if reverse:
        before, ahead, ahead_L = after.back, -path.d, path.back
    else:
        before, ahead, ahead_L = path.L, d, after.L
    probability_of = leaving_probability if reverse and first else meeting_probability
    after.S = path.S * probability_of(before, ahead, ahead_L, through, model.correlated) / before
    possible = density > 0
    here = np.abs(path.d[2] * d[2]) * path.P / np.where(possible, density, 1)
    after.X = (path.X / after.back + here) * survives_back
    after.P = path.P / path.L * survives
    return after.compress(possible & (rng.random(after.n, dtype=d.dtype) < survives))


def _sampled_density(model: Model, path: SubPath, after: SubPath, reverse: bool) -> Array:
    """What q_(s+1) is had the two directions at this facet been connected, (n,).

    A diffuse facet is always the one that light from wi finds, whichever end walks.
    """
    if model.material.specular:
        return pair_density(model.slopes, model.material, path, after.d, after.inside)[0]
    assert path.m is not None
    if reverse:
        return model.slopes.sigma(-after.d) * model.material.lobe(-dot(path.d, path.m))
    return path.sigma * model.material.lobe(dot(after.d, path.m))


def _connect(model: Model, a: SubPath, b: SubPath, last: bool) -> Array:
    """What the connected paths contribute, (channels, n), the factor of the far end aside;
    `last`: those whose last facet is the one that connects."""
    slopes, material = model.slopes, model.material
    assert a.m is not None
    w = -b.d
    if not material.specular:
        density = a.sigma * material.lobe(dot(w, a.m))
        colour: Array | None = np.array(material.albedos, density.dtype)[:, None]
    else:
        density, colour = pair_density(slopes, material, a, w, b.inside)
    through: Array | bool = False
    if a.inside is not None and b.inside is not None:
        through = a.inside != b.inside
    probability_of = leaving_probability if last else meeting_probability
    probability = probability_of(a.L, w, b.back, through, model.correlated)
    here = np.abs(a.d[2] * w[2]) * a.P * b.P
    elsewhere = a.X * b.P / b.L + b.X * a.P / a.L
    segments = a.S * b.S * probability / a.L
    value = segments * density / np.maximum(here + density * elsewhere, np.finfo(w.dtype).tiny)
    value = np.broadcast_to(value, (material.channels, a.n))
    for throughput in (colour, a.weight, b.weight):
        if throughput is not None:
            value = value * throughput
    return value
