"""Finished pieces of long work, kept until the whole is written, so that nothing is done twice."""

import json
import os
import shutil
from hashlib import sha256
from pathlib import Path
from typing import Any

Rows = list[dict[str, Any]]


class Pieces:
    """A directory of pieces beside the place of a report, `OUT.pieces`; each is written under
    another name and renamed. Pieces made by other `settings` are not taken up."""

    def __init__(self, out: Path, settings: dict[str, Any]) -> None:
        real = out.resolve()
        self.directory = real.with_name(f"{real.name}.pieces")
        self.settings = json.loads(json.dumps(settings))

    def done(self) -> dict[str, Rows]:
        """The pieces that are there, by name."""
        found = {}
        for path in sorted(self.directory.glob("*.json")):
            try:
                piece = json.loads(path.read_text(encoding="utf-8"))
                if piece["settings"] == self.settings:
                    found[str(piece["name"])] = list(piece["rows"])
            except (OSError, ValueError, KeyError, TypeError):
                continue
        return found

    def keep(self, name: str, rows: Rows) -> None:
        """Write a piece, whole or not at all."""
        self.directory.mkdir(parents=True, exist_ok=True)
        path = self.directory / f"{sha256(name.encode()).hexdigest()[:24]}.json"
        draft = path.with_suffix(f".{os.getpid()}.draft")
        piece = {"settings": self.settings, "name": name, "rows": rows}
        draft.write_text(json.dumps(piece), encoding="utf-8")
        os.replace(draft, path)

    def remove(self) -> None:
        """Once the whole is written, the pieces are of no use."""
        shutil.rmtree(self.directory, ignore_errors=True)
