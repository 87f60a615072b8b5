"""Tables on the terminal."""

from collections.abc import Sequence

import click


def show_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print right-aligned columns under a header."""
    widths = [max(len(line[i]) for line in (header, *rows)) for i in range(len(header))]
    for line in (header, *rows):
        click.echo("  ".join(cell.rjust(w) for cell, w in zip(line, widths, strict=True)))


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
