"""Directional albedos of a sweep, by any method."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from msbsdf_cli.experiments.furnace import (
    Albedos,
    AlbedoSums,
    FurnaceJob,
    albedo_sums,
    azimuths,
    furnace_table,
)
from msbsdf_cli.experiments.sweep.states import State
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.results.files import Table
from msbsdf_cli.scene import Scene

WALKS_PER_S = 2e4
"""Rough rate of one core."""


@dataclass(frozen=True)
class AlbedoCase:
    """Albedos of methods for one incident angle."""

    kind: ClassVar[str] = "furnace"
    shared: ClassVar[frozenset[str]] = frozenset(("theta",))
    """What `solve` sets up serves every angle."""

    scene: Scene
    methods: tuple[str, ...]
    samples: int
    seed: int
    accuracy: float | None
    autocorrelation: str = "gaussian"
    """Of the surfaces that a method remembers."""

    @property
    def parts(self) -> int:
        """A part for each method."""
        return len(self.methods)

    @staticmethod
    def seconds(cases: list["AlbedoCase"]) -> float:
        return sum(case.samples * len(azimuths(case.scene)) for case in cases) / WALKS_PER_S

    @staticmethod
    def measure(cases: list["AlbedoCase"], part: int) -> list[State]:
        # All angles at once: a method is set up for all of them.
        first = cases[0]
        scene = replace(first.scene, theta=tuple(c.scene.theta[0] for c in cases))
        how = first.samples, first.seed, first.accuracy, first.autocorrelation
        job = FurnaceJob(scene, first.methods[part], *how)
        sums = albedo_sums(job)
        return [_state(sums[i :: len(cases)], part, first.parts) for i in range(len(cases))]

    def table(self, state: State) -> Table:
        """furnace.csv of the case."""
        found = []
        for i, name in enumerate(self.methods):
            noiseless = METHODS[name].deterministic
            each = zip(state["counts"][i], state["sums"][i], strict=True)
            rows = [AlbedoSums(noiseless, *sums).estimate() for sums in each]
            value, stderr = (np.array(a)[:, None] for a in zip(*rows, strict=True))
            phi = azimuths(self.scene)
            found.append(Albedos(name, self.scene.alpha, phi, value, stderr))
        return furnace_table(self.scene, found)


def _state(sums: list[AlbedoSums], part: int, parts: int) -> State:
    """Of one method in its place among all; (method, azimuth, ...)."""
    counts, figures = (np.array([getattr(s, name) for s in sums]) for name in ("counts", "sums"))
    state = {"counts": np.zeros((parts, *counts.shape)), "sums": np.zeros((parts, *figures.shape))}
    state["counts"][part], state["sums"][part] = counts, figures
    return state
