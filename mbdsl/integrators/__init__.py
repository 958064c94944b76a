"""Registry of integration methods: one file each, discovered in their packages; there is no list of them.

A compiled method is a module of :mod:`mbdsl.integrators.methods` with a ``METHOD`` and the kernels that
:mod:`mbdsl.integrators.method` lists. A method of that folder whose steps are not compiled, and a backend (a
third-party integrator), have a ``METHOD`` and a function ``solve``, see :mod:`mbdsl.integrators.backends`. A backend
is a module of :mod:`mbdsl.integrators.external`, or is passed to ``register``, or belongs to another distribution that
declares an entry point of the group "mbdsl.integrators":

    [project.entry-points."mbdsl.integrators"]
    name = "package.module"
"""

from __future__ import annotations

import importlib
import inspect
import os
import pkgutil
import re
from collections.abc import Iterator, MutableMapping
from functools import cache
from types import ModuleType
from typing import Any

from mbdsl.errors import UsageError
from mbdsl.integrators.method import KERNELS, OPTIONAL_KERNELS, STEP_KERNELS, Method, Option, Run
from mbdsl.messages import did_you_mean

__all__ = [
    "Method",
    "Option",
    "Run",
    "available",
    "backend",
    "compiled",
    "declared",
    "modules",
    "own",
    "problems",
    "register",
    "uncompiled",
]

GROUP = "mbdsl.integrators"
_given: dict[str, object] = {}  # backends passed to ``register``


def _found(package: str, path) -> dict[str, ModuleType]:
    found = {}
    for info in pkgutil.iter_modules(path):
        module = importlib.import_module(f"{package}.{info.name}")
        if isinstance(getattr(module, "METHOD", None), Method):
            found[module.METHOD.name] = module
    return {name: found[name] for name in sorted(found, key=_words_and_numbers)}


def _words_and_numbers(name: str) -> list[str | int]:
    """The parts of a name, by which radau5 comes before radau13."""
    return [int(part) if part.isdecimal() else part for part in re.split(r"([0-9]+)", name)]


def _solves(module: ModuleType) -> bool:
    """Whether a method has a function ``solve`` of its own, in place of kernels."""
    return getattr(getattr(module, "solve", None), "__module__", "") == module.__name__


class _Modules(MutableMapping[str, ModuleType]):
    """Method name -> module, by name.

    A lookup imports only the file with the name of the method, if there is one: importing all of them takes a sixth of
    the time of a short run.
    """

    def __init__(self) -> None:
        self._imported: dict[str, ModuleType] = {}
        self._complete = False

    def __getitem__(self, name: str) -> ModuleType:
        if name not in self._imported and not self._complete and not self._import(name):
            self._import_all()
        return self._imported[name]

    def __setitem__(self, name: str, module: ModuleType) -> None:
        self._import_all()
        self._imported[name] = module

    def __delitem__(self, name: str) -> None:
        self._import_all()
        del self._imported[name]

    def __iter__(self) -> Iterator[str]:
        self._import_all()
        return iter(self._imported)

    def __len__(self) -> int:
        self._import_all()
        return len(self._imported)

    def _import(self, name: str) -> bool:
        """Whether the file of this name declares the method of this name."""
        from mbdsl.integrators import methods

        file = name.replace("-", "_")
        there = (os.path.exists(os.path.join(folder, f"{file}.py")) for folder in methods.__path__)
        if not (file.isidentifier() and any(there)):
            return False
        module = importlib.import_module(f"{methods.__name__}.{file}")
        method = getattr(module, "METHOD", None)
        if not (isinstance(method, Method) and method.name == name) or _solves(module):
            return False
        _check_kernels(name, module)
        self._imported[name] = module
        return True

    def _import_all(self) -> None:
        from mbdsl.integrators import methods

        if self._complete:
            return
        every = _found(methods.__name__, methods.__path__)
        found = {name: module for name, module in every.items() if not _solves(module)}
        for name in found.keys() - self._imported.keys():
            _check_kernels(name, found[name])
        self._imported, self._complete = found, True


@cache
def modules() -> MutableMapping[str, ModuleType]:
    """Method name -> module, for all compiled methods."""
    return _Modules()


def _check_kernels(name: str, module: ModuleType) -> None:
    """Check that a compiled method has its kernels, with their parameters."""
    required = STEP_KERNELS if hasattr(module, "take") else KERNELS
    for kernel, parameters in (required | OPTIONAL_KERNELS).items():
        function = getattr(module, kernel, None)
        if function is None:
            if kernel in required:
                raise UsageError(
                    f"method {name} has no kernel {kernel}({parameters})", hint=f"add it to {module.__file__}"
                )
        elif not hasattr(function, "__mbdsl_kernel__"):
            raise UsageError(f"{kernel} of method {name} is not marked as a kernel", hint=f"see {module.__file__}")
        elif (has := ", ".join(inspect.signature(function).parameters)) != parameters:
            wrong = f"the kernel {kernel} of method {name} takes ({has}), expected ({parameters})"
            raise UsageError(wrong, hint=f"see {module.__file__}")


@cache
def uncompiled() -> dict[str, ModuleType]:
    """Method name -> module, for mbdsl's own methods whose steps are not compiled."""
    from mbdsl.integrators import methods

    every = _found(methods.__name__, methods.__path__)
    return {name: module for name, module in every.items() if _solves(module)}


@cache
def shipped_backends() -> dict[str, ModuleType]:
    """Method name -> module, for the backends of this package; a backend imports its library only when it runs."""
    from mbdsl.integrators import external

    return _found(external.__name__, external.__path__)


@cache
def _registered() -> tuple[dict[str, object], dict[str, str]]:
    """Backends of other distributions by name, and reasons why other entry points are unusable; the search is slow."""
    from importlib.metadata import entry_points

    found: dict[str, object] = {}
    wrong: dict[str, str] = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        source = point.dist.name if point.dist is not None else point.value
        try:
            problem = _misfit(point.name, backend := point.load())
            if problem is None:
                found[point.name] = backend
                continue
        except Exception as error:  # any error in the code of another package
            problem = f"{type(error).__name__}: {error}"
        if found.get(point.name) is None:  # a distribution may be listed twice
            wrong[f"{point.name} (of {source})"] = problem
    return found, wrong


def _misfit(name: str, backend: object) -> str | None:
    """The reason why an object is not a backend of this name, or None."""
    method = getattr(backend, "METHOD", None)
    if not isinstance(method, Method) or not callable(getattr(backend, "solve", None)):
        return "it has no METHOD (an mbdsl.integrators.Method), or no function solve"
    if method.name != name:
        return f"the name in its METHOD is {method.name}"
    return "there is already a method of that name" if name in modules() or name in _with_solve() else None


def _with_solve() -> dict[str, ModuleType]:
    return {**uncompiled(), **shipped_backends()}


def backend(name: str) -> Any:
    """The method of this name with a function ``solve``; None if there is none."""
    if name in modules():
        return None
    return _given.get(name) or _with_solve().get(name) or _registered()[0].get(name)


def register(backend: object) -> None:
    """Register a third-party integrator in this process, by the name in its ``METHOD``.

    It replaces an integrator registered by the same name before.

    Parameters
    ----------
    backend : object
        A module or object with ``METHOD`` (a ``Method``) and a function ``solve``.

    Raises
    ------
    UsageError
        If it lacks ``METHOD`` or ``solve``, or another method has the same name.
    """
    name = getattr(getattr(backend, "METHOD", None), "name", "")
    if (problem := _misfit(name, backend)) is not None:
        raise UsageError(f"{backend!r} is not a backend: {problem}")
    _given[name] = backend


def compiled() -> dict[str, Method]:
    """Method name -> declaration, for the compiled methods that users can choose."""
    return {name: module.METHOD for name, module in modules().items() if module.METHOD.chosen}


def own() -> dict[str, Method]:
    """Method name -> declaration, for mbdsl's own methods that users can choose."""
    return {**compiled(), **{name: module.METHOD for name, module in uncompiled().items()}}


def available(spatial: bool = False) -> dict[str, Method]:
    """List the integration methods that can be chosen.

    Parameters
    ----------
    spatial : bool
        Only those that serve models in space.

    Returns
    -------
    dict
        Name -> ``Method``, mbdsl's own methods first, then third-party integrators.
    """
    others: dict[str, Any] = {**_with_solve(), **_registered()[0], **_given}
    found: dict[str, Method] = {name: each.METHOD for name, each in others.items()}
    return {**compiled(), **{name: method for name, method in found.items() if method.spatial or not spatial}}


def problems() -> dict[str, str]:
    """Unusable entry point -> the reason."""
    return _registered()[1]


def declared(name: str) -> Method:
    """The declaration of a method.

    Raises
    ------
    UsageError
        If no method has this name.
    """
    if not isinstance(name, str):
        raise UsageError(f"method: found {name!r}, expected the name of a method", hint=", ".join(available()))
    found = modules().get(name) or backend(name)
    if found is None:
        wrong = [f"{who}: {why}" for who, why in problems().items() if who.startswith(f"{name} (")]
        hint = "; ".join(wrong) or did_you_mean(name, available(), "methods")
        if name.lower().endswith(".py"):
            hint = f"a model cannot load a Python file: mbdsl simulate MODEL --method {name}"
        raise UsageError(f"there is no method `{name}`", hint=hint)
    return found.METHOD
