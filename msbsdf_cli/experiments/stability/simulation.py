"""The map of the simulation: what each of its settings does to the energies, and where the
automatic choice lies."""

import math
from collections.abc import Iterable, Iterator

from msbsdf_cli.experiments.convergence import EXTENT, HITS, LIFTS, Steps, convergence
from msbsdf_cli.experiments.resolution import plan
from msbsdf_cli.experiments.stability import verdicts
from msbsdf_cli.experiments.stability.study import Row
from msbsdf_cli.results.files import Table
from msbsdf_cli.run.executors import Workers
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.materials import Conductor

METHOD = "surfaces"
SCENE = Scene(Conductor(), Beckmann(1.0, 1.0), (1.0,), 0.0, 3)
RAYS, RAYS_OF_DRAFT = 500_000, 100_000
WAVES = (1, 2, 4, 10, 30, 100, None)
DRAFT = Steps((4, 8, 16), (2, 4, 16), (1, 4, 10, None), surfaces=6, hits=True)
FULL = Steps((2, 4, 8, 16, 32), (1, 2, 4, 8, 16), WAVES, hits=True)

ACCURACY = 2e-3
"""Error of an order's energy that `simulate` promises when it is told nothing else."""

NUMBERS = (2, 4, 8, 16, 32, 64, 128)
"""Surfaces of the automatic period whose scatter is told."""


def cells(full: bool) -> list[str]:
    """Names of all cells."""
    steps = FULL if full else DRAFT
    values: dict[str, Iterable[float | None]] = {
        "cells": steps.cells,
        "lift": LIFTS,
        "hits": HITS,
        "extent": steps.extents,
        "waves": steps.waves,
        "surfaces": NUMBERS,
    }
    return [_name(p, "all" if v is None else float(v)) for p, some in values.items() for v in some]


def _name(parameter: str, value: float | str) -> str:
    return f"{METHOD},{parameter},{value if isinstance(value, str) else f'{value:g}'}"


def simulation(full: bool, seed: int, workers: Workers, quiet: bool) -> list[Row]:
    """Rows of stability.csv: of each setting and value, the greatest error of an order's energy."""
    rays, steps = (RAYS, FULL) if full else (RAYS_OF_DRAFT, DRAFT)
    table = convergence(SCENE, rays, seed, workers, quiet, steps)
    chosen = plan(SCENE, ACCURACY, None, None, None, None)
    automatic = {
        "cells": f"{chosen.cells}",
        "lift": "1",
        "extent": f"{chosen.extent}",
        "waves": "all",
        "hits": "64",
    }
    found = list(_worst(table))
    last = {parameter: value for parameter, value, _, _ in found}
    rows = [
        _row(parameter, value, error, stderr, automatic[parameter], last[parameter])
        for parameter, value, error, stderr in found
    ]
    spread = _spread(table, steps)
    for number in NUMBERS:
        stderr = spread / math.sqrt(number)
        verdict = verdicts.WORKS if stderr <= ACCURACY else verdicts.DEGRADED
        note = f"a standard error of {stderr:.1g}; the automatic choice is {chosen.realisations}"
        rows.append(_of("surfaces", float(number), verdict, 0.0, stderr, note))
    return rows


def _worst(table: Table) -> Iterator[tuple[str, float | str, float, float]]:
    """Parameter, value, and the most significant difference of an order from the last value."""
    groups: dict[tuple[str, float | str], list[tuple[float, float]]] = {}
    for parameter, value, apart, stderr in zip(
        *(table[name] for name in ("parameter", "value", "difference", "difference_stderr")),
        strict=True,
    ):
        groups.setdefault((parameter, value), []).append((apart, stderr))
    for (parameter, value), found in groups.items():
        apart, stderr = max(found, key=lambda pair: abs(pair[0]))
        yield parameter, value, apart, stderr


def _spread(table: Table, steps: Steps) -> float:
    """Standard deviation from surface to surface of the energy of an order, the greatest."""
    errors = [
        stderr
        for parameter, value, stderr in zip(
            table["parameter"], table["value"], table["stderr"], strict=True
        )
        if parameter == "extent" and value == EXTENT
    ]
    return float(max(errors)) * math.sqrt(4 * steps.surfaces)


def _row(
    parameter: str,
    value: float | str,
    error: float,
    stderr: float,
    automatic: str,
    last: float | str,
) -> Row:
    if value == last:
        note = f"what the others are held against; the automatic choice is {automatic}"
        return _of(parameter, value, verdicts.WORKS, error, stderr, note)
    significant = abs(error) > 2 * stderr
    verdict = verdicts.WORKS
    if significant and abs(error) > ACCURACY:
        verdict = verdicts.FAILS if abs(error) > verdicts.VISIBLE else verdicts.DEGRADED
    elif stderr > ACCURACY:
        verdict = verdicts.UNKNOWN
    note = f"beside {last}; the automatic choice is {automatic}"
    return _of(parameter, value, verdict, error, stderr, note)


def _of(
    parameter: str, value: float | str, verdict: str, error: float, stderr: float, note: str
) -> Row:
    none = float("nan")
    return Row(
        method=METHOD,
        precision="float32" if parameter == "hits" and value == 32 else "float64",
        parameter=parameter,
        value=value,
        material=SCENE.material.name,
        slopes=SCENE.slopes.name,
        alpha_x=SCENE.alpha[0],
        alpha_y=SCENE.alpha[1],
        theta_i_rad=SCENE.theta[0],
        verdict=verdict,
        nonfinite=0,
        energy_error=error,
        bounces_mean=none,
        slowdown=none,
        note=note,
        phi_i_rad=SCENE.phi,
        ior=none,
        absorptance=0.0,
        energy_stderr=stderr,
        chi_square_p=none,
        tail_index=none,
        unresolved=none,
        cell=_name(parameter, value),
    )
