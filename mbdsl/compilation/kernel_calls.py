"""Calls in kernels: of other kernels, of compiled functions by their address, of mathematical functions."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable

from mbdsl.compilation.kernel_code import Code, returned, translates
from mbdsl.compilation.kernel_expressions import comparison
from mbdsl.compilation.kernel_types import (
    BOOL,
    FLOAT,
    INT,
    Array,
    Fixed,
    Group,
    Pointer,
    Scalar,
    Untranslatable,
    Value,
    constant,
    group,
    join,
    of_argument,
)
from mbdsl.kernels import marks

#: functions of floats -> the intrinsic or the function of the C library
INTRINSICS = {"sin": "llvm.sin.f64", "cos": "llvm.cos.f64", "sqrt": "llvm.sqrt.f64", "exp": "llvm.exp.f64"}
INTRINSICS |= {"log": "llvm.log.f64", "log10": "llvm.log10.f64", "floor": "llvm.floor.f64", "ceil": "llvm.ceil.f64"}
LIBRARY = {name: name for name in "tan sinh cosh tanh hypot atan2 asin acos atan".split()}
LIBRARY |= {"arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"}
OF_TWO = ("hypot", "atan2", "arctan2")


@translates(ast.Call)
def _call(code: Code, node: ast.Call) -> Value:
    match node:
        case ast.Call(ast.Name("tuple"), [ast.GeneratorExp(element, [generator])], []):
            return _tuple_of(code, element, generator)
    function = code.value(node.func)
    arguments = [code.value(x) for x in node.args]
    named = {x.arg: code.value(x.value) for x in node.keywords}
    if isinstance(function.type, Pointer):
        return pointer_call(code, function, arguments)
    if not isinstance(function.type, Fixed):
        raise Untranslatable(f"`{ast.unparse(node)}`")
    called = function.type.value
    if isinstance(called, type) and hasattr(called, "_fields"):
        return group([*arguments, *(named[f] for f in called._fields[len(arguments) :])], called)
    if callable(called) and getattr(called, "__mbdsl_kernel__", False):
        return kernel_call(code, called, arguments, named)
    if named or not callable(called):
        raise Untranslatable(f"`{ast.unparse(node)}`")
    return builtin_call(code, called, arguments, node)


def _tuple_of(code: Code, element: ast.expr, generator: ast.comprehension) -> Value:
    """``tuple(element for name in items)``, the items of a tuple."""
    over = code.value(generator.iter)
    if not isinstance(over.type, Group) or not isinstance(generator.target, ast.Name) or generator.ifs:
        raise Untranslatable(f"a tuple from `{ast.unparse(generator).strip()}`")
    outside, found = dict(code.bound), []
    for item in over.items:
        code.bound[generator.target.id] = item
        found.append(code.value(element))
    code.bound = outside
    return group(found)


def kernel_call(code: Code, called: Callable, arguments: list[Value], named: dict) -> Value:
    bound = inspect.signature(called).bind(*arguments, **named)
    bound.apply_defaults()
    given = [x if isinstance(x, Value) else constant(x) for x in bound.arguments.values()]
    symbol, gives = code.module.kernel(called, tuple(x.type for x in given))
    passed = ", ".join(f"{leaf} {x}" for v in given for leaf, x in zip(v.type.leaves, v.leaves, strict=True))
    if not gives.leaves:
        code.lines.append(f"  call void {symbol}({passed})")
        return Value(gives)
    result = code.new(f"call {returned(gives)} {symbol}({passed})")
    if len(gives.leaves) == 1:
        return Value(gives, (result,))
    return Value(
        gives,
        tuple(code.new(f"extractvalue {returned(gives)} {result}, {k}") for k in range(len(gives.leaves))),
    )


def pointer_call(code: Code, function: Value, arguments: list[Value]) -> Value:
    """The call of a compiled function by its address."""
    assert isinstance(function.type, Pointer)
    signature = function.type.signature
    given = [code.converted(x, of_argument(kind)) for kind, x in zip(signature.takes, arguments, strict=True)]
    passed = ", ".join(f"{leaf} {x}" for v in given for leaf, x in zip(v.type.leaves, v.leaves, strict=True))
    if signature.gives == "int":
        return Value(INT, (code.new(f"call i64 {function.leaves[0]}({passed})"),))
    code.lines.append(f"  call void {function.leaves[0]}({passed})")
    return constant(None)


def builtin_call(code: Code, called: Callable, arguments: list[Value], node: ast.Call) -> Value:
    if called is marks.square:
        of, at, size = arguments
        place = code.new(f"getelementptr inbounds double, ptr {of.leaves[0]}, i64 {at.leaves[0]}")
        return Value(Array(2, FLOAT), (place, size.leaves[0], size.leaves[0]))
    if called is len and isinstance(arguments[0].type, Array):
        return Value(INT, (arguments[0].leaves[1],))
    if called is len and isinstance(arguments[0].type, Group):
        return constant(len(arguments[0].items))
    if not arguments or not all(isinstance(x.type, Scalar) for x in arguments):
        raise Untranslatable(f"`{ast.unparse(node)}`")
    if called in (max, min) and len(arguments) > 1:
        return extreme(code, ast.Gt() if called is max else ast.Lt(), arguments)
    if called is abs:
        (x,) = arguments
        if x.type == FLOAT:
            fabs = code.module.declare("llvm.fabs.f64", "double", ("double",))
            return Value(FLOAT, (code.new(f"call double {fabs}(double {x.leaves[0]})"),))
        x = code.number(x, INT)
        absolute = code.module.declare("llvm.abs.i64", "i64", ("i64", "i1"))
        return Value(INT, (code.new(f"call i64 {absolute}(i64 {x.leaves[0]}, i1 false)"),))
    if called in (int, float, bool):
        return code.number(arguments[0], {int: INT, float: FLOAT, bool: BOOL}[called])
    name = getattr(called, "__name__", "")
    of_math = getattr(called, "__module__", "") == "math" or type(called).__name__ == "ufunc"
    if of_math and (name in INTRINSICS or name in LIBRARY) and len(arguments) == 1 + (name in OF_TWO):
        words = [code.number(x, FLOAT).leaves[0] for x in arguments]
        symbol = INTRINSICS.get(name) or LIBRARY[name]
        symbol = code.module.declare(symbol, "double", ("double",) * len(words))
        result = code.new(f"call double {symbol}({', '.join(f'double {x}' for x in words)})")
        if name in ("floor", "ceil") and type(called).__name__ != "ufunc":  # those of the module math give integers
            return code.number(Value(FLOAT, (result,)), INT)
        return Value(FLOAT, (result,))
    raise Untranslatable(f"`{ast.unparse(node)}`: this function is not available in kernels")


def extreme(code: Code, op: ast.cmpop, arguments: list[Value]) -> Value:
    """max or min; if values are equal or NaN, the same one as in Python."""
    found = arguments[0]
    for x in arguments[1:]:
        kind = join(found.type, x.type)
        kind = INT if kind == BOOL else kind
        found, x = code.converted(found, kind), code.converted(x, kind)
        test = comparison(code, op, x, found).leaves[0]
        leaf = kind.leaves[0]
        found = Value(kind, (code.new(f"select i1 {test}, {leaf} {x.leaves[0]}, {leaf} {found.leaves[0]}"),))
    return found
