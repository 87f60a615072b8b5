"""The command line as a user meets it, and the tables that it leaves."""

import contextlib
import csv
import io
import subprocess
import sys
from unittest.mock import patch

from click.testing import CliRunner

from msbsdf_cli.cli import group, main

RUN = "import warnings; warnings.simplefilter('error')\nfrom msbsdf_cli.cli import main; main()"
"""Warnings of NumPy are errors: none is for the user."""


def msbsdf(*words, before="", cwd=None):
    """Run a command; its status, standard output and standard error.

    In this process, whose imports are done; with a program `before` it in one of its own.
    """
    words = [str(word) for word in words]
    if before:
        command = [sys.executable, "-c", f"{before}\n{RUN}", *words]
        return subprocess.run(command, capture_output=True, text=True, cwd=cwd)
    out, err = io.StringIO(), io.StringIO()
    here = contextlib.chdir(cwd) if cwd else contextlib.nullcontext()
    streams = contextlib.redirect_stdout(out), contextlib.redirect_stderr(err)
    with here, streams[0], streams[1], patch.object(sys, "argv", ["msbsdf", *words]):
        try:
            main()
        except SystemExit as end:
            code = end.code or 0
    return subprocess.CompletedProcess(words, code, out.getvalue(), err.getvalue())


def refused(*words):
    """What a command says on standard error before it ends with status 2."""
    result = CliRunner().invoke(group, [str(word) for word in words], catch_exceptions=False)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    return result.stderr


def table(path):
    """Rows of a CSV file, by column."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
