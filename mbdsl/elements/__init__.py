"""The element kinds: one file each, discovered in this package.

A kind is a module of this package with a ``KIND``. ``kinds()`` maps the language's names to them.
"""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache
from types import ModuleType

from mbdsl.elements.kind import Kind


@cache
def modules() -> dict[str, ModuleType]:
    """Kind name -> the module that declares it."""
    found = {}
    for info in pkgutil.iter_modules(__path__):
        module = importlib.import_module(f"{__name__}.{info.name}")
        if isinstance(getattr(module, "KIND", None), Kind):
            found[module.KIND.name] = module
    return dict(sorted(found.items()))


def kinds() -> dict[str, Kind]:
    """Kind name -> declaration, by name."""
    return {name: module.KIND for name, module in modules().items()}
