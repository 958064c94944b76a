"""Errors of the assembly: the constraints and fixed values that contradict each other, with their places."""

from __future__ import annotations

import numpy as np

from mbdsl.errors import InitialisationError, Span
from mbdsl.initial import gaps
from mbdsl.initial.dependent_rows import without_units
from mbdsl.initial.least_steps import misses, stack, stacked, velocity_residual
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import InitialValue
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.system import System


def inconsistent(
    system: System, t: float, q: Array, fixed: list[InitialValue], velocity, interrupted: bool = False
) -> InitialisationError:
    """The constraints and fixed values that contradict each other, with their places.

    At a pose where the search was ``interrupted``, they perhaps do not: a joint then is not open if all others are
    closed, and its violation in this pose is stated.
    """
    level = "positions" if velocity is None else "velocities"
    v = np.zeros(system.n) if velocity is None else velocity
    residual = system.Phi(t, q) if velocity is None else velocity_residual(system, t, q, v)
    value, d_q, d_v = stack(system, fixed, t, q, v)
    residual = np.concatenate([residual, value - np.array([x.value for x in fixed])])
    J = stacked(system.Phi_q(t, q), d_q) if velocity is None else stacked(system.velocity_jacobian(t, q, v), d_v)
    alike = np.abs(without_units(J, residual, system.tables.scale)[1])  # metres and radians are comparable
    wrong: list[tuple[float, str, Span | None]] = []
    where: dict[str, tuple[str, str, slice]] = {}
    ranges = [(name, row, system.tables.joint(name).kind.rows) for name, row in system.tables.rows.items()]
    if velocity is not None:
        for name, row in system.tables.velocity_rows.items():
            ranges.append((name, row, len(system.scene.components[name].velocity_constraints)))
    for name, row, count in ranges:
        component, part = system.tables.joint(name), slice(row, row + count)
        kind, most = component.kind, np.abs(residual[part]).max()
        text = f"{kind.name} {name} is violated by {_with_units(most, kind, velocity)}"
        wrong.append((float(alike[part].max()), text, component.span))
        where[text] = kind.name, name, part
    for item, x, size in zip(fixed, value, alike[len(alike) - len(fixed) :], strict=True):
        text = f"{item.name} = {item.unit.text(item.value)} is fixed, but comes out as {item.unit.text(x)}"
        wrong.append((float(size), text, item.span))
    wrong.sort(key=lambda w: -w[0])
    wrong = [w for w in wrong if w[0] > 1e-3 * wrong[0][0]][:6]  # relative: the largest misfit may be tiny
    if system.scene.spatial and velocity is None and not interrupted:
        wrong = [
            (w, _opened(system, t, q, fixed, *where[text]) if text in where else text, at) for w, text, at in wrong
        ]
    return InitialisationError(
        f"no consistent initial {level} found at time {t:g}",
        span=wrong[0][2] if wrong else None,
        notes=tuple((text, span) for _, text, span in wrong),
        hint="check lengths and fixed values; give guesses near the intended pose"
        if velocity is None
        else "fix fewer velocities, or make them fit the joints and drivers",
    )


def _opened(system: System, t: float, q: Array, fixed: list[InitialValue], kind: str, name: str, own: slice) -> str:
    """How far a joint in space is open."""

    def residual(q: Array) -> tuple[Array, Array]:
        value, d_q, _v = stack(system, fixed, t, q, np.zeros(system.n))
        r = np.concatenate([system.Phi(t, q), misses(value, fixed)])
        J, r = without_units(stacked(system.Phi_q(t, q), d_q), r, system.tables.scale)
        return r, dense(J)

    if (found := gaps.gap(system, t, q, own, residual)) is not None:
        return f"{kind} {name} is open by {gaps.text(*found)} if all others are closed"
    return f"{kind} {name} is violated by {gaps.text(*gaps.parts(system, t, q, own))}"


def _with_units(violation: float, kind, velocity: Array | None) -> str:
    """A violation with the units of the constraints of a joint, which follow from those of its reactions."""
    found = [unit for unit, names in (("m", {"fx", "fy"}), ("rad", {"tau"})) if names & set(kind.reaction)]
    per = "" if velocity is None else "/s"
    degrees = f" ({np.rad2deg(violation):.3g} deg{per})" if found == ["rad"] else ""
    return f"{violation:.3g} {' or '.join(unit + per for unit in found) or '(SI units)'}{degrees}"
