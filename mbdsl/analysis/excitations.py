"""Excitations: what may oscillate about a state, by its name.

    u               an input of the model
    push.fx, push   the amplitude of a force in addition to that of the element; its name alone if it has one
    base.s, base    the offset of a driver, or of the velocity that one prescribes

A driver moves a constraint, g(q) - u(t) = w, so that its offset w and the rates w' and w'' excite the mechanism.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.analysis.input_forces import forces_of, input_forces, signal_derivatives
from mbdsl.analysis.tangent_bases import Released
from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import leaves
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.messages import count, did_you_mean, few
from mbdsl.numerics.saddle_point import Array
from mbdsl.system import System

NOTHING = "declare `input Torque u;`, or add a Force or a Torque"  #: hint where nothing oscillates
INPUT, FORCE, DRIVER, RATE = "input", "force", "driver", "velocity driver"


class Excitation(NamedTuple):
    """What oscillates: its name and SI unit, its sort, and for an element its name and the place of its parameter."""

    name: str
    unit: str
    sort: str
    owner: str = ""
    place: int = 0


class ExcitationColumns(NamedTuple):
    """What excitations w (i,) contribute to the equations.

    Forces (n, i) w; the values (h, i) w of the released constraints of positions, (g, i) w of those of velocities.
    """

    released: Released
    forces: Array
    positions: Array
    velocities: Array


def read(scene: Scene, names: Sequence[str] | None, drivers: bool = True) -> list[Excitation]:
    """The excitations with these names, each once; without names, all inputs of the model.

    Messages about unknown names list drivers only if ``drivers`` is true.

    Raises
    ------
    UsageError
        If a name is unknown, or is that of an element that nothing excites.
    """
    if names is None:
        return [_input(scene, name) for name in scene.inputs]
    if isinstance(names, str) or not all(isinstance(name, str) for name in names):
        raise UsageError(f"found {names!r}, expected names of inputs", hint='e.g. ["u"], or a driver, ["base.s"]')
    return list(dict.fromkeys(_named(scene, name, drivers) for name in names))


def all_of(scene: Scene, drivers: bool = True) -> list[str]:
    """Names of everything that may oscillate, with or without drivers."""
    found = list(scene.inputs)
    for c in scene.components.values():
        if not drivers and isinstance(c.kind, JointKind):
            continue
        found += [f"{c.name}.{key}" for key in _parameters(c)]
    return found


def _input(scene: Scene, name: str) -> Excitation:
    unit = scene.inputs[name].unit
    return Excitation(name, "" if unit == "1" else unit, INPUT)


def _named(scene: Scene, name: str, drivers: bool) -> Excitation:
    if name in scene.inputs:
        return _input(scene, name)
    components = scene.components
    owner, key = (name, "") if name in components else name.rpartition(".")[::2]
    known, nothing = all_of(scene, drivers), f"{NOTHING}{' or a driver' * drivers}"
    if owner not in components:
        hint = did_you_mean(name, known) or f"what can oscillate: {few(known)}" if known else nothing
        sorts = "input, driver or force" if drivers else "input or force"
        raise UsageError(f"{scene.name} has no {sorts} `{name}`", hint=hint)
    c = components[owner]
    others, known = known, list(_parameters(c))
    if not known:
        hint = f"what can oscillate: {few(others)}" if others else nothing
        raise UsageError(f"`{owner}` is a {c.kind.name}, which has nothing that can oscillate", hint=hint)
    if not key and len(known) > 1:
        named = " or ".join(f"`{owner}.{key}`" for key in known)
        raise UsageError(f"`{owner}` has {count(len(known), 'amplitude')}", hint=f"name one of them: {named}")
    key = key or known[0]
    if key not in known:
        hint = did_you_mean(key, known, f"`{owner}` has")
        raise UsageError(f"`{owner}` has no amplitude `{key}`", hint=hint)
    sort = FORCE if isinstance(c.kind, ForceKind) else DRIVER if c.kind.driver else RATE  # type: ignore[attr-defined]
    return Excitation(f"{owner}.{key}", c.kind.unit_of(key) or "", sort, owner, known.index(key))


def _parameters(c: Component) -> tuple[str, ...]:
    """The parameters of an element that have an amplitude."""
    if isinstance(c.kind, ForceKind):
        return c.kind.laws
    if isinstance(c.kind, JointKind) and c.kind.driver:
        return (c.kind.driver,)
    if isinstance(c.kind, JointKind) and len(c.velocity_constraints) == 1 and len(c.kind.law_parameters) == 1:
        return c.kind.law_parameters
    return ()


def columns(system: System, found: Sequence[Excitation], t: float, q: Array, v: Array, lam: Array) -> ExcitationColumns:
    """The columns of excitations at a state."""
    scene, tables = system.scene, system.tables
    inputs = [e.name for e in found if e.sort == INPUT]
    forces = np.zeros((system.n, len(found)))
    of_inputs = input_forces(system, inputs, t, q, v, lam)
    for k, e in enumerate(found):
        if e.sort == INPUT:
            forces[:, k] = of_inputs[:, inputs.index(e.name)]
        elif e.sort == FORCE:
            forces[:, k] = forces_of(system, scene.components[e.owner], e.place, t, q, v, lam)
    places = {e.name: tables.rows[e.owner] + scene.components[e.owner].kind.rows - 1 for e in found if e.sort == DRIVER}
    positions = np.array([[float(e.name == name) for e in found] for name in places]).reshape(len(places), len(found))
    rates: dict[int, Array] = {}
    for k, e in enumerate(found):
        if e.sort == RATE:
            rates.setdefault(tables.velocity_rows[e.owner] - system.m, np.zeros(len(found)))[k] = 1.0
    for c in scene.components.values():
        used = {leaf.value for leaf in leaves(*c.velocity_constraints) if leaf.op == "input"}
        if not used & set(inputs):
            continue
        slopes = signal_derivatives(system, c.velocity_constraints, inputs, t, q, v, lam).u
        for i, row in enumerate(slopes):
            if row.any():
                own = rates.setdefault(tables.velocity_rows[c.name] - system.m + i, np.zeros(len(found)))
                own[[k for k, e in enumerate(found) if e.sort == INPUT]] -= row
    velocities = np.array([*rates.values()]).reshape(len(rates), len(found))
    return ExcitationColumns(Released(tuple(places.values()), tuple(rates)), forces, positions, velocities)
