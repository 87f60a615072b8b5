"""What a second of simulation buys: energies by ever more surfaces, on one mesh and on three.

On one mesh the mean over surfaces has the noise that it has, and the error of its mesh. On three,
control variates take off most of the noise, and extrapolation most of the mesh's error, for the
price of coarser meshes; what stays in doubt of mesh and period is drawn as their bias.
"""

import numpy as np

from msbsdf_cli.experiments.tradeoff.known_energies import Known, Spent
from msbsdf_cli.experiments.tradeoff.rows import (
    Row,
    costs,
    place,
    with_front,
    with_slopes,
    with_stderr,
)
from msbsdf_cli.scene import Scene

ONE, THREE = "simulate-one-mesh", "simulate-three-meshes"


def energy_rows(scene: Scene, steps: list[list[Known]], spent: list[Spent], rays: int) -> list[Row]:
    """Rows of energies.csv from what ever more surfaces told, angle by angle."""
    rows: list[Row] = []
    for theta, mine in zip(scene.theta, steps, strict=True):
        one = [_row(scene, theta, k, ONE, spent, rays) for k in mine]
        three = [_row(scene, theta, k, THREE, spent, rays) for k in mine]
        rows += with_front(with_slopes([*one, *three]))
    return rows


def _row(scene: Scene, theta: float, at: Known, method: str, spent: list[Spent], rays: int) -> Row:
    noise2, bias2 = (at.one, at.three)[method == THREE] / (at.energy**2).sum()
    error, noise = np.sqrt(noise2 + bias2), np.sqrt(noise2)
    known_to = 1 / np.sqrt(2 * (at.surfaces - 1))
    used = spent[: at.surfaces]
    seconds = sum(s.trace_s + (s.coarser_s if method == THREE else 0) for s in used)
    return Row(
        method=method,
        samples=at.surfaces * rays,
        bias=float(np.sqrt(bias2)),
        reference="surfaces",
        model="surfaces",
        **place(scene, theta),
        **with_stderr(
            relative_rmse=(float(error), float(noise2 * known_to / error)),
            noise=(float(noise), float(noise * known_to)),
        ),
        **costs(float(error**2), (seconds,) * 3, sum(s.surface_s for s in used)),
    )
