"""A command's report: its place, the warnings, what run.json says, and the words at the end."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.plots import FORMAT, PAGE_OF
from msbsdf_cli.results.files import (
    Table,
    json_text,
    not_finite,
    write_csv,
    write_json,
)
from msbsdf_cli.results.manifest import manifest, now
from msbsdf_cli.results.place import Place, PlaceTakenError
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
    """The report of a command; refused where its place is taken, or is one of its `inputs`."""

    def __init__(
        self, command: str, slug: str, options: dict[str, Any], inputs: tuple[Path, ...] = ()
    ) -> None:
        super().__init__(command, options)
        out = f"reports/{command}-{slug}" if options["out"] is None else options["out"]
        try:
            self.place = Place(out, options["force"], inputs)
        except PlaceTakenError as taken:
            raise click.BadParameter(f"{taken}", param_hint="--out") from None

    @contextmanager
    def draft(self) -> Iterator[Path]:
        """A directory to write into, which becomes the report when all is written; index.html is
        made of it."""
        from msbsdf_cli.pages.page import write_page

        wanted = self.place.out
        with self.place.draft() as draft:
            with _environment({FORMAT: self.options["format"], PAGE_OF: str(draft)}):
                yield draft
            write_page(draft)
        if self.place.out != wanted:
            click.echo(
                f"Warning: {wanted} was taken while this ran; the report is in {self.place.out}.",
                err=True,
            )

    def end(self, show: Callable[[], None] = lambda: None) -> None:
        """Say what came out: as JSON; the verdict first, then what `show` prints, and where the
        report is; or not at all."""
        from msbsdf_cli.cli.terminal import say

        summary = self.record.get("summary", [])
        if self.options["as_json"]:
            click.echo(json_text(self.record | {"report": str(self.place.out)}))
        elif not self.options["quiet"]:
            say(summary if isinstance(summary, str) else "\n".join(summary))
            show()
            click.echo(f"Report: {self.place.out}")


@contextmanager
def _environment(wanted: dict[str, str]) -> Iterator[None]:
    """What pictures are to be, for processes that are started too."""
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value
