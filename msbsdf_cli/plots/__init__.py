"""A figure each."""

FORMAT = "MSBSDF_PICTURES"
"""Environment variable that says what pictures are written as: processes that draw inherit it."""
