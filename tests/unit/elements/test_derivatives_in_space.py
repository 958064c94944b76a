"""Every derivative of every kind in space, compared with differences of its function.

As ``test_derivatives.py``: kinds are discovered, each pair kind is set between turned frames off the centres of mass of
two bodies, of a body and the ground, and of a body and itself. Displacements and rotations are those of the body axes,
``System.moved``. TOLERANCE, relative to the largest entry: truncation of differences of seven points, H^6/140 = 7e-21
times seventh derivatives of up to 1e10 here, of angles of axes that are nearly parallel, and rounding, 1e-16/H = 1e-13
times values of up to 1e2.
"""

from dataclasses import replace

import numpy as np
import pytest

from mbdsl.elements import find, modules, of_variant
from mbdsl.elements.kind import ForceKind, JointKind, PairKind
from mbdsl.expressions import spatial_coordinates
from mbdsl.expressions.symbolic import TIME, call, coordinate
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.mechanism.scene_parts import SpatialFrame
from mbdsl.mechanism.signals import ComponentFormulas
from mbdsl.numerics import rotation_arrays
from mbdsl.system import build
from mbdsl.system.signals import frame_coordinate, values

H = 1e-3
TOLERANCE = 1e-9
T = 0.7  #: time [s]
#: forces that are linear springs here
LINEAR = ("SpringDamper", "RotationalSpringDamper")
#: of contacts at points; the third power has two derivatives at first touch
TOUCHING = {"e": 0.6, "exponent": 3.0, "mu_s": 1.7}
#: values whose random choice would not fit; limits within the range of the motion
CHOSEN = {
    "CircleContact": {"e": 0.6, "exponent": 1.5},
    "circle_friction": {"internal": False, "r_a": 3.0, **TOUCHING},
    "PointContact": {"radius": 1.5, **TOUCHING},
    "LineContact": {"radius": 1.5, **TOUCHING},
    "BoxContact": TOUCHING,
    "CylinderContact": TOUCHING,
    **{f"Sphere{x}Contact": {"radius": 1.2, **TOUCHING} for x in ("Box", "Cylinder", "Capsule")},
    "Rope": {"length": 0.3, "drum": 0.0},  # over discs: test_rope.py
    "RotationalStop": {"phi_min": -0.4, "phi_max": 0.3, "e": 0.7, "exponent": 1.5},
    "TranslationalStop": {"s_min": -0.4, "s_max": 0.3, "e": 0.5, "exponent": 1.0},
}
#: another choice of frames, whose axes are farther from parallel: angles have moderate derivatives there
SEEDS = {"Cam": 7}
NO_GRAPH = MechanismGraph.__new__(MechanismGraph)
PAIRS = [m.KIND for m in modules(True).values() if isinstance(m.KIND, PairKind)]
PAIRS += [of_variant(k.in_loops, True).KIND for k in PAIRS if k.in_loops]
PAIRS.append(of_variant("circle_friction", True).KIND)
CONSTRAINTS = [k for k in PAIRS if isinstance(k, JointKind) and (k.rows or k.velocity_rows)]


def component(name, kind, values, **ports):
    declared = find(kind, True) if isinstance(kind, str) else kind
    values = (
        {p.name: p.default for p in declared.parameters} | values | CHOSEN.get(declared.variant or declared.name, {})
    )
    values |= declared.derive(values)
    rows = getattr(declared, "velocity_rows", ())
    formulas = ComponentFormulas(declared, name, values.get, lambda port, key: coordinate(ports[port], key))
    constraints = tuple(map(formulas.row, rows))
    relations = tuple(map(formulas.row, getattr(declared, "relations", ())))
    for k, (function, signals) in enumerate(getattr(declared, "functions", ())):
        values[function] = surface([formulas.signal(x) for x in (signals if k else signals[::-1])])
    friction = formulas.signal("friction") if getattr(declared, "friction", "") else None
    if isinstance(declared, ForceKind) and declared.springs is None:
        values |= {law: formulas.signal(law) for law in declared.laws if values.get(law) is None}
    values |= {key: formulas.signal(key) for key in declared.computed}
    signals = tuple(declared.formulas)
    more = {
        "relations": relations,
        "friction": friction,
        "friction_rows": formulas.friction_rows() if friction is not None else (),
    }
    ports = {port: ports[port] for port in declared.ports}
    return Component(name, declared, values, ports, signals, velocity_constraints=constraints, **more)


def surface(x):
    """A function of three coordinates, or of one, with all its second derivatives."""
    if len(x) == 1:
        return call("sin", 0.5 * x[0]) + 0.1 * x[0]
    return call("sin", x[0] + 0.3 * x[1] * x[2]) + 0.7 * x[0] * x[1] * x[1] + 0.4 * x[2] * x[2] * x[0] + 0.9 * x[1]


def law(frames, rng):
    """A nonlinear function of time and of position, axes and velocities of two frames."""
    k = rng.uniform(0.5, 1.5, 6)
    a, b = ({key: coordinate(frame, key) for key in spatial_coordinates.COORDINATES} for frame in frames)
    angle = call("atan2", a["xx"] * b["yz"] + a["zy"], 3.0 + b["xz"] * b["zz"])
    speed = a["vx"] * b["wz"] * b["xy"] + b["vy"] * a["z"] * a["wx"] + b["wy"] * a["vz"]
    return k[0] * angle * b["x"] + k[1] * speed + k[2] * call("sin", a["y"] * TIME) * call("tanh", b["wx"] + a["wy"])


def place(frames, rng):
    """A nonlinear function of position, axes and angle of two frames."""
    k = rng.uniform(0.5, 1.5, 4)
    a, b = ({key: coordinate(frame, key) for key in spatial_coordinates.COORDINATES} for frame in frames)
    angle = spatial_coordinates.named(frames[0], "phi")
    axes = call("atan2", a["xx"] * b["yz"] + a["zy"], 3.0 + b["xz"] * b["zz"])
    return k[0] * axes * b["x"] + k[1] * a["y"] * b["z"] * a["x"] + k[2] * call("sin", angle) * b["xy"] + k[3] * angle


def parameters(kind, frames, rng):
    """Random values of the kind's parameters; laws of forces instead of linear springs where there is a choice."""
    given = {}
    for p in kind.parameters:
        if p.law and kind.name not in LINEAR:
            of_state = isinstance(kind, ForceKind) or kind.velocity_rows
            of_time = law(frames, rng) if of_state else 0.3 + TIME * TIME
            given[p.name] = place(frames, rng) if p.name in kind.coupled else of_time
        elif p.unit and not p.law:
            given[p.name] = float(rng.uniform(0.5, 1.5)) if p.shape == () else tuple(rng.uniform(0.5, 1.5, p.shape))
    return given


def system(kind, count=4, **more):
    rng = np.random.default_rng(SEEDS.get(kind.name, sum(map(ord, kind.name))))
    frames, components = [], [component("ground", "Ground", {})]
    for body in ("ground", "a", "b"):
        for f in "pq":
            axes = rotation_arrays.matrices(rng.uniform(-1.5, 1.5, (1, 3)))[0].T
            x, y, z = rng.uniform(-1, 1, 3)
            frames.append(SpatialFrame(f"{body}.{f}", body, x, y, z=z, axes=tuple(axes.ravel())))
        if body != "ground":
            A = rng.uniform(-1, 1, (3, 3))
            J = A @ A.T + np.eye(3)
            values = {"m": rng.uniform(1, 2), "I": tuple(map(tuple, J.tolist())), "com": tuple(rng.uniform(-1, 1, 3))}
            components.append(component(body, "Body", values))
    ends = (("ground.p", "a.p"), ("a.q", "b.p"), ("b.q", "ground.q"), ("a.p", "a.q"))
    for k, (a, b) in enumerate(ends[:count]):
        components.append(component(f"c{k}", kind, parameters(kind, (a, b), rng) | more, frame_a=a, frame_b=b))
    scene = Scene("Test", {c.name: c for c in components}, {f.name: f for f in frames}, spatial=True)
    return build(scene, NO_GRAPH)


def states(s, rng):
    q, v = rng.uniform(-1.5, 1.5, s.n), rng.uniform(-1.5, 1.5, s.n)
    return q, v, rng.uniform(-1.5, 1.5, s.m + s.p)


def difference(f, n):
    """The derivative of f(d) at d = 0, with d (n,)."""
    columns = []
    for i in range(n):
        e = np.eye(n)[i]
        columns.append(slope(lambda x, e=e: f(x * e)))
    return np.array(columns).T


def slope(f):
    """The derivative of f(x) at x = 0."""
    first, second, third = (f(k * H) - f(-k * H) for k in (1, 2, 3))
    return (45 * first - 9 * second + third) / (60 * H)


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0, atol=TOLERANCE * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("kind", PAIRS, ids=lambda kind: kind.variant or kind.name)
def test_tangents_are_derivatives(kind):
    s = system(kind)
    for seed in range(2):
        compare(s, *states(s, np.random.default_rng(seed)))


@pytest.mark.parametrize(("name", "axes"), [("Bushing", "world"), ("Torque", "frame_b")])
def test_tangents_in_other_axes_are_derivatives(name, axes):
    s = system(find(name, True), axes=axes)
    compare(s, *states(s, np.random.default_rng(0)))


#: kinds whose coordinates are those of points, of axes, and of angles; velocities; friction; a weld
ON_ROTORS = ("Spherical", "Revolute", "RotationalDriver", "RotationalVelocityDriver", "KnifeEdge", "Bushing")


def with_rotors(s):
    """The system with the body a as a gyrostat with two rotors; its frame q is on the second one."""
    rng = np.random.default_rng(11)
    a = s.scene.components["a"]
    axles = [tuple(n / np.linalg.norm(n)) for n in rng.normal(size=(2, 3))]
    J = np.array(a.values["I"]) + sum(C * np.outer(n, n) for n, C in zip(axles, (0.7, 0.4), strict=True))
    rotors = tuple(zip(axles, (0.7, 0.4), strict=True))
    values = {"m": a.values["m"], "com": a.values["com"], "J": tuple(J.ravel()), "rotors": rotors}
    components = dict(s.scene.components) | {"a": replace(a, kind=of_variant("gyrostat", True).KIND, values=values)}
    frames = dict(s.scene.frames) | {"a.q": replace(s.scene.frames["a.q"], rotor=2)}
    return build(replace(s.scene, components=components, frames=frames), NO_GRAPH)


@pytest.mark.parametrize("name", ON_ROTORS)
def test_tangents_on_rotors_are_derivatives(name):
    s = with_rotors(system(find(name, True)))
    q, v, lam = states(s, np.random.default_rng(0))
    compare(s, q, v, lam)


@pytest.mark.parametrize("name", ["Spherical", "RotationalVelocityDriver"])
def test_constraint_tangents_on_rotors_in_a_step(name):
    s = with_rotors(system(find(name, True)))
    in_a_step(s, *states(s, np.random.default_rng(0))[:2])


def compare(s, q, v, lam):
    def at(d):
        return s.moved(q, d)

    close(s.stiffness(T, q, v, lam), difference(lambda d: -s.evaluate(T, at(d), v, lam)[0], s.n))
    close(s.damping(T, q, v, lam), difference(lambda d: -s.evaluate(T, q, v + d, lam)[0], s.n))
    if s.m + s.p:
        force = difference(lambda d: s.evaluate(T, q, v, lam + d)[0], s.m + s.p)
        close(s.Q_lam(T, q, v, lam) - s.velocity_jacobian(T, q, v).T, force)
    if s.m:
        close(s.Phi_q(T, q), difference(lambda d: s.Phi(T, at(d)), s.n))
        close(s.Phi_v_q(T, q, v), difference(lambda d: s.evaluate(T, at(d), v)[2], s.n))
        close(s.evaluate(T, q, v)[2] - s.Phi_t(T, q), s.Phi_q(T, q) @ v)
        close(s.constraint_force(T, q, lam[: s.m]), s.Phi_q(T, q).T @ lam[: s.m])
    if s.p:
        close(s.Gam_v(T, q, v), difference(lambda d: s.Gam(T, q, v + d), s.n))
        close(s.Gam_q(T, q, v), difference(lambda d: s.Gam(T, at(d), v), s.n))
        forces = s.evaluate(T, q, v, lam)[0] - s.evaluate(T, q, v, 0.0 * lam)[0]
        close(-forces, s.velocity_jacobian(T, q, v).T @ lam)


@pytest.mark.parametrize("kind", CONSTRAINTS, ids=lambda kind: kind.variant or kind.name)
def test_constraint_tangents_in_a_step(kind):
    """In a step of a method with accelerations psi'', velocities are functions of the rotation vector psi, with
    Omega = T(psi) psi', which is Omega_0 + Omega_0 x psi/2 for small psi."""
    s = system(kind)
    in_a_step(s, *states(s, np.random.default_rng(0))[:2])


def in_a_step(s, q, v):
    def rates(d):
        found = v.copy()
        for k, _ in s.tables.rotations:
            found[k : k + 3] += np.cross(v[k : k + 3], d[k : k + 3]) / 2
        return found

    s.evaluate(T, q, v)
    s._work.layout[L.CHART] = 2
    if s.m:
        close(s.Phi_v_q(T, q, v), difference(lambda d: s.evaluate(T, s.moved(q, d), rates(d))[2], s.n))
    if s.p:
        close(s.Gam_q(T, q, v), difference(lambda d: s.Gam(T, s.moved(q, d), rates(d)), s.n))


@pytest.mark.parametrize("kind", CONSTRAINTS, ids=lambda kind: kind.variant or kind.name)
def test_acceleration_level_is_the_derivative_along_a_motion(kind):
    """Phi of a motion with constant velocities has the second derivative -gamma_c, and Gam the first one."""
    s = system(kind)
    q, v, _ = states(s, np.random.default_rng(3))

    def rates(t):  # constant Omega: psi' = Omega along psi
        at = s.moved(q, t * v)
        return np.concatenate([s.evaluate(T + t, at, v)[2], s.Gam(T + t, at, v)])

    close(-s.gamma_c(T, q, v), slope(rates))


def test_a_turned_scene_has_turned_forces():
    """Gravity and constraints of a scene turned as a whole: accelerations in body axes are the same."""
    from mbdsl.system.accelerations import accelerations

    scene = system(find("Spherical", True), 3).scene  # no joint of a body with itself, which leaves no motion
    dry = {name: replace(c, friction=None, friction_rows=()) for name, c in scene.components.items()}
    s = build(replace(scene, components=dry), NO_GRAPH)
    turn = rotation_arrays.matrices(np.array([[0.3, -0.8, 0.5]]))[0]
    scene = s.scene
    frames = dict(scene.frames)
    for name, frame in scene.frames.items():
        if frame.body == "ground":
            axes = (turn @ np.array(frame.axes).reshape(3, 3).T).T
            x, y, z = turn @ frame.pose[:3]
            frames[name] = replace(frame, x=x, y=y, z=z, axes=tuple(axes.ravel()))
    ground = scene.components["ground"]
    ground = replace(ground, values=dict(ground.values) | {"n": tuple(turn @ ground.values["n"])})
    turned = build(replace(scene, frames=frames, components=dict(scene.components) | {"ground": ground}), NO_GRAPH)
    q, v, _ = states(s, np.random.default_rng(4))
    p, w = q.copy(), v.copy()
    for d in range(0, s.n, 6):
        p[d : d + 3], w[d : d + 3] = turn @ q[d : d + 3], turn @ v[d : d + 3]
        attitude = turn @ rotation_arrays.matrices(q[None, d + 3 : d + 6])[0]
        p[d + 3 : d + 6] = rotation_arrays.of_matrix(attitude)
    a, lam = accelerations(s, 0.0, q, v)
    b, mu = accelerations(turned, 0.0, p, w)
    for d in range(0, s.n, 6):
        close(b[d : d + 3], turn @ a[d : d + 3])
        close(b[d + 3 : d + 6], a[d + 3 : d + 6])
    close(np.linalg.norm(mu.reshape(-1, 3), axis=1), np.linalg.norm(lam.reshape(-1, 3), axis=1))


def assembled(s, q, v):
    """A state near q, v that satisfies the constraints."""
    for _ in range(60 if s.m else 0):
        step = np.linalg.lstsq(s.Phi_q(T, q), s.Phi(T, q), rcond=None)[0]
        q = s.moved(q, -step * min(1.0, 0.5 / max(np.abs(step).max(), 1e-300)))
    J = s.velocity_jacobian(T, q, v)
    violated = np.concatenate([s.evaluate(T, q, v)[2], s.Gam(T, q, v)])
    v = v - np.linalg.lstsq(J, violated, rcond=None)[0]
    assert np.abs(s.Phi(T, q)).max(initial=0.0) < 1e-13
    return q, v


#: without drivers with a law of velocities here, which acts on the bodies whose velocities it contains
WITH_PORTS = [k for k in PAIRS if k.ports and not (isinstance(k, JointKind) and k.velocity_rows and k.law_parameters)]


IN_OTHER_AXES = [
    pytest.param(find("Bushing", True), {"axes": "world"}, id="Bushing-world"),
    pytest.param(find("Torque", True), {"axes": "frame_b"}, id="Torque-frame_b"),
]


@pytest.mark.parametrize(
    ("kind", "given"),
    [*(pytest.param(kind, {}, id=kind.variant or kind.name) for kind in WITH_PORTS), *IN_OTHER_AXES],
)
def test_wrenches_on_ports_are_the_forces_of_the_kernels(kind, given):
    """For random velocities dv, the power of the wrenches on both ports is that of the generalised forces: those on
    both bodies are right, and opposite. The signal ``power`` is their power at the velocities of the state."""
    s, empty = system(kind, 2, **given), system(kind, 0)
    rng = np.random.default_rng(0)
    q, v, lam = states(s, rng)
    q, v = assembled(s, q, v) if s.m + s.p else (q, v)
    dv = rng.uniform(-1, 1, (6, s.n))
    forces = s.evaluate(T, q, v, lam)[0] - empty.evaluate(T, q, v)[0]
    keys, found, power, said = ("vx", "vy", "vz", "wx", "wy", "wz"), np.zeros(len(dv)), 0.0, 0.0
    state = np.array([T]), q[None], v[None], lam[None]
    for c in (c for c in s.scene.components.values() if c.ports):
        for port, frame in c.ports.items():
            wrench = np.ravel(values(s, [x for part in s.scene.on_port(c, port) for x in part], *state))
            rates = [frame_coordinate(s, frame, key, np.repeat(q[None], len(dv), 0), dv) for key in keys]
            found += wrench @ np.array(rates)
            power += wrench @ [frame_coordinate(s, frame, key, *state[1:3])[0] for key in keys]
        said += values(s, [s.scene.signal_of(c, "power")], *state)[0][0] if "power" in c.signals else 0.0
    tolerance = 1e-11 * max(1.0, np.abs(forces).max())
    assert found == pytest.approx(dv @ forces, abs=tolerance)
    assert said == pytest.approx(power, abs=tolerance)
