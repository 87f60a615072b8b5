"""The list of identities, as a whole."""

from importlib import import_module
from pathlib import Path

from msbsdf_cli.validation import explicit
from msbsdf_cli.validation.suite import IDENTITIES


def test_every_identity_finds_some_fault():
    names = (f"validation.{path.stem}" for path in Path(__file__).parent.glob("test_*.py"))
    modules = [import_module(name) for name in names]
    guarded = {p[1] for module in modules for p in getattr(module, "PERTURBATIONS", ())}
    # On surfaces nothing is judged.
    assert {i.measure for i in IDENTITIES} - guarded == {explicit.on_surfaces}
