"""wang_17.png: error over time of a slab's image, a panel for each roughness."""

from pathlib import Path

import numpy as np

from msbsdf_cli.experiments.figures.settings import Tables
from msbsdf_cli.plots.style import look, panels, save

BIDIRECTIONAL = "-bidirectional"


def draw_wang_17(tables: Tables, directory: Path) -> None:
    """As [WJFYHY22 supp.] Figure 17; rings at two samples a pixel."""
    table = tables["wang_17"]
    rows = [dict(zip(table, cells, strict=True)) for cells in zip(*table.values(), strict=True)]
    alphas = list(dict.fromkeys(r["alpha_x"] for r in rows))
    figure, axes = panels(1, [2.2] * len(alphas), 2.2, (0.2, 0.4), sharex=True, sharey=True)
    for axis, alpha in zip(axes[0], alphas, strict=True):
        for name in dict.fromkeys(r["method"] for r in rows):
            line = [r for r in rows if r["alpha_x"] == alpha and r["method"] == name]
            style = look(name.removesuffix(BIDIRECTIONAL))
            x, y, error = (
                np.array([r[column] for r in line])
                for column in ("seconds_per_pixel", "relative_mse", "relative_mse_stderr")
            )
            dashes = "--" if name.endswith(BIDIRECTIONAL) else "-"
            axis.errorbar(
                x * 1e6, y, np.minimum(error, 0.9 * y), ms=3, elinewidth=0.7, label=name,
                **style, ls=dashes,
            )  # fmt: skip
            two = [r["samples"] for r in line].index(2)
            axis.plot(x[two] * 1e6, y[two], "o", ms=8, mfc="none", mec=style["color"], mew=0.8)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_title(f"alpha = {alpha:g}")
        axis.set_xlabel("microseconds a pixel", labelpad=1)
    axes[0, 0].set_ylabel("mean squared error, relative")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="upper left", ncols=3)
    save(figure, directory / "wang_17.png")
