"""Surfaces and walks of a sweep, held against each other."""

from dataclasses import dataclass, fields
from typing import Any

from msbsdf_cli.experiments.compare import Row, agreement
from msbsdf_cli.experiments.sweep.states import State
from msbsdf_cli.experiments.sweep.surfaces import SurfaceCase
from msbsdf_cli.experiments.sweep.walks import WalkCase
from msbsdf_cli.results.files import Table, columns


@dataclass(frozen=True)
class Pair:
    """Surfaces and walks of one scene."""

    simulated: SurfaceCase
    modelled: WalkCase

    @property
    def cases(self) -> dict[str, Any]:
        return {case.kind: case for case in (self.simulated, self.modelled)}

    def table(self, states: dict[str, State]) -> Table:
        """agreement.csv of the case."""
        runs = (case.run(states[case.kind]) for case in (self.simulated, self.modelled))
        rows = agreement(*(run.lobes() for run in runs))
        return columns(rows, (f.name for f in fields(Row)))
