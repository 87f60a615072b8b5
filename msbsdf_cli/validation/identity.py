"""An identity to measure: how, and in which configurations."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.validation.configurations import Configuration

Measure = Callable[[Configuration, int, np.random.Generator], Iterable[Finding]]


@dataclass(frozen=True)
class Identity:
    """A measurement, and the configurations it is made in."""

    measure: Measure
    """Findings in one configuration, from so many samples."""
    hard: Callable[[], list[Configuration]]
    """Fixed configurations, chosen to be difficult."""
    drawn: Callable[[np.random.Generator], Configuration] | None = None
    """One random configuration."""
    draws: int = 0
    """Random configurations in a full run."""
    thin: int = 1
    """A quick run has one of so many of the fixed configurations."""
    share: float = 1.0
    """Samples for a configuration, over those that the user asked for."""
    least: int = 1024
    """Samples below which nothing could be told, whatever the user asks for."""
    cost: float = 1.0
    """Seconds that a configuration takes in a full run, over those of masking, roughly."""
