"""The compiled step loop of a method: the shared driver with its kernels, or a loop of its own."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from mbdsl.compilation import code_cache
from mbdsl.integrators import modules
from mbdsl.integrators.loop import driver, step_control
from mbdsl.system.emit import EVALUATE, INERTIA, TANGENT

#: advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out)
ADVANCE = code_cache.Signature(
    (
        *(EVALUATE, TANGENT, INERTIA, "int", "vector", "vector", "ints"),
        *("matrix", "matrix", "matrix", "vector", "ints", "matrix", "int matrix", "vector", "matrix"),
    ),
    gives="int",
)
#: kernels of controlled steps, which methods have, or which do nothing
CONTROL = ("estimate", "local_error", "change_step")


def loop_name(method: str) -> str:
    """The name under which the compiled step loop of a method is kept."""
    return "mbdsl_method_" + modules()[method].__name__.rsplit(".", 1)[-1]


def controls_locally(method: str) -> bool:
    """Whether controlled steps of a method are those of :mod:`mbdsl.integrators.loop.step_control`, and not its own."""
    return method in modules() and not hasattr(modules()[method], "advance")


def compiled(name: str, module: ModuleType) -> Callable:
    """The step loop compiled for one method: its kernels are known to the compiler, the scene's are pointers."""
    short = module.__name__.rsplit(".", 1)[-1]
    if hasattr(module, "advance"):  # it brings a step loop of its own
        text = f'''"""Emitted by mbdsl: the step loop of {name}."""

from mbdsl.integrators.methods import {short} as method


def advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out):
    return method.advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out)
'''
        return code_cache.functions(loop_name(name), text, {"advance": ADVANCE}, lambda: [module])[0]
    text = f'''"""Emitted by mbdsl: the step loop of {name}."""

from mbdsl.integrators.loop import driver, step_control
from mbdsl.integrators.methods import {short} as method


def advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out):
    return driver.advance(
        method.motion, method.residual, method.matrix, method.correct, method.finish,
        {", ".join(f"{'method' if hasattr(module, f) else 'step_control'}.{f}" for f in CONTROL)},
        evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out,
    )
'''
    return code_cache.functions(loop_name(name), text, {"advance": ADVANCE}, lambda: [driver, step_control, module])[0]
