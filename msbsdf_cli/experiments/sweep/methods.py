"""Lobes of methods of a sweep, in the bins of its surfaces."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from msbsdf_cli.experiments.method_lobes import SAMPLES_OF_RAYS, bins, method_lobes, places
from msbsdf_cli.experiments.pilot import pilot
from msbsdf_cli.experiments.sweep.states import State
from msbsdf_cli.experiments.sweep.values import EVALUATIONS_PER_S, in_place
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.tally import Estimate

ESTIMATES = "energy", "bins"


@dataclass(frozen=True)
class MethodCase:
    """Lobes of methods for one incident angle."""

    kind: ClassVar[str] = "methods"
    shared: ClassVar[frozenset[str]] = frozenset(("theta",))
    """What `solve` sets up serves every angle."""

    scene: Scene
    methods: tuple[str, ...]
    rays: int
    """Of the surfaces that the lobes are held against."""
    seed: int
    precision: str
    autocorrelation: str = "gaussian"
    """Of the surfaces."""

    @property
    def parts(self) -> int:
        """A part for each method."""
        return len(self.methods)

    @staticmethod
    def seconds(cases: list["MethodCase"]) -> float:
        scene = cases[0].scene
        directions = bins(scene.material.transmits, places(scene))[0].shape[1]
        walks = sum(case.rays for case in cases) * SAMPLES_OF_RAYS * max(pilot(scene)[1], 1)
        return walks * directions / EVALUATIONS_PER_S

    @staticmethod
    def measure(cases: list["MethodCase"], part: int) -> list[State]:
        return [case.sums(part) for case in cases]

    def sums(self, part: int) -> State:
        """The lobes of one method, in its place among those of all."""
        how = self.seed, 1, self.precision, True, self.autocorrelation
        (found,) = method_lobes(self.scene, (self.methods[part],), self.rays, *how)
        state = {"runs": np.array(1.0)}
        for name in ESTIMATES:
            estimate = getattr(found, name)
            state |= {name: estimate.value, f"{name}_errors": estimate.stderr}
            state |= {f"{name}_variances": estimate.stderr**2}
        return {name: in_place(array, part, self.parts) for name, array in state.items()}

    def lobes(self, state: State) -> list[Lobes]:
        """The lobes of each method; those of several seeds together have less noise, but a
        discretisation errs as one of them does."""
        scene = self.scene
        found: list[Lobes] = []
        for i, name in enumerate(self.methods):
            mine = {key: array[i] for key, array in state.items()}
            energy, bins = (_mean(mine, key, METHODS[name].deterministic) for key in ESTIMATES)
            place = scene.theta, scene.phi, scene.orders, scene.material.transmits
            found.append(Lobes(name, *place, energy, bins))
        return found


def _mean(state: State, name: str, deterministic: bool) -> Estimate:
    runs = state["runs"]
    if deterministic:
        return Estimate(state[name] / runs, state[f"{name}_errors"] / runs)
    return Estimate(state[name] / runs, np.sqrt(state[f"{name}_variances"]) / runs)
