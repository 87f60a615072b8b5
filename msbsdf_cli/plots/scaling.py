"""scaling.png: how times grow."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.ticker import NullFormatter

from msbsdf_cli.experiments.tradeoff.scaling import Scaling
from msbsdf_cli.plots.style import in_degrees, key, look, method_lines, panels, save

AXES = {
    "samples": "walks",
    "threads": "processes",
    "orders": "orders told apart",
    "roughness": "roughness alpha",
}


def draw_scaling(rows: list[Scaling], path: Path) -> None:
    """A column for each parameter: seconds above, and below what they buy. Times are those after
    set-up, with quartiles; over samples at the first angle."""
    figure, axes = panels(2, [2.5] * len(AXES), 2.1, (0.75, 0.6))
    for column, (parameter, label) in enumerate(AXES.items()):
        mine = [r for r in rows if r.parameter == parameter]
        first = next((r.theta_i_rad for r in mine), 0.0)
        mine = [r for r in mine if r.theta_i_rad == first]
        upper, lower = axes[:, column]
        for method in dict.fromkeys(r.method for r in mine):
            line = _cheapest_of_each([r for r in mine if r.method == method])
            _draw_times(upper, line)
            _draw_worth(lower, line, parameter)
        for axis in (upper, lower):
            axis.set_xscale("log", base=10 if parameter in ("samples", "roughness") else 2)
            axis.yaxis.set_minor_formatter(NullFormatter())
            axis.xaxis.set_minor_formatter(NullFormatter())
            axis.set_xlabel(label, labelpad=1)
        upper.set_yscale("log")
        upper.set_title(f"over {label}, light from {in_degrees(first)}")
        lower.set_yscale("linear" if parameter in ("threads", "orders") else "log")
        lower.set_ylabel(
            {"threads": "speed over one process", "orders": "time over that of 1 order"}.get(
                parameter, "relative RMSE"
            )
        )
    axes[0, 0].set_ylabel("seconds")
    key(figure, method_lines(r.method for r in rows))
    save(figure, path)


def _cheapest_of_each(rows: list[Scaling]) -> list[Scaling]:
    """One row for each value: of several numbers of walks the largest, of resolutions the last."""
    last = {r.value: r for r in rows}
    return [last[value] for value in sorted(last)]


def _draw_times(axis: Any, line: list[Scaling]) -> None:
    y = np.array([r.seconds for r in line])
    low, high = (np.array([getattr(r, f"seconds_{end}") for r in line]) for end in ("low", "high"))
    axis.errorbar(
        [r.value for r in line],
        y,
        [np.maximum(y - low, 0), np.maximum(high - y, 0)],
        ms=3.5,
        elinewidth=0.7,
        **look(line[0].method),
    )


def _draw_worth(axis: Any, line: list[Scaling], parameter: str) -> None:
    x = np.array([r.value for r in line])
    seconds = np.array([r.seconds for r in line])
    if parameter == "threads":
        y, error = seconds[0] / seconds, None
        axis.plot(x, x / x[0], color="0.8", lw=0.8)
    elif parameter == "orders":
        y, error = seconds / seconds[0], None
    else:
        y = np.array([r.relative_rmse for r in line])
        error = np.minimum([r.relative_rmse_stderr for r in line], 0.9 * y)
    # Errors and ratios near 1 are noise: a line through them would show more than is known.
    joined = "-" if parameter == "threads" else ""
    axis.errorbar(x, y, error, ms=3.5, elinewidth=0.7, **look(line[0].method), ls=joined)
