"""Integrators in Python files of users: ``--method file.py`` on the command line.

A file contains what a module of :mod:`mbdsl.integrators.methods` or :mod:`mbdsl.integrators.external` contains: a
``METHOD``, and kernels or a function ``solve``. Only a user names such files: models, results and checkpoints never do,
because loading a file executes it. Its folder is not added to the path of imports, where its modules could replace
others.
"""

from __future__ import annotations

import ast
import builtins
import dis
import hashlib
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import ModuleType

from mbdsl import integrators
from mbdsl.compilation.kernel_sources import digest_of, names_of
from mbdsl.compilation.kernel_types import Untranslatable
from mbdsl.errors import MbdslError, Span, UsageError
from mbdsl.integrators.method import KERNELS, STEP_KERNELS, Method
from mbdsl.kernels import marks

PREFIX = "mbdsl_method_file_"  #: of the names of modules; a digest of the text follows
PAGE = "docs/backends.md describes both kinds of files"
_modules: dict[str, ModuleType] = {}  # file as given -> module


def load(path: str) -> str:
    """Execute a file and register its method; return the name of the method.

    Parameters
    ----------
    path : str
        A Python file.

    Returns
    -------
    str
        The name in its ``METHOD``, by which it is available in this process.

    Raises
    ------
    UsageError
        If the file cannot be read, raises an exception, or defines no method.
    """
    module = _executed(path)
    method = getattr(module, "METHOD", None)
    if not isinstance(method, Method):
        found = "no METHOD" if method is None else f"a METHOD of the type {type(method).__name__}"
        raise UsageError(f"`{path}` has {found}, expected `METHOD = mbdsl.integrators.Method(...)`", hint=PAGE)
    former = _module(method.name)
    if former is not None and not _is_of_a_file(former):
        raise UsageError(
            f"there is already a method called `{method.name}`", _assignment(path), "give METHOD another name"
        )
    integrators.modules().pop(method.name, None)
    _modules[path] = module
    if callable(getattr(module, "solve", None)):
        integrators.register(module)
    elif any(hasattr(module, kernel) for kernel in (*KERNELS, *STEP_KERNELS)):
        integrators._check_kernels(method.name, module)
        _check_names(path, module)
        integrators.modules()[method.name] = module
    else:
        raise UsageError(
            f"method `{method.name}` of `{path}` has neither a function solve(problem) nor kernels", hint=PAGE
        )
    return method.name


def _is_of_a_file(module: object) -> bool:
    return getattr(module, "__name__", "").startswith(PREFIX)


def paths() -> tuple[str, ...]:
    """The files that were loaded in this process, with absolute paths."""
    return tuple(str(module.__file__) for module in _modules.values())


def _module(name: str) -> ModuleType | None:
    return integrators.modules().get(name) or integrators.backend(name)


def spelled(name: str) -> str:
    """A method on the command line: its file as it was given, else its name."""
    return next((path for path, module in _modules.items() if module is _module(name)), name)


def digest(name: str) -> str | None:
    """A digest of a method's file and of the files that it imports; None for methods that are not of such a file."""
    found = _module(name)
    return digest_of(names_of([found])) if isinstance(found, ModuleType) and _is_of_a_file(found) else None


def place(problem: BaseException | None) -> Span | None:
    """The line of a method's file that raised an exception; None if there is none."""
    if problem is None:
        return None
    for frame in reversed(traceback.extract_tb(problem.__traceback__)):
        if frame.filename in _modules and frame.lineno is not None:
            columns = (getattr(frame, name, None) for name in ("colno", "end_colno"))  # since Python 3.11
            return _span(frame.filename, frame.lineno, *columns)
    return None


def blamed(problem: BaseException) -> MbdslError | None:
    """The error of an exception that the file of a method raised; None for other exceptions."""
    span = place(problem)
    return None if span is None else UsageError(f"{type(problem).__name__}: {' '.join(str(problem).split())}", span)


@contextmanager
def compiling(module: ModuleType) -> Iterator[None]:
    """While the kernels of a method's file are compiled: errors name the file as it was given."""
    try:
        yield
    except Untranslatable as problem:
        given = {str(known.__file__): path for path, known in _modules.items()}
        if problem.span is not None and problem.span.file in given:
            problem.span = replace(problem.span, file=given[problem.span.file])
        raise


def _executed(path: str) -> ModuleType:
    """The module of a file; the same one as long as its text does not change."""
    try:
        text = Path(path).read_bytes()
    except (OSError, ValueError) as problem:
        why = getattr(problem, "strerror", None) or "not a valid path"
        raise UsageError(f"cannot read the method `{path}`: {why}") from None
    name = PREFIX + hashlib.sha256(text).hexdigest()[:16]
    if (known := _modules.get(path)) is not None and known.__name__ == name:
        return known
    module = ModuleType(name)
    module.__file__ = os.path.abspath(path)
    setattr(module, marks.TEXT, text.decode("utf-8-sig", errors="replace"))
    former = _modules.get(path)
    _modules[path] = sys.modules[name] = module  # the compiler and pickle find functions by their modules
    try:
        exec(compile(text, path, "exec"), vars(module))
    except (Exception, SystemExit) as problem:
        error = _wrong_syntax(path, problem) or blamed(problem) or UsageError(f"cannot execute `{path}`: {problem}")
        sys.modules.pop(name, None)
        _modules.pop(path) if former is None else _modules.update({path: former})
        raise error from problem
    return module


def _wrong_syntax(path: str, problem: BaseException) -> UsageError | None:
    if not isinstance(problem, SyntaxError) or problem.filename != path:
        return None
    end = problem.end_offset if problem.end_lineno == problem.lineno else None
    column = problem.offset
    return UsageError(
        problem.msg, _span(path, problem.lineno or 1, column and column - 1, end and end - 1), "it is not valid Python"
    )


def _check_names(path: str, module: ModuleType) -> None:
    """Check that the names in kernels are defined, because their compilation takes long."""
    for kernel in vars(module).values():
        if not getattr(kernel, "__mbdsl_kernel__", False) or getattr(kernel, "__module__", "") != module.__name__:
            continue
        for step in dis.get_instructions(kernel):
            name = step.argval
            if step.opname == "LOAD_GLOBAL" and name not in vars(module) and not hasattr(builtins, name):
                at = getattr(step, "positions", None)  # since Python 3.11
                span = _span(path, at.lineno, at.col_offset, at.end_col_offset) if at and at.lineno else None
                raise UsageError(f"the kernel {kernel.__name__} uses `{name}`, which is not defined", span)


def _assignment(path: str) -> Span | None:
    """The line ``METHOD = ...``."""
    for node in ast.parse(Path(path).read_bytes()).body:
        if isinstance(node, ast.Assign) and any(getattr(x, "id", "") == "METHOD" for x in node.targets):
            return _span(path, node.lineno, node.col_offset, node.col_offset + len("METHOD"))
    return None


def _span(path: str, line: int, start: int | None = None, end: int | None = None) -> Span:
    """A place in a file; columns are counted from 0."""
    text = Path(path).read_text(encoding="utf-8", errors="replace").splitlines() if Path(path).is_file() else []
    shown = text[line - 1] if 0 < line <= len(text) else ""
    blank = len(shown) - len(shown.lstrip())
    start = blank if start is None else max(start, 0)
    length = len(shown) - start if end is None or end <= start else end - start
    return Span(path, line, start + 1, max(1, length), shown)
