"""Scalar expressions in time, the coordinates of frames, inputs and multipliers, with exact derivatives.

An :class:`Expr` is a node of a directed acyclic graph: equal expressions are the same object, so that a derivative
shares its subexpressions with the expression it came from and stays linear in its size. Numbers are SI; units
are checked before an expression gets here (:mod:`mbdsl.lang.units`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable
from typing import Any, ClassVar
from weakref import WeakValueDictionary

#: coordinate key -> key of its time derivative
RATE = {"x": "vx", "y": "vy", "phi": "w"}
COORDINATES = ("x", "y", "phi", "vx", "vy", "w")
#: the velocities among the coordinates of frames, in the plane and in space
_VELOCITIES = frozenset((*RATE.values(), "vz", "wx", "wy", "wz"))
#: operations without arguments whose value varies
LEAVES = ("time", "coordinate", "input", "multiplier")
#: operations with jumps and corners; their payload QUIET: events are not located there
SWITCHING = frozenset("lt le eq ne and or not sign floor ceil mod abs min max".split())
QUIET = "no event"


class Expr:
    """One node: an operation ``op`` on ``args``, with a payload ``value`` for leaves and tables.

    ``op`` is "const" (value: float), a leaf that varies (one of ``LEAVES``: "time", "coordinate" with value (frame,
    key), "input" with value name, "multiplier" with value (joint, k)), "table" (value: (Table, order of derivative)),
    "start" (value: an Expr, see :func:`at_start`) or a key of ``OPERATIONS``, of which those in ``SWITCHING`` may have
    the value ``QUIET``.
    """

    __slots__ = ("__weakref__", "args", "op", "value")
    _interned: ClassVar[WeakValueDictionary] = WeakValueDictionary()

    op: str
    args: tuple[Expr, ...]
    value: Any  #: of the type that belongs to ``op``

    def __new__(cls, op: str, args: tuple[Expr, ...] = (), value: object = None) -> Expr:
        # 0.0 and -0.0 are equal and hash alike; as constants they may share a node.
        key = (op, args, value)
        node = cls._interned.get(key)
        if node is None:
            node = object.__new__(cls)
            node.op, node.args, node.value = op, args, value
            cls._interned[key] = node
        return node

    def __reduce__(self):
        """Pickled as a list of its nodes: nested arguments of long chains would exceed the recursion limit."""
        order = walk(self)
        place = {node: k for k, node in enumerate(order)}
        return _of_nodes, ([(node.op, tuple(place[x] for x in node.args), node.value) for node in order],)

    # -- arithmetic, with the simplifications that keep derivatives readable ---------------------------------
    def __add__(self, other: Expr | float) -> Expr:
        other = expr(other)
        if is_const(self) and is_const(other):
            return const(self.value + other.value)
        if is_const(self, 0.0):
            return other
        if is_const(other, 0.0):
            return self
        return Expr("add", (self, other))

    def __radd__(self, other: float) -> Expr:
        return expr(other) + self

    def __neg__(self) -> Expr:
        if is_const(self):
            return const(-self.value)
        if self.op == "neg":
            return self.args[0]
        return Expr("neg", (self,))

    def __sub__(self, other: Expr | float) -> Expr:
        other = expr(other)
        if is_const(self) and is_const(other):
            return const(self.value - other.value)
        if is_const(other, 0.0):
            return self
        if is_const(self, 0.0):
            return -other
        return Expr("sub", (self, other))

    def __rsub__(self, other: float) -> Expr:
        return expr(other) - self

    def __mul__(self, other: Expr | float) -> Expr:
        other = expr(other)
        if is_const(self) and is_const(other):
            return const(self.value * other.value)
        for a, b in ((self, other), (other, self)):
            if is_const(a, 0.0):
                return const(0.0)
            if is_const(a, 1.0):
                return b
            if is_const(a, -1.0):
                return -b
        return Expr("mul", (self, other))

    def __rmul__(self, other: float) -> Expr:
        return expr(other) * self

    def __truediv__(self, other: Expr | float) -> Expr:
        other = expr(other)
        if is_const(other) and other.value != 0.0:
            if is_const(self):
                return const(self.value / other.value)
            if is_const(other, 1.0):
                return self
        if is_const(self, 0.0) and not is_const(other, 0.0):
            return const(0.0)
        return Expr("div", (self, other))

    def __rtruediv__(self, other: float) -> Expr:
        return expr(other) / self

    def __pow__(self, other: Expr | float) -> Expr:
        other = expr(other)
        if is_const(other, 1.0):
            return self
        if is_const(other, 0.0):
            return const(1.0)
        if is_const(other, 2.0):
            return self * self
        return call("pow", self, other)

    def __rpow__(self, other: float) -> Expr:
        return expr(other) ** self

    def __repr__(self) -> str:
        from mbdsl.expressions.printing import text

        return f"Expr({text(self)})"


def const(value: float) -> Expr:
    return Expr("const", (), float(value))


def expr(value: Expr | float) -> Expr:
    return value if isinstance(value, Expr) else const(value)


def is_const(node: Expr, value: float | None = None) -> bool:
    return node.op == "const" and (value is None or node.value == value)


TIME = Expr("time")


def coordinate(frame: str, key: str) -> Expr:
    """Coordinate ``key`` (one of ``COORDINATES``) of the frame named ``frame``, in world axes."""
    return Expr("coordinate", (), (frame, key))


def multiplier(joint: str, k: int) -> Expr:
    """Multiplier ``k`` (0, 1, ...) of the joint named ``joint``: those of its holonomic rows come first, then those of
    its velocity-level rows."""
    return Expr("multiplier", (), (joint, k))


def input_signal(name: str) -> Expr:
    """The input named ``name``, whose value the caller sets."""
    return Expr("input", (), name)


def at_start(quantity: Expr) -> Expr:
    """The value of ``quantity`` at the start of a motion: a constant that is known after the assembly."""
    return quantity if is_const(quantity) else Expr("start", (), quantity)


def call(op: str, *args: Expr | float) -> Expr:
    """Apply ``op`` (a key of ``OPERATIONS``), evaluating it now if all arguments are constants."""
    nodes = tuple(expr(a) for a in args)
    if op == "angle":
        y, x, rate = nodes if len(nodes) > 2 else (*nodes, const(0.0))
        return call("atan2", y, x) if is_const(y) and is_const(x) else Expr("angle", (y, x), rate)
    if all(is_const(a) for a in nodes):
        try:
            return const(OPERATIONS[op](*(a.value for a in nodes)))
        except (ValueError, ZeroDivisionError, OverflowError):
            pass  # not a number here: the evaluation of the expression reports it
    if op == "select" and is_const(nodes[0]):
        return nodes[1] if nodes[0].value else nodes[2]
    if op == "select" and nodes[1] is nodes[2]:
        return nodes[1]
    if op == "ratio" and is_const(nodes[0], 0.0):
        return const(0.0)
    return Expr(op, nodes)


def _ratio(a: float, b: float) -> float:
    return a / b if b != 0.0 else 0.0


def _sign(a: float) -> float:
    return (a > 0.0) - (a < 0.0)


#: op -> its value on floats; conditions are 1.0 (true) and 0.0 (false)
OPERATIONS: dict[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    "pow": math.pow,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "atan2": math.atan2,
    "angle": math.atan2,  # counts turns where states follow each other; the node's value is its rate, an expression
    "sinh": math.sinh,
    "cosh": math.cosh,
    "tanh": math.tanh,
    "exp": math.exp,
    "log": math.log,
    "log10": math.log10,
    "sqrt": math.sqrt,
    "hypot": math.hypot,
    "ratio": _ratio,  # a/b, and 0 where b = 0: the derivative of a distance at zero length
    "abs": abs,
    "sign": _sign,
    "min": min,
    "max": max,
    "floor": math.floor,
    "ceil": math.ceil,
    "mod": lambda a, b: a - math.floor(a / b) * b,
    "lt": lambda a, b: float(a < b),
    "le": lambda a, b: float(a <= b),
    "eq": lambda a, b: float(a == b),
    "ne": lambda a, b: float(a != b),
    "and": lambda a, b: float(a != 0.0 and b != 0.0),
    "or": lambda a, b: float(a != 0.0 or b != 0.0),
    "not": lambda a: float(a == 0.0),
    "select": lambda c, a, b: a if c else b,
}


def walk(*roots: Expr, known: Container[Expr] = ()) -> list[Expr]:
    """All nodes below ``roots``, each once, arguments before the nodes that use them; none of ``known``, nor what is
    below these only."""
    order: list[Expr] = []
    done: set[Expr] = set()
    stack = list(reversed(roots))
    while stack:
        node = stack[-1]
        if node in done or node in known:
            stack.pop()
            continue
        pending = [a for a in node.args if a not in done and a not in known]
        if pending:
            stack.extend(reversed(pending))
        else:
            done.add(node)
            order.append(node)
    return order


def _of_nodes(nodes: list[tuple[str, tuple[int, ...], object]]) -> Expr:
    """The last node of a pickled list."""
    made: list[Expr] = []
    for op, args, value in nodes:
        made.append(Expr(op, tuple(made[k] for k in args), value))
    return made[-1]


def leaves(*roots: Expr) -> list[Expr]:
    """The leaves of ``roots``: time, coordinates, inputs and multipliers that they depend on."""
    if len(roots) == 1 and not roots[0].args:
        return [roots[0]] if roots[0].op in LEAVES else []
    return [n for n in walk(*roots) if n.op in LEAVES]


def is_velocity(leaf: Expr) -> bool:
    """Whether a leaf is a velocity of a frame."""
    return leaf.op == "coordinate" and leaf.value[1] in _VELOCITIES


def is_velocity_level(root: Expr) -> bool:
    return is_velocity(root) if root.op == "coordinate" else any(map(is_velocity, leaves(root)))


def substitute(root: Expr, replacement: Callable[[Expr], Expr | None]) -> Expr:
    """``root`` with every leaf for which ``replacement`` gives an expression replaced by it."""
    new: dict[Expr, Expr] = {}
    for n in walk(root):
        found = replacement(n) if not n.args else None
        if found is not None:
            new[n] = found
        elif n.op == "angle":
            new[n] = call("angle", *(new[a] for a in n.args), substitute(n.value, replacement))
        elif n.op == "start":
            new[n] = at_start(substitute(n.value, replacement))
        elif all(new[a] is a for a in n.args):
            new[n] = n
        else:
            new[n] = rebuild(n, [new[a] for a in n.args])
    return new[root]


_ARITHMETIC: dict[str, Callable[..., Expr]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    "pow": lambda a, b: a**b,
}


def rebuild(node: Expr, args: list[Expr]) -> Expr:
    if node.op in ("table", "integral"):
        return Expr(node.op, tuple(args), node.value)
    if node.op == "angle":
        return call("angle", *args, node.value)
    if node.op in _ARITHMETIC:
        return _ARITHMETIC[node.op](*args)
    return _quiet(call(node.op, *args)) if node.value == QUIET else call(node.op, *args)


def without_events(root: Expr) -> Expr:
    """``root`` without events at the changes of its conditions, signs and corners: noEvent() of Modelica."""
    new: dict[Expr, Expr] = {}
    for n in walk(root):
        made = n if all(new[a] is a for a in n.args) else rebuild(n, [new[a] for a in n.args])
        new[n] = _quiet(made)
    return new[root]


def _quiet(node: Expr) -> Expr:
    return Expr(node.op, node.args, QUIET) if node.op in SWITCHING else node


def evaluate(
    roots: Iterable[Expr],
    leaf: Callable[[Expr], Any],
    operations: dict[str, Callable] = OPERATIONS,
    table: Callable[[Any, int, Any], Any] | None = None,
    angle: Callable[..., Any] | None = None,
    order: list[Expr] | None = None,
) -> list:
    """Values of ``roots`` given the value of every leaf; works on arrays with array ``operations``.

    ``angle`` evaluates nodes of this operation, which count turns; ``order`` is ``walk(*roots)``, if it is known.
    """
    roots = list(roots)
    values: dict[Expr, object] = {}
    for n in walk(*roots) if order is None else order:
        if n.op == "const":
            values[n] = n.value
        elif n.op == "table":
            data, nth = n.value
            values[n] = (table or _table)(data, nth, values[n.args[0]])
        elif n.op == "integral":  # of energies: for arrays only
            values[n] = operations[n.op](n.value, values[n.args[0]])
        elif n.op == "angle" and angle is not None:
            values[n] = angle(n, *(values[a] for a in n.args))
        elif n.args:
            values[n] = operations[n.op](*(values[a] for a in n.args))
        else:
            values[n] = leaf(n)
    return [values[r] for r in roots]


def _table(data: object, nth: int, u: object) -> object:
    raise TypeError("expressions with tables are evaluated with `table=`")
