"""Tables and JSON as files."""

import csv
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

Table = Mapping[str, Sequence[Any]]
"""Columns by name, all of one length."""


def from_rows(names: Sequence[str], rows: Iterable[Sequence[Any]]) -> Table:
    """Columns by name from rows, which may be none."""
    columns = list(zip(*rows, strict=True)) or [()] * len(names)
    return {name: list(column) for name, column in zip(names, columns, strict=True)}


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


def read_csv(path: Path) -> Table:
    """Columns of a table that `write_csv` wrote: numbers where all of their cells are."""
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {name: _numbers(column) for name, column in from_rows(header, rows).items()}


def _numbers(column: Sequence[str]) -> Sequence[Any]:
    try:
        return [float(x) for x in column]
    except ValueError:
        return column


INFINITE = {
    "free_path.csv": {"height_start", "height_low", "height_high"},
    "heitz_8.csv": {"height_low", "height_high"},
    "heitz_14.csv": {"height_start", "height_low", "height_high"},
    "heitz_10.csv": {"height"},
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
