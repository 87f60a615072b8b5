"""No damage to a report passes silently."""

import json
import os
import shutil

import numpy as np
import pytest
from command_line import msbsdf

RUNS = {
    "walk": ["walk", "--samples", "2e3"],
    "simulate": ["simulate", "--samples", "1e3", "--realisations", "3", "--extent", "4", "--cells",
                 "4"],
}  # fmt: skip
DAMAGES = 200


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    where = tmp_path_factory.mktemp("reports")
    for name, words in RUNS.items():
        few = ["--free-path-theta", 1, "--free-path-height", 0]
        words = [*words, *few, "--theta", 1, "--threads", 1, "--quiet", "--out", where / name]
        result = msbsdf(*words, pictures=True)
        assert result.returncode == 0, result.stderr
    return where


def cut(content, rng):
    return content[: rng.integers(len(content))]


def swap(content, rng):
    lines = content.split(b"\n")
    i, j = rng.choice(len(lines), 2, replace=len(lines) < 2)
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def half(content, rng):
    lines = content.split(b"\n")
    return b"\n".join(lines[:1] + lines[1 :: rng.integers(2, 4)])


def retype(content, rng):
    digit = bytes([rng.integers(48, 58)])
    return content.replace(digit, rng.choice([b"NaN", b"-", b"1e9", b"x"]), 3)


def other_bytes(content, rng):
    place = rng.integers(len(content))
    return content[:place] + bytes([content[place] ^ 1 << rng.integers(8)]) + content[place + 1 :]


def test_damaged_reports_are_refused_with_the_file(reports, tmp_path):
    rng = np.random.default_rng(11)
    done = 0
    while done < DAMAGES:
        which = str(rng.choice(list(RUNS)))
        path = rng.choice(sorted((reports / which).iterdir()))
        before = path.read_bytes()
        damage = rng.choice([cut, swap, half, retype, other_bytes, None])
        after = None if damage is None else damage(before, rng)
        if after == before:
            continue  # Nothing was changed.
        done += 1
        if after is None:
            path.unlink()
        else:
            path.write_bytes(after)
        both = reports / "walk", reports / "simulate"
        result = msbsdf("compare", *both, "--quiet", "--out", tmp_path / "c")
        path.write_bytes(before)
        assert result.returncode == 1, (path, damage)
        assert path.name in result.stderr, result.stderr
        assert len(result.stderr.strip().splitlines()) == 1
        assert not (tmp_path / "c").exists()


@pytest.mark.parametrize(
    "change",
    [{"alpha": [-1, -1]}, {"material": "x"}, {"theta": [5.0]}, {"orders": 0}, {"seed": "none"}],
)
def test_an_edited_scene_is_refused(change, reports, tmp_path):
    walk = shutil.copytree(reports / "walk", tmp_path / "w")
    run = json.loads((walk / "run.json").read_text())
    run["options"] |= change
    (walk / "run.json").write_text(json.dumps(run))
    result = msbsdf("compare", walk, reports / "simulate", "--out", tmp_path / "c")
    assert result.returncode == 1
    assert "run.json is not as it was written" in result.stderr


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_in_the_place_of_a_file_does_not_hang(reports, tmp_path):
    for name in ("run.json", "energy.csv"):
        walk = shutil.copytree(reports / "walk", tmp_path / name / "w")
        (walk / name).unlink()
        os.mkfifo(walk / name)
        result = msbsdf("compare", walk, reports / "simulate", "--out", tmp_path / "c")
        assert result.returncode == 1
        assert name in result.stderr
