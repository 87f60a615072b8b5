"""One model, and surfaces whose heights correlate in several ways: how far it is off on each.

The Smith model knows slopes and no correlation of heights, so that all surfaces of one roughness
have one BSDF in it. What it makes of single bounces rests on slopes first of all; where light goes
after them, on what lies around.
"""

import numpy as np

from msbsdf_cli.experiments.compare import Row, agreement, signed
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.statistics.tally import Estimate
from surfaces.facet import Array

MULTIPLE = "multiple_bounces"
"""The quantity of agreement.csv that is the energy of all bounces but the first."""


def multiple(lobes: Lobes) -> Estimate:
    """Energy that leaves after two bounces or more, (theta,): what neither leaves after the first,
    nor is absorbed or still under way.

    Its error is that of the first order, and of what is absorbed: for mirrors exactly, and else at
    most, since both sides of a first order go along with each other, and absorption with later
    bounces.
    """
    value = lobes.energy.value[:, 1:].sum(axis=(1, 2))
    first = lobes.energy.stderr[:, 0, : len(lobes.sides)].sum(axis=1)
    rest = [e.stderr for e in lobes.rest.values()]
    return Estimate(value, np.sqrt(first**2 + sum(np.square(e) for e in rest)))


def rows_of(simulated: Lobes, modelled: Lobes) -> list[Row]:
    """Rows of agreement.csv, and those of `MULTIPLE`."""
    mine, theirs = multiple(simulated), multiple(modelled)
    rows = []
    for i, theta in enumerate(simulated.theta):
        place = theta, simulated.phi, ">1", "all"
        pair = [(float(e.value[i]), float(e.stderr[i])) for e in (mine, theirs)]
        rows.append(signed(MULTIPLE, place, pair[0], pair[1], modelled.label))
    return rows + agreement(simulated, modelled)


def relative(rows: list[Row]) -> tuple[Array, Array, Array]:
    """Incident angles, by how much the energy of multiple bounces is too high there, relative to
    what it is, and the standard error of that."""
    mine = [row for row in rows if row.quantity == MULTIPLE]
    theta, simulated, modelled, *errors = (
        np.array([getattr(row, name) for row in mine])
        for name in ("theta_i_rad", "simulated", "modelled", "simulated_stderr", "modelled_stderr")
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = modelled / simulated
        stderr = np.hypot(errors[1], ratio * errors[0]) / simulated
    return theta, ratio - 1, stderr
