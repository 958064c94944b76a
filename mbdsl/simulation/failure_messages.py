"""Error messages of runs: the time, the equations, the reason, and a remedy."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.errors import InitialisationError, IntegrationError, MbdslError, Span
from mbdsl.expressions.printing import text
from mbdsl.expressions.symbolic import Expr, leaves, walk
from mbdsl.initial.mass_check import singular_mass
from mbdsl.initial.redundancy import singular
from mbdsl.integrators import Run, declared, method_files
from mbdsl.integrators.backends import External
from mbdsl.integrators.event_set import EventSet
from mbdsl.integrators.events import HARDLY, SLIDING, SLIDING_HINT, reads_reactions, sliding
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.integrators.standstill import STALLED, laws
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism.contacts import is_contact
from mbdsl.mechanism.events import Branch
from mbdsl.mechanism.scene import Component, is_state
from mbdsl.messages import few
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.result_checks import bending, failed, too_bent
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system import System
from mbdsl.system.broken_laws import Broken, broken_law
from mbdsl.system.paradox import Paradox, paradox
from mbdsl.system.signals import values
from mbdsl.system.switches import Switch, law_of, within

#: number of the last events of when-equations that show these as the cause of a run without progress
FEW = 4
#: rotation of a body in a step that may be the reason why it fails [rad]
FAR_TURN = 0.5
#: ends of a run in Newton's iteration
OF_ITERATION = (S.SINGULAR, S.DIVERGED, S.NOT_FINITE, S.TOO_LARGE)


def _indefinite(integration: MethodRun) -> str | None:
    """A body whose mass matrix has lost its definiteness at the last step or iterate."""
    tables, vectors = integration.system.tables, integration.vectors
    for name, body in tables.models.items():
        d = tables.coordinates[name]
        for row in (L.POSITION0, L.POSITION):
            q = vectors[row, d : d + body.n]
            if body.deforms and np.isfinite(q).all() and not np.linalg.eigvalsh(body.M(q))[0] > 0.0:
                return name
    return None


def _inextensible(system: System) -> str | None:
    """A beam whose ends are held by joints, and that shortens when it bends, but cannot stretch."""
    for name in system.tables.models:
        values = system.scene.components[name].values
        if values.get("stiffening") and values["modes"] and values["formulation"] == "floating":
            if values["axial"] == 0 or (values["axial"] is None and values["basis"] == "eigenmodes"):
                ends = {f"{name}.a", f"{name}.b"}
                joints = (c for c in system.scene.components.values() if isinstance(c.kind, JointKind))
                if ends <= {frame for c in joints if c.kind.rows > 1 for frame in c.ports.values()}:
                    return name
    return None


REASONS = {
    S.SINGULAR: "the iteration matrix is singular",
    S.DIVERGED: "Newton's iteration does not converge",
    S.NOT_FINITE: "the equations give values that are not finite",
    S.TOO_LARGE: "the step is so large that the result means nothing",
    S.TOO_SMALL: "no step is small enough for the tolerance",
    S.SLIDING: SLIDING,
    S.STIFF: "the model is stiff, and stability limits this explicit method",
    STALLED: "the run stands still",
}


REMEDIES = {
    S.SINGULAR: "redundant constraints, a singular pose, or a body without mass that moves freely",
    S.DIVERGED: "try a smaller step; near a singular pose, another initial value",
    S.NOT_FINITE: "an expression or its derivative leaves its domain (as sqrt at 0), or the step is too large",
    S.TOO_LARGE: "try a smaller step",
    S.SLIDING: SLIDING_HINT,
    S.TOO_SMALL: "a jump of forces, or a tolerance below rounding, as near a singular pose: try a larger tolerance",
    S.STIFF: "take radau5, whose steps are not limited by stability",
    STALLED: "make this force smoother, such as by a larger v_s in tanh(v/v_s), or try a larger tolerance",
}


def _broken_law(integration: MethodRun) -> Broken | None:
    """The first law that is not finite, or has no finite derivative, at the last iterate or the start of the step."""
    system, vectors, n = integration.system, integration.vectors, integration.system.n
    for row, rate, time in (
        (L.POSITION, L.VELOCITY, S.STEP_END),
        (L.POSITION0, L.VELOCITY0, S.NOW),
    ):
        q, v = system.out_of_charts(vectors[row, :n], integration.numbers), vectors[rate, :n]
        if (found := broken_law(system, float(integration.reals[time]), q, v)) is not None:
            return found
    return None


def _given_up(run: External, trajectory: Trajectory) -> IntegrationError:
    """The error of a backend."""
    message = f"{run.method} stopped at t = {run.time:.9g} s: {run.reason}"
    hint = run.hint or "a larger tolerance may pass, or another method; see `mbdsl methods`"
    span = getattr(run.cause, "span", None)
    if not isinstance(run.cause, MbdslError) and (place := method_files.place(run.cause)) is not None:
        span, hint = place, "the file of the method raised this error; --debug shows the traceback"
    if (bent := bending(trajectory)) is not None:
        reason, hint = too_bent(trajectory, *bent)
        message, span = f"{message}; {reason}", trajectory.scene.components[bent[1]].span
    error = failed(trajectory, message, span, hint, getattr(run.cause, "notes", ()))
    error.__cause__ = run.cause
    return error


def failure(motion: MechanismRun, trajectory: Trajectory, status: int) -> IntegrationError:
    """The error of a failed run: the reason, the time, the equations and a remedy."""
    assert motion.failed is not None
    integration = motion.failed.integration
    if status in (S.ASSERTED, S.ENDLESS):
        assert motion.event_set is not None
        return _of_events(integration, motion.event_set, trajectory)
    if isinstance(integration, External):
        return _given_up(integration, trajectory)
    assert isinstance(integration, MethodRun)
    if status == S.UNSOLVED:
        problem = integration.events.unsolved
        assert problem is not None
        return failed(trajectory, problem.message, problem.span, problem.hint, problem.notes)
    if status == S.SLIDING and (branches := _restless(integration)):
        return _of_chatter(branches, trajectory)
    t, notes = integration.reals[S.STEP_END], ()
    if status == S.STIFF and _singular_pose(integration, t):
        status = S.DIVERGED  # accelerations that change by any amount are not those of a stiff force
    if status == S.STIFF:
        trajectory.stats["stiff"] = True
    message, span, hint, of_law = _cause(integration, status, t, _remedy(motion, integration, status))
    regular = (S.SLIDING, S.STIFF, STALLED)
    if status not in regular and not of_law and (pose := _singular_pose(integration, t)):
        message += f"; {pose}"
    if not of_law and (near := _paradox(integration)) is not None:
        message, span, hint = f"{message}; {near.text}", near.span, "take a smaller coefficient of friction"
    more, place, hint = _of_bodies(trajectory, integration, hint)
    message, span = message + more, place or span
    if status in OF_ITERATION and (turn := _largest_turn(integration)) is not None:
        message += f"; {turn[0]} turns by {turn[1]:.2g} rad in this step"
        hint = f"try a step in which {turn[0]} turns by less than {FAR_TURN:g} rad; otherwise: {hint}"
    if status == S.SINGULAR and (light := _without_mass(integration)) is not None:
        message, span, hint, notes = f"{message}; {light.message}", light.span, light.hint or hint, light.notes
    return failed(trajectory, message, span, hint, notes)


def _of_events(integration: Run, events: EventSet, trajectory: Trajectory) -> IntegrationError:
    """The error of a run that an assertion or an endless event has ended."""
    t = float(trajectory.t[-1])
    if (action := events.failed) is not None:
        sides = _sides(action.value, integration, events)
        at = f" ({sides[0]:g} against {sides[1]:g})" if sides else ""
        message = f"the assertion `{action.target}` is false at t = {t:.9g} s{at}: {action.text}"
        return failed(trajectory, message, action.span, "the results up to this time are kept")
    branches = events.endless
    notes = tuple(("this one acts as well", b.span) for b in branches[1:4] if b.span is not None)
    message = f"the when-equations act without end at t = {t:.9g} s: they change what their own conditions read"
    hint = "use pre(x) for the value before the event, and conditions that become true once"
    return failed(trajectory, message, branches[0].span, hint, notes)


def _restless(integration: MethodRun) -> list[Branch]:
    """The when-equations whose events follow one another without progress of time, at the end of a run."""
    events = integration.events.set
    last = events.acted[-FEW:] if events is not None else []
    close = len(last) == FEW and last[-1].t - last[0].t <= HARDLY * (integration.stop - integration.start)
    if close and (found := list({id(b): b for x in last for b in x.branches}.values())):
        return found
    changing = [x.node for x in integration.events.changing]
    return [] if law_of(integration.system.scene, changing) is not None else _whens(integration)


def _whens(integration: MethodRun) -> list[Branch]:
    """The when-equations whose conditions change within every step, at the end of a run."""
    unresolved = integration.landings.unresolved
    nodes = {x.node for x in integration.events.changing} | ({unresolved} if unresolved is not None else set())
    return [b for b in integration.system.scene.events.branches if nodes & set(walk(*b.conditions))]


def _of_chatter(branches: Sequence[Branch], trajectory: Trajectory) -> IntegrationError:
    """The error of a run that such when-equations have ended."""
    message = f"the when-equation acts again and again without progress of time at t = {float(trajectory.t[-1]):.9g} s"
    if any(a.what == "reinit" for b in branches for a in b.actions):
        hint = "a body that bounces comes to rest at a rigid `Contact(gap = ..., e = ...)` in place of `reinit`"
    elif all(leaf.op == "time" for b in branches for leaf in leaves(*b.conditions)):
        hint = "let its condition change less often, or write `sample(start, period)`"
    else:
        hint = "give a hysteresis: a threshold to switch on and another one to switch off; or sample the condition"
    notes = tuple(("this one acts in turn with it", b.span) for b in branches[1:4] if b.span is not None)
    return failed(trajectory, message, branches[0].span, hint, notes)


def _sides(root: Expr | None, integration: Run, events: EventSet) -> list[float]:
    """The two sides of a comparison at the end of a run, in SI units; [] for other conditions."""
    if root is None or root.op not in ("lt", "le", "eq", "ne"):
        return []
    q, v, lam = integration.state()
    inputs = {name: np.array([x]) for name, x in events.values.items()}
    found = values(integration.system, root.args, np.array([integration.time]), q[None], v[None], lam[None], inputs)
    return [float(x[0]) for x in found]


def _remedy(motion: MechanismRun, integration: MethodRun, status: int) -> str:
    """What helps against the end of a step loop with this status."""
    system, hint = integration.system, REMEDIES[status]
    if status == S.DIVERGED and motion.plan.tol is None and system.tables.has_tape:
        hint = f"take --tol, which shortens the steps that do not converge at a jump of a force, or {hint}"
    special = declared(integration.method).diverges
    if status == S.DIVERGED and system.m and special:
        hint += f"; {special}"
    return hint


def _cause(integration: MethodRun, status: int, t: float, hint: str) -> tuple[str, Span | None, str, bool]:
    """What ended the run and where, the place in the model, the remedy, and whether a law is the cause."""
    system = integration.system
    broken = _broken_law(integration) if status == S.NOT_FINITE else None
    law, reason = broken.component if broken else None, REASONS[status]
    where, span = "", None
    changing: Sequence[Switch] = ()
    if status not in (S.SLIDING, S.TOO_SMALL, S.STIFF, STALLED):  # they have no residuals of Newton's iteration
        where, span = _worst_equations(integration)
    if status == S.SLIDING:
        changing = integration.events.changing or [x for x in system.tables.switches if reads_reactions(x)]
        law = law_of(system.scene, [switch.node for switch in changing])
        reason, hint = sliding(changing)
    elif status == S.TOO_SMALL and integration.landings.unresolved is not None:
        law = law_of(system.scene, [integration.landings.unresolved])
        where, span = next((("the condition of the `when`", b.span) for b in _whens(integration)), (where, span))
    if law is not None:
        where, span = _law(law), law.span
    message = f"{reason} in the step to t = {t:.9g} s (h = {integration.step:g} s)"
    if status == S.SLIDING and law is not None:
        what = _conditions(system, law, changing) or "it"
        message += f"; {what} changes in {where}"
    elif status == STALLED:
        more, span, hint = _of_standstill(integration, hint)
        message += f"; {more}"
    elif status == S.STIFF:
        more, hint = _of_stiffness(integration, hint)
        message += f"; {more}"
    elif status == S.TOO_SMALL and where:
        message += f"; {where} changes within every step, however short"
        hint = "if only rounding errors make it change, use fixed steps (--step); otherwise try a larger tolerance"
    elif broken is not None:
        message += f"; {broken.message}"
    elif where:
        message += f"; worst: {where}"
    return message, span, hint, law is not None


def _of_bodies(trajectory: Trajectory, integration: MethodRun, hint: str) -> tuple[str, Span | None, str]:
    """What bodies that deform have to do with a failure: a text, the place in the model, and the remedy."""
    if (bent := bending(trajectory)) is not None:
        reason, hint = too_bent(trajectory, *bent)
        return f"; {reason}", trajectory.scene.components[bent[1]].span, hint
    if (beam := _indefinite(integration)) is not None:
        hint = (
            "energies of second order are invalid for these shapes in this floating frame: take another `reference`, "
            'fewer modes, formulation = "ancf", or a method that does not need the inverse of M'
        )
        span = integration.system.scene.components[beam].span
        return f"; the mass matrix of {beam} is no longer positive definite", span, hint
    if (beam := _inextensible(integration.system)) is not None:
        hint = f"{beam} may have no axial mode: its ends cannot come closer when it bends; give `axial`; or {hint}"
    return "", None, hint


def _paradox(integration: MethodRun) -> Paradox | None:
    """Painleve's paradox in a joint at the beginning of the step, if the reactions there are near it."""
    if not integration.system.of_multipliers:
        return None
    q, v, lam = integration.state()
    return paradox(integration.system, integration.time, q, v, lam, tuple(integration.left_out))


def _without_mass(integration: MethodRun) -> InitialisationError | None:
    """Bodies that can move without moving a mass at the beginning of the step; None if there are none."""
    system, vectors, n = integration.system, integration.vectors, integration.system.n
    q = system.out_of_charts(vectors[L.POSITION0, :n], integration.numbers)
    return singular_mass(system, float(integration.reals[S.NOW]), q, vectors[L.VELOCITY0, :n])


def _largest_turn(integration: MethodRun) -> tuple[str, float] | None:
    """The body in space that turns most in the step, and its angle, if that is more than FAR_TURN [rad]."""
    tables, v = integration.system.tables, integration.vectors[L.VELOCITY0]
    of = {d: name for name, d in tables.coordinates.items()}
    turns = {of[int(d) - 3]: integration.step * float(np.linalg.norm(v[d : d + 3])) for d, _ in tables.rotations}
    name = max(turns, key=lambda k: turns[k], default="")
    return (name, turns[name]) if turns and turns[name] > FAR_TURN else None


def _conditions(system: System, law: Component, switches: Sequence[Switch]) -> str:
    """The conditions of those switches that are in a law, as text of the model."""
    own = [x for name, expression in laws(system) if name == law.name for x in within(expression, switches)]
    found = dict.fromkeys(re.sub(r"\b(\d+)\.0\b", r"\1", _as_written(system, x.node)) for x in own)
    return few((f"`{x[1:-1] if x.startswith('(') and x.endswith(')') else x}`" for x in found), 2)


def _as_written(system: System, node: Expr) -> str:
    """An expression as text, in which a state has its name, and not that of its velocity."""
    found = text(node)
    for name in (c.name for c in system.scene.components.values() if is_state(c)):
        found = found.replace(f"{name}.c.vx", name)
    return found


def _law(law: Component) -> str:
    """What the law of a component is called: that of a state is an equation, that of a contact its gap."""
    if law.kind.name == "StateRate":
        return f"the equation of {law.name}"
    return f"the {'gap' if is_contact(law) else 'law'} of {law.kind.name} {law.name}"


def _of_standstill(integration: MethodRun, hint: str) -> tuple[str, Span | None, str]:
    """What holds a run that stands still: a text, the place of the law, and the remedy."""
    stall, system = integration.standstill.found, integration.system
    assert stall is not None
    so_far = f"its last {stall.steps} steps advanced it by {stall.advance:.2g} s"
    if stall.law:
        law = system.scene.components[stall.law]
        changes = f" ({found} changes)" if (found := _conditions(system, law, stall.switches)) else ""
        return f"{so_far}, and {_law(law)} jumps back and forth between them{changes}", law.span, hint
    if stall.coordinate:
        return f"{so_far}, and the force on {stall.coordinate} jumps back and forth between them", None, hint
    return so_far, None, "the motion may end there, as at a pole of a force; otherwise try a larger tolerance"


def _of_stiffness(integration: MethodRun, hint: str) -> tuple[str, str]:
    """The product of step and largest eigenvalue, and the remedy."""
    found, stable = integration.reals[S.RADIUS], declared(integration.method).stable
    if integration.tol is None:
        hint = f"take a step below {integration.step * stable / found:.2g} s, or {hint.removeprefix('take ')}"
    return f"h |lambda| = {found:.3g}, stable up to {stable:g}", hint


def _worst_equations(integration: MethodRun) -> tuple[str, Span | None]:
    """The equations with the largest residuals, and where the joint of the first constraint of them is written."""
    system, n = integration.system, integration.system.n
    names = system.names() + system.constraint_names()
    residual = np.abs(integration.vectors[L.RESIDUAL, : len(names)])
    if not residual.any():  # the method has none: constraints at the last evaluation
        residual[n:] = np.abs(integration.vectors[L.FORCE, n : len(names)])
    if not residual.any():
        return "", None
    bad = np.flatnonzero(~np.isfinite(residual))
    worst = bad[:3] if len(bad) else np.argsort(-residual)[:3]
    where = ", ".join(names[k] if k >= n else f"equation of motion of {names[k]}" for k in worst)
    row = next((int(k) - n for k in worst if k >= n), None)
    if row is None:
        return where, None
    rows = {**system.tables.rows, **system.tables.velocity_rows}
    owner = max((r, j) for j, r in rows.items() if r <= row)[1]
    return where, system.scene.components[owner].span


def _singular_pose(integration: MethodRun, t: float) -> str | None:
    """How the pose is singular, at the start of the step or at the last iterate."""
    vectors, n = integration.vectors, integration.system.n
    start, last = (
        singular(
            integration.system,
            t,
            integration.system.out_of_charts(vectors[q, :n], integration.numbers),
            vectors[v, :n],
            integration.left_out,
        )
        for q, v in (
            (L.POSITION0, L.VELOCITY0),
            (L.POSITION, L.VELOCITY),
        )
    )
    return start or last
