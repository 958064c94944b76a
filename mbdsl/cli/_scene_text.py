"""A scene as text: every component with its numbers in SI, every frame, every signal."""

from __future__ import annotations

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.printing import text
from mbdsl.mechanism.drawn_shapes import DrawnShape
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.mechanism.scene_tables import value, whens, with_unit
from mbdsl.messages import visible


def describe(scene: Scene) -> str:
    lines = [f"scene {scene.name}" + (f'  "{visible(scene.doc, line=True)}"' if scene.doc else "")]
    section(lines, "parameters", [f"{p.name} = {value(p.value)} {p.unit}".rstrip() for p in scene.parameters.values()])
    section(lines, "inputs", [f"{x.name}(start = {value(x.start)}) {x.unit}".rstrip() for x in scene.inputs.values()])
    for c in scene.components.values():
        ports = ", ".join(f"{port} = {frame}" for port, frame in c.ports.items())
        section(
            lines,
            f"{c.kind.name} {c.name}" + (f"({ports})" if ports else "") + (f"  // {c.span}" if c.span else ""),
            [f"{name} = {with_unit(c, name, v)}" for name, v in c.values.items() if v not in (None, ())],
            [f"frame {f.name} = {value(f.pose)}" for f in scene.frames.values() if f.body == c.name],
            [f"signal {c.name}.{key} = {text(e)}" for key, e in scene.signals_of(c).items()],
            [f"{_prescribed(c)} = {text(e)}" for e in c.relations],
            [f"0 = {text(e)}" for e in c.velocity_constraints],
            [f"shape {_shape(x)}" for x in scene.shapes.get(c.name, ())],
        )
    discrete = [scene.events.variables[name] for name in scene.events.typed]
    section(lines, "discrete", [f"{x.type} {x.name}(start = {value(x.start)}) {x.unit}".rstrip() for x in discrete])
    section(lines, "events", [f"when {c}: {does}" + (f"  // {line}" if line else "") for c, does, line in whens(scene)])
    section(
        lines,
        "initial",
        ["state = steady"] if scene.steady else [],
        [f"{i.name} = {value(i.value)}{' (fixed)' if i.fixed else ' (guess)'}" for i in scene.initial],
    )
    left_out = {effect: ", ".join(names) or "nothing has it" for effect, names in scene.without.items()}
    section(lines, "without", [f"{effect}: {names}" for effect, names in left_out.items()])
    said = {name: getattr(scene.experiment, name) for name in scene.experiment.__dataclass_fields__}
    section(lines, "experiment", [f"{name} = {value(v)}" for name, v in said.items() if v not in (None, ())])
    return "\n".join(lines)


def _prescribed(c: Component) -> str:
    """What a relation equals."""
    return f"{c.name}.{c.kind.driver}" if isinstance(c.kind, JointKind) and c.kind.driver else "0"


def section(lines: list[str], title: str, *parts: list[str]) -> None:
    body = [line for part in parts for line in part]
    if body:
        lines += ["", title, *(f"  {line}" for line in body)]
    elif title[0].isupper():  # components without parameters are shown as well
        lines += ["", title]


def _shape(x: DrawnShape) -> str:
    size = f"half axes {value(x.axes[:2])}" if x.form == "ellipse" else f"{len(x)} points"
    colours = [f"{name} {colour}" for name, colour in (("fill", x.fill), ("line", x.line)) if colour]
    return ", ".join([f"{x.form} of {size}", *colours])
