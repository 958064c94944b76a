"""An integrator is one file: once it is in the package, every check of all methods includes it.

The file is BDF3, a method of order 3 that neither mbdsl nor its tests mention. Separate processes find it in a copy of
the package and run the checks below on it, including those of its order.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import mbdsl
from mbdsl.storage import cache_folder

PACKAGE = Path(mbdsl.__file__).parent
TESTS = Path(__file__).parents[2]
METHOD = '''
"""BDF3: the backward differentiation formula of order 3, on the index-3 equations.

v_{n+1} = (18 v_n - 9 v_{n-1} + 2 v_{n-2} + 6 h a_{n+1})/11, and q_{n+1} likewise from v_{n+1}. Source: Gear (1971).
"""

from mbdsl.integrators.method import Method, Option
from mbdsl.integrators.methods.nstiff import correct, matrix, residual
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

Q1, V1 = L.KEPT, L.KEPT2  # q and v one step before the start of the step
Q2, V2 = L.ROWS, L.ROWS + 1  # rows of its own: q and v two steps before the start of the step


def begin(c, start):
    h, q, v, a, j = start.h, start.q, start.v, start.a, start.jerk
    Qk = {row: q - k * h * v + (k * h) ** 2 / 2 * a - (k * h) ** 3 / 6 * j for k, row in ((1, Q1), (2, Q2))}
    Vk = {row: v - k * h * a + (k * h) ** 2 / 2 * j for k, row in ((1, V1), (2, V2))}
    return {L.UNKNOWN0: [*a, *start.lam], **Qk, **Vk}


METHOD = Method(
    "bdf3",
    doc="BDF of order 3 on the index-3 equations",
    order=3,
    index=3,
    enforces=("Phi",),
    source="Gear (1971)",
    parameters={"theta": Option(1.0, 0.5, 1.5, "scales nothing; an option as any other")},
    coefficients=lambda options: (options["theta"],),
    memory=lambda c, start: (36 / 121, 6 / 11),  # what nstiff's kernels read: (s/h)^2 and s/h
    begin=begin,
    own_reactions=False,  # from accelerations: between steps the loop interpolates multipliers to order 2
    rows=2,
    relative_step=0.5,
)


@kernel
def motion(h, run):
    y = run.vectors
    q, v, a = y[L.POSITION], y[L.VELOCITY], y[L.UNKNOWN]
    q0, v0, q1, v1, q2, v2 = y[L.POSITION0], y[L.VELOCITY0], y[Q1], y[V1], y[Q2], y[V2]
    for i in range(run.layout[L.N_Q]):
        v[i] = (18 * v0[i] - 9 * v1[i] + 2 * v2[i] + 6 * h * a[i]) / 11
        q[i] = (18 * q0[i] - 9 * q1[i] + 2 * q2[i] + 6 * h * v[i]) / 11


@kernel
def finish(h, run):
    y = run.vectors
    for i in range(run.layout[L.N_Q]):
        y[Q2, i], y[V2, i] = y[Q1, i], y[V1, i]
        y[Q1, i], y[V1, i] = y[L.POSITION0, i], y[L.VELOCITY0, i]
'''
#: BDF3 is not A-stable: in these tests, the nearly undamped modes of flexible beams grow with the steps. A copy of the
#: package compiles every model again: models without a constraint, body or law of their own are left out.
CHOSEN = "bdf3 and not (flexible or double_pendulum or seven_body or crank_ivp or spring_mass or four_bar)"
#: file -> tests of it that have to run on the method, each at least this number of times
CHECKS = {
    "verification/test_orders.py": {"test_order_of_positions_velocities_and_reactions": 1},
    "verification/test_nonholonomic.py": {"test_chaplygin_sleigh": 1, "test_rolling_disc": 1},
    "verification/test_jumps_at_steps.py": {"test_order_is_kept": 1},
    "verification/test_redundant.py": {"test_parallelogram": 1, "test_start_in_a_singular_pose": 1},
    "verification/test_default_steps.py": {"test_what_is_taken_where_nothing_is_said": 1},
    "models/test_every_model.py": {"test_run": 8},
    "unit/simulation/test_stepping.py": {
        "test_order_over_jumps_of_inputs": 1, "test_reaction_behind_a_jump": 1, "test_the_same_as_in_one_go": 1
    },
    "unit/simulation/test_checkpoint.py": {"test_stopped_and_resumed": 1},
    "unit/integrators/test_run.py": {
        "test_options_of_every_method": 1, "test_stop_times_are_hit_exactly": 3, "test_output_between_steps": 1,
        "test_the_same_twice_and_in_pieces": 1, "test_not_a_number_stops_with_results_so_far": 2,
        "test_a_drive_beyond_reach": 1, "test_counts": 1
    },
    "unit/integrators/test_no_allocation.py": {
        "test_python_does_the_same_for_ten_steps_as_for_ten_thousand": 1, "test_step_loops_call_mathematics_only": 1
    },
}  # fmt: skip
UNCOMPILED = """
import json, runpy
names = runpy.run_path({script!r}, run_name="script")
path = next(m for m in names["MODELS"] if m.stem == "slider_crank")
print(json.dumps(names["contraction"](path, "bdf3", 1e-2, False)))
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """Environment of processes in which the file is in the package."""
    root = tmp_path_factory.mktemp("copy")
    shutil.copytree(PACKAGE, root / "mbdsl", ignore=shutil.ignore_patterns("__pycache__"))
    (root / "mbdsl" / "integrators" / "methods" / "bdf3.py").write_text(METHOD, encoding="utf-8")
    return {**os.environ, "PYTHONPATH": str(root), "MBDSL_CACHE_DIR": str(cache_folder.own())}


def output(environment, where, *command, code=0):
    done = subprocess.run(
        [sys.executable, *map(str, command)], capture_output=True, text=True, env=environment, cwd=where, check=False
    )
    assert done.returncode == code, done.stdout[-5000:] + done.stderr[-5000:]
    return done.stdout + done.stderr


def test_every_check_of_all_methods_runs_on_it(environment, tmp_path):
    files = [TESTS / name for name in CHECKS]
    said = output(
        environment, tmp_path, "-m", "pytest", "-v", "-k", CHOSEN, "-p", "no:cacheprovider", "-p", "no:xdist",
        f"--rootdir={TESTS.parent}", "-c", TESTS.parent / "pyproject.toml", *files,
    )  # fmt: skip
    passed = re.findall(r"/(\w+)\.py::(\w+)\[[^\]]*bdf3[^\]]*\] PASSED", said)
    for name, tests in CHECKS.items():
        for test, count in tests.items():
            assert passed.count((Path(name).stem, test)) >= count, f"{test} of {name}"
    assert "failed" not in said.splitlines()[-1]


def test_its_correction_is_newtons(environment, tmp_path):
    """One correction leaves only rounding of an error, as with the other methods of index 3."""
    code = UNCOMPILED.format(script=str(TESTS / "unit" / "integrators" / "uncompiled.py"))
    largest, _ = eval(output({**environment, "MBDSL_NO_COMPILE": "1"}, tmp_path, "-c", code))
    assert largest < 1e-8


@pytest.mark.parametrize(
    ("taken", "changed", "expected"),
    [
        ("correct, matrix, motion, residual", "", "method incomplete has no kernel finish(h, run)"),
        ("correct, finish, matrix, motion", "", "method incomplete has no kernel residual(h, run)"),
        (
            "correct, finish, matrix, motion, residual",
            "@kernel\ndef motion(run): ...",
            "the kernel motion of method incomplete takes (run), expected (h, run)",
        ),
        (
            "correct, finish, matrix, motion, residual",
            "def finish(h, run): ...",
            "finish of method incomplete is not marked as a kernel",
        ),
    ],
)
def test_kernels_are_checked(taken, changed, expected, tmp_path, monkeypatch):
    from mbdsl import integrators
    from mbdsl.integrators import methods

    text = f"""
from mbdsl.kernels.marks import kernel
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.nstiff import {taken}

METHOD = Method("incomplete", doc="", order=1, index=3, enforces=("Phi",), source="")

{changed}
"""
    (tmp_path / "incomplete_method.py").write_text(text, encoding="utf-8")
    monkeypatch.setattr(methods, "__path__", [*methods.__path__, str(tmp_path)])
    try:
        with pytest.raises(mbdsl.errors.UsageError) as refused:
            list(integrators.modules.__wrapped__())
    finally:
        sys.modules.pop("mbdsl.integrators.methods.incomplete_method", None)
    assert refused.value.message == expected


def test_the_command_line_has_it(environment, tmp_path):
    listed = output(environment, tmp_path, "-m", "mbdsl", "methods")
    assert re.search(r"^bdf3 +order 3, index 3, enforces Phi$", listed, re.MULTILINE)
    assert "    --theta 1  (0.5 to 1.5)  scales nothing" in listed
    model = TESTS.parent / "models" / "pendulum.mbd"
    run = ["-m", "mbdsl", "simulate", model, "--method", "bdf3", "--step", "1ms", "--stop", "0.1"]
    assert "100 steps of bdf3" in output(environment, tmp_path, *run, "--theta", "0.75")
    assert "theta = 2 is outside [0.5, 1.5]" in output(environment, tmp_path, *run, "--theta", "2", code=2)
    assert "bdf3 has no error-controlled steps" in output(environment, tmp_path, *run[:-4], "--tol", "1e-4", code=2)
