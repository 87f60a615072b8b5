"""Scene files as nobody should write them: each is read, or refused in a sentence."""

import json
import string
import tempfile
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msbsdf_cli.experiments.recommend.scene_file import read_scene
from msbsdf_cli.experiments.recommend.scene_surface import SceneFileError

SCALARS = st.one_of(
    st.booleans(),
    st.integers(-(10**30), 10**30),
    st.floats(),
    st.sampled_from(["conductor", "dielectric", "diffuse", "ggx", "student-t", "gold", "", "x"]),
)
VALUES = st.recursive(SCALARS, lambda inner: st.lists(inner, max_size=3), max_leaves=4)
KEYS = st.sampled_from(
    (
        *("name", "material", "slopes", "gamma", "alpha", "alpha_x", "alpha_y", "metal", "eta_k"),
        *("albedo", "ior", "theta", "tolerance", "weight", "surface", "roughness", "other"),
    )
)
GOOD = {"name": "a", "material": "conductor", "alpha": 0.5}


def toml(value):
    """A value in TOML, which has JSON's scalars but for numbers that are not finite."""
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, float):
        return repr(value).replace("infinity", "inf")
    return json.dumps(value)


def read(text, suffix):
    """What a file with such a text is read as; None where it is refused, in a sentence."""
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / f"scene{suffix}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8", "replace"))
        try:
            return read_scene(path)
        except SceneFileError as refusal:
            words = str(refusal)
    assert words.endswith(".")
    assert "\n" not in words
    assert "Traceback" not in words
    return None


@settings(max_examples=250)
@given(st.dictionaries(KEYS, VALUES, max_size=6), st.dictionaries(KEYS, VALUES, max_size=2))
def test_tables_of_anything(entries, around):
    head = "".join(f"{key} = {toml(value)}\n" for key, value in around.items())
    body = "".join(f"{key} = {toml(value)}\n" for key, value in (GOOD | entries).items())
    scene = read(f"{head}[[surface]]\n{body}", ".toml")
    for surface in scene.surfaces if scene else ():
        assert all(s.alpha_x > 0 and s.alpha_y > 0 for s in surface.slopes)
        assert surface.theta


@settings(max_examples=200)
@given(st.one_of(st.binary(max_size=200), st.text(max_size=200)))
@pytest.mark.parametrize("suffix", [".toml", ".xml"])
def test_files_of_anything(suffix, content):
    assert read(content, suffix) is None


ATTRIBUTES = st.dictionaries(
    st.sampled_from(["type", "id", "name", "value", "filename"]),
    st.one_of(
        st.sampled_from(
            [
                "roughconductor",
                "roughdielectric",
                "principled",
                "metallic",
                "spec_trans",
                "base_color",
                "1",
                "twosided",
                "mask",
                "alpha",
                "alpha_u",
                "int_ior",
                "eta",
                "k",
                "material",
                "distribution",
                "ggx",
                "Au",
                "0.3",
                "nan",
                "-1",
                "1e999",
                "$a",
                "$",
                "0.1,0.2,0.3",
                "scene.xml",
                "..",
                "/",
            ]
        ),
        st.text(string.printable, max_size=5),
    ),
    max_size=3,
)
TAGS = st.sampled_from(
    (
        *("bsdf", "shape", "ref", "float", "rgb", "string", "spectrum", "texture", "default"),
        *("include", "scene", "integrator"),
    )
)


def element(tag, attributes, inner):
    clean = {k: "".join(c for c in v if c.isprintable()) for k, v in attributes.items()}
    words = "".join(f" {key}={quoteattr(value)}" for key, value in clean.items())
    return f"<{tag}{words}>{''.join(inner)}</{tag}>"


ELEMENTS = st.recursive(
    st.builds(element, TAGS, ATTRIBUTES, st.just([])),
    lambda inner: st.builds(element, TAGS, ATTRIBUTES, st.lists(inner, max_size=3)),
    max_leaves=12,
)


@settings(max_examples=250)
@given(st.lists(ELEMENTS, max_size=5))
def test_elements_of_anything(elements):
    scene = read(f"<scene>{''.join(elements)}</scene>", ".xml")
    for name, reason in scene.left_out if scene else ():
        assert isinstance(name, str)
        assert reason
