"""Whatever is typed, an option is a value in range or refused in a sentence."""

import math

import click
import pytest
from hypothesis import given
from hypothesis import strategies as st

from msbsdf_cli.cli.types import Angles, Count, Methods, Numbers, Real, Roughness

typed = st.one_of(
    st.text(max_size=12),
    st.floats(allow_nan=True).map(str),
    st.lists(st.floats(allow_nan=True), max_size=3).map(lambda x: ",".join(map(str, x))),
    st.floats().map(lambda x: f"{x}deg"),
    st.integers().map(str),
)
INCIDENT = Angles(0, math.nextafter(math.pi, 4), "to pi", but=math.pi / 2)
TYPES = [
    (Roughness(), lambda v: len(v) == 2 and all(0 < a < math.inf for a in v)),
    (Angles(0, math.pi / 2, "below"), lambda v: all(0 <= a < math.pi / 2 for a in v)),
    (INCIDENT, lambda v: all(0 <= a <= math.pi and a != math.pi / 2 for a in v)),
    (Count(), lambda v: isinstance(v, int) and v >= 1),
    (Count(4, even=True), lambda v: v >= 4 and v % 2 == 0),
    (Real(lambda x: 0 <= x <= 1, "from 0 to 1"), lambda v: 0 <= v <= 1),
    (Numbers(2, 0, 1), lambda v: len(v) == 2 and all(0 <= x <= 1 for x in v)),
    (Methods(), lambda v: len(v) > 0),
]


@pytest.mark.parametrize(("kind", "holds"), TYPES, ids=lambda x: type(x).__name__)
@given(typed)
def test_a_value_in_range_or_a_sentence(kind, holds, text):
    said = ""
    try:
        assert holds(kind.convert(text, None, None))
    except click.BadParameter as refusal:
        said = refusal.message
    assert len(said) < 200
    assert not said or said.endswith((".", "deg?"))
