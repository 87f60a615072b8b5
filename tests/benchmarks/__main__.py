"""`python -m tests.benchmarks`: what the project costs, side by side with the published walk.

The C++ of that walk, `published_walk.cpp`, is compiled when a compiler is there. Both sides take
turns on one core, and of each the fastest of several runs counts; ratios above 1 are in favour of
this project. Run it on a machine that does nothing else.
"""

import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

import msbsdf_cli as ms
from msbsdf_cli.experiments.random_surfaces import Resolution
from msbsdf_cli.experiments.realisations import simulate
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.surface_tally import SurfaceTally

RUNS = 5
WALKS = 400_000

GLASS = ms.Dielectric(1.5)
MATERIALS = {"conductor": ms.Conductor(), "diffuse": ms.Diffuse(), "dielectric": GLASS}
SLOPES = {"ggx": ms.Ggx, "beckmann": ms.Beckmann}

SCENES = (
    ("ggx", "conductor", 0.5, 1.0),
    ("beckmann", "conductor", 0.5, 1.0),
    ("ggx", "diffuse", 1.0, 0.0),
    ("beckmann", "diffuse", 1.0, 1.0),
    ("beckmann", "dielectric", 1.0, 1.5),
    ("ggx", "dielectric", 0.5, 0.5),
)

SOLVED = (
    (ms.Beckmann(0.2, 0.2), GLASS),
    (ms.Ggx(1.0, 1.0), GLASS),
    (ms.Ggx(0.1, 1.0), ms.Conductor()),
    (ms.Ggx(0.1, 1.0), GLASS),
    (ms.Beckmann(0.01, 0.01), ms.Conductor()),
)


SIMULATED = (("conductor", 1.0, 0.0), ("conductor", 0.5, 1.0), ("dielectric", 1.0, 1.5))

RESOLUTION, RAYS = Resolution(16, 16, 96), 3_000_000
"""Of simulations: 16 cells on 16 correlation lengths, 96 surfaces."""


def main() -> None:
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        print("No C++ compiler is installed: walks are timed alone.")
    with tempfile.TemporaryDirectory() as directory:
        program = compile_walk(compiler, Path(directory)) if compiler else None
        print(
            "walk, one core: million walks a second, and energy of order 1; the published walk is"
        )
        print("in single precision, so that its equal is the second of the two")
        for scene in SCENES:
            print(walk_lines(program, *scene))
    print("solve, one core: seconds for the energies of all orders, and the error that it states")
    for slopes, material in SOLVED:
        print(solve_line(slopes, material))
    print("simulate, all cores: energies of orders 1 and 2, their noise after a minute, and what")
    print("is in doubt of mesh and period")
    for name, alpha, theta in SIMULATED:
        print(simulate_line(name, alpha, theta))
    print(f"compare, no arguments: {compare_s():.1f} s")


def compile_walk(compiler: str, directory: Path) -> Path:
    """The program, as its authors would build it."""
    source, program = Path(__file__).with_name("published_walk.cpp"), directory / "published_walk"
    options = ["-std=c++17", "-O3", "-march=native"]
    subprocess.run([compiler, *options, source, "-o", program], check=True)
    return program


def walk_lines(program: Path | None, slopes: str, material: str, alpha: float, theta: float) -> str:
    model = ms.Smith(SLOPES[slopes](alpha, alpha), MATERIALS[material])
    ours: dict[str, list[float]] = {"float64": [], "float32": []}
    energies: dict[str, float] = {}
    theirs = []
    for seed in range(RUNS):
        for precision, seconds in ours.items():
            started = perf_counter()
            result = ms.walk(model, ms.direction(theta), WALKS, seed=seed, precision=precision)
            seconds.append(perf_counter() - started)
            energies[precision] = first_order(result)
        if program is not None:
            command = [program, slopes, material, str(alpha), str(theta), str(WALKS)]
            found = subprocess.run(command, check=True, capture_output=True, text=True)
            taken, energies["C++"], *_ = map(float, found.stdout.split())
            theirs.append(taken)
    lines = []
    for precision, seconds in ours.items():
        rate = WALKS / min(seconds) / 1e6
        line = f"  {slopes:9} {material:11} {alpha:4g} {theta:4g}  {precision} {rate:6.2f}"
        if theirs:
            ratio = min(theirs) / min(seconds)
            line += f"   C++ {WALKS / min(theirs) / 1e6:6.2f}   ratio {ratio:5.2f}"
        of_both = (f"{energies[key]:.4f}" for key in (precision, "C++") if key in energies)
        lines.append(f"{line}   {' '.join(of_both)}")
    return "\n".join(lines)


def first_order(result: ms.Result) -> float:
    """Energy of the first order, both sides."""
    return float(result.energy[0].sum())


def solve_line(slopes: ms.Beckmann | ms.Ggx, material: object) -> str:
    best, error = np.inf, 0.0
    for _ in range(3):
        started = perf_counter()
        energy = Solve(slopes, material, 4).energy(ms.direction(1.0))
        best, error = min(best, perf_counter() - started), float(energy.error.max())
    alpha = ",".join(f"{a:g}" for a in dict.fromkeys((slopes.alpha_x, slopes.alpha_y)))
    return f"  {slopes.name:9} {material.name:11} {alpha:8}  {best:7.2f} s   +- {error:.1e}"


def simulate_line(name: str, alpha: float, theta: float) -> str:
    scene = Scene(MATERIALS[name], ms.Beckmann(alpha, alpha), (theta,), 0.0)
    none = FreePaths((), (), np.array([0.0, 1.0]))
    started = perf_counter()
    run = simulate(scene, RAYS, RESOLUTION, none, 0, os.cpu_count() or 1, 10_000, True)
    minutes = (perf_counter() - started) / 60
    (tally,) = run.tallies
    assert isinstance(tally, SurfaceTally)
    value, squares = tally.figures()
    rows = value, np.sqrt((squares - tally.systematic) * minutes), np.sqrt(tally.systematic)
    energy, noise, systematic = (tally.views(row)["energy"] for row in rows)
    found = [
        f"{side}{order + 1} {energy[order, i]:.4f} +- {noise[order, i]:.1e} +- "
        f"{systematic[order, i]:.1e}"
        for i, side in enumerate("rt")
        for order in range(2)
        if energy[order, i] > 0.01
    ]
    share = run.notes["embree_s"] / run.notes["trace_s"]
    return f"  {name:11} {alpha:4g} {theta:4g}   {', '.join(found)}   Embree {share:.2f} of tracing"


def compare_s() -> float:
    """Seconds, all of it: imports, pictures and files."""
    with tempfile.TemporaryDirectory() as directory:
        command = [sys.executable, "-m", "msbsdf_cli", "compare", "--quiet"]
        started = perf_counter()
        subprocess.run([*command, "--out", f"{directory}/report"], check=True)
        return perf_counter() - started


if __name__ == "__main__":
    main()
