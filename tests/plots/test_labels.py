"""Names of curves hide neither one another nor, where there is room, the curves."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from msbsdf_cli.plots.labels import name_curves


@pytest.mark.parametrize("apart", [0.3, 0.02])
def test_names_hide_neither_one_another_nor_curves(apart):
    figure = Figure((5, 4))
    axis = figure.add_axes((0.1, 0.1, 0.85, 0.85))
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlim(1e-3, 1e2)
    axis.set_ylim(1e-4, 1)
    x = np.geomspace(1e-2, 1, 200)
    names = "walk", "position-free-uncorrelated", "walk-low-variance", "exact", "solve"
    curves = {
        name: (np.array([x, 0.02 * 10 ** (k * apart) / x]), "k") for k, name in enumerate(names)
    }
    curves["published"] = np.array([np.full(200, 1.5), np.geomspace(1e-3, 0.5, 200)]), "k"
    texts = np.array([np.geomspace(1e-3, 1e-1, 40), np.full(40, 0.02)])
    name_curves(axis, curves, texts)
    FigureCanvasAgg(figure).draw()
    boxes = [Text.get_window_extent(text) for text in axis.texts]  # Without leaders.
    assert [text.get_text() for text in axis.texts] == list(curves)
    frame = axis.get_window_extent()
    assert all(frame.x0 <= b.x0 and b.x1 <= frame.x1 for b in boxes)
    assert all(frame.y0 <= b.y0 and b.y1 <= frame.y1 for b in boxes)
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    points = axis.transData.transform(np.concatenate([*(c.T for c, _ in curves.values()), texts.T]))
    assert not any(b.contains(*point) for b in boxes for point in points)
