"""sphere.png: spheres in constant white light, and by how much they differ from it."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure

from msbsdf_cli.experiments.render.picture import luminance
from msbsdf_cli.experiments.white_sphere import Sphere
from msbsdf_cli.plots.furnace import alpha_name
from msbsdf_cli.plots.render import displayed
from msbsdf_cli.plots.style import save
from surfaces.facet import Array

SIDE, GAP, LEFT, RIGHT, TOP, BOTTOM = 1.25, 0.06, 0.55, 0.85, 0.45, 0.1
"""Inches: a sphere's, between two, and about all of them."""
GROUND = 0.5
"""The grey, as displayed, behind a sphere."""
FINEST, WIDEST = 0.03, 0.5
"""Differences up to which the scale of colours is linear, and where it ends."""
TICKS = (-0.5, -0.2, -0.1, -0.03, 0, 0.03, 0.1, 0.2, 0.5)


def draw_spheres(spheres: list[Sphere], path: Path) -> None:
    """A column for each method, two rows for each roughness: the sphere on a grey ground, as a
    display shows it, and its luminance less that of the light around it."""
    methods, alphas = (
        list(dict.fromkeys(getattr(s, name) for s in spheres)) for name in ("method", "alpha")
    )
    n, rows = len(methods), 2 * len(alphas)
    across = LEFT + n * (SIDE + GAP) + RIGHT
    up = TOP + rows * (SIDE + GAP) + len(alphas) * NOTE + BOTTOM
    figure = Figure((across, up))
    scale = {"cmap": "coolwarm", "norm": SymLogNorm(FINEST, vmin=-WIDEST, vmax=WIDEST)}
    for a, alpha in enumerate(alphas):
        high = up - TOP - a * (2 * (SIDE + GAP) + NOTE)
        _side(figure, LEFT - 0.12, high - SIDE / 2, f"alpha = {alpha_name(alpha)}")
        _side(figure, LEFT - 0.12, high - SIDE * 1.5 - GAP, "less 1")
        for sphere in (s for s in spheres if s.alpha == alpha):
            left = LEFT + methods.index(sphere.method) * (SIDE + GAP)
            places = [(left, high - (k + 1) * SIDE - k * GAP) for k in (0, 1)]
            above, below = (_place(figure, place) for place in places)
            above.imshow(on_grey(sphere), interpolation="nearest")
            shown = below.imshow(difference(sphere), interpolation="nearest", **scale)
            if a == 0:
                above.set_title(
                    sphere.method.replace("position-free-", "position-free\n"), fontsize=7
                )
            below.text(0.5, -0.03, note(sphere), transform=below.transAxes, **SMALL)
    bar = figure.add_axes(
        ((across - RIGHT + 0.1) / across, 0.25, 0.12 / across, 0.5),
    )
    figure.colorbar(shown, cax=bar, ticks=TICKS, extend="both", label="luminance less 1")
    bar.set_yticklabels([f"{t:+g}" if t else "0" for t in TICKS])
    bar.minorticks_off()
    bar.grid(False)
    save(figure, path)


NOTE = 0.24
"""Inches for the words under a sphere."""
SMALL = {"ha": "center", "va": "top", "fontsize": 5.5}


def on_grey(sphere: Sphere) -> Array:
    """Colours (rows, columns, 3) of the sphere, what is around it taken for grey."""
    shown = displayed(_alone(sphere))
    return np.asarray(GROUND + sphere.covered[..., None] * (shown - GROUND))


def difference(sphere: Sphere) -> Array:
    """Luminance less 1, the mean of 2 x 2 pixels, (rows, columns); not a number beside the
    sphere."""
    covered = _blocks(sphere.covered)
    less = _blocks(sphere.covered * (luminance(_alone(sphere)) - 1))
    return np.divide(less, covered, out=np.full_like(less, np.nan), where=covered > 0)


def _blocks(a: Array) -> Array:
    rows, columns = a.shape
    return np.asarray(a.reshape(rows // 2, 2, columns // 2, 2).mean(axis=(1, 3)))


def _alone(sphere: Sphere) -> Array:
    """Radiance of the sphere's part of each pixel, where light around it is 1."""
    part = np.maximum(sphere.covered, 1 / 16)
    return np.asarray(np.where(sphere.covered > 0, 1 + (sphere.image - 1) / part, 1))


def note(sphere: Sphere) -> str:
    """How bright the sphere is in the mean, and how sure that is."""
    mean = luminance(_alone(sphere))[sphere.covered > 0].mean() - 1
    words = f"mean {mean:+.2g}, noise {sphere.noise:.1g}"
    return f"{words}\ntable {sphere.table_error:.1g}" if sphere.table_error else words


def _place(figure: Any, corner: tuple[float, float]) -> Any:
    across, up = figure.get_size_inches()
    axis = figure.add_axes((corner[0] / across, corner[1] / up, SIDE / across, SIDE / up))
    axis.set_axis_off()
    return axis


def _side(figure: Any, x: float, y: float, text: str) -> None:
    across, up = figure.get_size_inches()
    figure.text(x / across, y / up, text, rotation=90, va="center", ha="right", fontsize=7)
