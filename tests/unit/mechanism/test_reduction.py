"""Bodies that are merged, carried, dropped and split before a scene is solved; the results do not change."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import InitialisationError, IntegrationError
from mbdsl.initial.consistent import initial_state
from mbdsl.mechanism import graph
from mbdsl.mechanism.poses import PlanarPose
from mbdsl.mechanism.reduction import reduce
from mbdsl.system import build

MODELS = Path(__file__).parents[3] / "models"

WELDED = """
model Welded "an L of two rods and a disc, on a pin"
  Ground ground;
  Rod a(m = 2 kg, length = 1 m);
  Rod b(m = 1 kg, length = 0.6 m);
  Body disc(m = 0.5 kg, I = 0.01 kg.m2, com = {0.05, 0.02}, frames(edge = {0.1, 0}));
  Revolute pin(ground, a.a);
  Fixed corner(a.b, b.a, phi0 = 90 deg);
  Fixed bolt(disc.edge, b.b, phi0 = -30 deg);
  SpringDamper spring(ground, disc.c, k = 20 N/m, c = 1 N.s/m, s0 = 1 m);
initial equation
  b.phi = 60 deg;
  b.w = 0.3 rad/s;
  annotation(experiment(StopTime = 1 s));
end Welded;
"""
#: the same bodies as one: sums of masses, moments about the common centre of mass
ONE = """
model One
  Ground ground;
  Body a(m = 3.5 kg, I = {inertia} kg.m2, com = {{ {x}, {y} }}, frames(a = {{-0.5, 0}}, d = {{ {dx}, {dy}, {dphi} }}));
  Revolute pin(ground, a.a);
  SpringDamper spring(ground, a.d, k = 20 N/m, c = 1 N.s/m, s0 = 1 m);
initial equation
  a.phi = -30 deg;
  a.w = 0.3 rad/s;
  annotation(experiment(StopTime = 1 s));
end One;
"""


def simulate(scene, **given):
    """With fixed steps, so that runs of different code take the same ones."""
    return mbdsl.simulate(scene, **{"step": scene.experiment.step or 1e-3, **given})


def reduction(text):
    return reduce(graph.build(mbdsl.parse(text)))


def actions(found):
    return [(note.action, note.names) for note in found.notes]


def test_poses():
    a, b = PlanarPose(1.0, 2.0, 0.3), PlanarPose(-0.4, 0.7, -1.1)
    assert a.inverse() @ a == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)
    x, y, phi = a @ b
    assert phi == pytest.approx(-0.8)
    assert complex(x, y) == pytest.approx(complex(1, 2) + np.exp(0.3j) * complex(-0.4, 0.7))


# -- welds ---------------------------------------------------------------------------------------------------------


def test_welded_bodies_become_one():
    found = reduction(WELDED)
    assert actions(found) == [("merged", ("b", "a", "disc"))]  # b has an initial value
    (part,) = found.parts
    assert (part.graph.coordinates, part.graph.rows) == (3, 2)
    assert set(found.notes[0].by) == {"corner", "bolt"}


def hand_made():
    """Mass points of the welded bodies in the axes of a, and the single body that they make."""
    corner = complex(0.5, 0.0)
    end_of_b = corner + 0.6j
    angle = np.pi / 2 + np.pi / 6  # of the disc: phi_b - phi_edge = -30 deg
    edge_to_com = complex(-0.05, 0.02) * np.exp(1j * angle)
    disc = end_of_b + edge_to_com
    parts = [(2.0, 0j, 2.0 / 12), (1.0, corner + 0.3j, 0.36 / 12), (0.5, disc, 0.01)]
    com = sum(m * r for m, r, _ in parts) / 3.5
    inertia = sum(I + m * abs(r - com) ** 2 for m, r, I in parts)
    return ONE.format(
        inertia=float(inertia),
        x=float(com.real),
        y=float(com.imag),
        dx=float(disc.real),
        dy=float(disc.imag),
        dphi=float(angle),
    ), disc


def test_welded_bodies_move_as_the_sum_of_them():
    text, _ = hand_made()
    a, b = simulate(mbdsl.parse(WELDED)), simulate(mbdsl.parse(text))
    finer = simulate(mbdsl.parse(WELDED), step=5e-4)
    assert a.system.n == 9
    assert a.stats["solved"] == {"n": 3, "m": 2, "p": 0, "parts": 1}
    for one, other in (("a.phi", "a.phi"), ("disc.c.x", "a.d.x"), ("disc.w", "a.w"), ("pin.fx", "pin.fx")):
        # Newton's iteration ends at another point. Each run leaves 1.2e-4 of the local error of a step in positions
        # (1e-5 of h^2 times the second difference of a, of which a twelfth is the error), two runs twice that: ten
        # times that is allowed, as contractions are estimates.
        error = np.abs(a[one] - finer[one]).max() * 4 / 3
        assert np.abs(a[one] - b[other]).max() < 2.4e-3 * error, one
    lost, other, least = (x["energy.total"] - x["energy.total"][0] for x in (a, b, finer))
    assert np.abs(lost - other).max() < 2.4e-3 * np.abs(lost - least).max()
    assert np.abs(a["b.phi"] - a["a.phi"] - np.pi / 2).max() < 1e-14


def test_reactions_of_welds_are_there_when_asked_for():
    """The force and torque of a weld that is cut accelerate the bodies attached to it."""
    a = simulate(mbdsl.parse(WELDED))
    assert np.isnan(a._lam).any()  # nothing is computed before
    spring = np.stack([a["disc.c.x"], a["disc.c.y"]]) / a["spring.s"] * a["spring.force"]
    force = 0.5 * np.stack([a["disc.ax"], a["disc.ay"] + 9.81]) + spring  # on the disc: without spring and weight
    # reactions act on frame_b, here of b
    assert np.abs(a["bolt.fx"] + force[0]).max() < 1e-9 * np.abs(force).max()
    assert np.abs(a["bolt.fy"] + force[1]).max() < 1e-9 * np.abs(force).max()
    lever = np.stack([a["b.b.x"] - a["disc.c.x"], a["b.b.y"] - a["disc.c.y"]])
    torque = 0.01 * a["disc.alpha"] - (lever[0] * force[1] - lever[1] * force[0])
    assert np.abs(a["bolt.tau"] + torque).max() < 1e-9


def test_merged_and_general_go_to_the_same_limit():
    """Not to rounding: the discretised motion depends on the coordinates."""
    gaps = []
    for h in (2e-3, 1e-3, 5e-4):
        a, b = (simulate(mbdsl.parse(WELDED), step=h, general=general) for general in (False, True))
        assert b.stats["solved"]["n"] == 9
        gaps.append([np.abs(a[name] - b[name]).max() for name in ("a.phi", "disc.w", "pin.fy", "corner.tau")])
    slopes = np.log2(np.array(gaps[:-1]) / gaps[1:])
    assert np.all((slopes > 1.85) & (slopes < 2.15))


def test_what_is_welded_to_the_ground_is_ground():
    text = """
    model Bracket
      Ground ground;
      Rod post(m = 5 kg, length = 2 m);
      Rod arm(m = 1 kg, length = 0.5 m);
      Rod swing(m = 1 kg, length = 1 m);
      Fixed foot(ground, post.a, phi0 = 90 deg);
      Fixed top(post.b, arm.a, phi0 = -90 deg);
      Revolute pin(arm.b, swing.a);
      SpringDamper idle(ground, arm.b, k = 100 N/m);
    initial equation
      swing.phi = 0 rad;
      annotation(experiment(StopTime = 0.5 s));
    end Bracket;
    """
    found = reduction(text)
    assert actions(found) == [("grounded", ("post", "arm")), ("dropped", ("idle",))]
    a = simulate(mbdsl.parse(text))
    assert a.stats["solved"] == {"n": 3, "m": 2, "p": 0, "parts": 1}
    assert np.abs(a["arm.b.y"] - 2.0).max() < 1e-15
    assert np.abs(a["arm.b.x"] - 0.5).max() < 1e-15
    assert np.abs(a["arm.phi"]).max() < 1e-15
    alone = simulate(
        mbdsl.parse(
            "model Alone Ground ground; Frame top(ground, r = {0.5 m, 2 m}); Rod swing(m = 1 kg, length = 1 m);"
            "Revolute pin(top, swing.a); initial equation swing.phi = 0 rad;"
            "annotation(experiment(StopTime = 0.5 s)); end Alone;"
        )
    )
    finer = simulate(mbdsl.parse(text), step=5e-4)
    assert np.abs(a["swing.phi"] - alone["swing.phi"]).max() < 1e-3 * np.abs(a["swing.phi"] - finer["swing.phi"]).max()
    # the foot carries the weights, the inertia forces, and the spring, which pulls the arm's end down by k y; the force
    # of the pin is found by the method, of order 2, and that of the foot follows from the motion
    gaps = []
    for h in (2e-3, 1e-3):
        a = simulate(mbdsl.parse(text), step=h)
        gaps.append(np.abs(a["foot.fy"] - (6 * 9.81 + a["pin.fy"] + 100 * 2.0)).max())
    assert gaps[1] < 1e-6 * 283
    assert 1.85 < np.log2(gaps[0] / gaps[1]) < 2.15


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ("Torque t(b.c, tau = 0.1*weld.tau);", "a law reads its reactions"),
        ("Revolute twice(a.a, b.b);", "joins the same bodies once more"),
    ],
)
def test_welds_that_are_kept(more, why):
    text = f"""
    model Kept
      Ground ground;
      Rod a(m = 1 kg, length = 1 m);
      Rod b(m = 1 kg, length = 1 m);
      Revolute pin(ground, a.a);
      Fixed weld(a.b, b.a, phi0 = 180 deg);
      {more}
    initial equation
      a.phi = -60 deg;
      annotation(experiment(StopTime = 0.1 s));
    end Kept;
    """
    found = reduction(text)
    assert [(n.action, n.names) for n in found.notes] == [("kept", ("weld",))]
    assert why in found.notes[0].why
    a, b = (simulate(mbdsl.parse(text), general=general) for general in (False, True))
    assert np.array_equal(a.q, b.q)


def test_initial_values_of_what_is_welded_to_the_ground(tmp_path):
    text = """
    model Wrong
      Ground ground;
      Rod post(m = 5 kg, length = 2 m);
      Rod swing(m = 1 kg, length = 1 m);
      Fixed foot(ground, post.a, phi0 = 90 deg);
      Revolute pin(post.b, swing.a);
    initial equation
      post.phi = 80 deg;
      annotation(experiment(StopTime = 0.5 s));
    end Wrong;
    """
    with pytest.raises(InitialisationError, match=r"post.phi = 80 deg is required at the start, but .* it 90 deg"):
        simulate(mbdsl.parse(text))
    assert simulate(mbdsl.parse(text.replace("80 deg", "90 deg"))).status == "done"


# -- drivers -------------------------------------------------------------------------------------------------------

ARM = """
model Arm "a driven arm, its elbow driven from the other side, and a passive link"
  Ground ground;
  Rod upper(m = 1 kg, length = 0.5 m);
  Rod lower(m = 1 kg, length = 0.4 m);
  Rod tip(m = 0.3 kg, length = 0.3 m);
  Revolute shoulder(ground, upper.a);
  RotationalDriver d1(shoulder, phi = 0.5 rad*sin(3 rad/s*time) - 1 rad);
  Revolute elbow(lower.a, upper.b);
  RotationalDriver d2(elbow, phi = 1 rad/s2*time^2);
  Revolute wrist(lower.b, tip.a, mu = 0.1, radius = 0.01 m);
  RotationalSpringDamper idle(ground, lower.c, k = 1 N.m/rad);
initial equation
  tip.phi = -90 deg; tip.w = 0 rad/s;
  annotation(experiment(StopTime = 1 s));
end Arm;
"""


def test_what_drivers_move_is_a_function_of_time():
    found = reduction(ARM)
    assert actions(found) == [("moved", ("upper",)), ("moved", ("lower",)), ("dropped", ("idle",))]
    (part,) = found.parts
    assert list(part.graph.bodies) == ["tip"]


def test_driven_arm():
    """Parts that depend on time alone are as accurate as sin and cos. The tip, and the whole general scene, are solved
    iteratively: each of 1000 steps leaves an error of up to 1e-11 of the size in positions, 8e-12 of the largest
    velocity, and 1e-5 h^2 of the second difference of accelerations, which is 4e-5 of that in reactions
    (docs/methods.md)."""
    a = simulate(mbdsl.parse(ARM), interval=0)
    rounding = 16.0 * np.finfo(float).eps
    first = 0.5 * np.sin(3 * a.t) - 1.0
    second = first - a.t**2  # the elbow counts from the lower arm to the upper one
    elbow = 0.5 * np.exp(1j * first)
    wrist = elbow + 0.4 * np.exp(1j * second)
    assert np.abs(a["upper.b.x"] + 1j * a["upper.b.y"] - elbow).max() < rounding
    assert np.abs(a["lower.b.x"] + 1j * a["lower.b.y"] - wrist).max() < rounding
    assert np.abs(a["lower.w"] - (1.5 * np.cos(3 * a.t) - 2 * a.t)).max() < 2.0 * rounding
    assert np.abs(a["tip.a.x"] + 1j * a["tip.a.y"] - wrist).max() < 1e-11
    b = simulate(mbdsl.parse(ARM), general=True, interval=0)
    assert b.stats["solved"]["n"] == 9
    left = {"tip.phi": 1e-8, "tip.w": 8e-9 * np.abs(b["tip.w"]).max()}
    left |= {f"wrist.{key}": 4e-5 * np.abs(np.diff(b[f"wrist.{key}"], 2)).max() for key in ("fx", "fy")}
    for name, most in left.items():
        assert np.abs(a[name] - b[name]).max() < most, name
    # mu R N tanh(w/w_s): at the reversal, with w_s = 0.01 rad/s, it depends on the remaining w
    normal = np.hypot(b["wrist.fx"], b["wrist.fy"]).max()
    most = 0.1 * 0.01 * (normal * left["tip.w"] / 0.01 + np.hypot(left["wrist.fx"], left["wrist.fy"]))
    assert np.abs(a["wrist.friction"] - b["wrist.friction"]).max() < most


CARRIED = """
model Carried "a driven arm with a slot, in which a point slides, and a hanging rod at its end; no gravity"
  Ground ground(g = 0 m/s2);
  Rod arm(m = 1 kg, length = 2 m);
  Revolute shoulder(ground, arm.a);
  RotationalDriver drive(shoulder, phi = 0.3 rad + 2 rad/s*time + 1.5 rad/s2*time^2);
  PointMass rider(m = 0.5 kg);
  PointOnLine slot(arm.a, rider);
  Rod tip(m = 0.3 kg, length = 0.4 m);
  Revolute wrist(tip.a, arm.b);
initial equation
  slot.s = 0.7 m;
  slot.v = 0.4 m/s;
  tip.phi = 1.1 rad;
  annotation(experiment(StopTime = 1 s));
end Carried;
"""


def test_accelerations_at_the_start_where_drivers_move_frames():
    """A point that slides freely has the acceleration 2 r' w + r w' across the slot and none along it; the end of a rod
    that is accelerated by u across the rod turns it by -3/(2 L) u, as its inertia about that end is m L^2/3."""
    found = {}
    for part in reduction(CARRIED).parts:
        system = build(part.scene, part.graph)
        found.update(zip(system.names(), initial_state(system, part.graph, 0.0).a, strict=True))
    r, r1, w, w1, along = 0.7, 0.4, 2.0, 3.0, np.exp(0.3j)
    rider = 1j * (2 * r1 * w + r * w1) * along
    end = 2.0 * (-(w**2) + 1j * w1) * along
    assert complex(found["rider.x"], found["rider.y"]) == pytest.approx(rider, rel=1e-12)
    assert found["tip.phi"] == pytest.approx(-1.5 / 0.4 * (end * np.exp(-1.1j)).imag, rel=1e-12)


def test_torques_of_drives_follow_from_the_motion():
    """The work of the drivers is in the energy, or lost by friction: computed from reactions for which no system was
    solved."""
    gaps = []
    for h in (2e-3, 1e-3, 5e-4):
        a = simulate(mbdsl.parse(ARM), step=h, stop=0.5, interval=0)
        power = (
            a["d1.tau"] * a["upper.w"]
            - a["d2.tau"] * (a["lower.w"] - a["upper.w"])
            - a["wrist.friction"] * a["wrist.w"]
        )
        work = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2) * h])
        energy = a["energy.total"] - a["energy.total"][0]
        gaps.append(np.abs(work - energy).max() / np.abs(energy).max())
    assert gaps[-1] < 1e-5
    assert np.all(np.log2(np.array(gaps[:-1]) / gaps[1:]) > 1.85)


@pytest.mark.parametrize("extra", ["", "PointMass rider(m = 1 kg); Revolute seat(b.b, rider);"])
def test_everything_driven(extra):
    """Two driven links: nothing remains to be solved; with a point mass on them, only its constraints."""
    text = f"""
    model Driven
      Ground ground;
      Rod a(m = 1 kg, length = 1 m);
      Rod b(m = 1 kg, length = 1 m);
      Prismatic slide(ground, a.a);
      TranslationalDriver d1(slide, s = 0.3 m*time/1 s);
      Revolute pin(a.b, b.a);
      RotationalDriver d2(pin, phi = 1 rad/s*time);
      {extra}
      annotation(experiment(StopTime = 1 s));
    end Driven;
    """
    a = simulate(mbdsl.parse(text))
    assert a.stats["solved"]["n"] == (2 if extra else 0)
    assert a.stats["steps"] == 1000
    end = 1.0 + 0.3 * a.t + np.exp(1j * a.t)
    assert np.abs(a["b.b.x"] + 1j * a["b.b.y"] - end).max() < 1e-14
    assert np.abs(a["b.b.vx"] + 1j * a["b.b.vy"] - 0.3 - 1j * np.exp(1j * a.t)).max() < 1e-14
    if extra:
        assert np.abs(a["rider.x"] + 1j * a["rider.y"] - end).max() < 1e-13
    # the driver carries the attached bodies: torque about the pin by gravity and inertia (zero for constant rotation)
    masses = 1.0 * 0.5 + (1.0 if extra else 0.0)
    assert a["d2.tau"] == pytest.approx(masses * 9.81 * np.cos(a.t), abs=1e-9)


def test_a_body_that_is_held_twice_is_not_carried():
    text = """
    model Twice
      Ground ground;
      Frame far(ground, r = {1 m, 0});
      Rod a(m = 1 kg, length = 1 m);
      Revolute pin(ground, a.a);
      RotationalDriver d(pin, phi = 0 rad);
      Revolute other(far, a.b);
      annotation(experiment(StopTime = 0.1 s));
    end Twice;
    """
    found = reduction(text)
    assert found.notes == ()
    assert simulate(mbdsl.parse(text)).stats["redundant"] == ["other.Phi[1]", "d.Phi[1]"]


def test_kinematics_of_a_truss():
    """As many constraints as coordinates without any driver: it stands still under any load."""
    text = """
    model Truss
      Ground ground;
      Frame right(ground, r = {1 m, 0});
      Rod a(m = 1 kg, length = 1 m);
      Rod b(m = 1 kg, length = 1 m);
      Revolute A(ground, a.a);
      Revolute B(right, b.a);
      Revolute C(a.b, b.b);
      Force load(a.b, fy = -100 N);
    initial equation
      guess a.phi = 50 deg;
      guess b.phi = 130 deg;
      annotation(experiment(StopTime = 0.1 s));
    end Truss;
    """
    found = reduction(text)
    assert actions(found) == [("kinematic", ("a", "b"))]
    a = simulate(mbdsl.parse(text))
    assert a["a.b.y"] == pytest.approx(np.sqrt(0.75), abs=1e-14)
    assert np.abs(a.v).max() < 1e-11  # Newton's floor is 4 eps size/h = 2e-12, before Phi_q^-1 magnifies it
    # each foot carries half of the load and of the weights
    assert a["A.fy"] == pytest.approx(50 + 9.81, abs=1e-9)


def test_what_only_counts_as_kinematic_is_solved_as_it_moves():
    """A parallelogram of three equal rockers: one constraint too many, one degree of freedom; counting does not show
    it."""
    text = """
    model Parallelogram
      Ground ground;
      Rod a(m = 1 kg, length = 1 m);
      Rod b(m = 1 kg, length = 1 m);
      Rod c(m = 1 kg, length = 1 m);
      Rod top(m = 1 kg, length = 2 m, frames(mid = {0, 0}));
      Frame f1(ground, r = {1 m, 0});
      Frame f2(ground, r = {2 m, 0});
      Revolute A(ground, a.a);
      Revolute B(f1, b.a);
      Revolute C(f2, c.a);
      Revolute D(a.b, top.a);
      Revolute E(b.b, top.mid);
      Revolute F(c.b, top.b);
    initial equation
      a.phi = 60 deg;
      guess b.phi = 60 deg;
      guess c.phi = 60 deg;
      annotation(experiment(StopTime = 0.5 s));
    end Parallelogram;
    """
    assert reduction(text).parts[0].kinematic
    a = simulate(mbdsl.parse(text))
    assert len(a.stats["redundant"]) == 1
    assert np.ptp(a["a.phi"]) > 0.1
    b = simulate(mbdsl.parse(text), general=True)
    assert np.abs(a.q - b.q).max() < 1e-12


# -- parts ---------------------------------------------------------------------------------------------------------

TWO = """
model Two "two pendulums that know nothing of each other"
  input Torque u(start = 0);
  Ground ground;
  Rod a(m = 1 kg, length = 1 m);
  Rod b(m = 1 kg, length = 0.3 m);
  Revolute A(ground, a.a);
  Revolute B(ground, b.a);
  Torque push(b.c, tau = u);
  {more}
initial equation
  a.phi = 10 deg;
  {initial}
  annotation(experiment(StopTime = 1 s));
end Two;
"""
ALONE = """
model Alone
  Ground ground;
  Rod a(m = 1 kg, length = 1 m);
  Revolute A(ground, a.a);
initial equation
  a.phi = 10 deg;
  annotation(experiment(StopTime = 1 s));
end Alone;
"""


def test_independent_parts_are_integrated_by_themselves():
    text = TWO.format(more="", initial="b.phi = 20 deg;")
    found = reduction(text)
    assert actions(found) == [("split", ("a",)), ("split", ("b",))]
    two, alone = simulate(mbdsl.parse(text)), simulate(mbdsl.parse(ALONE))
    assert two.stats["solved"]["parts"] == 2
    assert two.stats["steps"] == 1000
    assert np.array_equal(two["a.phi"], alone["a.phi"])
    assert np.array_equal(two["A.fx"], alone["A.fx"])
    assert np.isfinite(two.lam).all()
    assert two.stats["iterations"] > alone.stats["iterations"]


def test_parts_that_are_assembled_together_stay_together():
    found = reduction(TWO.format(more="Real d = b.phi - a.phi;", initial="d = 20 deg;"))
    assert len(found.parts) == 1
    assert found.notes == ()


def test_inputs_reach_the_part_that_reads_them():
    s = mbdsl.Simulation(mbdsl.parse(TWO.format(more="", initial="b.phi = 20 deg;")), step=1e-3)
    s.inputs["u"] = 5.0
    s.step(100)
    u = simulate(mbdsl.parse(TWO.format(more="", initial="b.phi = 20 deg;").replace("start = 0", "start = 5")))
    assert s["b.phi"] == pytest.approx(u["b.phi"][np.abs(u.t - 0.1).argmin()], abs=1e-6)
    assert s.q.shape == (6,)
    assert s.trajectory()["B.fx"].shape == (101,)


def test_where_one_part_fails_all_end():
    text = TWO.format(more="Force f(b.b, fx = 1 N*sqrt(0.5 - time/1 s));", initial="b.phi = 20 deg;")
    with pytest.raises(IntegrationError, match=r"t = 0\.50") as failure:
        simulate(mbdsl.parse(text), interval=1e-3)
    found = failure.value.trajectory
    assert found.status == "failed"
    assert found.t[-1] == pytest.approx(0.5, abs=2e-3)
    assert np.isfinite(found["a.phi"]).all()


def test_many_welds_take_no_time_to_find():
    """A thousand rods with a weight welded to each end: 3000 bodies, merged to 1000."""
    text = """
    model Many
      parameter Integer N = 1000;
      Ground ground;
      Rod rod[N](each m = 1 kg, each length = 1 m);
      Body left[N](each m = 1 kg, each I = 0.1 kg.m2);
      Body right[N](each m = 1 kg, each I = 0.1 kg.m2);
      Revolute J[1](ground, rod[1].a);
      for i in 2:N loop
        Revolute J[i](rod[i - 1].b, rod[i].a);
      end for;
      for i in 1:N loop
        Fixed l[i](rod[i].a, left[i].c);
        Fixed r[i](rod[i].b, right[i].c);
      end for;
      annotation(experiment(StopTime = 1 s));
    end Many;
    """
    found = reduction(text)
    assert len(found.notes) == 1000
    assert found.parts[0].graph.coordinates == 3000
    assert found.parts[0].graph.scene.components["rod[7]"].values["m"] == 3.0


# -- found by reviews ----------------------------------------------------------------------------------------------


def test_kinematics_with_too_large_steps_says_so():
    """Newton's iteration finds another assembly if the step is large: a crank that turns by a radian a step."""
    text = """
    model Quick
      Ground ground;
      Frame right(ground, r = {0.8 m, 0});
      Rod a(m = 1 kg, length = 0.3 m);
      Rod b(m = 2 kg, length = 0.9 m);
      Rod c(m = 1 kg, length = 0.7 m);
      Revolute A(ground, a.a);
      Revolute B(a.b, b.a);
      Revolute C(b.b, c.b);
      Revolute D(right, c.a);
      RotationalDriver d(A, phi = 50 deg + 1000 rad/s*time);
    initial equation
      guess a.phi = 50 deg;
      guess b.phi = 20 deg;
      guess c.phi = 70 deg;
      annotation(experiment(StopTime = 30 ms));
    end Quick;
    """
    with pytest.raises(IntegrationError, match="the step is so large"):
        simulate(mbdsl.parse(text), step=1e-3)
    fine = simulate(mbdsl.parse(text), step=1e-4, interval=1e-3)
    a = 0.3 * np.exp(1j * (np.deg2rad(50) + 1000 * fine.t))
    assert fine["c.phi"].min() > 1.2 and fine["c.phi"].max() < 2.4
    assert np.abs(a + 0.9 * np.exp(1j * fine["b.phi"]) - 0.8 - 0.7 * np.exp(1j * fine["c.phi"])).max() < 1e-13


@pytest.mark.parametrize("said", ["", "lo.b.x = 0.55 m;", "guess up.phi = 20 deg; lo.b.vx = 1 m/s;"])
def test_what_is_not_said_does_not_depend_on_welds(said):
    """No initial value determines the velocity of the welded pair: it is the smallest possible, counting each of its
    bodies."""
    text = f"""
    model Unsaid
      Ground ground;
      Rod bar(m = 3 kg, length = 1 m);
      Rod up(m = 1 kg, length = 0.5 m);
      Rod lo(m = 0.5 kg, length = 0.25 m);
      Revolute p(ground, bar.a);
      RotationalDriver d(p, phi = 0.5 rad*sin(4 rad/s*time));
      Fixed weld(up.b, lo.a, phi0 = -20 deg);
      Revolute hip(bar.b, up.a);
    initial equation
      {said}
      annotation(experiment(StopTime = 1 ms));
    end Unsaid;
    """
    a, b = (simulate(mbdsl.parse(text), general=general) for general in (False, True))
    assert b.stats["solved"]["n"] == 9 and a.stats["solved"]["n"] == 3
    assert np.abs(b.v[0]).max() > 0.1
    assert np.abs(a.q[0] - b.q[0]).max() < 1e-7  # near a flat minimum, the position is known to the root of rounding
    assert np.abs(a.v[0] - b.v[0]).max() < 1e-7


def test_a_look_back_does_not_disturb_what_runs():
    def run(look):
        s, old = mbdsl.Simulation(mbdsl.parse(TWO.format(more="", initial="b.phi = 20 deg;")), step=1e-2), None
        for u in (5.0, -4.0, 7.0):
            s.inputs["u"] = u
            s.step(3)
            old = old or s.trajectory()
            if look:
                assert old["b.ax"].shape == (4,)
        return s["b.phi"], s["b.w"]

    assert run(True) == run(False)


@pytest.mark.parametrize(("first", "second"), [(1.3, 9.0), (9.0, 1.3)])
def test_nothing_that_was_computed_is_lost_when_a_part_fails(first, second):
    text = f"""
    model Ending
      Ground ground;
      Rod a(m = 1 kg, length = 0.3 m);
      Rod b(m = 2 kg, length = 0.5 m);
      Revolute A(ground, a.a);
      Revolute B(ground, b.a);
      Torque s(a.c, tau = 1 N.m*sqrt({first} - time/(1 s)));
      Torque t(b.c, tau = 1 N.m*sqrt({second} - time/(1 s)));
      annotation(experiment(StopTime = 20 s, Interval = 0.1 s));
    end Ending;
    """
    broken = "s" if first < second else "t"
    with pytest.raises(IntegrationError, match=f"`{broken}.tau` has no value at time") as failure:
        simulate(mbdsl.parse(text), step=1e-3)
    assert failure.value.trajectory.t[-1] == pytest.approx(1.3, abs=2e-3)
    s = mbdsl.Simulation(mbdsl.parse(text), step=1e-2)
    for _ in range(3):
        with pytest.raises(IntegrationError):
            s.step(200)
        assert 1.3 - 2 * s.h < s.time <= 1.3  # the last step before the law ends


def test_a_point_without_reactions_costs_only_itself():
    """A stretched parallelogram: its positions are known there, its reactions are not."""
    text = """
    model Flat
      Ground ground;
      Frame right(ground, r = {1 m, 0});
      Rod a(m = 1 kg, length = 0.5 m);
      Rod b(m = 1 kg, length = 1 m);
      Rod c(m = 1 kg, length = 0.5 m);
      Revolute A(ground, a.a);
      Revolute B(a.b, b.a);
      Revolute C(b.b, c.b);
      Revolute D(right, c.a);
      RotationalDriver d(A, phi = 0.4 rad - 4 rad/s*time);
    initial equation
      guess a.phi = 0.4 rad;
      guess c.phi = 0.4 rad;
      annotation(experiment(StopTime = 0.2 s, Step = 1 ms, Interval = 1 ms));
    end Flat;
    """
    found = simulate(mbdsl.parse(text))
    bad = np.flatnonzero(~np.isfinite(found["A.fx"]))
    assert found.undetermined == found.t[bad].tolist()
    assert len(bad) <= 1
    assert np.abs(found["c.phi"] - (0.4 - 4 * found.t)).max() < 1e-6
