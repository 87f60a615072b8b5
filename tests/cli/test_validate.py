"""`msbsdf validate` as a user meets it, in processes of its own."""

import json

import pytest
from command_line import msbsdf, table

from msbsdf_cli.smith.slopes import NAMES

FEW = ["--quick", "--samples", "2e3", "--threads", "2"]

# A program whose projected areas are 1 % too large, as a user would meet it. It leaves out half of
# the configurations, and the methods, whose identities are faulty one by one elsewhere.
BENT = """
from msbsdf_cli.validation import suite
plan = suite.plan
kept = lambda job: not job.configuration.method and job.place % 2 == 1
suite.plan = lambda *words: filter(kept, plan(*words))
from msbsdf_cli.smith.slopes import Ggx
right = Ggx.sigma
Ggx.sigma = lambda self, d: 1.01 * right(self, d)
"""

# Some configurations of every identity; all of them have a step of their own in `.ci/run`.
SOME = """
from msbsdf_cli.validation import suite
plan = suite.plan
suite.plan = lambda *words: (job for job in plan(*words) if (job.number + job.place) % {} == 2)
"""

COLUMNS = [
    *("identity", "section", "material", "slopes", "alpha_x", "alpha_y", "theta_i_rad"),
    *("expected", "measured", "stderr", "tolerance", "verdict"),
]


def validate(*words, **how):
    return msbsdf("validate", *words, **how)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    out = tmp_path_factory.mktemp("validate") / "report"
    return out, validate(*FEW, "--json", "--out", out, before=SOME.format(3))


def rows(out):
    return table(out / "identities.csv")


def test_a_correct_program_holds(report):
    out, result = report
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout)
    assert found["verdicts"]["fails"] == found["verdicts"]["holds against expectation"] == 0
    assert found["failed"] == []
    assert found["family_error"] == 1e-3
    for name in ("identities.png", "reciprocity.png"):
        assert (out / name).stat().st_size > 10_000
    assert json.loads((out / "run.json").read_text())["command"] == "validate"


def test_the_table_is_what_the_contract_says(report):
    table = rows(report[0])
    assert list(table[0])[: len(COLUMNS)] == COLUMNS
    assert {row["verdict"] for row in table} == {"holds", "fails as expected", "agreement"}
    assert {row["slopes"] for row in table} == set(NAMES)
    for row in table:
        assert row["reason"]
        apart = abs(float(row["measured"]) - float(row["expected"]))
        # Chi-square statistics below their mean are no failure, however far.
        one_sided = row["reason"].startswith("chi-square")
        if row["verdict"] == "holds" and not one_sided:
            assert apart <= float(row["tolerance"])
        assert float(row["detectable"]) >= float(row["tolerance"]) * (1 - 1e-9)


def test_a_faulty_program_ends_with_status_3(tmp_path):
    out = tmp_path / "r"
    result = validate(*FEW, "--out", out, before=BENT)
    assert result.returncode == 3, result.stderr
    assert "Traceback" not in result.stderr
    failed = {row["identity"] for row in rows(out) if row["verdict"] == "fails"}
    assert {"projected area", "visible normals, normalisation"} <= failed
    assert "measurements fail" in result.stdout
    assert {row["slopes"] for row in rows(out) if row["verdict"] == "fails"} == {"ggx"}


def test_the_same_numbers_whatever_the_threads(report, tmp_path):
    """Measured in another order and company; verdicts are of all together, and may differ."""
    words = "--threads", 1, "--quiet", "--out", tmp_path / "r"
    assert validate(*FEW[:-2], *words, before=SOME.format(9)).returncode == 0
    measured = [{name: row[name] for name in COLUMNS[:10]} for row in rows(report[0])]
    some = [{name: row[name] for name in COLUMNS[:10]} for row in rows(tmp_path / "r")]
    assert 30 < len(some) < len(measured)
    assert all(row in measured for row in some)


def test_bad_input_is_refused_in_a_sentence(report, tmp_path):
    for words, said in (
        (["--samples", "0"], "0"),
        (["--samples", "1.5"], "whole"),
        (["--seed", "-1"], "-1"),
        (["--out", report[0]], "--force"),
    ):
        result = validate(*words, cwd=tmp_path)
        assert result.returncode == 2
        assert said in result.stderr
        assert "Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == []
