"""furnace.png and sphere.png: directional albedos, and spheres under constant white light.

Where the two roughnesses differ, albedos are drawn at the azimuths of the axes, and a sphere's
pixel has the azimuth at which its place is seen: the x axis of the roughness is horizontal in the
picture, and is carried over the sphere without turning.
"""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from msbsdf_cli.plots.style import method_look, panels, save
from msbsdf_cli.results.files import Table
from surfaces.facet import Array

PIXELS = 160
"""Of a sphere, each way."""


def draw_furnace(table: Table, directory: Path) -> None:
    """From furnace.csv: albedo over the angle of incidence, a panel for each roughness and channel,
    a line with a band of two standard errors for each method; and the spheres."""
    columns = {name: np.array(values) for name, values in table.items()}
    alphas = list(dict.fromkeys(zip(table["alpha_x"], table["alpha_y"], strict=True)))
    methods, channels = (list(dict.fromkeys(table[name])) for name in ("method", "channel"))
    shown = [(alpha, phi) for alpha in alphas for phi in _axes_of(columns, alpha)]
    figure, axes = panels(len(channels), [2.2] * len(shown), 1.9, (0.4, 0.6))
    for i, channel in enumerate(channels):
        for j, (alpha, phi) in enumerate(shown):
            axis = axes[i, j]
            for m, method in enumerate(methods):
                theta, albedo, stderr = _curve(columns, alpha, phi, method, channel)
                look = method_look(m)
                axis.plot(np.degrees(theta), albedo, **look, label=method)
                band = albedo - 2 * stderr, albedo + 2 * stderr
                axis.fill_between(np.degrees(theta), *band, color=look["color"], alpha=0.25, lw=0)
            axis.axhline(1, color="0.5", lw=0.6)
            turned = "" if alpha[0] == alpha[1] else f", phi = {np.degrees(phi):g} degrees"
            axis.set_title(f"alpha = {_name(alpha)}{turned}   {channel}")
            axis.set_xlabel("theta_i, degrees", labelpad=1)
        axes[i, 0].set_ylabel("albedo")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="upper left", ncols=5)
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
            maps = [_map(columns, alpha, method, c) for c in channels]
            axes[i, j].imshow(_sphere(maps), vmin=0, vmax=1, interpolation="bilinear")
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


Map = tuple[Array, Array, Array]
"""Azimuths (p,), polar angles (t,) and albedos (p, t)."""


def _sphere(maps: list[Map]) -> Array:
    """Brightness (PIXELS, PIXELS, 3) of a sphere before a white wall that lights it evenly."""
    x, y = np.meshgrid(*[np.linspace(-1.1, 1.1, PIXELS)] * 2)
    radius = np.hypot(x, y)
    theta, phi = np.arcsin(np.minimum(radius, 1)), np.arctan2(np.abs(y), np.abs(x))
    channels = maps if len(maps) == 3 else maps[:1] * 3
    image = np.stack([_bilinear(m, phi, theta) for m in channels], axis=-1)
    image[radius > 1] = 1
    # Shown as a display wants it, brightness encoded by the usual power.
    return np.clip(image, 0, 1) ** (1 / 2.2)


def _bilinear(albedos: Map, phi: Array, theta: Array) -> Array:
    """Albedos at azimuths and polar angles of one shape; beyond the last angle, that one's."""
    azimuths, angles, values = albedos
    if len(azimuths) == 1:
        return np.interp(theta, angles, values[0])
    inside = np.clip(theta, angles[0], angles[-1])
    found = RegularGridInterpolator((azimuths, angles), values)(np.stack([phi, inside], axis=-1))
    return np.asarray(found)


def _map(columns: dict[str, Array], alpha: Any, method: str, channel: str) -> Map:
    """Over the quarter turn from the x to the y axis, or at the one azimuth that stands for all."""
    azimuths = _azimuths(columns, alpha)
    if alpha[0] != alpha[1]:
        azimuths = azimuths[(azimuths >= 0) & (azimuths <= np.pi / 2)]
    curves = [_curve(columns, alpha, phi, method, channel) for phi in azimuths]
    order = np.argsort(curves[0][0])
    return azimuths, curves[0][0][order], np.array([albedo[order] for _, albedo, _ in curves])


def _azimuths(columns: dict[str, Array], alpha: Any) -> Array:
    mine = (columns["alpha_x"] == alpha[0]) & (columns["alpha_y"] == alpha[1])
    return np.unique(columns["phi_i_rad"][mine])


def _axes_of(columns: dict[str, Array], alpha: Any) -> list[float]:
    """The azimuths to draw curves at: of the x and y axes, or the only one."""
    azimuths = _azimuths(columns, alpha)
    return azimuths.tolist() if len(azimuths) == 1 else [0.0, np.pi / 2]


def _curve(columns: dict[str, Array], alpha: Any, phi: float, method: str, channel: str) -> Any:
    mine = (
        (columns["alpha_x"] == alpha[0])
        & (columns["alpha_y"] == alpha[1])
        & (columns["phi_i_rad"] == phi)
        & (columns["method"] == method)
        & (columns["channel"] == channel)
        & (columns["order"] == "all")
    )
    return tuple(columns[name][mine] for name in ("theta_i_rad", "albedo", "stderr"))


def _name(alpha: tuple[float, float]) -> str:
    return ", ".join(f"{a:g}" for a in dict.fromkeys(alpha))
