"""Compilation: marked kernels become numba functions, and stay plain Python where numba is absent or switched off.

Element files only mark their kernels (:mod:`mbdsl.kernels`), because ``mbdsl check`` reads the files
without numerics. :func:`activate` replaces the marks by compiled functions, in the modules that use them.

Compiled code is kept on disk under a folder named by the digest of the sources it comes from: an edited kernel can
never meet the machine code of its former self.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from types import ModuleType

from mbdsl import __version__

_compiled: dict[Callable, Callable] = {}


@cache
def numba() -> ModuleType | None:
    """The numba module, or None where it cannot be imported (then everything runs as Python, slowly)."""
    try:
        import numba
    except ImportError as error:
        warnings.warn(f"numba cannot be imported ({error}); running uncompiled, some 100 times slower", stacklevel=2)
        return None
    return numba


def skip_blas() -> None:
    """Keep numba from loading scipy.linalg, in a process of our own that uses no BLAS: it saves a fifth of a second."""
    module = numba()
    if module is None or "numba.np.arraymath" in sys.modules or "scipy.linalg" in sys.modules:
        return
    blas = "scipy.linalg.cython_blas"
    sys.modules[blas] = None  # type: ignore[assignment]  # importing it fails, which numba is prepared for
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        del sys.modules[blas]


def enabled() -> bool:
    """Whether kernels are compiled at all."""
    module = numba()
    return module is not None and not module.config.DISABLE_JIT


@cache
def cache_directory() -> Path:
    """Where compiled code and emitted modules of this version live; created if need be.

    ``MBDSL_CACHE_DIR`` names another place for the parent folder.
    """
    package = Path(__file__).parent
    digest = hashlib.sha256()
    compiled = [path for folder in ("elements", "system", "integrators") for path in (package / folder).rglob("*.py")]
    for path in sorted([*compiled, package / "layout.py", package / "kernels.py", package / "jit.py"]):
        digest.update(path.name.encode() + path.read_bytes())
    module = numba()
    name = f"{__version__}-py{sys.version_info[0]}{sys.version_info[1]}-{module.__version__ if module else 'plain'}"
    name += f"-{digest.hexdigest()[:12]}"
    chosen = os.environ.get("MBDSL_CACHE_DIR")
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    for parent in [Path(chosen)] if chosen else [Path(home) / "mbdsl"]:
        folder = parent / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                return folder
        except OSError:
            pass
    # Nowhere to keep things: a private folder for this process, so that nobody else's code can lie in wait there.
    folder = Path(tempfile.mkdtemp(prefix="mbdsl-")) / name
    folder.mkdir()
    return folder


def compile(function: Callable, signature=None, cached: bool = True, **options) -> Callable:
    """``numba.njit`` with the project's cache folder and settings; the function itself where JIT is off."""
    module = numba()
    if module is None or not enabled():
        return function
    former = module.config.CACHE_DIR
    module.config.CACHE_DIR = str(cache_directory())
    try:
        arguments = (signature,) if signature is not None else ()
        # Without numba's runtime nothing can be allocated, and no time goes into counting references.
        return module.njit(*arguments, cache=cached, error_model="numpy", _nrt=False, **options)(function)
    finally:
        module.config.CACHE_DIR = former


def activate(*modules: ModuleType) -> None:
    """Replace every marked kernel that ``modules`` define or import, there and where it comes from, by its compiled
    function.

    Compilation itself happens when a kernel is first called from compiled code, so the order does not matter.
    """
    if not enabled():
        return
    for module in _with_imports(modules):
        for name, value in list(vars(module).items()):
            if getattr(value, "__mbdsl_kernel__", False) and not hasattr(value, "py_func"):
                if value not in _compiled:
                    options: dict[str, object] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
                    if hasattr(value, "__mbdsl_template__"):
                        options["inline"] = "always"
                    elif not hasattr(value, "__mbdsl_rare__"):
                        # A call hands over every array piece by piece, which costs more than most kernels.
                        options["forceinline"] = True
                    # What every scene calls is kept by itself; the rest lives in what it is compiled into.
                    kept = value.__module__.startswith("mbdsl.system") or value.__module__.endswith("_frames")
                    _compiled[value] = compile(value, cached=kept, **options)
                setattr(module, name, _compiled[value])


def _with_imports(modules: tuple[ModuleType, ...]) -> list[ModuleType]:
    """``modules`` and those that their kernels come from."""
    found = dict.fromkeys(modules)
    pending = list(found)
    while pending:
        for value in vars(pending.pop()).values():
            if getattr(value, "__mbdsl_kernel__", False) or hasattr(value, "py_func"):
                module = sys.modules[value.__module__]
                if module not in found:
                    found[module] = None
                    pending.append(module)
    return sorted(found, key=lambda module: module.__name__)


_imported: dict[str, ModuleType] = {}


def import_text(name: str, text: str, functions: Mapping[str, object]) -> ModuleType:
    """The module ``name`` made from emitted ``text``, with ``functions`` (name -> signature or None) compiled.

    It is kept as a file, since numba keeps machine code by the file that it came from.
    """
    if name in _imported:
        return _imported[name]
    path = cache_directory() / f"{name}.py"
    if not path.exists():
        part = path.with_suffix(f".{os.getpid()}.part")
        part.write_text(text)
        part.replace(path)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None  # a path that exists always gives both
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # before executing: numba finds the module of a cached function by its name
    spec.loader.exec_module(module)
    for function, signature in functions.items():
        if hasattr(module, function):
            setattr(module, function, compile(getattr(module, function), signature))
    if enabled():
        path.with_suffix(".compiled").touch()
    _imported[name] = module
    return module


def is_compiled(name: str) -> bool:
    """Whether the module ``name`` needs no compilation: it is on disk, or kernels run as Python."""
    return not enabled() or (cache_directory() / f"{name}.compiled").exists()


def beside(module: str, *arguments: str) -> subprocess.Popen | None:
    """Call ``module.main(*arguments)`` in another process, to compile there what this one will find on disk.

    It imports from where this process does and from nowhere else: not from the folder that a model happens to be in.
    None where no process can be had: then everything is compiled here, one after the other.
    """
    environment = {**os.environ, "MBDSL_CACHE_DIR": str(cache_directory().parent)}
    code = f"import sys; sys.path[:] = {sys.path!r}; from {module} import main; main(*sys.argv[1:])"
    command = [sys.executable, "-I", "-c", code, *arguments]
    try:
        null = subprocess.DEVNULL
        return subprocess.Popen(command, stdin=null, stdout=null, stderr=null, env=environment)
    except OSError:
        return None
