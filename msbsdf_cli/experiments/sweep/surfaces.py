"""Surfaces of a sweep: one random field serves every roughness, angle and material."""

from dataclasses import dataclass
from typing import ClassVar

from msbsdf_cli.experiments.control_variates import NUMBER, expected
from msbsdf_cli.experiments.pilot import pilot
from msbsdf_cli.experiments.random_surfaces import Resolution
from msbsdf_cli.experiments.realisations import (
    LobeGroups,
    Meshes,
    SurfaceJob,
    SurfaceResult,
    trace_surface,
)
from msbsdf_cli.experiments.sweep.states import (
    MOVED,
    State,
    of_free_paths,
    of_tally,
    restore,
    restore_free_paths,
)
from msbsdf_cli.results.files import Table
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import Run
from msbsdf_cli.results.tables import energy
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.discretisation import on_all_meshes
from msbsdf_cli.statistics.surface_tally import SurfaceTally
from surfaces.facet import Array
from surfaces.marginal import Marginal, marginal

PART = 4
"""Realisations of a part."""

OF_MODELS = ("memory", "precision", "method")
"""Options of what is held against surfaces: cases that differ in them alone share all light."""

RAYS_PER_S, TRIANGLES_PER_S = 1e6, 1e6
"""Rough rates of one core."""


@dataclass(frozen=True)
class SurfaceCase:
    """Light of one incident angle on realisations of a surface."""

    kind: ClassVar[str] = "simulate"
    shared: ClassVar[frozenset[str]] = frozenset(
        (
            *("alpha", "theta", "phi", "material", "ior", "metal", "eta_k", "albedo"),
            *("slopes", "gamma", *OF_MODELS),
        )
    )

    scene: Scene
    rays: int
    """On each realisation."""
    resolution: Resolution
    free_paths: FreePaths
    """Empty, of the directions and heights wanted."""
    seed: int
    place: int
    """Where the case's rays begin in their random stream."""
    max_order: int
    directions: bool
    """Whether lobes and free paths are wanted too, and not the energies alone."""

    @property
    def parts(self) -> int:
        return -(-self.resolution.realisations // PART)

    @property
    def cells(self) -> int:
        """Of the meshes that are kept at a time."""
        return round(1.4 * (self.resolution.cells * self.resolution.extent) ** 2)

    @staticmethod
    def seconds(cases: list["SurfaceCase"]) -> float:
        resolution, middle = cases[0].resolution, cases[len(cases) // 2]
        meshes = 2 * (resolution.cells * resolution.extent) ** 2 / TRIANGLES_PER_S
        rays = sum(case.rays for case in cases) * pilot(middle.scene)[1]
        return PART * (meshes + rays / RAYS_PER_S)

    @staticmethod
    def measure(cases: list["SurfaceCase"], part: int) -> list[State]:
        # Cases whose rays are in one place of their stream are one.
        wanted = {case.place: _Sums(case) for case in cases}
        first = cases[0]
        last = min((part + 1) * PART, first.resolution.realisations)
        heights_are = marginal(first.resolution.heights_of)
        known = [sums.expected(heights_are) for sums in wanted.values()]
        for number in range(part * PART, last):
            fields = Meshes(first.resolution, number, first.seed)
            for sums, mean in zip(wanted.values(), known, strict=True):
                sums.add(number, trace_surface(sums.case.job(number, mean), fields))
        states = {place: sums.state() for place, sums in wanted.items()}
        return [states[case.place] for case in cases]

    def job(self, number: int, mean: Array) -> SurfaceJob:
        """What is traced on one realisation, and what control variates come to in the mean."""
        paths = self.free_paths
        return SurfaceJob(
            self.scene,
            self.resolution,
            number,
            self.rays,
            paths.theta if self.directions else (),
            paths.starts,
            tuple(paths.edges),
            self.seed,
            self.max_order,
            (mean,),
            on_all_meshes=number < on_all_meshes(self.resolution.realisations),
            place=self.place,
        )

    def run(self, state: State) -> Run:
        """What all parts came to, as `simulate` has it."""
        sums = _Sums(self)
        restore(sums.tally, state)
        groups = None
        if self.directions:
            restore_free_paths(sums.paths, state)
            if f"{MOVED}free_path_sums" in state:
                sums.paths.moved = sums.paths.empty()
                restore_free_paths(sums.paths.moved, state, MOVED)
            sums.groups.sums, sums.groups.units = state["group_sums"], state["group_units"]
            groups = sums.groups.lobes()
        return Run("simulate", self.scene, [sums.tally], sums.paths, "gaussian", groups)

    def table(self, state: State) -> Table:
        """energy.csv of the case."""
        return energy(self.run(state).lobes())


class _Sums:
    """Sums over realisations of one case."""

    def __init__(self, case: SurfaceCase) -> None:
        self.case, resolution = case, case.resolution
        self.tally = SurfaceTally(case.scene.orders, NUMBER, resolution.lengths)
        self.paths = case.free_paths.empty()
        self.groups = LobeGroups(case.scene, resolution.realisations)

    def expected(self, heights: Marginal) -> Array:
        """What control variates come to in the mean."""
        scene = self.case.scene
        return expected(scene.slopes, scene.wi(scene.theta[0]), heights)

    def add(self, number: int, found: SurfaceResult) -> None:
        """Take in the light of one realisation."""
        self.tally.add_surface(found.light[0])
        if self.case.directions:
            self.groups.add([found.light[0].unit], number)
            self.paths.add_unit(*found.paths)

    def state(self) -> State:
        """All sums by name."""
        state = of_tally(self.tally, self.case.directions)
        if self.case.directions:
            state |= of_free_paths(self.paths)
            # Of every piece, as states have the same names; not all have surfaces on two meshes.
            state |= of_free_paths(self.paths.moved or self.paths.empty(), MOVED)
            state["group_sums"] = self.groups.sums
            state["group_units"] = self.groups.units
        return state
