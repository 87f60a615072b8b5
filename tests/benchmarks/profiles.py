"""Free paths against lines of a Gaussian surface that are drawn whole, without a mesh:
`python -m tests.benchmarks.profiles`.

Along a line all depends on the slope c of the ray, in standard deviations of the surface's. Prints
CSV: how far the free paths of each model are from those of the lines (Kolmogorov-Smirnov), and the
noise of that; then how often a model has at most a third of Smith's distance.
"""

import sys

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from msbsdf_cli.experiments.walks import smith_shares
from msbsdf_cli.memory.free_paths import shares
from msbsdf_cli.memory.remembered import Remembered
from msbsdf_cli.smith.heights import Gaussian
from msbsdf_cli.smith.slopes import Beckmann

THETA = 0.5, 1.0, 1.4, 2.0
STARTS = -2.0, -1.0, 0.0, 1.0, 2.0
RAYS, BLOCK = 400_000, 10_000
STEP, TOP = 0.06, 6.0


def lines(c: float, h: float, edges: NDArray[np.float64], rng: np.random.Generator):
    """Shares (bins + 1,) of rays of slope `c` from height `h` that meet the surface in bins of
    height, and that escape."""
    # A ray that falls is below all of the surface somewhen.
    length = (TOP - h) / c if c > 0 else (TOP + h) / -c
    x = np.arange(1, int(length / STEP) + 2) * STEP
    E = np.exp(-x * x / 2)
    given = np.stack([E, x * E], axis=1)
    power, wave = np.linalg.eigh(np.exp(-((x[:, None] - x) ** 2) / 2) - given @ given.T)
    kept = power > 1e-11
    wave = wave[:, kept] * np.sqrt(power[kept])
    count, ray = np.zeros(edges.size), h + c * x
    for _ in range(RAYS // BLOCK):
        s = ndtri((1 - rng.random(BLOCK)) * ndtr(c))
        above = wave @ rng.standard_normal((wave.shape[1], BLOCK))
        above += given @ np.stack([np.full(BLOCK, h), s]) - ray[:, None]
        hit = np.flatnonzero((above > 0).any(axis=0))
        at = (above > 0).argmax(axis=0)[hit]
        over = above[at, hit]
        # From the facet to the first place as straight as everywhere: it is a tenth of a bin.
        under = np.where(at > 0, above[at - 1, hit], -1e-9)
        met = h + c * (x[at] - STEP * over / (over - under))
        count[:-1] += np.histogram(np.clip(met, edges[1] - 1, edges[-2] + 1), edges)[0]
        count[-1] += BLOCK - hit.size
    return count / RAYS


def main() -> None:
    edges, slopes, rng = Gaussian().edges, Beckmann(1, 1), np.random.default_rng(0)
    models = [smith_shares(slopes, Gaussian(), edges)]
    models += [shares(Remembered(number=n), slopes, edges) for n in (1, 2)]
    print("c,start,smith,memory,memory_2,stderr")
    found = []
    for theta in THETA:
        c = np.sqrt(2) / np.tan(theta)
        d = np.array([[np.sin(theta)], [0], [np.cos(theta)]])
        for start in STARTS:
            true = np.cumsum(lines(c, start, edges, rng))
            drawn = [np.cumsum(m(d, start, RAYS, rng)) for m in models]
            apart = [np.abs(a - true)[:-1].max() for a in drawn]
            # Of the difference of two shares, where it is greatest.
            p = true[:-1][np.argmax(np.abs(drawn[0] - true)[:-1])]
            stderr = np.sqrt(2 * p * (1 - p) / RAYS)
            found.append((*apart, stderr))
            print(f"{c:.3g},{start:.0f}," + ",".join(f"{a:.2g}" for a in found[-1]), flush=True)
    told = [row for row in found if row[0] > 3 * row[-1]]
    for k, name in ((1, "memory"), (2, "memory_2")):
        met = sum(row[k] - row[-1] <= row[0] / 3 for row in told)
        print(f"{name}: at most a third of Smith's in {met} of {len(told)}", file=sys.stderr)


if __name__ == "__main__":
    main()
