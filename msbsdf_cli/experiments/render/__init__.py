"""Small scenes whose surfaces are shaded by any method: geometry, lights, paths, pictures."""
