"""The command line as a user meets it, and the tables that it leaves."""

import contextlib
import csv
import inspect
import io
import subprocess
import sys
from unittest.mock import patch

from click.testing import CliRunner

from msbsdf_cli.cli import group, main

RUN = "import warnings; warnings.simplefilter('error')\nfrom msbsdf_cli.cli import main; main()"
"""Warnings of NumPy are errors: none is for the user."""

WITHOUT_PICTURES = RUN.replace(
    "; main()", "\nfrom msbsdf_cli.run import executors; executors.do_all = lambda *_: None; main()"
)
"""Where no test looks at any."""


def call_nothing(tasks, workers):
    """Pictures that could be drawn are not, but have what their functions take."""
    for task in tasks:
        inspect.signature(task.func).bind(*task.args, **task.keywords)


NO_PICTURES = {
    "msbsdf_cli.run.executors.do_all": call_nothing,
    "msbsdf_cli.plots.surface.draw_surface": lambda *arguments: None,
    "matplotlib.figure.Figure.savefig": lambda *arguments, **keywords: None,
    "msbsdf_cli.experiments.white_sphere.PIXELS": 12,
}
"""What pictures are drawn by and of, and what takes its place where no test looks at any."""


QUICKER = {
    "os.cpu_count": lambda: 1,
    "msbsdf_cli.smith.slopes._visible_cells.POLAR_BINS": 8,
    "msbsdf_cli.smith.slopes._visible_cells.AZIMUTH_BINS": 16,
}
"""One process unless a test says how many, as tests have one for each core already. Tables of
counted slopes that are made in no time: normals drawn from them are as right, and a few more of
them are rejected."""


def msbsdf(*words, pictures=False, cwd=None):
    """Run a command in this process, whose imports are done; its status, standard output and
    standard error. Only with `pictures` are there any: they take longer than most runs."""
    words = [str(word) for word in words]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.ExitStack() as during:
        patches = QUICKER if pictures else QUICKER | NO_PICTURES
        for name, instead in patches.items():
            during.enter_context(patch(name, instead))
        during.enter_context(contextlib.chdir(cwd or "."))
        during.enter_context(contextlib.redirect_stdout(out))
        during.enter_context(contextlib.redirect_stderr(err))
        during.enter_context(patch.object(sys, "argv", ["msbsdf", *words]))
        code = 0
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
