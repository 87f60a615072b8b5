"""The seal of a report: what its files held when they were written, so that damage shows."""

import json
from hashlib import sha256
from pathlib import Path
from typing import Any

RUN = "run.json"


def seal(directory: Path) -> None:
    """Put into every run.json below `directory` the digests of the files beside and below it, and
    one of itself."""
    for path in sorted(directory.rglob(RUN), key=lambda p: -len(p.parts)):
        files = sorted(p for p in path.parent.rglob("[!.]*") if p.is_file() and p != path)
        run = json.loads(path.read_text(encoding="utf-8"))
        run["files"] = {str(p.relative_to(path.parent)): _digest(p.read_bytes()) for p in files}
        run["digest"] = _of_run(run)
        path.write_text(json.dumps(run, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def unsealed(directory: Path) -> dict[str, Any]:
    """The content of a report's run.json, and that none of its files has changed.

    Raises ValueError with a sentence that names the file for what is no report, or no longer the
    one that was written.
    """
    path = directory / RUN
    if not path.is_file():
        raise ValueError(f"{directory} is not a report: it has no file {RUN}.")
    try:
        run: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        digest, files = run["digest"], dict(run["files"])
        run["command"], run["options"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{directory} is not a report of this version: {path}: {error}.") from None
    if digest != _of_run(run):
        raise ValueError(f"{path} is not as it was written; make the report again.")
    for name, known in files.items():
        file = directory / name
        if not file.is_file():
            raise ValueError(f"{file} is missing; make the report again.")
        if _digest(file.read_bytes()) != known:
            raise ValueError(f"{file} is not as it was written; make the report again.")
    return run


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()


def _of_run(run: dict[str, Any]) -> str:
    rest = {key: value for key, value in run.items() if key != "digest"}
    return _digest(json.dumps(rest, sort_keys=True).encode())
