"""Integration methods: one file each, found by looking, never listed.

A method is a module of this package with a ``METHOD``. ``methods()`` maps names to declarations.
"""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache
from types import ModuleType

from mbdsl.integrators.method import Method, Option, Run

__all__ = ["Method", "Option", "Run", "methods", "modules"]


@cache
def modules() -> dict[str, ModuleType]:
    """Method name -> the module that implements it."""
    found = {}
    for info in pkgutil.iter_modules(__path__):
        module = importlib.import_module(f"{__name__}.{info.name}")
        if isinstance(getattr(module, "METHOD", None), Method):
            found[module.METHOD.name] = module
    return dict(sorted(found.items()))


def methods() -> dict[str, Method]:
    """Method name -> declaration, by name, of those that can be chosen."""
    return {name: module.METHOD for name, module in modules().items() if module.METHOD.chosen}
