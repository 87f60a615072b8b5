"""furnace.png and sphere.png: directional albedos, and spheres under constant white light."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.report.directory import read_csv
from msbsdf_cli.report.style import method_look, panels, save
from surfaces.facet import Array

NUMBERS = ("alpha_x", "alpha_y", "theta_i_rad", "albedo", "stderr")
PIXELS = 160
"""Of a sphere, each way."""


def draw_furnace(directory: Path) -> None:
    """Albedo over the angle of incidence, a panel for each roughness and channel, a line with a
    band of two standard errors for each method; and the spheres."""
    table = read_csv(directory / "furnace.csv", NUMBERS)
    columns = {name: np.array(values) for name, values in table.items()}
    alphas = list(dict.fromkeys(zip(table["alpha_x"], table["alpha_y"], strict=True)))
    methods, channels = (list(dict.fromkeys(table[name])) for name in ("method", "channel"))
    figure, axes = panels(len(channels), [2.2] * len(alphas), 1.9, (0.4, 0.6))
    for i, channel in enumerate(channels):
        for j, alpha in enumerate(alphas):
            axis = axes[i, j]
            for m, method in enumerate(methods):
                theta, albedo, stderr = _curve(columns, alpha, method, channel)
                look = method_look(m)
                axis.plot(np.degrees(theta), albedo, **look, label=method)
                band = albedo - 2 * stderr, albedo + 2 * stderr
                axis.fill_between(np.degrees(theta), *band, color=look["color"], alpha=0.25, lw=0)
            axis.axhline(1, color="0.5", lw=0.6)
            axis.set_title(f"alpha = {_name(alpha)}   {channel}")
            axis.set_xlabel("theta_i, degrees", labelpad=1)
        axes[i, 0].set_ylabel("albedo")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="upper left", ncols=4)
    save(figure, directory / "furnace.png")
    _draw_spheres(columns, alphas, methods, channels, directory / "sphere.png")


def _draw_spheres(
    columns: dict[str, Array],
    alphas: list[Any],
    methods: list[str],
    channels: list[str],
    path: Path,
) -> None:
    figure, axes = panels(len(alphas), [1.2] * len(methods), 1.2, (0.08, 0.12))
    for i, alpha in enumerate(alphas):
        for j, method in enumerate(methods):
            curves = [_curve(columns, alpha, method, c)[:2] for c in channels]
            axes[i, j].imshow(_sphere(curves), vmin=0, vmax=1, interpolation="bilinear")
            axes[i, j].axis("off")
            if i == 0:
                axes[i, j].set_title(
                    method.replace("position-free-", "position-free\n"), fontsize=6
                )
        axes[i, 0].text(
            -0.06,
            0.5,
            f"alpha = {_name(alpha)}",
            rotation=90,
            va="center",
            ha="right",
            transform=axes[i, 0].transAxes,
        )
    save(figure, path)


def _sphere(curves: list[tuple[Array, Array]]) -> Array:
    """Brightness (PIXELS, PIXELS, 3) of a sphere before a white wall that lights it evenly."""
    x = np.linspace(-1.1, 1.1, PIXELS)
    radius = np.hypot(x, x[:, None])
    theta = np.arcsin(np.minimum(radius, 1))
    channels = curves if len(curves) == 3 else curves[:1] * 3
    image = np.stack([np.interp(theta, t, albedo) for t, albedo in channels], axis=-1)
    image[radius > 1] = 1
    # Shown as a display wants it, brightness encoded by the usual power.
    return np.clip(image, 0, 1) ** (1 / 2.2)


def _curve(columns: dict[str, Array], alpha: Any, method: str, channel: str) -> Any:
    mine = (
        (columns["alpha_x"] == alpha[0])
        & (columns["alpha_y"] == alpha[1])
        & (columns["method"] == method)
        & (columns["channel"] == channel)
        & (columns["order"] == "all")
    )
    return tuple(columns[name][mine] for name in ("theta_i_rad", "albedo", "stderr"))


def _name(alpha: tuple[float, float]) -> str:
    return ", ".join(f"{a:g}" for a in dict.fromkeys(alpha))
