"""A simulated result beside a modelled one."""

import numpy as np

from msbsdf_cli.experiments.agreement import Row, distance, signed
from msbsdf_cli.results.result import Result
from msbsdf_cli.results.tables import order_names
from msbsdf_cli.statistics.distances import Histogram, total_variation
from msbsdf_cli.statistics.tally import PHI_BINS, SIDES, THETA_BINS, merge_bins
from surfaces.facet import Array

SAME = ("material", "wi", "orders")
"""Settings in which two results of one scene agree, whatever they come from."""


def compare(simulated: Result, modelled: Result) -> dict[str, Array]:
    """The rows of agreement.csv as arrays by column: energies, and distances between lobes.

    `difference` is modelled minus simulated, or the distance; `own` what it would be without
    noise, with its error bar `own_stderr`. Raises ValueError where the two are not of one scene.
    """
    for name in SAME:
        a, b = (r.settings.get(name) for r in (simulated, modelled))
        if a != b:
            raise ValueError(f"the results are of different scenes: {name} is {a} and {b}.")
    wi = np.array(simulated.settings["wi"])
    theta, phi = float(np.arccos(min(wi[2], 1))), float(np.arctan2(wi[1], wi[0]))
    rows: list[Row] = []
    for side, name in enumerate(SIDES):
        if not (simulated.energy[:, side].any() or modelled.energy[:, side].any()):
            continue
        for k, order in enumerate(order_names(simulated.orders)):
            values = (
                float(a[k, side])
                for r in (simulated, modelled)
                for a in (r.energy, r.energy_stderr)
            )
            rows.append(signed("energy", (theta, phi, order, name), *values))
        for order, part in _parts(simulated.orders).items():
            a, b = (_lobe(r, part, side) for r in (simulated, modelled))
            totals = [(float(h.value.sum()), float(np.sqrt((h.stderr**2).sum()))) for h in (a, b)]
            place = (theta, phi, order, name)
            rows.append(distance("total_variation", place, totals, total_variation(b, a)))
    columns = {name: [getattr(row, name) for row in rows] for name in Row.__dataclass_fields__}
    return {name: np.array(column) for name, column in columns.items() if name != "method"}


def _parts(orders: int) -> dict[str, list[int]]:
    """Rows of a lobe for each order and for all."""
    each = {name: [k] for k, name in enumerate(order_names(orders))}
    return each | {"all": list(range(orders + 1))}


def _lobe(result: Result, part: list[int], side: int) -> Histogram:
    """Energies of some orders in bins of 9 by 18 degrees, with standard errors."""
    lobe = result.estimate("lobe")
    value = lobe.value[part, side].sum(axis=0).reshape(THETA_BINS, PHI_BINS)
    square = (lobe.stderr[part, side] ** 2).sum(axis=0).reshape(THETA_BINS, PHI_BINS)
    return Histogram(merge_bins(value).ravel(), np.sqrt(merge_bins(square)).ravel())
