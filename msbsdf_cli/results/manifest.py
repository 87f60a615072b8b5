"""What run.json says of every run."""

import platform
import time
from collections.abc import Callable
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import click

from msbsdf_cli import __version__
from msbsdf_cli.results.directory import (
    RUN,
    Table,
    json_text,
    not_finite,
    write_csv,
    write_json,
)

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
    return manifest(command, options, started, wall_s, walks / wall_s, None, warnings)


def stopwatch() -> Callable[[], float]:
    """A function that tells the seconds since now."""
    started = time.monotonic()
    return lambda: time.monotonic() - started


def manifest(
    command: str,
    options: dict[str, Any],
    started: str,
    wall_s: float,
    rate_per_s: float,
    bounces_mean: float | None,
    warnings: list[str],
) -> dict[str, Any]:
    """The content of run.json that all commands share."""
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


def show_json(record: dict[str, Any]) -> None:
    """Print the summary as one JSON object."""
    click.echo(json_text(record))
