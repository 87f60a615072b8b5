"""What `msbsdf recommend` says of each surface."""

import math
from typing import Any


def sentence(found: Any, wanted: Any) -> str:
    """What a surface needs, in words."""
    name, chosen = found.surface.name, found.chosen
    if chosen is None:
        return f"{name} is not judged: {found.reason}."
    pairs = list(zip(found.candidates, found.verdicts, strict=True))
    text = f"{name} ({roughness(found.surface)}): "
    if ("nearest" in found.verdicts) and chosen.bound > wanted.tolerance:
        return text + beyond(found, wanted)
    text += model(chosen) + (" is enough" if chosen.bounces == 1 else "")
    if chosen.error > 0:
        # Where single scattering's bound was enough, nothing else was worked out.
        most = "at most " if found.bound_only else ""
        text += f", {most}{off(chosen)}"
    close = [model(c) for c, verdict in pairs if verdict == "close"]
    return text + (f"; too close to call: {', '.join(close)}." if close else ".")


def picture_sentence(found: list[Any]) -> str:
    """How far off the pictures of a scene are."""
    each = (f"{percent(p.error)} (at most {percent(p.error_bound)}) by {p.method}" for p in found)
    return f"The picture of {found[0].surface} is off by {', '.join(each)}, root mean square."


def beyond(found: Any, wanted: Any) -> str:
    """Why nothing is known to be within the tolerance, and what comes as near as anything."""
    chosen = found.chosen
    smith = [c for c in found.candidates if c.bounces or c.follows_all]
    nearest = min(smith, key=lambda c: c.error)
    near = f"{model(chosen)} {'comes' if chosen.bounces in (0, 1) else 'come'} as near as anything"
    near += f", {off(chosen)}"
    if min(c.least for c in smith) > wanted.tolerance:
        return (
            f"no number of bounces of the Smith model gets below {percent(nearest.error)}: the "
            f"model itself is off by that from traced surfaces; {near}."
        )
    return (
        f"nothing is known to be within {percent(wanted.tolerance)}: the Smith model itself is "
        f"off from traced surfaces by {percent(nearest.error)}, or up to "
        f"{percent(nearest.bound)}, which more --samples tell; {near}."
    )


def off(candidate: Any) -> str:
    """How far a candidate is off, and where; the colour difference where there is a colour."""
    where = f" at {math.degrees(candidate.place.theta):.0f} degrees"
    if candidate.place.alpha[0] != candidate.place.alpha[1]:
        where += f" and azimuth {math.degrees(candidate.place.phi):.0f}"
    colour = candidate.colour
    return (
        percent(candidate.error)
        + where
        + (f", colour difference {colour:.2g}" if colour == colour else "")
    )


def model(candidate: Any) -> str:
    """A candidate in words."""
    if candidate.bounces == 1:
        return "single scattering"
    if candidate.method in ("turquin", "energy-compensated"):
        return f"{candidate.method}"
    if candidate.bounces == 0:
        return f"all bounces of {candidate.method}"
    return f"{candidate.bounces} bounces of {candidate.method}"


def roughness(surface: Any) -> str:
    """Alpha, and what renderers that square it call roughness."""
    ends = surface.slopes[0], surface.slopes[-1]
    pairs = dict.fromkeys((s.alpha_x, s.alpha_y) for s in ends)
    alphas = list(dict.fromkeys(a for pair in pairs for a in pair))
    joined = " to " if len(pairs) > 1 else ", "
    perceptual = joined.join(f"{math.sqrt(a):.3g}" for a in alphas)
    return f"alpha {joined.join(f'{a:.3g}' for a in alphas)}, perceptual {perceptual}"


def percent(share: float) -> str:
    """A share in percent, to two digits."""
    return f"{100 * share:.2g} %"
