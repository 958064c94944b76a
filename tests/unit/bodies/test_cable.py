"""Beams in absolute nodal coordinates: kernels against differences and energies, and beams against closed forms.

Differences are five-point ones with step H: truncation H^4/30 f^(5), f^(5) being up to 5!/|r'|^5 = 4e6 times the values
at hand where |r'| is down to 0.12 (2e-10), rounding eps/H of them (1e-12). Hence TOLERANCE, relative to the largest
entry; a wrong term is off by 1e-3 or more.
"""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

import mbdsl
from mbdsl.bodies.ancf_cable import shapes
from mbdsl.bodies.floating_beam_integrals import discretise
from mbdsl.bodies.uniform_beam import UniformBeam
from mbdsl.errors import ModelError
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop.sparse_lu import analyse
from mbdsl.kernels import buffer_layout
from mbdsl.system import build

H, TOLERANCE = 2e-4, 1e-8
DATA = Path(__file__).parents[2] / "data" / "reference" / "elastica.json"
METHODS = ("hht-i3", "hht-si2", "hht-add", "nstiff-si2", "newmark", "nstiff")
#: one of each kind of attachment: at a node, inside an element, turned; by constraints, springs and laws
ATTACHED = """
model Attached
  Ground ground(g = 9.81);
  FlexibleBeam rod(
    length = 1.2, mass = 0.9, S = 2e-4, I = 1e-8, E = 1e6, formulation = "ancf", elements = 3, beta = 0.02,
    rotary = 0.02, frames(s = {0.1, 0, 0.3}, n = {-0.2, 0, -0.4}));
  Body tip(m = 1, length = 0.3);
  Revolute O(ground, rod.a);
  Fixed W(rod.s, tip.a);
  RotationalSpringDamper turning(ground, rod.s, k = 3, c = 0.2);
  SpringDamper along(rod.n, tip.b, k = 30, c = 3);
  Torque motor(rod.n, tau = 0.7 * rod.phi + 0.2 * rod.w);
  Force follower(rod.s, rod.b, fx = 0.4, fy = 1.3);
end Attached;
"""


def system(text):
    return build(mbdsl.parse(text))


def beam(rest="", elements=8, EA=1e3, beta=0.0, rotary=0.0, more=""):
    """A beam whose length, mass and EI are 1, with the components ``rest``, or free."""
    rest = rest or "  FreeMotion free(ground, rod.c);"
    return (
        f"model M\n  Ground ground(g = 0);\n  FlexibleBeam rod(length = 1, mass = 1, S = {EA!r}, I = 1, E = 1, "
        f'formulation = "ancf", elements = {elements}, beta = {beta!r}, rotary = {rotary!r}{more});\n{rest}\nend M;'
    )


def deformed(S, seed=0, size=0.2):
    """Bent to a third of a circle or more, and stretched by some tenths; q, v, a, lam."""
    rng = np.random.default_rng(seed)
    q, v, a = (rng.normal(size=S.n) for _ in range(3))
    for name, d in S.tables.coordinates.items():
        model = S.tables.models[name]
        q[d : d + model.n] = model.placed((0.1, 0.2, 0.7))[0] + size * rng.normal(size=model.n)
    return q, v, a, rng.normal(size=S.m)


def differences(f, x):
    steps = H * np.eye(len(x))
    return np.stack([(8 * (f(x + e) - f(x - e)) - (f(x + 2 * e) - f(x - 2 * e))) / (12 * H) for e in steps], axis=-1)


def apart(found, expected):
    return np.abs(found - expected).max() / np.abs(expected).max()


# -- kernels -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_tangents_are_derivatives(seed):
    S = system(ATTACHED)
    q, v, a, lam = deformed(S, seed)
    assert apart(S.stiffness(0, q, v, lam), -differences(lambda x: S.evaluate(0, x, v, lam)[0], q)) < TOLERANCE
    assert apart(S.damping(0, q, v, lam), -differences(lambda x: S.evaluate(0, q, x, lam)[0], v)) < TOLERANCE
    assert apart(S.Phi_q(0, q), differences(lambda x: S.Phi(0, x), q)) < TOLERANCE
    assert apart(S.Phi_v_q(0, q, v), differences(lambda x: S.Phi_q(0, x) @ v, q)) < TOLERANCE
    assert apart(S.evaluate(0, q, v)[2], S.Phi_q(0, q) @ v) < 1e-13
    assert apart(S.constraint_force(0, q, lam), S.Phi_q(0, q).T @ lam) < 1e-13
    # M is constant: an acceleration adds no stiffness
    assert np.array_equal(S.stiffness(0, q, v, lam, a=a), S.stiffness(0, q, v, lam))


def test_the_model_says_of_frames_what_kernels_say():
    S = system(ATTACHED)
    q, v, _, _ = deformed(S)
    S.evaluate(0, q, v)
    d, model = S.tables.coordinates["rod"], S.tables.models["rod"]
    e, rate = q[d : d + model.n], v[d : d + model.n]
    for frame, x, phi in (("a", -0.6, 0.0), ("b", 0.6, 0.0), ("s", 0.1, 0.3), ("n", -0.2, -0.4)):
        pose, row = (x, 0.0, phi), S._work.frames[S.tables.frames[f"rod.{frame}"]]
        assert len(model.dofs(pose)) == (8 if frame == "s" else 4)
        for k, key in enumerate(("x", "y", "phi", "vx", "vy", "w")):
            assert model.frame(pose, key, e[None], rate[None])[0] == pytest.approx(row[k], rel=1e-13, abs=1e-13)
        B, B_rate = model.gradient(pose, e, rate)

        def read(keys, q, v, pose=pose):
            return np.array([model.frame(pose, k, q[None], v[None])[0] for k in keys])

        assert apart(B, differences(lambda y, read=read: read(("x", "y", "phi"), y, rate), e)) < TOLERANCE
        assert apart(B, differences(lambda y, read=read: read(("vx", "vy", "w"), e, y), rate)) < TOLERANCE
        assert apart(B_rate, differences(lambda y, read=read: read(("vx", "vy", "w"), y, rate), e)) < TOLERANCE
        others = np.setdiff1d(np.arange(model.n), model.dofs(pose))
        assert not B[:, others].any() and not B_rate[:, others].any()


@pytest.mark.parametrize("x", ["0.7, 0, 0", "0.1, 0.01, 0"])
def test_frames_lie_on_the_axis(x):
    with pytest.raises(ModelError, match="does not lie on its axis"):
        system(beam("  Revolute O(ground, rod.f);", more=f", frames(f = {{{x}}})"))


def test_forces_are_those_of_the_energy():
    S = system(beam("", elements=3).replace("g = 0", "g = 9.81"))
    g, model = np.array([0.0, -9.81]), S.tables.models["rod"]
    for seed in range(3):
        q, v, _, _ = deformed(S, seed)
        gradient = differences(lambda x: model.energies(x[None], v[None], g)[1][0], q)  # noqa: B023
        assert apart(S.Q(0, q, v), -gradient) < TOLERANCE
        assert model.energies(q[None], v[None], g)[0] == pytest.approx(0.5 * v @ model.M(q) @ v, rel=1e-13)


def test_damping_takes_what_strain_rates_say():
    """-v . (Q(v) - Q(0)) = T int EA eps'^2 + EI K'^2 dx, rates by differences along q + t v."""
    S = system(beam("", elements=3, beta=0.03))
    model = S.tables.models["rod"]
    q, v, _, _ = deformed(S)
    rates = [differences(lambda t, k=k: model.strains((q + t * v)[None])[k], np.zeros(1))[0, ..., 0] for k in (0, 1)]
    weights = np.array([1, 4, 1]) / 6, np.array([5, 8, 5]) / 18
    power = (
        0.03
        * model.L
        * sum(
            stiffness * (rate**2).sum(axis=0) @ w for stiffness, rate, w in zip((1e3, 1.0), rates, weights, strict=True)
        )
    )
    assert -v @ (S.Q(0, q, v) - S.Q(0, q)) == pytest.approx(power, rel=1e-8)


def test_mass_matrix():
    """Against quadrature with more points than needed; total mass and moment of inertia; its inverse in the kernels."""
    S = system(beam("", elements=5, rotary=0.03))
    model, L = S.tables.models["rod"], 0.2
    x, w = np.polynomial.legendre.leggauss(7)
    N, d, _ = shapes((x + 1) / 2, L)
    expected = np.zeros((S.n, S.n))
    for i in range(5):
        for axis in range(2):
            own = 4 * i + axis + 2 * np.arange(4)
            expected[np.ix_(own, own)] += L / 2 * ((N.T * w) @ N + 0.03 * (d.T * w) @ d)
    q, at = model.placed((0.3, -0.2, 0.9))
    M = S.M(0, q)
    assert apart(M, expected) < 1e-14 and apart(model.M(q), expected) < 1e-14
    assert np.allclose(at.T @ M @ at, np.diag([1.0, 1.0, 1 / 12 + 0.03]), rtol=0, atol=1e-14)
    work, force = S.workspace(), np.random.default_rng(0).normal(size=S.n)
    work.vectors[buffer_layout.FORCE] = force
    S.kernels(1).inertia(
        buffer_layout.INVERSE, buffer_layout.FORCE, buffer_layout.TEMPORARY, work.vectors, work.numbers, work.layout
    )
    assert apart(work.vectors[buffer_layout.TEMPORARY], np.linalg.solve(expected, force)) < 1e-11


# -- rigid motion ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("phi", [0.0, 0.4, 2.0, np.pi, -3.0, 5.5])
def test_rigid_motion_strains_nothing(phi):
    S = system(beam("", elements=4, EA=1e6, beta=0.1))
    model = S.tables.models["rod"]
    q, rates = model.placed((2.0, -1.0, phi))
    v = rates @ [0.3, -0.7, 5.0]
    eps, K = model.strains(q[None])
    assert np.abs(eps).max() < 1e-14 and np.abs(K).max() < 1e-13
    assert np.abs(S.Q(0, q, v)).max() < 1e-8  # of EA = 1e6 to rounding, with 5 rad/s
    assert np.abs(S.stiffness(0, q) @ rates).max() < 1e-8


def test_forces_turn_with_the_beam():
    S = system(beam("", elements=4, beta=0.1))
    q, v, _, _ = deformed(S)
    force = S.Q(0, q, v)
    for phi in (0.5, 2.5, -1.7):
        c, s = np.cos(phi), np.sin(phi)
        turn = np.kron(np.eye(S.n // 2), [[c, -s], [s, c]])
        moved = turn @ q + np.tile([3.0, -2.0, 0.0, 0.0], 5)
        # turning adds J q to the velocity, which strains nothing
        spin = 7.0 * np.kron(np.eye(S.n // 2), [[0.0, -1.0], [1.0, 0.0]]) @ turn @ q
        assert apart(S.Q(0, moved, turn @ v + spin), turn @ force) < 1e-12


def test_errors_of_all_nodes_count_alike():
    """Positions are compared as parts of the mechanism's size; slopes by the displacement of the next node that they
    cause."""
    S = system(beam(elements=5))
    assert S.tables.scale.size == S.n == 24
    assert S.tables.scale.reshape(6, 4) == pytest.approx(np.array([[1.0, 1.0, 0.2, 0.2]] * 6) / S.tables.size)


def test_inertia_of_a_rotation():
    """Points of a beam that turns about one of its own move as S e(t) says, exactly: so do energy and inertia force."""
    S = system(beam("", elements=3, rotary=0.02))
    model, w = S.tables.models["rod"], 4.0
    q, rates = model.placed((0.5 * np.cos(0.8), 0.5 * np.sin(0.8), 0.8))  # frame a at the origin
    about = np.kron(np.eye(8), [[0.0, -1.0], [1.0, 0.0]])
    kinetic = model.energies(q[None], (w * about @ q)[None], np.zeros(2))[0][0]
    assert kinetic == pytest.approx(0.5 * (1 / 3 + 0.02) * w**2, rel=1e-14)
    force = S.M(0, q) @ (-(w**2) * q)
    assert np.allclose(rates.T @ force, [-(w**2) * 0.5 * np.cos(0.8), -(w**2) * 0.5 * np.sin(0.8), 0.0], atol=1e-13)


# -- statics -----------------------------------------------------------------------------------------------------

LOADS = """
  input Real px(start = 0);
  input Real py(start = 0);
  input Real m(start = 0);
  Fixed clamp(ground, rod.a);
  Force tip(rod.b, fx = px, fy = py);
  Torque moment(rod.b, tau = m);
initial equation
  rod.phi = 0;
"""


def at_rest(S, load, steps=10):
    """Equilibrium under loads by name, by Newton's method from the straight beam on; frame b (3,)."""
    start = S.tables.models["rod"].placed((0.5, 0.0, 0.0))[0]
    q, lam = start, np.zeros(S.m)
    for k in range(1, steps + 1):
        for name, value in load.items():
            S.set_input(name, value * k / steps)
        for _ in range(60):
            f, phi, _ = S.evaluate(0, q, None, lam)
            step = np.linalg.solve(S.tangent(0, q, None, lam, cK=1.0, cP=1.0), np.concatenate([f, -phi]))
            size = np.abs(step[: S.n]).max()
            step *= min(1.0, 0.5 / max(size, 1e-300))
            q, lam = q + step[: S.n], lam + step[S.n :]
            if size < 1e-9:
                break
        else:
            raise AssertionError("no equilibrium found")
    S.evaluate(0, q, None, lam)
    return S._work.frames[S.tables.frames["rod.b"], :3].copy()


def inextensible(elements, load, EA, **options):
    """Tip of a beam that does not stretch, from two that hardly do."""
    stiff, soft = (at_rest(system(beam(LOADS, elements, EA=k * EA)), load, **options) for k in (2.0, 1.0))
    return 2 * stiff - soft


@cache
def elastica():
    rows = json.loads(DATA.read_text())["data"]["rows"]
    keys = ("tip_x_over_L", "tip_defl_over_L", "tip_slope_rad")
    return {float(r["PL2_over_EI"]): np.array([float(r[k]) for k in keys]) for r in rows}


def orders(errors):
    return np.log2(np.array(errors[:-1]) / errors[1:])


@pytest.mark.parametrize(("EA", "steps"), [(1e6, 10), (1e8, 40)])
@pytest.mark.parametrize("P", [1.0, 5.0, 10.0])
def test_dead_load_at_the_tip(P, EA, steps):
    """The elastica: 1e-4 with eight elements, order 4, for any ratio of axial to bending stiffness."""
    errors = [np.abs(inextensible(n, {"py": P}, EA, steps=steps) - elastica()[P]).max() for n in (4, 8, 16)]
    assert errors[1] < 1e-4
    assert (orders(errors) > 3.5).all()


def test_end_moment_makes_a_circle():
    """Curvature is constant: at lambda = 2 pi the tip is back where the beam begins, turned once."""
    errors = []
    for n in (8, 16, 32):
        found = inextensible(n, {"m": 2 * np.pi}, 1e6)
        errors.append(np.abs(found - [0.0, 0.0, 2 * np.pi]).max())
    assert errors[-1] < 1e-4
    assert (orders(errors) > 3.8).all()


def test_small_loads_bend_as_the_linear_theory_says():
    """Deflection and slope per load are even functions of it: two loads, extrapolated to none."""
    S = system(beam(LOADS, 2, EA=1e4))
    (_, y1, phi1), (_, y2, phi2) = (at_rest(S, {"py": P}, steps=1) / P for P in (1e-2, 2e-2))
    assert (4 * y1 - y2) / 3 == pytest.approx(1 / 3, rel=1e-8)
    assert (4 * phi1 - phi2) / 3 == pytest.approx(1 / 2, rel=1e-8)
    assert abs(y2 - 1 / 3) > 1e-6  # the values of the extrapolation
    tension = [at_rest(S, {"px": P, "py": 0.0}, steps=1)[0] - 1 for P in (1.0, -1.0)]
    assert tension == pytest.approx([1e-4, -1e-4], rel=1e-10)  # eps is linear in r' along the axis


# -- vibration ---------------------------------------------------------------------------------------------------


def frequencies(rest, elements, EA):
    """Of vibrations about the straight beam (rad/s), axial ones, then those across."""
    S = system(beam(rest, elements, EA=EA))
    q = S.tables.models["rod"].placed((0.5, 0.0, 0.0))[0]
    K, M, N = S.stiffness(0, q), S.M(0, q), null_space(S.Phi_q(0, q)) if S.m else np.eye(S.n)
    values, vectors = eigh(N.T @ K @ N, N.T @ M @ N)
    along = (N @ vectors)[0::2]
    axial = np.einsum("ik,ij,jk->k", along, M[0::2, 0::2], along) > 0.5
    return np.sqrt(values[axial]), np.sqrt(values[~axial])


def clamped_free(k):
    return brentq(lambda b: np.cos(b) * np.cosh(b) + 1, (k - 0.5) * np.pi - 0.4, (k - 0.5) * np.pi + 0.4, xtol=1e-14)


CLAMPED = "  Fixed clamp(ground, rod.a);"
PINNED = "  Revolute pin(ground, rod.a);\n  PointOnLine slide(ground, rod.b);"


@pytest.mark.parametrize(
    ("rest", "exact"),
    [(CLAMPED, [clamped_free(k) ** 2 for k in (1, 2, 3)]), (PINNED, [(k * np.pi) ** 2 for k in (1, 2, 3)])],
    ids=["clamped-free", "pinned-pinned"],
)
def test_frequencies_across(rest, exact):
    errors = np.array([frequencies(rest, n, 1e4)[1][:3] / exact - 1 for n in (6, 12, 24)])
    assert (errors[1] < 3e-4).all() and (errors > 0).all()  # as of every conforming discretisation
    assert (orders(errors) > 3.8).all()


def test_frequencies_along():
    exact = np.sqrt(1e5) * np.pi * np.array([0.5, 1.5, 2.5])
    errors = np.abs([frequencies(CLAMPED, n, 1e5)[0][:3] / exact - 1 for n in (4, 8, 16)])
    assert (errors[1] < 5e-4).all()
    assert (orders(errors) > 3.8).all()


@pytest.mark.parametrize("elements", [1, 2, 7])
def test_nothing_but_rigid_motion_is_free(elements):
    """Fewer points for strains would leave more than three motions of a straight beam without a force."""
    S = system(beam("", elements))
    q, _ = S.tables.models["rod"].placed((0.0, 0.0, 0.3))
    values = eigh(S.stiffness(0, q), S.M(0, q), eigvals_only=True)
    assert np.abs(values[:3]).max() < 1e-9 * values[-1]
    same = discretise(UniformBeam(1.0, 1.0, 1e3, 1.0, elements=elements, modes=1, axial=0, reference="mean-axis"))
    assert values[3] == pytest.approx(same.frequencies()[0] ** 2, rel=1e-9)  # cubic elements made by other code
    if elements == 1:
        assert values[3] == pytest.approx(720.0, rel=1e-9)  # Ritz's method with a parabola, by hand


# -- motion ------------------------------------------------------------------------------------------------------


def hanging(elements=8, beta=0.0):
    return f"""
model Hanging
  Ground ground(g = 9.81);
  FlexibleBeam rod(length = 1, mass = 0.5, S = 1e-4, I = 1e-9, E = 1e8, formulation = "ancf", elements = {elements},
    beta = {beta});
  Revolute O(ground, rod.a);
initial equation
  rod.phi = 0;
  rod.w = 0;
end Hanging;
"""


def energy(t, g=9.81):
    return sum(t.system.tables.models["rod"].energies(t.q, t.v, np.array([0.0, -g])))


@pytest.mark.parametrize("method", METHODS)
def test_a_hanging_beam_swings(method):
    """Without damping, energy is lost by the method alone, with its order; with damping, at every step."""
    order = 1 if method == "newmark" else 2
    run = lambda h, beta: mbdsl.simulate(  # noqa: E731
        mbdsl.parse(hanging(4, beta)), method=method, step=h, stop=0.4, interval=0, force=True
    )
    lost = []
    for h in (1e-3, 5e-4, 2.5e-4):
        E = energy(run(h, 0.0))
        assert E.max() - E[0] < 1e-4 * np.ptp(E) + 1e-6
        lost.append(np.abs(E - E[0]).max())
    assert (orders(lost) > order - 0.2).all()
    t = run(1e-3, 0.01)
    E, S = energy(t), t.system
    power = np.array([v @ (S.Q(0, q) - S.Q(0, q, v)) for q, v in zip(t.q, t.v, strict=True)])
    assert (np.diff(E)[5:] < 0).all()
    balance = E[0] - E[-1] - np.trapezoid(power, t.t)
    assert abs(balance) < 1.2 * lost[0] < 0.2 * (E[0] - E[-1])


def test_methods_agree():
    ends = []
    for method in METHODS:
        coarse, fine = (
            mbdsl.simulate(mbdsl.parse(hanging(4, 0.002)), method=method, step=h, stop=0.4, force=True).q[-1]
            for h in (5e-4, 2.5e-4)
        )
        p = 1 if method == "newmark" else 2
        ends.append(fine + (fine - coarse) / (2**p - 1))
    assert np.abs(np.array(ends) - ends[0]).max() < 1e-5


def test_angles_count_turns():
    """A driver turns the end of a beam five times; its torque is about the angle that the kernels count."""
    driven = "RotationalDriver d(ground, rod.a, phi = 5 * (1 rad/s * time - sin(1 rad/s * time)));"
    rest = f"  Revolute O(ground, rod.a);\n  {driven}"
    text = beam(rest + "\ninitial equation\n  guess rod.phi = 0;", 2)
    t = mbdsl.simulate(mbdsl.parse(text), method="hht-si2", step=1e-3, stop=2 * np.pi, interval=0.01)
    exact = 5 * (t.t - np.sin(t.t))
    model = t.system.tables.models["rod"]
    assert np.abs(model.frame((-0.5, 0, 0), "phi", t.q, t.v) - exact).max() < 1e-9
    assert exact[-1] == pytest.approx(10 * np.pi) and np.abs(t["rod.phi"] - exact).max() < 1.0
    S, row = t.system, t.system.tables.frames["rod.a"]
    for k, (q, angle) in enumerate(zip(t.q, exact, strict=True)):
        S.count_turns(q)
        S.evaluate(t.t[k], q)
        assert S._work.frames[row, 2] == pytest.approx(angle, abs=1e-9)


def test_a_spring_winds_up():
    """A torque winds up a torsional spring by several turns, and recovers its work: E - tau phi + k phi^2/2."""
    rest = (
        "  Revolute O(ground, rod.a);\n  RotationalSpringDamper k(ground, rod.a, k = 0.05);\n"
        "  Torque tau(rod.a, tau = 0.6);\ninitial equation\n  rod.phi = 0;\n  rod.w = 0;"
    )
    t = mbdsl.simulate(mbdsl.parse(beam(rest, 2)), method="hht-si2", step=2e-3, stop=16.0, interval=0.02)
    phi = t.system.tables.models["rod"].frame((-0.5, 0, 0), "phi", t.q, t.v)
    E = energy(t, g=0.0) - 0.6 * phi + 0.025 * phi**2
    assert phi.max() > 3 * 2 * np.pi
    # the method damps the vibration that the sudden torque excites; a missed turn would be 0.6 * 2 pi
    assert np.abs(E - E[0]).max() < 1e-3 * 0.6 * phi.max()


@pytest.mark.parametrize("turn", [1.5 * np.pi, -4.0, 2 * np.pi + 0.1, np.pi])
def test_where_it_is_placed_says_how_often_it_has_turned(turn):
    S = system(beam(f"  Fixed clamp(ground, rod.a, phi0 = {turn});\ninitial equation\n  rod.phi = {turn};", 3))
    first = initial_state(S, S.graph, 0.0)
    assert first.q == pytest.approx(
        S.tables.models["rod"].placed((0.5 * np.cos(turn), 0.5 * np.sin(turn), turn))[0], abs=1e-12
    )
    assert np.abs(S.Phi(0, first.q)).max() < 1e-12


def test_cost_grows_with_the_number_of_elements():
    """Entries of the iteration matrix, of its factors and of the tables grow by the same number with every element."""
    counts = []
    for n in (10, 20, 40):
        S = system(beam("  Revolute O(ground, rod.a);", n))
        pattern = analyse(S.unknowns, *S.tables.pattern, S.elimination_order())
        counts.append([S.size, pattern.size, pattern.length, len(S.tables.numbers), len(S.tables.layout)])
    counts = np.array(counts)
    assert np.array_equal(counts[2] - counts[1], 2 * (counts[1] - counts[0]))
