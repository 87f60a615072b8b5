"""The command line in processes of its own, and the tables that it leaves."""

import csv
import subprocess
import sys

from click.testing import CliRunner

from msbsdf_cli.cli import group

RUN = "import warnings; warnings.simplefilter('error')\nfrom msbsdf_cli.cli import main; main()"
"""Warnings of NumPy are errors: none is for the user."""


def msbsdf(*words, before="", cwd=None):
    """Run a command, and a program before it; its status, standard output and standard error."""
    command = [sys.executable, "-c", f"{before}\n{RUN}", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd)


def refused(*words):
    """What a command says on standard error before it ends with status 2, in this process: nothing
    has been started yet, and no traceback is on the way."""
    result = CliRunner().invoke(group, [str(word) for word in words], catch_exceptions=False)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    return result.stderr


def table(path):
    """Rows of a CSV file, by column."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
