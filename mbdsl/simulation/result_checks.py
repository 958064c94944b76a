"""Checks of results: a run whose motion is not that of the model, or less accurate than it has to be, is an error."""

from __future__ import annotations

import numpy as np

from mbdsl.bodies.contract import LARGEST_BEND
from mbdsl.elements.kind import JointKind
from mbdsl.elements.line_of_centres import THETA_0, TURN
from mbdsl.errors import IntegrationError, Span
from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import coordinate, expr, substitute
from mbdsl.integrators import declared
from mbdsl.simulation import derived_signals
from mbdsl.simulation.left_out_rows import violated, violations
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.bending import REMEDY, SMALL, first_bend
from mbdsl.system.signals import values

#: a reason why a tolerance is not reached; another method may reach it
TOO_MANY_STEPS = "it would take too many steps"
#: error estimates above this only show that the error is not known
LITTLE_KNOWN = 0.05


def failed(
    trajectory: Trajectory,
    message: str,
    span: Span | None = None,
    hint: str | None = None,
    notes: tuple = (),
    status: str = "failed",
) -> IntegrationError:
    """The error of a run with its results, which get this status and message."""
    trajectory.stats["status"], trajectory.message = status, message
    error = IntegrationError(message, span, hint=hint, notes=notes)
    error.trajectory = trajectory
    return error


def check_left_out(motion: MechanismRun, trajectory: Trajectory, states: list) -> None:
    """Raise an error if a constraint that was left out as redundant is violated: the motion is then not that of the
    model. The error has the results up to there."""
    for part, (every_q, every_v) in zip(motion.parts, states, strict=True):
        system = part.system
        rows = [k for k in part.initial.redundant if k not in system.tables.switchable]
        if not rows:
            continue
        angles = derived_signals.angles(system, trajectory.t, every_q, every_v)
        every = violations(system, part.initial, trajectory.t, every_q, every_v, angles)
        found, others = every[:, rows], np.delete(every, rows, axis=1)
        bad = np.flatnonzero(violated(every, rows))
        if len(bad):
            name = system.constraint_names()[rows[int(found[bad[0]].argmax())]]
            since = trajectory.t[bad[0]]
            if 0 < bad[0] < len(trajectory.t) - 1:
                trajectory = trajectory[:since]
            message = f"{name} was redundant at the start, but is violated from t = {since:g} s on"
            span = system.scene.components[name.rsplit(".", 1)[0]].span
            hint = "the mechanism locks there, or reaches a pose with fewer degrees of freedom"
            if others[bad[0]].max(initial=0.0) > 1e-3 * found[bad[0]].max():  # what the iteration leaves
                smaller = "step" if trajectory.stats.get("tol") is None else "tolerance"
                hint = f"the other constraints are not satisfied either: take a smaller {smaller}"
            raise failed(trajectory, message, span, hint)


def inaccurate(trajectory: Trajectory, reason: str) -> IntegrationError:
    """The error of a run that reaches its end, but not its tolerance."""
    tol, error, horizon = (trajectory.stats[key] for key in ("tol", "error", "horizon"))
    known = error is not None and error < LITTLE_KNOWN
    size = f"its error is about {error:.1g}" if known else "its error is not known"
    start, hint = trajectory.t[0], "ask for a larger tolerance"
    until = f"it is kept until t = {horizon:.6g} s" if horizon > start else "it is not kept at any time"
    if reason == TOO_MANY_STEPS and declared(trajectory.stats["method"]).order <= 2:
        hint += ", or take radau5, which needs fewer steps"
    if horizon > start:
        hint += f", or stop at t = {horizon:.6g} s"
    message = f"the tolerance of {tol:g} is not reached, {size}: {reason}; {until}"
    return failed(trajectory, message, hint=hint, status="inaccurate")


def bending(trajectory: Trajectory) -> tuple[float, str, float] | None:
    """The first time at which a body deforms beyond the range of its theory, its name, and the angle [rad]."""
    bend = first_bend(trajectory.system, trajectory.q)
    return None if bend is None else (float(trajectory.t[bend.row]), bend.name, bend.angle)


def check_bending(trajectory: Trajectory) -> None:
    """Raise an error if a body bends further than its theory allows."""
    if (found := bending(trajectory)) is not None:
        message, hint = too_bent(trajectory, *found)
        raise failed(trajectory, message, trajectory.scene.components[found[1]].span, hint)


def too_bent(trajectory: Trajectory, t: float, name: str, angle: float) -> tuple[str, str]:
    values = trajectory.scene.components[name].values
    hint = REMEDY
    if not values["stiffening"]:
        hint = f"with stiffening = true rotation stiffens it; {hint}"
    return (
        f"{name} bends by {angle:.2g} rad at t = {t:g} s: {SMALL}, "
        f"and beyond {LARGEST_BEND:g} rad the results are invalid",
        hint,
    )


def check_lines_of_centres(trajectory: Trajectory) -> None:
    """Raise an error if the line of centres of a RotationalCam passes the direction in which its angle jumps by a turn,
    and the law of the cam does not change by whole turns there: the constraint jumps, and the later motion is wrong."""
    scene, system = trajectory.scene, trajectory.system
    for name, component in scene.components.items():
        if not isinstance(component.kind, JointKind) or component.kind.coupling is None:
            continue
        theta = scene.signal_of(component, "theta")
        if theta is None:
            continue
        angles, rates = values(system, [theta, der(theta)], trajectory.t, trajectory.q, trajectory.v)
        # between distant output times a line that swings may turn by more than pi: the rate shows the direction
        change, expected = np.diff(angles), 0.5 * np.diff(trajectory.t) * (rates[1:] + rates[:-1])
        other = change - TURN * np.sign(change)
        jumps = np.flatnonzero((np.abs(change) > np.pi) & (np.abs(expected - other) < np.abs(expected - change)))
        if not len(jumps):
            continue
        law = expr(component.values[component.kind.coupling[0]])
        cam = coordinate(component.ports["frame_a"], "phi")
        turned = substitute(law, {cam: cam + TURN}.get)
        change = values(system, [turned - law], trajectory.t, trajectory.q, trajectory.v)[0][jumps] / TURN
        wrong = np.flatnonzero(np.abs(change - np.round(change)) > 1e-6)
        if len(wrong):
            since = float(trajectory.t[jumps[wrong[0]]])
            message = (
                f"after t = {since:g} s the line of centres of {name} passes {THETA_0 - np.pi:.3g} rad, where its "
                f"angle jumps by a turn, but `beta` changes by {change[wrong[0]]:.4g} turns when `phi` changes by one"
            )
            hint = (
                "with a line of centres that turns, `beta` has to change by whole turns, as in `beta = -2*phi`; "
                "gears of any ratio: GearPair"
            )
            raise failed(trajectory, message, component.span, hint)
