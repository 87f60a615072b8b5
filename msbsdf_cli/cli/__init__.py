"""The command `msbsdf`. Commands are imported when they are called, so that help is immediate."""

import io
import os
import signal
import sys
import threading
from importlib import import_module
from types import FrameType

import click

from msbsdf_cli import __version__

COMMANDS = {
    "simulate": "Trace light on explicit random Beckmann surfaces.",
    "walk": "Run the Smith random walk: no surface, only its statistics.",
    "compare": "Hold the model against the surfaces: free paths and lobes.",
    "evaluate": "Evaluate the BSDF along a slice of directions, by any method.",
    "validate": "The published identities, each with a figure and a verdict.",
    "furnace": "Directional albedo of every method; the white sphere.",
    "stability": "Where each method stops working, as a map.",
    "render": "A small scene shaded by any method, side by side.",
    "recommend": "The cheapest model that each surface of a scene needs.",
    "export": "Tables that renderers load: the BSDF of all bounces, and albedos.",
    "sweep": "Any of the measuring commands for many scenes, on all cores or a cluster.",
    "merge": "Put together the reports of other seeds, shares and machines.",
    "tradeoff": "Error against time for every method, on one chart.",
    "figures": "The papers' figures remade, and what they claim.",
}


class Lazy(click.Group):
    """A group that imports `msbsdf_cli.cli.NAME` only for the command that is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of a first reading."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """The command, or None."""
        if name not in COMMANDS:
            return None
        command: click.Command = import_module(f"msbsdf_cli.cli.{name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that is called; refused where one of its options is given twice, of which
        click would take the last."""
        name, command, rest = super().resolve_command(ctx, args)
        seen: set[str] = set()
        params = command.params if command is not None else []
        once = [p for p in params if isinstance(p, click.Option) and not p.multiple]
        flags = {flag: str(p.name) for p in once for flag in p.opts}
        for flag in (word.partition("=")[0] for word in rest):
            if flags.get(flag) in seen:
                raise click.UsageError(
                    f"{flag} is given twice, and `{name}` takes one; `msbsdf sweep` runs a "
                    "command for several."
                )
            seen.add(flags.get(flag, ""))
            seen.discard("")
        return name, command, rest

    def invoke(self, ctx: click.Context) -> object:
        """Run the command; Ctrl-C ends it with a sentence."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            click.echo("\nStopped: no report is written.", err=True)
            ctx.exit(1)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=Lazy, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="msbsdf")
def group() -> None:
    """Microfacet models of multiple scattering, put to the test on explicit random surfaces.

    Start with `msbsdf compare`.
    """


def main() -> None:
    """Run the command line; a failed run ends with one sentence and status 1."""
    # One process a core is the parallelism here; threads of a linear algebra library would
    # only compete with it.
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    _open_streams()
    _stop_cleanly()
    try:
        group(standalone_mode=True)
    except (OSError, MemoryError, ArithmeticError, RuntimeError) as error:
        click.echo(f"Error: the run failed: {describe(error)}", err=True)
        sys.exit(1)


def _open_streams() -> None:
    """Let what is said on a stream that the user has closed be lost, and signs that it has not."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
        if isinstance(stream := getattr(sys, name), io.TextIOWrapper):
            # A terminal without a sign for degrees is no reason to fail.
            stream.reconfigure(errors="replace")


def _stop_cleanly() -> None:
    """Make an end by another signal as clean as one by Ctrl-C."""
    if threading.current_thread() is not threading.main_thread():
        return
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        # What the caller has told to be ignored, as `nohup` does, stays so.
        defaults = signal.SIG_DFL, signal.default_int_handler
        if number is not None and signal.getsignal(number) in defaults:
            signal.signal(number, _stop)
    if sys.unraisablehook is sys.__unraisablehook__:
        sys.unraisablehook = _heed


def _heed(lost: "sys.UnraisableHookArgs") -> None:
    """Give a signal again whose exception was lost, as one is that comes while a process forks."""
    error = lost.exc_value
    code = 128 + signal.SIGINT if isinstance(error, KeyboardInterrupt) else 0
    if isinstance(error, SystemExit) and isinstance(error.code, int):
        code = error.code
    if code > 128:
        _give_again(code - 128)
    else:
        sys.__unraisablehook__(lost)


def _stop(number: int, frame: FrameType | None) -> None:
    if _importing(frame):
        # Libraries swallow what is raised while they are imported.
        _give_again(number)
        return
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    click.echo(f"Error: stopped by {signal.Signals(number).name}; no report is written.", err=True)
    sys.exit(128 + number)


def _give_again(number: int) -> None:
    """Raise a signal once more, a little later."""
    again = threading.Timer(0.05, signal.raise_signal, (number,))
    again.daemon = True
    again.start()


def _importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def describe(error: BaseException) -> str:
    """What went wrong, as a sentence."""
    if isinstance(error, MemoryError):
        return "there is not enough memory; a smaller --extent or a coarser --accuracy needs less."
    if isinstance(error, OSError) and error.filename:
        return f"{error.strerror} ({error.filename})."
    return f"{error}" or type(error).__name__
