"""Named random streams: every generator of a run is made here, from the seed and a key.

NumPy pads seeds with zeros, so that `SFC64([s, n])` and `SFC64([s, n, 0])` are one stream. Here a
key is the stream's name and its place within it, each in words of fixed width behind the seed's
own, and so no two keys are the same numbers (M. E. O'Neill's seed sequence, `numpy.random`).
"""

from zlib import crc32

import numpy as np

STREAMS = {
    "heightfield": "a realisation of the surface: number, period, waves",
    "rays": "light traced on a surface: number of the surface, incident angle",
    "free-path rays": "free paths traced on a surface: number of the surface, scene",
    "sweep": "the seed of a piece of work: what it measures",
    "convergence heightfield": "parameter varied, number, period, waves",
    "convergence rays": "parameter varied, number of the surface, period, waves, incident angle",
    "pilot walks": "walks that tell how much light meets a second facet: facets, incident angle",
    "pilot of time": "walks that tell how long others will take: incident angle",
    "walk": "random walks: incident angle of each of several slopes in turn, part",
    "walk free paths": "free paths of the Smith model",
    "evaluate": "a method's values: method, incident angle, part",
    "furnace": "a method's albedos: method, roughness, incident angle, repetition",
    "identity": "an identity: its name, its configuration",
    "lobe directions": "outgoing directions in which methods are judged",
    "reference walks": "walks that stand in for `solve`: what is measured, incident angle",
    "model lobe": "samples of a model: its name, incident angle, part",
    "order of runs": "the order in which methods take turns: what is measured, round",
    "timed run": "a timed evaluation: what is measured, round, series",
    "shared work": "work that processes share: method, round, part",
    "noise of distances": "what noise alone makes of a distance",
    "stability": "a method where it may fail: method, precision, point, number of the draw",
    "stability timing": "evaluations that are timed: method, walks, number",
    "stability walks": "long walks that are the truth of a point: point",
    "stability pilot": "walks that tell how many facets light meets: point",
    "stability directions": "outgoing directions of a point: point, repetition",
    "stability reference": "directions of long walks: point",
    "export pairs": "directions in which a table is held against what it was made from",
    "table directions": "directions in which a table for pictures is held against `solve`",
    "without noise": "handed to methods that draw nothing",
    "render": "paths from the camera: method, strategy, some of the pixels, picture",
    "slab": "walks to a slab's image: method, roughness, repetition",
    "swapped ends": "values of a picture from either end: method, end, batch",
}
"""Name of every stream, and what it serves; the numbers of its place are named after the colon."""

COMMON = {
    "heightfield": "a realisation is the same field in whatever fineness it is meshed",
    "rays": "the same rays meet the same field on two meshes, and tell these apart",
    "free-path rays": "free paths on two meshes of one field tell these apart",
    "sweep": "the seed of a piece is told wherever it is wanted, and nothing else is drawn",
    "pilot walks": "walks that decide on a resolution, and are no part of any result",
    "pilot of time": "walks that are timed, and are no part of any result",
    "convergence heightfield": "cells and offsets are varied on the same fields",
    "convergence rays": "cells and offsets are varied under the same rays",
    "noise of distances": "the same draws, scaled, serve every distance",
    "shared work": "the same work is timed on one process and on several",
    "stability timing": "the same work at ordinary roughness and elsewhere",
    "stability directions": "all methods and precisions are judged in the same directions",
    "stability reference": "all methods and precisions are held against the same walks",
    "without noise": "nothing is drawn from it",
    "table directions": "tables of all roughnesses are judged in the same directions",
    "lobe directions": "lobes of all incident angles are judged in directions drawn alike",
}
"""Streams that are drawn more than once on purpose, and why: their differences have less noise."""

WORD = 1 << 32


def seed_sequence(seed: int, name: str, *place: int | str) -> np.random.SeedSequence:
    """The seed of the stream `name` at `place`, for generators that NumPy does not make.

    `seed` and the numbers of `place` are at least 0, and those of `place` below 2^63. Raises
    KeyError for a name that is not in `STREAMS`, and ValueError for a number out of range.
    """
    if name not in STREAMS:
        raise KeyError(f"{name!r} is not the name of a random stream")
    words = [word for part in (name, *place) for word in _words(part)]
    return np.random.SeedSequence(seed, spawn_key=words)


def stream(seed: int, name: str, *place: int | str) -> np.random.Generator:
    """The generator of the stream `name` at `place`; see `seed_sequence`."""
    return generator(seed_sequence(seed, name, *place))


def generator(seed: np.random.SeedSequence) -> np.random.Generator:
    """The project's generator, of a seed from `seed_sequence`."""
    return np.random.Generator(np.random.SFC64(seed))


def _words(part: int | str) -> tuple[int, int]:
    """Two words of 32 bits: a number below 2^63, or a text by its checksum, which is above."""
    if isinstance(part, str):
        return crc32(part.encode()), WORD - 1
    if not 0 <= part < 1 << 63:
        raise ValueError(f"{part} is not a place in a random stream: 0 to 2^63 - 1")
    return part % WORD, part // WORD
