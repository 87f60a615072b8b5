"""`msbsdf compare`"""

import math
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.options import FREE_PATH, MODEL_OF_SURFACES, REPORT, RESOLUTION, samples, use


@click.command("compare")
@click.argument("runs", nargs=-1, metavar="[RUN [RUN]]", type=click.Path())
@use(*MODEL_OF_SURFACES, "orders", "method")
@samples("2e6")
@use(*RESOLUTION, "mesh", "max-order", *FREE_PATH, "seed", "threads", "precision", *REPORT)
def command(runs: tuple[str, ...], **options: Any) -> None:
    """Hold the Smith model against explicit surfaces: free paths and lobes.

    RUN is the directory of a report of `simulate` or `walk`; what is not given is run, for the
    same scene. Writes agreement.csv and pictures, and the reports that it made as directories.
    With --method, the lobes of other methods are held against the surfaces instead of the walk.
    """
    from msbsdf_cli.cli import common, simulate, walk
    from msbsdf_cli.experiments.agreement import in_order
    from msbsdf_cli.results.directory import new_report
    from msbsdf_cli.results.manifest import show_json

    if len(runs) > 2:
        raise click.UsageError(f"{len(runs)} reports are given; two are compared.")
    handed = take_runs(runs, options)
    options["heights"] = "gaussian"
    scene = common.scene_from(options)
    common.free_paths_from(options, "gaussian")
    out = common.out_directory("compare", scene.slug(), options)
    simulate.refuse_mesh(options)
    warnings, work_s = [], 0.0
    if "simulate" not in handed:
        simulate.resolve(scene, options)
        warnings += simulate.surface_warnings(options)
        work_s += simulate.work_s(options)
    if options["method"] is not None:
        if "walk" in handed:
            raise click.UsageError(
                f"--method replaces the walk; leave out {handed['walk']}, or leave out --method."
            )
        options["method"] = common.methods_for(scene, options["method"])
    elif "walk" not in handed:
        work_s += walk.work_s(options)
    warnings += common.scene_warnings(options, work_s)
    common.announce(warnings)
    if len(handed) == 2:
        in_order(*handed.values())
    with new_report(out) as draft:
        if "simulate" not in handed:
            (draft / "simulate").mkdir()
            simulate.run(draft / "simulate", scene, options, [])
        simulated = handed.get("simulate", draft / "simulate")
        modelled = models(draft, scene, options, handed)
        rows, record = write_comparison(draft, simulated, modelled, options, warnings)
    if options["as_json"]:
        show_json(record | {"report": str(out)})
    elif not options["quiet"]:
        show(rows)
        click.echo(f"\n{record['summary']}\nReport: {out}")


def models(
    draft: Path, scene: Any, options: dict[str, Any], handed: dict[str, Path]
) -> dict[str, Path]:
    """Reports of the methods wanted, or of the walk, made where they are not handed over."""
    from msbsdf_cli.cli import walk
    from msbsdf_cli.experiments.method_lobes import write_method_lobes

    if options["method"] is not None:
        return write_method_lobes(draft, scene, options["method"], options)
    if "walk" not in handed:
        (draft / "walk").mkdir()
        walk.run(draft / "walk", scene, options, [])
    return {"walk": handed.get("walk", draft / "walk")}


def take_runs(runs: tuple[str, ...], options: dict[str, Any]) -> dict[str, Path]:
    """The reports handed over, by command, with their scene put into `options`.

    Raises click.UsageError where a scene is given beside them, and click.ClickException for what
    is not a report.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.experiments.agreement import SAME
    from msbsdf_cli.results.directory import read_run

    handed: dict[str, Path] = {}
    for name in runs:
        run = read_run(Path(name))
        if run["command"] in handed:
            raise click.ClickException(
                f"both reports are of `{run['command']}`; one of `simulate` and one of `walk` "
                "are compared."
            )
        handed[run["command"]] = Path(name)
        scene = (*SAME, "slopes", *common.material_options(), *FREE_PATH)
        source = click.get_current_context().get_parameter_source
        for option in (o.replace("-", "_") for o in scene):
            if source(option) is click.core.ParameterSource.COMMANDLINE:
                raise click.UsageError(
                    f"--{option.replace('_', '-')} beside a report: the scene is that of {name}."
                )
            value = run["options"].get(option)
            if isinstance(value, list):
                value = tuple(math.inf if x == "inf" else x for x in value)
            options[option] = value
    return handed


def write_comparison(
    draft: Path,
    simulated: Path,
    modelled: dict[str, Path],
    options: dict[str, Any],
    warnings: list[str],
) -> tuple[list[Any], dict[str, Any]]:
    """Compare reports and write the result into `draft`; its rows and run.json's content."""
    from msbsdf_cli.experiments.agreement import agreement, as_table, in_one_sentence
    from msbsdf_cli.plots.agreement import draw_agreement
    from msbsdf_cli.plots.free_path import draw_free_paths
    from msbsdf_cli.plots.lobes import draw_lobe_comparison, draw_methods
    from msbsdf_cli.results.directory import read_run
    from msbsdf_cli.results.manifest import write_report

    rows, sentences = [], []
    for name, path in modelled.items():
        mine = agreement(simulated, path, name)
        target = path if options["method"] else draft
        draw_agreement(mine, target / "agreement.png")
        draw_lobe_comparison(simulated, path, target)
        if (path / "free_path.csv").exists():
            draw_free_paths(simulated, path, draft)
        rows += mine
        sentences.append(in_one_sentence(mine))
    if options["method"]:
        draw_methods(simulated, modelled, draft)
    record = read_run(simulated)
    record |= {
        "command": "compare",
        "options": options,
        "warnings": warnings + record["warnings"],
        "summary": "\n".join(sentences),
    }
    write_report(draft, record, {"agreement.csv": as_table(rows)})
    return rows, record


def show(rows: list[Any]) -> None:
    """Print what differs: how much, how much of it noise explains, how much is the model's own.

    Lobes order by order, and free paths that all escape or none, are left to agreement.csv.
    """
    from msbsdf_cli.cli.terminal import measured, show_table

    header = (
        "method",
        "quantity",
        "theta",
        "order",
        "side",
        "simulated",
        "modelled",
        "difference",
        "noise",
    )
    lines = []
    for r in rows:
        if r.quantity == "total_variation" and r.order != "all":
            continue
        if r.simulated == r.modelled and r.simulated in (0, 1):
            continue
        lines.append(
            (
                r.method,
                r.quantity,
                f"{r.theta:.4g}",
                r.order,
                r.side,
                measured(r.simulated, r.simulated_stderr),
                measured(r.modelled, r.modelled_stderr),
                f"{r.difference:.2g}",
                f"{r.noise:.1g}",
                measured(r.own, r.own_stderr),
                f"{r.z:.1f}",
            )
        )
    show_table((*header, "model's own", "z"), lines)
