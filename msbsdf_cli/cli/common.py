"""What the commands share: the scene from the options, warnings, and where reports go."""

import math
from typing import Any

import click

from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.scene import Scene, in_degrees
from msbsdf_cli.smith.heights import height_distribution
from msbsdf_cli.smith.slopes import NAMES as SLOPES
from msbsdf_cli.smith.slopes import Slopes, distribution, parameters
from surfaces.materials import NAMES as MATERIALS
from surfaces.materials import Material, material

RAYS_PER_S = 1e6
TRIANGLES_PER_S = 1e6
EVALUATIONS_PER_S = 2e7
"""Rough rates of one core, for telling beforehand what takes long; evaluations are walks times
directions."""

LONG_S = 60
"""Seconds, by rough estimates, from which a run is called long beforehand."""


def scene_from(options: dict[str, Any], slopes: Slopes | None = None) -> Scene:
    """The scene that options describe, but for `slopes` that come from elsewhere. Raises
    click.UsageError for what is none."""
    if slopes is None:
        name = options["slopes"]
        shape = {parameter: options[parameter] for parameter in parameters(name)}
        slopes = distribution(name)(*options["alpha"], **shape)
    return Scene(
        seen_from(options, material_from(options)),
        slopes,
        options["theta"],
        options["phi"][0],
        options["orders"],
    )


def check_memory(scene: Scene, options: dict[str, Any]) -> None:
    """Refuse, by click.UsageError, --memory of surfaces that are not Gaussian."""
    if options["memory"] and scene.slopes.name != "beckmann":
        raise click.UsageError(
            f"--memory {options['memory']} beside --slopes {scene.slopes.name}: a walk remembers "
            "facets of Gaussian surfaces, whose slopes are beckmann."
        )
    if options["memory"] and options["heights"] != "gaussian":
        raise click.UsageError(
            f"--memory {options['memory']} beside --heights {options['heights']}: heights of the "
            "surfaces that a walk remembers are gaussian."
        )


def seen_from(options: dict[str, Any], facets: Material) -> Material:
    """The facets as they are from the side that light comes from: at theta beyond pi/2 from inside,
    where the surface is turned over. Raises click.BadParameter where there is no such side."""
    inside = [theta for theta in options["theta"] if theta > math.pi / 2]
    if not inside:
        return facets
    said = f"{inside[0]:.4g} ({in_degrees(inside[0])}) is light from inside"
    if not facets.transmits:
        reason = f"{said}, and nothing is inside of --material {facets.name}."
    elif len(inside) < len(options["theta"]):
        reason = f"{said}, and other angles are outside; run each side by itself."
    elif options.get("surface") or options.get("heights_of", "gaussian") != "gaussian":
        reason = f"{said}, where peaks of this surface are pits; turn it over with --ior 1/N."
    else:
        return facets.turned_over
    raise click.BadParameter(reason, param_hint="--theta")


def material_from(options: dict[str, Any]) -> Material:
    """The facets' material; raises click.UsageError for options that describe none."""
    kind = material(options["material"])
    try:
        found: Material = kind.of(**{name: options.get(name) for name in kind.options})
    except ValueError as error:
        names = ", ".join(f"--{name.replace('_', '-')}" for name in kind.options)
        raise click.UsageError(f"{names}: {error}") from None
    return found


def free_paths_from(options: dict[str, Any], heights: str) -> FreePaths:
    """Empty free paths of the wanted directions and heights of start.

    Raises click.BadParameter for a height at which there is no surface.
    """
    distribution = height_distribution(heights)
    starts = options["free_path_height"] or distribution.starts
    for start in starts:
        if distribution.t(start) == float("inf"):
            raise click.BadParameter(
                f"{start:g} is below all of the surface, whose heights are {heights}.",
                param_hint="--free-path-height",
            )
    return FreePaths(options["free_path_theta"], starts, distribution.edges)


MANY_FACETS = 30
"""Facets that light meets in the mean from which a run is long on their account."""


def scene_warnings(options: dict[str, Any]) -> list[str]:
    """Sentences on what is allowed but has no effect."""
    given = click.get_current_context().get_parameter_source
    return [
        f"--{name.replace('_', '-')} has no effect: it is for --material {other}, "
        f"and this is {options['material']}."
        for other in (other for other in MATERIALS if other != options["material"])
        for name in material(other).options
        if given(name) is click.core.ParameterSource.COMMANDLINE
    ] + slopes_warnings(options)


def slopes_warnings(options: dict[str, Any]) -> list[str]:
    """Sentences on parameters of other slope distributions."""
    given, slopes = click.get_current_context().get_parameter_source, options.get("slopes")
    return [
        f"--{name} has no effect: it is for --slopes {other}, and these are {slopes}."
        for other in SLOPES
        if slopes not in (None, other)
        for name in parameters(other)
        if given(name) is click.core.ParameterSource.COMMANDLINE
    ]


def long_warnings(options: dict[str, Any], work_s: float, work: str) -> list[str]:
    """A sentence where a run takes long: `work_s` is about how many seconds one core will need,
    and `work` says for what."""
    expected = work_s / options["threads"]
    if expected < LONG_S:
        return []
    fewer = "--replicates or --directions" if "replicates" in options else "--samples"
    if options.get("realisations"):
        fewer += " or a coarser --accuracy"
    return [f"this will take about {duration(expected)}, for {work}; fewer {fewer} take less."]


def method_warnings(scenes: list[Scene], methods: tuple[str, ...]) -> list[str]:
    """Sentences on scenes in which the walk meets many facets, or that take `solve` long."""
    from msbsdf_cli.methods.registry import METHODS

    random = not all(METHODS[name].deterministic for name in methods)
    facets = [text for scene in scenes if random for text in facet_warnings(scene)]
    return facets + [text for scene in scenes for text in solve_warnings(scene, methods)]


def remember(methods: tuple[str, ...]) -> bool:
    """Whether any of the methods remembers surfaces."""
    from msbsdf_cli.methods.registry import METHODS

    return any(METHODS[name].traits.model == "memory" for name in methods)


def not_remembered(options: dict[str, Any]) -> list[str]:
    """A sentence on --autocorrelation where no method remembers surfaces."""
    if remember(options["method"]) or options["autocorrelation"] == "gaussian":
        return []
    return ["--autocorrelation has no effect: it is for the method walk-memory."]


def facet_warnings(scene: Scene) -> list[str]:
    """A sentence where light meets many facets."""
    from msbsdf_cli.experiments.pilot import pilot

    facets = pilot(scene)[1]
    if facets <= MANY_FACETS:
        return []
    alpha = ",".join(f"{a:g}" for a in scene.alpha)
    return [
        f"light meets {facets:.0f} facets in the mean at roughness {alpha} before it leaves, each "
        "of which costs as much as a walk of ordinary surfaces; the run takes long."
    ]


def solve_warnings(scene: Scene, methods: tuple[str, ...]) -> list[str]:
    """A sentence where `solve` is among the methods and takes longer than anybody expects."""
    from msbsdf_cli.methods.solver.size import value_seconds

    takes = value_seconds(scene.slopes, scene.material)
    if "solve" not in methods or takes < LONG_FOR_A_METHOD_S:
        return []
    alpha = ",".join(f"{a:g}" for a in scene.alpha)
    return [
        f"method solve needs about {duration(takes)} at roughness {alpha}: the narrower "
        "the lobes, the more directions it has to tell apart."
    ]


LONG_FOR_A_METHOD_S = 45
"""Seconds of one method, by a rough law, that a user is told of beforehand."""


def methods_for(scene: Scene, wanted: tuple[str, ...] | None) -> tuple[str, ...]:
    """The methods that the user wants, or all that hold for the scene.

    Raises click.BadParameter for a method that does not.
    """
    from msbsdf_cli.methods.protocol import UnsupportedError
    from msbsdf_cli.methods.registry import METHODS

    holding = []
    for name in wanted or METHODS:
        try:
            METHODS[name].check_supported(scene.slopes, scene.material)
            holding.append(name)
        except UnsupportedError as refusal:
            if wanted:
                raise click.BadParameter(f"{refusal}.", param_hint="--method") from None
    return tuple(holding)


def check_exr() -> None:
    """Raise click.UsageError where OpenEXR is not installed."""
    from msbsdf_cli.renderers.exr import MISSING, has_exr

    if not has_exr():
        raise click.UsageError(f"--exr: {MISSING}")


def duration(seconds: float) -> str:
    """About how long, in words."""
    if seconds > 2 * 86400:
        return f"{seconds / 86400:.3g} days"
    if seconds < 90:
        whole = round(seconds)
        return f"{whole} second{'s' * (whole != 1)}"
    return f"{seconds / 3600:.1f} hours" if seconds > 7200 else f"{seconds / 60:.0f} minutes"
