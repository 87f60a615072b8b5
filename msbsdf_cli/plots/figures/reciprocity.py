"""wang_16.png"""

from pathlib import Path

import numpy as np
from scipy.stats import norm

from msbsdf_cli.experiments.figures.settings import Tables
from msbsdf_cli.plots.figures.rows import values, where
from msbsdf_cli.plots.style import COLOURS, panels, save


def draw_wang_16(tables: Tables, directory: Path) -> None:
    """A row for each model: f(i, o), f(i, o) - f(o, i), and its histogram."""
    table = tables["wang_16"]
    methods = values(table, "method")
    side = round(max(table["row"])) + 1
    top = float(np.quantile(table["forward"], 0.99))
    figure, axes = panels(len(methods), [2.0, 2.0, 2.6], 2.0, (0.95, 0.75))
    for line, method in zip(axes, methods, strict=True):
        rows = where(table, method=method)
        looks = ("forward", "viridis", (0, top)), ("difference", "RdBu_r", (-top / 4, top / 4))
        for axis, (name, colours, (low, high)) in zip(line[:2], looks, strict=True):
            image = np.full((side, side), np.nan)
            image[rows["row"].astype(int), rows["column"].astype(int)] = rows[name]
            drawn = axis.imshow(image, cmap=colours, vmin=low, vmax=high, interpolation="nearest")
            figure.colorbar(drawn, cax=axis.inset_axes((1.03, 0.05, 0.05, 0.9)), extend="both")
            axis.set_axis_off()
        z = rows["difference"] / rows["stderr"]
        spread = np.linspace(-6, 6, 49)
        counts = np.histogram(np.clip(z, -6, 6), spread)[0]
        middle, width = (spread[1:] + spread[:-1]) / 2, spread[1] - spread[0]
        line[2].stairs(counts, spread, color=COLOURS[0], fill=True, alpha=0.5)
        line[2].plot(middle, z.size * width * norm.pdf(middle), color=COLOURS[1], label="noise")
        line[2].set_xlabel("difference / standard error (beyond 6 at the edge)")
        mean, error = rows["difference"].mean(), np.sqrt((rows["stderr"] ** 2).sum()) / z.size
        line[2].set_title(f"mean difference {mean:.2g} ± {error:.1g}")
        line[0].set_title(f"{method}\nf(i, o) [1/sr]")
        line[1].set_title("f(i, o) - f(o, i) [1/sr]")
        line[2].legend(loc="upper left")
    save(figure, directory / "wang_16.png")
