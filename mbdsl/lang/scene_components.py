"""From a component under construction to the components of a Scene."""

from __future__ import annotations

from collections.abc import Iterable

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.errors import ModelError
from mbdsl.expressions.frame_derivatives import by_rate, frames_in
from mbdsl.expressions.primitive import potential
from mbdsl.expressions.symbolic import Expr, is_velocity_level
from mbdsl.lang.flat_component import FlatComponent
from mbdsl.lang.mistakes import joint_laws
from mbdsl.lang.paths import spans
from mbdsl.lang.source import placed, span_of
from mbdsl.mechanism.scene import Component
from mbdsl.mechanism.signals import ComponentFormulas


def components_of(part: FlatComponent) -> list[Component]:
    """The component, and those of the further spans of its path."""
    if part.kind.computed:
        return spans(part, part.modifier("over"))
    return [_component(part), *(_contact(part, x) for x in part.formulas.contacts.values())]


def latches_of(part: FlatComponent) -> Iterable[tuple[str, Expr, Expr]]:
    """The numbers of a component that events set, as of :meth:`mbdsl.mechanism.signals.ComponentFormulas.latches`."""
    return part.formulas.latches() if part.own_kind.latches else ()


def _component(part: FlatComponent) -> Component:
    kind = part.own_kind
    laws = {name: part.law(name) for name in kind.law_parameters}
    if isinstance(kind, ForceKind) and kind.springs is None:
        laws |= {name: part.formulas.signal(name) for name in kind.laws if laws.get(name) is None}
    if isinstance(kind, ForceKind) and kind.searched:
        laws["searched"] = part.formulas.signal(kind.searched)
    ports = {port: part.own_frame(port).name for port in part.nodes}
    return Component(
        part.name,
        kind,
        {**part.values, **laws} if laws else part.values,
        ports,
        part.signal_names(),
        span_of(part.at),
        part.doc,
        _energy(part),
        _velocity_constraints(part),
        part.formulas.resistance() if part.has_friction() else None,
        part.formulas.friction_rows() if part.has_friction() else (),
        {port: frame for port, own in ports.items() if (frame := part.port_frame(port).name) != own},
        tuple(map(part.formulas.row, kind.relations)) if isinstance(kind, JointKind) else (),
        part.units() if kind.coupled else {},
    )


def _contact(part: FlatComponent, own: ComponentFormulas) -> Component:
    """A rigid contact that a component consists of; its signals are those of the component."""
    kind = own.kind
    assert isinstance(kind, JointKind)
    values = {x.name: own.given(x.name) for x in kind.parameters}
    slips = tuple(own.row(x) for x in kind.velocity_rows if values[x] is not None)
    values |= {"aim": own.given("aim")} if own.given("aim") else {}
    return Component(
        own.name,
        kind,
        values,
        span=span_of(part.at),
        velocity_constraints=slips,
        friction=own.resistance() if slips else None,
        relations=(own.row("gap"),),
        units={"gap": "rad"} if part.kind.unit_of("phi") == "rad" else {},
    )


def _energy(part: FlatComponent) -> Expr | None:
    """The potential energy, if the kind has one; of a law, if it depends on the kind's coordinate and rate only."""
    kind = part.own_kind
    if not getattr(kind, "energy", ""):
        return None
    given = [name for name in kind.law_parameters if part.has_law(name)]
    if not given:
        return part.formulas.energy()
    law, coordinate = part.formulas.law(given[0]), next((x for x in ("s", "phi") if x in kind.formulas), None)
    if law is None or coordinate is None or len(given) > 1:
        return None
    rate = part.formulas.signal("v" if coordinate == "s" else "w")
    start = part.values.get(f"{coordinate}0", 0.0)
    return potential(law, part.formulas.signal(coordinate), rate, float(start))


def _velocity_constraints(part: FlatComponent) -> tuple[Expr, ...]:
    if not isinstance(part.kind, JointKind) or not part.kind.velocity_rows:
        return ()
    if part.kind.unilateral:
        return _slips(part)
    found = tuple(map(part.formulas.row, part.kind.velocity_rows))
    for name in part.kind.law_parameters:
        modifier = part.modifier(name)
        for row in found:
            with placed(modifier.value.at if modifier and modifier.value else part.at):
                joint_laws.check_row(name, row, part.kind, part.name)
    return found


def _slips(part: FlatComponent) -> tuple[Expr, ...]:
    """The slips of a rigid contact with friction."""
    kind, found = part.kind, list[Expr]()
    assert isinstance(kind, JointKind)
    for name in kind.velocity_rows:
        modifier = part.modifier(name)
        if not part.has_friction() or modifier is None or modifier.value is None:
            continue
        row = part.formulas.row(name)
        with placed(modifier.value.at):
            joint_laws.check_row(name, row, kind, part.name)
            if any(is_velocity_level(x) for f in frames_in(row) for x in by_rate(row, f, kind.spatial)):
                message = f"`{name}` of {kind.name} `{part.name}` is not linear in velocities"
                raise ModelError(message, hint="it is a speed, such as `ball.vx + r*ball.w`")
        found.append(row)
    if part.has_friction() and not found:
        message = f"{kind.name} `{part.name}` has friction, but no `slip`"
        hint = "give the velocity of sliding, such as `slip = ball.vx + r*ball.w`"
        raise ModelError(message, span_of(part.at), hint)
    return tuple(found)
