"""A picture of a surface, lit and traced, so that a person sees what a roughness is."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from msbsdf_cli.plots.style import save
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
    lit from a side, with shadows; and from above, its heights over one period."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(8, 3.6), width_ratios=[1.25, 1], layout="constrained"
    )
    left.imshow(
        lit_view(surface, stretch, alpha), cmap="gray", vmin=0, vmax=1, interpolation="bilinear"
    )
    left.set_title(
        f"alpha = {alpha[0]:.3g}, {alpha[1]:.3g}: seen from 35 degrees above the horizon"
    )
    left.axis("off")
    lengths = surface.period[:, 0] / np.diag(stretch.matrix)[:2]
    picture = right.imshow(
        surface.heights.T,
        origin="lower",
        extent=(0, lengths[0], 0, lengths[1]),
        cmap="viridis",
        aspect="auto" if max(lengths) > 3 * min(lengths) else "equal",
    )
    right.set_title("one period; unit: standard deviation of height")
    right.grid(False)
    figure.colorbar(picture, ax=right, label="height")
    save(figure, directory / "surface.png")


def lit_view(surface: Surface, stretch: Stretch, alpha: tuple[float, float]) -> Array:
    """Brightness (PIXELS, PIXELS) of a diffuse surface under a low lamp, seen by parallel rays."""
    elevation = np.radians(35)
    view = np.array([0.0, np.cos(elevation), -np.sin(elevation)])
    up = np.array([0.0, np.sin(elevation), np.cos(elevation)])
    width = WIDTH * 2 / np.sqrt(alpha[0] * alpha[1])
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
