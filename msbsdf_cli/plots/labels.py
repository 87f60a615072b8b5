"""Names of curves beside their ends, where they hide least."""

from itertools import pairwise
from typing import Any

import numpy as np

from msbsdf_cli.plots.style import HALO
from surfaces.facet import Array

LETTER, LINE = 0.056, 0.15
"""Inches of a letter of 7 points and of a line of them."""
STEP = 0.03
"""Inches between the places of a curve that are not to be hidden."""
DISTANCES, TURNS = (0.1, 0.18, 0.28, 0.42, 0.6, 0.8), 24
"""Of the places to try: inches from the end of a curve, and directions."""
FAR, FIRST_END, ON_NAME, OUTSIDE = 8, 1, 10, 1000
"""What a place costs, in places of curves hidden: an inch away; the first end in place of the
last; a place of a name; a corner outside the axes."""


def name_curves(axis: Any, curves: dict[str, tuple[Array, str]], around: Array) -> None:
    """Write the name of each curve, points (2, n) of the data, in its colour; nor are the points
    `around` (2, m) hidden. Limits and scales must be there."""
    dots = axis.figure.dpi
    ends = {name: axis.transData.transform(xy.T) / dots for name, (xy, _) in curves.items()}
    frame = axis.get_window_extent().get_points() / dots
    curve_points = [_along(points) for points in ends.values()]
    hidden = np.concatenate([*curve_points, axis.transData.transform(around.T) / dots])
    named = np.zeros((0, 2))
    for name, points in ends.items():
        half = np.array([LETTER * len(name), LINE]) / 2
        centre, end, distance = _candidates(points, half)
        cost = FAR * distance + FIRST_END * (end == 0) + _covered(hidden, centre, half)
        cost += ON_NAME * _covered(named, centre, half)
        cost += OUTSIDE * ((centre - half < frame[0]) | (centre + half > frame[1])).sum(axis=1)
        best = int(cost.argmin())
        place, colour = centre[best], curves[name][1]
        edges = [_along(place + half * [[-1, side], [1, side]]) for side in (-1, 1)]
        named = np.concatenate([named, *edges])
        arrow = {"arrowstyle": "-", "color": colour, "lw": 0.5, "shrinkA": 0, "shrinkB": 2}
        axis.annotate(
            name, curves[name][0][:, end[best]], (place - points[end[best]]) * 72, "data",
            "offset points", arrow if distance[best] > DISTANCES[1] else None,
            ha="center", va="center", fontsize=7, color=colour, zorder=6,
            path_effects=HALO,
        )  # fmt: skip


def _candidates(points: Array, half: Array) -> tuple[Array, Array, Array]:
    """Centres (n, 2) of boxes about the ends of a curve, which end each is of, how far it is."""
    turn = np.linspace(0, 2 * np.pi, TURNS, endpoint=False)
    way = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    # The nearest point of the box, and not its centre, is to be this far away.
    reach = np.minimum(*(half / np.maximum(np.abs(way), 1e-9)).T)[:, None]
    parts = [
        (points[end] + way * (reach + distance), np.full(TURNS, end), np.full(TURNS, distance))
        for end in (-1, 0)
        for distance in DISTANCES
    ]
    centre, end, distance = (np.concatenate(part) for part in zip(*parts, strict=True))
    return centre, end, distance


def _along(points: Array) -> Array:
    """Points (m, 2) all along a line of points (n, 2)."""
    found = [points[:1]]
    for a, b in pairwise(points):
        n = int(np.linalg.norm(b - a) / STEP) + 1
        found.append(a + (b - a) * np.linspace(0, 1, n + 1)[1:, None])
    return np.concatenate(found)


def _covered(points: Array, centre: Array, half: Array) -> Array:
    """How many points each box covers."""
    return (np.abs(points - centre[:, None]) < half + 0.02).all(axis=2).sum(axis=1)
