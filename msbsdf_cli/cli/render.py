"""`msbsdf render`"""

from functools import partial
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import MODEL_IN_COLOUR, REPORT, use
from msbsdf_cli.cli.types import Count
from msbsdf_cli.experiments.render.scenes import NAMES, TEXTURES

SURFACE = tuple(name for name in MODEL_IN_COLOUR if name not in ("theta", "phi"))


def own_defaults(function: Any) -> Any:
    """The options of the surface, whose defaults are the scene's."""
    function = use(*SURFACE)(function)
    for option in function.__click_params__:
        if option.name in ("material", "slopes", "alpha"):
            option.show_default = "that of SCENE"
    return function


@click.command("render", cls=Page)
@click.argument(
    "scene", required=False, default="plate", type=click.Choice(NAMES), metavar="[SCENE]"
)
@use("method-or-surfaces")
@own_defaults
@click.option(
    "--texture",
    type=click.Choice(TEXTURES),
    help="plate: what differs from point to point, up to --alpha; by default roughness.",
)
@click.option(
    "--samples",
    type=Count(2),
    default="64",
    show_default=True,
    help="Paths for each pixel.",
)
@click.option(
    "--width", type=Count(8, most=8192), default="288", show_default=True, help="Pixels across."
)
@click.option(
    "--strategy",
    type=click.Choice(["mis", "bsdf", "light"]),
    default="mis",
    show_default=True,
    help="How light is found: samples of the BSDF, of the lights, or both, weighed.",
)
@click.option(
    "--claims",
    is_flag=True,
    help="Instead of a picture: what a paper says of the cost of many bounces, measured.",
)
@click.option("--exr", is_flag=True, help="Linear pictures as OpenEXR too.")
@use("seed", "threads", *REPORT)
def command(**options: Any) -> None:
    """A small scene shaded by several methods, side by side; by default single and walk.

    SCENE is `plate` (a texture of roughness, albedo or anisotropy), `furnace` (constant white
    light, in which what loses no energy disappears), `sphere`, `bottle` or `slab`. Each has a
    surface of its own, which options change. The first method is the one that others are held
    against.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.render.picture import Settings, render, table_of
    from msbsdf_cli.plots.render import draw_pictures
    from msbsdf_cli.run.executors import do_all

    if options["claims"]:
        write_claims(options)
        return
    fill_in(options)
    if options["exr"]:
        common.check_exr()
    stage = stage_from(options)
    surface = common.scene_from(options | {"theta": (0.0,), "phi": (0.0,), "orders": 1})
    methods = options["method"]
    check_methods(surface, methods, options["texture"])
    slug = f"{options['scene']}-{surface.material.name}-{surface.slopes.name}"
    report = Report("render", slug, options)
    report.warn(common.scene_warnings(options) + without_effect(options))
    height = round(options["width"] / stage.camera.aspect)
    paths = options["width"] * height * options["samples"] * len(methods)
    report.warn(common.long_warnings(options, *effort(surface, options, paths)))
    settings = Settings(
        options["width"], height, options["samples"], options["seed"], options["strategy"]
    )
    with report.draft() as draft:
        around = options["threads"], options["quiet"]
        pictures = render(stage, surface.slopes, surface.material, methods, settings, *around)
        report.warn(what_happened(pictures))
        table = table_of(pictures)
        more = {"exposure": stage.exposure, "summary": in_one_sentence(table, options)}
        report.write(draft, {"render.csv": table}, paths, more=more)
        save_arrays(pictures, draft, options["exr"])
        drawn = pictures, stage.exposure, draft / "render.png"
        do_all([partial(draw_pictures, *drawn)], options["threads"])
    report.end(lambda: show(table))


def write_claims(options: dict[str, Any]) -> None:
    """The report of --claims."""
    from dataclasses import fields

    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.render.claims import Claim, claims
    from msbsdf_cli.results.files import columns

    given = click.get_current_context().get_parameter_source
    counts = ("claims", "seed", "threads", "out", "force", "format", "quiet", "as_json")
    for name in [name for name in options if name not in counts]:
        if given(name) is click.core.ParameterSource.COMMANDLINE:
            said = "SCENE" if name == "scene" else f"--{name.replace('_', '-')}"
            raise click.UsageError(f"{said} beside --claims: these have scenes of their own.")
        # What has no effect is no option of this run.
        del options[name]
    report = Report("render", "claims", options)
    with report.draft() as draft:
        found = claims(options["seed"], options["threads"], options["quiet"])
        table = columns(found, (f.name for f in fields(Claim)))
        report.write(draft, {"claims.csv": table}, 0, more={"summary": of_claims(found)})
    report.end(lambda: show_claims(found))


def of_claims(found: list[Any]) -> str:
    """How many claims have which verdict."""
    from collections import Counter

    counted = Counter("hold" if c.verdict == "holds" else f"are {c.verdict}" for c in found)
    return f"Of {len(found)} claims {', '.join(f'{n} {v}' for v, n in counted.items())}."


def show_claims(found: list[Any]) -> None:
    """Print a line for each claim."""
    from msbsdf_cli.cli.terminal import measured, show_table

    rows = [(c.claim, f"{c.published:g}", measured(c.measured, c.stderr), c.verdict) for c in found]
    show_table(("claim", "published", "measured", "verdict"), rows, "claims.csv")


def without_effect(options: dict[str, Any]) -> list[str]:
    """A sentence on --albedo where a texture has its own."""
    given = click.get_current_context().get_parameter_source
    if (
        options["texture"] != "albedo"
        or given("albedo") is not click.core.ParameterSource.COMMANDLINE
    ):
        return []
    return ["--albedo has no effect: the texture has albedos of its own."]


def effort(surface: Any, options: dict[str, Any], paths: int) -> tuple[float, str]:
    """About how many seconds one core will need, and for what."""
    ior = surface.material.ior
    # Light is thrown to and fro within a body until it meets its side steeply enough to leave.
    seconds, work = paths / PATHS_PER_S * max(ior, 1 / ior) ** 2, f"{paths:.2g} paths"
    levels = 1 if options["texture"] == "none" else 8
    sides = 1 + surface.material.transmits
    for name, each in TABLE_S.items():
        if name in options["method"]:
            seconds += levels * sides * each
            work += f" and tables of {name}"
    return seconds, work


TABLE_S = {"solve": 6, "surfaces": 30}
"""Seconds of one core for a table of one roughness, roughly."""

PATHS_PER_S = 1.5e5
"""Rough rate of one core."""


def fill_in(options: dict[str, Any]) -> None:
    """Put the scene's own surface where nothing was given; a texture goes where a roughness comes,
    and its metal where another material does."""
    from msbsdf_cli.experiments.render.scenes import defaults

    context = click.get_current_context()
    of_scene = defaults(options["scene"])
    given = {
        name
        for name in options
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
    }
    if {"material", "eta_k"} & given:
        of_scene = {k: v for k, v in of_scene.items() if k not in ("metal", "rgb")}
    elif "metal" in given:
        of_scene["material"] = "conductor"
    for parameter in context.command.params:
        name = parameter.name
        if name in of_scene and name not in given:
            options[name] = parameter.type_cast_value(context, of_scene[name])
    if options["texture"] is None:
        options["texture"] = "none"
    if options["method"] is None:
        options["method"] = ("single", "walk")


def stage_from(options: dict[str, Any]) -> Any:
    """The scene. Raises click.BadParameter for a texture that it does not have, or that the
    surface does not."""
    from msbsdf_cli.experiments.render.scenes import stage

    if options["texture"] == "albedo" and options["material"] != "diffuse":
        raise click.BadParameter(
            f"albedo is of diffuse facets, and these are {options['material']}.",
            param_hint="--texture",
        )
    try:
        return stage(options["scene"], options["texture"])
    except ValueError as error:
        raise click.BadParameter(f"{error}", param_hint="--texture") from None


def check_methods(surface: Any, methods: tuple[str, ...], texture: str) -> None:
    """Raise click.BadParameter for a method that cannot shade this surface."""
    from msbsdf_cli.experiments.render.picture import check_shades
    from msbsdf_cli.methods.protocol import UnsupportedError

    for name in methods:
        try:
            check_shades(name, surface.slopes, surface.material, texture)
        except UnsupportedError as refusal:
            raise click.BadParameter(f"{refusal}.", param_hint="--method") from None


def what_happened(pictures: list[Any]) -> list[str]:
    """Sentences on paths that were lost, and on what methods cannot do."""
    lost = [
        f"{p.lost} of {p.mean[0].size * p.samples} paths by {p.method} were lost to rounding at "
        "edges, and count as dark."
        for p in pictures
        if p.lost
    ]
    nonfinite = [
        f"{p.nonfinite} values by {p.method} were not finite: that method replaces them or leaves "
        "them out, and the picture is off by what they stood for."
        for p in pictures
        if p.nonfinite
    ]
    cut = [
        f"{p.cut} walks by {p.method} were cut off after as many facets as it follows, and count "
        "as dark from there on."
        for p in pictures
        if p.cut
    ]
    return lost + nonfinite + cut


def save_arrays(pictures: list[Any], draft: Path, exr: bool) -> None:
    """Linear radiance (height, width, 3) and its standard error, as .npy and .exr."""
    import numpy as np

    for p in pictures:
        for name, image in ((p.method, p.mean), (f"{p.method}_stderr", p.stderr)):
            linear = np.moveaxis(image, 0, -1).astype(np.float32)
            np.save(draft / f"{name}.npy", linear)
            if exr:
                from msbsdf_cli.renderers.exr import write_exr

                write_exr(draft / f"{name}.exr", linear)


def in_one_sentence(table: Any, options: dict[str, Any]) -> str:
    """Noise and time of each method, and how far its picture is from the first."""
    from msbsdf_cli.cli.terminal import in_percent

    parts, first = [], table["luminance"][0]
    for k, name in enumerate(table["method"]):
        text = f"{name} takes {table['seconds'][k] + table['setup_seconds'][k]:.2g} s"
        text += f" and leaves {100 * table['noise'][k]:.2g} % of noise"
        if k and first > 0:
            apart = in_percent(
                abs(table["difference"][k]) / first, table["difference_stderr"][k] / first
            )
            side = "brighter" if table["difference"][k] > 0 else "darker"
            text += f", {apart} {side} than {table['method'][0]}"
        parts.append(text)
    return f"At {options['samples']} paths a pixel {'; '.join(parts)}."


def show(table: Any) -> None:
    """Print a line for each method."""
    from msbsdf_cli.cli.terminal import measured, show_table

    rows = [
        (
            table["method"][k],
            measured(table["luminance"][k], table["luminance_stderr"][k]),
            f"{100 * table['noise'][k]:.2g} %",
            f"{table['seconds'][k]:.1f}",
            f"{table['setup_seconds'][k]:.1f}",
            f"{table['surfaces_per_path'][k]:.2f}",
            measured(table["difference"][k], table["difference_stderr"][k]) if k else "",
        )
        for k in range(len(table["method"]))
    ]
    head = ("method", "mean luminance", "noise of a pixel", "processor s", "of tables")
    show_table((*head, "surfaces", "difference"), rows, "render.csv")
    for name, error in zip(table["method"], table["table_error"], strict=True):
        if error:
            click.echo(f"The table of {name} is off by {100 * error:.2g} %, which no error shows.")
