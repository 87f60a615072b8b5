"""`--surface FILE`: the page of a surface that is given, for `simulate` and `walk`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from msbsdf_cli.cli.options import OF_FILE
from msbsdf_cli.cli.types import MOST_ROUGHNESS, UNITS
from msbsdf_cli.smith.slopes import OF_SURFACE

if TYPE_CHECKING:
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.sweep.files import Source

OF_RANDOM = (
    "alpha",
    "autocorrelation",
    "heights-of",
    "accuracy",
    "cells",
    "extent",
    "realisations",
    "waves",
    "convergence",
)
"""Options of surfaces that are made; those of a surface that is given are in the file."""


def check_options(options: dict[str, Any]) -> None:
    """Refuse options that belong to the other kind of surface. Raises click.UsageError."""
    given = options["surface"] is not None
    if "realisations" not in options and given != (options["slopes"] == OF_SURFACE):
        raise click.UsageError("--slopes surface and --surface FILE go together.")
    source = click.get_current_context().get_parameter_source
    for name in OF_RANDOM if given else (*OF_FILE, "wavelength"):
        if source(name.replace("-", "_")) is click.core.ParameterSource.COMMANDLINE:
            if given:
                raise click.UsageError(
                    f"--{name} beside --surface: it is for random surfaces, and a file has its own."
                )
            raise click.UsageError(f"--{name} without --surface: it is for a file of heights.")


def report(command: str, options: dict[str, Any]) -> "Report":
    """The report of a command that reads a surface, in a place that does not hold it."""
    from msbsdf_cli.cli.report import Report

    file = Path(options["surface"])
    return Report(command, f"{options['material']}-{file.stem}", options, (file,))


def scene_of_slopes(options: dict[str, Any], warn: "Report") -> Any:
    """The scene of the slopes of the surface, without heights. Raises click.BadParameter."""
    from msbsdf_cli.cli import common

    field = read(options)
    warn.warn(list(field.notes))
    slopes = own_slopes(field, options)
    options["alpha"] = slopes.alpha
    return common.scene_from(options, slopes)


def own_slopes(field: Any, options: dict[str, Any]) -> Any:
    """The slopes of the surface, counted. Raises click.BadParameter where they have no spread."""
    from msbsdf_cli.smith.slopes.surface import Surface

    try:
        return Surface.of(field.patch.slopes)
    except ValueError as error:
        raise click.BadParameter(f"{options['surface']}: {error}", param_hint="--surface") from None


def simulate(options: dict[str, Any]) -> None:
    """Read the surface, describe it, trace light on it, and write the report."""
    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.meshes import refuse_mesh
    from msbsdf_cli.cli.runs import show_run, write_run
    from msbsdf_cli.experiments.own_surface import simulate_surface
    from msbsdf_cli.experiments.resolution import LEAST_RAYS
    from msbsdf_cli.run.executors import do_all

    place = report("simulate", options)
    refuse_mesh(options)
    free_paths = common.free_paths_from(options, "gaussian")
    field = read(options)
    refuse_size(field, options["threads"])
    about = described(field, options)
    options["alpha"] = tuple(about[f"alpha_{axis}"].value for axis in "xy")
    options["slopes"] = OF_SURFACE
    scene = common.scene_from(options, own_slopes(field, options))
    place.warn([*common.scene_warnings(options), *field.notes, *about.warnings])
    names = ("seed", "threads", "max_order", "quiet")
    with place.draft() as draft:
        options["samples"] = options["samples"] or LEAST_RAYS
        work = scene, field, options["samples"], free_paths
        result = simulate_surface(*work, *(options[name] for name in names))
        tables = {"roughness.csv": about.to_columns()}
        lobes, pictures = write_run(place, draft, result, tables)
        draw(draft, scene, field, options)
        do_all(pictures, options["threads"])

    def show() -> None:
        show_run(lobes, result, "rays")
        show_roughness(about, field)

    place.end(show)


def read(options: dict[str, Any]) -> Any:
    """The field of the file. Raises click.BadParameter where it holds none."""
    from surfaces.field import HeightField

    try:
        field = HeightField.load(options["surface"], *how_read(options))
    except ValueError as error:
        raise click.BadParameter(f"{error}", param_hint="--surface") from None
    return field


def how_read(options: dict[str, Any]) -> tuple[Any, ...]:
    """What `HeightField.load` takes beside the file."""
    unit, length = (options[name] and options[name][0] for name in ("height_unit", "filter"))
    return options["step"], unit, options["periodic"], options["detrend"], length


def source(options: dict[str, Any], digest: str) -> "Source":
    """The file and how it is read, for others to read it, wherever they were started."""
    from msbsdf_cli.experiments.sweep.files import Source

    return Source(str(Path(options["surface"]).resolve()), digest, *how_read(options))


def refuse_size(field: Any, threads: int) -> None:
    """Refuse what this machine has no memory for. Raises click.BadParameter."""
    from msbsdf_cli.cli.meshes import BYTES_PER_CELL
    from msbsdf_cli.experiments.own_surface import number_of_pieces
    from msbsdf_cli.run.memory import gigabytes, memory_bytes

    number, windows = number_of_pieces(field)
    need = BYTES_PER_CELL * field.heights.size * (1 if field.periodic else 4)
    if windows:
        need = BYTES_PER_CELL * 4 * field.heights.size // number * threads
    if need > memory_bytes():
        raise click.BadParameter(
            f"{' x '.join(map(str, field.heights.shape))} points need {gigabytes(need)}, and this "
            f"machine has {gigabytes(memory_bytes())}; average some of them.",
            param_hint="--surface",
        )


def described(field: Any, options: dict[str, Any]) -> Any:
    """Its roughness in figures. Raises click.BadParameter for what no surface is."""
    wavelength = options["wavelength"] and options["wavelength"][0]
    about = field.describe(unit(options), wavelength)
    check_roughness(options, tuple(about[f"alpha_{axis}"].value for axis in "xy"))
    return about


def check_roughness(options: dict[str, Any], alphas: tuple[float, float]) -> None:
    """Refuse what no surface is. Raises click.BadParameter."""
    for axis, alpha in zip("xy", alphas, strict=True):
        if alpha > MOST_ROUGHNESS:
            raise click.BadParameter(
                f"{options['surface']} has the roughness {alpha:.2g} along {axis}, beyond every "
                "surface: its heights and its steps are in different units, which --step and "
                "--height-unit tell.",
                param_hint="--surface",
            )
        if not alpha > 0:
            raise click.BadParameter(
                f"{options['surface']} has no slopes along {axis}: facets that all lean one way "
                "are no rough surface.",
                param_hint="--surface",
            )


def unit(options: dict[str, Any]) -> str:
    """Name of the unit of heights and steps; meshes do not say."""
    from surfaces.files import FORMATS

    mesh = FORMATS[Path(options["surface"]).suffix.lower()] == "meshes"
    return "" if mesh and options["step"] is None else "m"


def draw(draft: Path, scene: Any, field: Any, options: dict[str, Any]) -> None:
    """Draw the surface, here where its mesh is, and save that where it is wanted; of a large one a
    piece is drawn."""
    from msbsdf_cli.cli.meshes import write_mesh
    from msbsdf_cli.experiments.own_surface import number_of_pieces, parts
    from msbsdf_cli.plots.surface import draw_surface

    if options["save_mesh"] is not None:
        write_mesh(Path(options["save_mesh"]), field.mesh())
    part = next(parts(field, *number_of_pieces(field)))
    draw_surface(draft, part.field.surface, part.field.stretch(0.0), scene.alpha)


SHOWN = ("sq", "correlation_length", "alpha_x", "alpha_y", "direction_rad", "student_t_gamma")


def show_roughness(about: Any, field: Any) -> None:
    """Print what a reader would want to know first, and of what."""
    show_quantities(about)
    size = " x ".join(map(str, field.heights.shape))
    ends = "which go on at their sides" if field.periodic else "which their mirror images continue"
    click.echo(f"{size} points, {ends}; errors come from how pieces of the surface differ.")


def show_quantities(about: Any) -> None:
    """Print roughness and what fits to it."""
    import math

    from msbsdf_cli.cli.terminal import measured, show_table

    lines = []
    for row in about.rows:
        if row.quantity in SHOWN or "misfit" in row.quantity:
            name, note = row.unit, row.note if row.quantity == "student_t_gamma" else ""
            if name == "m":
                name = next((u for u, size in reversed(UNITS.items()) if row.value >= size), "nm")
            size = UNITS.get(name, 1.0)
            if name == "rad":
                size, name = math.pi / 180, "degrees"
            lines.append(
                (
                    row.quantity.removesuffix("_rad"),
                    measured(row.value / size, row.stderr / size),
                    name,
                    note,
                )
            )
    show_table(("quantity", "value", "unit", "note"), lines, "roughness.csv", len(about.rows))
