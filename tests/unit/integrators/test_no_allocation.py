"""The step loop runs no Python and allocates nothing, however many steps it takes."""

import gc
import re
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.compilation import code_cache, translation
from mbdsl.compilation.kernel_types import Untranslatable
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators import compiled as methods
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.compiled_loop import loop_name
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import build

MODELS = Path(__file__).parents[3] / "models"
FEW, MANY = 10, 10_000
#: model -> step: springs; laws; friction and driven frames; nonholonomic rows; drivers
STEPS = {"slider_crank": 1e-3, "seven_body": 1e-5, "stick_slip_belt": 5e-5, "rolling_disc": 1e-3, "driven_crank": 1e-3}

pytestmark = pytest.mark.skipif(not code_cache.enabled(), reason="uncompiled, everything is Python")


def running(model, method, tol=None):
    """A running integration that writes every tenth step, after its first steps, which do some work once."""
    mechanism = graph.build(mbdsl.load(MODELS / f"{model}.mbd"))
    system, h = build(mechanism.scene, mechanism), STEPS[model]
    steps = 2 * MANY
    start = initial_state(system, mechanism, 0.0)
    run = MethodRun(system, method, h, 0.0, steps * h, 10 * h * np.arange(1, steps // 10 + 1), tol=tol)
    run.begin(start.q, start.v, start.a, start.lam, start.redundant)
    for count in (FEW, FEW):
        run.advance(count)
    return run


def calls(run, steps):
    """Calls of Python functions that the profiler sees while the loop takes ``steps`` steps."""
    found = []
    before, former = int(run.integers[S.STEP]), sys.getprofile()
    sys.setprofile(lambda frame, event, argument: found.append(event))
    try:
        status = run.advance(steps)
    finally:
        sys.setprofile(former)
    assert status == S.RUNNING and run.integers[S.STEP] - before == steps
    return found


def memory(run, steps):
    """Blocks of Python's allocator that are left, and the peak of allocated bytes, including those of numpy."""
    gc.collect()
    tracemalloc.start()
    try:
        blocks = sys.getallocatedblocks()
        run.advance(steps)
        blocks = sys.getallocatedblocks() - blocks
        return blocks, tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("method", sorted(methods()))
@pytest.mark.parametrize("model", STEPS)
def test_python_does_the_same_for_ten_steps_as_for_ten_thousand(model, method):
    run = running(model, method)
    few, many = calls(run, FEW), calls(run, MANY)
    assert few
    assert few == many
    assert run.pivoting_from is None


@pytest.mark.parametrize("model", STEPS)
def test_no_memory_is_taken(model):
    run = running(model, "hht-si2")
    memory(run, FEW)  # the measurement itself allocates on its first use
    (blocks, peak), (more_blocks, more_peak) = memory(run, FEW), memory(run, MANY - 5 * FEW)
    # a few objects of the call itself; one float a step would be a hundred times this
    assert abs(more_blocks - blocks) < 100
    assert abs(more_peak - peak) < 4096


def test_the_measure_sees_allocations():
    class Wasteful:
        kept = ()

        def advance(self, steps):
            self.kept = [float(k) for k in range(steps)]

    assert memory(Wasteful(), MANY)[0] - memory(Wasteful(), FEW)[0] > MANY / 2
    assert memory(Wasteful(), MANY)[1] - memory(Wasteful(), FEW)[1] > 8 * MANY


# -- the compiled code itself ----------------------------------------------------------------------------------------


#: functions of C that compiled code may call: none of them allocates or uses Python
MATHEMATICS = re.compile(r"(a?(sin|cos|tan)h?|atan2|exp|log|log10|sqrt|pow|hypot|floor|ceil|fmod|mem(set|cpy|move))")


def symbols(name):
    """The external symbols of a module's stored machine code."""
    body = code_cache._body(name)
    assert body is not None
    return body.split(b"\n", 4)[3].decode().split()


@pytest.mark.parametrize("model", ["stick_slip_belt", "rolling_disc"])
def test_compiled_code_calls_mathematics_only(model):
    mechanism = graph.build(mbdsl.load(MODELS / f"{model}.mbd"))
    system = build(mechanism.scene, mechanism)
    for sets in (1, 2, 3):
        system.kernels(sets)
        found = symbols(system.module_name(sets))
        assert {"tan", "hypot"} <= set(found)  # they come from the tape: the list is not empty
        assert [name for name in found if not MATHEMATICS.fullmatch(name)] == []


@pytest.mark.parametrize("method", sorted(methods()))
def test_step_loops_call_mathematics_only(method):
    running("slider_crank", method)
    assert [name for name in symbols(loop_name(method)) if not MATHEMATICS.fullmatch(name)] == []


def test_what_allocates_does_not_compile():
    text = "import numpy as np\n\ndef allocates(n):\n    return np.zeros(n).size\n"
    try:
        module = code_cache.import_text("mbdsl_test_allocates", text)
        with pytest.raises(Untranslatable, match=r":4:5: cannot compile the kernel allocates: `np.zeros\(n\)`"):
            translation.translate("a", {"f": module.allocates}, {"f": code_cache.Signature(("int",), gives="int")})
    finally:
        sys.modules.pop("mbdsl_test_allocates", None)
