"""Whether recommendations are right: `python -m tests.benchmarks.recommendations [SCENES]`.

Random surfaces of every material and slope distribution, one or two roughnesses, and tolerances.
The errors of the model that `recommend` chooses, and of all that are cheaper, are found once more
from long random walks with bins, sums and samples of their own. Prints CSV, then how often the
error of what was chosen is within its bound, and what is cheaper misses the tolerance.
"""

import math
import os
import sys
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from msbsdf_cli.experiments.recommend.candidates import COMPENSATED, Candidate
from msbsdf_cli.experiments.recommend.cases import ORDERS, scenes
from msbsdf_cli.experiments.recommend.choice import CLOSE, Recommendation, Wanted, recommend
from msbsdf_cli.experiments.recommend.light import channels
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.experiments.recommend.toml_scene import surface_of
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.run.executors import map_ordered
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.colour import albedo_difference
from surfaces.facet import Array

WALKS = 4_000_000
"""From each direction in each channel."""

ROWS, COLUMNS = 10, 20
"""Bins of a hemisphere, 9 by 18 degrees, in which a lobe's distance is defined."""

IN_BIN = 24
"""Directions along either side of a bin, in which a model's light is added up."""

SURE = 2.0
"""Standard errors."""

METALS = "gold", "copper", "aluminium"


def surface(number: int) -> tuple[SceneSurface, float]:
    """A random surface, and a tolerance."""
    rng = np.random.default_rng([1, number])
    alpha = 10 ** rng.uniform(-1.2, 0)
    material = rng.choice(["conductor", "metal", "diffuse", "dielectric"])
    entries = {"name": f"{number}", "material": "conductor" if material == "metal" else material}
    entries["slopes"] = rng.choice(["beckmann", "ggx", "student-t"])
    if entries["slopes"] == "student-t":
        entries["gamma"] = rng.uniform(2.2, 8)
    if material != "dielectric" and rng.random() < 0.25:
        # At most three to one, where `solve` takes seconds.
        entries["alpha_x"], entries["alpha_y"] = alpha, alpha * 3 ** rng.uniform(-1, 0)
    else:
        entries["alpha"] = alpha
    if material == "metal":
        entries["metal"] = rng.choice(METALS)
    elif material == "diffuse":
        entries["albedo"] = rng.uniform(0.1, 1)
    elif material == "dielectric":
        entries["ior"] = rng.uniform(1.2, 2)
    entries["theta"] = rng.uniform(0, 1.4, 2).tolist()
    made = {k: v.item() if isinstance(v, np.generic) else v for k, v in entries.items()}
    return surface_of(made), float(10 ** rng.uniform(-2.5, -1))


class Walked(NamedTuple):
    """Light of walks in two halves that know nothing of each other."""

    energy: Array
    """(halves, channels, orders + 1), all later ones together."""
    later: Array
    """Of all bounces but the first, (halves, channels, bins)."""

    @property
    def stderr(self) -> float:
        """Of a share of the light, at most."""
        return 0.5 / math.sqrt(WALKS * self.energy.mean(axis=0).sum(axis=1).min())


def walked(scene: Scene, theta: float, rng: np.random.Generator) -> Walked:
    """Long walks from one direction."""
    parts = channels(scene.material)
    energy = np.zeros((2, len(parts), ORDERS + 1))
    later = np.zeros((2, len(parts), 2 * ROWS * COLUMNS))
    for half in range(2):
        for c, material in enumerate(parts):
            wi = np.array(scene.wi(theta))
            for light in random_walk(scene.slopes, material, wi, WALKS // 2, rng, 10_000):
                n = light.w.shape[1]
                weight = np.ones(n) if light.weight is None else light.weight[0]
                energy[half, c, min(light.order, ORDERS + 1) - 1] += weight.sum()
                if light.order > 1:
                    later[half, c] += np.bincount(_bin(light.w), weight, 2 * ROWS * COLUMNS)
    return Walked(energy / (WALKS // 2), later / (WALKS // 2))


def _bin(w: Array) -> NDArray[np.intp]:
    row = np.arccos(np.clip(np.abs(w[2]), 0, 1)) / (math.pi / 2) * ROWS
    column = np.floor((np.arctan2(w[1], w[0]) / (2 * math.pi) % 1) * COLUMNS)
    flat = np.minimum(row.astype(int), ROWS - 1) * COLUMNS + column.astype(int) % COLUMNS
    return np.where(w[2] < 0, ROWS * COLUMNS + flat, flat)


def replaced(method: str, scene: Scene, theta: float) -> Array:
    """What a method has in the place of later bounces, in the same bins (channels, bins)."""
    rows = (np.arange(ROWS * IN_BIN) + 0.5) / (ROWS * IN_BIN) * math.pi / 2
    phi = (np.arange(COLUMNS * IN_BIN) + 0.5) / (COLUMNS * IN_BIN) * 2 * math.pi
    t, p = np.meshgrid(rows, phi, indexing="ij")
    w = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)]).reshape(3, -1)
    area = (np.sin(t) * (math.pi / 2 / rows.size) * (2 * math.pi / phi.size)).ravel()
    model, nothing = METHODS[method](scene.slopes, scene.material, 1), np.random.default_rng(0)
    sides = [w, w * [[1], [1], [-1]]] if scene.material.transmits else [w]
    found = np.zeros((scene.material.channels, 2 * ROWS * COLUMNS))
    for half, side in enumerate(sides):
        value = model.evaluate(np.array(scene.wi(theta)), side, 0, nothing).value[:, 1] * area
        cells = np.bincount(_bin(side), minlength=2 * ROWS * COLUMNS).astype(bool)
        assert cells[half * ROWS * COLUMNS : (half + 1) * ROWS * COLUMNS].all()
        for c, light in enumerate(value):
            found[c] += np.bincount(_bin(side), light, 2 * ROWS * COLUMNS)
    return found


def errors(candidate: Candidate, scene: Scene, theta: float, light: Walked, scale: float) -> float:
    """How far a candidate is off at one place."""
    energy = light.energy.mean(axis=0)
    total = energy.sum(axis=1)
    if candidate.method in COMPENSATED:
        added = replaced(candidate.method, scene, theta)
        model = energy[:, 0] + added.sum(axis=1)
        # What is more and what is less is told by one half, and how much by the other.
        off = added - light.later
        lobe = (np.sign(off) * off[::-1]).sum(axis=2).mean(axis=0) / 2
        found = max((np.abs(model - total) / total).max(), (lobe / total).max())
    else:
        model = total if candidate.bounces == 0 else energy[:, : candidate.bounces].sum(axis=1)
        found = (np.abs(model - total) / total).max()
    colour = float(albedo_difference(model, total)) if total.size == 3 else 0.0
    return max(float(found), scale * colour)


class Row(NamedTuple):
    """What was found of one candidate."""

    scene: int
    surface: str
    tolerance: float
    method: str
    bounces: int
    verdict: str
    error: float
    bound: float
    walked: float
    stderr: float


def judged(number: int) -> list[Row]:
    """The candidate that is chosen, and those that are cheaper."""
    one, tolerance = surface(number)
    wanted = Wanted(tolerance)
    (said,) = recommend([one], wanted, number, 1, True)
    if said.chosen is None:
        raise ValueError(f"scene {number}: {said.reason}")
    rng = np.random.default_rng([2, number])
    light = [(s, t, walked(s, t, rng)) for s in scenes(one) for t in s.theta]
    stderr = max(walks.stderr for _, _, walks in light)
    name = f"{one.material} {one.slopes[0]}".replace(",", ";")
    return [
        Row(number, name, tolerance, c.method, c.bounces, verdict, c.error, c.bound, off, stderr)
        for c, verdict in _judged(said)
        for off in [max(errors(c, *place, wanted.scale) for place in light)]
    ]


def _judged(said: Recommendation) -> list[tuple[Candidate, str]]:
    pairs = list(zip(said.candidates, said.verdicts, strict=True))
    return pairs[: said.candidates.index(said.chosen) + 1] if said.chosen else []


def main(count: int) -> None:
    print(",".join(Row._fields))
    confirmed = missing = cheaper = close = 0
    for rows in map_ordered(judged, range(count), os.cpu_count() or 1):
        for row in rows:
            print(",".join(f"{x:.3g}" if isinstance(x, float) else str(x) for x in row), flush=True)
        *others, chosen = rows
        confirmed += chosen.walked - SURE * chosen.stderr <= chosen.bound
        close += sum(row.verdict == CLOSE for row in others)
        told = [row for row in others if row.verdict != CLOSE]
        cheaper += len(told)
        missing += sum(row.walked + SURE * row.stderr > row.tolerance for row in told)
    print(
        f"The error of what was chosen is within its bound in {confirmed} of {count} scenes; what "
        f"is cheaper misses the tolerance {missing} times of {cheaper}, {close} close calls apart.",
        file=sys.stderr,
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
