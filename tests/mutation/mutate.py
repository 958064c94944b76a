"""Mutation testing: small errors are put into the numerics one at a time, and some test has to detect each of them.

Run by hand::

    python tests/mutation/mutate.py                        # five mutants of every file, seed 1
    python tests/mutation/mutate.py mbdsl/bodies --each 20 --seed 7 --report bodies.json

A mutant is a copy of one file in which a sign is flipped, ``+`` and ``-`` are swapped, a constant is 1 % larger, an
index is one larger, or a comparison goes the other way. It runs uncompiled (``NUMBA_DISABLE_JIT=1``), as compilation
takes longer than any test, in a process forked from one that has loaded all unchanged modules. ``NEAREST`` names the
tests of the file, the nearest first; they run up to the first failure. After ``--limit`` seconds a mutant counts as a
timeout, which is inconclusive if the tests take longer than that without it, too. Surviving mutants are printed with
their lines, for a person to judge.
"""

from __future__ import annotations

import argparse
import ast
import copy
import json
import os
import random
import re
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

ROOT = Path(__file__).parents[2]
FOLDERS = (
    *("mbdsl/elements", "mbdsl/bodies", "mbdsl/numerics", "mbdsl/expressions", "mbdsl/system", "mbdsl/initial"),
    "mbdsl/integrators",
)
#: elements: motion of frames, signals, corner cases; derivatives of the whole system take longest
FORMULAS = "tests/unit/lang/test_joint_formulas.py", "tests/unit/elements/test_corners.py"
DERIVATIVES = "tests/unit/elements/test_derivatives.py"
KERNELS = (
    *FORMULAS,
    f"{DERIVATIVES}::test_kernels_at_frames",
    f"{DERIVATIVES}::test_signals_are_what_the_kernels_compute",
    f"{DERIVATIVES}::test_springs_are_gradients_of_their_energy",
    f"{DERIVATIVES}::test_dampers_take_the_power_that_their_coefficients_say",
    f"{DERIVATIVES}::test_what_replaces_springs_resists_as_they_do",
    f"{DERIVATIVES}::test_forces_and_torques_do_the_work_of_their_laws",
)
#: without the tests that solve for shapes or integrate
CABLE = (
    "tests/unit/bodies/test_cable.py",
    "-k",
    "not tip and not circle and not small_loads and not swings and not agree and not turns and not winds and not cost",
)
#: assembly of the equations, and initial values
STARTS = "tests/unit/initial/test_initial.py", "tests/unit/system/test_reductions.py"
MODES = "tests/unit/analysis/test_eigenmodes.py"
#: peaks of laws between steps; radau5 and long runs take minutes uncompiled
UNSEEN, FIXED = "tests/verification/test_unseen.py", "tests/verification/test_unseen_fixed.py"
PEAKS = (FIXED, "-k", "not radau5 and not far and not checkpoint and not hht")
INTEGRATORS = "tests/unit/integrators"
QUICK = f"{INTEGRATORS}/test_starts.py", f"{INTEGRATORS}/test_generalized_alpha.py"
#: a few steps, compared with the same equations written out in full
FULL = (f"{INTEGRATORS}/test_full_systems.py", "-k", "not test_a_step or (slider_crank and not flexible)")
CONTROL = (f"{INTEGRATORS}/test_control.py", "-k", "local_errors or bdf2 or anew or rows")
STEPS = (*CONTROL[:1], f"{INTEGRATORS}/test_run.py", "-k", f"{CONTROL[2]} or (newmark and not order)")
RADAU5 = (
    f"{INTEGRATORS}/test_radau5.py",
    "-k",
    "not test_a_step and not pieces and not statistics and not corrections",
)
RADAU = (f"{INTEGRATORS}/test_radau.py",)
BACKENDS = f"{INTEGRATORS}/test_backends.py"
JUMPS = "tests/verification/test_jumps_at_steps.py"
#: tests of a method, selected by its name; tests of its order take minutes uncompiled
METHODS = (*QUICK, FULL[0], CONTROL[0], f"{INTEGRATORS}/test_run.py", "tests/unit/simulation/test_stepping.py")
#: beginning of a file's path -> its tests, in this order; the longest matching beginning counts
NEAREST = {
    "mbdsl/elements/": KERNELS,
    "mbdsl/numerics/": STARTS,
    "mbdsl/numerics/error_norm": ("tests/unit/system/test_error_norm.py",),
    "mbdsl/numerics/tolerance": ("tests/verification/test_tolerances.py",),
    "mbdsl/numerics/hermite": ("tests/unit/simulation/test_stepping.py",),
    "mbdsl/expressions/": FORMULAS,
    "mbdsl/initial/": (*STARTS, "tests/unit/explanation/test_receipt.py"),
    "mbdsl/numerics/banded": ("tests/unit/elements/test_flexible_beam.py", *CABLE),
    "mbdsl/elements/body": (
        f"{DERIVATIVES}::test_mass_and_weight",
        "tests/unit/lang/test_builder.py",
        "tests/unit/initial/test_initial.py",
    ),
    "mbdsl/bodies/ancf_cable_kernels": CABLE,
    "mbdsl/bodies/floating_beam_kernels": (
        "tests/unit/elements/test_flexible_beam.py",
        "tests/unit/bodies/test_floating.py",
    ),
    "mbdsl/elements/flexible_beam": ("tests/unit/elements/test_flexible_beam.py", "tests/unit/bodies/test_floating.py"),
    "mbdsl/elements/ground": ("tests/unit/mechanism/test_graph.py", "tests/unit/initial/test_initial.py"),
    "mbdsl/elements/kind": (*KERNELS, "tests/unit/mechanism/test_graph.py", "tests/unit/explanation/test_receipt.py"),
    "mbdsl/bodies/point_mass_kernels": STARTS,
    "mbdsl/elements/point_mass": (f"{DERIVATIVES}::test_mass_and_weight", "tests/unit/mechanism/test_graph.py"),
    "mbdsl/bodies/rigid_body": (*STARTS, f"{DERIVATIVES}::test_signals_are_what_the_kernels_compute"),
    "mbdsl/bodies/rigid_body_kernels": (
        *KERNELS,
        FULL[0],
        "-k",
        "not test_a_step or (slider_crank and not flexible and si2)",
    ),
    "mbdsl/elements/rod": (f"{DERIVATIVES}::test_mass_and_weight", "tests/unit/mechanism/test_graph.py"),
    "mbdsl/elements/velocity_constraint": (*FORMULAS, "tests/unit/mechanism/test_graph.py"),
    "mbdsl/bodies/": ("tests/unit/bodies/test_floating.py", *CABLE),
    "mbdsl/bodies/ancf_cable": CABLE,
    "mbdsl/bodies/floating_beam": (
        "tests/unit/elements/test_flexible_beam.py",
        "tests/unit/bodies/test_floating.py",
    ),
    "mbdsl/system/": (*STARTS, "tests/unit/explanation/test_receipt.py"),
    "mbdsl/system/accelerations": STARTS,
    "mbdsl/system/structure": (*STARTS, "tests/unit/system/test_emitted.py", "tests/unit/explanation/test_receipt.py"),
    "mbdsl/system/background_compilation": ("tests/unit/compilation/test_code_cache.py",),
    "mbdsl/system/body_models": STARTS,
    "mbdsl/system/time_derivatives": (
        *STARTS,
        "tests/unit/mechanism/test_reduction.py::test_accelerations_at_the_start_where_drivers_move_frames",
    ),
    "mbdsl/initial/redundancy": ("tests/unit/system/test_dependence.py",),
    "mbdsl/system/emit": (
        "tests/unit/system/test_emitted.py",
        "tests/unit/explanation/test_receipt.py",
        "tests/unit/compilation/test_code_cache.py",
    ),
    "mbdsl/system/peaks_in_fixed_steps": PEAKS,
    "mbdsl/system/nonholonomic": (
        "tests/unit/system/test_emitted.py",
        "tests/unit/system/test_reductions.py",
        f"{MODES}::test_gears",
    ),
    "mbdsl/system/index1": ("tests/unit/system/test_reductions.py",),
    "mbdsl/system/stabilised_index2": ("tests/unit/system/test_reductions.py",),
    "mbdsl/expressions/interval_arithmetic": ("tests/unit/expressions/test_intervals.py",),
    "mbdsl/system/loops": ("tests/unit/system/test_reductions.py", "tests/unit/explanation/test_receipt.py", *FULL),
    "mbdsl/initial/weights": (
        "tests/unit/initial/test_initial.py",
        "tests/unit/mechanism/test_reduction.py",
        "-k",
        "guess or said",
    ),
    "mbdsl/system/peaks_along_motion": ("tests/unit/expressions/test_intervals.py", *PEAKS),
    "mbdsl/system/signals": ("tests/unit/system/test_tape.py", *STARTS),
    "mbdsl/system/expression_tape": ("tests/unit/system/test_tape.py", "tests/unit/system/test_switches.py"),
    "mbdsl/system/time_events": ("tests/unit/system/test_switches.py",),
    "mbdsl/initial/undeformed": (
        "tests/unit/elements/test_flexible_beam.py",
        *STARTS,
        "tests/unit/analysis/test_eigenmodes.py",
    ),
    "mbdsl/numerics/piecewise_cubic": ("tests/unit/system/test_tape.py",),
    "mbdsl/system/system": (
        *STARTS,
        "tests/unit/explanation/test_receipt.py",
        f"{DERIVATIVES}::test_derivatives_of_the_system",
        "-k",
        "not derivatives_of or Revolute-friction",
    ),
    "mbdsl/system/switches": ("tests/unit/system/test_switches.py",),
    "mbdsl/system/peaks_in_time": ("tests/unit/expressions/test_intervals.py", *PEAKS),
    "mbdsl/integrators/": (*QUICK, *FULL),
    "mbdsl/integrators/methods/": (*QUICK, *FULL),
    "mbdsl/integrators/__init__": (BACKENDS, "-k", "registered or process"),
    "mbdsl/integrators/backends": (BACKENDS, "-k", "registered or failures or output or tolerances_of"),
    "mbdsl/integrators/methods/radau5_coefficients": RADAU5,
    "mbdsl/integrators/loop/complex_lu": (f"{INTEGRATORS}/test_linear.py", *RADAU5),
    "mbdsl/integrators/loop/linear_solve": (f"{INTEGRATORS}/test_linear.py", *FULL),
    "mbdsl/integrators/loop/step_control": CONTROL,
    "mbdsl/integrators/loop/split_correction": FULL,
    "mbdsl/integrators/loop/tangent_matrices": FULL,
    "mbdsl/integrators/loop/driver": STEPS,
    "mbdsl/integrators/loop/multistep": STEPS,
    "mbdsl/integrators/loop/step_times": STEPS,
    "mbdsl/integrators/events": ("tests/unit/system/test_switches.py", "tests/unit/integrators/test_events.py"),
    "mbdsl/integrators/external/": (
        BACKENDS,
        f"{UNSEEN}::test_backends_see_it",
        "-k",
        "reactions or peak or domain or see_it",
    ),
    "mbdsl/integrators/scheduled_jumps": ("tests/unit/simulation/test_stepping.py::test_reaction_behind_a_jump", JUMPS),
    "mbdsl/integrators/methods/kinematic": (
        "tests/unit/mechanism/test_reduction.py",
        "-k",
        "everything_driven or kinematics or without_reactions",
    ),
    "mbdsl/integrators/loop/zone_landing": PEAKS,
    "mbdsl/integrators/peak_zones": (UNSEEN, "-k", "nested and hht-si2-0.001"),
    "mbdsl/integrators/missed_peaks": PEAKS,
    "mbdsl/integrators/methods/radau5": RADAU5,
    "mbdsl/integrators/loop/sparse_lu": ("tests/unit/system/test_reductions.py", *FULL),
    "mbdsl/integrators/methods/radau_newton": RADAU5,
    "mbdsl/integrators/methods/radau_step": RADAU5,
    "mbdsl/integrators/methods/radau_stages": RADAU,
    "mbdsl/integrators/methods/radau_coefficients": RADAU,
    "mbdsl/integrators/methods/radau5_stages": RADAU5,
    "mbdsl/integrators/loop/switch_location": (
        "tests/unit/system/test_switches.py",
        "tests/unit/integrators/test_events.py",
    ),
    "mbdsl/integrators/loop/turn_counting": ("tests/unit/bodies/test_turns.py",),
}
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


def tests_of(path: str) -> tuple[str, ...]:
    """Arguments for pytest; of a joint, a force or a method, the tests with its name alone."""
    start = max((start for start in NEAREST if path.startswith(start)), key=len)
    text = (ROOT / path).read_text(encoding="utf-8")
    pair = re.search("^KIND = (Joint|Force)Kind", text, re.MULTILINE)
    stem = Path(path).stem
    if start == "mbdsl/elements/" and pair:
        kind = "".join(word.capitalize() for word in stem.split("_"))
        return (*KERNELS, f"{DERIVATIVES}::test_derivatives_of_the_system", "-k", f"[{kind}")
    if start == "mbdsl/integrators/methods/" and re.search("^METHOD = ", text, re.MULTILINE):
        name = stem.replace("_", "-")
        return (*METHODS, "-k", f"({name} or {stem}) and not seven_body and not soft and not flexible and not order")
    return NEAREST[start]


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
    os.environ.update(NUMBA_DISABLE_JIT="1", OPENBLAS_NUM_THREADS="1", PYTHONDONTWRITEBYTECODE="1")
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
