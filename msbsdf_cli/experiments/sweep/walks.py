"""Random walks of a sweep."""

from dataclasses import dataclass
from itertools import islice
from typing import ClassVar

import numpy as np

from msbsdf_cli.experiments.pilot import pilot
from msbsdf_cli.experiments.sweep.states import (
    State,
    of_free_paths,
    of_tally,
    restore,
    restore_free_paths,
)
from msbsdf_cli.experiments.walk import WALKS, jobs, run_walks
from msbsdf_cli.experiments.walks import add_free_paths
from msbsdf_cli.memory.remembered import TAKES, Remembered
from msbsdf_cli.model import Smith
from msbsdf_cli.results.files import Table
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.results.run import Run
from msbsdf_cli.results.tables import energy
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.tally import Tally

JOBS = 64
"""Jobs of a part at most: some seconds of work, which is what a process that dies may cost."""
JOBS_OF_HEIGHTS = 4
"""The same of walks that draw the heights which rays pass."""


@dataclass(frozen=True)
class WalkCase:
    """Walks of one scene with one incident angle."""

    kind: ClassVar[str] = "walk"
    shared: ClassVar[frozenset[str]] = frozenset()

    scene: Scene
    samples: int
    free_paths: FreePaths
    """Empty, of the directions and heights wanted."""
    heights: str
    seed: int
    precision: str
    max_order: int
    directions: bool
    """Whether lobes and free paths are wanted too, and not the energies alone."""
    memory: Remembered | None = None

    @property
    def parts(self) -> int:
        return -(-self.samples // self.part)

    @property
    def part(self) -> int:
        """Walks of a part."""
        heights = self.memory is not None and self.memory.number == 2
        return WALKS * (JOBS_OF_HEIGHTS if heights else JOBS)

    @staticmethod
    def seconds(cases: list["WalkCase"]) -> float:
        return sum(case.part_s() for case in cases)

    def part_s(self) -> float:
        """Seconds of a part, about."""
        takes = TAKES[0 if self.memory is None else self.memory.number]
        return takes * pilot(self.scene)[0] * min(self.samples, self.part)

    @staticmethod
    def measure(cases: list["WalkCase"], part: int) -> list[State]:
        return [case.walked(part) for case in cases]

    def walked(self, part: int) -> State:
        """The walks of a part, as `walk` numbers them; the free paths are with the first."""
        scene, tally = self.scene, Tally(self.scene.orders)
        wi = scene.wi(scene.theta[0], np.dtype(self.precision).type)
        walks = jobs(
            Smith(scene.slopes, scene.material),
            wi,
            self.samples,
            scene.orders,
            self.seed,
            self.max_order,
            memory=self.memory,
        )
        jobs_of_part = self.part // WALKS
        for job in islice(walks, part * jobs_of_part, (part + 1) * jobs_of_part):
            tally.merge(run_walks(job)[1])
        state = of_tally(tally, self.directions)
        if self.directions:
            paths = self.free_paths.empty()
            if part == 0:
                how = self.heights, self.samples, self.seed, self.memory
                add_free_paths(scene, paths, *how)
            state |= of_free_paths(paths)
        return state

    def run(self, state: State) -> Run:
        """What all parts came to, as `walk` has it."""
        tally, paths = Tally(self.scene.orders), self.free_paths.empty()
        restore(tally, state)
        if self.directions:
            restore_free_paths(paths, state)
        remembers = 0 if self.memory is None else self.memory.number
        return Run("walk", self.scene, [tally], paths, self.heights, memory=remembers)

    def lobes(self, state: State) -> list[Lobes]:
        """The light that left."""
        return [self.run(state).lobes()]

    def table(self, state: State) -> Table:
        """energy.csv of the case."""
        return energy(self.lobes(state)[0])
