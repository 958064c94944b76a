"""Making of the tables of a scene (:mod:`mbdsl.system.tables`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import JointKind
from mbdsl.errors import ModelError
from mbdsl.expressions.frame_derivatives import by_motion, by_rate, frames_in
from mbdsl.expressions.symbolic import Expr, input_signal, is_velocity_level, leaves
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import columns_of
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.numerics.piecewise_cubic import piecewise
from mbdsl.system import clock_tables, gradient_rows, moving_frames, nonholonomic, relations, switches
from mbdsl.system.body_models import body_models, body_pose
from mbdsl.system.expression_tape import Tape
from mbdsl.system.peaks_in_time import abrupt
from mbdsl.system.structure import Block, expressions, find_blocks, law_expressions
from mbdsl.system.tables import Buffers, Tables, gravity, of_models

#: lengths below this part of the motion, or of the radii of gyration, are rounding: assembly closes gaps to 1e-12
COINCIDENT = 1e-10
#: displacement, relative to a size that is not that of the parts themselves, above which it becomes the size
FAR = 10.0


def build_tables(scene: Scene, general: bool = False, size: float | None = None) -> Tables:
    """Make the tables of ``scene``; ``general`` tables have space for all kinds of elements.

    ``size`` is that of the mechanism [m], by which translations are scaled; default: the size of the scene.
    """
    bodies = scene.with_coordinates()
    blocks = find_blocks(scene, general)
    coordinates: dict[str, int] = {}
    n = 0
    for body in bodies:
        coordinates[body.name] = n
        n += len(body.coordinates)
    rows: dict[str, int] = {}
    m = 0
    for block in blocks:
        if block.role == "joint":
            for c in block.components:
                rows[c.name] = m
                m += c.kind.rows
    velocity_rows: dict[str, int] = {}
    p = 0
    for block in blocks:
        if block.role == "gamma":
            for c in block.components:
                velocity_rows[c.name] = m + p
                p += len(c.velocity_constraints)
    frames = _used_frames(scene, blocks)
    if general or any(scene.frames[name].motion for name in frames):
        blocks.append(Block("moving", moving_frames))
    models = body_models(bodies)
    tables = Tables(scene, blocks, n, m, p, coordinates, rows, velocity_rows, frames, models)
    _fill(tables, size)
    return tables


def _used_frames(scene: Scene, blocks: list[Block]) -> dict[str, int]:
    """Frames used by joints, forces or expressions: the ground's first, then body by body."""
    used: dict[str, None] = {}
    for block in blocks:
        if block.role == "body":
            continue
        for c in block.components:
            if block.role != "gamma":
                for port in c.kind.ports:
                    used[c.ports[port]] = None
            for root in expressions(block, c):
                used |= dict.fromkeys(frames_in(root))
    for root in scene.conditions:
        used |= dict.fromkeys(frames_in(root))
    body_order = {body.name: i + 1 for i, b in enumerate(blocks) if b.role == "body" for body in b.components}
    position = {name: i for i, name in enumerate(c.name for b in blocks if b.role == "body" for c in b.components)}
    ordered = sorted(used, key=lambda f: (scene.frames[f].body in body_order, position.get(scene.frames[f].body, -1)))
    return {name: i for i, name in enumerate(ordered)}


def _searched(tables: Tables) -> list[Expr]:
    """The velocity constraints; notes the laws that are searched for peaks in another form."""
    nonholonomic_joints = [c for b in tables.blocks if b.role == "gamma" for c in b.components]
    for c in nonholonomic_joints:
        _search(tables, c, c.velocity_constraints, by_rate)
    for c in [c for b in tables.blocks if b.related for c in b.components]:
        _search(tables, c, c.relations, by_motion)
    for c in (c for b in tables.blocks if b.role == "law" for c in b.components if "searched" in c.values):
        first, *others = law_expressions(c)
        tables.row_laws |= {**dict.fromkeys(others), first: c.values["searched"]}
    return [g for c in nonholonomic_joints for g in c.velocity_constraints]


def _fill(tables: Tables, size: float | None) -> None:
    scene, frames, n, m, p = tables.scene, tables.frames, tables.n, tables.m, tables.p
    sizes = columns_of(scene.spatial)
    buffers = Buffers(L.BLOCKS + L.BLOCK * len(tables.blocks))
    layout = buffers.layout
    layout[L.N_Q], layout[L.N_PHI], layout[L.N_ALL] = n, m, n + m + p
    layout[L.N_STATES] = tables.states
    layout[L.N_FRAMES] = len(frames)
    for row in (L.LAM_ROW, L.LAW_ROW, L.PSI_ROW):
        layout[row] = L.UNKNOWN
    layout[L.MU_ROW] = L.UNKNOWN2
    Z = np.zeros((max(1, len(frames)), sizes.COLUMNS))
    dofs, lengths = _fill_frames(tables, buffers, Z)
    ground = layout[L.GROUND_FRAMES]

    g = gravity(scene)
    _fill_mass(tables, buffers, g)
    lengths += [float(c.values[c.kind.size]) for c in scene.components.values() if c.values.get(c.kind.size)]
    parts = max(lengths, default=0.0)
    if not size:
        tables.outgrown_from = 1.0 / COINCIDENT if parts else FAR
    tables.resize(size or parts or _extent(scene, Z[:ground]) or _of_start(scene) or 1.0)

    starts = scene.number_starts
    tables.multipliers = _multipliers(tables)
    tape = Tape(frames, scene.spatial, tables.multipliers, starts)
    later: list[Callable[[], None]] = []
    _fill_bodies(tables, buffers, g)
    layout[L.ROTATIONS] = buffers.ints(x for rotation in buffers.rotations for x in rotation)
    layout[L.N_ROTATIONS] = len(buffers.rotations)
    gradient_rows.tabulate(tables, buffers, dofs, tape, later)
    relations.tabulate(tables, buffers, dofs, tape, later)
    found = _searched(tables)
    nonholonomic.tabulate(found, frames, dofs, n + m, buffers, tape, later)
    moving_frames.tabulate({f: scene.frames[name].motion for name, f in frames.items()}, buffers, tape, later)
    # All values are on the tape now, and with them all switches; derivatives have the same ones.
    forces = dict.fromkeys(
        x for b in tables.blocks if b.role == "law" for c in b.components for x in law_expressions(c)
    )
    conditions = [tape.add(x) for x in scene.conditions]
    for joint in scene.sticking:
        for name in joint.held:
            tape.add(input_signal(name))
    tables.values = list(dict.fromkeys(tape.roots))
    tables.switches = switches.find(forces, (x for x in dict.fromkeys(tape.roots) if x not in forces))
    tables.quantities = switches.tabulate(tables.switches, buffers, tape)
    actions = clock_tables.compilable(scene.events, scene.spatial, scene.conditions[len(scene.events.conditions) :])
    clock_tables.declare(scene.events, actions, tape)
    _fill_tape(buffers, tape, later, lambda known: clock_tables.tabulate(scene.events, actions, tape, known, buffers))
    for node, register in tape.angles.items():
        tables.angles.setdefault(node, []).append(layout[L.REGISTERS] + register)
    tables.conditions = layout[L.REGISTERS] + np.array(conditions, np.int64)
    tables.starts = {node: layout[L.REGISTERS] + register for node, register in tape.begun.items()}
    counted = [at for places in tables.angles.values() for at in places]
    layout[L.OF_MULTIPLIERS] = int(tables.of_multipliers)
    layout[L.COUNTED], layout[L.N_COUNTED] = buffers.ints(counted), len(counted)
    tables.inputs = {name: layout[L.REGISTERS] + register for name, register in tape.inputs.items()}

    tables.pattern = np.array(buffers.rows, np.int64), np.array(buffers.columns, np.int64)
    tables.numbers = np.array(buffers.numbers + [0.0] * sizes.TANGENT_SCRATCH)
    tables.rotations = np.array(buffers.rotations, np.int64).reshape(-1, 2)
    tables.layout = np.array(layout, dtype=np.int64)
    tables.frame_table = Z


def _search(tables: Tables, c: Component, rows: Sequence[Expr], derivatives: Callable) -> None:
    """Enter what is searched for peaks of the ``rows`` of a joint by expression, which are evaluated with the
    ``derivatives`` by motions or rates of frames."""
    assert isinstance(c.kind, JointKind)
    given = [(name, x) for name, x in c.values.items() if isinstance(x, Expr) and name != c.kind.driver]
    whole = (*c.kind.velocity_rows, *c.kind.coupled)  # laws that are the row, or the coordinates in it
    laws = [y for name, x in given for y in (abrupt(x) if name in whole else [x])]
    for g in rows:
        for name in frames_in(g):
            tables.row_laws |= dict.fromkeys(derivatives(g, name, tables.scene.spatial))
        tables.row_laws[g] = sum(laws[1:], laws[0]) if laws else None


def _fill_frames(tables: Tables, buffers: Buffers, Z: NDArray[np.float64]) -> tuple[list[tuple[int, ...]], list[float]]:
    """The coordinates that each frame depends on, with space for B and (B v)_q; and the distances of frames on bodies
    from their reference points [m]. Z gets the poses of frames on the ground."""
    scene, layout = tables.scene, buffers.layout
    dofs: list[tuple[int, ...]] = []
    origins: list[tuple[float, ...]] = []
    ground = 0
    for name, f in tables.frames.items():
        frame = scene.frames[name]
        body = scene.components[frame.body]
        pose = body_pose(body, frame)
        own: tuple[int, ...] = ()
        if frame.motion is not None:
            ground += 1
        elif frame.body not in tables.models:
            Z[f, : len(pose)] = pose
            ground += 1
        else:
            origins.append(pose[: 3 if scene.spatial else 2])
            first = tables.coordinates[frame.body]
            try:
                own = tuple(first + i for i in tables.models[frame.body].dofs(pose))
            except ValueError as problem:
                raise ModelError(f"frame `{name}`: {problem}", frame.span) from None
        dofs.append(own)
    layout[L.GROUND_FRAMES] = ground
    entries = 2 * columns_of(scene.spatial).POSE  # rows of B and (B v)_q
    layout[L.FRAMES] = buffers.ints([v for d in dofs for v in (len(d), buffers.floats([0.0] * (entries * len(d))))])
    places = np.array(origins, float).reshape(-1, 3 if scene.spatial else 2)
    return dofs, (np.linalg.norm(places, axis=1) if scene.spatial else np.hypot(*places.T)).tolist()


def _extent(scene: Scene, ground: NDArray[np.float64]) -> float:
    """The size [m] of a mechanism of bodies without frames away from their centres: the distance between the frames on
    the ground (k, 6), else the largest length parameter of a component; 0 if there is none."""
    axes = 3 if scene.spatial else 2
    apart = float(np.linalg.norm(ground[:, :axes] - ground[:1, :axes], axis=1).max(initial=0.0))
    parameters = [(c, p.name) for c in scene.components.values() for p in c.kind.parameters if p.unit == "m"]
    values = [c.values[name] for c, name in parameters]
    return apart or max((abs(x) for x in values if isinstance(x, float)), default=0.0)


def _of_start(scene: Scene) -> float:
    """The largest initial position [m]; 0 if it is rounding beside the radii of gyration of bodies, as the positions of
    bodies that only turn are at the end of a run from which another one begins."""
    far = max((abs(x.value) for x in scene.initial if _is_length(x.target)), default=0.0)
    inertias = [(np.abs(c.values.get("I") or 0.0).max(), c.values.get("m")) for c in scene.with_coordinates()]
    radius = max((float(np.sqrt(I / m)) for I, m in inertias if m), default=0.0)
    return far if far > COINCIDENT * radius else 0.0


def _is_length(root: Expr) -> bool:
    """Whether a position has the unit of a length: angles depend on angles alone."""
    keys = {leaf.value[1] for leaf in leaves(root) if leaf.op == "coordinate"}
    return not is_velocity_level(root) and ("x" in keys or "y" in keys)


def _multipliers(tables: Tables) -> dict[tuple[str, int], int]:
    """(joint, k) -> the entry of its multiplier in a row of vectors: those of holonomic constraints first."""
    found = {}
    for c in (*tables.scene.components.values(), *tables.holding.values()):
        if isinstance(c.kind, JointKind):
            for k in range(c.kind.rows):
                found[c.name, k] = tables.n + tables.rows[c.name] + k
            for k in range(len(c.velocity_constraints)):
                found[c.name, c.kind.rows + k] = tables.n + tables.velocity_rows[c.name] + k
    return found


def _fill_mass(tables: Tables, buffers: Buffers, g: NDArray[np.float64]) -> None:
    """Tabulate the constant part of the mass matrix, diagonal and off-diagonal, and of the force of gravity."""
    layout, diagonal, force, couplings, values = (
        buffers.layout,
        list[float](),
        list[float](),
        list[int](),
        list[float](),
    )
    for own in of_models(tables.models, lambda body: body.mass().tolist()):
        diagonal.extend(own)
    for own in of_models(tables.models, lambda body: body.weight(g).tolist()):
        force.extend(own)
    for name, body in tables.models.items():
        d = tables.coordinates[name]
        for i, j, value in body.couplings():
            couplings += [d + i, d + j, buffers.slots((d + i,), (d + j,))]
            buffers.slots((d + j,), (d + i,))
            values.append(value)
    layout[L.MASS] = buffers.floats(diagonal)
    layout[L.CONSTANT_FORCE] = buffers.floats(force)
    layout[L.COUPLINGS], layout[L.N_COUPLINGS] = buffers.ints(couplings), len(values)
    layout[L.COUPLING_VALUES] = buffers.floats(values)
    layout[L.MASS_KIND] = max((b.module.MASS for b in tables.blocks if b.role == "body" and b.components), default=0)
    layout[L.MASS_ROW], layout[L.TANGENT_ROW] = L.POSITION, L.UNKNOWN
    layout[L.INERTIA_ROW], layout[L.INERTIA_ROW2] = (
        L.UNKNOWN,
        L.UNKNOWN2,
    )
    layout[L.MASS_SLOTS] = buffers.requested
    buffers.rows.extend(range(tables.n))
    buffers.columns.extend(range(tables.n))


def _fill_bodies(tables: Tables, buffers: Buffers, g: NDArray[np.float64]) -> None:
    """Tabulate the record of every body, from its model."""
    names: dict[str, list[str]] = {}
    for name in tables.frames:
        names.setdefault(tables.scene.frames[name].body, []).append(name)
    for k, block in enumerate(tables.blocks):
        if block.role != "body":
            continue
        ints: list[int] = []
        for c in block.components:
            own = names.get(c.name, [])
            d, first = tables.coordinates[c.name], tables.frames[own[0]] if own else 0
            poses = [body_pose(c, tables.scene.frames[name]) for name in own]
            ints += tables.models[c.name].record(buffers, d, first, poses, g)
        header = L.BLOCKS + L.BLOCK * k
        buffers.layout[header] = len(block.components)
        buffers.layout[header + 1] = buffers.ints(ints)
    counters = [(body.counter, tables.coordinates[name]) for name, body in tables.models.items() if body.counter >= 0]
    buffers.layout[L.TURNS], buffers.layout[L.N_TURNS] = (
        buffers.ints(x for c in counters for x in c),
        len(counters),
    )


def _fill_tape(
    buffers: Buffers, tape: Tape, later: list[Callable[[], None]], of_clocks: Callable[[dict], Callable[[], None]]
) -> None:
    """Append the gradients to the values, and what clocks do, then store the program and its tables."""
    layout = buffers.layout
    values, known = len(tape.code), tape.known
    for fill in later:
        fill()
    gradients = len(tape.code)
    write = of_clocks(known)
    layout[L.TAPE] = buffers.ints(v for instruction in tape.code for v in instruction)
    layout[L.TAPE_LENGTH], layout[L.GRADIENT_LENGTH] = values, gradients - values
    layout[L.REGISTERS] = buffers.floats(tape.registers)
    write()
    headers = []
    for table in tape.tables:
        breaks, coefficients = piecewise(table)
        beyond = {"hold": 0, "linear": 1, "periodic": 2, "error": 3}[table.extrapolation]
        headers += [len(breaks), buffers.floats(breaks), beyond]
        buffers.floats(coefficients.ravel())
    layout[L.TABLES] = buffers.ints(headers)
