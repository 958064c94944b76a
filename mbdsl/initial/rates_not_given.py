"""Initial rates of joints that neither the model nor its constraints determine."""

from __future__ import annotations

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.symbolic import is_velocity_level
from mbdsl.initial.consistent import InitialState
from mbdsl.numerics.saddle_point import dense, null_space, row_size
from mbdsl.system.signals import gradients
from mbdsl.system.system import DENSE_LIMIT, System

UNITS = ("m/s", "rad/s")
ZERO = 1e-9  #: rates relative to the fastest motion, and parts of directions, that count as zero


def rates_not_given(system: System, state: InitialState) -> list[str]:
    """Rates of joints that no initial value gives and that are not zero, as texts.

    [] of large systems, and of flexible bodies, which begin without rates of deformation.
    """
    scene, scale, (t, q, v) = system.scene, system.tables.scale, (state.t, state.q, state.v)
    fastest = float(np.abs(v * scale).max(initial=0.0))
    if not fastest or system.unknowns > DENSE_LIMIT or system.tables.flexible:
        return []
    joints = [c for c in scene.components.values() if isinstance(c.kind, JointKind) and c.kind.driver is None]
    rates = {
        f"{c.name}.{key}": (rate, c.kind.unit_of(key))
        for c in joints
        for key, rate in scene.signals_of(c).items()
        if c.kind.unit_of(key) in UNITS and is_velocity_level(rate)
    }
    given = [x.target for x in scene.initial if is_velocity_level(x.target)]
    rows = np.vstack([dense(system.velocity_jacobian(t, q, v)), dense(gradients(system, given, t, q, v)[2])]) / scale
    free = null_space(rows / row_size(rows)[:, None])
    value, _, d_v = gradients(system, [rate for rate, _ in rates.values()], t, q, v)
    rows = dense(d_v) / scale
    size = row_size(rows)
    undecided = np.linalg.norm(rows @ free, axis=1) > ZERO * size
    moving = np.abs(value) > ZERO * fastest * size
    found = zip(rates.items(), value, undecided & moving, strict=True)
    return [f"{name} = {x:.6g} {unit}" for (name, (_, unit)), x, listed in found if listed]
