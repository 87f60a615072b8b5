"""recommendation.png: what each surface's models cost, and how far they are off."""

from pathlib import Path
from typing import Any

from msbsdf_cli.plots.style import COLOURS, panels, save

COLUMNS = 3

DEPTH = 100
"""Tolerance over the smallest error that is drawn; what is below stands on the lower edge."""

MARKS = {
    "chosen": ("o", 0, "chosen"),
    "nearest": ("D", 0, "nearest: nothing is known to beat it"),
    "too far": ("x", 1, "too far"),
    "close": ("s", 4, "too close to call"),
    "not needed": (".", 6, "not needed"),
}
"""Marker, colour and words of a verdict."""

SHORT = {
    "energy-compensated": "Kulla-\nConty",
    "turquin": "Tur-\nquin",
    "walk-memory": "mem-\nory",
}
"""Methods by their authors, who have shorter names, on two lines."""

MOST_AFTER = 1
"""Candidates drawn between the choice and the model of all bounces."""


def draw_recommendations(found: list[Any], wanted: Any, against: str, path: Path) -> None:
    """A panel for each surface that could be judged: error of the candidates, the cheapest first,
    the tolerance, the choice, and, against surfaces, the floor under the Smith model."""
    judged = [r for r in found if r.candidates] or found[:1]
    columns = min(COLUMNS, len(judged))
    rows = -(-len(judged) // columns)
    figure, axes = panels(rows, [3.3 if columns > 1 else 5.2] * columns, 1.9, (0.5, 0.85))
    for axis in axes.flat[len(judged) :]:
        axis.set_axis_off()
    for axis, r in zip(axes.flat, judged, strict=False):
        _panel(axis, r, wanted.tolerance, against)
    for axis in axes[:, 0]:
        axis.set_ylabel("largest error, % of the light")
    handles: dict[str, Any] = {}
    for axis in axes.flat:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc="upper left", ncols=min(4, columns + 1))
    save(figure, path)


def _panel(axis: Any, recommendation: Any, tolerance: float, against: str) -> None:
    floor, shown = tolerance / DEPTH, _shown(recommendation)
    for x, (c, verdict) in enumerate(shown):
        marker, colour, words = MARKS[verdict]
        height = 100 * max(c.error, floor)
        look = {"marker": marker, "color": COLOURS[colour], "ls": "", "ms": 4, "label": words}
        axis.errorbar(x, height, [[0], [max(100 * c.bound - height, 0)]], lw=0.7, **look)
    axis.axhline(100 * tolerance, color="0.4", lw=0.8, ls="--", label="tolerance")
    if against == "surfaces" and recommendation.floor is not None:
        height = 100 * max(recommendation.floor.error, floor)
        label = "floor: distance of the Smith model of all bounces from traced surfaces"
        axis.axhline(height, color=COLOURS[1], lw=1, ls=":", label=label)
    axis.set_yscale("log")
    axis.set_ylim(100 * floor / 1.5, 100)
    axis.yaxis.set_major_formatter("{x:g}")
    axis.set_xlim(-0.5, len(shown) - 0.5)
    names = [SHORT.get(c.method, f"{c.bounces or 'all'}\n{c.facets:.3g}") for c, _ in shown]
    axis.set_xticks(range(len(shown)), names, fontsize=5.5)
    axis.set_title(recommendation.surface.name)
    axis.set_xlabel("bounces or method; facets met in the mean")


def _shown(recommendation: Any) -> list[tuple[Any, str]]:
    """Candidates and verdicts: all up to the choice, few behind it."""
    pairs = list(zip(recommendation.candidates, recommendation.verdicts, strict=True))
    behind = [c for c, verdict in pairs if verdict == "not needed" and not c.follows_all]
    return [(c, v) for c, v in pairs if c not in behind[MOST_AFTER:]]
