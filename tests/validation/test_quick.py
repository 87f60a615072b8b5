"""What a quick run has the power to see: faults of one percent and of rare paths."""

from functools import cache

import pytest

from msbsdf_cli.cli.validate import QUICK_SAMPLES
from msbsdf_cli.methods import solve
from msbsdf_cli.statistics.multiple_testing import FAMILY_ERROR, judge
from msbsdf_cli.validation.solved import ROUGH
from msbsdf_cli.validation.suite import IDENTITIES, plan, run
from validation.fault_injection import (
    lambda_of_masking,
    long_free_paths,
    next_events_on_one_side,
    start_below_the_top,
)

FAMILY = 1000
"""Measurements of a quick run, or nearly: a part of them must fail at the level of them all."""

GLASS = "solved"
"""The section whose faults are of light through rough facets: what else it has would take long."""


def glass(job):
    c = job.configuration
    return c.facets.transmits and min(c.slopes.alpha) >= ROUGH


SOLUTION = cache(solve.solution)


@cache
def failing(section, fault=None):
    """What fails of a section's share in a quick run: identities and methods."""
    of_section = [i for i in IDENTITIES if i.measure.__module__.endswith(f".{section}")]
    with pytest.MonkeyPatch.context() as patch:
        # The faults of that section are of walks: what they are held against is solved once.
        patch.setattr(solve, "solution", SOLUTION)
        if fault is not None:
            fault(patch)
        jobs = (j for j in plan(QUICK_SAMPLES, 0, True, of_section) if section != GLASS or glass(j))
        findings = [f for job in jobs for f in run(job)]
    rows = judge(findings, FAMILY_ERROR * len(findings) / FAMILY)
    return {(row.finding.identity, row.finding.configuration.method) for row in rows if row.failed}


@pytest.mark.parametrize(
    ("fault", "section", "method"),
    [
        (long_free_paths, "free_paths", ""),
        (long_free_paths, "one_way", ""),
        (start_below_the_top, "one_way", ""),
        (next_events_on_one_side, "solved", "walk"),
        (next_events_on_one_side, "solved", "walk-low-variance"),
        (lambda_of_masking, "intersection", ""),
    ],
)
def test_a_quick_run_sees(fault, section, method):
    assert not failing(section)
    assert method in {of for _, of in failing(section, fault)}
