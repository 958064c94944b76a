"""Mutation testing: small errors are put into the numerics one at a time, and some test has to detect each of them.

Run by hand::

    python tests/mutation/mutate.py                        # five mutants of every file, seed 1
    python tests/mutation/mutate.py mbdsl/bodies --each 20 --seed 7 --report bodies.json

A mutant is a copy of one file in which a sign is flipped, ``+`` and ``-`` are swapped, a constant is 1 % larger, an
index is one larger, or a comparison goes the other way. It runs uncompiled (``MBDSL_NO_COMPILE=1``), as compilation
takes longer than any test, in a process forked from one that has loaded all unchanged modules. ``NEAREST`` in
``nearest.py`` names the tests of the file, the nearest first; they run up to the first failure. After ``--limit``
seconds a mutant counts as a timeout, which is inconclusive if the tests take longer than that without it, too.
Surviving mutants are printed with their lines, for a person to judge.
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
from functools import cache
from pathlib import Path

import pytest
from nearest import tests_of

ROOT = Path(__file__).parents[2]
FOLDERS = (
    *("mbdsl/elements", "mbdsl/bodies", "mbdsl/numerics", "mbdsl/expressions", "mbdsl/system", "mbdsl/initial"),
    *("mbdsl/integrators", "mbdsl/simulation", "mbdsl/studies"),
)
#: subscripts of these names are types
GENERIC = {"tuple", "list", "dict", "Callable", "NDArray", "Mapping", "Sequence"}
#: file in which a child stores the name of the test that failed
FAILED = Path("failed.txt")
SWAPPED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE}


def mutations(tree: ast.Module) -> list[tuple[int, str, object]]:
    """The possible changes: the line, a description, and a function that changes a node of a copy of the tree."""
    found = []
    # messages and annotations are not numerics
    silent = [node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr | ast.Raise)]
    silent += [x for node in ast.walk(tree) for x in (getattr(node, "annotation", 0), getattr(node, "returns", 0)) if x]
    quiet = {id(below) for node in silent for below in ast.walk(node)}
    for k, node in enumerate(ast.walk(tree)):
        line = getattr(node, "lineno", 0)
        if id(node) in quiet or (isinstance(node, ast.Subscript) and getattr(node.value, "id", "") in GENERIC):
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


def load() -> None:
    """Load the modules that children need and no mutant changes."""
    import hypothesis.core
    import hypothesis.strategies  # noqa: F401
    import numpy  # noqa: F401
    import scipy.integrate
    import scipy.sparse.linalg  # noqa: F401


class First:
    """A plugin of pytest that stores the name of the first test that fails, or of the file that cannot be loaded."""

    def pytest_runtest_logreport(self, report) -> None:
        if report.failed and not FAILED.exists():
            FAILED.write_text(report.nodeid, encoding="utf-8")

    pytest_collectreport = pytest_runtest_logreport


def run(folder: Path, tests: tuple[str, ...], limit: float) -> str:
    """In a child: "caught", "survived" or "timeout"."""
    (folder / FAILED).unlink(missing_ok=True)
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
            # compiled code does not warn, and no test expects warnings of it
            options = ["-x", "-q", "-p", "no:cacheprovider", "-W", "ignore::RuntimeWarning"]
            options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # modules that `load` has loaded
            code = int(pytest.main([*options, *tests], plugins=[First()]))
        except BaseException:  # it must not continue as its parent
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


@cache
def passes(folder: Path, test: str, limit: float) -> bool:
    """Whether a test passes, or a file of tests can be loaded, with no mutant in ``folder``."""
    return run(folder, (test,) if "::" in test else (test, "--collect-only"), limit) == "survived"


def main() -> None:
    parser = argparse.ArgumentParser(description="Count which small errors in the numerics no test catches.")
    parser.add_argument("files", nargs="*", default=FOLDERS, help="files or folders; default: all numerics")
    parser.add_argument("--each", type=int, default=5, help="mutants of every file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=600.0, help="seconds for a mutant")
    parser.add_argument("--tests", nargs="*", help="tests to run in place of the nearest ones")
    parser.add_argument("--report", type=Path, help="a JSON file of all mutants, written as it goes")
    parser.add_argument("--again", type=Path, help="an earlier report: try again what was not caught")
    args = parser.parse_args()
    os.environ.update(MBDSL_NO_COMPILE="1", OPENBLAS_NUM_THREADS="1", PYTHONDONTWRITEBYTECODE="1")
    load()
    files = [f for x in args.files for f in (sorted((ROOT / x).rglob("*.py")) if (ROOT / x).is_dir() else [ROOT / x])]
    again = json.loads(args.again.read_text(encoding="utf-8")) if args.again else []
    wanted = {(d["file"], d["line"], d["what"]) for d in again if d["outcome"] != "caught"}
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
            if args.again:
                chosen = [m for m in possible if (path, *m[:2]) in wanted]
            else:
                chosen = random.Random(f"{args.seed} {path}").sample(possible, min(args.each, len(possible)))
            for line, what, k, change in sorted(chosen, key=lambda m: m[0]):
                (folder / path).write_text(mutant(tree, k, change), encoding="utf-8")
                outcome = run(folder, tuple(args.tests or tests_of(path)), args.limit)
                (folder / path).write_text(text, encoding="utf-8")
                if outcome == "caught" and (folder / FAILED).exists():
                    test = (folder / FAILED).read_text(encoding="utf-8")
                    if not passes(folder, test, args.limit):
                        sys.exit(f"{test} does not pass without a mutant; see {folder}/tests.log and `NEAREST`")
                done.append({"file": path, "line": line, "what": what, "outcome": outcome})
                print(f"{outcome:9s} {path}:{line}: {what}: {text.splitlines()[line - 1].strip()}", flush=True)
                if args.report:
                    args.report.write_text(json.dumps(done, indent=1), encoding="utf-8")
    print(f"{len(done)} mutants:", ", ".join(f"{n} {what}" for what, n in Counter(d["outcome"] for d in done).items()))


if __name__ == "__main__":
    main()
