"""What the verdicts come to: columns for a file, lines for a terminal, one sentence."""

from collections import Counter
from statistics import median
from typing import Any

from msbsdf_cli.cli.terminal import measured
from msbsdf_cli.results.files import Table, from_rows
from msbsdf_cli.scene import in_degrees
from msbsdf_cli.statistics.multiple_testing import (
    AGREEMENT,
    FAILS,
    FAILS_AS_EXPECTED,
    FAMILY_ERROR,
    HOLDS,
    HOLDS_UNEXPECTEDLY,
    Judged,
)

VERDICTS = (HOLDS, FAILS, FAILS_AS_EXPECTED, HOLDS_UNEXPECTEDLY, AGREEMENT)

NOT_JUDGED = "the model is an approximation here, and its difference is not judged; noise alone: "


def identities(rows: list[Judged]) -> Table:
    """identities.csv"""
    entries = [_entry(row) for row in rows]
    return {name: [entry[name] for entry in entries] for name in entries[0]}


def _entry(row: Judged) -> dict[str, Any]:
    finding, c, evidence = row.finding, row.finding.configuration, row.finding.evidence
    wo = c.wo or ("", "")
    reason = NOT_JUDGED + evidence.reason if row.verdict == AGREEMENT else evidence.reason
    return {
        "identity": finding.identity,
        "section": finding.section,
        "material": "" if c.material is None else c.material.name,
        "slopes": c.slopes.name,
        "alpha_x": c.slopes.alpha[0],
        "alpha_y": c.slopes.alpha[1],
        "theta_i_rad": c.wi[0],
        "expected": evidence.expected,
        "measured": evidence.measured,
        "stderr": evidence.stderr,
        "tolerance": row.tolerance,
        "verdict": row.verdict,
        "z": "" if row.z is None else row.z,
        "p_value": "" if row.p_value is None else row.p_value,
        "detectable": row.detectable,
        "reason": reason,
        "method": c.method,
        "heights": c.heights,
        "phi_i_rad": c.wi[1],
        "theta_o_rad": wo[0],
        "phi_o_rad": wo[1],
        "configuration": c.drawn,
    }


def differences(rows: list[Judged]) -> Table:
    """reciprocity.csv: differences behind the histogram of [WJFYHY22 supp.] figure 16."""
    where = ((row.finding.configuration, row.finding.detail) for row in rows)
    entries = (
        (c.method, c.slopes.name, pair, value)
        for c, detail in where
        for pair, value in enumerate(detail)
    )
    return from_rows(("method", "slopes", "pair", "difference"), entries)


def counts(rows: list[Judged]) -> dict[str, int]:
    """How many rows have each verdict."""
    found = Counter(row.verdict for row in rows)
    return {verdict: found[verdict] for verdict in VERDICTS}


def summary(rows: list[Judged]) -> str:
    """The run in one sentence or two."""
    found = counts(rows)
    bad = found[FAILS] + found[HOLDS_UNEXPECTEDLY]
    names = {row.finding.identity for row in rows}
    noisy = sum(row.p_value is not None and row.finding.wanted == HOLDS for row in rows)
    outcome = "All identities hold" if not bad else f"{bad} of {len(rows)} measurements fail"
    return (
        f"{outcome}: {len(names)} identities, {len(rows)} measurements. The {noisy} that are "
        f"subject to chance are judged together by Holm's procedure; a correct program fails one "
        f"run in {1 / FAMILY_ERROR:.0f}."
    )


HEADER = ("identity", "verdict", "largest |z|", "of tolerance", "detectable", "rows", "section")


def lines(rows: list[Judged]) -> list[tuple[str, ...]]:
    """One line for each identity: its worst row, and the error that half of its rows would have
    found."""
    groups: dict[tuple[str, str], list[Judged]] = {}
    for row in rows:
        groups.setdefault((row.finding.identity, row.finding.section), []).append(row)
    found = [_line(name, section, group) for (name, section), group in groups.items()]
    return sorted(found, key=lambda line: WORST_FIRST.index(line[1]))


WORST_FIRST = (FAILS, HOLDS_UNEXPECTEDLY, FAILS_AS_EXPECTED, AGREEMENT, HOLDS)
"""So that one failure among many rows is not overlooked."""


def _line(name: str, section: str, group: list[Judged]) -> tuple[str, ...]:
    scores = [abs(row.z) for row in group if row.z is not None]
    shares = [
        abs(row.finding.evidence.measured - row.finding.evidence.expected) / row.tolerance
        for row in group
        if row.tolerance > 0
    ]
    verdicts = Counter(row.verdict for row in group)
    return (
        name,
        next(verdict for verdict in WORST_FIRST if verdicts[verdict]),
        f"{max(scores):.1f}" if scores else "",
        f"{max(shares):.2g}" if shares else "",
        f"{median(row.detectable for row in group):.1g}",
        str(len(group)),
        section,
    )


FAILURE_HEADER = (
    "failure",
    "method",
    "material",
    "slopes",
    "alpha",
    "theta_i",
    "expected",
    "measured",
    "tolerance",
)


def failures(rows: list[Judged]) -> list[tuple[str, ...]]:
    """One line for each row that fails."""
    out: list[tuple[str, ...]] = []
    for row in rows:
        if not row.failed:
            continue
        c, evidence = row.finding.configuration, row.finding.evidence
        out.append(
            (
                row.finding.identity,
                c.method,
                "" if c.material is None else c.material.name,
                c.slopes.name,
                ",".join(f"{a:.3g}" for a in c.slopes.alpha),
                in_degrees(c.wi[0]),
                f"{evidence.expected:.6g}",
                measured(evidence.measured, evidence.stderr),
                f"{row.tolerance:.2g}",
            )
        )
    return out
