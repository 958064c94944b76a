"""Laws that have no finite value, or no finite derivative, at a state: their names, and the signals they depend on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.symbolic import TIME, Expr, leaves, walk
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Component
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.system.signals import values
from mbdsl.system.system import System

MOST = 4  #: signals named in a message


class Broken(NamedTuple):
    """A law that has no value: its component, and what is wrong in words."""

    component: Component
    message: str


def broken_law(system: System, t: float, q: Array, v: Array, lam: Array | None = None) -> Broken | None:
    """The first law that is not a finite number at the state, or whose derivative is not; None if all are finite."""
    at = np.array([t]), q[None], v[None], None if lam is None else lam[None]
    if not (np.isfinite(q).all() and np.isfinite(v).all()):
        return None
    for c in system.scene.components.values():
        for p in c.kind.parameters:
            law = c.values[p.name]
            if not (p.law and isinstance(law, Expr)):
                continue
            on = [x for x in leaves(law) if lam is not None or x.op != "multiplier"]
            if lam is None and len(on) < len(leaves(law)):
                continue
            value, *slopes = (float(x[0]) for x in values(system, [law, *diff(law, *on)], *at))
            if not np.isfinite([value, *slopes]).all():
                what = "is infinite" if np.isinf(value) else "has no value"
                if np.isfinite(value):
                    what = "has an infinite derivative"
                where = _depends_on(system, c, law, at)
                law_name = c.name if c.kind.name == "StateRate" else f"{c.name}.{p.name}"
                return Broken(c, f"`{law_name}` {what}" + (f" at {where}" if where else ""))
    return None


def _depends_on(system: System, c: Component, law: Expr, at: tuple[Array, Array, Array, Array | None]) -> str:
    """The signals of other components that a law of ``c`` depends on, with their values."""
    nodes, names, found = set(walk(law)), SignalNames(system.scene), dict[Expr, str]()
    for name, x in system.scene.signals().items():
        if x in nodes and leaves(x) and name.rpartition(".")[0] != c.name:
            found[x] = name  # of several names of a quantity, that of a joint, which comes after its bodies
    kept = list(found)[:MOST]
    numbers = zip(kept, values(system, kept, *at), strict=True)
    shown = [f"{found[x]} = {float(number[0]):g} {names.unit(found[x])}".rstrip() for x, number in numbers]
    return ", ".join([*shown, *([f"time = {at[0][0]:g} s"] if TIME in nodes else [])])


def not_finite(
    system: System, t: float, q: Array, v: Array, what: str, lam: Array | None = None
) -> InitialisationError:
    """The error of ``what`` (forces, their derivatives) that are not finite numbers at a state."""
    law = broken_law(system, t, q, v, lam)
    hint = "an expression divides by zero or leaves the domain of a function there"
    if "derivatives" in what:
        hint = "a function has no derivative there, as sqrt(x) at x = 0"
    if law is None:
        return InitialisationError(f"{what} at t = {t:g} s are not finite numbers", hint=hint)
    message = f"{what} at t = {t:g} s are not finite numbers: {law.message}"
    return InitialisationError(message, law.component.span, hint=hint)
