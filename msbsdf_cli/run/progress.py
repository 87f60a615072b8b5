"""Progress of long work."""

import sys
import time
from typing import Any

import click

EVERY_S = 30
"""Seconds between two lines, where there is no terminal to draw on."""


class Progress:
    """A line on standard error with the share done, the rate and the time left; without a terminal,
    a line now and then."""

    def __init__(self, label: str, total: float, unit: str, quiet: bool) -> None:
        self.started = self.said = time.monotonic()
        self.done = self.earlier = 0.0
        self.label, self.total, self.unit = label, total, unit
        terminal = sys.stderr.isatty()
        self.in_lines = not (quiet or terminal)
        self.bar: Any = click.progressbar(
            length=1000,
            label=label,
            file=sys.stderr,
            hidden=quiet or not terminal,
            item_show_func=lambda _: f"{self.rate:.3g} {unit}/s",
        )

    @property
    def rate(self) -> float:
        """Units done a second."""
        return (self.done - self.earlier) / max(time.monotonic() - self.started, 1e-9)

    def __enter__(self) -> "Progress":
        self.bar.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self.bar.__exit__(None, None, None)

    def skip(self, amount: float) -> None:
        """Count work as done by an earlier run."""
        self.earlier += amount
        self.advance(amount)

    def advance(self, amount: float) -> None:
        """Count work as done."""
        before = int(1000 * self.done / self.total)
        self.done += amount
        self.bar.update(int(1000 * self.done / self.total) - before, self.unit)
        if self.in_lines and time.monotonic() - self.said >= EVERY_S:
            self.said = time.monotonic()
            left = (self.total - self.done) / max(self.rate, 1e-9)
            click.echo(
                f"{self.label}: {self.done:.4g} of {self.total:.4g} {self.unit}, "
                f"{self.rate:.3g} a second, {left:.0f} s left.",
                err=True,
            )
