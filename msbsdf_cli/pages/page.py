"""`index.html`: one page with a report's sentence, pictures, tables, settings and how to repeat it.

Nothing in it comes from elsewhere: pictures are inside, styles and the few lines of script too.
"""

import csv
import json
import math
from base64 import b64encode
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, Template, select_autoescape

from msbsdf_cli.pages.captions import CAPTIONS
from msbsdf_cli.pages.citations import papers
from msbsdf_cli.plots import FOR_PAGE
from msbsdf_cli.results.seal import RUN

PAGE = "index.html"

SVG_BYTES = 700_000
"""Of all pictures of lines together; where there are more, the last ones are bitmaps."""
PICTURES_BYTES = 1_100_000
"""Of all pictures together: written as text they are a third more, and a page is below 2 MB."""

BITMAP = b"<image"
"""In an SVG of a dense map."""

ROWS = 40
"""Of a table; the rest is in its file."""
ALL_ROWS = 600
"""Of all tables, where there are many."""

OWN = "files", "digest", "summary", "warnings", "options", "versions"
"""Parts of run.json that have a place of their own in the page, or none."""


@dataclass(frozen=True)
class Picture:
    """A picture within the page."""

    name: str
    source: str
    words: str


@dataclass(frozen=True)
class TableOfPage:
    """The first rows of a table."""

    name: str
    header: list[str]
    rows: list[list[str]]
    more: int


def write_page(directory: Path) -> None:
    """Write the page of a report that is otherwise complete."""
    record = json.loads((directory / RUN).read_text(encoding="utf-8"))
    pictures, slides = _pictures(directory)
    content = _template().render(
        command=record["command"],
        summary=_sentences(record.get("summary")),
        record=record,
        warnings=record["warnings"],
        pictures=pictures,
        slides=slides,
        tables=_tables(directory),
        options=_words(record["options"]),
        figures=_words({k: v for k, v in record.items() if k not in OWN}),
        versions=record["versions"],
        papers=papers(record["command"], record["options"]),
    )
    (directory / PAGE).write_text(content, encoding="utf-8")


@cache
def _template() -> Template:
    """The page, compiled once for all the reports of a sweep or a gallery."""
    loader = PackageLoader("msbsdf_cli.pages", "")
    environment = Environment(loader=loader, autoescape=select_autoescape(), trim_blocks=True)
    return environment.get_template("report.html")


def _sentences(summary: Any) -> list[str]:
    if isinstance(summary, list):
        return [str(sentence) for sentence in summary]
    return str(summary).splitlines() if summary else []


def _words(values: dict[str, Any]) -> dict[str, str]:
    """Settings as text; what is not set is left out."""
    found = {}
    for name, value in values.items():
        if value is None or isinstance(value, dict) or value == []:
            continue
        text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
        found[name] = text if len(text) < 400 else f"{text[:397]}..."
    return found


def _pictures(directory: Path) -> tuple[list[Picture], list[Picture]]:
    """The pictures of the report, and those of single angles, which a slider turns over: lines as
    SVG and what is left as PNG, which can be packed."""
    files: dict[str, dict[str, Path]] = {}
    names: dict[str, str] = {}
    for path in directory.iterdir():
        if path.suffix in (".png", ".svg", ".pdf"):
            stem = path.stem.removesuffix(FOR_PAGE)
            files.setdefault(stem, {})[path.suffix] = path
            if stem == path.stem:
                names[stem] = path.name
    paths, room = {}, SVG_BYTES
    for stem in sorted(files, key=lambda stem: (_place(stem), stem)):
        svg = files[stem].get(".svg")
        drawn = svg.read_bytes() if svg else b""
        paths[stem] = files[stem][".png"]
        if svg and BITMAP not in drawn and len(drawn) <= room:
            paths[stem], room = svg, room - len(drawn)
    bitmaps = sum(p.stat().st_size for p in paths.values() if p.suffix == ".png")
    scale = (PICTURES_BYTES - SVG_BYTES + room) / max(bitmaps, 1)
    all_ = [
        Picture(names[stem], _source(path, scale), CAPTIONS.get(_kind(stem), ""))
        for stem, path in paths.items()
    ]
    slides = [picture for picture in all_ if _kind(Path(picture.name).stem) == SLIDES]
    for path in directory.glob(f"*{FOR_PAGE}.*"):
        path.unlink()
    return [p for p in all_ if p not in slides], slides


SLIDES = "lobes_theta"


def _kind(stem: str) -> str:
    return SLIDES if stem.startswith(SLIDES) else stem


def _place(stem: str) -> int:
    names = list(CAPTIONS)
    return names.index(_kind(stem)) if _kind(stem) in names else len(names)


def _source(path: Path, scale: float) -> str:
    """A picture as text: as it is, or, where all together are too large, packed tighter."""
    content, kind = path.read_bytes(), {".png": "png", ".svg": "svg+xml"}[path.suffix]
    if scale < 1 and kind == "png":
        content, kind = _packed(path, int(len(content) * scale)), "webp"
    return f"data:image/{kind};base64,{b64encode(content).decode()}"


def _packed(path: Path, size: int) -> bytes:
    """A picture in at most about `size` bytes: all colours are kept, fine detail gives way, and
    where that is not enough, the picture shrinks."""
    from PIL import Image

    with Image.open(path) as image:
        picture = image.convert("RGB")
    for quality in (90, 75, 60):
        file = BytesIO()
        picture.save(file, "WEBP", quality=quality, method=2)
        if file.tell() <= size:
            return file.getvalue()
    side = math.sqrt(size / file.tell())
    shape = [max(round(pixels * side), 1) for pixels in picture.size]
    picture.resize((shape[0], shape[1])).save(file := BytesIO(), "WEBP", quality=quality, method=2)
    return file.getvalue()


def _tables(directory: Path) -> list[TableOfPage]:
    paths = sorted(directory.rglob("*.csv"))
    rows = min(ROWS, ALL_ROWS // max(len(paths), 1))
    return [_table(path, directory, rows) for path in paths]


def _table(path: Path, directory: Path, most: int) -> TableOfPage:
    """A table's first rows, its angles in degrees."""
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.reader(file)
        header = next(reader, [])
        rows = [[*map(_cell, header, row)] for row in islice(reader, most)]
    with open(path, "rb") as lines:
        more = sum(1 for _ in lines) - 1 - len(rows)
    names = [f"{n.removesuffix('_rad')} [degrees]" if n.endswith("_rad") else n for n in header]
    return TableOfPage(str(path.relative_to(directory)), names, rows, more)


def _cell(name: str, text: str) -> str:
    try:
        number = float(text)
    except ValueError:
        return text
    if name.endswith("_rad"):
        number = math.degrees(number)
    return f"{number:.5g}"
