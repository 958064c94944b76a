"""Compilation of a method's step loop: the shared loop with the kernels of the method's step."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from mbdsl.compilation import code_cache
from mbdsl.integrators import method_files, modules
from mbdsl.integrators.loop import driver, multistep, step_control
from mbdsl.integrators.loop.run_data import Formulas, RunData, Step
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
    """The name of the emitted module with the step loop of a method; methods with the same kernels share it."""
    return "mbdsl_method_" + _with_kernels_of(modules()[method]).__name__.rsplit(".", 1)[-1]


def _with_kernels_of(module: ModuleType) -> ModuleType:
    """The first module of a method with the kernels of ``module``, if that defines none itself."""
    kernels = _kernels(module)
    if any(defined == module.__name__ for _, defined, _ in kernels):
        return module
    return next((other for other in modules().values() if _kernels(other) == kernels), module)


def _kernels(module: ModuleType) -> list[tuple[str, str, str]]:
    found = [(name, value) for name, value in vars(module).items() if hasattr(value, "__mbdsl_kernel__")]
    return sorted((name, value.__module__, value.__name__) for name, value in found)


def has_own_step(method: str) -> bool:
    """Whether a method brings its own step (kernel ``take``) in place of the common one."""
    return method in modules() and hasattr(modules()[method], "take")


def controls_locally(method: str) -> bool:
    """Whether the lengths of a method's steps are controlled by :mod:`mbdsl.integrators.loop.step_control`."""
    return method in modules() and not has_own_step(method)


def compiled(name: str, module: ModuleType) -> Callable:
    """Compile the step loop of one method, with its kernels; the functions of the scene are arguments (pointers)."""
    module = _with_kernels_of(module)
    short = module.__name__.rsplit(".", 1)[-1]
    if has_own_step(name):
        formulas = "method.SCHEME" if hasattr(module, "SCHEME") else "None"
        whose, used = "method", [driver]
    else:
        of = {f: "method" if hasattr(module, f) or f not in CONTROL else "step_control" for f in Formulas._fields}
        formulas = f"run_data.Formulas({', '.join(f'{of[f]}.{f}' for f in of)})"
        whose, used = "multistep", [driver, multistep, step_control]
    found = f"from mbdsl.integrators.methods import {short}" if module.__package__ else f"import {short}"
    text = f'''"""Emitted by mbdsl: the step loop of {short}."""

from mbdsl.integrators.loop import {", ".join(sorted(["run_data", *(m.__name__.rsplit(".", 1)[-1] for m in used)]))}
{found} as method


def advance(steps, times, out, {_BUFFERS}):
    run = run_data.RunData({_BUFFERS})
    step = run_data.Step({", ".join(f"{whose}.{f}" for f in Step._fields)})
    return driver.advance(step, {formulas}, steps, times, out, run)
'''
    with method_files.compiling(module):
        return code_cache.functions(loop_name(name), text, {"advance": ADVANCE}, lambda: [*used, module])[0]
