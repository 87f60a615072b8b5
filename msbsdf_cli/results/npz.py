"""Arrays and what is to be known of them in one .npz file, written whole or not at all."""

import json
import os
import secrets
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO
from zipfile import BadZipFile

import numpy as np
from numpy.lib.npyio import NpzFile

from msbsdf_cli import __version__
from surfaces.facet import Array


def write(path: str | Path, kind: str, about: dict[str, Any], arrays: dict[str, Any]) -> None:
    """Write arrays by name and `about`, which JSON can hold; a file that is there is replaced."""
    path = Path(path)
    text = json.dumps({"format": kind, "version": __version__} | about)
    draft = path.with_name(f".{path.name}-{secrets.token_hex(4)}")
    try:
        with open(draft, "xb") as file:
            np.savez_compressed(file, **arrays, about=np.array(text))
        os.replace(draft, path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def read(
    path: str | Path, kind: str, content: bytes | None = None
) -> tuple[dict[str, Any], dict[str, Array]]:
    """What `write` wrote under the name `kind`; `content` is that of the file, where it is at hand.
    Raises ValueError for any other file."""
    try:
        # Opened here, so that it is closed whatever NumPy makes of it.
        with _stream(path, content) as stream, _archive(stream) as file:
            about: dict[str, Any] = json.loads(str(file["about"]))
            arrays = {name: file[name] for name in file.files if name != "about"}
        if about["format"] != kind:
            raise ValueError(f"its format is {about['format']!r}")
    except (OSError, ValueError, KeyError, TypeError, EOFError, BadZipFile, zlib.error) as error:
        raise ValueError(f"{path} does not hold a {kind.rpartition(' ')[0]}: {error}.") from None
    return about, arrays


def _archive(stream: BinaryIO) -> NpzFile:
    """Of .npz files; raises ValueError for an array alone."""
    file = np.load(stream, allow_pickle=False)
    if not isinstance(file, NpzFile):
        raise ValueError("it is a single array")
    return file


def _stream(path: str | Path, content: bytes | None) -> BinaryIO:
    return open(path, "rb") if content is None else BytesIO(content)
