"""The sources of machine code: the modules that define kernels, or constants that kernels read, and their digest.

They are found by following the imports in the source of each module, into the modules of users, too: a kernel of a user
may call kernels of another file and read its constants.
"""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from itertools import accumulate
from numbers import Number
from pathlib import Path
from types import ModuleType
from typing import Any

from mbdsl.compilation.kernel_types import Untranslatable
from mbdsl.errors import Span
from mbdsl.kernels import marks

#: names of emitted modules, which have no source file
emitted: set[str] = set()
#: packages whose modules define kernels, or constants that kernels read
_ROOMS = tuple(f"mbdsl.{room}." for room in ("bodies", "elements", "integrators", "kernels", "numerics", "system"))
#: modules that element and method files import for their declarations; no kernel reads them
_DECLARATIONS = ("mbdsl.elements.kind", "mbdsl.integrators.method")
#: modules that write code, which is compiled too: the loops, and the kernels of rows
_WRITERS = (
    *("mbdsl.system.emit", "mbdsl.system.row_kernels", "mbdsl.elements.row", "mbdsl.elements.row_derivatives"),
    *("mbdsl.expressions.formulas", "mbdsl.expressions.spatial_coordinates", "mbdsl.expressions.symbolic"),
    "mbdsl.expressions.derivatives",
)
#: packages whose versions are part of the name of the cache's subfolder, or which kernels cannot use
_LIBRARIES = ("numpy", "scipy", "llvmlite")
#: folders of installed packages
_INSTALLED = ("site-packages", "dist-packages")

#: packages whose versions or sources are part of the digest of the compiler, or of that of kernels
_VERSIONED = {"mbdsl", "numpy", *sys.stdlib_module_names}


def with_imports(modules: tuple[ModuleType, ...]) -> list[ModuleType]:
    """``modules`` and all modules that define the kernels in them.

    Emitted modules contain no kernels of other modules, but those modules.
    """
    found = dict.fromkeys(modules)
    pending = list(found)
    while pending:
        of = pending.pop()
        for value in vars(of).values():
            if getattr(value, "__mbdsl_kernel__", False):
                module = sys.modules[value.__module__]
            elif isinstance(value, ModuleType) and of.__name__ in emitted:
                module = value
            else:
                continue
            if module not in found:
                found[module] = None
                pending.append(module)
    return sorted(found, key=lambda module: module.__name__)


def names_of(modules: Iterable[ModuleType]) -> list[str]:
    """Names of the modules that define the kernels, or constants that the kernels read, directly or not."""
    found = set(_WRITERS)
    pending = [module.__name__ for module in modules]
    looked_at = set(_DECLARATIONS)
    while pending:
        name = pending.pop()
        path = None if name in looked_at else file_of(name)
        looked_at.add(name)
        if path is None:
            continue
        found.add(name)
        try:
            text = path.read_bytes()
        except OSError:  # a module in an archive; without a digest, its machine code is not used again
            continue
        if b"mbdsl" in text or not set(_INSTALLED) & set(path.parts):
            pending += imported_kernels(text, getattr(sys.modules.get(name), "__package__", None) or "")
    return sorted(found)


def imported_kernels(text: str | bytes, package: str = "") -> Iterator[str]:
    """Names in the imports at module level of a source that may be modules with kernels, or constants for kernels.

    A name imported from a package may be a module. ``package`` is that of the source, for relative imports.
    """
    pending: list[ast.AST] = [*ast.parse(text).body]
    while pending:
        node = pending.pop()
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            of = package.rsplit(".", node.level - 1)[0] if node.level else ""
            of = ".".join(filter(None, (of, node.module)))
            names = [of, *(f"{of}.{alias.name}" for alias in node.names)]
        elif isinstance(node, (ast.If, ast.Try, ast.ExceptHandler, ast.With)):
            pending += ast.iter_child_nodes(node)
        for name in filter(_is_read, names):
            yield from filter(_is_read, accumulate(name.split("."), "{}.{}".format))  # packages are modules, too


def _is_read(name: str) -> bool:
    """Whether kernels may read the content of a module."""
    package = name.partition(".")[0]
    if package == "mbdsl":
        return name.startswith(_ROOMS)
    return package not in _LIBRARIES and package not in sys.stdlib_module_names


def file_of(name: str) -> Path | None:
    """The file of a module; None for packages of mbdsl, emitted modules, and modules without a file."""
    if name.startswith("mbdsl."):
        path = Path(__file__).parents[1].joinpath(*name.split(".")[1:]).with_suffix(".py")
        if path.exists():
            return path
    file = getattr(sys.modules.get(name), "__file__", None)
    if file is None or name in emitted or (name.startswith("mbdsl.") and Path(file).name == "__init__.py"):
        return None
    return Path(file)


def digest_of(names: Iterable[str]) -> str | None:
    """Digest of the sources of modules, and of the constants in those of users; None if a source is missing."""
    digest = hashlib.sha256()
    for name in names:
        path = file_of(name)
        try:
            text = path.read_bytes() if path is not None else None
        except OSError:
            text = None
        if text is None:
            return None
        digest.update(name.encode() + text)
        if not name.startswith("mbdsl.") and name in sys.modules:
            digest.update(repr(list(_constants(sys.modules[name]))).encode())
    return digest.hexdigest()


def _constants(module: ModuleType) -> Iterator[tuple]:
    """Numbers, also in tuples and arrays, that kernels of a module may read by a name, or as attributes of a module:
    their values may come from other files, and machine code contains them."""
    for name, value in sorted(vars(module).items()):
        if isinstance(value, ModuleType) and value.__name__.partition(".")[0] not in _VERSIONED:
            yield from ((name, x, found) for x, y in sorted(vars(value).items()) if (found := _numbers(y)))
        elif found := _numbers(value):
            yield name, found


def _numbers(value: object) -> list:
    if isinstance(value, tuple):
        return [x for item in value for x in _numbers(item)]
    if isinstance(value, Number):
        return [repr(value)]
    return [value.tobytes()] if hasattr(value, "tobytes") and not isinstance(value, type) else []


def syntax_tree(function: Callable) -> ast.FunctionDef:
    """The definition of a function. A module may define several functions of one name.

    Raises
    ------
    Untranslatable
        If the function is not defined at the level of its module, as one that reads variables of another function.
    """
    found = _functions_of(sys.modules[function.__module__]).get(function.__code__.co_firstlineno)
    if found is None or found.name != function.__code__.co_name:
        raise Untranslatable(f"`{function.__name__}` is not defined at the level of its module")
    return found


@cache
def _functions_of(module: ModuleType) -> dict[int, ast.FunctionDef]:
    """The functions of a module by their first line, which may be that of a decorator."""
    functions = [node for node in ast.parse(_text_of(module)).body if isinstance(node, ast.FunctionDef)]
    return {min([node.lineno, *(x.lineno for x in node.decorator_list)]): node for node in functions}


def place_of(function: Callable, node: Any) -> Span:
    """The place of a part of a kernel in its file."""
    module = sys.modules[function.__module__]
    line, column = getattr(node, "lineno", 1), getattr(node, "col_offset", 0)
    text = _text_of(module).splitlines()[line - 1]
    end = node.end_col_offset if getattr(node, "end_lineno", None) == line else len(text)
    return Span(str(module.__file__), line, column + 1, end - column, text)


def _text_of(module: ModuleType) -> str:
    return vars(module).get(marks.TEXT) or Path(str(module.__file__)).read_text(encoding="utf-8-sig")
