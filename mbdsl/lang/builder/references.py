"""The references between the declarations of a model under construction from Python."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

from mbdsl.elements import find
from mbdsl.elements.kind import Kind
from mbdsl.expressions import symbolic
from mbdsl.lang import syntax as s
from mbdsl.lang.builder.content import DraftContent, is_element
from mbdsl.lang.functions import CONSTANTS
from mbdsl.lang.instantiate import Instance
from mbdsl.lang.mistakes.references import unknown
from mbdsl.lang.modelica_names import KINDS as ALIASES
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity


def check_names(node: object, instance: Instance) -> None:
    """Check that the names with which references in a syntax tree begin are declared.

    Raises
    ------
    ModelError
        At the first one that is not.
    """
    own: set[str] = {"time", "Modelica", "AssertionLevel", *CONSTANTS}
    spatial = instance.assembly.spatial
    if isinstance(node, s.Initial) and node.mode == "state":
        return
    if isinstance(node, s.Declaration) and (kind := _kind(node, spatial)) is not None:
        own |= {*(p.name for p in kind.parameters), *kind.formulas}  # in its law
    for step, _ in _first_steps(node, functions=False):
        if step.name not in own and step.name not in instance.namespace.places:
            raise unknown(instance.scope, step.name, step.at)


def _first_steps(node: object, functions: bool = True) -> Iterator[tuple[s.NamePart, bool]]:
    """The first step of every reference in a syntax tree, and whether it is the whole reference."""
    if isinstance(node, s.Comprehension):
        variables = {iterator.name for iterator in node.iterators}
        inner = (node.item, *(iterator.values for iterator in node.iterators))
        yield from ((step, alone) for step, alone in _first_steps(inner, functions) if step.name not in variables)
    elif isinstance(node, s.Call) and not functions:
        yield from _first_steps(node.arguments, functions)
    elif isinstance(node, s.Reference):
        yield node.steps[0], len(node.steps) == 1
        for step in node.steps:
            yield from _first_steps(step.indices, functions)
    elif isinstance(node, s.Literal) and isinstance(node.value, Quantity):
        for leaf in symbolic.leaves(node.value.expression):
            named = leaf.value[0] if isinstance(leaf.value, tuple) else leaf.value
            if leaf.op in ("coordinate", "multiplier", "input"):
                first, _, index = str(named).split(".")[0].partition("[")
                numbers = tuple(s.Number(int(i)) for i in index.rstrip("]").split(",") if i)
                yield s.NamePart(first, numbers), False
    elif isinstance(node, tuple):
        for inner in node:
            yield from _first_steps(inner, functions)
    elif isinstance(node, s.Node):
        for f in fields(node):
            if f.compare:
                yield from _first_steps(getattr(node, f.name), functions)


def _refers(node: object, d: s.Declaration, own: Sequence[str] = ()) -> bool:
    """Whether a syntax tree refers to ``d``; alone, names in ``own`` denote something else."""
    for step, alone in _first_steps(node):
        if step.name != d.name or (alone and step.name in own):
            continue
        element = step.indices and all(isinstance(i, s.Number) for i in step.indices)
        if not (element and is_element(d)) or step.indices == d.indices:
            return True
    return False


def _kind(d: s.Declaration, spatial: bool) -> Kind | None:
    return find(ALIASES.get(d.type, d.type), spatial)


def _has_ports(d: s.Declaration, spatial: bool) -> bool:
    kind = _kind(d, spatial)
    return kind is not None and bool(kind.ports)


def _declaration_refers(d: s.Declaration, to: s.Declaration, spatial: bool) -> bool:
    if _refers((d.value, d.indices, d.notes), to):
        return True
    kind = _kind(d, spatial)
    if kind is None:
        return _refers(d.arguments, to)
    frames = tuple(a for a in d.arguments if not a.name or a.name in kind.ports)
    values = tuple(a for a in d.arguments if a not in frames)
    # In a law, a component with the name of a signal or parameter of the law's own component is hidden by it.
    own = [*(p.name for p in kind.parameters), *kind.formulas] if _kind(to, spatial) else []
    return _refers(frames, to) or _refers(values, to, own)


def _attached(content: DraftContent, to: s.Declaration) -> Iterator[str]:
    """The joints and forces that are connected with the body or frame ``to``."""
    if _has_ports(to, content.spatial):
        return
    joints = {k: e.declaration for k, e in content.entries.items() if _has_ports(e.declaration, content.spatial)}
    for item in content.connections:
        for one, other in ((item.first, item.second), (item.second, item.first)):
            if _refers(one, to):
                yield from (k for k, d in joints.items() if _refers(other, d))


def find_dependents(content: DraftContent, names: Sequence[str]) -> list[str]:
    """What refers to the declarations ``names``, directly or through others, in the order of declaration."""
    found: set[str] = set()
    pending = [content.entries[name].declaration for name in names]
    while pending:
        to = pending.pop()
        entries = content.entries.items()
        direct = {key for key, e in entries if _declaration_refers(e.declaration, to, content.spatial)}
        direct |= set(_attached(content, to))
        rates = {item.left: item for item in content.rates if _refers(item, to)}
        direct |= {key for key, e in entries if any(_refers(left, e.declaration) for left in rates)}
        direct -= {*found, *names}
        found |= direct
        pending += [content.entries[key].declaration for key in direct]
    # An initial value belongs to its target, but its value may refer to another component.
    gone = [content.entries[name].declaration for name in (*names, *found)]
    values = [
        f"the initial value of {write(item.target)}"
        for item in content.initial
        if any(_refers(item.value, d) for d in gone) and not any(_refers(item.target, d) for d in gone)
    ]
    values += [_event_name(item) for item in content.events if any(_refers(item, d) for d in gone)]
    settings = [f"experiment({key})" for key, a in content.settings.items() if any(_refers(a.value, d) for d in gone)]
    return [*(key for key in content.entries if key in found), *values, *settings]


def _event_name(item: s.When | s.Relation) -> str:
    return f"when {write(item.branches[0][0])}" if isinstance(item, s.When) else write(item.left)


def without(content: DraftContent, gone: set[str]) -> DraftContent:
    """The content without declarations, and without what refers to them."""
    out = [content.entries[name].declaration for name in gone if name in content.entries]

    def stays(node: s.Node) -> bool:
        return not any(_refers(node, d) for d in out)

    return replace(
        content,
        entries={key: e for key, e in content.entries.items() if key not in gone},
        connections=[item for item in content.connections if stays(item)],
        rates=[item for item in content.rates if stays(item)],
        events=[item for item in content.events if stays(item)],
        initial=[item for item in content.initial if stays(item)],
        settings={key: a for key, a in content.settings.items() if stays(a)},
    )
