"""Options at their extremes: finite numbers, or a sentence; never a traceback."""

import csv
import math
import tempfile
from pathlib import Path
from unittest.mock import patch

from command_line import msbsdf
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

EXTREMES = {
    "--alpha": ["1e-6", "1e-3", "30", "1e4", "1e308", "1,0.001", "0.001,1", "1e-300"],
    "--theta": ["0", "1e-8", "1.5707963267948966", "89.99deg", "1.5708", "-0.0"],
    "--phi": ["1e300", "-1e-300", "3.141592653589793", "360deg"],
    "--ior": ["1.000001", "0.999999", "0.333", "4", "100", "0.01", "1"],
    "--albedo": ["0", "1e-300", "1"],
    "--eta-k": ["1e-300,0", "1e4,1e4", "1,1e-5", "0,0"],
    "--material": ["conductor", "diffuse", "dielectric"],
    "--orders": ["1", "10", "11"],
    "--samples": ["1", "2", "7"],
    "--seed": ["0", "1e40", "18446744073709551616"],
    "--threads": ["1", "1e9"],
}
OF_A_MODEL = {
    "--slopes": ["beckmann", "ggx", "student-t"],
    "--gamma": ["1.5001", "1e6"],
    "--precision": ["float32", "float64"],
}
OF_A_RUN = {
    "--max-order": ["1", "1e30"],
    "--free-path-theta": ["0", "3.14159", "1e-8", "3.15"],
    "--free-path-height": ["inf", "1e300", "-1e300", "0"],
}
COMMANDS = {
    "walk": (OF_A_MODEL | OF_A_RUN | {"--heights": ["uniform"]}, {}),
    "simulate": (
        OF_A_RUN
        | {"--cells": ["4", "1e4"], "--extent": ["4", "1e4"], "--waves": ["1", "1e6", "1e12"]},
        {"--cells": "4", "--extent": "4", "--realisations": "2"},
    ),
    "evaluate": (
        OF_A_MODEL | {"--phi-o": ["1e300", "0"], "--points": ["2", "1e9"]},
        {"--points": "6", "--method": "single,walk,walk-low-variance,position-free-correlated"},
    ),
}
"""Of each command: its own extremes, and what makes it quick."""
TABLES = {"evaluate": ("slice.csv", "value_per_sr")}


@st.composite
def command(draw):
    """A command with some of its options at their extremes."""
    name = draw(st.sampled_from(sorted(COMMANDS)))
    own, quick = COMMANDS[name]
    table = EXTREMES | own
    words = {"--samples": "100", "--theta": "0.5", "--threads": "1"} | quick
    for option in draw(st.lists(st.sampled_from(sorted(table)), min_size=1, max_size=4)):
        words[option] = draw(st.sampled_from(table[option]))
    return [name, *(word for pair in words.items() for word in pair)]


SMALL = ["--samples", "100", "--theta", "0.5", "--cells", "4", "--extent", "4"]


@example(["simulate", *SMALL, "--realisations", "2", "--free-path-height", "1e300"])
@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])
@given(command())
def test_finite_numbers_or_a_sentence(words):
    # The pilot that tells how long a run takes is the longest part of such runs.
    shorter = patch("msbsdf_cli.experiments.pilot.PILOT_ORDER", 400)
    with shorter, tempfile.TemporaryDirectory() as where:
        out = Path(where) / "r"
        result = msbsdf(*words, "--quiet", "--out", out)
        assert result.returncode in (0, 1, 2), result.stderr
        if result.returncode:
            assert not out.exists()
            assert len(result.stderr.strip().splitlines()[-1]) < 200
            return
        table, column = TABLES.get(words[0], ("energy.csv", "energy"))
        with open(out / table, newline="") as file:
            for row in csv.DictReader(file):
                assert math.isfinite(float(row[column]))
