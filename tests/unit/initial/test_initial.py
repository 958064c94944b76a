"""Consistent initial values: fixed values stay, guesses change least, and impossible ones are reported in terms of the
model."""

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array

import mbdsl
from mbdsl import Builder
from mbdsl.errors import InitialisationError
from mbdsl.initial.consistent import initial_state
from mbdsl.initial.least_steps import constrained, damped
from mbdsl.initial.placement import place
from mbdsl.mechanism import graph
from mbdsl.system import build
from mbdsl.system.accelerations import balance
from mbdsl.system.system import DENSE_LIMIT

#: assembly ends where constraints hold to 1e-13 of the mechanism's size; linear solves lose two digits more
EXACT = 1e-12


def start(model, t=0.0):
    """The system and its consistent initial state."""
    scene = model.scene() if isinstance(model, Builder) else mbdsl.parse(model)
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    return system, initial_state(system, mechanism, t)


def dense(value):
    return value.toarray() if hasattr(value, "toarray") else value


def consistent(system, s):
    """Constraints of all levels and the equations of motion hold."""
    force, position, velocity = system.evaluate(s.t, s.q, s.v, s.lam)
    assert np.abs(position).max(initial=0.0) < EXACT
    assert np.abs(velocity).max(initial=0.0) < EXACT * (1 + np.abs(s.v).max())
    size = 1 + np.abs(force).max() + np.abs(s.lam).max(initial=0.0)
    assert np.abs(system.mass() * s.a - force).max() < EXACT * size
    acceleration = dense(system.Phi_q(s.t, s.q)) @ s.a - system.gamma_c(s.t, s.q, s.v)
    assert np.abs(acceleration).max(initial=0.0) < EXACT * (1 + np.abs(s.a).max())


def value(system, s, name):
    return s.q[system.names().index(name)]


CRANK = """
model Crank
  Ground ground;
  Rod crank(m = 3 kg, length = 0.3 m);
  Rod rod(m = 0.9 kg, length = 0.6 m);
  Revolute O(ground, crank.a);
  Revolute A(crank.b, rod.a);
  PointOnLine B(ground, rod.b);
initial equation
  {}
end Crank;
"""


def test_fixed_values_are_kept_and_the_rest_follows():
    system, s = start(CRANK.format("crank.phi = 0.7; crank.w = 3; guess rod.phi = 0;"))
    assert value(system, s, "crank.phi") == pytest.approx(0.7, abs=1e-15)
    assert s.v[2] == pytest.approx(3.0, abs=1e-14)
    assert value(system, s, "rod.phi") == pytest.approx(-np.arcsin(np.sin(0.7) / 2), abs=EXACT)
    rate = -np.cos(0.7) * 3 / (2 * np.sqrt(1 - np.sin(0.7) ** 2 / 4))
    assert s.v[5] == pytest.approx(rate, abs=EXACT)
    consistent(system, s)
    assert [m.name for m in s.moved] == ["rod.phi"]
    assert s.moved[0].guess == 0.0
    assert s.moved[0].value == value(system, s, "rod.phi")


def test_a_guess_that_fits_is_not_reported():
    _, s = start(CRANK.format("crank.phi = 0; guess rod.phi = 0;"))
    assert s.moved == ()


def test_guesses_choose_the_branch():
    left = "crank.phi = 0.7; guess rod.phi = 3;"
    system, s = start(CRANK.format(left))
    assert value(system, s, "rod.phi") == pytest.approx(np.pi + np.arcsin(np.sin(0.7) / 2), abs=EXACT)
    consistent(system, s)


def test_guesses_move_least():
    """A point on the line y = x tan(30 deg), guessed beside it, goes to the foot of the perpendicular."""
    b = Builder("Foot")
    b.Ground("ground", frames={"line": (0, 0, np.pi / 6)})
    p = b.PointMass("p", m=1.0)
    b.PointOnLine("slot", "ground.line", p)
    b.initial(p.x, 1.0, fixed=False)
    b.initial(p.y, 2.0, fixed=False)
    b.initial(p.vx, 3.0, fixed=False)
    b.initial(p.vy, -1.0, fixed=False)
    system, s = start(b)
    along = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    # every coordinate also has a weight of 1e-3, against 1, towards its first placement: a millionth in squares
    assert s.q == pytest.approx(along * (along @ (1.0, 2.0)), abs=3e-6)
    assert s.v == pytest.approx(along * (along @ (3.0, -1.0)), abs=3e-6)
    consistent(system, s)
    assert {m.name for m in s.moved} == {"p.x", "p.y", "p.vx", "p.vy"}


def test_what_nothing_was_said_about_moves_first():
    """Of two points joined by a link, the one with a guess stays in place."""
    b = Builder("Link")
    ground = b.Ground("ground")
    p, q = b.PointMass("p", m=1.0), b.PointMass("q", m=1.0)
    b.FreeMotion("free", ground, p)
    b.Distance("link", p, q, length=1.0)
    b.initial(p.x, 0.3, fixed=False)
    b.initial(p.y, 0.4, fixed=False)
    b.initial(p.vx, 1.0, fixed=False)
    b.initial(p.vy, 2.0, fixed=False)
    system, s = start(b)
    assert s.q[:2] == pytest.approx([0.3, 0.4], abs=1e-5)
    assert s.v[:2] == pytest.approx([1.0, 2.0], abs=1e-5)
    assert np.hypot(*(s.q[2:] - s.q[:2])) == pytest.approx(1.0, abs=1e-13)
    consistent(system, s)


@pytest.mark.parametrize("phi", [0.4, 2.2, -2.9])
def test_a_body_whose_centre_is_known_is_turned_towards_its_joint(phi):
    pivot, lever = 0.5 + 0.2j, -0.3 + 0.1j  # the frame on the body, from its centre of mass
    centre = pivot - np.exp(1j * phi) * lever
    scene = mbdsl.parse(f"""
model Hung
  Ground ground;
  Frame there(ground, r = {{0.5 m, 0.2 m}});
  Body b(m = 1 kg, I = 1 kg.m2, frames(a = {{-0.3, 0.1}}));
  Revolute pin(there, b.a);
initial equation
  guess b.x = {float(centre.real)!r} m;
  guess b.y = {float(centre.imag)!r} m;
end Hung;
""")
    mechanism = graph.build(scene)
    x, y, turned = place(build(scene, mechanism), mechanism, 0.0, list(scene.initial))
    assert complex(x, y) == pytest.approx(centre, abs=1e-14)
    assert np.exp(1j * turned) == pytest.approx(np.exp(1j * phi), abs=1e-14)


def test_driven_crank_moves_at_the_start():
    """Positions and velocities at the start are the driver's, at whatever time it starts."""
    drive = "RotationalDriver drive(O, phi = 0.3 + 2 rad/s * time + 0.5 rad/s2 * time * time);"
    text = CRANK.replace("initial equation", drive + "\ninitial equation")
    for t in (0.0, 1.5):
        system, s = start(text.format("guess rod.phi = 0; guess crank.phi = 1;"), t)
        assert value(system, s, "crank.phi") == pytest.approx(0.3 + 2 * t + t * t / 2, abs=EXACT)
        assert s.v[2] == pytest.approx(2 + t, abs=EXACT)
        assert s.a[2] == pytest.approx(1.0, abs=1e-10)
        consistent(system, s)


def test_accelerations_of_driven_velocities_are_the_rates_of_their_laws():
    system, s = start("""
model Driven
  Ground ground;
  Body wheel(m = 1 kg, I = 0.5 kg.m2);
  Body block(m = 2 kg, I = 1 kg.m2);
  Revolute pin(ground, wheel.c);
  RotationalVelocityDriver motor(pin, w = 1 rad/s + 3 rad/s2*time);
  Prismatic slide(ground, block.c);
  TranslationalVelocityDriver actuator(slide, v = 0.7 m/s*sin(2 rad/s*time));
end Driven;
""")
    a = dict(zip(system.names(), s.a, strict=True))
    assert a["wheel.phi"] == pytest.approx(3.0, rel=1e-14)
    assert a["block.x"] == pytest.approx(1.4, rel=1e-14)
    assert system.constraint_names()[-2:] == ["motor.Gam[1]", "actuator.Gam[1]"]
    assert sorted(system.elimination_order().tolist()) == list(range(system.unknowns))
    # reactions: I phi'' and m x'', with the signs of constraint forces -J^T lam
    assert s.lam[-2:] == pytest.approx([-0.5 * 3.0, -2.0 * 1.4], rel=1e-13)


def test_start_at_a_dead_centre():
    """Stretched out, the slider's velocity does not depend on the crank's, and its acceleration is finite."""
    system, s = start(CRANK.format("crank.phi = 0; crank.w = 2; guess rod.phi = 0;"))
    consistent(system, s)
    r, l, w = 0.3, 0.6, 2.0
    assert s.v[5] == pytest.approx(-r / l * w, abs=EXACT)  # the rod's angular velocity
    end = system.evaluate(0.0, s.q, s.v)
    assert np.abs(end[1]).max() < EXACT
    # centre of the rod: r'' = -r w^2 - l/2 (r w / l)^2
    assert s.a[3] == pytest.approx(-r * w**2 - l / 2 * (r * w / l) ** 2, abs=1e-10)


def test_a_fixed_pose_at_the_end_of_reach():
    """At the dead centre of the slider, the constraint and the fixed value are tangent: their Jacobian is singular
    there."""
    system, s = start(CRANK.format("B.s = 0.9; guess crank.phi = 0.1; guess rod.phi = 0;"))
    position = system.Phi(0.0, s.q)
    # a double root is found to the root of the tolerance
    assert np.abs(position).max() < 1e-10
    assert abs(value(system, s, "crank.phi")) < 1e-4


PARALLEL = """
model Parallel "three equal cranks carry a beam: one constraint more than needed"
  Ground ground;
  Frame base[3](ground, r = {{0, 0}, {1, 0}, {2, 0}});
  Rod crank[3](each m = 1 kg, each length = 0.5 m);
  Body beam(m = 2 kg, I = 1 kg.m2, frames(p1 = {-1, 0}, p2 = {0, 0}, p3 = {1, 0}));
  for i in 1:3 loop
    Revolute A[i](base[i], crank[i].a);
  end for;
  Revolute B1(crank[1].b, beam.p1);
  Revolute B2(crank[2].b, beam.p2);
  Revolute B3(crank[3].b, beam.p3);
initial equation
  crank[1].phi = 1; crank[1].w = 2;
  guess crank[2].phi = 1; guess crank[3].phi = 1;
  guess beam.phi = 0;
end Parallel;
"""


def test_redundant_constraints():
    """The motion of a parallelogram with a third crank is unique; its multipliers are not, but one solution satisfies
    the equations."""
    system, s = start(PARALLEL)
    consistent(system, s)
    assert system.m - len(s.redundant) == system.n - 1
    assert len(s.redundant) == 1
    # one freedom theta: (3 m L^2/3 + M L^2) theta'' = -(3 m L/2 + M L) g cos(theta)
    L, m, M, g = 0.5, 1.0, 2.0, 9.81
    expected = -(1.5 * m + M) * L * g * np.cos(1.0) / ((m + M) * L**2)
    for i in range(3):
        assert s.a[3 * i + 2] == pytest.approx(expected, rel=1e-11)


def test_fixed_values_that_cannot_be():
    with pytest.raises(InitialisationError) as caught:
        start(CRANK.format("crank.phi = 0; rod.b.x = 5 m;"))
    error = caught.value
    assert error.exit_code == 3
    text = error.render()
    assert "no consistent initial positions" in text
    assert "rod.b.x = 5 m is fixed" in text
    lines = CRANK.splitlines()
    where = {note.split(" is ")[0]: span.line for note, span in error.notes if span}
    assert error.span is not None
    for name, line in where.items():
        if name.startswith(("Revolute", "PointOnLine")):
            assert name in lines[line - 1].replace("(", " "), name


def test_fixed_velocities_that_cannot_be():
    with pytest.raises(InitialisationError) as caught:
        start(CRANK.format("crank.phi = 1; crank.w = 1; rod.w = 7;"))
    assert caught.value.exit_code == 3
    text = caught.value.render()
    assert "no consistent initial velocities" in text
    assert "rod.w = 7" in text or "crank.w = 1" in text


def test_lengths_that_do_not_meet():
    text = CRANK.replace("Rod rod(m = 0.9 kg, length = 0.6 m)", "Rod rod(m = 0.9 kg, length = 0.1 m)")
    with pytest.raises(InitialisationError) as caught:
        start(text.format("crank.phi = 1.5;"))
    text = caught.value.render()
    assert "is violated by" in text
    assert "PointOnLine B" in text or "Revolute A" in text


def test_forces_that_are_no_numbers():
    text = CRANK.replace("initial equation", "Torque t(crank.a, tau = 1 N.m * sqrt(crank.phi - 3));\ninitial equation")
    with pytest.raises(InitialisationError, match="not finite"):
        start(text.format("crank.phi = 1;"))


def test_free_bodies_start_where_said_and_at_rest():
    b = Builder("Free")
    ground = b.Ground("ground")
    body = b.Body("body", m=1.0, I=1.0)
    b.FreeMotion("free", ground, body.c)
    b.initial(body.x, 1.0)
    b.initial(body.phi, 0.5)
    system, s = start(b)
    assert s.q == pytest.approx([1.0, 0.0, 0.5], abs=1e-15)
    assert s.v == pytest.approx(np.zeros(3), abs=1e-15)
    assert s.a == pytest.approx([0.0, -9.81, 0.0], abs=1e-13)
    consistent(system, s)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e4])
def test_assembly_is_free_of_scale(size):
    """A closed loop is assembled as well when it is tiny or huge."""
    b = Builder("Scaled")
    ground = b.Ground("ground")
    crank, rod = b.Rod("crank", m=1.0, length=0.3 * size), b.Rod("rod", m=1.0, length=0.6 * size)
    b.Revolute("O", ground, crank.a)
    b.Revolute("A", crank.b, rod.a)
    b.PointOnLine("B", ground, rod.b)
    b.initial(crank.phi, 0.7)
    b.initial(rod.phi, 0.0, fixed=False)
    b.initial(crank.w, 1.0)
    system, s = start(b)
    assert value(system, s, "rod.phi") == pytest.approx(-np.arcsin(np.sin(0.7) / 2), abs=EXACT)
    assert s.v[5] == pytest.approx(-np.cos(0.7) / (2 * np.sqrt(1 - np.sin(0.7) ** 2 / 4)), abs=1e-9)
    assert np.abs(system.Phi(0.0, s.q)).max() < 1e-12 * size


def test_balanced_equations_have_entries_near_one():
    """For any masses: powers of two, each of which brings a mass or a row of J to between 0.4 and 2."""
    system, s = start("""
model Link
  Ground ground;
  PointMass p(m = 1e-9 kg);
  PointMass q(m = 1e9 kg);
  Distance far(ground, p, length = 1 km);
  Distance near(p, q, length = 1 um);
end Link;
""")
    M, J = system.M(0.0, s.q).diagonal(), system.Phi_q(0.0, s.q)
    d = balance(system, M, J)
    assert (np.frexp(d)[0] == 0.5).all()
    assert (d[:4] ** 2 * M > 0.4).all() and (d[:4] ** 2 * M < 2.0).all()
    rows = d[4:] * (np.abs(J) @ d[:4])
    assert (rows > 0.4).all() and (rows < 2.0).all()


@pytest.mark.parametrize("solve", [constrained, damped])
def test_dense_and_sparse_steps_agree(solve):
    rng = np.random.default_rng(2)
    weight, r_w, r_s, r_c = (rng.uniform(0.5, 1.5, k) for k in (7, 7, 4, 3))
    S, J = rng.normal(size=(4, 7)), rng.normal(size=(3, 7))
    found = solve(weight, r_w, S, r_s, J, r_c)
    assert solve(weight, r_w, csr_array(S), r_s, csr_array(J), r_c) == pytest.approx(found, abs=1e-11)


def test_steps_of_assembly_end_where_the_gradient_is_along_constraints():
    """J d = -r_c, and the gradient of |r_w + W d|^2 + |r_s + S d|^2 has no component in the null space of J."""
    rng = np.random.default_rng(2)
    weight, r_w, r_s, r_c = (rng.uniform(0.5, 1.5, k) for k in (7, 7, 4, 3))
    S, J = rng.normal(size=(4, 7)), rng.normal(size=(3, 7))
    d = constrained(weight, r_w, S, r_s, J, r_c)
    assert J @ d == pytest.approx(-r_c, abs=1e-13)
    gradient = weight * (r_w + weight * d) + S.T @ (r_s + S @ d)
    assert gradient == pytest.approx(J.T @ np.linalg.lstsq(J.T, gradient, rcond=None)[0], abs=1e-12)


def test_long_chain_is_assembled():
    """Beyond the limit for dense matrices assembly and accelerations are solved sparsely: the same checks."""
    n = DENSE_LIMIT // 5 + 20
    b = Builder("Chain")
    frame = b.Ground("ground")
    for i in range(1, n + 1):
        link = b.Rod(f"link[{i}]", m=1.0, length=1.0)
        b.Revolute(f"J[{i}]", frame, link.a)
        b.initial(link.phi, 0.01 * i)
        b.initial(link.w, 0.1 * (-1) ** i)
        frame = link.b
    system, s = start(b)
    assert not isinstance(system.Phi_q(0.0, s.q), np.ndarray)
    assert s.q[2::3] == pytest.approx(0.01 * np.arange(1, n + 1), abs=EXACT)
    assert s.v[2::3] == pytest.approx(0.1 * (-1.0) ** np.arange(1, n + 1), abs=EXACT)
    # the condition of a chain grows with the square of its length: two digits for each factor of ten
    force, position, velocity = system.evaluate(0.0, s.q, s.v, s.lam)
    assert max(np.abs(position).max(), np.abs(velocity).max()) < n * EXACT
    assert np.abs(system.mass() * s.a - force).max() < n**2 * EXACT
    acceleration = system.Phi_q(0.0, s.q) @ s.a - system.gamma_c(0.0, s.q, s.v)
    assert np.abs(acceleration).max() < n**2 * EXACT


@pytest.mark.parametrize("n", [1, 5, 6, 20])
def test_four_bars_start_where_they_are_meant_to(n):
    """The positions of couplers are given, but not their angles; for any N, no given value has to change."""
    path = Path(__file__).parents[3] / "models" / "four_bar.mbd"
    r = mbdsl.simulate(mbdsl.load(path, {"N": n}), step=1e-3, stop=1e-3)
    assert not r.moved
    kinetic = (n + 1) / 6 + n / 2  # rockers turn at 1 rad/s, couplers move at 1 m/s
    assert r["energy.total"][0] == pytest.approx(((n + 1) / 2 + n) * 9.81 + kinetic, rel=1e-12)


@pytest.mark.parametrize("length", [1e-9, 1e-3, 1.0, 1e6])
@pytest.mark.parametrize("where", [0.0, 7.0])
def test_size_of_a_mechanism_of_points(length, where):
    """The largest distance of frames on the ground; otherwise a given length, otherwise a length at the start; at any
    place."""

    def size(*frames, s0=0.0, start=0.0):
        b = Builder("Points")
        ground, mass = b.Ground("ground", g=0.0), b.PointMass("mass", m=1.0)
        for k, x in enumerate(frames):
            b.frame(f"f{k}", ground, (where * length, x))
            b.SpringDamper(f"spring{k}", f"f{k}", mass, k=1.0, s0=s0)
        b.initial("mass.y", start)
        return build(b.scene(), graph.build(b.scene())).tables.size

    assert size(0.0, length) == pytest.approx(length, rel=1e-9)
    assert size(0.0, s0=length) == length
    assert size(0.0, start=-length) == length


@pytest.mark.parametrize("length", [1e-9, 1.0, 1e6])
def test_redundant_joints_of_any_size(length):
    """Three equal cranks side by side carry a bar: two would do, and a row of the third joint follows from theirs."""
    b = Builder("Cranks")
    ground, bar = b.Ground("ground"), b.Rod("bar", m=1.0, length=2 * length, frames={"c1": (0.0, 0.0)})
    for k, end in enumerate(("a", "c1", "b")):
        crank = b.Rod(f"crank{k}", m=1.0, length=length)
        b.frame(f"f{k}", ground, (k * length, 0.0))
        b.Revolute(f"A{k}", f"f{k}", crank.a)
        b.Revolute(f"B{k}", crank.b, f"bar.{end}")
        b.initial(crank.phi, 1.0, fixed=k == 0)
    b.initial(bar.phi, 0.0, fixed=False)
    b.initial("crank0.w", 1.0)
    _, s = start(b)
    assert len(s.redundant) == 1
    assert s.v[-1] == pytest.approx(1.0, abs=1e-9)
