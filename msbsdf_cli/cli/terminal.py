"""Sentences and tables on the terminal, no wider and no longer than it is."""

import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence

import click

WIDTH, LINES = 100, 30
"""Of a page, where there is no terminal; a table is never wider there."""

AROUND = 10
"""Lines of a screen that are left to the command, the sentences and what stands under a table."""

PROSE = 40
"""Characters from which a text is wrapped in its column; numbers never are."""


def screen() -> tuple[int, int]:
    """Columns and lines that there is room for."""
    columns, lines = shutil.get_terminal_size((WIDTH, LINES))
    return (columns, lines) if sys.stdout.isatty() else (min(columns, WIDTH), LINES)


def say(text: str) -> None:
    """Print sentences, one a line; on a terminal they are broken between words."""
    for line in text.splitlines():
        if sys.stdout.isatty():
            # A number stays with what it is of.
            kept = line.replace(" %", "\N{NO-BREAK SPACE}%")
            broken = textwrap.wrap(kept, screen()[0], break_on_hyphens=False)
            line = "\n".join(broken).replace("\N{NO-BREAK SPACE}", " ")
        click.echo(line)


def show_table(
    header: Sequence[str], rows: Sequence[Sequence[str]], file: str, total: int | None = None
) -> None:
    """Print the first rows that a screen has room for, and the first columns that a line has; what
    is left out is in `file`, which has `total` rows, by default those given."""
    # Not above: it takes as long as all of `--help`.
    from rich.console import Console
    from rich.table import Table

    width, lines = screen()
    shown = rows[: max(lines - AROUND, 5)]
    count = _that_fit(header, shown, width)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    for i, name in enumerate(header[:count]):
        prose = _is_prose(row[i] for row in shown)
        table.add_column(name, justify="left" if prose else "right", no_wrap=not prose)
    for row in shown:
        table.add_row(*row[:count])
    console = Console(file=sys.stdout, width=width, markup=False, highlight=False, emoji=False)
    console.print(table)
    left = (len(rows) if total is None else total) - len(shown)
    cut = ", ".join(header[count:])
    if left > 0:
        click.echo(f"{left} more in {file}{cut and f', with {cut}'}.")
    elif cut:
        click.echo(f"Also in {file}: {cut}.")


def _is_prose(cells: Iterable[str]) -> bool:
    """Whether any of the cells is in words."""
    return any(cell[:1].isalpha() and cell not in ("inf", "nan") for cell in cells)


def _that_fit(header: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> int:
    """How many of the first columns fit into a line."""
    left = width + 2
    for i, name in enumerate(header):
        cells = [row[i] for row in rows]
        need = max(map(len, [name, *cells]), default=0)
        left -= 2 + (min(need, PROSE) if _is_prose(cells) else need)
        if left < 0:
            return max(i, 1)
    return len(header)


def measured(value: float, stderr: float) -> str:
    """A value with the digits that its standard error leaves standing: `0.4692(7)`, `1002(34)`; six
    where these would be more than anybody reads, or nothing is known of the error."""
    if not stderr > 5e-8:
        return f"{value:.6g}"
    if stderr == float("inf"):
        return f"{value:.6g}(inf)"
    digits = 0
    while round(stderr * 10**digits) < 1:
        digits += 1
    return f"{value:.{digits}f}({round(stderr * 10**digits)})"


def in_percent(value: float, stderr: float) -> str:
    """A share in percent, with its error likewise, `46.92(4) %`, unless that is below what anybody
    reads of one: `46.9 %`."""
    if 100 * stderr < 0.0005 * max(100 * abs(value), 1):
        return f"{round(100 * value, 4):.3g} %"
    return f"{measured(100 * value, 100 * stderr)} %"
