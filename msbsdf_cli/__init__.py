"""Microfacet multiple-scattering BSDFs, put to the test on explicit surfaces."""

__version__ = "0.1.0"
