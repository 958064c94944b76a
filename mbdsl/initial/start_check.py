"""The initial state of a model, assembled for ``mbdsl check``: without a run, and with uncompiled kernels.

An assembly evaluates the equations some ten times. Python needs 10 ms for this with a slider crank; compiling its
kernels takes ten seconds, and loading compiled ones half a second, because LLVM is imported.
"""

from __future__ import annotations

from collections.abc import Iterator
from time import process_time

import numpy as np

from mbdsl.compilation import code_cache
from mbdsl.errors import InitialisationError
from mbdsl.initial.consistent import InitialState, Moved, determined, initial_state
from mbdsl.initial.mass_check import singular_mass
from mbdsl.initial.mirrored_poses import MIRRORED
from mbdsl.initial.misfits import misfits, turned_around
from mbdsl.initial.rates_not_given import rates_not_given
from mbdsl.initial.redundancy import not_unique, repeated
from mbdsl.initial.start_conditions import check_loose
from mbdsl.initial.weights import members_of
from mbdsl.mechanism.extreme_numbers import blame_extremes
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.reduction import Part, Reduction, reduce
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import count, few
from mbdsl.system import System, build

#: time [s] of the processor after which a search for positions is given up, however busy the machine is; four-bar
#: linkages of 3,600 unknowns take 3 s
LIMIT = 10.0
#: unknowns above which a model is not assembled: one evaluation would take a second
MOST = 10_000


def check_start(graph: MechanismGraph) -> list[str]:
    """Assemble a model at its start time.

    Flexible bodies that have to deform for it are not brought to their static shape.

    Parameters
    ----------
    graph : MechanismGraph
        The structure of the model.

    Returns
    -------
    list of str
        Lines about the result: guesses that were changed, redundant constraints, and the size that errors are relative
        to; or why it was not assembled.

    Raises
    ------
    InitialisationError
        If there is no consistent initial state, or the mass matrix is singular.
    """
    number = graph.coordinates + graph.rows + graph.velocity_rows
    if number > MOST:
        return [f"not assembled: {number} unknowns, more than {MOST}; mbdsl simulate assembles the model"]
    try:
        with code_cache.uncompiled(), np.errstate(all="ignore"):  # as compiled code, which gives nan
            return _assembled(graph.scene, graph)
    except TimeoutError as late:
        best: InitialisationError = late.args[0]
        worst = "; ".join(text for text, _ in best.notes)
        more = "mbdsl simulate searches further, by compiled code"
        return [f"no consistent initial positions found within {LIMIT:g} s; {more}", f"  the best so far: {worst}"]


@blame_extremes
def _assembled(scene: Scene, graph: MechanismGraph) -> list[str]:
    t, reduction = scene.experiment.start, reduce(graph, planar=False)
    whole = build(scene, graph)
    check_loose(reduction, whole, t)
    moved: list[Moved] = []
    redundant: list[str] = []
    rates: list[str] = []
    lines: list[str] = []
    for system, state in _states(reduction, whole, t):
        lines += misfits(system, t, state.q, state.v)
        lines += turned_around(system, t, state.q, state.v)
        if (problem := singular_mass(system, t, state.q, state.v, state.lam)) is not None:
            raise problem
        if (held := singular_mass(system, t, state.q, state.v)) is not None:
            bodies = held.message.partition(": ")[2]
            lines.append(f"{bodies}; springs alone determine where it is, which few methods solve (radau5)")
            lines.append(f"  {held.hint}")
        moved += state.moved
        lines += [MIRRORED.format(name) for name in state.mirrored]
        lines += [*state.notes, *state.turned]
        rates += rates_not_given(system, state)
        names = system.constraint_names()
        redundant += [names[k] for k in state.redundant if k not in system.tables.switchable]
        lines += [f"  {line}" for line in repeated(system, t, state.q, state.v, state.redundant)]
        if scene.spatial:
            lines += [f"  {line}" for line in not_unique(system, t, state.q, state.redundant)]
    if rates:
        lines.append(f"initial rates that are not given and not zero: {few(rates)}")
    if redundant:
        follow = "follows" if len(redundant) == 1 else "follow"
        lines.insert(0, f"redundant: {', '.join(redundant)} {follow} from the other constraints")
        lines.insert(0, _mobility(graph, len(redundant)))
    return [f"assembled at t = {t:g} s{_guesses(moved)}", *lines, _size(whole)]


def _size(whole: System) -> str:
    """What errors of positions are relative to; a size that is not that of the parts gives way to a long motion."""
    size, far = whole.tables.size, whole.tables.outgrown_from
    or_motion = f", or to the largest displacement of a run if that is above {far * size:.3g} m" if far < 1e3 else ""
    return f"errors of positions are relative to {size:.3g} m{or_motion}"


def _mobility(graph: MechanismGraph, redundant: int) -> str:
    """The mobility that counts independent rows only, without those of rigid contacts."""
    rows = graph.rows + graph.velocity_rows - redundant
    sides = f"{count(graph.coordinates, 'coordinate')} - {count(rows, 'independent constraint row')}"
    return f"true mobility {graph.coordinates - rows} = {sides}"


def _states(reduction: Reduction, whole: System, t: float) -> Iterator[tuple[System, InitialState]]:
    """The parts of a model, as a simulation solves them, and their initial states."""
    until = process_time() + LIMIT
    for part in reduction.parts:
        system = whole if reduction.nothing_done else build(part.scene, part.graph, size=whole.tables.size)
        state = initial_state(system, part.graph, t, members_of(reduction, system), until=until)
        if part.kinematic and (state.redundant or not determined(system, t, state.q)):
            assert part.dynamic is not None
            other = Part(part.dynamic)
            system = build(other.scene, other.graph, size=whole.tables.size)
            state = initial_state(system, other.graph, t, members_of(reduction, system), until=until)
        yield system, state


def _guesses(moved: list[Moved]) -> str:
    if not moved:
        return ""
    changes = [m.change() for m in moved]
    more = f", and {len(changes) - 3} more" if len(changes) > 3 else ""
    return f"; {count(len(moved), 'guess', 'guesses')} moved: {', '.join(changes[:3])}{more}"
