"""The element kinds: one file each, discovered in this package.

A file declares its kind for models in the plane as ``KIND``, for models in space as ``IN_SPACE``, or both, and is named
after it: RotationalStop is in ``rotational_stop.py``. ``kinds()`` maps the language's names to all kinds; ``find``
imports only the file of one kind.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
import sys
from functools import cache
from types import ModuleType

from mbdsl.elements.declaration import RIGID
from mbdsl.elements.kind import JointKind, Kind, PairKind

_found: dict[tuple[str, bool], Declared] = {}  #: (file, spatial) -> what it declares, of the files used so far


class Declared:
    """A kind with what its file has for it: kernels and ``motion``. In space, names that end with
    ``_in_space`` come first. Kernels that are made from rows are those of :mod:`mbdsl.system.row_kernels`."""

    def __init__(self, kind: Kind, file: ModuleType) -> None:
        self.KIND, self.file = kind, file
        self.name = kind.variant.partition("_of_")[0] or file.__name__.rpartition(".")[2]
        #: by which :func:`loaded` finds it
        self.__name__ = f"{_package(kind.spatial)}.{self.name}"

    def __getattr__(self, name: str):
        if self.KIND.spatial and hasattr(self.file, f"{name}_in_space"):
            return getattr(self.file, f"{name}_in_space")
        return getattr(self.file, name)

    @property
    def pair(self) -> PairKind:
        """The kind, of joints and forces."""
        assert isinstance(self.KIND, PairKind)
        return self.KIND

    @property
    def joint(self) -> JointKind:
        """The kind, of joints."""
        assert isinstance(self.KIND, JointKind)
        return self.KIND

    @property
    def made(self) -> bool:
        """Whether its kernels are made from its rows."""
        return (
            isinstance(self.KIND, PairKind) and bool(self.KIND.g) and not hasattr(self.file, f"gradient{self.suffix}")
        )

    @property
    def suffix(self) -> str:
        """What the names of its kernels end with."""
        return "_in_space" if self.KIND.spatial and hasattr(self.file, "gradient_in_space") else ""

    @property
    def curved(self) -> bool:
        """Whether it has second derivatives."""
        return self.pair.held.curved if self.made else getattr(self, "hessian", None) is not None


def _package(spatial: bool) -> str:
    return f"{__name__}.in_space" if spatial else __name__


@cache
def _declared(file: ModuleType, spatial: bool) -> Declared | None:
    """What a file declares; None if it declares nothing."""
    kind = getattr(file, "IN_SPACE" if spatial else "KIND", None)
    return Declared(kind, file) if isinstance(kind, Kind) else None


@cache
def modules(spatial: bool = False) -> dict[str, Declared]:
    """Kind name -> what its file declares, of models in the plane or in space."""
    files = [importlib.import_module(f"{__name__}.{info.name}") for info in pkgutil.iter_modules(__path__)]
    found = [x for file in files if (x := _declared(file, spatial)) is not None and not x.KIND.variant]
    return {x.KIND.name: x for x in sorted(found, key=lambda x: x.KIND.name)}


def kinds(spatial: bool = False) -> dict[str, Kind]:
    """Kind name -> declaration, by name."""
    return {name: found.KIND for name, found in modules(spatial).items()}


def find(name: str, spatial: bool = False) -> Kind | None:
    """The kind of this name; None if there is none."""
    found = _of_name(name, spatial)
    return None if found is None else found.KIND


def declaring(kind: Kind) -> Declared:
    """The kernels of a kind, and what else its file has for it."""
    if kind.variant:
        return of_variant(kind.variant, kind.spatial)
    found = _of_name(kind.name, kind.spatial)
    if found is None:
        raise LookupError(f"no file of mbdsl.elements declares the kind {kind.name}")
    return found


@cache
def of_variant(name: str, spatial: bool) -> Declared:
    """A variant of a kind: of its own file, for a number of features, or of a joint in space with its first rows in
    other axes."""
    if name.startswith(RIGID):
        from mbdsl.elements.rigid_contact import rigid

        base = of_variant(name.removeprefix(RIGID), spatial)
        return Declared(rigid(base.KIND, name), base.file)
    base = name.removesuffix("_in_axes")
    if base == name:
        from mbdsl.elements import sliding_friction

        if name in sliding_friction.MOTIONS:
            return Declared(sliding_friction.MOTIONS[name], sliding_friction)
        file = importlib.import_module(f"{__name__}.{name.partition('_of_')[0]}")
        if "_of_" in name:
            return Declared(file.of_count(*map(int, name.partition("_of_")[2].split("_"))), file)
        return Declared(file.IN_SPACE if spatial else file.KIND, file)
    found = loaded(f"{_package(True)}.{base}")
    return Declared(found.joint.in_axes(name), found.file)


def loaded(name: str) -> Declared:
    """What has this ``__name__``."""
    file, spatial = name.rpartition(".")[2], name.startswith(f"{_package(True)}.")
    found = _of_file(file, spatial)
    return of_variant(file, spatial) if found is None else found


def _of_name(name: str, spatial: bool = False) -> Declared | None:
    """The declaration of the kind of this name; None if there is none."""
    if not spatial and modules.cache_info().currsize:
        return modules().get(name)
    found = _of_file(file_of(name), spatial) if name.isidentifier() else None
    return found if found is not None and found.KIND.name == name and not found.KIND.variant else None


def _of_file(file: str, spatial: bool) -> Declared | None:
    """The declaration in the file of this name; None if there is none."""
    if (file, spatial) in _found:
        return _found[file, spatial]
    name, paths = f"{__name__}.{file}", [os.path.join(folder, f"{file}.py") for folder in __path__]
    if name not in sys.modules and not any(map(os.path.exists, paths)):
        return None
    found = _declared(importlib.import_module(name), spatial)
    return found if found is None else _found.setdefault((file, spatial), found)


def file_of(name: str) -> str:
    """Name of the file of a kind: RotationalStop -> rotational_stop."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()
