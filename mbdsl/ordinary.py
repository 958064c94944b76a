"""Compilation with what numba promises: slower, and numba is imported in every run.

Where :mod:`mbdsl.machine` fails, this takes over; it gives functions of the same kind.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from numba import cfunc, config, njit, types
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import populate_array

from mbdsl import kernels
from mbdsl.jit import Native, Signature

TYPES = {
    "none": types.void,
    "float": types.float64,
    "int": types.int64,
    "vector": types.Array(types.float64, 1, "C"),
    "matrix": types.Array(types.float64, 2, "C"),
    "ints": types.Array(types.int64, 1, "C"),
    "int matrix": types.Array(types.int64, 2, "C"),
}


def numba_signature(signature: Signature):
    return TYPES[signature.gives](*(numba_type(kind) for kind in signature.takes))


def numba_type(kind: str | Signature):
    """The numba type of an argument; functions are pointers."""
    return TYPES[kind] if isinstance(kind, str) else types.ExternalFunctionPointer(numba_signature(kind), None)


@type_callable(kernels.square)
def _type_square(context):
    return lambda F, at: TYPES["matrix"]


@lower_builtin(kernels.square, types.Array, types.Integer)
def _square(context, builder, signature, arguments):
    """Only the view: reshape would call a function that comes with numba."""
    F = context.make_array(signature.args[0])(context, builder, arguments[0])
    six, row, entry = (context.get_constant(types.intp, k) for k in (6, 48, 8))
    view = context.make_array(signature.return_type)(context, builder)
    populate_array(view, builder.gep(F.data, [arguments[1]]), (six, six), (row, entry), entry, None)
    return view._getvalue()


def compile_kernel(function: Callable, **options) -> Callable:
    return njit(error_model="numpy", _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)(function)


def compile_function(function: Callable, signature: Signature, folder: Path) -> Native:
    """A function that Python and other such functions may call; kept in ``folder``."""
    former, config.CACHE_DIR = config.CACHE_DIR, str(folder)
    try:
        made = cfunc(numba_signature(signature), cache=True, error_model="numpy", _nrt=False)(function)
    finally:
        config.CACHE_DIR = former
    return Native(made.address, signature, made)
