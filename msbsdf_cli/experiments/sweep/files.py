"""Light of a sweep on surfaces that are given in files."""

from dataclasses import dataclass
from functools import lru_cache
from hashlib import file_digest
from typing import ClassVar

import numpy as np

from msbsdf_cli.experiments.own_surface import (
    Job,
    number_of_pieces,
    piece_of,
    trace,
)
from msbsdf_cli.experiments.pilot import pilot
from msbsdf_cli.experiments.realisations import LobeGroups
from msbsdf_cli.experiments.sweep.states import State, of_tally, restore
from msbsdf_cli.experiments.sweep.surfaces import OF_MODELS, RAYS_PER_S, TRIANGLES_PER_S
from msbsdf_cli.results.files import Table
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import Run
from msbsdf_cli.results.tables import energy
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes.surface import Surface
from msbsdf_cli.statistics.tally import Tally
from surfaces.facet import Array
from surfaces.field import HeightField


@dataclass(frozen=True)
class Source:
    """A file of heights, and how it is read, as `HeightField.load` has it."""

    path: str
    digest: str
    """Of its bytes: whoever works on the sweep reads the same file."""
    step: tuple[float, float] | None
    height_unit: float | None
    periodic: bool
    detrend: int
    filter_length: float | None

    def field(self) -> HeightField:
        """The surface, read once in a process for all work on it that follows. Raises ValueError
        where there is none."""
        return _field(self)

    def slopes(self, scene: Scene) -> Array:
        """Slopes (2, nx, ny) of its facets."""
        return self.field().patch.slopes


def digest_of(path: str) -> str:
    """The SHA-256 of a file."""
    with open(path, "rb") as file:
        return file_digest(file, "sha256").hexdigest()


@lru_cache(maxsize=2)
def _field(source: Source) -> HeightField:
    if digest_of(source.path) != source.digest:
        raise ValueError(f"{source.path} is not the file with which the sweep began.")
    how = source.height_unit, source.periodic, source.detrend, source.filter_length
    return HeightField.load(source.path, source.step, *how)


@lru_cache(maxsize=8)
def own_slopes(source: Source) -> Surface:
    """The slopes of its facets, counted. Raises ValueError where they have no spread."""
    slopes = source.field().patch.slopes
    try:
        return Surface.of(slopes)
    except ValueError as error:
        raise ValueError(f"{source.path}: {error}") from None


@lru_cache(maxsize=256)
def notes_on(source: Source) -> tuple[str, ...]:
    """What was made of the file, and what about it costs accuracy, in sentences."""
    field = source.field()
    return *field.notes, *field.describe("").warnings


@dataclass(frozen=True)
class FileCase:
    """Light of one incident angle on a surface that is given."""

    kind: ClassVar[str] = "surface"
    shared: ClassVar[frozenset[str]] = frozenset(("slopes", "gamma", *OF_MODELS))

    scene: Scene
    """Nothing is traced by its slopes."""
    source: Source
    samples: int
    seed: int
    max_order: int
    directions: bool
    """Whether lobes are wanted too, and not the energies alone."""
    pieces: int
    windows: bool
    """Whether each piece of the surface is traced on a window of its own."""
    cells: int
    """Of the meshes that are kept at a time."""

    @classmethod
    def of(
        cls,
        scene: Scene,
        source: Source,
        samples: int,
        seed: int,
        max_order: int,
        directions: bool,
    ) -> "FileCase":
        """Cut into pieces as its size wants it."""
        how = scene, source, samples, seed, max_order, directions
        return cls(*how, *_cut(source))

    @property
    def parts(self) -> int:
        """A part for each piece of the surface."""
        return self.pieces

    @staticmethod
    def seconds(cases: list["FileCase"]) -> float:
        first = cases[0]
        meshes = 2 * first.cells / TRIANGLES_PER_S / (1 if first.windows else first.pieces)
        rays = sum(case.rays for case in cases) * pilot(first.scene)[1]
        return meshes + rays / RAYS_PER_S

    @property
    def rays(self) -> int:
        """On each piece."""
        return -(-self.samples // self.pieces)

    @staticmethod
    def measure(cases: list["FileCase"], part: int) -> list[State]:
        # Cases whose rays are the same are one.
        found = {case.seed: case.light(part) for case in {c.seed: c for c in cases}.values()}
        return [found[case.seed] for case in cases]

    def light(self, number: int) -> State:
        """Of the rays that start on a piece of the surface."""
        place = piece_of(self.source.field(), number, self.pieces, self.windows)
        how = self.rays, _none(), self.seed, self.max_order
        units = trace(Job(self.scene, place, number, *how))[0]
        tally, groups = Tally(self.scene.orders), LobeGroups(self.scene, self.pieces)
        tally.merge(units[0])
        state = of_tally(tally, self.directions)
        if self.directions:
            groups.add(units, number)
            state |= {"group_sums": groups.sums, "group_units": groups.units}
        return state

    def run(self, state: State) -> Run:
        """What all pieces came to, as `simulate` has it."""
        tally, groups = Tally(self.scene.orders), LobeGroups(self.scene, self.pieces)
        restore(tally, state)
        found = None
        if self.directions:
            groups.sums, groups.units = state["group_sums"], state["group_units"]
            found = groups.lobes()
        return Run("simulate", self.scene, [tally], _none(), "gaussian", found)

    def table(self, state: State) -> Table:
        """energy.csv of the case."""
        return energy(self.run(state).lobes())


@lru_cache(maxsize=256)
def _cut(source: Source) -> tuple[int, bool, int]:
    """Pieces, whether each has a window of its own, and cells of the meshes."""
    number, windows = number_of_pieces(source.field())
    # Mirror images are meshed with a patch, and what is around it with a window.
    cells = source.field().heights.size * (4 if windows or not source.periodic else 1)
    return number, windows, -(-cells // number) if windows else cells


def _none() -> FreePaths:
    """No free paths."""
    return FreePaths((), (), np.array([-np.inf, np.inf]))
