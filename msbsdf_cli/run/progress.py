"""Progress of long work."""

import sys
import time
from typing import Any

import click

EVERY_S = 30
"""Seconds between two lines, where there is no terminal to draw on."""


class Progress:
    """A line on standard error with the share done, the rate and the time left; without a terminal,
    a line now and then, and one at the end."""

    def __init__(self, label: str, total: float, unit: str, quiet: bool) -> None:
        self.started = self.said = time.monotonic()
        self.done = self.earlier = 0.0
        self.label, self.total, self.unit = label, total, unit
        self.last = ""
        """What came back last, and how long it took, in words."""
        self.in_lines = not (quiet or sys.stderr.isatty())
        self.bar: Any = _bar() if sys.stderr.isatty() and not quiet else None

    @property
    def rate(self) -> float:
        """Units done a second."""
        return (self.done - self.earlier) / max(time.monotonic() - self.started, 1e-9)

    def __enter__(self) -> "Progress":
        if self.bar is not None:
            self.bar.start()
            self.task = self.bar.add_task(self.label, total=self.total, rate="")
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if self.bar is not None:
            self._draw()
            self.bar.stop()
        elif self.in_lines and kind is None:
            took = time.monotonic() - self.started
            click.echo(f"{self.label}: {self.done:.4g} {self.unit} in {took:.3g} s.", err=True)

    def skip(self, amount: float) -> None:
        """Count work as done by an earlier run."""
        self.earlier += amount
        self.advance(amount)

    def advance(self, amount: float, last: str = "") -> None:
        """Count work as done; `last` says what it was."""
        self.done += amount
        self.last = f"; last {last}" if last else ""
        wait = DRAWN_S if self.bar is not None else EVERY_S
        if time.monotonic() - self.said < wait:
            return
        self.said = time.monotonic()
        if self.bar is not None:
            self._draw()
        elif self.in_lines:
            left = (self.total - self.done) / max(self.rate, 1e-9)
            click.echo(
                f"{self.label}: {self.done:.4g} of {self.total:.4g} {self.unit}, "
                f"{self.rate:.3g} a second, {left:.0f} s left{self.last}.",
                err=True,
            )

    def _draw(self) -> None:
        rate = f"{self.rate:.3g} {self.unit}/s{self.last}"
        self.bar.update(self.task, completed=self.done, rate=rate, refresh=True)


DRAWN_S = 0.1
"""Seconds between two drawings of a bar."""


def _bar() -> Any:
    """A bar that no thread draws: processes are started while it is there."""
    from rich import progress
    from rich.console import Console

    return progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.TaskProgressColumn(),
        progress.TimeRemainingColumn(),
        progress.TextColumn("{task.fields[rate]}"),
        console=Console(stderr=True),
        auto_refresh=False,
        redirect_stdout=False,
        redirect_stderr=False,
    )
