"""The compiled step loop of a method: the shared driver with its kernels, or a loop of its own."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from mbdsl.compilation import code_cache
from mbdsl.integrators import modules
from mbdsl.integrators.loop import driver, step_control
from mbdsl.integrators.loop.run_data import Formulas, RunData
from mbdsl.system.emit import EVALUATE, INERTIA, TANGENT

#: advance(steps, times, out, *RunData)
ADVANCE = code_cache.Signature(
    (
        *("int", "vector", "matrix", EVALUATE, TANGENT, INERTIA, "vector", "vector", "vector", "ints"),
        *("matrix", "matrix", "matrix", "vector", "ints", "matrix", "int matrix"),
    ),
    gives="int",
)
#: kernels of controlled steps, which methods have, or which do nothing
CONTROL = ("estimate", "local_error", "change_step")
_BUFFERS = ", ".join(RunData._fields)


def loop_name(method: str) -> str:
    """The name under which the compiled step loop of a method is kept."""
    return "mbdsl_method_" + modules()[method].__name__.rsplit(".", 1)[-1]


def controls_locally(method: str) -> bool:
    """Whether controlled steps of a method are those of :mod:`mbdsl.integrators.loop.step_control`, and not its own."""
    return method in modules() and not hasattr(modules()[method], "advance")


def compiled(name: str, module: ModuleType) -> Callable:
    """The step loop compiled for one method: its kernels are known to the compiler, the scene's are pointers."""
    short = module.__name__.rsplit(".", 1)[-1]
    if hasattr(module, "advance"):  # it has a step loop of its own
        called, imports, sources = "method.advance(", "run_data", [module]
    else:
        of = {f: "method" if hasattr(module, f) or f not in CONTROL else "step_control" for f in Formulas._fields}
        called = f"driver.advance(run_data.Formulas({', '.join(f'{of[f]}.{f}' for f in of)}), "
        imports, sources = "driver, run_data, step_control", [driver, step_control, module]
    text = f'''"""Emitted by mbdsl: the step loop of {name}."""

from mbdsl.integrators.loop import {imports}
from mbdsl.integrators.methods import {short} as method


def advance(steps, times, out, {_BUFFERS}):
    run = run_data.RunData({_BUFFERS})
    return {called}steps, times, out, run)
'''
    return code_cache.functions(loop_name(name), text, {"advance": ADVANCE}, lambda: sources)[0]
