"""The ways to evaluate a Smith microfacet BSDF, one file each, behind `protocol.Method`."""
