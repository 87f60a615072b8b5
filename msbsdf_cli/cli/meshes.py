"""The file that a surface is saved to as a mesh, and the memory that a mesh takes."""

from pathlib import Path
from typing import Any

import click

BYTES_PER_CELL = 600
"""Of a surface, its mesh and Embree's scene of it."""


def refuse_mesh(options: dict[str, Any]) -> None:
    """Refuse a mesh file that cannot be written. Raises click.BadParameter."""
    if options["save_mesh"] is None:
        return
    path = Path(options["save_mesh"])
    formats = ("ply", "obj", "stl", "off", "glb")
    if path.suffix.lower().removeprefix(".") not in formats:
        raise click.BadParameter(
            f"{path}: a mesh is written as one of .{', .'.join(formats)}.", param_hint="--save-mesh"
        )
    if options.get("surface") and path.resolve() == Path(options["surface"]).resolve():
        raise click.BadParameter(
            f"{path} is the surface that is read; name another file.", param_hint="--save-mesh"
        )
    if path.exists() and not options["force"]:
        raise click.BadParameter(
            f"{path} is already there; name another file, or replace it with --force.",
            param_hint="--save-mesh",
        )
    if not path.absolute().parent.is_dir():
        raise click.BadParameter(f"{path}: there is no such directory.", param_hint="--save-mesh")


def write_mesh(path: Path, mesh: Any) -> None:
    """Write a mesh, whole or not at all, in the format that the file's name ends in."""
    import os
    import tempfile

    with tempfile.TemporaryDirectory(prefix=f".{path.stem}-", dir=path.absolute().parent) as draft:
        file = Path(draft) / path.name
        mesh.export(file)
        os.replace(file, path)
