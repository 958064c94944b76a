"""Code of a kernel during its translation: lines, blocks, variables and conversions of values."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Callable, Iterator

from mbdsl.compilation.kernel_sources import emitted, syntax_tree
from mbdsl.compilation.kernel_types import (
    BOOL,
    FLOAT,
    INT,
    NOTHING,
    Group,
    Scalar,
    Type,
    Untranslatable,
    Value,
    constant,
    describe,
    group,
    join,
    literal,
)
from mbdsl.compilation.llvm_module import Module

RESULT = "return"  #: the key of the result among the types of variables, which no variable can have
#: initial values of variables
ZERO = {"i64": "0", "double": literal(0.0), "i1": "false", "ptr": "null"}


def returned(kind: Type) -> str:
    """The LLVM type of a result."""
    leaves = kind.leaves
    return "void" if not leaves else leaves[0] if len(leaves) == 1 else f"{{{', '.join(leaves)}}}"


def _assigned(body: list[ast.stmt]) -> Iterator[str]:
    """Names that statements assign; ``ast.walk`` would visit all expressions, too."""
    for statement in body:
        targets = list(getattr(statement, "targets", ())) or [getattr(statement, "target", None)]
        for target in targets:
            if isinstance(target, ast.Tuple):
                targets += target.elts
            elif isinstance(target, ast.Name):
                yield target.id
        for part in ("body", "orelse"):
            yield from _assigned(getattr(statement, part, []))


#: type of a statement or an expression -> the function of (code, node) that translates it
TRANSLATIONS: dict[type[ast.AST], Callable] = {}


def translates(kind: type[ast.AST]) -> Callable[[Callable], Callable]:
    """Mark the function that translates a kind of statements or expressions."""

    def mark(function: Callable) -> Callable:
        TRANSLATIONS[kind] = function
        return function

    return mark


_STATUS = "return a number that the caller looks at"
_TUPLE = "write a tuple, or fill the entries of an array that is an argument"
_LOOP = "write a `for` loop"
#: what to write in place of Python that is not translated
ALTERNATIVES: dict[type[ast.AST], str] = {
    **dict.fromkeys((ast.List, ast.Dict, ast.Set), _TUPLE),
    **dict.fromkeys((ast.ListComp, ast.GeneratorExp, ast.DictComp, ast.SetComp), _LOOP),
    **dict.fromkeys((ast.Try, ast.Raise, ast.Assert, ast.With), _STATUS),
    **dict.fromkeys((ast.Lambda, ast.FunctionDef), "write a kernel at the level of the module"),
    **dict.fromkeys((ast.Import, ast.ImportFrom), "import at the level of the module"),
    ast.Match: "write `if ... elif ...`",
    ast.Starred: "write the items of the tuple",
    ast.NamedExpr: "write an assignment before the statement",
    ast.Global: "pass the value as an argument and return it",
    ast.AnnAssign: "leave out the type",
}


class Widened(Exception):
    """The type of a variable or of the result is wider than assumed so far."""


class Code:
    """Lines of LLVM code with the variables of one kernel, for one combination of argument types."""

    def __init__(self, module: Module, function: Callable, takes: tuple[Type, ...], types: dict[str, Type]) -> None:
        self.module, self.function, self.types = module, function, types
        self.tree = syntax_tree(function)
        self.node: ast.AST = self.tree
        #: whether the kernel is in no module of mbdsl and in no emitted one
        self.of_user = not f"{function.__module__}.".startswith(("mbdsl.", *(f"{x}." for x in emitted)))
        self.variables: list[str] = []  # allocations, at the start of the function
        self.lines: list[str] = []
        self.count = 0
        self.ended = False  # whether the present block has an end
        self.block = "entry"
        self.loops: list[tuple[str, str]] = []  # labels for continue and break
        self.memory: dict[str, list[str]] = {}
        self.bound: dict[str, Value] = {}  # variables of generators
        names = [a.arg for a in self.tree.args.args]
        self.given = {
            name: Value(kind, tuple(f"%in.{k}.{i}" for i in range(len(kind.leaves))))
            for k, (name, kind) in enumerate(zip(names, takes, strict=True))
        }
        self.assigned = set(_assigned(self.tree.body))

    # -- parts of the syntax tree ------------------------------------------------------------------------------

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        return self.translated(node)

    def translated(self, node: ast.AST) -> Value:
        function = TRANSLATIONS.get(type(node))
        if function is None:
            raise Untranslatable(f"`{ast.unparse(node).splitlines()[0]}`", hint=ALTERNATIVES.get(type(node)))
        return function(self, node)

    # -- lines -----------------------------------------------------------------------------------------------

    def new(self, text: str) -> str:
        """An instruction with a result."""
        self.count += 1
        self.lines.append(f"  %v{self.count} = {text}")
        return f"%v{self.count}"

    def label(self) -> str:
        self.count += 1
        return f"b{self.count}"

    def start(self, label: str) -> None:
        self.lines.append(f"{label}:")
        self.block, self.ended = label, False

    def end(self, text: str) -> None:
        if not self.ended:
            self.lines.append(f"  {text}")
        self.ended = True

    def go(self, label: str) -> None:
        self.end(f"br label %{label}")

    def branch(self, test: Value, yes: str, no: str) -> None:
        self.end(f"br i1 {self.truth(test)}, label %{yes}, label %{no}")

    # -- variables -------------------------------------------------------------------------------------------

    def widen(self, name: str, kind: Type) -> Type:
        """The type of a variable, which is assigned a value of type ``kind``."""
        known = self.types.get(name)
        if known is None:
            self.types[name] = kind
            return kind
        joined = join(known, kind)
        if joined != known:
            self.types[name] = joined
            raise Widened
        return known

    def assign_name(self, name: str, value: Value) -> None:
        kind = self.widen(name, value.type)
        if name not in self.memory:
            self.memory[name] = [f"%{name}.{i}" for i in range(len(kind.leaves))]
            for place, leaf in zip(self.memory[name], kind.leaves, strict=True):
                self.variables.append(f"  {place} = alloca {leaf}")
                self.variables.append(f"  store {leaf} {ZERO[leaf]}, ptr {place}")
        for place, leaf, x in zip(self.memory[name], kind.leaves, self.converted(value, kind).leaves, strict=True):
            self.lines.append(f"  store {leaf} {x}, ptr {place}")

    def read_name(self, name: str) -> Value:
        if name in self.bound:
            return self.bound[name]
        if name in self.assigned:
            if name not in self.types:
                raise Untranslatable(f"`{name}` is read before it is assigned")
            kind = self.types[name]
            if name not in self.memory:
                self.memory[name] = [f"%{name}.{i}" for i in range(len(kind.leaves))]
                for place, leaf in zip(self.memory[name], kind.leaves, strict=True):
                    self.variables.append(f"  {place} = alloca {leaf}")
                    self.variables.append(f"  store {leaf} {ZERO[leaf]}, ptr {place}")
            places = self.memory[name]
            return Value(kind, tuple(self.new(f"load {x}, ptr {p}") for p, x in zip(places, kind.leaves, strict=True)))
        if name in self.given:
            return self.given[name]
        scope = self.function.__globals__
        if name in scope:
            return constant(scope[name])
        if hasattr(builtins, name):
            return constant(getattr(builtins, name))
        raise Untranslatable(f"`{name}` is not defined")

    # -- conversions -----------------------------------------------------------------------------------------

    def converted(self, value: Value, kind: Type) -> Value:
        if value.type == kind:
            return value
        if isinstance(kind, Scalar) and isinstance(value.type, Scalar):
            return self.number(value, kind)
        if isinstance(kind, Group) and isinstance(value.type, Group):
            return group([self.converted(x, k) for x, k in zip(value.items, kind.items, strict=True)], kind.named)
        raise Untranslatable(f"{describe(value.type)} in place of {describe(kind)}")

    def number(self, value: Value, kind: Scalar) -> Value:
        """A number converted to another kind; to an integer by dropping the fraction."""
        if not isinstance(value.type, Scalar):
            raise Untranslatable(f"{describe(value.type)} in place of a number")
        if value.type == kind:
            return value
        if kind == BOOL:
            return Value(BOOL, (self.truth(value),))
        if value.known is not None and (kind == FLOAT or value.type == BOOL):
            return constant(float(value.known) if kind == FLOAT else int(value.known))
        step = {("bool", "int"): "zext i1", ("bool", "float"): "uitofp i1", ("int", "float"): "sitofp i64"}.get(
            (value.type.name, kind.name), "fptosi double"
        )
        found = self.new(f"{step} {value.leaves[0]} to {kind.leaf}")
        if step == "fptosi double":  # of inf and nan: some integer instead of undefined behaviour
            found = self.new(f"freeze i64 {found}")
        return Value(kind, (found,))

    def truth(self, value: Value) -> str:
        if value.type == BOOL:
            return value.leaves[0]
        if value.type == INT:
            return self.new(f"icmp ne i64 {value.leaves[0]}, 0")
        if value.type == FLOAT:
            return self.new(f"fcmp une double {value.leaves[0]}, {literal(0.0)}")
        if value.type == NOTHING:
            return "false"
        raise Untranslatable(f"{describe(value.type)} as a condition")
