"""Warnings about angles of models in space whose turns between output times are uncertain.

Coordinates in space do not contain turns: those of results follow from the mean of the rates at two output times
(:func:`mbdsl.expressions.array_operations.counted`). Where the rates differ by more than a turn per interval, or their
mean predicts an angle that differs by more than a quarter turn from the nearest possible one, the count may be wrong,
although the motion is right.
"""

from __future__ import annotations

from math import pi

import numpy as np

from mbdsl.expressions.symbolic import Expr, walk
from mbdsl.mechanism.energies import energies
from mbdsl.mechanism.scene import ENERGIES, Component
from mbdsl.simulation.examined_run import ExaminedRun
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.signals import values

MOST = 5  #: signals that are named with an angle


def _angles(c: Component) -> set[str]:
    return {x.name for x in c.kind.signals if x.unit == "rad"}


def warnings(run: ExaminedRun) -> list[str]:
    """A warning about angles whose turns may be counted wrong; none in the plane."""
    return uncertain(run.trajectory)


def uncertain(trajectory: Trajectory) -> list[str]:
    """A warning about the first angle of a joint or force whose turns may be counted wrong, and the signals that follow
    from such angles; none in the plane."""
    scene, t = trajectory.scene, trajectory.t
    components = scene.components.values() if scene.spatial and len(t) > 1 else ()
    angles, first = set[tuple[Expr, ...]](), ""
    for c, key in ((x, key) for x in components if x.ports for key in x.signals if key in _angles(x)):
        node = scene.signal_of(c, key)
        if node is None or node.op != "angle" or node.args in angles:
            continue
        angle, rate = values(trajectory.system, [node, node.value], t, trajectory.q, trajectory.v)
        doubt = np.abs(0.5 * (rate[1:] + rate[:-1]) * np.diff(t) - np.diff(angle)) > 0.5 * pi
        far = np.flatnonzero(doubt | (0.5 * np.abs(np.diff(rate)) * np.diff(t) > pi))
        if not len(far):
            continue
        angles.add(node.args)
        if not first:
            k, name = int(far[0]), f"{c.name}.{key}"
            first = f"{c.span}: {name}" if c.span is not None else name
            changes = f"its rate changes from {rate[k]:.3g} to {rate[k + 1]:.3g} rad/s until the next output"
            when = f"may be wrong by whole turns after t = {t[k]:g} s"
    if not first:
        return []
    every = scene.signals() | dict(zip(ENERGIES, energies(scene), strict=True))
    others = [n for n, x in every.items() if n != name and any(y.op == "angle" and y.args in angles for y in walk(x))]
    more = f" and {len(others) - MOST} others" if len(others) > MOST else ""
    with_it = f", and with it {', '.join(others[-MOST:])}{more}" if others else ""
    return [f"{first} {when}{with_it}: {changes}; take a shorter interval"]
