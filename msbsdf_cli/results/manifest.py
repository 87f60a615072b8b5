"""Turning a run's outcome into a report and a summary."""

import platform
import time
from collections.abc import Callable
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import click

from msbsdf_cli import __version__
from msbsdf_cli.cli.terminal import measured, show_table
from msbsdf_cli.results.directory import (
    RUN,
    Table,
    json_text,
    not_finite,
    write_csv,
    write_json,
)
from msbsdf_cli.results.run import Outcome
from msbsdf_cli.results.tables import all_tables, order_names
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.tally import SIDES

PACKAGES = ("numpy", "scipy", "embreex", "trimesh", "click", "matplotlib")


def now() -> str:
    """The time, UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def methods_record(
    command: str,
    options: dict[str, Any],
    started: str,
    wall_s: float,
    walks: int,
    warnings: list[str],
) -> dict[str, Any]:
    """The content of run.json of a run of methods, whose facets are not counted."""
    return _record(command, options, started, wall_s, walks / wall_s, None, warnings)


def stopwatch() -> Callable[[], float]:
    """A function that tells the seconds since now."""
    started = time.monotonic()
    return lambda: time.monotonic() - started


def _record(
    command: str,
    options: dict[str, Any],
    started: str,
    wall_s: float,
    rate_per_s: float,
    bounces_mean: float | None,
    warnings: list[str],
) -> dict[str, Any]:
    versions = {"msbsdf": __version__, "python": platform.python_version()}
    return {
        "command": command,
        "options": options,
        "seed": options["seed"],
        "versions": versions | {name: version(name) for name in PACKAGES},
        "started": started,
        "wall_s": wall_s,
        "rate_per_s": rate_per_s,
        "bounces_mean": bounces_mean,
        "warnings": warnings,
    }


def summary(scene: Scene, outcome: Outcome) -> list[dict[str, Any]]:
    """Energies in total, one entry for each incident angle."""
    entries = []
    for theta, tally in zip(scene.theta, outcome.tallies, strict=True):
        side = tally.estimate("side")
        entry: dict[str, Any] = {"theta_i_rad": theta, "phi_i_rad": scene.phi}
        for i, name in enumerate(SIDES[: 1 + scene.material.transmits]):
            entry[name] = float(side.value[i])
            entry[f"{name}_stderr"] = float(side.stderr[i])
        for name in ("absorbed", "unresolved"):
            entry[name] = float(tally.estimate(name).value)
        entries.append(entry)
    return entries


def write_run(
    draft: Path,
    command: str,
    options: dict[str, Any],
    started: str,
    scene: Scene,
    outcome: Outcome,
    warnings: list[str],
) -> dict[str, Any]:
    """Write what the reports of both producers hold; the content of run.json."""
    from msbsdf_cli.plots.free_path import draw_free_paths
    from msbsdf_cli.plots.lobes import draw_lobes

    rates = outcome.wall_s, outcome.paths / outcome.wall_s, outcome.bounces_mean
    record = _record(command, options, started, *rates, warnings)
    record |= {"energies": summary(scene, outcome), **outcome.notes}
    write_report(draft, record, all_tables(scene, outcome))
    draw_lobes(draft)
    draw_free_paths(draft)
    return record


def write_report(draft: Path, record: dict[str, Any], tables: dict[str, Table]) -> None:
    """Write run.json, and tables by the names of their files; count what is not finite in them,
    on standard error and in the warnings."""
    found = [sentence for name, table in tables.items() for sentence in not_finite(name, table)]
    for sentence in found:
        click.echo(f"Warning: {sentence}", err=True)
    record["warnings"] = [*record.get("warnings", ()), *found]
    write_json(draft / RUN, record)
    for name, table in tables.items():
        write_csv(draft / name, table)


def show_run(scene: Scene, outcome: Outcome) -> None:
    """Print energies per order and side, with standard errors in the last digits."""
    sides = SIDES[: 1 + scene.material.transmits]
    prefixes = [""] if len(sides) == 1 else ["R ", "T "]
    names = [f"{p}{o}" for p in prefixes for o in order_names(scene.orders)]
    rows = []
    for theta, tally in zip(scene.theta, outcome.tallies, strict=True):
        energy = tally.estimate("energy")
        cells = [
            measured(energy.value[row, column], energy.stderr[row, column])
            for column in range(len(sides))
            for row in range(scene.orders + 1)
        ]
        rest = [measured(float(e.value), float(e.stderr)) for e in map(tally.estimate, REST)]
        rows.append([f"{theta:.4g}", *cells, *rest])
    show_table(["theta", *names, *REST], rows)


REST = ("absorbed", "unresolved")


def show_end(out: Path, record: dict[str, Any], unit: str) -> None:
    """Print how the run went and where its report is."""
    click.echo(
        f"{record['rate_per_s']:.3g} {unit} a second for {record['wall_s']:.1f} s, "
        f"{record['bounces_mean']:.3f} facets each. Report: {out}"
    )


def show_json(record: dict[str, Any]) -> None:
    """Print the summary as one JSON object."""
    click.echo(json_text(record))
