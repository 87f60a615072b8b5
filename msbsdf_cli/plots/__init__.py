"""A figure each."""

FORMAT = "MSBSDF_PICTURES"
"""Environment variable that says what pictures are written as: processes that draw inherit it."""
PAGE_OF = "MSBSDF_PAGE_OF"
"""Likewise of the directory whose pictures go into its index.html."""
FOR_PAGE = ".page"
"""In the names of pictures that go into index.html and are no files of the report."""
