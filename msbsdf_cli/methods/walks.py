"""Walks in the coordinate t: their first facet, the way on from any, and the chance to leave."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from msbsdf_cli.methods.base import Outgoing
from msbsdf_cli.methods.paths import Paths, arriving, meet, scatter
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import exponential, flip, free_path
from surfaces.facet import Array
from surfaces.materials import Material


@dataclass(kw_only=True)
class Walks(Paths):
    """Paths with their coordinate t = -ln C1(h), at the facet they met."""

    t: Array


W = TypeVar("W", bound=Walks)


def first_facet(
    slopes: Slopes,
    material: Material,
    d: Array,
    inside: Array,
    rng: np.random.Generator,
    start: Array | None = None,
) -> Walks:
    """Walks along `d` (3, n) from outside at their first facet: a free path from t = 0."""
    columns = arriving(slopes, material, d, inside)
    E = exponential(d.shape[1], rng, d.dtype.type)
    _, t = free_path(np.zeros(d.shape[1], d.dtype), d, columns["sigma"], E)
    return Walks(**columns, t=t, start=start)


def leave_facet(slopes: Slopes, material: Material, walks: W, rng: np.random.Generator) -> W:
    """The walks in their directions after the facet."""
    assert walks.m is not None
    after, transmitted = scatter(slopes, material, walks, walks.m, rng)
    if transmitted is not None:
        after.t = np.where(transmitted, flip(after.t), after.t)
    return after


def escape(t: Array, inside: Array | None, ends: Outgoing) -> Array:
    """Probability exp(-Lambda t) of leaving in outgoing directions as paths see them, (n,
    directions), from `t` (n,)."""
    t = t[:, None]
    if inside is None:
        return np.exp(-t * ends.Lambda)
    same = inside[:, None] == ends.inside
    return np.where(same, np.exp(-t * ends.Lambda), np.exp(-flip(t) * ends.Lambda))


def sample_each(
    slopes: Slopes, material: Material, wi: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Where one random walk from each of `wi` (3, n) leaves, (3, n), and the energy (channels, n)
    that it has left ([HHdD16] Section 9)."""
    n = wi.shape[1]
    w, weight = np.empty_like(wi), np.ones((material.channels, n), wi.dtype)
    walks = first_facet(slopes, material, -wi, np.zeros(n, bool), rng, np.arange(n))
    while walks.n:
        walks.m = meet(slopes, material, walks, rng)
        walks = leave_facet(slopes, material, walks, rng)
        E = exponential(walks.n, rng, wi.dtype.type)
        leaves, walks.t = free_path(walks.t, walks.d, walks.sigma, E)
        done, walks = walks.compress(leaves), walks.compress(~leaves)
        w[:, done.start] = done.d if done.inside is None else np.where(done.inside, -done.d, done.d)
        if done.weight is not None:
            weight[:, done.start] = done.weight
    return w, weight
