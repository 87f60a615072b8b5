"""How wrong methods are along a slice, held against the most trustworthy of them."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.evaluate import Values
from msbsdf_cli.experiments.slices import channel_names
from msbsdf_cli.methods.registry import METHODS, most_trusted
from msbsdf_cli.statistics.distances import Histogram, total_variation


@dataclass(frozen=True)
class SliceError:
    """A row of errors.csv."""

    method: str
    against: str
    theta_i_rad: float
    phi_i_rad: float
    channel: str
    error: float
    """Sum over the slice of the sizes of differences, over that of the values they are from, by
    which each direction counts as much as light goes there; below 0 only by noise."""
    stderr: float


def slice_errors(values: list[Values], phi: float) -> list[SliceError]:
    """All methods and incident angles in all channels; nothing where no method can be trusted, or
    `dark` says that there is nothing to be wrong about."""
    against = most_trusted(v.method for v in values)
    truth = {v.theta: v for v in values if v.method == against}
    rows = []
    for v in (v for v in values if against is not None and v.method != against):
        for c, channel in enumerate(channel_names(len(v.value))):
            if dark(truth[v.theta], c):
                continue
            error = _error(v, truth[v.theta], c)
            rows.append(SliceError(v.method, str(against), v.theta, phi, channel, *error))
    return rows


def dark(truth: Values, channel: int) -> bool:
    """Whether less light than its noise goes to the directions of the slice."""
    value, stderr = truth.value[channel, -1], truth.stderr[channel, -1]
    return not value.sum() > np.sqrt((stderr**2).sum())


def _error(mine: Values, truth: Values, channel: int) -> tuple[float, float]:
    """Relative error and its standard error. What a method without noise states of its own error
    may be off one way everywhere, and adds up as it is."""
    difference = mine.value[channel, -1] - truth.value[channel, -1]
    noise, stated, groups = np.zeros_like(difference), 0.0, []
    for v, sign in ((mine, 1), (truth, -1)):
        stderr = v.stderr[channel, -1]
        if METHODS[v.method].deterministic:
            stated += float(stderr.sum())
        else:
            noise = np.hypot(noise, stderr)
        known = v.value[None, channel, -1] if v.groups is None else v.groups[:, channel]
        groups.append(sign * known)
    apart, error = float(np.abs(difference).sum()), 0.0
    if noise.any():
        scatter = groups[0] + groups[1]
        none = Histogram(np.zeros_like(difference), np.zeros_like(difference))
        found = total_variation(
            none, Histogram(difference, noise), scatter if len(scatter) > 1 else None
        )
        apart, error = 2 * found.own, 2 * found.own_stderr
    total = float(truth.value[channel, -1].sum())
    return apart / total, float(np.hypot(error, stated)) / total
