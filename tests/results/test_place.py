"""Nothing of the user's is lost, whatever a report does to its directory."""

import json
import os
import shutil
from pathlib import Path

import pytest

from msbsdf_cli.results import place
from msbsdf_cli.results.place import Place, PlaceTakenError
from msbsdf_cli.results.seal import unsealed

RUN = {"command": "walk", "options": {}, "versions": {"msbsdf": "1"}}


def write(out, force=False, files=("energy.csv", "part/lobe.csv"), text="new"):
    where = Place(out, force)
    with where.draft() as draft:
        for name in files:
            (draft / name).parent.mkdir(exist_ok=True)
            (draft / name).write_text(text)
        (draft / "run.json").write_text(json.dumps(RUN))
    return where.out


def tree(directory):
    """Every file and directory below, with what is in it and its mode."""
    return {
        str(p.relative_to(directory)): (p.lstat().st_mode, p.read_text() if p.is_file() else None)
        for p in Path(directory).rglob("*")
    }


def test_a_report_is_whole_and_alone(tmp_path):
    out = tmp_path / "a" / "r"
    assert write(out) == out
    assert unsealed(out)["command"] == "walk"
    assert sorted(tree(out)) == ["energy.csv", "part", "part/lobe.csv", "run.json"]
    assert os.listdir(out.parent) == ["r"]


def test_what_is_no_report_is_never_touched(tmp_path):
    out = tmp_path / "r"
    out.mkdir()
    for content in ({}, {"command": "walk"}, [1], {"command": "x", "options": {}, "files": ["a"]}):
        (out / "run.json").write_text(json.dumps(content))
        (out / "a").write_text("mine")
        before = tree(out)
        for force in (False, True):
            with pytest.raises(PlaceTakenError, match="not a report"):
                Place(out, force)
        assert tree(out) == before
    with pytest.raises(PlaceTakenError, match="is a file"):
        Place(out / "a")
    with pytest.raises(PlaceTakenError, match="empty"):
        Place("")


def test_a_report_is_replaced_and_nothing_else(tmp_path):
    out = tmp_path / "r"
    write(out, files=("energy.csv", "old.csv", "gone/x.csv"), text="old")
    (out / "notes.txt").write_text("mine")
    (out / "empty").mkdir(mode=0o700)
    (out / "link").symlink_to("notes.txt")
    with pytest.raises(PlaceTakenError, match="--force"):
        Place(out)
    inode = out.stat().st_ino
    assert write(out, force=True) == out
    names = ["empty", "energy.csv", "link", "notes.txt", "part", "part/lobe.csv", "run.json"]
    assert sorted(tree(out)) == names
    assert (out / "energy.csv").read_text() == "new"
    assert (out / "link").is_symlink()
    assert (out / "empty").stat().st_mode & 0o777 == 0o700
    assert out.stat().st_ino == inode


def test_files_in_the_way_send_the_report_beside(tmp_path):
    out = tmp_path / "r"
    write(out, files=("energy.csv",))
    (out / "part").mkdir()
    (out / "part" / "lobe.csv").write_text("mine")
    before = tree(out)
    assert write(out, force=True) == tmp_path / "r-2"
    assert tree(out) == before
    unsealed(tmp_path / "r-2")


def test_a_report_that_appeared_meanwhile_is_kept(tmp_path):
    out = tmp_path / "r"
    slow = Place(out)
    with slow.draft() as draft:
        (draft / "run.json").write_text(json.dumps(RUN | {"command": "slow"}))
        assert write(out) == out
    assert slow.out == tmp_path / "r-2"
    assert [unsealed(p)["command"] for p in (out, slow.out)] == ["walk", "slow"]


@pytest.mark.parametrize("name", [".", "../r", "link"])
def test_places_by_other_names(name, tmp_path, monkeypatch):
    real = tmp_path / "r"
    real.mkdir()
    (real / "link").symlink_to("../elsewhere")
    if name != "link":
        (real / "link").unlink()
    monkeypatch.chdir(real)
    write(name)
    unsealed(Path(name))
    write(name, force=True)
    assert Path.cwd() == real
    assert name != "link" or Path(name).is_symlink()
    assert unsealed((tmp_path / "elsewhere") if name == "link" else real)


def test_an_input_is_not_replaced(tmp_path):
    write(tmp_path / "r")
    with pytest.raises(PlaceTakenError, match="which is read"):
        Place(tmp_path / "r", True, (tmp_path / "r",))
    with pytest.raises(PlaceTakenError, match="which is read"):
        Place(tmp_path, True, (tmp_path / "r",))


@pytest.mark.parametrize("step", range(6))
def test_every_step_can_be_undone(step, tmp_path, monkeypatch):
    out = tmp_path / "r"
    write(out, text="old")
    before, moves = tree(out), []

    def failing(source, target, moved, right=place._move):
        if len(moves) == step:
            raise OSError("the disk is full")
        moves.append(target)
        right(source, target, moved)

    monkeypatch.setattr(place, "_move", failing)
    with pytest.raises(OSError, match="full"):
        write(out, force=True)
    assert tree(out) == before
    assert os.listdir(tmp_path) == ["r"]


def test_a_dead_draft_is_cleaned_and_gives_back_what_it_had_taken(tmp_path):
    out = tmp_path / "r"
    write(out, text="old")
    dead = tmp_path / ".r.draft-dead"
    (dead / place.OLD).mkdir(parents=True)
    shutil.move(out / "energy.csv", dead / place.OLD / "energy.csv")
    (dead / place.LOCK).touch()
    newborn = tmp_path / ".r.draft-new"
    newborn.mkdir()
    stillborn = tmp_path / ".r.draft-old"
    stillborn.mkdir()
    os.utime(stillborn, (0, 0))
    living = Place(tmp_path / "s")
    with living.draft() as draft:
        (draft / "run.json").write_text(json.dumps(RUN))
        write(tmp_path / "s")
        assert draft.is_dir()
    with pytest.raises(PlaceTakenError):
        Place(out)
    assert write(out, force=True) == out
    assert not dead.exists()
    assert not stillborn.exists()
    assert newborn.exists()
    unsealed(out)


def test_a_list_of_files_that_leads_elsewhere_is_not_followed(tmp_path):
    (tmp_path / "mine").write_text("mine")
    out = tmp_path / "r"
    write(out)
    run = json.loads((out / "run.json").read_text())
    run["files"] = ["../mine", str(tmp_path / "mine"), "energy.csv"]
    (out / "run.json").write_text(json.dumps(run))
    write(out, force=True, files=("energy.csv",))
    assert (tmp_path / "mine").read_text() == "mine"
