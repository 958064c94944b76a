"""Compilation with numba's public interface only: the fallback if :mod:`mbdsl.compilation.translation` or
:mod:`mbdsl.compilation.object_code` fails.

It returns functions of the same kind, but compilation takes longer, and every run imports numba.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cached_property
from math import prod
from pathlib import Path

from numba import cfunc, config, njit, types
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import populate_array

from mbdsl.compilation import marks, object_code
from mbdsl.compilation.entry_points import from_numba, to_numba
from mbdsl.compilation.native_call import ARRAYS, Native, Signature

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
    """The numba type of an argument; a function is passed as a pointer."""
    return TYPES[kind] if isinstance(kind, str) else types.ExternalFunctionPointer(numba_signature(kind), None)


@type_callable(marks.square)
def _type_square(context):
    return lambda F, at, size: TYPES["matrix"]


@lower_builtin(marks.square, types.Array, types.Integer, types.Integer)
def _square(context, builder, signature, arguments):
    """Code for ``marks.square`` as a view; ``reshape`` would call a function of numba's library."""
    F = context.make_array(signature.args[0])(context, builder, arguments[0])
    entry, size = context.get_constant(types.intp, 8), arguments[2]
    row = builder.mul(size, entry)
    view = context.make_array(signature.return_type)(context, builder)
    populate_array(view, builder.gep(F.data, [arguments[1]]), (size, size), (row, entry), entry, None)
    return view._getvalue()


#: (form, function) -> address of an entry point that calls the function
_entries: dict[tuple[str, Native], int] = {}


class Flat(Native):
    """A compiled function that takes arrays in numba's form (:mod:`mbdsl.compilation.entry_points`); functions among
    its arguments have to do so, too."""

    def __init__(self, address: int, signature: Signature, owner: object) -> None:
        super().__init__(address, address, signature, owner)
        pointer, size = ctypes.c_void_p, ctypes.c_ssize_t
        c_types: list = []
        for kind in signature.takes:
            if kind in ARRAYS:
                c_types += (pointer, pointer, size, size, pointer, *(size,) * (2 * ARRAYS[kind][0]))
            else:
                c_types.append({"float": ctypes.c_double, "int": ctypes.c_int64}.get(str(kind), pointer))
        function = ctypes.CFUNCTYPE(ctypes.c_int64 if signature.gives == "int" else None, *c_types)(address)

        def call(words):
            """Unpack the block of words that :class:`Native` makes, and call the function."""
            pieces: list = []
            for kind in signature.takes:
                if kind in ARRAYS:
                    data, *shape = (next(words) for _ in range(1 + ARRAYS[kind][0]))
                    pieces += (None, None, prod(shape), 8, data, *shape, *([8 * shape[1], 8] if shape[1:] else [8]))
                else:
                    pieces.append(next(words))
            return function(*pieces)

        self._pack, self._call = lambda *words: iter(words), call

    def prepared(self, *arguments) -> Callable[[float], int]:
        return lambda first: self(first, *arguments[1:])

    @cached_property
    def plain(self) -> int:
        return _address("from_numba", from_numba, self)

    def _address_of(self, function: Native) -> int:
        return function.address if isinstance(function, Flat) else _address("to_numba", to_numba, function)


def _address(form: str, entry: Callable, function: Native) -> int:
    """The address of another entry point of a compiled function."""
    if (form, function) not in _entries:
        name = f"mbdsl_{form}_{len(_entries)}"
        code = object_code.compile_object("\n".join(entry(name, function.address, function.signature))).code
        _entries[form, function] = object_code.load(code).get_function_address(name)
    return _entries[form, function]


def compile_kernel(function: Callable, **options) -> Callable:
    return njit(error_model="numpy", _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)(function)


def compile_function(function: Callable, signature: Signature, folder: Path | None) -> Native:
    """Compile a function that Python and compiled functions can call; cache it in ``folder`` if that is possible."""
    options = {"error_model": "numpy", "_nrt": False}
    if folder is not None:
        former, config.CACHE_DIR = config.CACHE_DIR, str(folder)
        try:
            made = cfunc(numba_signature(signature), cache=True, **options)(function)
        except (OSError, RuntimeError):  # numba cannot write its files
            folder = None
        finally:
            config.CACHE_DIR = former
    if folder is None:
        made = cfunc(numba_signature(signature), **options)(function)
    return Flat(made.address, signature, made)
