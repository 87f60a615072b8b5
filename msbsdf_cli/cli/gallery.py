"""The gallery: which commands made which pictures of `reports/gallery`, and how to make them again.

The table of `reports/README.md` says the same, and a test holds it to this list.
"""

import json
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

PLACE = Path("reports/gallery")
MOST_BYTES = 8_000_000
"""Of all pictures and tables together."""
MADE = "made.json"
TERRAIN = "jacksboro_fault_dem.npz"
"""Of Matplotlib's sample data."""
KITCHEN = "recommend/kitchen.toml"


@dataclass(frozen=True)
class Folder:
    """A folder of the gallery."""

    name: str
    made_by: dict[str, tuple[str, ...]]
    """What is kept of the report of each command, without the directories within it."""
    needs: str | None = None
    """Another folder, whose reports the commands read."""

    @property
    def remade(self) -> bool:
        """Whether this program makes it, and no benchmark, which takes hours and reports of its
        own."""
        return all(command.startswith("msbsdf ") for command in self.made_by)


GALLERY = {
    folder.name: folder
    for folder in (
        Folder(
            "compare",
            {
                "msbsdf compare": (
                    *("agreement.csv", "agreement.png", "free_path.png", "lobes.png"),
                    *("lobes_theta_1.png", "simulate/surface.png"),
                )
            },
        ),
        Folder(
            "glass",
            {
                "msbsdf compare --material dielectric --alpha 1,0.1 --theta 0.5,1.5": (
                    *("agreement.csv", "lobes.png", "lobes_transmitted.png"),
                    "simulate/surface.png",
                )
            },
        ),
        Folder("diffuse", {"msbsdf compare --material diffuse --alpha 1": ("lobes.png",)}),
        Folder(
            "methods",
            {
                "msbsdf compare reports/compare-conductor-beckmann-0.5/simulate --method single,"
                "exact,position-free-uncorrelated,position-free-correlated,energy-compensated "
                "--out reports/methods": (*("agreement.csv", "methods.png"),)
            },
            needs="compare",
        ),
        Folder(
            "methods-glass",
            {
                "msbsdf compare --material dielectric --alpha 1,0.1 --theta 0.5,1.5 --method walk,"
                "single,position-free-uncorrelated,position-free-correlated": (
                    *("agreement.csv", "methods.png", "methods_transmitted.png"),
                )
            },
        ),
        Folder(
            "gold",
            {
                "msbsdf evaluate --method single,exact,solve,energy-compensated --metal gold --rgb "
                "--slopes ggx --alpha 0.8 --theta 0.5,1.2": ("slice.png",)
            },
        ),
        Folder("furnace", {"msbsdf furnace": ("furnace.png", "sphere.png")}),
        Folder(
            "furnace-gold",
            {
                "msbsdf furnace --method single,exact,solve,energy-compensated --metal gold --rgb "
                "--slopes ggx": ("furnace.png", "sphere.png")
            },
        ),
        Folder(
            "stability",
            {"msbsdf stability --full": ("published.png", "stability.png", "surfaces.png")},
        ),
        Folder("render", {"msbsdf render": ("render.csv", "render.png")}),
        Folder(
            "render-bottle",
            {"msbsdf render bottle --method single,walk,turquin": ("render.csv", "render.png")},
        ),
        Folder(
            "render-furnace",
            {
                "msbsdf render furnace --material dielectric --method single,walk,"
                "energy-compensated": ("render.csv", "render.png")
            },
        ),
        Folder("claims", {"msbsdf render --claims": ("claims.csv",)}),
        Folder(
            "recommend",
            {
                "msbsdf recommend": ("sheet.png",),
                "msbsdf recommend reports/gallery/recommend/kitchen.toml --against surfaces": (
                    *("recommendation.csv", "recommendation.png"),
                ),
            },
        ),
        Folder("validate", {"msbsdf validate": ("identities.png", "reciprocity.png")}),
        Folder(
            "surface",
            {
                "msbsdf compare --surface jacksboro_fault_dem.npz --step 92.6,74.2": (
                    *("parts.png", "roughness.csv", "surface.png"),
                )
            },
        ),
        Folder(
            "spectra",
            {
                "msbsdf compare --autocorrelation gaussian,exponential,matern:1.5,power-law:0.8 "
                "--alpha 0.7 --theta 0,0.5,1,1.2,80deg,1.5": ("spectra.png",)
            },
        ),
        Folder("tradeoff", {"msbsdf tradeoff": ("reach.csv", "tradeoff.png")}),
        Folder(
            "convergence",
            {
                "msbsdf simulate --alpha 1 --theta 0,1,1.5 --convergence": (
                    *("convergence.csv", "convergence.png"),
                )
            },
        ),
        Folder(
            "memory",
            {"python -m tests.benchmarks.memory REPORT...": ("memory.csv",)},
        ),
        Folder(
            "figures",
            {
                "msbsdf figures heitz-7 heitz-sequences wang-16": (
                    *("heitz_7.png", "heitz_sequences.png", "wang_16.png"),
                ),
                "msbsdf figures claims": ("claims.csv",),
            },
        ),
    )
}


def make(names: tuple[str, ...], place: Path) -> int:
    """Make these folders again, or all, in `place`; the bytes that all of it then has.

    Raises RuntimeError for a command that fails; folders made before it are there.
    """
    with tempfile.TemporaryDirectory() as directory:
        work = Path(directory)
        _bring_inputs(work, place)
        reports: dict[str, dict[str, Any]] = {}
        for name in names or (name for name, folder in GALLERY.items() if folder.remade):
            folder = GALLERY[name]
            needed = () if folder.needs is None else GALLERY[folder.needs].made_by
            for command in (*needed, *folder.made_by):
                if command not in reports:
                    click.echo(command, err=True)
                    reports[command] = _run(command, work)
            _keep(folder, reports, work, place / name)
    return sum(path.stat().st_size for path in place.rglob("*") if path.is_file())


def _bring_inputs(work: Path, place: Path) -> None:
    from matplotlib.cbook import get_sample_data

    kitchen = work / PLACE / KITCHEN
    kitchen.parent.mkdir(parents=True)
    if (place / KITCHEN).exists():
        kitchen.write_bytes((place / KITCHEN).read_bytes())
    path: Any = get_sample_data(TERRAIN, asfileobj=False)
    (work / TERRAIN).write_bytes(Path(path).read_bytes())


def _run(command: str, work: Path) -> dict[str, Any]:
    """What a command says with --json."""
    words = [sys.executable, "-m", "msbsdf_cli", *shlex.split(command)[1:], "--force", "--json"]
    done = subprocess.run(words, cwd=work, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise RuntimeError(f"`{command}` ended with status {done.returncode}.")
    return dict(json.loads(done.stdout))


def _keep(folder: Folder, reports: dict[str, dict[str, Any]], work: Path, to: Path) -> None:
    """Take over what is kept, and say what made it."""
    to.mkdir(parents=True, exist_ok=True)
    for command, files in folder.made_by.items():
        for name in files:
            (to / Path(name).name).write_bytes(_packed(work / reports[command]["report"] / name))
    last = reports[next(reversed(folder.made_by))]
    about = {"commands": list(folder.made_by), "version": last["versions"]["msbsdf"]}
    about |= {"commit": last["commit"], "started": last["started"]}
    (to / MADE).write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")


def _packed(path: Path) -> bytes:
    """A file as it is; a picture in fewer bytes, without loss: nothing in it is transparent."""
    if path.suffix != ".png":
        return path.read_bytes()
    from io import BytesIO

    from PIL import Image

    file = BytesIO()
    with Image.open(path) as image:
        image.convert("RGB").save(file, "PNG", optimize=True)
    return file.getvalue()
