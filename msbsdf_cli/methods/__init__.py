"""The methods: a BSDF of given slopes and material, evaluated in one way or another.

`msbsdf_cli.methods` is this package and, called, the list of their names: a package that holds a
folder `methods` cannot have another thing of that name.
"""

import sys
from types import ModuleType


class _Named(ModuleType):
    def __call__(self) -> tuple[str, ...]:
        """Names of all methods."""
        from msbsdf_cli.methods.bound import methods

        return methods()


sys.modules[__name__].__class__ = _Named
