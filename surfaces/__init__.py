"""Explicit random surfaces, what light does on them, and the facets they share with the models."""
