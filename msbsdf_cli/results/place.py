"""Where a report goes: written whole or not at all, never over what is somebody's own.

A draft lies beside the place under a name that tells whose it is, locked as long as its process
lives; a draft without a living process is cleaned by the next run into the place. A report that is
replaced gives up the files that it lists, and these only; they wait in the draft until all of the
new ones are there, so that every step can be undone."""

import json
import os
import secrets
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from msbsdf_cli.results.seal import RUN, seal

LOCK, UNNAMED, OLD = ".lock", ".lock-", ".old"
"""In a draft: the file that its process holds locked, before and after it is, and the files of the
report replaced."""

YOUNG_S = 60
"""Age of a draft without a lock below which it may be one that is about to have it."""


class PlaceTakenError(ValueError):
    """A report cannot go where it was wanted; the text says why."""


class Place:
    """A directory for one report. Raises PlaceTakenError where there is something else, or, unless
    `force` is given, a report."""

    def __init__(self, out: str | Path, force: bool = False, inputs: tuple[Path, ...] = ()) -> None:
        self.out, self.force = Path(out), force
        """The place; once the report is written, where it is."""
        if not str(out):
            raise PlaceTakenError("the name of the directory is empty; name one.")
        if self.out.exists() and not self.out.is_dir():
            raise PlaceTakenError(f"{out} is a file; name a directory.")
        for path in inputs:
            if self.real == path.resolve() or self.real in path.resolve().parents:
                raise PlaceTakenError(f"{out} holds {path}, which is read; name another directory.")
        if self.taken():
            self._check_old()

    @property
    def real(self) -> Path:
        """The place itself, whatever links lead there."""
        return self.out.resolve()

    def taken(self) -> bool:
        """Whether there is anything in it."""
        return self.out.is_dir() and any(self.out.iterdir())

    def _check_old(self) -> None:
        if listed(self.real) is None:
            raise PlaceTakenError(
                f"{self.out} holds files that are not a report; name another directory."
            )
        if not self.force:
            raise PlaceTakenError(
                f"{self.out} already holds a report; name another directory, or replace it with "
                "--force."
            )

    @contextmanager
    def draft(self) -> Iterator[Path]:
        """A directory to write into, which becomes the report when all is written, and vanishes
        otherwise.

        Where a report appeared in the meantime, or files of the user's are in the way, it becomes
        one beside it, `OUT-2` and so on; `out` says which.
        """
        real = self.real
        real.parent.mkdir(parents=True, exist_ok=True)
        _clean(real)
        draft, lock = real.parent / f"{_prefix(real)}{secrets.token_hex(4)}", None
        try:
            draft.mkdir()
            lock = locked(draft / UNNAMED)
            if lock is not None:
                # It has its name only when it is locked: nobody takes the draft for dead.
                os.rename(draft / UNNAMED, draft / LOCK)
            yield draft
            seal(draft)
            if not _fill(real, draft, self.force):
                self.out = self._settle(real, draft)
        finally:
            if lock is not None:
                os.close(lock)
            shutil.rmtree(draft, ignore_errors=True)

    def _settle(self, real: Path, draft: Path) -> Path:
        """Give the draft its name, or the first free one beside it."""
        for k in range(1, 10_000):
            name = real.name if k == 1 else f"{real.name}-{k}"
            target = real.with_name(name)
            try:
                # Fails where there is anything but an empty directory.
                os.rename(draft, target)
            except OSError:
                if not target.exists():
                    raise
            else:
                (target / LOCK).unlink(missing_ok=True)
                return self.out if k == 1 else self.out.with_name(name)
        raise PlaceTakenError(f"{self.out} and all names like it are taken.")


def listed(directory: Path) -> list[str] | None:
    """The files that a report of this program lists, beside its run.json; None where it is none."""
    path = directory / RUN
    try:
        if not path.is_file():
            return None
        run: Any = json.loads(path.read_text(encoding="utf-8"))
        run["command"], run["options"], run["versions"]["msbsdf"]
        names = [str(name) for name in run["files"]]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    # A name that leads out of the directory is none of a report's.
    return [name for name in names if not (Path(name).is_absolute() or ".." in Path(name).parts)]


def _fill(out: Path, draft: Path, force: bool) -> bool:
    """Put the files of the draft into a directory that is there, in the place of those of the
    report that it holds, or leave all as it is.

    False where there is no directory, or a report that is not to be replaced, or files that no
    report wrote are in the way.
    """
    if not out.is_dir():
        return False
    # Of two runs into one directory the second waits, and sees what the first has put there.
    directory = locked(out, wait=True)
    try:
        old = [] if not any(out.iterdir()) else listed(out) if force else None
        return old is not None and _exchange(out, draft, old)
    finally:
        if directory is not None:
            os.close(directory)


def _exchange(out: Path, draft: Path, old: list[str]) -> bool:
    """Move the files `old` out of the way and those of the draft into `out`, all or none; False
    where other files are in the way."""
    new = [str(p.relative_to(draft)) for p in draft.rglob("*") if p.is_file() and p.name != LOCK]
    if any(name not in (*old, RUN) and os.path.lexists(out / name) for name in new):
        return False
    moved: list[tuple[Path, Path]] = []
    try:
        for name in (name for name in (*old, RUN) if os.path.lexists(out / name)):
            _move(out / name, draft / OLD / name, moved)
        # What makes a report of a directory comes last.
        for name in sorted(new, key=lambda name: (name == RUN, name)):
            _move(draft / name, out / name, moved)
    except BaseException:
        for source, target in reversed(moved):
            os.rename(target, source)
        raise
    for directory in sorted({(out / name).parent for name in old}, reverse=True):
        if directory != out and directory.is_dir() and not any(directory.iterdir()):
            directory.rmdir()
    return True


def _move(source: Path, target: Path, moved: list[tuple[Path, Path]]) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    os.rename(source, target)
    moved.append((source, target))


def _prefix(real: Path) -> str:
    return f".{real.name}.draft-"


def _clean(real: Path) -> None:
    """Remove drafts whose process has ended; what one had taken from a report goes back."""
    for draft in real.parent.glob(f"{_prefix(real)}*"):
        if not (draft / LOCK).exists():
            # It has just begun, or was killed in its first instant.
            if time.time() - draft.stat().st_mtime < YOUNG_S:
                continue
        elif (lock := locked(draft / LOCK)) is None:
            continue
        else:
            os.close(lock)
        for path in [p for p in (draft / OLD).rglob("*") if p.is_file()]:
            home = real / path.relative_to(draft / OLD)
            if not home.exists():
                home.parent.mkdir(parents=True, exist_ok=True)
                os.rename(path, home)
        shutil.rmtree(draft, ignore_errors=True)


def locked(path: Path, wait: bool = False) -> int | None:
    """A lock on a file or directory, until it is closed or this process ends; None where another
    one has it, or locks are unknown."""
    try:
        import fcntl
    except ImportError:  # Elsewhere than on POSIX nobody can tell; a draft stays.
        return None
    try:
        flags = os.O_RDONLY if path.is_dir() else os.O_RDWR | os.O_CREAT
        descriptor = os.open(path, flags, 0o600)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        os.close(descriptor)
        return None
    return descriptor
