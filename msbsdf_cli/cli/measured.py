"""What each command that can be swept measures, from its options."""

import json
from dataclasses import dataclass
from typing import Any

import click

from msbsdf_cli.cli import common
from msbsdf_cli.cli.simulate import RESOLVED
from msbsdf_cli.experiments.resolution import plan, rays
from msbsdf_cli.experiments.slices import slice_directions
from msbsdf_cli.experiments.sweep.albedos import AlbedoCase
from msbsdf_cli.experiments.sweep.pairs import Pair
from msbsdf_cli.experiments.sweep.plan import Cases
from msbsdf_cli.experiments.sweep.surfaces import OF_MODELS, SurfaceCase
from msbsdf_cli.experiments.sweep.values import ValueCase
from msbsdf_cli.experiments.sweep.walks import WalkCase
from msbsdf_cli.experiments.sweep.work import Alone, Failure, Measured, place_of, seed_of
from msbsdf_cli.experiments.walk import remembered_surface

Options = dict[str, Any]

KINDS: dict[str, tuple[Any, ...]] = {
    "simulate": (SurfaceCase,),
    "walk": (WalkCase,),
    "compare": (SurfaceCase, WalkCase),
    "evaluate": (ValueCase,),
    "furnace": (AlbedoCase,),
}
"""The kinds of work of each command."""


@dataclass
class Settings:
    """What is measured of each case of a sweep of `command`: its options are `options` with those
    that vary."""

    command: str
    options: Options
    cases: Cases

    def __post_init__(self) -> None:
        self.resolutions: dict[str, Any] = {}

    def __call__(self, case: int, seed: int) -> Measured | Failure:
        """What is measured of a case with a seed, or why nothing can be."""
        options = self.options | self.cases.values(case)
        try:
            return self._measured(options, seed)
        except click.ClickException as refusal:
            return Failure(refusal.format_message())
        except ValueError as refusal:
            return Failure(f"{refusal}")

    def _measured(self, options: Options, seed: int) -> Measured:
        if self.command == "walk":
            return Alone(_walks(options, seed, options["samples"], False))
        if self.command == "evaluate":
            return Alone(_values(options, seed))
        if self.command == "furnace":
            return Alone(_albedos(options, seed))
        both = self.command == "compare"
        surfaces = self._surfaces(options, seed, both)
        if not both:
            return Alone(surfaces)
        samples = surfaces.rays * surfaces.resolution.realisations
        return Pair(surfaces, _walks(options, seed, samples, True))

    def _surfaces(self, options: Options, seed: int, directions: bool) -> SurfaceCase:
        scene, resolution = common.scene_from(options), self._resolution(options)
        samples = options["samples"] or rays(resolution)
        return SurfaceCase(
            scene,
            -(-samples // resolution.realisations),
            resolution,
            common.free_paths_from(options, "gaussian"),
            seed,
            place_of(_identity(options, *OF_MODELS)),
            options["max_order"],
            directions,
        )

    def _resolution(self, options: Options) -> Any:
        """The finest that any of the cases needs that have the surfaces in common."""
        axes = self.cases.axes
        shared = [axis for axis in axes if axis.name in SurfaceCase.shared]
        key = _identity(options, *SurfaceCase.shared)
        if key not in self.resolutions:
            # All angles at once, as `simulate` takes them.
            theta = tuple(t for a in axes if a.name == "theta" for (t,) in a.values)
            others = Cases(tuple(axis for axis in shared if axis.name != "theta"))
            found = []
            for case in range(len(others)):
                mine = options | others.values(case) | {"theta": theta or options["theta"]}
                given = (mine[name] for name in RESOLVED)
                found.append(plan(common.scene_from(mine), mine["accuracy"], *given))
            self.resolutions[key] = _finest(found)
        return self.resolutions[key]


def _finest(found: list[Any]) -> Any:
    from dataclasses import replace

    most = {n: max(getattr(r, n) for r in found) for n in ("cells", "extent", "realisations")}
    return replace(found[0], **most)


def _identity(options: Options, *but: str) -> str:
    """What is measured, in words, but for options that make no difference to it."""
    return json.dumps({k: v for k, v in sorted(options.items()) if k not in but}, default=str)


def _walks(options: Options, seed: int, samples: int, directions: bool) -> WalkCase:
    scene = common.scene_from(options)
    common.check_memory(scene, {"heights": "gaussian"} | options)
    return WalkCase(
        scene,
        samples,
        common.free_paths_from(options, "gaussian"),
        "gaussian",
        seed_of(seed, _identity(options)),
        options["precision"],
        options["max_order"],
        directions,
        remembered_surface(scene.slopes, options["memory"], options["autocorrelation"]),
    )


def _values(options: Options, seed: int) -> ValueCase:
    scene = common.scene_from(options)
    return ValueCase(
        scene,
        common.methods_for(scene, options["method"]),
        slice_directions(scene, options["phi_o"], options["points"]),
        options["samples"],
        seed_of(seed, _identity(options)),
        options["precision"],
        options["bidirectional"],
    )


def _albedos(options: Options, seed: int) -> AlbedoCase:
    scene = common.scene_from(options)
    return AlbedoCase(
        scene,
        common.methods_for(scene, options["method"]),
        options["samples"],
        # Of all angles: they are measured together.
        seed_of(seed, _identity(options, "theta")),
        options["accuracy"],
    )
