"""What run.json says of every run."""

import platform
import shlex
import subprocess
import sys
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path
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
    return {
        "command": command,
        "options": options,
        "seed": options.get("seed"),
        "versions": versions(),
        "commit": commit(),
        "processor": processor(),
        "command_line": shlex.join(["msbsdf", *sys.argv[1:]]),
        "started": started,
        "wall_s": wall_s,
        "rate_per_s": rate_per_s,
        "bounces_mean": bounces_mean,
        "warnings": warnings,
    }


def versions() -> dict[str, str]:
    """Of this program, of Python, and of the packages that numbers depend on."""
    return {"msbsdf": __version__, "python": platform.python_version()} | _packages()


@cache
def _packages() -> dict[str, str]:
    return {name: version(name) for name in PACKAGES}


@cache
def commit() -> str | None:
    """The commit that this program is at, where it is a checkout; with a `+` where it was changed
    since. Asked once: what runs is what was there when it was started."""
    root = Path(__file__).parents[2]
    if not (root / ".git").exists():
        return None
    git = ("git", "-C", str(root))
    try:
        head, changes = (
            subprocess.run([*git, *words], capture_output=True, text=True, check=True, timeout=10)
            for words in (("rev-parse", "HEAD"), ("status", "--porcelain", "--untracked-files=no"))
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return head.stdout.strip() + "+" * bool(changes.stdout)


def processor() -> str:
    """The processor's own name for itself, as far as the system knows it."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
