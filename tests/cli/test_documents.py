"""What the documents say of commands: each of them exists, with its options."""

import re
import shlex
from importlib import import_module
from pathlib import Path

import click
import pytest

from msbsdf_cli.cli import COMMANDS, group
from msbsdf_cli.cli.gallery import GALLERY, MADE, MOST_BYTES, PLACE, make

ROOT = Path(__file__).parents[2]
DOCUMENTS = [
    ROOT / name for name in ("README.md", "CONTRIBUTING.md", "msbsdf_cli/README.md")
] + sorted((ROOT / "reports").glob("*.md"))


def command_lines():
    """Every command line in code, within lines or in blocks, on one line each."""
    for document in DOCUMENTS:
        text = document.read_text(encoding="utf-8")
        code = re.findall(r"`((?:\.venv/bin/)?msbsdf [^`]+)`", text)
        for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL):
            code += re.findall(r"(?:^|&& |/)(msbsdf [^\n&]*)", block, re.MULTILINE)
        for line in code:
            yield document.name, " ".join(line.split())
    for folder in GALLERY.values():
        for line in folder.made_by if folder.remade else ():
            yield "gallery", line


@pytest.mark.parametrize(("document", "line"), sorted(set(command_lines())))
def test_a_command_in_the_documents_exists(document, line, tmp_path, monkeypatch):
    check(line, tmp_path, monkeypatch)


def check(line, tmp_path, monkeypatch):
    """Parse a command line as the program does; files that it names are there, and empty. Words in
    capitals stand for something."""
    name, *words = shlex.split(line)[1:]
    if name.isupper() or name.startswith("-"):
        return
    assert name in COMMANDS, f"`{line}`: no such command"
    command = import_module(f"msbsdf_cli.cli.{name}").command
    flags = {flag for p in command.params for flag in (*p.opts, *p.secondary_opts)} | {"--help"}
    if name == "sweep" and words and words[0].islower() and "." not in words[0]:
        # What a sweep does not know belongs to the command that it runs.
        inner = import_module(f"msbsdf_cli.cli.{words[0]}").command
        flags |= {flag for p in inner.params for flag in p.opts}
    for word in words:
        if word.startswith("--"):
            assert word.partition("=")[0] in flags, f"`{line}`: no option {word}"
    placeholder = any(re.fullmatch(r"\[?[A-Z]{2,}[.\]]*", word) for word in words)
    if not words or placeholder or "--help" in words:
        return
    monkeypatch.chdir(tmp_path)
    for word in words:
        if re.search(r"\.(npy|npz|toml|xml|csv)$", word):
            path = Path(word)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
    # An option that is only mentioned has no value.
    if words and words[-1] in {f for p in command.params if not is_flag(p) for f in p.opts}:
        words = words[:-1]
    with click.Context(group, info_name="msbsdf") as parent:
        command.make_context(name, words, parent=parent)


def is_flag(parameter):
    return getattr(parameter, "is_flag", False)


@pytest.mark.parametrize(
    "line", ["msbsdf comparison", "msbsdf compare --alfa 1", "msbsdf compare --alpha zero"]
)
def test_what_is_no_command_is_found(line, tmp_path, monkeypatch):
    with pytest.raises((AssertionError, click.UsageError)):
        check(line, tmp_path, monkeypatch)


def test_the_table_of_the_gallery_says_what_makes_it():
    text = (ROOT / "reports" / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[([\w-]+)\]\(gallery/([\w-]+)\) \| (.*) \|$", text, re.MULTILINE)
    said = {name: re.findall(r"`([^`]*)`", words) for name, _, words in rows}
    assert said == {name: list(folder.made_by) for name, folder in GALLERY.items()}
    assert all(name == place for name, place, _ in rows)


def test_the_gallery_holds_what_its_list_says_and_no_more_than_it_may():
    place = ROOT / PLACE
    files = {str(p.relative_to(place)) for p in place.rglob("*") if p.is_file()}
    wanted = {
        f"{f.name}/{Path(n).name}"
        for f in GALLERY.values()
        for kept in f.made_by.values()
        for n in kept
    }
    made = {f"{name}/{MADE}" for name in GALLERY}
    assert files == wanted | made | {"recommend/kitchen.toml"}
    assert sum((place / name).stat().st_size for name in files) < MOST_BYTES


def test_a_folder_of_the_gallery_is_made_by_its_command(tmp_path, monkeypatch):
    import json

    from msbsdf_cli.cli import gallery

    line = "msbsdf evaluate --method single --theta 0.5 --points 4"
    mine = gallery.Folder("one", {line: ("slice.csv", "slice.png")})
    monkeypatch.setattr(gallery, "GALLERY", {"one": mine})
    size = make((), tmp_path)
    about = json.loads((tmp_path / "one" / MADE).read_text())
    assert about["commands"] == [line]
    assert about["version"]
    assert size == sum(p.stat().st_size for p in (tmp_path / "one").iterdir())
    monkeypatch.setattr(gallery, "GALLERY", {"one": gallery.Folder("one", {"msbsdf none": ()})})
    with pytest.raises(RuntimeError, match="msbsdf none"):
        make((), tmp_path)
