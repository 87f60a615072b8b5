"""How long each method takes to a wanted error: what one reads off the chart, as a table."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.tradeoff.rows import Row
from msbsdf_cli.scene import in_degrees

ERRORS = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Relative errors asked for."""

SIGNIFICANT = 3
"""Standard errors beyond which a bias counts as one."""


@dataclass(frozen=True)
class TimeToAccuracy:
    """Seconds a method needs for a relative error at one angle of incidence."""

    method: str
    alpha_x: float
    alpha_y: float
    theta_i_rad: float
    relative_rmse: float
    seconds: float
    """Of one lobe, set-up included; infinite where the method does not get there."""
    seconds_after_setup: float
    gain: float
    """Seconds of `walk` over these."""
    gain_stderr: float
    """From the noise of the errors; times are medians of many."""
    gain_after_setup: float
    best: bool
    """Nobody is faster, set-up included."""


def seconds_to(rows: list[Row], error: float) -> tuple[float, float]:
    """Seconds to a relative error with and without set-up, from the rows of a method at one angle.

    A method without noise takes its cheapest setting that is good enough. Of another one the
    dearest setting tells noise and bias; noise falls with the root of the time from there, and no
    run is shorter than the shortest measured.
    """
    if rows[0].samples == 0:
        enough = [r for r in rows if r.relative_rmse <= error]
        if not enough:
            return float("inf"), float("inf")
        total = min(r.seconds + r.setup_s for r in enough)
        return total, min(r.seconds for r in enough)
    last = max(rows, key=lambda r: r.samples)
    bias = largest_bias(last)
    if bias >= error:
        return float("inf"), float("inf")
    needed = last.seconds * last.noise**2 / (error**2 - bias**2)
    seconds = max(needed, min(r.seconds for r in rows))
    return seconds + last.setup_s, seconds


def largest_bias(row: Row) -> float:
    """The bias to reckon with: of another model than Smith's up to two standard errors more than
    was seen, of that model itself only one that is significant."""
    if row.model == "smith":
        return row.bias if row.bias_z > SIGNIFICANT else 0.0
    spread = 2 if row.bias > 0 else np.sqrt(2)
    return float(row.bias + spread * row.bias_stderr)


def uncertainty(rows: list[Row]) -> float:
    """Relative standard error of the seconds to an error: that of the squared noise."""
    last = max(rows, key=lambda r: r.samples)
    return 2 * last.noise_stderr / last.noise if last.noise > 0 else 0.0


def times_to_accuracy(rows: list[Row], errors: tuple[float, ...] = ERRORS) -> list[TimeToAccuracy]:
    """For every method of the Smith model's chart, scene, angle and wanted error."""
    groups: dict[tuple[float, float, float], dict[str, list[Row]]] = {}
    for r in rows:
        if r.reference == "smith":
            here = groups.setdefault((r.alpha_x, r.alpha_y, r.theta_i_rad), {})
            here.setdefault(r.method, []).append(r)
    found = []
    for place, methods in groups.items():
        uncertain = {name: uncertainty(mine) for name, mine in methods.items()}
        for error in errors:
            times = {name: seconds_to(mine, error) for name, mine in methods.items()}
            walk = times.get("walk", (float("nan"), float("nan")))
            fastest = min(t for t, _ in times.values())
            found += [
                TimeToAccuracy(
                    name,
                    *place,
                    error,
                    total,
                    marginal,
                    walk[0] / total,
                    walk[0] / total * np.hypot(uncertain.get("walk", np.nan), uncertain[name]),
                    walk[1] / marginal,
                    total == fastest < float("inf"),
                )
                for name, (total, marginal) in times.items()
            ]
    return found


def sentences(found: list[TimeToAccuracy]) -> list[str]:
    """Which method to take for how much error, and where it gains ten times over the walk."""
    said = []
    for error in dict.fromkeys(r.relative_rmse for r in found):
        winners = [r for r in found if r.relative_rmse == error and r.best]
        names = dict.fromkeys(r.method for r in winners)
        parts = []
        for name in names:
            angles = [in_degrees(r.theta_i_rad) for r in winners if r.method == name]
            gains = _range([r.gain for r in winners if r.method == name])
            parts.append(f"{name} at theta {', '.join(angles)} ({gains})")
        said.append(f"Fastest to {error:.1%}, and speed over walk: " + "; ".join(parts) + ".")
    return said


def tenfold(found: list[TimeToAccuracy], names: tuple[str, ...] = ("exact", "solve")) -> list[str]:
    """Where these methods are ten times as efficient as the walk, and where they lose to it."""
    if not any(r.method == "walk" for r in found):
        return []
    said = []
    for name in (n for n in names if any(r.method == n for r in found)):
        mine = [r for r in found if r.method == name]
        wins, losses = ([r for r in mine if r.gain >= 10], [r for r in mine if r.gain < 1])
        said.append(f"{name} gains tenfold over walk {_places(wins)}; loses {_places(losses)}.")
    return said


def _places(found: list[TimeToAccuracy]) -> str:
    """`at theta 0, 1 to 1.0% (12 to 30x)`, for each error; or `nowhere here`."""
    parts = []
    for error in dict.fromkeys(r.relative_rmse for r in found):
        mine = [r for r in found if r.relative_rmse == error]
        angles = ", ".join(in_degrees(r.theta_i_rad) for r in mine)
        parts.append(f"to {error:.1%} at theta {angles} ({_range([r.gain for r in mine])})")
    return "; ".join(parts) or "nowhere here"


def _range(gains: list[float]) -> str:
    low, high = times(min(gains)), times(max(gains))
    return low if low == high else f"{low.removesuffix('x')} to {high}"


def times(gain: float) -> str:
    """A ratio of speeds to two digits, or to the unit: `1.4x`, `140x`."""
    return f"{gain:.0f}x" if gain >= 10 else f"{gain:.2g}x"
