"""A command's report: its place, the warnings, what run.json says, and the words at the end."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.results.directory import (
    Table,
    json_text,
    new_report,
    not_finite,
    refuse_existing,
    write_csv,
    write_json,
)
from msbsdf_cli.results.manifest import manifest, now
from msbsdf_cli.results.seal import RUN


@dataclass
class Part:
    """What run.json says of a run, and the tables beside it."""

    command: str
    options: dict[str, Any]
    warnings: list[str] = field(default_factory=list)
    record: dict[str, Any] = field(default_factory=dict)
    """The content of run.json, once it is written."""

    def __post_init__(self) -> None:
        self.started, self.clock = now(), time.monotonic()

    def warn(self, sentences: list[str]) -> None:
        """Say sentences on standard error, and keep them for run.json."""
        for sentence in sentences:
            click.echo(f"Warning: {sentence}", err=True)
        self.warnings += sentences

    def write(
        self,
        draft: Path,
        tables: dict[str, Table],
        paths: int,
        bounces_mean: float | None = None,
        wall_s: float | None = None,
        more: dict[str, Any] | None = None,
    ) -> None:
        """Write run.json and tables by the names of their files; what is not finite in them is
        counted. `paths` are rays or walks; `wall_s` is the time they took, by default all of it."""
        for name, table in tables.items():
            self.warn(not_finite(name, table))
            write_csv(draft / name, table)
        took = time.monotonic() - self.clock if wall_s is None else wall_s
        figures = took, paths / took, bounces_mean
        self.record = manifest(self.command, self.options, self.started, *figures, self.warnings)
        self.record |= more or {}
        write_json(draft / RUN, self.record)


class Report(Part):
    """The report of a command; refused where its place is taken."""

    def __init__(self, command: str, slug: str, options: dict[str, Any]) -> None:
        super().__init__(command, options)
        self.out = Path(options["out"] or f"reports/{command}-{slug}")
        refuse_existing(self.out, options["force"])

    @contextmanager
    def draft(self) -> Iterator[Path]:
        """A directory to write into, which becomes the report when all is written."""
        with new_report(self.out) as draft:
            yield draft

    def end(self, show: Callable[[], None]) -> None:
        """Say what came out: as JSON, by `show` and where the report is, or not at all."""
        if self.options["as_json"]:
            click.echo(json_text(self.record | {"report": str(self.out)}))
        elif not self.options["quiet"]:
            show()
            click.echo(f"Report: {self.out}")
