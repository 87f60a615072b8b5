"""Options of a sweep: lists and ranges of what a command takes one of."""

import math
import re
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.types import Angles, Count, Lengths, Numbers, Real, Roughness, quoted
from msbsdf_cli.experiments.sweep.plan import Axis

RANGE = re.compile(r"(log:)?([^:,]+):([^:,]+):(\d+)")
DEG = "deg"

MOST_IN_RANGE = 100_000

HAVE_COMMAS = Roughness, Numbers
"""Types in which a comma is within a value: several values of these are several options; so are
those of `Lengths` of more than one."""

ARE_NUMBERS = Roughness, Angles, Real, Count, click.types.IntRange


def given(words: Sequence[str], options: dict[str, click.Option]) -> dict[str, list[str]]:
    """The texts of each option in a command line without the rest, by parameter.

    `options` are those that may be given, by flag. Raises click.UsageError for others.
    """
    found: dict[str, list[str]] = {}
    rest = iter(words)
    for word in rest:
        flag, equals, text = word.partition("=")
        if flag not in options:
            what = "no such option" if word.startswith("--") else "not an option"
            raise click.UsageError(f"{quoted(flag)} is {what} of a command that is swept.")
        option = options[flag]
        if not option.is_flag and not equals:
            text = next(rest, "")
            if not text:
                raise click.UsageError(f"{flag} needs a value.")
        found.setdefault(str(option.name), []).append(text)
    return found


def in_file(path: Path) -> tuple[str, dict[str, list[str]]]:
    """The command of a TOML file, and the texts of its options by parameter.

    Raises click.UsageError with a sentence for a file that describes no sweep.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise click.UsageError(f"{path} cannot be read as TOML: {error}.") from None
    command = content.pop("command", None)
    if not isinstance(command, str):
        raise click.UsageError(f'{path} names no command; begin it with command = "walk".')
    return command, {name.replace("-", "_"): list(_texts(v)) for name, v in content.items()}


def _texts(value: Any) -> Iterator[str]:
    for item in value if isinstance(value, list) else [value]:
        yield ",".join(map(str, item)) if isinstance(item, list) else str(item)


def flags(texts: dict[str, list[str]], options: dict[str, click.Option]) -> dict[str, bool]:
    """Flags by parameter, taken out of the texts of all options: on where a command line names
    them, in a file as it says. Raises click.UsageError for what is neither true nor false."""
    found = {}
    for name in [name for name in texts if name in options and options[name].is_flag]:
        text = ",".join(texts.pop(name))
        if text not in SAID:
            raise click.UsageError(f"{name} is {quoted(text)}: true or false is wanted.")
        found[name] = SAID[text]
    return found


SAID = {"": True, "True": True, "False": False}


def axis(option: click.Option, texts: Sequence[str], ctx: click.Context) -> Axis:
    """All values that the texts of one option name.

    Raises click.BadParameter for what the command would refuse, and for a value named twice.
    """
    values: list[Any] = []
    for text in texts:
        try:
            parts = list(_parts(option, text))
        except ValueError as error:
            raise click.BadParameter(f"{error}", ctx=ctx, param=option) from None
        values += (option.type.convert(part, option, ctx) for part in parts)
    pairs = isinstance(option.type, Roughness)
    labels = tuple(_label(value, pairs) for value in values)
    seen: set[Any] = set()
    for value, label in zip(values, labels, strict=True):
        if value in seen:
            raise click.BadParameter(f"{label} is named twice.", ctx=ctx, param=option)
        seen.add(value)
    return Axis(str(option.name), tuple(values), labels)


def _parts(option: click.Option, text: str) -> Iterator[str]:
    numeric = isinstance(option.type, ARE_NUMBERS)
    pair = isinstance(option.type, Lengths) and option.type.most > 1
    for part in [text] if pair or isinstance(option.type, HAVE_COMMAS) else text.split(","):
        found = RANGE.fullmatch(part.strip()) if numeric else None
        if found is None:
            yield part.strip()
        else:
            yield from _range(part, *found.groups())


def _range(text: str, log: str | None, low: str, high: str, number: str) -> Iterator[str]:
    """`n` numbers from low to high; a unit behind the second holds for both."""
    unit = DEG if high.endswith(DEG) else ""
    if low.endswith(DEG) and not unit:
        raise ValueError(f"{quoted(text)}: the unit deg belongs behind the second number too.")
    try:
        a, b = (float(end.removesuffix(DEG)) for end in (low, high))
    except ValueError:
        raise ValueError(f"{quoted(text)} is not a range: LOW:HIGH:N, or log:LOW:HIGH:N.") from None
    n = int(number)
    if not 2 <= n <= MOST_IN_RANGE or not a < b or not math.isfinite(a) or not math.isfinite(b):
        raise ValueError(
            f"{quoted(text)} is not a range: LOW:HIGH:N, LOW below HIGH, N from 2 to "
            f"{MOST_IN_RANGE}."
        )
    if log and a <= 0:
        raise ValueError(f"{quoted(text)}: the ends of a range by factors are above 0.")
    for i in range(n):
        x = a * (b / a) ** (i / (n - 1)) if log else a + (b - a) * i / (n - 1)
        yield f"{x:.12g}{unit}"


def _label(value: Any, pairs: bool) -> float | str:
    """A value as tables have it: a number where it is one, or a pair of equal ones."""
    if isinstance(value, tuple) and (len(value) == 1 or (pairs and len(set(value)) == 1)):
        value = value[0]
    if isinstance(value, tuple):
        return ",".join(f"{x:g}" if isinstance(x, float) else str(x) for x in value)
    return value if isinstance(value, int | float) else str(value)
