"""A picture of a surface, lit and traced, so that a person sees what a roughness is."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from msbsdf_cli.plots.style import HALO, save
from surfaces.facet import Array
from surfaces.periodic import meet, next_triangle
from surfaces.stretch import Stretch
from surfaces.surface import Surface

PIXELS = 420
"""Of the picture, each way."""
WIDTH = 8
"""Width of the view in correlation lengths, their geometric mean where they differ."""


def draw_surface(
    directory: Path, surface: Surface, stretch: Stretch, alpha: tuple[float, float]
) -> None:
    """surface.png: the surface of roughness `alpha` that `stretch` makes of a mesh, seen aslant,
    lit from a side, with shadows; and from above, the heights of the same square."""
    figure = Figure((8, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1.25, 1])
    brightness = lit_view(surface, stretch, alpha)
    left.imshow(brightness, cmap="gray", vmin=0, vmax=1, interpolation="bilinear")
    left.set_title(f"alpha = {alpha[0]:.3g}, {alpha[1]:.3g}: from 35° above the horizon")
    left.axis("off")
    width, (rows, columns) = _width(alpha), brightness.shape
    _scale_bar(left, columns * _round(width / 4) / width, _round(width / 4), rows)
    lamp = {"arrowstyle": "->", "color": "#d55e00", "lw": 1.5}
    left.annotate("", (0.84, 0.86), (0.98, 0.98), "axes fraction", arrowprops=lamp)
    left.text(
        0.83, 0.93, "light", transform=left.transAxes, ha="right", fontsize=7, color="#d55e00",
        path_effects=HALO,
    )  # fmt: skip
    picture = right.imshow(
        _heights(surface, stretch, width),
        origin="lower",
        extent=(0, width, 0, width),
        cmap="viridis",
    )
    right.set_title("from above; unit: standard deviation of height")
    right.grid(False)
    figure.colorbar(picture, ax=right, label="height")
    save(figure, directory / "surface.png")


def _width(alpha: tuple[float, float]) -> float:
    """Of what is shown, in standard deviations of height."""
    return WIDTH * 2 / float(np.sqrt(alpha[0] * alpha[1]))


def _round(length: float) -> float:
    """A length near to this one that is said with one digit."""
    return float(f"{length:.0e}")


def _scale_bar(axis: Any, pixels: float, length: float, rows: int) -> None:
    axis.plot([8, 8 + pixels], [rows - 10] * 2, color="#d55e00", lw=2.5, solid_capstyle="butt")
    words = f"{length:g} standard deviations of height"
    axis.text(8, rows - 15, words, color="#d55e00", fontsize=7, va="bottom", path_effects=HALO)


def _heights(surface: Surface, stretch: Stretch, width: float) -> Array:
    """Heights (PIXELS, PIXELS) over a square, which the period repeats to fill."""
    x = np.linspace(0, width, PIXELS)
    o = np.stack([*(a.ravel() for a in np.meshgrid(x, x)), np.zeros(PIXELS**2)])
    u, v = (np.floor(stretch.to_grid(o)[:2] % surface.period)).astype(int)
    heights: Array = surface.heights[u, v].reshape(PIXELS, PIXELS)
    return heights


def lit_view(surface: Surface, stretch: Stretch, alpha: tuple[float, float]) -> Array:
    """Brightness (PIXELS, PIXELS) of a diffuse surface under a low lamp, seen by parallel rays."""
    elevation = np.radians(35)
    view = np.array([0.0, np.cos(elevation), -np.sin(elevation)])
    up = np.array([0.0, np.sin(elevation), np.cos(elevation)])
    width = _width(alpha)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, PIXELS), np.linspace(0.31, -0.31, int(PIXELS * 0.62)))
    o = (x * width)[None] * np.array([1.0, 0, 0])[:, None, None] + (y * width)[None] * up[
        :, None, None
    ]
    o = o.reshape(3, -1)
    # Back along the line of sight to above the highest point.
    o = o + ((surface.top + 0.1 - o[2]) / view[2]) * view[:, None]
    o = stretch.to_grid(o)
    o[:2] %= surface.period
    o[2] = surface.top
    d = np.broadcast_to(stretch.to_grid(view[:, None]), o.shape)
    triangle = next_triangle(surface, o, d, None)
    hit = triangle >= 0
    point, _, slopes = meet(surface, o[:, hit], d[:, hit], triangle[hit])
    m = stretch.normals(slopes)
    m /= np.sqrt((m * m).sum(axis=0))
    lamp = np.array([0.75, 0.35, 0.56])
    lamp /= np.linalg.norm(lamp)
    point[2] += surface.lift
    towards = np.broadcast_to(stretch.to_grid(lamp[:, None]), point.shape)
    lit = next_triangle(surface, point, towards, None) < 0
    sky = 0.5 + 0.5 * m[2]
    brightness = np.zeros(hit.size)
    brightness[hit] = 0.25 * sky + 0.75 * lit * np.maximum(lamp @ m, 0)
    return brightness.reshape(x.shape) ** (1 / 1.8)
