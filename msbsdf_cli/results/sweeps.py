"""What the pieces of a sweep came to: a file each while it runs, all in one archive in its report.

An archive holds the sums themselves, so that those of other seeds and machines can be added."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol
from zipfile import BadZipFile, ZipFile, ZipInfo

from msbsdf_cli.results import npz
from msbsdf_cli.results.place import locked
from surfaces.facet import Array

ARCHIVE = "pieces.zip"
FAILURES = "failures.json"
"""In an archive: why pieces failed, by name."""
PLAN = "plan.json"
"""In a directory of pieces, and in an archive: the sweep that they are of."""

FORMAT = "piece of msbsdf 1"

SUFFIX = ".npz"

State = dict[str, Array]


def name_of(seed: int, number: int) -> str:
    """The file of a piece."""
    return f"{seed}-{number}{SUFFIX}"


def refuse_other(mine: dict[str, Any], other: dict[str, Any], where: Path, *but: str) -> None:
    """Raise ValueError with a sentence where two sweeps differ, other than in the keys `but`."""
    for key in (key for key in mine if key not in but):
        a, b = mine[key], other.get(key)
        if a == b:
            continue
        if isinstance(a, dict) and isinstance(b, dict):
            names = [name for name in (*a, *b) if a.get(name) != b.get(name)]
            key, a, b = names[0], a.get(names[0]), b.get(names[0])
        raise ValueError(
            f"{where} is of another sweep: {key} is {_short(b)} there, here {_short(a)}."
        )


def _short(value: Any) -> str:
    text = "not given" if value is None else json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


class PieceStore:
    """The directory `OUT.pieces` of a sweep that is under way, for this process alone."""

    def __init__(self, out: Path, plan: dict[str, Any]) -> None:
        real = out.resolve()
        self.directory = real.with_name(f"{real.name}.pieces")
        self.plan = json.loads(json.dumps(plan))

    @contextmanager
    def opened(self) -> Iterator[Path]:
        """The directory, made where it is missing, for this process alone.

        Raises ValueError where another process has it, or it holds pieces of another sweep.
        """
        self.directory.mkdir(parents=True, exist_ok=True)
        lock = locked(self.directory)
        if lock is None:
            raise ValueError(
                f"another sweep writes into {self.directory}; wait for it, or name another --out."
            )
        try:
            self._check_plan()
            yield self.directory
        finally:
            os.close(lock)
            if self.directory.is_dir() and not self.done():
                self.remove()

    def _check_plan(self) -> None:
        path = self.directory / PLAN
        if path.exists():
            try:
                refuse_other(self.plan, _json(path.read_bytes(), path), self.directory)
            except ValueError as error:
                raise ValueError(f"{error} Name another --out, or remove the directory.") from None
            return
        draft = path.with_suffix(".draft")
        draft.write_text(json.dumps(self.plan), encoding="utf-8")
        os.replace(draft, path)

    def done(self) -> set[str]:
        """Names of the pieces that are there."""
        with os.scandir(self.directory) as entries:
            return {e.name for e in entries if e.name.endswith(SUFFIX) and e.name[0] != "."}

    def keep(self, name: str, states: list[State]) -> None:
        """Write a piece, whole or not at all."""
        npz.write(self.directory / name, FORMAT, {}, _flat(states))

    def bytes(self, name: str) -> bytes:
        """A piece as it was written."""
        return (self.directory / name).read_bytes()

    def remove(self) -> None:
        """Once all is in an archive, the pieces are of no use."""
        shutil.rmtree(self.directory, ignore_errors=True)


class Archive:
    """The pieces of a sweep that has ended. Raises ValueError for a file that holds none."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self.zip = ZipFile(path)
            self.plan = _json(self.zip.read(PLAN), path)
            self.failures: dict[str, str] = json.loads(self.zip.read(FAILURES))
        except (OSError, ValueError, KeyError, BadZipFile) as error:
            raise ValueError(f"{path} does not hold the pieces of a sweep: {error}.") from None

    def done(self) -> set[str]:
        """Names of the pieces that are there."""
        return {name for name in self.zip.namelist() if name.endswith(SUFFIX)}

    def bytes(self, name: str) -> bytes:
        """A piece as it was written."""
        return self.zip.read(name)


class Pieces(Protocol):
    """Pieces by name, wherever they are."""

    def done(self) -> set[str]:
        """Names of the pieces that are there."""
        ...

    def bytes(self, name: str) -> bytes:
        """A piece as it was written."""
        ...


def read(pieces: Pieces, name: str) -> list[State]:
    """The states of a piece that is there. Raises ValueError for one that cannot be read."""
    return _states(npz.read(name, FORMAT, pieces.bytes(name))[1])


def pack(path: Path, plan: dict[str, Any], failures: dict[str, str], *parts: Pieces) -> None:
    """Put all pieces, the plan of all of them, and why some failed, into an archive."""
    with ZipFile(path, "w") as archive:
        archive.writestr(ZipInfo(PLAN), json.dumps(plan))
        archive.writestr(ZipInfo(FAILURES), json.dumps(failures))
        for part in parts:
            for name in sorted(part.done()):
                archive.writestr(ZipInfo(name), part.bytes(name))


def _json(content: bytes, path: Path) -> dict[str, Any]:
    try:
        plan: dict[str, Any] = json.loads(content)
        plan["command"], plan["axes"], plan["seeds"], plan["options"]
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path} does not hold the plan of a sweep: {error}.") from None
    return plan


def _flat(states: list[State]) -> State:
    return {f"{i} {name}": a for i, state in enumerate(states) for name, a in state.items()}


def _states(arrays: State) -> list[State]:
    states: dict[int, State] = {}
    for key, array in arrays.items():
        number, _, name = key.partition(" ")
        states.setdefault(int(number), {})[name] = array
    return [states[i] for i in range(len(states))]
