"""identities.png: every z-score against what chance would give; reciprocity.png: a histogram of
differences between both directions of light ([WJFYHY22 supp.] figure 16)."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from msbsdf_cli.plots.style import COLOURS, panels, save

BAND = 0.95
"""Share of runs in which each rank's z-score lies in the band, were the tests independent."""

SHOWN = 8.0
"""z-scores beyond are drawn at the edge."""


def draw_identities(rows: list[Any], path: Path) -> None:
    """Three panels: sorted z-scores against normal quantiles, z-scores section by section of the
    papers, and deviations without noise over their tolerance; where one fails, its name."""
    judged = [r for r in rows if r.verdict != "agreement"]
    # Where p is 1 nothing else could have come out: that is no draw from probability.
    noisy = [r for r in judged if r.z is not None and r.finding.wanted == "holds" and r.p_value < 1]
    exact = [r for r in judged if r.p_value is None]
    sections = list(dict.fromkeys(r.finding.section for r in judged))
    height = max(3.6, 0.17 * len(sections))
    figure, axes = panels(1, [3.2, 3.4, 1.9], height, (1.75, 0.6))
    _quantiles(axes[0, 0], noisy)
    _by_section(axes[0, 1], [r for r in judged if r.z is not None], sections)
    _tolerances(axes[0, 2], exact, sections)
    axes[0, 2].set_position(_beside(axes[0, 1], axes[0, 2]))
    names = {r.finding.identity for r in judged}
    figure.suptitle(f"{len(rows)} measurements of {len(names)} identities", x=0.02, ha="left")
    save(figure, path)


def _beside(left: Any, right: Any) -> tuple[float, float, float, float]:
    """The place of `right`, moved next to `left`, whose labels serve both."""
    a, b = left.get_position(), right.get_position()
    return (a.x1 + 0.1 * b.width, b.y0, b.width, b.height)


def _quantiles(axis: Any, noisy: list[Any]) -> None:
    z = np.sort(np.clip([r.z for r in noisy], -SHOWN, SHOWN))
    n, rank = z.size, np.arange(1, z.size + 1)
    wanted = stats.norm.ppf((rank - 0.5) / n)
    low, high = (
        stats.norm.ppf(stats.beta.ppf(p, rank, n + 1 - rank))
        for p in ((1 - BAND) / 2, (1 + BAND) / 2)
    )
    axis.fill_between(wanted, low, high, color="0.85", lw=0, label=f"chance, {BAND:.0%}")
    axis.plot(wanted, wanted, color="0.5", lw=0.8)
    axis.plot(wanted, z, "o", ms=2, color=COLOURS[0], label=f"{n} z-scores")
    bad = np.array([r.failed for r in sorted(noisy, key=lambda r: np.clip(r.z, -SHOWN, SHOWN))])
    if bad.any():
        axis.plot(wanted[bad], z[bad], "s", ms=4, color=COLOURS[1], label="fails")
    cut = stats.norm.isf(_level(noisy) / 2)
    for side in (-cut, cut):
        axis.axhline(side, color=COLOURS[1], lw=0.8, ls="--")
    axis.text(wanted[0], cut, "a failure beyond", va="bottom", color=COLOURS[1], fontsize=6)
    axis.set_xlabel("what chance would give")
    axis.set_ylabel("z-score of the measurement")
    axis.set_title("all of them, sorted")
    axis.legend(loc="lower right", bbox_to_anchor=(1, 0.12))


def _level(noisy: list[Any]) -> float:
    """The p-value at which measurements fail, from the verdicts: Holm's level for these."""
    from msbsdf_cli.statistics.multiple_testing import FAMILY_ERROR, holm

    return holm([r.p_value for r in noisy], FAMILY_ERROR)


def _by_section(axis: Any, rows: list[Any], sections: list[str]) -> None:
    place = {section: i for i, section in enumerate(sections)}
    kinds = {"holds": (COLOURS[0], "o"), "fails as expected": (COLOURS[2], "v")}
    for verdict in dict.fromkeys(r.verdict for r in rows):
        colour, marker = kinds.get(verdict, (COLOURS[1], "s"))
        mine = [r for r in rows if r.verdict == verdict]
        z = np.clip([r.z for r in mine], -SHOWN, SHOWN)
        y = [place[r.finding.section] for r in mine]
        axis.plot(z, y, marker, ms=2.2, color=colour, alpha=0.6)
    axis.set_xlim(-SHOWN - 0.5, SHOWN + 0.5)
    axis.axvline(0, color="0.5", lw=0.6)
    axis.set_xlabel(f"z-score (beyond {SHOWN:g} at the edge)")
    for r in (r for r in rows if r.failed):
        at = float(np.clip(r.z, -SHOWN, SHOWN)), place[r.finding.section]
        axis.annotate(r.finding.identity, at, (3, 3), textcoords="offset points", fontsize=6)
    axis.set_yticks(range(len(sections)), sections, fontsize=6)
    axis.set_ylim(len(sections), -1)
    axis.set_title("by section; triangles: fails as expected")


def _tolerances(axis: Any, rows: list[Any], sections: list[str]) -> None:
    place = {section: i for i, section in enumerate(sections)}
    for failed, colour in ((False, COLOURS[0]), (True, COLOURS[1])):
        mine = [r for r in rows if r.failed == failed]
        share = np.clip([_share_of_tolerance(r) for r in mine], 1e-4, 1e3)
        y = [place[r.finding.section] for r in mine]
        axis.plot(share, y, "o", ms=2.2, color=colour, alpha=0.6)
    axis.axvline(1, color=COLOURS[1], lw=0.8, ls="--")
    axis.set_xscale("log")
    axis.set_yticks([])
    axis.set_ylim(len(sections), -1)
    axis.set_xlabel("deviation / tolerance")
    axis.set_title("without noise")


def _share_of_tolerance(row: Any) -> float:
    apart = abs(row.finding.evidence.measured - row.finding.evidence.expected)
    return apart / row.tolerance if row.tolerance > 0 else float(apart > 0) * 10


def draw_reciprocity(rows: list[Any], path: Path) -> None:
    """Histograms of f(wi, wo) - f(wo, wi) over pairs of directions, wi the steeper one."""
    shown = [r for r in rows if r.finding.detail]
    if not shown:
        return
    figure, axes = panels(1, [2.4] * len(shown), 1.9, (0.45, 0.6))
    for axis, row in zip(axes[0], shown, strict=True):
        values, c = np.array(row.finding.detail), row.finding.configuration
        reach = np.quantile(np.abs(values), 0.98)
        axis.hist(np.clip(values, -reach, reach), 41, color=COLOURS[0], alpha=0.8)
        axis.axvline(0, color="0.4", lw=0.7)
        axis.axvline(row.finding.evidence.measured, color=COLOURS[1], lw=1, label="mean")
        axis.locator_params(axis="x", nbins=5)
        axis.set_title(f"{c.method}, {c.slopes.name}\n{row.verdict}")
        axis.set_xlabel("f(i, o) - f(o, i), orders 2 and later  [1/sr]\n(tails in the outer bars)")
    axes[0, 0].set_ylabel("pairs of directions")
    axes[0, 0].legend(loc="upper left")
    save(figure, path)
