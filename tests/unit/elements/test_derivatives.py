"""Every derivative of every kind, compared with differences of its function.

Kinds are discovered, never listed: a new element file is tested automatically. Each pair kind is set between frames of
every combination of bodies (two of each body kind, off their centres of mass and turned; flexible ones as ``VARIANTS``
says; the ground; one body with itself) in a scene that also has every other kind, between two frames of the ground,
where these have no effect. All these scenes have one structure, so that the code is compiled once.

Differences are five-point with step H: their truncation error is H^4/30 f^(5), with f^(5) up to 5!/l^5 = 4e3 at the
smallest distance l = 0.5 m allowed here and magnitudes s, lam of a few units, that is 3e-14 * 4e3 * 10 = 1e-9; rounding
adds eps/H = 2e-13 times values of up to 1e2. Hence TOLERANCE, relative to the largest entry; a wrong term is off by
1e-2 or more.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import mbdsl
from mbdsl import Builder
from mbdsl.elements import friction, modules
from mbdsl.elements.declaration import REQUIRED
from mbdsl.elements.kind import BodyKind, ForceKind, JointKind, PairKind
from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import COORDINATES, TIME, Expr, call, coordinate
from mbdsl.kernels import buffer_layout
from mbdsl.kernels.columns import PLANE
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.system import build
from mbdsl.system.signals import begin, frame_coordinate, gradients, values
from mbdsl.system.system import System
from mbdsl.system.tables import gravity

H = 1e-3
TOLERANCE = 1e-8
STATES = 3
#: how far bodies are deformed, in their own coordinates: their mass matrices are positive definite up to there
BENT = 0.05
NO_GRAPH = MechanismGraph.__new__(MechanismGraph)

KINDS = {name: m.KIND for name, m in modules().items()}
PAIRS = [k for k in KINDS.values() if isinstance(k, PairKind) and (k.rows or k.name == "FreeMotion")]
BODIES = [k for k in KINDS.values() if isinstance(k, BodyKind) and k.coordinates]
#: bodies of these kinds, one a variant: parameters that are chosen rather than drawn. The bodies are soft, so that none
#: of their stiffnesses is much larger than the other terms, which would hide errors.
VARIANTS = {
    "FlexibleBeam": (
        dict(formulation='"floating"', elements=2, length=1.3, E=1.5, reference='"pinned-pinned"', alpha=0.3, beta=0.2),
        dict(
            formulation='"floating"', modes=4, elements=4, length=1.1, E=0.5, basis='"craig-bampton"',
            reference='"clamped-free"', zeta=0.1,
        ),
    ),
}  # fmt: skip
#: their parameters that are drawn
DRAWN = {"FlexibleBeam": ("mass", "S", "I", "rotary")}
#: parameters of friction, given in one variant only
FRICTION = {p.name for speed in "vw" for p in friction.parameters(speed, "m/s", 1.0)}


#: of contacts at points; the third power has two derivatives at first touch
TOUCHING = {"e": 0.6, "exponent": 3.0, "mu": 0.5, "mu_s": 0.8, "v_s": 1.1, "v_st": 0.9}
#: parameters that are chosen rather than drawn, since not every value is valid; and a second variant of their kinds
CHOSEN = {
    "BeltDrive": {"r_a": 0.6, "r_b": 1.3},
    "CircleContact": {"r_a": 3.0, "r_b": 0.9, "e": 0.6, "exponent": 1.5},
    "GearPair": {"r_a": 0.6, "r_b": 1.3},
    "PlanetaryGear": {"ratio": 1.7},
    "PointContact": {"radius": 1.5, **TOUCHING},
    "LineContact": {"radius": 1.5, **TOUCHING},
    "BoxContact": TOUCHING,
    "ProfileContact": {"points": ((-3.0, 0.0), (3.0, 0.0)), "arcs": (3.0, 3.0), "radius": 0.4, **TOUCHING},
    "Rope": {"length": 0.4, "turns": 1.0, **dict.fromkeys(("radius", "mu", "drum"))},
    "RotationalStop": {"phi_min": -0.4, "phi_max": 0.3, "e": 0.7, "exponent": 2.0},
    "TranslationalStop": {"s_min": -0.4, "s_max": 0.3, "e": 0.5, "exponent": 1.5},
}
#: parameters of ropes over discs, which test_rope.py draws
ROPES = {"Rope": ("radius", "mu", "v_s", "drum")}
TURNED = {
    "Bushing": {"axes": "world"},
    "CircleContact": {"internal": True},
    "GearPair": {"internal": True},
    "BeltDrive": {"crossed": True},
}


def variants(kind):
    """The variants of a kind: with linear springs or laws, with or without friction; one variant if there is no
    choice."""
    if kind.name in TURNED:
        return ("", "turned")
    optional = [p.name for p in kind.parameters if p.law and p.default is None]
    if isinstance(kind, JointKind) and kind.friction:
        return ("",) if kind.unilateral else ("", "friction")  # see test_contact_friction.py
    return ("linear", "law") if optional else ("",)


SIDES = (("p", -1.0), ("q", 1.0))
CASES = [pytest.param(k, v, id=f"{k.name}-{v}" if v else k.name) for k in PAIRS for v in variants(k)]


# -- scenes of random numbers ----------------------------------------------------------------------------------


def number(p, rng):
    """A random value for a declared parameter."""
    if p.choices:
        return str(rng.choice(p.choices))
    if None in p.shape:
        return ()  # of ``CHOSEN``
    drawn = rng.uniform(0.4, 1.6, p.shape) if p.positive or p.minimum is not None else rng.uniform(-1.5, 1.5, p.shape)
    return float(drawn) if p.shape == () else tuple(float(x) for x in drawn)


def law(frames, rng) -> Expr:
    """A nonlinear function of time and of position and velocity of several frames, with an `if` in it."""
    k = rng.uniform(0.5, 1.5, 8)
    a, b, c = ({key: coordinate(frame, key) for key in COORDINATES} for frame in frames)
    distance = call("hypot", a["x"] - c["x"], a["y"] - c["y"])
    branch = call("select", call("lt", a["x"], b["x"]), a["vx"] * c["y"], k[7] * b["y"] * b["y"])
    return (
        k[0] * distance * call("sin", b["phi"] - k[1] * a["phi"])
        + k[2] * c["vx"] * a["w"]
        + k[3] * call("exp", 0.3 * b["x"]) * TIME
        + k[4] * call("tanh", b["vy"]) * c["vy"]
        + k[5] * call("atan2", a["y"], 3.0 + c["phi"] * c["phi"]) * b["w"]
        + k[6] * branch
    )


def place(frames, rng) -> Expr:
    """A nonlinear function of the positions of several frames."""
    k = rng.uniform(0.5, 1.5, 6)
    a, b, c = ({key: coordinate(frame, key) for key in COORDINATES} for frame in frames)
    return (
        k[0] * a["x"] * call("sin", b["phi"] - k[1] * a["phi"])
        + k[2] * c["x"] * b["y"] * a["y"]
        + k[3] * call("cos", c["phi"]) * b["x"]
        + k[4] * call("atan2", a["y"], 3.0 + b["x"] * b["x"])
        + k[5] * a["phi"] * b["phi"]
    )


def motion(rng) -> Expr:
    """A nonlinear function of time."""
    k = rng.uniform(0.5, 1.5, 4)
    return k[0] + k[1] * call("sin", k[2] * TIME) + k[3] * TIME * TIME * call("exp", -TIME)


def parameters(kind, variant, frames, rng):
    given = {}
    for p in kind.parameters:
        if variant == "law" and p.name in ("k", "c"):
            continue  # the law replaces them
        if p.law:
            if p.default is None and variant != "law":
                continue
            driver = isinstance(kind, JointKind) and p.name == kind.driver
            if p.name in kind.coupled:
                given[p.name] = place(frames, rng)
                continue
            if isinstance(kind, JointKind) and kind.coupling is not None:
                k, x = rng.uniform(0.5, 1.5, 3), kind.coupling[1]
                given[p.name] = f"({k[0]} + {k[1]}*sin({x} + {k[2]}) + 0.3*{x})*(1 {p.unit})"
            else:
                given[p.name] = motion(rng) if driver else law(frames, rng)
        elif p.unit and p.name not in FRICTION:
            given[p.name] = number(p, rng)
        elif p.unit and variant == "friction":
            given[p.name] = float({"mu": 0.5, "mu_s": 0.8}.get(p.name, rng.uniform(0.6, 1.6)))
    return given | CHOSEN.get(kind.name, {}) | (TURNED[kind.name] if variant == "turned" else {})


def add_body(builder, kind, name, rng, chosen=None):
    """A body with two frames off its centre of mass; their names. ``chosen``: a variant of a flexible one."""
    names = DRAWN.get(kind.name, [p.name for p in kind.parameters if p.unit and kind.name != "Ground"])
    given = {p.name: number(p, rng) for p in kind.parameters if p.name in names} | (chosen or {})
    if kind.parameter("frames") is not None:
        place = (lambda: rng.uniform(0.3, 0.5) * chosen["length"]) if chosen else lambda: rng.uniform(0.4, 1.0)
        frames = {f: (side * place(), side * rng.uniform(0.4, 1.0), side * rng.uniform(0.4, 1.0)) for f, side in SIDES}
        given["frames"] = {f: (x, 0.0 if chosen else y, phi) for f, (x, y, phi) in frames.items()}
    builder.add(kind.name, name, **given)
    return [f"{name}.p", f"{name}.q"] if "frames" in given else [f"{name}.c", f"{name}.c"]


def count(kind) -> int:
    """How many bodies of a kind a scene has."""
    return len(VARIANTS.get(kind.name, (None, None)))


def add_pair(builder, kind, variant, name, a, b, third, rng):
    def written(frame):  # a body that is a frame is named without its centre
        return frame[:-2] if frame.endswith(".c") and frame not in centres else frame

    centres = {f"{kind.name}{i}.c" for kind in BODIES if not kind.is_frame for i in range(1, count(kind) + 1)}
    frames = (a, b, third)
    ends = () if kind.coupled else (written(a), written(b))
    later = kind.coupled or (kind.name, variant) == ("Bushing", "turned")
    rng = np.random.default_rng(len(name)) if later else rng  # the states of others are as without them
    builder.add(kind.name, name, *ends, **parameters(kind, variant, frames, rng))


@cache
def scene(tested: str, variant: str, centred: bool = False):
    """The scene for one kind, and the names of its components. ``centred``: between the centres of two bodies only."""
    rng = np.random.default_rng(sum(map(ord, tested + variant)))
    builder = Builder(f"Test{tested}")
    frames = {"ground": add_body(builder, KINDS["Ground"], "ground", rng)}
    for kind in BODIES:
        for i, chosen in enumerate(VARIANTS.get(kind.name, (None, None)), 1):
            frames[f"{kind.name}{i}"] = add_body(builder, kind, f"{kind.name}{i}", rng, chosen)
    for kind in PAIRS:
        for way in variants(kind):  # numbers of their own: another kind does not change those of the tested one
            own = np.random.default_rng(sum(map(ord, kind.name + way)))
            add_pair(builder, kind, way, f"idle{kind.name}{way}", *frames["ground"], "ground.p", own)
    names = []
    if centred:
        rotating = [k.name for k in BODIES if len(k.coordinates) == 3 and k.name not in VARIANTS]
        ends = [(f"{rotating[0]}1.c", f"{rotating[-1]}2.c")]
    else:
        # every pair of places, a place being two bodies of a rigid kind, or a flexible body, which is then joined to
        # itself
        rigid = [kind for kind in BODIES if kind.name not in VARIANTS]
        places = [("ground", "ground"), *((f"{kind.name}1", f"{kind.name}2") for kind in rigid)]
        places += [(f"{name}{i + 1}",) * 2 for name in VARIANTS for i in range(len(VARIANTS[name]))]
        ends = [(frames[a][0], frames[b][1]) for a, _ in places for _, b in places if not a == b == "ground"]
        ends += [tuple(frames[f"{kind.name}1"]) for kind in rigid if len(kind.coordinates) == 3]  # to itself
    for k, (a, b) in enumerate(ends):
        third = list(frames.values())[1 + k % (len(frames) - 1)][0]
        names.append(f"c{k}")
        add_pair(builder, KINDS[tested], variant, names[-1], a, b, third, rng)
    return builder.scene(), tuple(names)


@cache
def system(tested: str, variant: str, centred: bool = False) -> System:
    # The graph does not affect the numbers; it would refuse joints that join the ground to itself.
    found, rng = build(scene(tested, variant, centred)[0], NO_GRAPH), np.random.default_rng(3)
    begin(found, 0.0, rng.uniform(-3, 3, found.n), np.zeros(found.n))
    return found


def flexible(s: System):
    """Names, coordinates and models of bodies that deform."""
    for name, d in s.tables.coordinates.items():
        body = s.tables.models[name]
        if s.scene.components[name].kind.name in VARIANTS:
            yield name, slice(d, d + body.n), body


def mass_matrix(s: System, q):
    """M as the bodies' models say."""
    M = np.zeros((s.n, s.n))
    for name, d in s.tables.coordinates.items():
        body = s.tables.models[name]
        at = slice(d, d + body.n)
        M[at, at] = body.M(q[at])
    return M


def switches(x: Expr) -> bool:
    """Whether an expression contains an ``if``."""
    return x.op == "select" or any(map(switches, x.args))


def states(s: System, names):
    """Random (t, q, v, lam) with no two connected frames closer than half a metre.

    If they have laws with an ``if``, which switch at equal x, their x differ by more than changes of coordinates of up
    to 2 H move them.
    """
    rng = np.random.default_rng(7)
    rows = sum(c.kind.rows for c in s.scene.components.values() if c.kind.coupled)  # they do not change the states
    found = []
    tested = [s.scene.components[name] for name in names]
    ends = [tuple(c.ports.values()) for c in tested if c.ports]
    apart = 20 * H if any(isinstance(x, Expr) and switches(x) for x in tested[0].values.values()) else 0.0
    while len(found) < STATES:
        q = rng.uniform(-3, 3, s.n)
        for name, at, body in flexible(s):
            q[at] = body.placed(q[at][:3])[0] + BENT * rng.uniform(-1, 1, body.n)
            assert np.linalg.eigvalsh(body.M(q[at])).min() > 0.0, name
        v, drawn = rng.normal(size=(2, s.n)), rng.normal(size=s.m + s.p - rows)
        lam = np.resize(drawn, s.m + s.p)
        lam += np.copysign(4.0 * H, lam)  # friction depends on |lam|
        x, y = ({f: frame_coordinate(s, f, k, q[None], v[:1])[0] for e in ends for f in e} for k in "xy")
        if all(np.hypot(x[a] - x[b], y[a] - y[b]) > 0.5 and abs(x[a] - x[b]) >= apart for a, b in ends):
            found.append((rng.uniform(0.1, 2.0), q, v[0], lam))
    return found


def first_row(s: System, name: str) -> int:
    """Where the gradient table holds a component."""
    row = 0
    for block in s.tables.blocks:
        if block.role not in ("body", "gamma"):
            for c in block.components:
                if c.name == name:
                    return row
                row += block.rows
    raise KeyError(name)


# -- differences -----------------------------------------------------------------------------------------------


def slope(f, h=H):
    """df/dx at 0 of a function of a scalar."""
    return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)


def jacobian(f, x):
    unit = np.eye(len(x))
    return np.array([slope(lambda d, e=e: f(x + d * e)) for e in unit]).T


def matrix(value):
    """A quantity of a System, which is sparse if it is large, as an array."""
    return value.toarray() if hasattr(value, "toarray") else np.asarray(value)


def agree(exact, differences, what):
    exact = matrix(exact)
    size = max(1.0, np.abs(differences).max(initial=0.0))
    error = np.abs(exact - differences)
    assert error.max(initial=0.0) <= TOLERANCE * size, (
        f"{what}: {error.max():.2e} at {np.unravel_index(error.argmax(), error.shape)}"
    )


def check(s, t, q, v, lam):
    """All derivatives of a system at one state."""
    dense, n, m = matrix(s.Phi_q(t, q)), s.n, s.m
    agree(dense, jacobian(lambda x: s.Phi(t, x), q), "Phi_q")
    agree(s.Phi_t(t, q), slope(lambda d: s.Phi(t + d, q)), "Phi_t")
    agree(s.evaluate(t, q, v)[2], dense @ v + s.Phi_t(t, q), "Phi_q v + Phi_t")
    agree(s.Phi_v_q(t, q, v), jacobian(lambda x: s.evaluate(t, x, v)[2], q), "(Phi_q v)_q")
    Gam_v, Gam_q = matrix(s.Gam_v(t, q, v)), matrix(s.Gam_q(t, q, v))
    agree(Gam_v, jacobian(lambda x: s.Gam(t, q, x), v), "Gam_v")
    agree(Gam_q, jacobian(lambda x: s.Gam(t, x, v), q), "Gam_q")
    K, D = matrix(s.stiffness(t, q, v, lam)), matrix(s.damping(t, q, v, lam))
    agree(K, -jacobian(lambda x: s.evaluate(t, x, v, lam)[0], q), "-f_q")
    agree(D, -jacobian(lambda x: s.evaluate(t, q, x, lam)[0], v), "-f_v")
    J = matrix(s.velocity_jacobian(t, q, v))
    agree(J, np.vstack([dense, Gam_v]), "[Phi_q; Gam_v]")
    M = matrix(s.M(t, q))
    agree(M, mass_matrix(s, q), "M")
    inert = np.abs(M).max(axis=1) > 0.0  # a point mass that a joint turns has no moment of inertia
    agree((M @ s.solve_mass(t, q, v))[inert], v[inert], "M M^-1")
    acceleration = np.sin(1.0 + np.arange(n))
    of_mass = jacobian(lambda x: mass_matrix(s, x) @ acceleration, q)
    agree(matrix(s.stiffness(t, q, v, lam, a=acceleration)) - K, of_mass, "(M a)_q")
    force = s.evaluate(t, q, v, lam)[0]
    agree(matrix(s.Q_lam(t, q, v, lam)) - J.T, jacobian(lambda x: s.evaluate(t, q, v, x)[0], lam), "f_lam")
    agree(s.constraint_force(t, q, lam[:m]), dense.T @ lam[:m], "constraint_force")
    a = np.cos(np.arange(n))  # some acceleration

    def constraints(d):
        x = t + d, q + d * v + d * d / 2 * a, v + d * a
        return np.concatenate([s.evaluate(*x)[2], s.Gam(*x)])

    agree(J @ a - s.gamma_c(t, q, v), slope(constraints), "gamma_c")
    both = matrix(s.tangent(t, q, v, lam, cM=1.0, cK=0.5, cD=0.25, cL=0.75, cP=2.0, cN=0.125, cV=3.0, cW=0.375))
    agree(both[:n, n:], J.T - 0.75 * matrix(s.Q_lam(t, q, v, lam)), "the right block of the tangent")
    agree(both[:n, :n], M + 0.5 * K + 0.25 * D, "the sum of M, K and D")
    with_a = s.tangent(t, q, v, lam, cM=1.0, cK=0.5, cD=0.25, a=acceleration)
    agree(matrix(with_a)[:n, :n], M + 0.5 * (K + of_mass) + 0.25 * D, "the sum of M, K, (M a)_q and D")
    agree(both[n : n + m, :n], 2.0 * dense + 0.125 * matrix(s.Phi_v_q(t, q, v)), "the sum of Phi_q and N")
    agree(both[n + m :, :n], 3.0 * Gam_v + 0.375 * Gam_q, "the sum of Gam_v and Gam_q")
    if not s.of_multipliers:
        agree(force, s.Q(t, q, v) - J.T @ lam, "Q - Phi_q^T lam - Gam_v^T nu")


# -- the tests -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "variant"), CASES)
def test_derivatives_of_the_system(kind, variant):
    s = system(kind.name, variant)
    for state in states(s, scene(kind.name, variant)[1]):
        check(s, *state)


def wrong(right: System, method: str) -> System:
    """A system in which the largest entry returned by ``method`` is wrong by a millionth."""

    def off(*args, **more):
        value = matrix(getattr(right, method)(*args, **more))
        value.flat[np.abs(value).argmax()] *= 1 + 1e-6
        return value

    found = replace(right)
    setattr(found, method, off)
    return found


@pytest.mark.parametrize(
    "method",
    [
        "M",
        "Phi_q",
        "stiffness",
        "damping",
        "Phi_v_q",
        "Phi_t",
        "gamma_c",
        "constraint_force",
        "Gam_v",
        "Gam_q",
        "Q_lam",
    ],
)
def test_the_check_sees_a_wrong_derivative(method):
    # an error would drown among the much larger numbers of idle components: a kind is used that has such terms itself
    kinds_ = {"damping": ("SpringDamper", "linear"), "Gam_v": ("KnifeEdge", ""), "Gam_q": ("KnifeEdge", "")}
    kind, variant = kinds_.get(method, ("Revolute", "friction") if method == "Q_lam" else ("DistanceDriver", ""))
    right = system(kind, variant)
    state = states(right, scene(kind, variant)[1])[0]
    check(right, *state)
    with pytest.raises(AssertionError):
        check(wrong(right, method), *state)


@pytest.mark.parametrize(("kind", "variant"), [c for c in CASES if c.values[0].rows and not c.values[0].coupled])
def test_kernels_at_frames(kind, variant):
    """gradient and hessian themselves: between centres of mass, z = (z_a, z_b) are coordinates of the system."""
    s = system(kind.name, variant, True)
    (name,) = scene(kind.name, variant, True)[1]
    a, b = s.scene.components[name].ports.values()
    row = first_row(s, name)
    at = [s.tables.coordinates[f[:-2]] + k for f in (a, b) for k in range(3)]
    rows = slice(row, row + kind.rows)

    def table(t, q, v):
        s.stiffness(t, q, v, np.zeros(s.m + s.p))
        return s.gradient_table()[rows].copy()

    def moved(t, q, v, z, columns):
        x = q.copy()
        x[at] = z
        return table(t, x, v)[:, columns]

    for t, q, v, _ in states(s, [name]):
        C = table(t, q, v)
        if not modules()[kind.name].curved:
            second = np.zeros((kind.rows, 6, 6))
        else:
            o = [
                s.tables.layout[s.tables.layout[buffer_layout.PAIRS] + buffer_layout.PAIR * r + 3]
                for r in range(row, row + kind.rows)
            ]
            second = np.array([s._work.numbers[h : h + 36].reshape(6, 6) for h in o])
            agree(
                C[:, PLANE.GRADIENT_RATE : PLANE.GRADIENT_RATE + 6],
                np.einsum("i,kij->kj", v[at], second),
                "rate of the gradient",
            )
        if not (kind.g and all(kind.held.rates)):  # directions are not gradients of a coordinate
            agree(C[:, :6], jacobian(lambda z, t=t, q=q, v=v: moved(t, q, v, z, PLANE.VALUE), q[at]), "gradient")
            agree(second, second.transpose(0, 2, 1), "symmetry of the hessian")
        by_z = [slope(lambda d, e=e, t=t, q=q, v=v: moved(t, q, v, q[at] + d * e, slice(6))) for e in np.eye(6)]
        agree(second, np.array(by_z).transpose(1, 2, 0), "hessian")


@pytest.mark.parametrize(("kind", "variant"), [c for c in CASES if c.values[0].signals and c.values[0].rows])
def test_signals_are_what_the_kernels_compute(kind, variant):
    """The coordinates in a kind's signals, written in the language, are those of its kernels; so are their rates."""
    s, names = system(kind.name, variant), scene(kind.name, variant)[1]
    if isinstance(kind, ForceKind):
        if kind.g and all(kind.held.rates):
            pytest.skip("its rows are rates, which are no coordinates")
        own = [x.name for x in kind.signals[: kind.rows]]
    elif kind.driver:
        own = [kind.driver]
    else:
        pytest.skip("constrains other coordinates than it reports")
    for t, q, v, _ in states(s, names):
        s.evaluate(t, q, v)
        C = s.gradient_table()
        for name in names:
            c, start = s.scene.components[name], first_row(s, name)
            a, b = (s.tables.frames[f] for f in c.ports.values())
            for k, key in enumerate(own):
                root = s.scene.signal_of(c, key)
                found = values(s, [root, der(root)], np.array([t]), q[None], v[None])
                rate = C[start + k, :3] @ s._work.frames[a, 3:6] + C[start + k, 3:6] @ s._work.frames[b, 3:6]
                # the same few operations in another order: a few roundings of values of some metres
                from_start = "start(" in kind.formulas[key]  # which the kernels do not know
                assert from_start or found[0][0] == pytest.approx(C[start + k, PLANE.VALUE], abs=1e-13)
                assert found[1][0] == pytest.approx(rate, abs=1e-12)
            for key in {"force", "torque"} & {x.name for x in kind.signals}:
                root = s.scene.signal_of(c, key)
                found = values(s, [root], np.array([t]), q[None], v[None])[0][0]
                resisting = -kind.sign * C[start, PLANE.MAGNITUDE]
                assert found == pytest.approx(resisting, rel=1e-12, abs=1e-12)


def assembled(s, kind, name, t, q, v):
    """A state near q, v that satisfies the constraints of one joint."""
    rows = s.tables.rows[name] + np.arange(kind.rows) if kind.rows else np.array([], int)
    for _ in range(30):
        q = q - np.linalg.lstsq(s.Phi_q(t, q)[rows], s.Phi(t, q)[rows], rcond=None)[0]
    own = [*rows, *(s.tables.velocity_rows[name] + np.arange(len(kind.velocity_rows)) if kind.velocity_rows else ())]
    violated = np.concatenate([s.evaluate(t, q, v)[2], s.Gam(t, q, v)])[own]
    assert np.abs(s.Phi(t, q)[rows]).max(initial=0.0) < 1e-13
    return q, v - np.linalg.lstsq(s.velocity_jacobian(t, q, v)[own], violated, rcond=None)[0]


@pytest.mark.parametrize(("kind", "variant"), [c for c in CASES if not c.values[0].coupled])
def test_wrenches_on_ports_are_the_forces_of_the_kernels(kind, variant):
    """As in space, see there; on two rigid bodies, on which only elements and their weight act."""
    s, (name,) = system(kind.name, variant, True), scene(kind.name, variant, True)[1]
    c, keys = s.scene.components[name], ("vx", "vy", "w")
    weight = s.tables.numbers[s.tables.layout[buffer_layout.CONSTANT_FORCE] :][: s.n]
    t, q, v, lam = states(s, (name,))[0]
    q, v = assembled(s, kind, name, t, q, v) if isinstance(kind, JointKind) else (q, v)
    dv = np.random.default_rng(3).normal(size=(4, s.n))
    for _, at, _ in flexible(s):
        dv[:, at] = 0.0
    forces = s.evaluate(t, q, v, lam)[0] - weight
    state, found, power = (np.array([t]), q[None], v[None], lam[None]), np.zeros(len(dv)), 0.0
    for port, frame in c.ports.items():
        wrench = np.ravel(values(s, [x for part in s.scene.on_port(c, port) for x in part], *state))
        found += wrench @ [frame_coordinate(s, frame, key, np.repeat(q[None], len(dv), 0), dv) for key in keys]
        power += wrench @ [frame_coordinate(s, frame, key, *state[1:3])[0] for key in keys]
    said = values(s, [s.scene.signal_of(c, "power")], *state)[0][0] if "power" in c.signals else 0.0
    tolerance = 1e-11 * max(1.0, np.abs(forces).max())
    assert found == pytest.approx(dv @ forces, abs=tolerance)
    assert said == pytest.approx(power, abs=tolerance)


@pytest.mark.parametrize("kind", [k for k in PAIRS if k.energy], ids=lambda k: k.name)
def test_springs_are_gradients_of_their_energy(kind):
    s, names = system(kind.name, variants(kind)[0]), scene(kind.name, variants(kind)[0])[1]
    roots = [s.scene.components[name].energy for name in names]
    idle = s.scene.components
    others = [c for c in idle.values() if isinstance(c.kind, ForceKind) and c.kind.name != kind.name]
    assert all({s.scene.frames[f].body for f in c.ports.values()} == {"ground"} for c in others)
    weight = s.tables.numbers[s.tables.layout[buffer_layout.CONSTANT_FORCE] :][: s.n]
    for t, q, v, _ in states(s, names):
        slopes = gradients(s, roots, t, q, v)[1].sum(axis=0)
        for _, at, body in flexible(s):  # the body's own energy, weight included; a complex step is exact
            dq = q[at] + 1e-30j * np.eye(body.n)
            slopes[at] += body.energies(dq, np.zeros((body.n, body.n)), gravity(s.scene))[1].imag / 1e-30 + weight[at]
        # exact derivatives of both: rounding of some twenty terms of size 10, and of a hundred of size 50 in a beam
        assert s.Q(t, q) - weight == pytest.approx(-slopes, abs=1e-12)


#: kind -> coefficients, and the coordinates whose rates they damp
DAMPERS = {
    "SpringDamper": ("c = 0.7", ("s",), (0.7,)),
    "TranslationalSpringDamper": ("c = 0.7", ("s",), (0.7,)),
    "RotationalSpringDamper": ("c = 0.7", ("phi",), (0.7,)),
    "Bushing": ("c = {0.7, 0.4}, c_phi = 0.3", ("x", "y", "phi"), (0.7, 0.4, 0.3)),
}


def test_the_list_of_dampers_is_complete():
    assert set(DAMPERS) == {k.name for k in PAIRS if isinstance(k, ForceKind) and k.springs}


FLYING = """
model Flying
  Ground ground(g = 0 m/s2);
  Body a(m = 1 kg, I = 1 kg.m2, frames(f = {{0.2, -0.1, 0.3}}));
  Body b(m = 1 kg, I = 1 kg.m2, frames(f = {{-0.3, 0.4, -0.2}}));
  FreeMotion free(ground, a.c);
  FreeMotion free_too(ground, b.c);
  {}
end Flying;
"""


@pytest.mark.parametrize("name", DAMPERS)
def test_dampers_take_the_power_that_their_coefficients_say(name):
    """Only the damper acts: forces times velocities equal -c times the squares of the rates of its coordinates."""
    given, keys, c = DAMPERS[name]
    scene = mbdsl.parse(FLYING.format(f"{name} d(a.f, b.f, {given});"))
    s, rng = build(scene), np.random.default_rng(1)
    rates = [der(scene.signal(f"d.{key}")) for key in keys]
    for _ in range(STATES):
        q, v = rng.uniform(-1.0, 1.0, (2, 6))
        speeds = np.array([x[0] for x in values(s, rates, np.zeros(1), q[None], v[None])])
        assert s.Q(0.0, q, v) @ v == pytest.approx(-np.dot(c, speeds**2), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "law"), [(k.name, k.laws[0]) for k in PAIRS if isinstance(k, ForceKind) and k.springs and k.laws]
)
def test_what_replaces_springs_resists_as_they_do(name, law):
    """A force of 0.7 N pulls frames together, a torque of 0.7 N.m turns them back: the power is -0.7 times the rate."""
    (law,) = KINDS[name].laws
    torque = law == "torque"
    scene = mbdsl.parse(FLYING.format(f"{name} d(a.f, b.f, {law} = 0.7 {'N.m' if torque else 'N'});"))
    s, (q, v) = build(scene), np.random.default_rng(1).uniform(-1.0, 1.0, (2, 6))
    rate = der(scene.signal("d.phi" if torque else "d.s"))
    speed = values(s, [rate], np.zeros(1), q[None], v[None])[0][0]
    assert s.Q(0.0, q, v) @ v == pytest.approx(-0.7 * speed, rel=1e-12)


def test_forces_and_torques_do_the_work_of_their_laws():
    s = build(
        mbdsl.parse(FLYING.format("Force push(a.f, fx = 0.7 N, fy = -0.4 N); Torque turn(a.f, b.f, tau = 0.3 N.m);"))
    )
    q, v = np.random.default_rng(1).uniform(-1.0, 1.0, (2, 6))
    lever = np.exp(1j * q[2]) * (0.2 - 0.1j)
    there = complex(v[0], v[1]) + 1j * v[2] * lever
    assert s.Q(0.0, q, v) @ v == pytest.approx(0.7 * there.real - 0.4 * there.imag + 0.3 * (v[5] - v[2]), rel=1e-13)


def test_friction_follows_from_the_reactions_of_its_own_joint():
    """Of discs on pins at their centres, the second turns by 1 rad/s, far above w_s: -mu radius |lam|."""
    s = build(
        mbdsl.parse("""
model Pins
  Ground ground(g = 0 m/s2);
  Body a(m = 1 kg, I = 1 kg.m2);
  Body b(m = 1 kg, I = 1 kg.m2);
  Revolute first(ground, a.c);
  Revolute second(ground, b.c, mu = 0.3, radius = 0.1 m);
end Pins;
""")
    )
    force = s.evaluate(0.0, np.zeros(6), np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), np.array([70.0, 50.0, 3.0, 4.0]))[0]
    assert force[[2, 5]] == pytest.approx([0.0, -0.3 * 0.1 * 5.0], abs=1e-14)


def test_mass_and_weight():
    """M agrees with the bodies' tables, and at rest without forces Q is the weight.

    Of a flexible body that is: M moves it as a rigid one, and Q does the virtual work of its weight.
    """
    s = system("FreeMotion", "")
    q = np.zeros(s.n)
    M, Q = matrix(s.M(0.0, q)), s.Q(0.3, q)
    for body in s.scene.bodies():
        if body.kind.name in VARIANTS:
            continue
        d, m = s.tables.coordinates[body.name], body.values["m"]
        expected = np.array([m, m, body.values["I"]] if "phi" in body.kind.coordinates else [m, m])
        at = slice(d, d + len(expected))
        assert np.array_equal(M[at, at], np.diag(expected))
        assert s.mass()[at] == pytest.approx(expected, rel=1e-15)
        assert Q[at] == pytest.approx(np.array([0.0, -9.81 * m, 0.0])[: len(expected)], rel=1e-15)
    assert len(list(flexible(s))) == sum(map(len, VARIANTS.values()))
    # of degree 3 within elements, of which there are 2 or 4
    points, weights = np.polynomial.legendre.leggauss(4)
    points, weights = (np.arange(8)[:, None] + (points + 1) / 2).ravel() / 8 - 0.5, np.tile(weights / 16, 8)
    for name, at, body in flexible(s):
        v = s.scene.components[name].values
        m, L = v["mass"], v["length"]
        straight, rigid = body.placed((0.0, 0.0, 0.0))
        q[at] = straight
        M, Q = matrix(s.M(0.0, q))[at, at], s.Q(0.3, q)[at]
        assert rigid.T @ M @ rigid == pytest.approx(np.diag([m, m, m * L**2 / 12 + v["rotary"] * L]), rel=1e-13)
        B = [body.gradient((x * L, 0.0, 0.0), straight, 0 * straight)[0] for x in points]
        weight = -9.81 * m * np.tensordot(weights, B, 1)[1]
        assert pytest.approx(weight, rel=1e-12, abs=1e-12) == Q


def test_every_required_parameter_was_drawn():
    """The generator gives each numeric parameter a value of its own, so that none hides behind its default."""
    for kind in PAIRS:
        for way in variants(kind):
            c = scene(kind.name, way)[0].components["c0"]
            for p in kind.parameters:
                skipped = p.law or not p.unit or (way == "law" and p.name in ("k", "c"))
                if skipped or (p.name in FRICTION and way != "friction") or p.name in ROPES.get(kind.name, ()):
                    continue
                assert p.default is REQUIRED or c.values[p.name] != p.default
