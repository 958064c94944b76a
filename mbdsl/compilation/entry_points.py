"""Entry points of compiled functions, as LLVM code. They differ in the form of the arguments:

    plain    numbers and addresses of functions; of an array, its address and shape: the form of calls by address
    block    the address of a block of words with the plain arguments: the form of calls from Python
    numba    as plain, but an array is seven or more words: two addresses that numba manages, number of entries, size of
             an entry, address, shape and strides

The fewer words a call passes, the less it costs: a step of a pendulum takes 4 to 12 % less than with the form of numba.
"""

from __future__ import annotations

from collections.abc import Sequence

from mbdsl.compilation.kernel_types import Array, of_argument
from mbdsl.compilation.native_call import Signature

#: words of an array in numba's form before its shape; the last of them is its address
BEFORE_SHAPE = ("ptr", "ptr", "i64", "i64", "ptr")


def block_entry(name: str, called: str, signature: Signature) -> list[str]:
    """The function ``name``, which calls the function ``called`` with the plain arguments in a block."""
    lines, passed = [], []
    for k, leaf in enumerate(leaf for kind in signature.takes for leaf in of_argument(kind).leaves):
        lines += [f"  %p{k} = getelementptr i64, ptr %block, i64 {k}", f"  %w{k} = load {leaf}, ptr %p{k}"]
        passed.append(f"{leaf} %w{k}")
    return _function(name, signature, ["ptr %block"], lines, called, passed)


def from_numba(name: str, address: int, signature: Signature) -> list[str]:
    """The function ``name`` with plain arguments, which calls a function in numba's form."""
    takes, lines, passed = [], [], []
    for k, kind in enumerate(map(of_argument, signature.takes)):
        own = [f"{leaf} %a{k}.{i}" for i, leaf in enumerate(kind.leaves)]
        takes += own
        if not isinstance(kind, Array):
            passed += own
            continue
        count, strides = f"%a{k}.1", ["i64 8"]
        if kind.axes == 2:
            lines += [f"  %a{k}.n = mul i64 %a{k}.1, %a{k}.2", f"  %a{k}.s = mul i64 %a{k}.2, 8"]
            count, strides = f"%a{k}.n", [f"i64 %a{k}.s", "i64 8"]
        passed += ["ptr null", "ptr null", f"i64 {count}", "i64 8", *own, *strides]
    return _function(name, signature, takes, lines, f"inttoptr (i64 {address} to ptr)", passed)


def to_numba(name: str, address: int, signature: Signature) -> list[str]:
    """The function ``name`` in numba's form, which calls a function with plain arguments."""
    takes, passed = [], []
    for k, kind in enumerate(map(of_argument, signature.takes)):
        leaves = [*BEFORE_SHAPE, *["i64"] * (2 * kind.axes)] if isinstance(kind, Array) else kind.leaves
        own = [f"{leaf} %a{k}.{i}" for i, leaf in enumerate(leaves)]
        takes += own
        first = len(BEFORE_SHAPE) - 1
        passed += own[first : first + len(kind.leaves)] if isinstance(kind, Array) else own
    return _function(name, signature, takes, [], f"inttoptr (i64 {address} to ptr)", passed)


def result(signature: Signature) -> str:
    """The LLVM type of the result."""
    return "i64" if signature.gives == "int" else "void"


def _function(
    name: str, signature: Signature, takes: Sequence[str], lines: Sequence[str], called: str, passed: Sequence[str]
) -> list[str]:
    gives = result(signature)
    kept, value = ("", "") if gives == "void" else ("%r = ", " %r")
    return [
        f'define {gives} @"{name}"({", ".join(takes)}) nounwind {{',
        *lines,
        f"  {kept}call {gives} {called}({', '.join(passed)})",
        f"  ret {gives}{value}",
        "}",
    ]
