"""Kernels to LLVM code: a translator for the part of Python in which kernels are written (docs/kernels.md).

A kernel is translated once for each combination of argument types; functions among the arguments are constants of that
translation. Each kind of statement and expression has a function, marked by
:func:`mbdsl.compilation.kernel_code.translates`, which adds instructions to a ``Code``. Variables are memory on the
stack, which LLVM turns into registers. The types of variables follow from their assignments; if an assignment requires
a wider type than the code before it assumes, the kernel is translated again.

The code has the same results with every level of optimisation, because LLVM does not reorder floating-point operations.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping

from mbdsl.compilation import kernel_arrays, kernel_calls, kernel_expressions  # noqa: F401  (their translations)
from mbdsl.compilation.kernel_code import RESULT, Code, Widened, returned
from mbdsl.compilation.kernel_sources import place_of
from mbdsl.compilation.kernel_statements import translate_body
from mbdsl.compilation.kernel_types import INT, NOTHING, Array, Fixed, Type, Untranslatable, describe, of_argument
from mbdsl.compilation.llvm_module import Module
from mbdsl.compilation.native_call import Signature
from mbdsl.errors import MbdslError

LIMIT = 100  #: attempts to find the types of variables; each widens one of them, and few need more than three
HINT = "docs/kernels.md lists the part of Python that is compiled"


def translate(name: str, functions: Mapping[str, Callable], signatures: Mapping[str, Signature]) -> str:
    """LLVM code of a module with the entries ``name.function`` and ``name.function.packed``.

    Raises
    ------
    Untranslatable
        If a kernel contains something that is not translated.
    """
    module = Module(_translated)
    for key, function in functions.items():
        _add_entries(module, f"{name}.{key}", function, signatures[key])
    return module.text()


def _translated(module: Module, function: Callable, symbol: str, takes: tuple[Type, ...], apart: bool) -> Type:
    """Add the translation of a kernel for one combination of argument types to a module; the type of its result."""
    types: dict[str, Type] = {}
    for _ in range(LIMIT):
        code = Code(module, function, takes, types)
        try:
            _translate_kernel(code)
        except Widened:
            continue
        except Exception as problem:  # such as a TypeError for a missing argument of a call
            if isinstance(problem, Untranslatable) and problem.span is not None:
                raise
            raise _placed(problem, code.node, function) from problem
        gives = types.get(RESULT, NOTHING)
        if isinstance(gives, Fixed) and gives is not NOTHING and gives.value is not None:
            raise Untranslatable(f"`{function.__name__}` returns {describe(gives)}")
        arguments = [
            f"{leaf}{' noalias' if apart and i == 0 and isinstance(kind, Array) else ''} %in.{k}.{i}"
            for k, kind in enumerate(takes)
            for i, leaf in enumerate(kind.leaves)
        ]
        inlined = "#1" if hasattr(function, "__mbdsl_rare__") else "#0"
        head = f"define internal {returned(gives)} {symbol}({', '.join(arguments)}) {inlined} {{"
        module.lines += [head, "entry:", *code.variables, *code.lines, "}"]
        return gives
    raise Untranslatable(f"the types of the variables of `{function.__name__}` are not found")


def _translate_kernel(code: Code) -> None:
    for name, value in code.given.items():
        if name in code.assigned:
            code.assign_name(name, value)
    translate_body(code, code.tree.body)
    if not code.ended:
        if RESULT in code.types and code.types[RESULT] != NOTHING:
            raise Untranslatable("one end of the function returns a value, and another does not")
        code.end("ret void")


def _placed(problem: Exception, node: ast.AST, function: Callable) -> Untranslatable:
    """The error with the statement of the kernel that is not translated."""
    if isinstance(problem, MbdslError):
        what, remedy = problem.message, problem.hint or HINT
    else:
        what, remedy = f"{type(problem).__name__}: {problem}", HINT
    hint = f"{remedy}; MBDSL_NO_COMPILE=1 runs kernels as Python"
    return Untranslatable(f"cannot compile the kernel {function.__name__}: {what}", place_of(function, node), hint)


def _add_entries(module: Module, name: str, function: Callable, signature: Signature) -> None:
    """Two entries for a kernel: ``name`` takes numbers, addresses of functions, and arrays as address and shape, for
    calls by address; ``name.packed`` takes the address of a block with these words, for calls from Python."""
    kinds = tuple(of_argument(kind) for kind in signature.takes)
    symbol, gives = module.kernel(function, kinds, apart=True)
    if gives != (INT if signature.gives == "int" else NOTHING):
        raise Untranslatable(f"`{function.__name__}` returns {describe(gives)}")
    result = "i64" if signature.gives == "int" else "void"
    leaves = [leaf for kind in kinds for leaf in kind.leaves]
    module.lines += [
        f'@"{name}" = alias {result} ({", ".join(leaves)}), ptr {symbol}',
        f'define {result} @"{name}.packed"(ptr %block) nounwind {{',
    ]
    for k, leaf in enumerate(leaves):
        module.lines += [f"  %p{k} = getelementptr i64, ptr %block, i64 {k}", f"  %w{k} = load {leaf}, ptr %p{k}"]
    kept, value = ("", "") if result == "void" else ("%r = ", " %r")
    passed = ", ".join(f"{leaf} %w{k}" for k, leaf in enumerate(leaves))
    module.lines += [f"  {kept}call {result} {symbol}({passed})", f"  ret {result}{value}", "}"]
