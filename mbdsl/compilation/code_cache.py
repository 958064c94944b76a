"""Compilation of marked kernels and the cache of their machine code; without LLVM, kernels run as plain Python.

Element files only mark their kernels (:mod:`mbdsl.kernels.marks`), because ``mbdsl check`` imports these files
without numerics. :func:`functions` compiles an emitted module and all kernels that it calls to one object: the kernels
are translated to LLVM code (:mod:`mbdsl.compilation.translation`; docs/decisions/translator.md has the reason).
``MBDSL_NO_COMPILE=1`` runs them as plain Python.

Objects are cached on disk with a digest of their sources, in a folder named by a digest of the compiler. After an edit
of a kernel its old machine code is therefore never used again, and edits of other files do not invalidate it.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from mbdsl.compilation.kernel_sources import digest_of, emitted, names_of, with_imports
from mbdsl.compilation.native_call import Native, Signature
from mbdsl.kernels import marks
from mbdsl.storage import cache_folder
from mbdsl.version import __version__

if TYPE_CHECKING:
    import subprocess

_functions: dict[str, list[Callable]] = {}
SLOW = "running uncompiled, some 100 times slower"
_plain_only = False
#: held while code is compiled or loaded: other threads wait and use the result
lock = threading.RLock()


@contextmanager
def uncompiled() -> Iterator[None]:
    """While the block runs, kernels that are not loaded yet run as plain Python: for a few evaluations this is faster
    than compilation, and than the import of LLVM. Systems made in the block are used only there."""
    global _plain_only
    with lock:
        before, _plain_only = _plain_only, True
        try:
            yield
        finally:
            _plain_only = before


class Uncompiled(UserWarning):
    """Kernels run as plain Python, because the installed llvmlite cannot compile them."""


def enabled() -> bool:
    """Whether kernels are compiled."""
    return os.environ.get("MBDSL_NO_COMPILE", "0") in ("", "0") and _has_llvm()


@cache
def _has_llvm() -> bool:
    found = importlib.util.find_spec("llvmlite") is not None
    if not found:
        warnings.warn(f"llvmlite is not installed; {SLOW}", stacklevel=3)
    return found


def version() -> str:
    """Name of the subfolder of the cache folder with the objects and emitted modules that this process can use."""
    settings = ("MBDSL_CPU_", "MBDSL_OPTIMISATION")
    environment = tuple(sorted(item for item in os.environ.items() if item[0].startswith(settings)))
    return f"{__version__}-py{sys.version_info[0]}{sys.version_info[1]}-{_digest(environment)[:16]}"


@cache
def _digest(environment: tuple) -> str:
    """Digest of the common dependencies of all machine code: this package, versions of llvmlite and numpy, settings of
    the compiler, the processor."""
    files = list(Path(__file__).parent.glob("*.py"))
    for name, written in (("llvmlite", "_version.py"), ("numpy", "version.py")):
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.origin is not None:
            files += Path(spec.origin).parent.glob(written)
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.name.encode() + path.read_bytes())
    digest.update(repr(environment).encode())
    if enabled():
        from llvmlite import binding

        digest.update(repr((binding.get_process_triple(), binding.get_host_cpu_name())).encode())
        digest.update(binding.get_host_cpu_features().flatten().encode())
    return digest.hexdigest()


# -- emitted modules -----------------------------------------------------------------------------------------


def functions(
    name: str, text: str, signatures: Mapping[str, Signature], modules: Callable[[], Iterable[ModuleType]]
) -> list[Callable]:
    """Functions of the module ``name`` with the emitted ``text``: from the cache, newly compiled, or as plain Python.

    ``modules()`` imports and returns the modules whose kernels the text calls.
    """
    with lock:
        if name not in _functions:
            if _plain_only:
                return _plain(name, text, signatures, modules)
            _functions[name] = (
                _plain(name, text, signatures, modules)
                if not enabled()
                else _kept(name, text, signatures) or _compiled(name, text, signatures, modules)
            )
        return _functions[name]


def is_compiled(name: str) -> bool:
    """Whether the module ``name`` needs no compilation: its code is on disk, or kernels run as plain Python."""
    return not enabled() or _body(name) is not None


def import_text(name: str, text: str) -> ModuleType:
    """Make the module ``name`` from emitted ``text``; a copy of the text is written to the cache folder for readers."""
    with lock:
        if name not in sys.modules:
            module = ModuleType(name)
            module.__file__ = _text_file(name, text)
            setattr(module, marks.TEXT, text)
            exec(compile(text, module.__file__, "exec"), vars(module))  # the file on disk is never executed
            emitted.add(name)
            sys.modules[name] = module  # other emitted modules import it by its name
        return sys.modules[name]


def _text_file(name: str, text: str) -> str:
    if _plain_only:  # the name of the folder depends on the version of LLVM, whose import takes long
        return f"<{name}>"
    kept = cache_folder.keep(f"{version()}/{name}.py", text.encode())
    return f"<{name}>" if kept is None else str(kept)


def _plain(name: str, text: str, signatures: Mapping[str, Signature], modules: Callable) -> list[Callable]:
    modules()
    module = import_text(name, text)
    return [getattr(module, function) for function in signatures]


def _compiled(name: str, text: str, signatures: Mapping[str, Signature], modules: Callable) -> list[Callable]:
    from mbdsl.compilation import object_code, translation

    called = modules()
    module = import_text(name, text)
    translated = translation.translate(name, {f: getattr(module, f) for f in signatures}, signatures)
    sources = names_of(with_imports(tuple(called)))
    head = [digest_of(sources) or "", " ".join(sources), _asked(text, signatures)]
    try:
        made = object_code.compile_object(translated)
        body = "\n".join([*head, " ".join(made.needs), ""]).encode() + made.code
        if (linked := _linked(name, body, signatures)) is None:
            raise RuntimeError(f"compiled code needs {', '.join(made.needs)}")
    except Exception as error:  # another version of llvmlite
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        warnings.warn(f"llvmlite cannot compile ({reason}); {SLOW}", Uncompiled, stacklevel=2)
        return _plain(name, text, signatures, modules)
    cache_folder.keep(_object(name), hashlib.sha256(body).hexdigest().encode() + b"\n" + body)
    return linked


# -- objects on disk -----------------------------------------------------------------------------------------


def _object(name: str) -> str:
    return f"{version()}/{name}.o"


def _asked(text: str, signatures: Mapping[str, Signature]) -> str:
    """Digest of what an object is compiled from apart from its sources; the text alone contains no types."""
    return hashlib.sha256(f"{text}\0{signatures}".encode()).hexdigest()


def _kept(name: str, text: str, signatures: Mapping[str, Signature]) -> list[Callable] | None:
    """The functions of an object on disk; None if it is missing, is of another text, or needs unknown symbols."""
    body = _body(name)
    if body is None or body.split(b"\n", 3)[2].decode() != _asked(text, signatures):
        return None
    return _linked(name, body, signatures)


def _body(name: str) -> bytes | None:
    """The cached file of a module; None if it is missing or incomplete, or its sources have changed."""
    try:
        said, body = (cache_folder.read(_object(name)) or b"").split(b"\n", 1)
        digest, sources, _ = body.split(b"\n", 2)
    except ValueError:
        return None
    if hashlib.sha256(body).hexdigest().encode() != said or digest_of(sources.decode().split()) != digest.decode():
        return None
    return body


def _linked(name: str, body: bytes, signatures: Mapping[str, Signature]) -> list[Callable] | None:
    from llvmlite import binding

    from mbdsl.compilation import object_code

    _, _, _, needs, code = body.split(b"\n", 4)
    object_code.engine()  # makes the symbols of the C library known
    # LLVM ends the process if a symbol is missing
    if not all(binding.address_of_symbol(symbol) for symbol in needs.decode().split()):
        return None
    engine = object_code.load(code)
    address = engine.get_function_address
    return [Native(address(f"{name}.{f}"), address(f"{name}.{f}.packed"), signatures[f], engine) for f in signatures]


# -- other processes -----------------------------------------------------------------------------------------


def beside(module: str, *arguments: str) -> subprocess.Popen | None:
    """Call ``module.main(*arguments)`` in another process, which compiles code into the cache for this one.

    The other process has the import path of this one and nothing else, in particular not the folder of the model.
    None if no process can be started, or the cache cannot be written: this process then compiles all code itself.
    """
    if cache_folder.own() is None:
        return None
    import subprocess

    environment = {**os.environ, **cache_folder.environment()}
    code = f"import sys; sys.path[:] = {sys.path!r}; from {module} import main; main(*sys.argv[1:])"
    command = [sys.executable, "-I", "-c", code, *arguments]
    try:
        null = subprocess.DEVNULL
        return subprocess.Popen(command, stdin=null, stdout=null, stderr=null, env=environment)
    except OSError:
        return None
