"""parts.png: where the difference between a BSDF and a surface comes from."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.plots.style import COLOURS, in_degrees, panels, save

NAMES = {
    "part_distribution": "slopes are not the fitted ones",
    "part_correlation": "heights are correlated",
    "part_bounces": "later bounces, left out",
}


def draw_parts(rows: list[Any], path: Path) -> None:
    """The three parts at each incident angle, and the floor: how large noise alone makes them."""
    theta = list(dict.fromkeys(r.theta_i_rad for r in rows))
    figure, axes = panels(1, [max(4.6, 1.3 * len(theta))], 2.6)
    axis, x = axes[0, 0], np.arange(len(theta))
    for k, (quantity, label) in enumerate(NAMES.items()):
        mine = [r for r in rows if r.quantity == quantity]
        own, stderr, noise = (
            100 * np.array([getattr(r, name) for r in mine])
            for name in ("own", "own_stderr", "noise")
        )
        place = x + 0.27 * (k - 1)
        axis.bar(place, own, 0.25, color=COLOURS[k], alpha=0.8, label=label)
        axis.errorbar(place, own, stderr, fmt="none", ecolor="0.2", lw=0.9, capsize=2)
        floor = "floor: noise alone" if k == 0 else None
        axis.hlines(noise, place - 0.13, place + 0.13, color="0.1", ls=":", label=floor)
    axis.axhline(0, color="0.4", lw=0.7)
    axis.set_xticks(x, [*map(in_degrees, theta)])
    axis.set_xlabel("light from")
    axis.set_ylabel("light that goes elsewhere, %\n(bars: 1 std. error)")
    axis.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    save(figure, path)
