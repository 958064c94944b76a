"""Signals of the present state as Python functions that read the buffers of the runs.

The coordinates of frames in a signal's expression are replaced by their formulas in the coordinates of the bodies that
are solved for, and the resulting expression becomes the text of a function. The text contains only numbered names: no
name and no number of the model is part of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from mbdsl.bodies.contract import POSITIONS, SPATIAL_POSITIONS, SPATIAL_VELOCITIES, VELOCITIES
from mbdsl.bodies.gyrostat_kernels import ANGLES
from mbdsl.expressions.array_operations import table_value
from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import OPERATIONS, RATE, TIME, Expr, call, const, rebuild, substitute, walk
from mbdsl.initial.shared_loads import shares
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.mechanism.scene import Scene
from mbdsl.numerics.rotation import BASE
from mbdsl.numerics.rotation_arrays import cross_matrix
from mbdsl.simulation.gyrostat_states import Placed
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.part_run import KINEMATIC
from mbdsl.simulation.planar_states import PlanarBody, PlanarStates
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.simulation.turn_counters import TurnCounter
from mbdsl.system import System
from mbdsl.system.body_models import at_rest, body_pose

Vector = list[Expr]
#: the values of signals, without arguments
Values = Callable[[], tuple[float, ...]]
_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_RATES = tuple(RATE.values())
LARGEST = 20_000  #: largest number of nodes of an expression that becomes a function


class _NotHere(Exception):
    """A signal depends on values that are not in the buffers."""


class PresentSignals:
    """Makes functions for the signals of a motion; they are valid until a buffer of a run is replaced.

    Parameters
    ----------
    motion : MechanismRun
        A prepared motion with fixed steps.
    known : AskedSignals
        The signals of its scene.
    inputs : list of float
        The values of all inputs during the last step. The functions read this list.
    point : callable
        The present state as a trajectory of one point, which has the signals that are not in the buffers.
    whole : callable
        All stored states as a trajectory.
    counter : callable
        The counter of an angle that counts turns.
    """

    def __init__(
        self,
        motion: MechanismRun,
        known: AskedSignals,
        inputs: list[float],
        point: Callable[[], Trajectory],
        whole: Callable[[], Trajectory],
        counter: Callable[[Expr], TurnCounter],
    ) -> None:
        self.known, self._counter = known, counter
        self._motion, self._point, self._whole = motion, point, whole
        self._input = {name: k for k, name in enumerate(motion.system.scene.inputs)}
        self._owner = {body: k for k, p in enumerate(motion.parts) for body in p.system.tables.coordinates}
        self._names: dict[str, object] = {"u": inputs, "table": _table}
        for k, p in enumerate(motion.parts):
            run = p.integration
            assert isinstance(run, MethodRun)
            n, vectors = p.system.n, run.vectors
            self._names[f"q{k}"] = vectors[L.POSITION0, :n].data
            self._names[f"v{k}"] = vectors[L.VELOCITY0, :n].data
            self._names[f"l{k}"] = vectors[L.UNKNOWN0].data
            self._names[f"n{k}"] = run.numbers.data
            self._names[f"i{k}"], self._names[f"r{k}"] = run.integers.data, run.reals.data
        self._states: dict[str, tuple[Vector, list[Vector], Vector, Vector]] = {}

    def _root(self, name: str) -> Expr | None:
        """The expression of a signal or an expression of signals; None if a part has none."""
        entry = self.known.entry(name)
        return None if entry is None or self.known.computed_in(entry[0]) else entry[0]

    def function(self, names: tuple[str, ...]) -> Values:
        """The function that returns the present values of signals, in SI units.

        Raises
        ------
        UsageError
            If there is no such signal.
        """
        roots = [TIME if name == "time" else self._root(name) for name in names]
        quick = None if None in roots else self._compiled(roots)  # type: ignore[arg-type]
        if quick is None and len(names) > 1:
            each = [self.function((name,)) for name in names]
            return lambda: tuple(value()[0] for value in each)
        for name in names:
            if name not in self.known:
                raise self.known.unknown(name)
        point = self._point

        if quick is None and any(root is not None and self._counted(root) for root in roots):
            point = self._whole  # angles between axes in space count turns from the start of the run on

        def by_arrays() -> tuple[float, ...]:
            return tuple(float(point()[name][-1]) for name in names)

        if quick is None:
            return by_arrays

        def values() -> tuple[float, ...]:
            try:
                return quick()
            except (ArithmeticError, ValueError):  # as of sqrt(-1), for which arrays give nan
                return by_arrays()

        return values

    def _counted(self, root: Expr) -> bool:
        return self._motion.system.counts_angles and any(node.op == "angle" for node in walk(root))

    def _compiled(self, roots: Sequence[Expr]) -> Values | None:
        """The function that returns the values of expressions; None if the buffers do not determine them."""
        try:
            roots = [self._inlined(root) for root in roots]
        except _NotHere:
            return None
        order = walk(*roots)
        if len(order) > LARGEST:
            return None
        names, lines, place = dict(self._names), [], dict[Expr, str]()
        for number, node in enumerate(order):
            place[node] = f"x{number}"
            lines.append(f" x{number} = {self._text(node, [place[a] for a in node.args], number, names)}")
        result = "".join(f"{place[root]}, " for root in roots)
        exec(compile("\n".join(["def values():", *lines, f" return ({result})"]), "<signals>", "exec"), names)
        return names["values"]  # type: ignore[return-value]

    def count(self, nodes: Sequence[Expr]) -> Values | None:
        """The function that counts the turns of angles up to the present state; None if the buffers do not suffice."""
        return self._compiled(nodes)

    def _inlined(self, root: Expr) -> Expr:
        """An expression over buffers, with counters in place of angles that count turns."""
        new: dict[Expr, Expr] = {}
        for n in walk(root):
            if n.op == "angle":
                rate = self._inlined(n.value)
                args = *(new[a] for a in n.args), rate, self._time()
                new[n] = Expr("turns", args, self._counter(n))
            elif n.op == "integral":
                raise _NotHere  # a quadrature
            elif not n.args:
                found = self._leaf(n)
                new[n] = n if found is None else found
            else:
                new[n] = n if all(new[a] is a for a in n.args) else rebuild(n, [new[a] for a in n.args])
        return new[root]

    def _discrete(self, name: str) -> float:
        """The present value of a discrete variable."""
        events = self._motion.event_set
        assert events is not None
        return events.values[name]

    def _text(self, node: Expr, args: list[str], number: int, names: dict[str, object]) -> str:
        """The text of one operation; its constants are added to the ``names`` of the function."""
        if node.op == "buffer":
            buffer, index = node.value
            return f"{buffer}[{int(index)}]"
        if node.op == "const":
            names[f"c{number}"] = float(node.value)
            return f"c{number}"
        if node.op == "table":
            names[f"t{number}"], order = node.value
            return f"table(t{number}, {int(order)}, {args[0]})"
        if node.op == "held":
            names[f"f{number}"] = partial(self._discrete, node.value)
            return f"f{number}()"
        if node.op == "turns":
            names[f"f{number}"] = node.value
            return f"f{number}({', '.join(args)})"
        if node.op in _INFIX:
            return f"{args[0]} {_INFIX[node.op]} {args[1]}"
        if node.op == "neg":
            return f"-{args[0]}"
        names[f"f{number}"] = OPERATIONS[node.op]
        return f"f{number}({', '.join(args)})"

    def _leaf(self, leaf: Expr) -> Expr | None:
        if leaf.op == "time":
            return self._time()
        if leaf.op == "start":
            return const(self._motion.system.tables.first_angles.get(leaf, 0.0))
        if leaf.op == "input":
            name = str(leaf.value)
            return _buffer("u", self._input[name]) if name in self._input else Expr("held", (), name)
        if leaf.op == "multiplier":
            return self._multiplier(leaf.value)
        if leaf.op == "coordinate":
            frame, key = leaf.value
            return self._coordinate(self._motion.system.scene, frame, key)
        return None

    def _time(self) -> Expr:
        if not self._motion.parts:
            raise _NotHere
        plan = self._motion.plan
        if self._motion.event_set is not None:
            return _buffer("r0", S.STOP)  # the end of the last step
        return plan.start + _buffer("i0", S.STEP) * plan.h

    def _multiplier(self, key: tuple[str, int]) -> Expr:
        if self._motion.own_reactions and not shares(self._motion.system, self._motion.left_out):
            reduced = {k for x in self._motion.whole.reduced for k in x.flat.numbers}
            for k, p in enumerate(self._motion.parts):
                if k not in reduced and p.method != KINEMATIC and key in p.system.tables.multipliers:
                    return _buffer(f"l{k}", p.system.tables.multipliers[key])
        raise _NotHere

    def _coordinate(self, scene: Scene, name: str, key: str, reduced: Scene | None = None) -> Expr:
        """A coordinate of a frame of ``scene``: the model as written, ``reduced``, or a part."""
        if scene.spatial:
            return self._in_space(scene, name, key)
        frame = scene.frames[name]
        if frame.motion is not None:
            moved = frame.motion[tuple(RATE).index(key)] if key in RATE else der(frame.motion[_RATES.index(key)])
            return substitute(moved, self._leaf)
        body = scene.components[frame.body]
        if frame.body in self._owner:
            k = self._owner[frame.body]
            part = self._motion.parts[k].system
            if part.scene is scene:
                return _of_body(k, part, frame.body, body_pose(body, frame), key)
            if name in part.scene.frames:
                return self._coordinate(part.scene, name, key, reduced)
        elif not body.coordinates:
            return const(at_rest(body, frame, key))
        reduced = reduced or self._motion.reduction.scene
        if reduced is not scene and name in reduced.frames:
            return self._coordinate(reduced, name, key, reduced)
        raise _NotHere

    def _in_space(self, scene: Scene, name: str, key: str) -> Expr:
        """A coordinate of a frame in space, in world axes."""
        frame = scene.frames[name]
        body = scene.components[frame.body]
        if frame.motion is not None:
            raise _NotHere
        if not body.coordinates:
            return const(at_rest(body, frame, key))
        if frame.body not in self._states:
            self._states[frame.body] = self._state(frame.body)
        x, R, v, w = self._states[frame.body]
        return _of_frame(body_pose(body, frame), key, x, R, v, w)

    def _state(self, body: str) -> tuple[Vector, list[Vector], Vector, Vector]:
        """The position x, the attitude R by rows, the velocity v, and the angular velocity w in the body's axes."""
        for states in self._motion.whole.reduced:
            for own in states.bodies:
                if own.name == body:
                    if isinstance(own, Placed):
                        return self._on_gyrostat(own)
                    assert isinstance(states, PlanarStates)
                    return self._from_plane(states, own)
        return self._state_of_part(body)

    def _state_of_part(self, body: str) -> tuple[Vector, list[Vector], Vector, Vector]:
        """As ``_state``, of a body of a part."""
        if (k := self._owner.get(body)) is None:
            raise _NotHere
        part = self._motion.parts[k]
        d, model = part.system.tables.coordinates[body], part.system.tables.models[body]
        own_q, own_v = ([_buffer(f"{row}{k}", d + i) for i in range(model.n)] for row in "qv")
        if model.n == 3:
            return own_q, _constant(np.eye(3)), own_v, _constant(np.zeros((1, 3)))[0]
        (at,) = (int(at) for first, at in part.system.tables.rotations if first == d + 3)
        # between steps, the rotation vector in the chart is zero: the attitude is that of the chart
        p = [_buffer(f"n{k}", at + BASE + i) for i in range(4)]
        return own_q[:3], _attitude(*p), own_v[:3], own_v[3:6]

    def _on_gyrostat(self, body: Placed) -> tuple[Vector, list[Vector], Vector, Vector]:
        """As ``_state``, of a body that is part of a gyrostat: R = R_carrier Q(theta) P."""
        x, R, v, w = self._state_of_part(body.on)
        lever = [float(a) for a in body.lever]
        across = _cross(w, lever)
        x, v = ([a[i] + _dot(R[i], d) for i in range(3)] for a, d in ((x, lever), (v, across)))
        if body.rotor < 0:
            return x, R, v, w
        k = self._owner[body.on]
        at = self._motion.parts[k].system.tables.coordinates[body.on] + ANGLES + body.rotor
        theta, rate = _buffer(f"q{k}", at), _buffer(f"v{k}", at)
        c, s = call("cos", theta), call("sin", theta)
        # Q = c (I - n n^T) + s n~ + n n^T, with constant matrices
        along = np.outer(body.n, body.n)
        cosine, sine, fixed = (A @ body.P for A in (np.eye(3) - along, cross_matrix(body.n), along))
        QP = [[c * cosine[i, j] + s * sine[i, j] + float(fixed[i, j]) for j in range(3)] for i in range(3)]
        spin = [w[i] + float(body.n[i]) * rate for i in range(3)]
        columns = [[QP[i][j] for i in range(3)] for j in range(3)]
        return x, [[_dot(row, column) for column in columns] for row in R], v, [_dot(a, spin) for a in columns]

    def _from_plane(self, states: PlanarStates, body: PlanarBody) -> tuple[Vector, list[Vector], Vector, Vector]:
        """As ``_state``, of a body that is solved for in a plane: R = E Rz(phi) A."""
        scene, reduced = states.system.scene, states.flat.reduction.scene
        keys = ("x", "y", "vx", "vy", *(("phi", "w") if body.turns else ()))
        found = {key: self._coordinate(scene, f"{body.name}.c", key, reduced) for key in keys}
        E = states.axes
        x = [E[i, 0] * found["x"] + E[i, 1] * found["y"] + body.height * E[i, 2] for i in range(3)]
        v = [E[i, 0] * found["vx"] + E[i, 1] * found["vy"] for i in range(3)]
        if not body.turns:
            return x, _constant(np.eye(3)), v, _constant(np.zeros((1, 3)))[0]
        c, s, A = call("cos", found["phi"]), call("sin", found["phi"]), body.A
        # E Rz A = E (c P + s Q + k k^T) A, with constant matrices
        P, Q = np.diag([1.0, 1.0, 0.0]), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
        cosine, sine, fixed = E @ P @ A, E @ Q @ A, E @ np.diag([0.0, 0.0, 1.0]) @ A
        R = [[c * cosine[i, j] + s * sine[i, j] + fixed[i, j] for j in range(3)] for i in range(3)]
        return x, R, v, [found["w"] * A[2, i] for i in range(3)]


def _constant(matrix: Array) -> list[Vector]:
    return [[const(float(x)) for x in row] for row in matrix]


def _attitude(a: Expr, b: Expr, c: Expr, d: Expr) -> list[Vector]:
    """The rotation matrix of a unit quaternion, scalar part first, by rows."""
    two = const(2.0)
    ab, ac, ad, bb, bc, bd, cc, cd, dd = a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d
    return [
        [1.0 - two * (cc + dd), two * (bc - ad), two * (bd + ac)],
        [two * (bc + ad), 1.0 - two * (bb + dd), two * (cd - ab)],
        [two * (bd - ac), two * (cd + ab), 1.0 - two * (bb + cc)],
    ]


def _dot(row: Sequence[Expr], vector: Sequence[Expr | float]) -> Expr:
    return row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2]


def _cross(a: Sequence[Expr], b: Sequence[float]) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _of_frame(pose: Sequence[float], key: str, x: Vector, R: list[Vector], v: Vector, w: Vector) -> Expr:
    """A coordinate of a frame at a pose (12) on a body in space, as :meth:`SpatialRigid.frame` has it."""
    k = (SPATIAL_VELOCITIES if key in SPATIAL_VELOCITIES else SPATIAL_POSITIONS).index(key)
    i, s = k % 3, pose[:3]
    if key in SPATIAL_VELOCITIES[:3]:
        return v[i] + _dot(R[i], _cross(w, s))
    if key in SPATIAL_VELOCITIES:
        return _dot(R[i], w)
    found = _dot(R[i], [float(y) for y in pose[k - i : k - i + 3]])
    return x[i] + found if k < 3 else found


def _buffer(name: str, index: int) -> Expr:
    return Expr("buffer", (), (name, int(index)))


def _of_body(k: int, system: System, body: str, pose: tuple[float, float, float], key: str) -> Expr:
    """A coordinate of a frame at a pose on a body of part ``k``."""
    d, model = system.tables.coordinates[body], system.tables.models[body]
    if model.deforms:
        raise _NotHere
    names = VELOCITIES if key in VELOCITIES else POSITIONS
    j, buffer = names.index(key), "v" if key in VELOCITIES else "q"
    own = [_buffer(f"{buffer}{k}", d + i) for i in range(model.n)]
    if j == 2:
        offset = const(pose[2] if buffer == "q" else 0.0)
        return own[2] + offset if model.n == 3 else offset
    if model.n < 3 or (pose[0] == 0.0 and pose[1] == 0.0):
        return own[j]
    phi = _buffer(f"q{k}", d + 2)
    c, s = call("cos", phi), call("sin", phi)
    lever = c * pose[0] - s * pose[1], s * pose[0] + c * pose[1]
    if buffer == "q":
        return own[j] + lever[j]
    return own[0] - lever[1] * own[2] if j == 0 else own[1] + lever[0] * own[2]


def _table(table: object, order: int, u: float) -> float:
    return float(table_value(table, order, u))
