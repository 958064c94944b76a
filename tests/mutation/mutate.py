"""Mutation testing: small errors put into the numerics one at a time, each of which some test has to catch.

Run by hand::

    python tests/mutation/mutate.py                        # five mutants of every file, seed 1
    python tests/mutation/mutate.py mbdsl/beams --each 20 --seed 7 --report beams.json

A mutant is a copy of one file in which a sign is flipped, ``+`` and ``-`` are swapped, a constant is 1 % larger, an
index is one larger, or a comparison goes the other way. It runs uncompiled (``NUMBA_DISABLE_JIT=1``), as compiling
anew takes longer than any test, in a process forked from one that has loaded what does not change. Tests are those that
``NEAREST`` names for the file, the nearest first, up to the first that fails. What takes more than ``--limit`` seconds
does not end, or its tests take longer than that: a timeout says nothing where the tests of the file do. Those that
survive are printed with their lines, for a person to judge.
"""

from __future__ import annotations

import argparse
import ast
import copy
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("mbdsl/elements", "mbdsl/beams", "mbdsl/system", "mbdsl/integrators")
#: beginning of a file's path -> its tests, in this order; the longest beginning that fits counts
NEAREST = {
    "mbdsl/elements/": ("tests/unit/lang/test_joint_formulas.py", "tests/unit/elements/test_derivatives.py"),
    "mbdsl/elements/cable_frames": ("tests/unit/beams/test_cable.py",),
    "mbdsl/elements/floating_frames": ("tests/unit/elements/test_flexible_beam.py", "tests/unit/beams"),
    "mbdsl/elements/flexible_beam": ("tests/unit/elements/test_flexible_beam.py", "tests/unit/beams"),
    "mbdsl/beams/": ("tests/unit/beams/test_floating.py", "tests/unit/beams/test_cable.py"),
    "mbdsl/beams/cable_body": ("tests/unit/beams/test_cable.py",),
    "mbdsl/system/": ("tests/unit/test_initial.py", "tests/unit/elements/test_derivatives.py"),
    "mbdsl/system/tape": ("tests/unit/test_tape.py",),
    "mbdsl/system/splines": ("tests/unit/test_tape.py",),
    "mbdsl/system/index": ("tests/unit/integrators/test_backends.py", "tests/unit/integrators/test_full_systems.py"),
    "mbdsl/system/switches": ("tests/unit/test_switches.py",),
    "mbdsl/integrators/": ("tests/unit/integrators",),
    "mbdsl/integrators/generalized_alpha": (
        "tests/unit/integrators/test_generalized_alpha.py",
        "tests/unit/integrators",
    ),
    "mbdsl/integrators/control": ("tests/unit/integrators/test_control.py",),
    "mbdsl/integrators/radau5": ("tests/unit/integrators/test_radau5.py",),
    "mbdsl/integrators/stages": ("tests/unit/integrators/test_radau5.py",),
    "mbdsl/integrators/collocation": ("tests/unit/integrators/test_radau5.py",),
    "mbdsl/integrators/events": ("tests/unit/integrators/test_events.py",),
}
SWAPPED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE}


def mutations(tree: ast.Module) -> list[tuple[int, str, object]]:
    """What can be changed: the line, what is done, and a function that does it to a node of a copy of the tree."""
    found = []
    # what messages and annotations say is not numerics
    silent = [node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr | ast.Raise)]
    silent += [x for node in ast.walk(tree) for x in (getattr(node, "annotation", 0), getattr(node, "returns", 0)) if x]
    quiet = {id(below) for node in silent for below in ast.walk(node)}
    for k, node in enumerate(ast.walk(tree)):
        line = getattr(node, "lineno", 0)
        if id(node) in quiet:
            continue
        if isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in SWAPPED:
            found.append((line, "sign", k, lambda n: setattr(n, "op", SWAPPED[type(n.op)]())))
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            found.append((line, "minus", k, lambda n: setattr(n, "op", ast.UAdd())))
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in SWAPPED:
            found.append((line, "comparison", k, lambda n: n.ops.__setitem__(0, SWAPPED[type(n.ops[0])]())))
        elif isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value:
            found.append((line, "1 %", k, lambda n: setattr(n, "value", n.value * 1.01)))
        elif isinstance(node, ast.Subscript):
            places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
            for i, place in enumerate(places):
                whole = isinstance(place, ast.Constant) and isinstance(place.value, int)
                if whole or isinstance(place, ast.Name | ast.BinOp):
                    found.append((line, "index", k, lambda n, i=i: _next(n, i)))
    return found


def _next(node: ast.Subscript, i: int) -> None:
    """The index number ``i`` becomes one larger."""
    place = node.slice.elts[i] if isinstance(node.slice, ast.Tuple) else node.slice
    larger = ast.BinOp(place, ast.Add(), ast.Constant(1))
    if isinstance(node.slice, ast.Tuple):
        node.slice.elts[i] = larger
    else:
        node.slice = larger


def mutant(tree: ast.Module, k: int, change) -> str:
    changed = copy.deepcopy(tree)
    change(list(ast.walk(changed))[k])
    return ast.unparse(ast.fix_missing_locations(changed))


def tests_of(path: str) -> tuple[str, ...]:
    """Arguments for pytest; of an element, the tests of its kind alone."""
    if path.startswith("mbdsl/elements/") and "\nKIND = " in (ROOT / path).read_text(encoding="utf-8"):
        kind = "".join(word.capitalize() for word in Path(path).stem.split("_"))
        return (*NEAREST["mbdsl/elements/"], "-k", kind)
    return NEAREST[max((start for start in NEAREST if path.startswith(start)), key=len)]


def load() -> None:
    """Whatever children need and no mutant changes."""
    import numpy  # noqa: F401
    import scipy.integrate
    import scipy.sparse.linalg  # noqa: F401


def run(folder: Path, tests: tuple[str, ...], limit: float) -> str:
    """In a child: "caught", "survived" or "timeout"."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.setsid()
            os.chdir(folder)
            sys.path.insert(0, str(folder))
            with open("tests.log", "w") as log:
                os.dup2(log.fileno(), 1)
                os.dup2(log.fileno(), 2)
            code = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests]))
        except BaseException:  # it must not go on as if it were its parent
            traceback.print_exc()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    end = time.monotonic() + limit
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            code = os.waitstatus_to_exitcode(status)
            if code in (pytest.ExitCode.USAGE_ERROR, pytest.ExitCode.NO_TESTS_COLLECTED):
                sys.exit(f"no tests: {' '.join(tests)}; see `NEAREST`")
            return "caught" if code else "survived"
        time.sleep(0.05)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return "timeout"


def main() -> None:
    parser = argparse.ArgumentParser(description="Count which small errors in the numerics no test catches.")
    parser.add_argument("files", nargs="*", default=FOLDERS, help="files or folders; default: all numerics")
    parser.add_argument("--each", type=int, default=5, help="mutants of every file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=600.0, help="seconds for a mutant")
    parser.add_argument("--tests", nargs="*", help="tests to run in place of the nearest ones")
    parser.add_argument("--report", type=Path, help="a JSON file of all mutants, written as it goes")
    args = parser.parse_args()
    os.environ.update(NUMBA_DISABLE_JIT="1", OPENBLAS_NUM_THREADS="1", PYTHONDONTWRITEBYTECODE="1")
    load()
    files = [f for x in args.files for f in (sorted((ROOT / x).glob("*.py")) if (ROOT / x).is_dir() else [ROOT / x])]
    done = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for name in ("mbdsl", "tests", "models", "docs"):
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", folder)
        for file in files:
            path = file.relative_to(ROOT).as_posix()
            text = file.read_text(encoding="utf-8")
            tree = ast.parse(text)
            possible = mutations(tree)
            chosen = random.Random(f"{args.seed} {path}").sample(possible, min(args.each, len(possible)))
            for line, what, k, change in sorted(chosen, key=lambda m: m[0]):
                (folder / path).write_text(mutant(tree, k, change), encoding="utf-8")
                outcome = run(folder, tuple(args.tests or tests_of(path)), args.limit)
                done.append({"file": path, "line": line, "what": what, "outcome": outcome})
                print(f"{outcome:9s} {path}:{line}: {what}: {text.splitlines()[line - 1].strip()}", flush=True)
                if args.report:
                    args.report.write_text(json.dumps(done, indent=1), encoding="utf-8")
            (folder / path).write_text(text, encoding="utf-8")
    print(f"{len(done)} mutants:", ", ".join(f"{n} {what}" for what, n in Counter(d["outcome"] for d in done).items()))


if __name__ == "__main__":
    main()
