"""`msbsdf walk`"""

from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.options import FREE_PATH, MODEL, REPORT, samples, use


@click.command("walk")
@use(*MODEL, "orders")
@samples("4e6")
@use("max-order", *FREE_PATH, "seed", "threads", "precision", *REPORT)
def command(**options: Any) -> None:
    """Run the Smith random walk: no surface, only its statistics.

    Writes energies per order, moments, lobes and free paths, with standard errors.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.results.directory import new_report
    from msbsdf_cli.results.manifest import show_end, show_json, show_run

    scene = common.scene_from(options)
    common.free_paths_from(options, options["heights"])
    out = common.out_directory("walk", scene.slug(), options)
    warnings = common.scene_warnings(options, work_s(options))
    common.announce(warnings)
    with new_report(out) as draft:
        outcome, record = run(draft, scene, options, warnings)
    if options["as_json"]:
        show_json(record | {"report": str(out)})
    elif not options["quiet"]:
        show_run(scene, outcome)
        show_end(out, record, "walks")


def work_s(options: dict[str, Any]) -> float:
    """About how many seconds one core will need."""
    from msbsdf_cli.cli.common import WALKS_PER_S

    return float(options["samples"] * len(options["theta"]) / WALKS_PER_S)


def run(
    draft: Path, scene: Any, options: dict[str, Any], warnings: list[str]
) -> tuple[Any, dict[str, Any]]:
    """Walk, and write the report into `draft`; the outcome and the content of run.json."""
    from msbsdf_cli.cli.common import free_paths_from
    from msbsdf_cli.experiments.walks import walk
    from msbsdf_cli.results.manifest import now, write_run

    started = now()
    outcome = walk(
        scene,
        options["samples"],
        free_paths_from(options, options["heights"]),
        options["heights"],
        options["seed"],
        options["threads"],
        options["precision"],
        options["max_order"],
        options["quiet"],
    )
    return outcome, write_run(draft, "walk", options, started, scene, outcome, warnings)
