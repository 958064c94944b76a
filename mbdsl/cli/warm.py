"""mbdsl warm: compile code before it is needed."""

from __future__ import annotations

import argparse
import os
import sys
from typing import TYPE_CHECKING

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._progress import Preparation
from mbdsl.errors import UsageError
from mbdsl.messages import count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mbdsl.simulation.code_preparation import EmittedModule

REMEDY = "set MBDSL_CACHE_DIR to the absolute path of a folder with free space that only you can write into"


COMMAND = Command(
    "compile code before it is needed",
    "Compile the step loops of methods and the equations of models, and store the machine code in the cache folder, "
    "so that later runs start at once. This is useful in images, in continuous integration, and after an update. Code"
    " in the cache is not compiled again.",
    """
    models MODEL ...  files of models (.mbd)
    @model_name
    --methods NAME,...  integrators, or Python files (NAME.py); default: all own methods
    --jobs N  number of parallel processes; default: one for each processor
    --bytecode  also write Python's bytecode of mbdsl, which is missing with PYTHONDONTWRITEBYTECODE and some installers
    --quiet  print errors only
    """,
    jobs=values.whole("expected a number of processes above 0, found `{}`", 1000),
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.compilation import code_cache
    from mbdsl.lang.load import load
    from mbdsl.simulation import code_preparation
    from mbdsl.storage import cache_folder

    folder = cache_folder.chosen()
    if problem := folder.fault or cache_folder.unwritable(folder.path):
        raise UsageError(f"machine code cannot be stored: {problem}", hint=REMEDY)
    if not code_cache.enabled():
        raise UsageError("kernels are not compiled: MBDSL_NO_COMPILE is set, or llvmlite is not installed")
    scenes = [(os.path.basename(path), load(path)) for path in args.models]
    if args.bytecode:
        _write_bytecode(args.quiet)
    found = code_preparation.codes(scenes, args.methods or ())
    _prepare(found, args)
    return 0


def _prepare(found: Sequence[EmittedModule], args: argparse.Namespace) -> None:
    from time import perf_counter

    from mbdsl.simulation import code_preparation
    from mbdsl.storage import cache_folder

    began, missing = perf_counter(), sum(not code.is_ready for code in found)
    line = None if args.quiet else Preparation(sys.stderr)

    def done(code: EmittedModule, seconds: float) -> None:
        if line:
            line.close()
            print(f"{code.what}: {seconds:.1f} s", flush=True)

    try:
        jobs = args.jobs or os.cpu_count() or 1
        code_preparation.prepare(found, jobs, line or (lambda progress: None), done)
    finally:
        if line:
            line.close()
    if not args.quiet:
        compiled = f"{missing} compiled in {perf_counter() - began:.1f} s" if missing else "nothing to compile"
        print(f"{count(len(found), 'module')}: {compiled}, {len(found) - missing} already in the cache")
        print(f"folder: {cache_folder.chosen().path}")


def _write_bytecode(quiet: bool) -> None:
    """Write the bytecode of the package; Python reads it also where it does not write any."""
    import compileall
    from pathlib import Path

    package = Path(__file__).parents[1]
    if not compileall.compile_dir(str(package), quiet=2, workers=0):
        raise UsageError(f"cannot write the bytecode of `{package}`", hint="run it as the owner of this folder")
    if not quiet:
        print(f"bytecode: {package}")
