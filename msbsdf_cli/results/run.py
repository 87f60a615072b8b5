"""What a run of either producer came to: sums that merge, save and load, and figures of the run."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.results import npz
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.lobes import Lobes, lobes_of
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import OF_SURFACE, Beckmann
from msbsdf_cli.statistics.surface_tally import SurfaceTally
from msbsdf_cli.statistics.tally import Tally
from surfaces.facet import Array

FORMAT = "run of msbsdf 1"


@dataclass
class Run:
    """Tallies, one for each incident angle of a scene, free paths, and how the run went."""

    kind: str
    """`simulate` or `walk`."""
    scene: Scene
    tallies: list[Tally]
    free_paths: FreePaths
    heights: str
    """Distribution of heights that the free paths are of."""
    lobe_groups: Array | None = None
    """Energies of independent groups of surfaces, (theta, group, order, side, merged bin)."""
    wall_s: float = 0.0
    notes: dict[str, float] = field(default_factory=dict)
    """Figures of the run worth keeping beside the results."""
    group_units: Array | None = None
    """Surfaces of each group; None where they are not independent of those of other runs."""
    memory: int = 0
    """Facets that walks remember."""

    @property
    def paths(self) -> int:
        """Rays or walks finished."""
        return sum(tally.rays for tally in self.tallies)

    @property
    def bounces_mean(self) -> float:
        """Facets hit by a ray or walk, in the mean."""
        return sum(tally.facets for tally in self.tallies) / self.paths

    def lobes(self) -> Lobes:
        """The light that left, with standard errors."""
        scene, transmits = self.scene, self.scene.material.transmits
        light = self.tallies, self.lobe_groups, self.free_paths
        return lobes_of(self.label, scene.theta, scene.phi, transmits, *light)

    @property
    def label(self) -> str:
        """`simulate`, `walk`, or `walk-memory` for walks that remember facets."""
        return f"{self.kind}-memory" if self.memory else self.kind

    def bounces(self) -> list[tuple[tuple[float, float], tuple[float, float]]]:
        """Of each incident angle the share of light that leaves after one bounce, and after more,
        each with its standard error.

        Errors of several orders or sides add up as squares for walks, of which each leaves by one
        of them, and by themselves for surfaces, where they may go together: at least the true one.
        """
        power = 2 if self.kind == "walk" else 1
        found = []
        for tally in self.tallies:
            energy, unresolved = tally.estimate("energy"), tally.estimate("unresolved")
            once, more = (
                (
                    float(energy.value[k].sum()),
                    float((energy.stderr[k] ** power).sum()) ** (1 / power),
                )
                for k in (slice(1), slice(1, None))
            )
            if not self.scene.material.absorbs:
                # What does not leave after one bounce leaves later, and is known as well.
                error = min(once[1], more[1]) + float(unresolved.stderr)
                once, more = ((share, min(own, error)) for share, own in (once, more))
            found.append((once, more))
        return found

    @property
    def same_scene(self) -> Scene:
        """What a run by another seed has in common with it: where slopes were counted on random
        surfaces, their roughness, and not what the facets of these very surfaces came to."""
        random = self.kind == "simulate" and self.group_units is not None
        if not random or self.scene.slopes.name != OF_SURFACE:
            return self.scene
        return replace(self.scene, slopes=Beckmann(*self.scene.alpha))

    def merge(self, other: "Run") -> None:
        """Take in the light of another run of the same scene, by another seed.

        Raises ValueError where that would not be one long run.
        """
        of_both = [
            {"kind": r.label, "scene": r.same_scene, "heights": r.heights} for r in (self, other)
        ]
        for name, a in of_both[0].items():
            if a != (b := of_both[1][name]):
                raise ValueError(f"the runs differ in {name}: {a} and {b}.")
        for run in (self, other):
            if run.kind == "simulate" and run.group_units is None:
                raise ValueError("light on a given surface is of no other realisation of it.")
        for mine, tally in zip(self.tallies, other.tallies, strict=True):
            mine.merge(tally)
        self.free_paths.merge(other.free_paths)
        self._merge_groups(other)
        self.wall_s += other.wall_s
        for name, figure in other.notes.items():
            self.notes[name] = self.notes.get(name, 0) + figure

    def _merge_groups(self, other: "Run") -> None:
        """Groups of as many surfaces each as they have together; without groups of one of the
        runs there are none."""
        mine, theirs = (r.lobe_groups for r in (self, other))
        a, b = self.group_units, other.group_units
        if mine is None or theirs is None or a is None or b is None or mine.shape != theirs.shape:
            self.lobe_groups = self.group_units = None
            return
        units = a + b
        share = (a / units)[:, None, None, None]
        self.lobe_groups = np.asarray(share * mine + (1 - share) * theirs, np.float32)
        self.group_units = units

    def save(self, path: str | Path) -> None:
        """Write the sums to an .npz file."""
        paths = self.free_paths
        about = {name: getattr(self, name) for name in ("kind", "heights", "wall_s", "notes")}
        about |= {"scene": self.scene.settings(), "rays": paths.rays, "memory": self.memory}
        about |= {"free_path_theta": paths.theta, "free_path_starts": paths.starts}
        arrays = {f"free_path_{name}": getattr(paths, name) for name in FREE_PATH}
        if paths.moved is not None:
            about["rays_moved"] = paths.moved.rays
            arrays |= {f"moved_{name}": getattr(paths.moved, name) for name in FREE_PATH[1:]}
        for i, tally in enumerate(self.tallies):
            arrays |= {f"light_{i}_{name}": array for name, array in tally.arrays().items()}
            about |= {"extent": tally.extent} if isinstance(tally, SurfaceTally) else {}
        if self.lobe_groups is not None:
            arrays["lobe_groups"] = self.lobe_groups
        if self.group_units is not None:
            arrays["group_units"] = self.group_units
        npz.write(path, FORMAT, about, arrays)


FREE_PATH = ("edges", "sums", "weights", "units")


def load_run(path: str | Path) -> Run:
    """A run that `Run.save` wrote. Raises ValueError for a file that holds none."""
    about, arrays = npz.read(path, FORMAT)
    try:
        return _run(about, arrays)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ValueError(f"{path} does not hold a run: {error}.") from None


def _run(about: dict[str, Any], arrays: dict[str, Array]) -> Run:
    scene = Scene.of(about["scene"])
    tallies = [_tally(scene.orders, i, about, arrays) for i in range(len(scene.theta))]
    paths = FreePaths(
        tuple(about["free_path_theta"]), tuple(about["free_path_starts"]), arrays["free_path_edges"]
    )
    _restore(paths, arrays, "free_path_", about["rays"])
    if "rays_moved" in about:
        paths.moved = paths.empty()
        _restore(paths.moved, arrays, "moved_", about["rays_moved"])
    light = about["kind"], scene, tallies, paths, about["heights"], arrays.get("lobe_groups")
    how = about["wall_s"], about["notes"], arrays.get("group_units"), about.get("memory", 0)
    return Run(*light, *how)


def _restore(paths: FreePaths, arrays: dict[str, Array], start: str, rays: int) -> None:
    """Put sums whose names have that start into empty free paths."""
    for name in FREE_PATH[1:]:
        getattr(paths, name)[:] = arrays[f"{start}{name}"]
    paths.rays = int(rays)


def _tally(orders: int, angle: int, about: dict[str, Any], arrays: dict[str, Array]) -> Tally:
    start = f"light_{angle}_"
    mine = {name.removeprefix(start): a for name, a in arrays.items() if name.startswith(start)}
    tally = Tally(orders)
    if "products" in mine:
        tally = SurfaceTally(orders, len(mine["products"]), float(about["extent"]))
    tally.restore(mine)
    return tally
