"""Calls of compiled functions from Python, by address; arrays are passed as address and shape."""

from __future__ import annotations

import ctypes
import struct
import weakref
from collections.abc import Callable
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np


class Signature(NamedTuple):
    """Types of the arguments and of the result of a compiled function.

    Arguments are "float", "int", arrays ("vector" and "matrix" of floats, "ints", "int matrix"), or other compiled
    functions, given by their signatures; the result is "int" or "none".
    """

    takes: tuple[str | Signature, ...]
    gives: str = "none"


#: kind of an array -> number of axes, and type of its entries
ARRAYS: dict[object, tuple[int, np.dtype]] = {
    "vector": (1, np.dtype(np.float64)),
    "matrix": (2, np.dtype(np.float64)),
    "ints": (1, np.dtype(np.int64)),
    "int matrix": (2, np.dtype(np.int64)),
}


#: number of sets of arrays whose addresses are kept: those of a run, and of the System that it belongs to
KEPT = 2


class Native:
    """A compiled function, called by its address; other compiled functions may be among its arguments.

    A call from Python passes all arguments in one block, because the time of such a call grows with the number of its
    arguments. Arrays are passed as address and shape.
    """

    def __init__(self, address: int, packed: int, signature: Signature, owner: object) -> None:
        gives = ctypes.c_int64 if signature.gives == "int" else None
        self._call: Callable = ctypes.CFUNCTYPE(gives, ctypes.c_char_p)(packed)
        self._arrays = [ARRAYS.get(kind) for kind in signature.takes]
        words = ["d" if k == "float" else "q" * (1 + ARRAYS[k][0] if k in ARRAYS else 1) for k in signature.takes]
        self._pack: Callable = struct.Struct("=" + "".join(words)).pack
        starts = [0, *accumulate(map(len, words))]
        others = [(k, starts[k]) for k, kind in enumerate(self._arrays) if kind is None]
        self._numbers = [(k, at) for k, at in others if isinstance(signature.takes[k], str)]
        self._functions = [(k, at) for k, at in others if not isinstance(signature.takes[k], str)]
        self._blocks: list[tuple[list, list]] = []  #: of the last arguments, the latest first
        self.address, self.signature = address, signature
        self._owner = owner  # keeps the machine code in memory

    def __call__(self, *arguments):
        return self._call(self._block(arguments))

    def prepared(self, *arguments) -> Callable[[float], int]:
        """A function of the first argument, a number, for many calls with the same other arguments.

        It keeps the arrays alive, and the content of the arrays may change.
        """
        call, blocks, others = self._call, dict[float, bytes](), self._block(arguments)[8:]
        head: Callable = struct.Struct("=d" if isinstance(arguments[0], float) else "=q").pack

        def prepared(first: float, kept: tuple = arguments) -> int:
            block = blocks.get(first)
            if block is None:
                if len(blocks) > 64:
                    blocks.clear()
                block = blocks[first] = head(first) + others
            return call(block)

        return prepared

    def _block(self, arguments: tuple) -> bytes:
        """The arguments as one block of bytes."""
        words = list(self._known(arguments))
        for k, at in self._numbers:
            words[at] = arguments[k]
        for k, at in self._functions:
            x = arguments[k]
            words[at] = x.address if isinstance(x, Native) else x
        return self._pack(*words)

    def _known(self, arguments: tuple) -> list:
        """The block of words with addresses and shapes of the arrays among the arguments."""
        blocks = self._blocks if len(arguments) == len(self._arrays) else []
        for i, (arrays, words) in enumerate(blocks):
            for k, known in arrays:
                if known() is not arguments[k]:
                    break
            else:
                if i:
                    blocks.insert(0, blocks.pop(i))
                return words
        blocks.insert(0, self._look_at(arguments))
        del blocks[KEPT:]
        return blocks[0][1]

    def _look_at(self, arguments: tuple) -> tuple[list, list]:
        """Weak references to the arrays among the arguments, and a block of words with their addresses and shapes.

        Both are kept for the next call, which mostly has the same arrays: to get the address of an array takes longer
        than the call.
        """
        arrays, words, places = [], [], []
        for k, (x, kind) in enumerate(zip(arguments, self._arrays, strict=True)):
            if kind is None:
                words.append(0)
            elif x.dtype == kind[1] and x.ndim == kind[0] and x.flags.c_contiguous:
                arrays.append((k, weakref.ref(x)))
                words += (_address(x), *x.shape)
                places.append((words[-len(x.shape) - 1], x.nbytes))
            else:
                raise TypeError(f"compiled code takes C-contiguous arrays of {kind[1]}")
        # compiled code keeps entries of one array in registers while it writes to others
        places = sorted(place for place in places if place[1])
        if any(start + size > after for (start, size), (after, _) in pairwise(places)):
            raise ValueError("compiled code takes arrays that do not overlap")
        return arrays, words


def _address(x: np.ndarray) -> int:
    """Address of the entries of an array; ``x.ctypes.data`` takes five to twenty times as long."""
    if x.size and x.flags.writeable:
        return ctypes.addressof(ctypes.c_char.from_buffer(x.data))
    return int(x.__array_interface__["data"][0])
