"""Picking from tables."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from surfaces.facet import Array

Columns = Mapping[str, Any]
"""A table, or columns of it as arrays."""


def values(table: Columns, column: str) -> list[Any]:
    """The different values of a column, in the order of the table."""
    return list(dict.fromkeys(np.asarray(table[column]).tolist()))


def where(table: Columns, **wanted: Any) -> dict[str, Array]:
    """Columns as arrays (n,) of the rows in which columns have these values."""
    columns = {name: np.asarray(column) for name, column in table.items()}
    n = len(next(iter(columns.values())))
    keep = np.full(n, True)
    for name, value in wanted.items():
        keep &= columns[name] == value
    return {name: column[keep] for name, column in columns.items()}
