"""A report's directory: written whole or not at all, never over somebody's files."""

import csv
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.results.seal import RUN, seal

Table = Mapping[str, Sequence[Any]]
"""Columns by name, all of one length."""


def refuse_existing(out: Path, force: bool) -> None:
    """Refuse a directory that holds a report, unless forced, or anything else, even then.

    Raises click.BadParameter.
    """
    if out.exists() and not out.is_dir():
        raise click.BadParameter(f"{out} is a file; name a directory.", param_hint="--out")
    if not out.is_dir() or not any(out.iterdir()):
        return
    if not (out / RUN).is_file():
        raise click.BadParameter(
            f"{out} holds files that are not a report; name another directory.",
            param_hint="--out",
        )
    if not force:
        raise click.BadParameter(
            f"{out} already holds a report; name another directory, or replace it with --force.",
            param_hint="--out",
        )


@contextmanager
def new_report(out: Path) -> Iterator[Path]:
    """A directory to write into, which becomes `out` when all is written, and vanishes otherwise.

    A report that it replaces goes only then, and files in it that no report wrote are kept.
    """
    out.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    try:
        yield draft
        draft.chmod(0o755)
        seal(draft)
        if out.is_dir():
            _replace(out, draft)
        else:
            os.rename(draft, out)
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        raise


def _replace(out: Path, draft: Path) -> None:
    old = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent)) / "old"
    os.rename(out, old)
    os.rename(draft, out)
    try:
        known = set(json.loads((old / RUN).read_text()).get("files", []))
    except (OSError, ValueError):
        known = set()
    for path in [p for p in old.rglob("*") if p.is_file()]:
        name = path.relative_to(old)
        if str(name) not in known and not (out / name).exists():
            (out / name).parent.mkdir(parents=True, exist_ok=True)
            os.rename(path, out / name)
    shutil.rmtree(old.parent)


def columns(rows: Iterable[Any], names: Iterable[str]) -> Table:
    """Attributes of rows as columns; where a row has not a number, it does not apply: no text."""
    picked = {name: [getattr(row, name) for row in rows] for name in names}
    return {name: ["" if x != x else x for x in column] for name, column in picked.items()}


def write_csv(path: Path, table: Table) -> None:
    """Write columns under a header line; floats as their shortest exact text."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table)
        writer.writerows(zip(*table.values(), strict=True))


INFINITE = {
    "free_path.csv": {"height_start", "height_low", "height_high"},
    "reach.csv": {"seconds", "seconds_after_setup", "gain", "gain_stderr", "gain_after_setup"},
}
"""Columns in which infinity is a value: rays from outside, an error that is never reached."""


def not_finite(name: str, table: Table) -> list[str]:
    """Sentences that count the values of the file `name` that are not finite, by column."""
    sentences = []
    for column in (c for c in table if c not in INFINITE.get(name, ())):
        bad = sum(isinstance(x, float) and not math.isfinite(x) for x in table[column])
        if bad:
            of = f"{bad} of {len(table[column])}"
            sentences.append(f"{name}: {of} values in the column {column} are not finite.")
    return sentences


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a JSON object."""
    path.write_text(json_text(content, indent=1) + "\n", encoding="utf-8")


def json_text(content: dict[str, Any], indent: int | None = None) -> str:
    """JSON, which has no word for what is not finite: `inf` and `nan` become strings."""
    return json.dumps(_finite(content), indent=indent, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
