"""Tallies, distances between lobes, error bars and the tests that judge them."""
