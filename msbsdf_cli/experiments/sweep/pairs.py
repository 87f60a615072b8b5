"""Surfaces and models of a sweep, held against each other."""

from dataclasses import dataclass, fields
from typing import Any

from msbsdf_cli.experiments.compare import Row, agreement
from msbsdf_cli.experiments.fitted_walks import traced
from msbsdf_cli.experiments.parts import parts
from msbsdf_cli.experiments.sweep.files import FileCase
from msbsdf_cli.experiments.sweep.fitted import FittedCase
from msbsdf_cli.experiments.sweep.methods import MethodCase
from msbsdf_cli.experiments.sweep.states import State
from msbsdf_cli.experiments.sweep.surfaces import SurfaceCase
from msbsdf_cli.experiments.sweep.walks import WalkCase
from msbsdf_cli.results.files import Table, columns


@dataclass(frozen=True)
class Pair:
    """Surfaces, and walks or methods, of one scene."""

    simulated: SurfaceCase
    modelled: WalkCase | MethodCase

    @property
    def cases(self) -> dict[str, Any]:
        return {case.kind: case for case in (self.simulated, self.modelled)}

    def table(self, states: dict[str, State]) -> Table:
        """agreement.csv of the case."""
        simulated = self.simulated.run(states[self.simulated.kind]).lobes()
        models = self.modelled.lobes(states[self.modelled.kind])
        return _table([row for model in models for row in agreement(simulated, model)])


@dataclass(frozen=True)
class InParts:
    """Surfaces whose slopes have no name, and walks on these and on what is fitted to them."""

    simulated: SurfaceCase | FileCase
    fitted: FittedCase

    @property
    def cases(self) -> dict[str, Any]:
        return {case.kind: case for case in (self.simulated, self.fitted)}

    def table(self, states: dict[str, State]) -> Table:
        """agreement.csv of the case: the parts of the difference."""
        run = self.simulated.run(states[self.simulated.kind])
        walks, name = self.fitted.walks(states[self.fitted.kind])
        light = traced(run.lobes(), run.paths)
        return _table(parts(self.fitted.scene, light, walks, name).rows)


def _table(rows: list[Row]) -> Table:
    return columns(rows, (f.name for f in fields(Row)))
