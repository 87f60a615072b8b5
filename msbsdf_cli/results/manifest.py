"""What run.json says of every run."""

import platform
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

from msbsdf_cli import __version__

PACKAGES = ("numpy", "scipy", "embreex", "trimesh", "click", "matplotlib")


def now() -> str:
    """The time, UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def manifest(
    command: str,
    options: dict[str, Any],
    started: str,
    wall_s: float,
    rate_per_s: float,
    bounces_mean: float | None,
    warnings: list[str],
) -> dict[str, Any]:
    """The content of run.json that all commands share."""
    versions = {"msbsdf": __version__, "python": platform.python_version()}
    return {
        "command": command,
        "options": options,
        "seed": options.get("seed"),
        "versions": versions | {name: version(name) for name in PACKAGES},
        "started": started,
        "wall_s": wall_s,
        "rate_per_s": rate_per_s,
        "bounces_mean": bounces_mean,
        "warnings": warnings,
    }
