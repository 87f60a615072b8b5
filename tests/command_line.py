"""The command line in processes of its own, and the tables that it leaves."""

import csv
import subprocess
import sys

RUN = "from msbsdf_cli.cli import main; main()"


def msbsdf(*words, before="", cwd=None):
    """Run a command, and a program before it; its status, standard output and standard error."""
    command = [sys.executable, "-c", before + RUN, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd)


def table(path):
    """Rows of a CSV file, by column."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
