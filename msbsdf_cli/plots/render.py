"""render.png: a scene by several methods side by side, what differs, and how sure that is."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from msbsdf_cli.experiments.render.picture import Picture, luminance
from msbsdf_cli.plots.style import save
from surfaces.facet import Array

WIDTH = 3.0
"""Of a picture in inches."""
LINEAR, SLOPE, POWER, OFFSET = 0.0031308, 12.92, 1 / 2.4, 0.055
"""The sRGB transfer function, IEC 61966-2-1."""


def draw_pictures(pictures: list[Picture], exposure: float, path: Path) -> None:
    """A column for each method: the picture, its luminance less that of the first, or in words what
    is shown, and the standard error; differences and errors have one scale each, over the largest
    radiance shown."""
    _, height, width = pictures[0].mean.shape
    up = WIDTH * height / width
    rows = 3
    across = len(pictures) * (WIDTH + 0.1) + 0.9
    total = rows * (up + 0.12) + 0.45
    figure = Figure((across, total))
    axes = figure.subplots(rows, len(pictures), squeeze=False)
    figure.subplots_adjust(
        0.1 / across, 0.05 / total, 1 - 0.8 / across, 1 - 0.4 / total, 0.03, 0.06
    )
    apart = [luminance(p.mean - pictures[0].mean) / exposure for p in pictures]
    errors = [luminance(p.stderr) / exposure for p in pictures]
    largest = max(float(np.quantile(np.abs(a), 0.99)) for a in apart) or 1.0
    error = max(float(np.quantile(e, 0.99)) for e in errors) or 1.0
    for k, p in enumerate(pictures):
        axes[0, k].imshow(displayed(p.mean / exposure), interpolation="nearest")
        axes[0, k].set_title(
            f"{p.method}\nmean {luminance(p.mean).mean():.4g}, noise {100 * p.noise:.2g} %, "
            f"{p.seconds:.3g} s"
        )
        shown = axes[-1, k].imshow(errors[k], cmap="magma", vmin=0, vmax=error)
        if k:
            bar = axes[1, k].imshow(apart[k], cmap="RdBu_r", vmin=-largest, vmax=largest)
    words = {"ha": "center", "va": "center", "fontsize": 8, "transform": axes[1, 0].transAxes}
    axes[1, 0].text(0.5, 0.5, _words(pictures), **words)
    if len(pictures) > 1:
        _bar(figure, axes[1, -1], bar, "difference", "both")
    _bar(figure, axes[-1, -1], shown, "standard error over white", "max")
    for axis in axes.ravel():
        axis.set_axis_off()
    save(figure, path)


def _words(pictures: list[Picture]) -> str:
    """What the rows show, and how the first picture was made."""
    first = pictures[0]
    beside = [f"right of here: luminance less that of {first.method}"] if len(pictures) > 1 else []
    made = f"{first.samples} paths a pixel"
    tables = [
        f"tables of {p.method}: {p.setup_seconds:.3g} s, off by {100 * p.table_error:.2g} %"
        for p in pictures
        if p.table_error
    ]
    return "\n\n".join(
        (
            *beside,
            "below: standard error of each pixel,\nover the luminance shown as white",
            "noise: standard error over luminance,\nroot mean squares",
            f"{made}; seconds of processor time, tables aside",
            *tables,
        )
    )


def displayed(radiance: Array) -> Array:
    """sRGB (height, width, 3), 0 to 1, of linear radiance (3, height, width), 1 as white."""
    linear = np.clip(np.moveaxis(radiance, 0, -1), 0, 1)
    curve = (1 + OFFSET) * linear**POWER - OFFSET
    return np.asarray(np.where(linear <= LINEAR, SLOPE * linear, curve))


def _bar(figure: Any, axis: Any, image: Any, label: str, beyond: str) -> None:
    place = axis.get_position()
    width = figure.get_figwidth()
    beside = figure.add_axes((place.x1 + 0.08 / width, place.y0, 0.1 / width, place.height))
    figure.colorbar(image, cax=beside, label=label, extend=beyond)
    beside.grid(False)
