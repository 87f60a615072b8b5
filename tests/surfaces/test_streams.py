"""Random streams: each has a name, and none is another one in disguise."""

import re
from collections import Counter
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest
from click.testing import CliRunner
from command_line import NO_PICTURES

from msbsdf_cli.cli import group
from msbsdf_cli.experiments.convergence import Steps
from msbsdf_cli.validation.suite import IDENTITIES, name, plan
from surfaces import streams

ROOT = Path(__file__).parents[2]
SURFACES = ["--cells", "4", "--extent", "8", "--realisations", "2", "--samples", "400"]
RUNS = [
    [
        *("sweep", "compare", *SURFACES, "--alpha", "0.5", "--alpha", "1", "--theta", "0,1"),
        *("--material", "conductor,dielectric", "--seed", "1"),
    ],
    ["compare", *SURFACES, "--theta", "0"],
    ["evaluate", "--method", "walk,exact", "--samples", "64", "--points", "4", "--theta", "0,1"],
    ["simulate", *SURFACES[:-2], "--samples", "64", "--theta", "0,1", "--convergence"],
    ["stability", "--cell", "walk,float64,outgoing,around the horizon,conductor,ggx,1"],
    [
        *("furnace", "--samples", "32", "--theta", "0,1", "--alpha", "0.5", "--alpha", "1"),
        *("--method", "walk,exact"),
    ],
    [
        *("tradeoff", "--method", "walk,exact", "--samples", "16", "--replicates", "4"),
        *("--directions", "16", "--rays", "100", *SURFACES[:4], "--realisations", "8"),
        *("--theta", "0,1", "--qmc"),
    ],
]
FEWER = {
    "msbsdf_cli.experiments.convergence": {
        "STEPS": Steps((4, 6), (4, 8), (30, None), surfaces=2),
        "EXTENT": 8,
    },
    "msbsdf_cli.experiments.tradeoff.roughness": {"ALPHAS": (0.5, 1.0)},
    # Spheres are small, and yet made in four jobs.
    "msbsdf_cli.experiments.render.picture": {"CHUNK": 36},
}


@pytest.fixture
def keys(monkeypatch):
    """Seed and key of every stream that is made, in their order."""
    made = []

    class Recorded(np.random.SeedSequence):
        def __init__(self, seed, *, spawn_key, **more):
            made.append((seed, tuple(spawn_key)))
            super().__init__(seed, spawn_key=spawn_key, **more)

    monkeypatch.setattr(np.random, "SeedSequence", Recorded)
    # No picture is made of random numbers, and drawing takes longer than the run.
    for drawing, instead in NO_PICTURES.items():
        monkeypatch.setattr(drawing, instead)
    for module, values in FEWER.items():
        for constant, value in values.items():
            monkeypatch.setattr(f"{module}.{constant}", value)
    return made


@pytest.mark.parametrize("words", RUNS, ids=lambda words: words[0])
def test_no_two_streams_of_a_run_are_alike(words, keys, tmp_path):
    words = [*words, "--seed", "0", "--threads", "1", "--quiet", "--out", str(tmp_path / "r")]
    result = CliRunner().invoke(group, words, catch_exceptions=False)
    assert result.exit_code in (0, 3), result.output
    assert len(keys) > 5
    common = {crc32(name.encode()) for name in streams.COMMON}
    names = {crc32(name.encode()): name for name in streams.STREAMS}
    times = Counter(key for key in keys if key[1][0] not in common)
    assert {names[key[1][0]] for key, n in times.items() if n > 1} == set()
    distinct = set(keys)
    sequences = [np.random.SeedSequence(seed, spawn_key=key) for seed, key in distinct]
    numbers = {tuple(streams.generator(s).integers(1 << 63, size=2)) for s in sequences}
    assert len(numbers) == len(distinct)


def test_no_two_identities_share_a_stream():
    jobs = list(plan(1, 0, quick=False))
    keys = {(name(IDENTITIES[job.number]), job.place) for job in jobs}
    assert len(keys) == len(jobs)
    assert min(job.place for job in jobs) > 0, "0 is the stream that draws configurations"


def test_names_and_places_make_different_streams():
    names = [crc32(name.encode()) for name in streams.STREAMS]
    assert len(set(names)) == len(names)
    assert set(streams.COMMON) <= set(streams.STREAMS)
    places = [(), (0,), (0, 0), (1,), (1, 0), (1 << 32,), (0, 1), ("0",), ("",)]
    keys = [streams.seed_sequence(s, "walk", *p) for s in (0, 1 << 40) for p in places]
    states = {tuple(key.generate_state(4)) for key in keys}
    assert len(states) == 2 * len(places)
    with pytest.raises(ValueError, match="place"):
        streams.stream(0, "walk", -1)
    with pytest.raises(KeyError, match="walc"):
        streams.stream(0, "walc")


def test_generators_are_made_in_one_place():
    made = re.compile(r"default_rng\(|SFC64\(|PCG64|np\.random\.seed|RandomState")
    sources = [*(ROOT / "msbsdf_cli").rglob("*.py"), *(ROOT / "surfaces").rglob("*.py")]
    found = {path.name for path in sources if made.search(path.read_text())}
    assert found == {"streams.py"}
