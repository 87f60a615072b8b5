"""A walk that remembers the last facet.

Smith takes heights at different points as independent. On a Gaussian surface those near a facet of
known height, slope and curvature are not, and all that follows from these is Gaussian:
`correlation` is what the facet says of the surface ahead, `hazard` the rate of crossings there,
`march` its integral along a ray, `escape` a table of that along whole rays, `way_in` what it says
of the way out that light came in, `facets`, `next_facet` and `entry` where light meets the surface
next and first, `walk` and `next_event` what becomes of it.

`profile` is the dearer way, `--memory 2` (`remembered`): it draws the heights that a ray passes one
after the other instead of asking how probable it is that it passes, and remembers the last of them.
"""
