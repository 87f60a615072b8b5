"""A figure each."""

FORMAT = "MSBSDF_PICTURES"
"""Environment variable that says what pictures are written as: processes that draw inherit it."""
FOR_PAGE = ".page"
"""In the names of pictures that go into index.html and are no files of the report."""
