"""Scenes in files, by the name of the file."""

from pathlib import Path

from msbsdf_cli.experiments.recommend.mitsuba_scene import read_mitsuba
from msbsdf_cli.experiments.recommend.scene_surface import SceneFile
from msbsdf_cli.experiments.recommend.toml_scene import read_toml


def read_scene(path: str | Path) -> SceneFile:
    """The surfaces of a file, TOML, or XML of Mitsuba where its name says so. Raises SceneFileError
    for what is no scene."""
    path = Path(path)
    return read_mitsuba(path) if path.suffix.lower() == ".xml" else read_toml(path)
