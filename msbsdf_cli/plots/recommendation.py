"""recommendation.png: what each surface's models cost, and how far they are off."""

from pathlib import Path
from typing import Any

from msbsdf_cli.experiments.recommend.candidates import COMPENSATED
from msbsdf_cli.plots.style import COLOURS, panels, save

COLUMNS = 3

DEPTH = 100
"""Tolerance over the smallest error that is drawn; what is below stands on the lower edge."""

MARKS = {"chosen": ("o", 0), "too far": ("x", 1), "close": ("s", 4), "not needed": (".", 6)}
"""Marker and colour of a verdict."""


def draw_recommendations(found: list[Any], tolerance: float, path: Path) -> None:
    """A panel for each surface that could be judged: error over facets, the tolerance, and the
    choice."""
    judged = [r for r in found if r.candidates] or found[:1]
    columns = min(COLUMNS, len(judged))
    rows = -(-len(judged) // columns)
    figure, axes = panels(rows, [2.6] * columns, 1.8, (0.5, 0.7))
    for axis in axes.flat[len(judged) :]:
        axis.set_axis_off()
    for axis, r in zip(axes.flat, judged, strict=False):
        _panel(axis, r, tolerance)
    for axis in axes[:, 0]:
        axis.set_ylabel("largest error")
    handles: dict[str, Any] = {}
    for axis in axes.flat:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc="upper left", ncols=5)
    save(figure, path)


def _panel(axis: Any, recommendation: Any, tolerance: float) -> None:
    floor = tolerance / DEPTH
    for c, verdict in zip(recommendation.candidates, recommendation.verdicts, strict=True):
        if c.error < floor and verdict == "not needed" and c.bounces:
            continue
        marker, colour = MARKS[verdict]
        height = max(c.error, floor)
        look = {"marker": marker, "color": COLOURS[colour], "ls": "", "ms": 4, "label": verdict}
        axis.errorbar(c.facets, height, [[0], [c.uncertainty]], lw=0.7, **look)
        short = c.method if c.method in COMPENSATED else str(c.bounces or "all")
        axis.annotate(short, (c.facets, height), (4, 2), textcoords="offset points", fontsize=6)
    axis.axhline(tolerance, color="0.4", lw=0.8, ls="--", label="tolerance")
    axis.set_yscale("log")
    axis.set_ylim(floor / 1.5, 1)
    axis.margins(x=0.15)
    axis.set_title(recommendation.surface.name)
    axis.set_xlabel("facets met in the mean")
