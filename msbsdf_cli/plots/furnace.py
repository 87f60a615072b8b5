"""furnace.png: directional albedos. Where the two roughnesses differ they are drawn at the azimuths
of the axes."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.plots.style import method_look, panels, save
from msbsdf_cli.results.files import Table
from surfaces.facet import Array


def draw_furnace(table: Table, path: Path) -> None:
    """From furnace.csv: albedo over the angle of incidence, a panel for each roughness and channel,
    a line with a band of two standard errors for each method."""
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
            axis.set_title(f"alpha = {alpha_name(alpha)}{turned}   {channel}")
            axis.set_xlabel("theta_i, degrees", labelpad=1)
        axes[i, 0].set_ylabel("albedo")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="upper left", ncols=5)
    save(figure, path)


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


def alpha_name(alpha: tuple[float, float]) -> str:
    """One roughness, or two."""
    return ", ".join(f"{a:g}" for a in dict.fromkeys(alpha))
