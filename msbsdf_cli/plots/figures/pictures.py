"""heitz_1.png and heitz_16.png to heitz_20.png"""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.experiments.figures.settings import Tables
from msbsdf_cli.experiments.render.lights import LUMINANCE
from msbsdf_cli.plots.figures.rows import values, where
from msbsdf_cli.plots.render import displayed
from msbsdf_cli.plots.style import panels, save
from msbsdf_cli.results.files import Table
from surfaces.facet import Array

CHANNELS = ("red", "green", "blue")
WIDTH = 2.0
"""Of a picture in inches."""


def draw_pictures(name: str, tables: Tables, directory: Path) -> None:
    """A row for each surface: single scattering, all bounces, what these add, and its error."""
    pixels, means = tables[name], tables[f"{name}_mean"]
    shown = [
        (p, [_image(pixels, p, m) for m in values(means, "method")]) for p in values(means, "panel")
    ]
    up = WIDTH * max(pair[0][0].shape[1] / pair[0][0].shape[2] for _, pair in shown)
    figure, axes = panels(len(shown), [WIDTH] * 4, up, (0.08, 0.42), right=0.75)
    for line, (panel, ((single, few), (full, many))) in zip(axes, shown, strict=True):
        rows = where(means, panel=panel)
        white = float(rows["exposure"][0])
        for axis, image in zip(line[:2], (single, full), strict=True):
            axis.imshow(displayed(image / white), interpolation="nearest")
        apart = np.tensordot(LUMINANCE, full - single, 1) / white
        error = np.tensordot(LUMINANCE, np.hypot(few, many), 1) / white
        reach = float(np.quantile(np.abs(apart), 0.995)) or 1.0
        last = [
            axis.imshow(part, cmap="RdBu_r", vmin=-reach, vmax=reach, interpolation="nearest")
            for axis, part in zip(line[2:], (apart, error), strict=True)
        ][-1]
        bar = figure.colorbar(last, cax=line[3].inset_axes((1.04, 0.05, 0.06, 0.9)))
        bar.ax.tick_params(labelsize=6)
        _title(line, panel, rows)
    for axis in axes.flat:
        axis.set_axis_off()
    save(figure, directory / f"{name}.png")


def _title(line: Any, panel: str, rows: dict[str, Array]) -> None:
    said = [
        f"{m:.4g} ± {e:.1g}"
        for m, e in zip(rows["luminance"], rows["luminance_stderr"], strict=True)
    ]
    line[0].set_title(f"{panel}\nsingle scattering, mean {said[0]}", fontsize=6.5, loc="left")
    line[1].set_title(f"all bounces, mean {said[1]}", fontsize=6.5, loc="left")
    line[2].set_title("what later bounces add, over white", fontsize=6.5, loc="left")
    line[3].set_title("its standard error", fontsize=6.5, loc="left")


def _image(pixels: Table, panel: str, method: str) -> tuple[Array, Array]:
    """Radiance and its standard error, (3, height, width)."""
    rows = where(pixels, panel=panel, method=method)
    shape = int(rows["row"].max()) + 1, int(rows["column"].max()) + 1
    mean, stderr = (
        np.stack([rows[f"{channel}{suffix}"].reshape(shape) for channel in CHANNELS])
        for suffix in ("", "_stderr")
    )
    return mean, stderr


draw_heitz_1, draw_heitz_16, draw_heitz_17, draw_heitz_18, draw_heitz_19, draw_heitz_20 = (
    partial(draw_pictures, f"heitz_{n}") for n in (1, 16, 17, 18, 19, 20)
)
