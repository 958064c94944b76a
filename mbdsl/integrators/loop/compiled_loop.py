"""Compilation of a method's step loop: the shared driver with the method's kernels, or the method's own loop."""

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
#: kernels of controlled steps; a method that lacks one gets the default in ``step_control``
CONTROL = ("estimate", "local_error", "change_step")
_BUFFERS = ", ".join(RunData._fields)


def loop_name(method: str) -> str:
    """The name of the emitted module with the step loop of a method."""
    return "mbdsl_method_" + modules()[method].__name__.rsplit(".", 1)[-1]


def controls_locally(method: str) -> bool:
    """Whether :mod:`mbdsl.integrators.loop.step_control` controls the steps of a method, and not its own loop."""
    return method in modules() and not hasattr(modules()[method], "advance")


def compiled(name: str, module: ModuleType) -> Callable:
    """Compile the step loop of one method, with its kernels; the functions of the scene are arguments (pointers)."""
    short = module.__name__.rsplit(".", 1)[-1]
    if hasattr(module, "advance"):  # the method has its own step loop
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
