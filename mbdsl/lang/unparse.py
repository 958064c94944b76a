"""The syntax tree as text: an expression as it would be written, a file as an indented listing."""

from __future__ import annotations

from dataclasses import fields

from mbdsl.lang import syntax as s


def write(e: s.Expression | None) -> str:
    """An expression as text of the language."""
    match e:
        case None:
            return ""
        case s.Number(value, unit):
            shown = repr(int(value)) if unit and float(value).is_integer() and abs(value) < 1e15 else repr(value)
            return f"{shown} {unit.text}" if unit else shown
        case s.String(value):
            return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
        case s.Boolean(value):
            return "true" if value else "false"
        case s.Last():
            return "end"
        case s.Everything():
            return ":"
        case s.Reference(steps):
            return ".".join(step.name + indices(step.indices) for step in steps)
        case s.Unary(operator, operand):
            return f"{operator}{' ' if operator.isalpha() else ''}{inner(operand)}"
        case s.Binary():
            # Long sums associate to the left: written without recursion, with parentheses for lower precedence only.
            chain: list[str] = []
            while True:
                chain += (inner(e.right), e.operator)
                left = e.left
                if not (isinstance(left, s.Binary) and _PRECEDENCE[left.operator] == _PRECEDENCE[e.operator] != 6):
                    return " ".join([inner(left), *reversed(chain)])
                e = left
        case s.Choice(branches, otherwise):
            parts = " elseif ".join(f"{write(c)} then {write(v)}" for c, v in branches)
            return f"if {parts} else {write(otherwise)}"
        case s.Range(start, step, stop):
            return ":".join(inner(x) for x in (start, step, stop) if x is not None)
        case s.ArrayNode(items, unit):
            return "{" + ", ".join(map(write, items)) + "}" + (f" {unit.text}" if unit else "")
        case s.Comprehension(item, iterators, unit):
            return "{" + f"{write(item)} for {_iterators(iterators)}" + "}" + (f" {unit.text}" if unit else "")
        case s.Literal(value):
            return str(getattr(value, "value", value))
        case s.Call(function, arguments):
            return f"{write(function)}({', '.join(map(write_argument, arguments))})"
    raise TypeError(f"no expression: {e!r}")


_PRECEDENCE = {
    "or": 1,
    "and": 2,
    "==": 3,
    "<>": 3,
    "<": 3,
    "<=": 3,
    ">": 3,
    ">=": 3,
    "+": 4,
    "-": 4,
    "*": 5,
    "/": 5,
    "^": 6,
}


def inner(e: s.Expression) -> str:
    """``e`` as an operand, in parentheses where it has operators."""
    return f"({write(e)})" if isinstance(e, s.Binary | s.Unary | s.Choice | s.Range) else write(e)


def indices(given: tuple[s.Expression, ...]) -> str:
    return f"[{', '.join(map(write, given))}]" if given else ""


def _iterators(iterators: tuple[s.Iterator, ...]) -> str:
    return ", ".join(f"{i.name} in {write(i.values)}" for i in iterators)


def write_argument(a: s.Argument) -> str:
    if not a.name:
        return write(a.value)
    words = ("each " if a.each else "") + ("final " if a.final else "") + a.name + indices(a.indices)
    inner = f"({', '.join(map(write_argument, a.modifiers))})" if a.modifiers else ""
    return words + inner + (f" = {write(a.value)}" if a.value is not None else "")


def dump(node: s.Node, level: int = 0) -> str:
    """The tree, one item a line, indented by its depth."""
    pad = "  " * level
    match node:
        case s.File(name, imports, models):
            lines = [f"File {name}"]
            lines += [f'  Import "{i.path}"' + (f" as {i.alias}" if i.alias else "") for i in imports]
            return "\n".join(lines + [dump(m, level + 1) for m in models])
        case s.Model():
            lines = [
                f"{pad}Model {node.name}"
                + (" (partial)" if node.partial else "")
                + (" (spatial)" if node.spatial else "")
            ]
            for title, items in (("", node.items), ("equation", node.equations), ("initial", node.initial)):
                if items and title:
                    lines.append(f"{pad}  {title}")
                lines += [dump(i, level + (2 if title else 1)) for i in items]
            return "\n".join(lines)
        case s.For(iterators, items):
            return "\n".join([f"{pad}For {_iterators(iterators)}", *(dump(i, level + 1) for i in items)])
        case s.If(branches):
            lines = []
            for condition, items in branches:
                lines.append(f"{pad}If {write(condition)}" if condition is not None else f"{pad}Else")
                lines += [dump(i, level + 1) for i in items]
            return "\n".join(lines)
    shown = []
    for f in fields(node):
        value = getattr(node, f.name)
        if f.name in ("at", "type_at", "doc") or value in ((), "", None, frozenset()):
            continue
        if isinstance(value, s.Expression):
            value = write(value)
        elif isinstance(value, frozenset):
            value = " ".join(sorted(value))
        elif isinstance(value, tuple):
            value = ", ".join(write_argument(v) if isinstance(v, s.Argument) else write(v) for v in value)
        shown.append(f"{f.name}={value}")
    return f"{pad}{type(node).__name__} {' '.join(shown)}"
