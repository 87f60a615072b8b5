"""The rough surfaces of a Mitsuba 3 scene in XML: files, variables, references and wrappers."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from msbsdf_cli.experiments.recommend.mitsuba_bsdf import Entries, LeftOutError, surface
from msbsdf_cli.experiments.recommend.scene_surface import MOST_BYTES, SceneFile, SceneFileError

AROUND = ("twosided", "mask", "bumpmap", "normalmap")
"""Plugins that wrap another surface, whose roughness they leave as it is."""

MOST_FILES = 64
"""Files that a scene may include."""


@dataclass
class _Reader:
    """Files read so far, and the values of variables."""

    root: Path
    files: int = 0
    variables: dict[str, str] = field(default_factory=dict)

    def elements(self, path: Path) -> Iterator[ElementTree.Element]:
        """Elements of the scene in a file, those of included files in their place."""
        self.files += 1
        if self.files > MOST_FILES:
            raise SceneFileError(f"{path}: more than {MOST_FILES} files are included.")
        for element in _parsed(path):
            if element.tag == "default":
                self.variables.setdefault(element.get("name", ""), element.get("value", ""))
            elif element.tag == "include":
                wanted = (path.parent / self.value(element, "filename")).resolve()
                if not wanted.is_relative_to(self.root):
                    raise SceneFileError(f"{path}: {wanted.name} lies outside of {self.root}.")
                yield from self.elements(wanted)
            else:
                yield element

    def value(self, element: ElementTree.Element, name: str = "value") -> str:
        """An attribute, with the values of variables put in."""

        def known(match: re.Match[str]) -> str:
            if match[1] not in self.variables:
                raise SceneFileError(f"${match[1]} has no value and no default.")
            return self.variables[match[1]]

        return re.sub(r"\$(\w+)", known, element.get(name, ""))


def read_mitsuba(path: str | Path) -> SceneFile:
    """The rough surfaces of a scene, and what cannot be judged. Raises SceneFileError for what is
    no scene."""
    path = Path(path)
    reader = _Reader(path.resolve().parent)
    named: dict[str, ElementTree.Element] = {}
    used: list[tuple[str, ElementTree.Element]] = []
    for element in reader.elements(path):
        if element.tag == "bsdf":
            name = reader.value(element, "id") or f"surface {len(used) + 1}"
            named[name] = element
            used.append((name, element))
        for shape in element.iter("shape") if element.tag == "shape" else ():
            for inner in shape.iterfind("bsdf"):
                used.append((reader.value(shape, "id") or f"shape {len(used) + 1}", inner))
    scene = SceneFile()
    for name, element in used:
        try:
            inner = _unwrapped(reader, element, named)
            kind = reader.value(inner, "type")
            found, notes = surface(name, kind, Entries(inner, reader.value))
            scene.surfaces.append(found)
            scene.notes += [f"{name} {note}." for note in notes]
        except LeftOutError as reason:
            scene.left_out.append((name, str(reason)))
    if not used:
        raise SceneFileError(f"{path} has no bsdf.")
    return scene


def _parsed(path: Path) -> ElementTree.Element:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise SceneFileError(f"{path} is larger than {MOST_BYTES} bytes.")
        text = path.read_text("utf-8")
        # What entities could be made to do, no scene needs.
        if re.search(r"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
            raise SceneFileError(f"{path} declares a document type: no scene needs one.")
        root = ElementTree.fromstring(text)
    except OSError as error:
        raise SceneFileError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (ElementTree.ParseError, UnicodeDecodeError, RecursionError) as error:
        raise SceneFileError(f"{path} is not XML: {error}.") from None
    if root.tag != "scene":
        raise SceneFileError(f"{path} is no Mitsuba scene: it starts with <{root.tag[:40]}>.")
    return root


def _unwrapped(
    reader: _Reader, element: ElementTree.Element, named: dict[str, ElementTree.Element]
) -> ElementTree.Element:
    """The surface inside of others that leave its roughness alone."""
    seen: set[int] = set()
    while reader.value(element, "type") in AROUND:
        if id(element) in seen:
            raise LeftOutError("it refers to itself")
        seen.add(id(element))
        kind, inside = reader.value(element, "type"), list(element.iterfind("bsdf"))
        inside += [
            named[name]
            for ref in element.iterfind("ref")
            if (name := reader.value(ref, "id")) in named
        ]
        if not inside:
            raise LeftOutError(f"its {kind} holds no surface that is known here")
        element = inside[0]
    return element
