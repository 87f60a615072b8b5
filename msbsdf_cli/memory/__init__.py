"""A walk that remembers the last facet: the Gaussian surface ahead, given height and slope
there."""
