"""Speed against accuracy: the parts of `msbsdf tradeoff`."""
