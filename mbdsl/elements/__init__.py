"""The element kinds: one file each, discovered in this package.

A kind is a module of this package with a ``KIND``, and the file is named after it: RotationalStop is in
``rotational_stop.py``. ``kinds()`` maps the language's names to all kinds; ``find`` imports only the file of one kind.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
from functools import cache
from types import ModuleType

from mbdsl.elements.kind import Kind

_imported: dict[tuple[str, bool], ModuleType] = {}  #: (kind name, spatial) -> its module, of the kinds used so far
_SPACE = os.path.join(__path__[0], "in_space")


@cache
def modules(spatial: bool = False) -> dict[str, ModuleType]:
    """Kind name -> the module that declares it, of models in the plane or in space."""
    found = {}
    for info in pkgutil.iter_modules([_SPACE] if spatial else __path__):
        module = importlib.import_module(f"{_package(spatial)}.{info.name}")
        if isinstance(getattr(module, "KIND", None), Kind) and not module.KIND.variant:
            found[module.KIND.name] = module
    return dict(sorted(found.items()))


def _package(spatial: bool) -> str:
    return f"{__name__}.in_space" if spatial else __name__


def kinds(spatial: bool = False) -> dict[str, Kind]:
    """Kind name -> declaration, by name."""
    return {name: module.KIND for name, module in modules(spatial).items()}


def find(name: str, spatial: bool = False) -> Kind | None:
    """The kind of this name; None if there is none."""
    module = _module_of(name, spatial)
    return None if module is None else module.KIND


def declaring(kind: Kind) -> ModuleType:
    """The module of a kind, with its kernels."""
    if kind.variant:
        return of_variant(kind.variant)
    module = _module_of(kind.name, kind.spatial)
    if module is None:
        raise LookupError(f"no file of mbdsl.elements declares the kind {kind.name}")
    return module


def of_variant(file: str) -> ModuleType:
    """The module of a variant of a kind in space."""
    return importlib.import_module(f"{_package(True)}.{file}")


def _module_of(name: str, spatial: bool = False) -> ModuleType | None:
    """The module that declares the kind of this name; None if there is none."""
    if not spatial and modules.cache_info().currsize:
        return modules().get(name)
    if (name, spatial) in _imported:
        return _imported[name, spatial]
    file, folders = file_of(name), [_SPACE] if spatial else __path__
    if not (name.isidentifier() and any(os.path.exists(os.path.join(folder, f"{file}.py")) for folder in folders)):
        return None
    module = importlib.import_module(f"{_package(spatial)}.{file}")
    declared = getattr(module, "KIND", None)
    if not (isinstance(declared, Kind) and declared.name == name):
        return None
    return _imported.setdefault((name, spatial), module)


def file_of(name: str) -> str:
    """Name of the file of a kind: RotationalStop -> rotational_stop."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()
