"""What each command that can be swept measures, from its options."""

import json
from dataclasses import dataclass
from typing import Any

import click

from msbsdf_cli.cli import common, compare_skewed, compare_surface, own_surface
from msbsdf_cli.cli.options import OF_FILE
from msbsdf_cli.cli.simulate import RESOLVED
from msbsdf_cli.experiments.resolution import LEAST_RAYS, plan, rays
from msbsdf_cli.experiments.slices import slice_directions
from msbsdf_cli.experiments.sweep.albedos import AlbedoCase
from msbsdf_cli.experiments.sweep.files import FileCase, notes_on, own_slopes
from msbsdf_cli.experiments.sweep.fitted import Facets, FittedCase, RandomFacets
from msbsdf_cli.experiments.sweep.methods import MethodCase
from msbsdf_cli.experiments.sweep.pairs import InParts, Pair
from msbsdf_cli.experiments.sweep.plan import Cases
from msbsdf_cli.experiments.sweep.surfaces import OF_MODELS, SurfaceCase
from msbsdf_cli.experiments.sweep.values import ValueCase
from msbsdf_cli.experiments.sweep.walks import WalkCase
from msbsdf_cli.experiments.sweep.work import Alone, Failure, Measured, place_of, seed_of
from msbsdf_cli.experiments.walk import remembered_surface
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Slopes

Options = dict[str, Any]

KINDS: dict[str, tuple[Any, ...]] = {
    "simulate": (SurfaceCase, FileCase),
    "walk": (WalkCase,),
    "compare": (SurfaceCase, FileCase, WalkCase, MethodCase, FittedCase),
    "evaluate": (ValueCase,),
    "furnace": (AlbedoCase,),
}
"""The kinds of work that each command may have."""


@dataclass
class Settings:
    """What is measured of each case of a sweep of `command`: its options are `options` with those
    that vary."""

    command: str
    options: Options
    cases: Cases
    given: frozenset[str]
    """Options that are not as the command has them by itself."""
    files: dict[str, str]
    """Digests of the surfaces that are given, by path."""

    def __post_init__(self) -> None:
        self.resolutions: dict[str, Any] = {}
        self.notes: dict[str, None] = {}

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
        if options.get("surface") is not None:
            return self._on_file(options, seed)
        if self.command == "walk":
            return Alone(_walks(options, seed, options["samples"], False))
        if self.command in ("evaluate", "furnace"):
            case = (_values if self.command == "evaluate" else _albedos)(options, seed)
            told = common.not_remembered(options | {"method": case.methods})
            self.notes |= dict.fromkeys(told)
            return Alone(case)
        if self.command == "simulate":
            return Alone(self._surfaces(options, seed, False))
        return self._pair(options, seed)

    def _pair(self, options: Options, seed: int) -> Pair | InParts:
        """Random surfaces and what is held against them."""
        compare_surface.check_gamma(options, "gamma" in self.given)
        if options["heights_of"] != "gaussian":
            compare_skewed.check_options(options)
            of_surface = WITHOUT_FREE_PATHS | {"slopes": "beckmann"}
            surfaces = self._surfaces(options | of_surface, seed, True)
            facets = RandomFacets(surfaces.resolution, seed)
            return InParts(surfaces, self._fitted(options, seed, surfaces.scene, facets))
        compare_surface.check_slopes(options)
        compare_surface.check_memory(options)
        surfaces = self._surfaces(options, seed, True)
        samples = surfaces.rays * surfaces.resolution.realisations
        if options["method"] is None:
            return Pair(surfaces, _walks(options, seed, samples, True))
        methods = common.methods_for(surfaces.scene, options["method"])
        how = seed_of(seed, _identity(options)), options["precision"], options["autocorrelation"]
        return Pair(surfaces, MethodCase(surfaces.scene, methods, samples, *how))

    def _on_file(self, options: Options, seed: int) -> Measured:
        """Light and walks on a surface that is given."""
        source = own_surface.source(options, self.files[options["surface"]])
        slopes = own_slopes(source)
        own_surface.check_roughness(options, slopes.alpha)
        self.notes |= dict.fromkeys(f"{options['surface']}: {n}" for n in notes_on(source))
        if self.command == "walk":
            options |= {"alpha": slopes.alpha}
            return Alone(_walks(options, seed, options["samples"], False, slopes))
        beckmann = options | {"slopes": "beckmann", "alpha": slopes.alpha}
        scene, samples = common.scene_from(beckmann), options["samples"] or LEAST_RAYS
        light = _identity(options, *OF_MODELS, "slopes", "gamma")
        how = samples, seed_of(seed, light), options["max_order"]
        traced = FileCase.of(scene, source, *how, directions=self.command == "compare")
        if self.command == "simulate":
            return Alone(traced)
        compare_surface.check_gamma(options, "gamma" in self.given)
        return InParts(traced, self._fitted(options | {"samples": samples}, seed, scene, source))

    def _fitted(self, options: Options, seed: int, scene: Scene, facets: Facets) -> FittedCase:
        slopes, gamma = (options[n] if n in self.given else None for n in ("slopes", "gamma"))
        return FittedCase(
            scene,
            facets,
            slopes,
            gamma,
            options["samples"] or LEAST_RAYS,
            seed_of(seed, _identity(options, "slopes")),
            options["precision"],
            options["max_order"],
        )

    def _surfaces(self, options: Options, seed: int, directions: bool) -> SurfaceCase:
        scene, resolution = common.scene_from(options), self._resolution(options)
        samples = options["samples"] or rays(resolution)
        return SurfaceCase(
            scene,
            -(-samples // resolution.realisations),
            resolution,
            common.free_paths_from(options, options["heights_of"]),
            seed,
            place_of(_identity(options, *OF_MODELS, *(["gamma"] if resolution.skewed else []))),
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
                own = {n: options[n] for n in ("slopes", "gamma") if n in options}
                mine = options | others.values(case) | {"theta": theta or options["theta"]} | own
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
    # Options without use, so that what is measured without them stays the same numbers.
    if options.get("surface") is None:
        but = (*but, *OF_FILES)
    if "heights_of" in options and options.get("method") is None:
        but = (*but, "method")
    return json.dumps({k: v for k, v in sorted(options.items()) if k not in but}, default=str)


OF_FILES = ("surface", *(name.replace("-", "_") for name in OF_FILE))
"""Options of a surface that is given."""

WITHOUT_FREE_PATHS: Options = {"free_path_theta": (), "free_path_height": (0.0,)}


def _walks(
    options: Options, seed: int, samples: int, directions: bool, slopes: Slopes | None = None
) -> WalkCase:
    scene = common.scene_from(options, slopes)
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


def _of_no_use(options: Options, methods: tuple[str, ...]) -> tuple[str, ...]:
    """Names of options that make no difference to these methods."""
    used = common.remember(methods) and options["autocorrelation"] != "gaussian"
    return () if used else ("autocorrelation",)


def _values(options: Options, seed: int) -> ValueCase:
    scene = common.scene_from(options)
    methods = common.methods_for(scene, options["method"])
    return ValueCase(
        scene,
        methods,
        slice_directions(scene, options["phi_o"], options["points"]),
        options["samples"],
        seed_of(seed, _identity(options, *_of_no_use(options, methods))),
        options["precision"],
        options["bidirectional"],
        options["autocorrelation"],
    )


def _albedos(options: Options, seed: int) -> AlbedoCase:
    scene = common.scene_from(options)
    methods = common.methods_for(scene, options["method"])
    return AlbedoCase(
        scene,
        methods,
        options["samples"],
        # Of all angles: they are measured together.
        seed_of(seed, _identity(options, "theta", *_of_no_use(options, methods))),
        options["accuracy"],
        options["autocorrelation"],
    )
