"""A solution that the machine has no room for is refused before any of it is made."""

import pytest

from msbsdf_cli.methods import solve
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.solver.size import needed_bytes
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.materials import Conductor, Dielectric

MEASURED = [
    (Conductor(), (0.05, 0.05), 0.066e9),
    (Conductor(), (0.02, 0.02), 0.25e9),
    (Conductor(), (1, 0.1), 0.33e9),
    (Dielectric(), (0.1, 0.1), 0.112e9),
    (Dielectric(), (0.05, 0.05), 0.34e9),
    (Dielectric(), (0.02, 0.02), 1.96e9),
    (Dielectric(), (1, 0.05), 1.47e9),
]
"""Peak memory of one evaluation."""


@pytest.mark.parametrize(("material", "alpha", "measured"), MEASURED)
def test_the_law_holds_where_it_was_measured(material, alpha, measured):
    assert 0.6 < needed_bytes(Beckmann(*alpha), material) / measured < 1.6


@pytest.mark.parametrize("alpha", [(1, 0.001), (1e-4, 1e-4), (1e4, 1e-6)])
@pytest.mark.parametrize("material", [Conductor(), Dielectric()], ids=lambda m: m.name)
def test_what_has_no_room_is_refused(material, alpha, monkeypatch):
    monkeypatch.setattr(solve, "memory_bytes", lambda: 64e9)
    with pytest.raises(UnsupportedError, match=r"needs about .* GB"):
        solve.Solve(Beckmann(*alpha), material, 4)
