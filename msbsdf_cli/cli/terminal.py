"""Tables on the terminal."""

from collections.abc import Sequence

import click


def show_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print right-aligned columns under a header."""
    widths = [max(len(line[i]) for line in (header, *rows)) for i in range(len(header))]
    for line in (header, *rows):
        click.echo("  ".join(cell.rjust(w) for cell, w in zip(line, widths, strict=True)))


def measured(value: float, stderr: float) -> str:
    """A value with the digits that its standard error leaves standing: `0.4692(7)`; six where
    these would be more than anybody reads."""
    if not 5e-8 < stderr < 1:
        return f"{value:.6g}"
    digits = 0
    while round(stderr * 10**digits) < 1:
        digits += 1
    return f"{value:.{digits}f}({round(stderr * 10**digits)})"
