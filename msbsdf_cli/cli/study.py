"""The study of many scenes that a command line, or a file, describes."""

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from msbsdf_cli import __version__
from msbsdf_cli.cli.measured import KINDS, Settings
from msbsdf_cli.cli.options import OF_FILE
from msbsdf_cli.cli.own_surface import OF_RANDOM
from msbsdf_cli.cli.ranges import axis, flags, given, in_file
from msbsdf_cli.experiments.sweep.files import digest_of
from msbsdf_cli.experiments.sweep.plan import Axis, Cases
from msbsdf_cli.experiments.sweep.sweep import Sweep
from msbsdf_cli.smith.slopes import OF_SURFACE

NOT_SWEPT = (
    *("out", "force", "format", "quiet", "as_json", "threads"),
    *("save_mesh", "convergence", "wavelength"),
)
"""Options of the commands that belong to a report of their own."""


@dataclass(frozen=True)
class Study:
    """What is swept, in words and as a sweep."""

    command: str
    texts: dict[str, list[str]]
    """What was typed for each option."""
    sweep: Sweep
    files: dict[str, str]
    """Digests of the surfaces that are given, by path."""

    @property
    def slug(self) -> str:
        """The study as a file name."""
        return "-".join([self.command, *(axis.name for axis in self.sweep.cases.axes)])

    def plan(self, shard: tuple[int, int] | None) -> dict[str, Any]:
        """All that tells it from other sweeps, for JSON."""
        return {
            "version": __version__,
            "command": self.command,
            "options": {n: list(t) for n, t in sorted(self.texts.items()) if n != "seed"},
            "axes": {axis.name: axis.labels for axis in self.sweep.cases.axes},
            "seeds": self.sweep.seeds,
            "shard": shard,
        } | ({"files": self.files} if self.files else {})


def study_of(command: str, words: tuple[str, ...]) -> Study:
    """The study that a command line describes. Raises click.UsageError where it describes none."""
    texts: dict[str, list[str]] = {}
    if command.endswith(".toml"):
        command, texts = in_file(Path(command))
    if command not in KINDS:
        known = ", ".join(KINDS)
        raise click.UsageError(f"{command!r} is not a command that can be swept: {known}.")
    by_flag = {flag: option for option in swept(command).values() for flag in option.opts}
    return study(command, texts | given(words, by_flag))


def swept(command: str) -> dict[str, click.Option]:
    """The options of a command that may vary, by parameter."""
    found: click.Command = import_module(f"msbsdf_cli.cli.{command}").command
    options = (p for p in found.params if isinstance(p, click.Option))
    return {str(p.name): p for p in options if p.name not in NOT_SWEPT}


def study(command: str, texts: dict[str, list[str]], seeds: tuple[int, ...] = ()) -> Study:
    """The study of texts of options by parameter, with its own seeds or `seeds`."""
    known = swept(command)
    for name in (name for name in texts if name not in known):
        raise click.UsageError(f"{name} is not an option of {command} that can vary.")
    words, texts = texts, dict(texts)
    on = flags(texts, known)
    found: click.Command = import_module(f"msbsdf_cli.cli.{command}").command
    with found.make_context(f"msbsdf {command}", []) as ctx:
        options = {name: value for name, value in ctx.params.items() if name in known}
        options |= on
        # In the command's own order, so that pieces have the same numbers however it is typed.
        axes = {
            name: axis(option, texts.get(name) or _default(option), ctx)
            for name, option in known.items()
            if name in texts or name in VARY_BY_THEMSELVES
        }
        if "surface" in texts:
            del axes["alpha"]
    options |= {name: a.values[0] for name, a in axes.items()}
    own = axes.pop("seed").values if "seed" in axes else (0,)
    del options["seed"]
    seeds = seeds or own
    names = frozenset(texts) | {name for name, wanted in on.items() if wanted}
    _check_surface(command, names, axes, seeds)
    cases = Cases(tuple(a for a in axes.values() if len(a.values) > 1))
    paths = axes["surface"].values if "surface" in axes else ()
    files = {path: digest_of(path) for path in paths}
    settings = Settings(command, options, cases, names, files)
    sweep = Sweep(cases, seeds, KINDS[command], settings, settings.notes)
    return Study(command, words, sweep, files)


def _check_surface(
    command: str, given: frozenset[str], axes: dict[str, Axis], seeds: tuple[int, ...]
) -> None:
    """Refuse options that belong to the other kind of surface. Raises click.UsageError."""
    of_file = "surface" in given
    for name in OF_RANDOM if of_file else OF_FILE:
        if name.replace("-", "_") in given:
            which = "beside --surface: a file has its own" if of_file else "without --surface"
            raise click.UsageError(f"--{name} {which}.")
    slopes = axes["slopes"].values if "slopes" in axes else ()
    if command == "walk" and (slopes == (OF_SURFACE,)) != of_file:
        raise click.UsageError("--slopes surface and --surface FILE go together.")
    for name in ("method", "memory") if of_file else ():
        if name in given:
            raise click.UsageError(f"--{name} beside --surface: it is not for surfaces of files.")
    if of_file and len(seeds) > 1:
        raise click.UsageError(
            "several seeds beside --surface: light on a given surface is of no other realisation "
            "of it."
        )


VARY_BY_THEMSELVES = ("alpha", "theta")
"""Options of which a command's default may be a list."""


def _default(option: click.Option) -> list[str]:
    default: Any = option.default
    return [default] if isinstance(default, str) else [*default]
