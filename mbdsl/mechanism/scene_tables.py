"""A Scene as tables, its values as texts, and both as a notebook shows them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from mbdsl.elements.declaration import ANY
from mbdsl.elements.kind import JointKind
from mbdsl.expressions.printing import text
from mbdsl.expressions.symbolic import Expr
from mbdsl.messages import OWN, UnitsOfSignals, few, visible
from mbdsl.plotting.figures import TextTable
from mbdsl.plotting.html_tables import fragment

if TYPE_CHECKING:
    from mbdsl.mechanism.events import Action
    from mbdsl.mechanism.graph import MechanismGraph
    from mbdsl.mechanism.scene import Component, Scene

LONG = 60  #: characters of a value in a table


def value(v: Any, number: Callable[[float], str] = repr) -> str:
    """A value of a component or a parameter, in SI units, as text; ``number`` makes the text of a number."""
    if isinstance(v, Expr):
        return text(v)
    if hasattr(v, "smoothness"):  # a table
        return f"table of {len(v.u)} points ({v.smoothness}, {v.extrapolation})"
    if isinstance(v, tuple):
        return "{" + ", ".join(value(x, number) for x in v) + "}"
    if isinstance(v, str):
        return f'"{visible(v, line=True)}"'
    return number(v) if isinstance(v, float) else repr(v)


def rounded(x: float) -> str:
    return f"{x:.6g}"


def with_unit(
    c: Component, name: str, v: Any, number: Callable[[float], str] = repr, display: UnitsOfSignals = OWN
) -> str:
    """The value of a parameter of a component with its unit."""
    parameter = c.kind.parameter(name)
    unit = c.units.get(name) or (parameter.unit if parameter else "")
    found, shown = displayed(v, "" if unit == ANY else unit, f"{c.name}.{name}", display)
    return f"{value(found, number)} {shown}".rstrip()


def displayed(v: Any, unit: str, name: str, display: UnitsOfSignals) -> tuple[Any, str]:
    """A number, or an array of numbers, in the unit in which it is displayed, and that unit; others as they are."""
    shown = display.of("" if unit == "1" else unit, name)
    found = v if shown.factor == 1.0 else _divided(v, shown.factor)
    return (v, "" if unit == "1" else unit) if found is None else (found, shown.symbol)


def _divided(v: Any, factor: float) -> Any:
    """None if a part of it is no number."""
    if isinstance(v, tuple):
        parts = tuple(_divided(x, factor) for x in v)
        return None if None in parts else parts
    return v / factor if isinstance(v, (int, float)) and not isinstance(v, bool) else None


def tables(scene: Scene) -> list[TextTable]:
    """The scene as tables: components, parameters, inputs, initial values.

    Returns
    -------
    list of Table
        Numbers are in the units in which the scene displays them.
    """
    units = {"phi": "rad", "w": "rad/s", "vx": "m/s", "vy": "m/s", "x": "m", "y": "m"}
    rows = [_row(c, scene.display) for c in scene.components.values()]
    discrete = {name: scene.events.variables[name] for name in scene.events.typed}

    def number(name: str, v: Any, unit: str) -> tuple[str, str]:
        found, shown = displayed(v, unit, name, scene.display)
        return _short(value(found, rounded)), shown

    return [
        TextTable("", ("component", "kind", "frames", "values", "description"), rows),
        TextTable(
            "Parameters",
            ("name", "value", "unit", "description"),
            [(p.name, *number(p.name, p.value, p.unit), p.doc) for p in scene.parameters.values()],
        ),
        TextTable(
            "Inputs",
            ("name", "start", "unit", "description"),
            [(x.name, *number(x.name, x.start, x.unit), x.doc) for x in scene.inputs.values()],
        ),
        TextTable(
            "Variables",
            ("name", "value", "unit", "description"),
            [
                (name, _short(text(e)), *scene.descriptions.get(name, ("", "")))
                for name, e in scene.variables.items()
                if name not in discrete
            ],
        ),
        TextTable(
            "Discrete variables",
            ("name", "start", "unit", "description"),
            [(x.name, *number(x.name, x.start, x.unit), x.doc) for x in discrete.values()],
        ),
        TextTable("Events", ("when", "does", "line"), [tuple(map(_short, row)) for row in whens(scene)]),
        TextTable(
            "Initial values",
            ("signal", "value", "unit", ""),
            [("state", "steady", "", "")] * scene.steady
            + [
                (
                    i.name,
                    *number(i.name, i.value, units.get(i.name.rpartition(".")[2], "")),
                    "fixed" if i.fixed else "guess",
                )
                for i in scene.initial
            ],
        ),
    ]


def whens(scene: Scene) -> Iterator[tuple[str, str, str]]:
    """The branches of when-equations and the assertions as texts: conditions, what they do, and the line."""
    for when in scene.events.written:
        for k, branch in enumerate(when.branches):
            conditions = ", ".join(text(c.args[0] if _is_pulse(c) else c) for c in branch.conditions)
            line = "" if branch.span is None else f"{branch.span.file}:{branch.span.line}"
            yield f"{'else ' if k else ''}{conditions}", "; ".join(map(_action, branch.actions)), line


def _is_pulse(condition: Expr) -> bool:
    """Whether it is the truth of a clock, of `initial()` or of `terminal()`."""
    return condition.op == "ne" and condition.args[0].op == "input" and str(condition.args[0].value).endswith(")")


def _action(action: Action) -> str:
    if action.what == "set":
        return f"warn: {action.text}" if action.text else f"{action.target} = {value(action.value)}"
    if action.what == "reinit":
        return f"reinit({action.target}, {value(action.value)})"
    return f"{action.what}({f'{action.target}, ' if action.target else ''}{value(action.text)})"


def _row(c: Component, display: UnitsOfSignals) -> tuple[str, ...]:
    usual = _defaults(c)
    given = {name: v for name, v in c.values.items() if not (v is None or v == () or _same(v, usual.get(name)))}
    values = [f"{name} = {_short(with_unit(c, name, v, rounded, display))}" for name, v in given.items()]
    return c.name, c.kind.name, ", ".join(c.ports.values()), ", ".join(values), c.doc


def _defaults(c: Component) -> dict[str, Any]:
    """Values of parameters that are not given; of joints also those that follow from the given ones."""
    found = {p.name: p.default for p in c.kind.parameters}
    if isinstance(c.kind, JointKind):
        found |= c.kind.derive({**c.values, **{name: None for name, v in found.items() if v is None}})
    return found


def _same(v: Any, default: Any) -> bool:
    return not isinstance(v, Expr) and v == default


def _short(shown: str) -> str:
    return shown if len(shown) <= LONG else f"{shown[: LONG - 3]}..."


def experiment(scene: Scene) -> list[str]:
    """The settings of ``annotation(experiment(...))`` and the effects left out, in one line or none."""
    said = {name: getattr(scene.experiment, name) for name in scene.experiment.__dataclass_fields__}
    shown = [f"{name} = {value(v, rounded)}" for name, v in said.items() if v not in (None, ())]
    lines = [f"experiment: {', '.join(shown)}"] if len(shown) > 1 else []
    for effect, names in scene.without.items():
        lines.append(f"without {effect}: {few(names) if names else 'nothing has it'}")
    return lines


def of_scene(scene: Scene) -> str:
    """A scene as HTML: its counts and tables."""
    title = f"{scene.name}: {scene.doc}" if scene.doc else scene.name
    counts = repr(scene).partition(": ")[2].rstrip(">")
    return fragment(title, [counts], tables(scene), experiment(scene))


def of_graph(graph: MechanismGraph) -> str:
    """A graph as HTML: its counts, and a row for each body, joint and force."""
    head, *lines = graph.summary().splitlines()
    bodies = [(name, c.kind.name, ", ".join(c.coordinates)) for name, c in graph.bodies.items()]
    edges = [
        (e.name, e.component.kind.name, ", ".join(e.component.ports.values()), str(e.rows or ""))
        for e in (*graph.joints, *graph.forces)
    ]
    found = [TextTable("", ("body", "kind", "coordinates"), bodies)]
    found.append(TextTable("", ("joint or force", "kind", "frames", "rows"), edges))
    return fragment(head, lines, found, [w.render() for w in graph.warnings])
