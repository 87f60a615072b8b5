"""How far one model's light is from another's: over the light that a surface sends back, and as the
eye sees it.

A relative error is the larger of two: of the directional albedo, and the total variation of the
lobe, half the sum of absolute differences over directions. Surfaces of three channels have a colour
too, and models of them a colour difference, CIEDE2000, in which 1 is just noticeable.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.statistics.colour import albedo_difference
from msbsdf_cli.statistics.distances import Histogram, total_variation
from surfaces.facet import Array

CONFIDENCE = 2.0
"""Standard errors to the bound of an error: 19 times of 20, to both sides."""

CHANNELS_OF_COLOUR = 3
"""Red, green and blue of linear sRGB."""

Energies = tuple[Array, Array]
"""Of each channel, (channels,), and how well they are known."""


@dataclass(frozen=True)
class Place:
    """An incident direction, in radians, and a roughness."""

    theta: float
    phi: float
    alpha: tuple[float, float]


@dataclass(frozen=True)
class Apart:
    """How far a model is off at one place, in the channel where it is most."""

    place: Place
    albedo: float
    lobe: float
    bound: float
    """Of both: as far as known, neither is larger."""
    colour: float = math.nan
    """Colour difference; not a number where there is no colour."""
    colour_bound: float = math.nan

    def error(self, colour_scale: float) -> float:
        """The largest, a colour difference times a factor among them if there is one."""
        return max(self.albedo, self.lobe, colour_scale * self.colour)

    def most(self, colour_scale: float) -> float:
        """Its upper bound."""
        return max(self.bound, colour_scale * self.colour_bound)


def by_energy(place: Place, model: Energies, truth: Energies) -> Apart:
    """Of a model that leaves out late bounces: what it lacks is all that its lobe has wrong."""
    missing, known = over(np.maximum(truth[0] - model[0], 0), truth[0]), over(truth[1], truth[0])
    albedo = float(missing.max())
    bound = float((missing + known).max())
    return Apart(place, albedo, albedo / 2, bound, *_colours(model, truth))


def by_lobe(
    place: Place,
    model: Energies,
    truth: Energies,
    lobes: Sequence[tuple[Histogram, Histogram, Array | None]],
    doubt: Array | float = 0.0,
) -> Apart:
    """Of a model whose lobe in each channel is given beside the true one, and groups of that, all
    of them with the same light left out. `doubt` (channels,) is what may be wrong beside noise, of
    energies."""
    found = [total_variation(*three) for three in lobes]
    # An estimate below 0 is off by as much at least.
    own = np.array([d.own for d in found])
    wide = CONFIDENCE * np.array([d.own_stderr for d in found]) + np.maximum(-own, 0) + doubt
    known = CONFIDENCE * np.hypot(model[1], truth[1]) + doubt
    lobe, albedo = np.maximum(own, 0), np.abs(model[0] - truth[0])
    bound = np.maximum(lobe + wide, albedo + known)
    lobe, albedo, bound = (over(each, truth[0]) for each in (lobe, albedo, bound))
    wider = model[0], CONFIDENCE * model[1] + doubt
    colours = _colours(wider, (truth[0], CONFIDENCE * truth[1]))
    return Apart(place, float(albedo.max()), float(lobe.max()), float(bound.max()), *colours)


def over(a: Array, b: Array) -> Array:
    """a / b, and 0 in a channel that is black."""
    return np.divide(a, b, out=np.zeros(np.broadcast_shapes(a.shape, b.shape)), where=b > 0)


def _colours(model: Energies, truth: Energies) -> tuple[float, float]:
    """Colour difference and its upper bound, which adds what each channel's error alone makes of
    either colour."""
    if len(model[0]) != CHANNELS_OF_COLOUR:
        return math.nan, math.nan
    apart = float(albedo_difference(model[0], truth[0]))
    moved = [
        albedo_difference(energy, energy + error * np.eye(CHANNELS_OF_COLOUR)[c])
        for energy, error in (model, truth)
        for c in range(CHANNELS_OF_COLOUR)
    ]
    return apart, apart + float(np.sum(moved))
