"""Mechanisms in space that can only move in a plane: solved as planar ones, against the equations in space.

The coordinates of a plane are isometric to those in space, and exponentials about one axis add: the numbers are those
of the equations in space up to the errors that Newton's iteration leaves. Reactions of the planar run follow from its
motion, so that they are compared with those that follow from the motion of the other run; reactions out of the plane
are also compared with closed forms.
"""

import re
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.elements import find, kinds
from mbdsl.errors import MbdslError
from mbdsl.mechanism import graph
from mbdsl.mechanism.reduction import reduce
from mbdsl.mechanism.reduction.planar_motion import _writer
from mbdsl.simulation.trajectory import Trajectory

MODELS = Path(__file__).parents[2] / "models"
TURN = 2.0 * np.pi

TILTED = """spatial model Tilted "A slider crank in the plane with the normal {1, 2, 2}, with products of inertia"
  parameter Length h = HEIGHT "height of the slider over the crank's hinge";
  Ground ground(n = {0.6, -0.8, 0}, frames(o = {0.1, 0.2, 0.3}, slide = {0.1 m + h/3, 0.2 m + 2*h/3, 0.3 m + 2*h/3}));
  Box crank(m = 1 kg, length = 0.3 m, width = 0.05 m, height = 0.03 m);
  Body rod(m = 2 kg, I = {{0.05, 0.01, -0.02}, {0.01, 0.08, 0.02}, {-0.02, 0.02, 0.07}} kg.m2, com = {0.05, 0, 0.02},
           frames(p = {-0.4, 0, 0.01}, q = {0.4, 0, 0.01}));
  Sphere slider(m = 1.5 kg, radius = 0.1 m);
  Frame a(crank.a, n = {0.3, 1, 0.5}, phi = 50 deg);
  Frame b(crank.b, n = {0.3, 1, 0.5}, phi = 50 deg);
  Revolute O(ground.o, a, n = {1, 2, 2});
  Revolute A(b, rod.p, n = {1, 2, 2});
  Revolute B(rod.q, slider.c, n = {1, 2, 2});
  Prismatic S(ground.slide, slider.c, n = {2, -2, 1});
initial equation
  O.phi = 30 deg;
  O.w = 8 rad/s;
end Tilted;"""

# the normal in axes of the crank, whose x axis leads from one hinge to the next, and in those of the rod
NORMAL, AXIS = np.array([1.0, 2.0, 2.0]) / 3.0, np.array([0.3, 1.0, 0.5]) / np.sqrt(1.34)
ALONG_CRANK = (
    np.cos(np.radians(50.0)) * NORMAL
    + np.sin(np.radians(50.0)) * np.cross(AXIS, NORMAL)
    + (1.0 - np.cos(np.radians(50.0))) * (AXIS @ NORMAL) * AXIS
)[0]
TILTED = TILTED.replace("HEIGHT", f"{float(0.3 * ALONG_CRANK + 0.8 * NORMAL[0])!r} m")

LAWS = """spatial model Laws "Laws of joints and bodies, axes of opposite sense, turns, an input, a switch"
  input Real u(start = 2);
  Ground ground(frames(w = {1, 0.5, 0}));
  Body one(m = 2 kg, I = {0.1, 0.2, 0.3} kg.m2, frames(p = {-0.3, 0, 0}, q = {0.3, 0, 0.1}, s = {0, 0.1, 0}));
  Body two(m = 1 kg, I = {0.1, 0.2, 0.3} kg.m2, frames(p = {-0.3, 0, 0}, q = {0.3, 0, 0}));
  Frame flip(two.p, n = {1, 0, 0}, phi = 180 deg);
  Revolute O(ground, one.p);
  Revolute A(one.q, flip, n = {0, 0, -1});
  RotationalSpringDamper linear(one.q, flip, n = {0, 0, -1}, k = 3 N.m/rad, c = 0.1 N.m.s/rad, phi0 = 10 deg);
  RotationalSpringDamper law(ground, one.p, torque = (0.2 N.m)*law.phi + (0.1 N.m.s)*law.w);
  SpringDamper spring(ground.w, one.s, k = 50 N/m, c = 1 N.s/m, s0 = 0.5 m);
  RotationalStop limit(ground, one.p, phi_max = 13.15 rad, k = 40 N.m/rad);
  FreeMotion measured(ground, two.c);
  Torque between(one.q, flip, n = {0, 0, -1},
               tau = u*(1 N.m)*cos((3 rad/s)*time) - (0.3 N.m.s)*A.w + (0.2 N.m)*O.phi);
  Torque skew(one.p, n = {0.6, 0, 0.8},
              tau = 0.5 N.m - (0.1 N.m.s)*one.wz + (0.3 N)*two.x + (0.1 N)*two.z + (0.3 N.m)*two.c.phi);
  Force fixed(one.q, fx = 1 N, fy = if time < 0.1235 then 2 N else -3 N, fz = 30 N + (1 N.s/m)*two.vy);
  Force follows(two.q, two.q, fx = 1 N, fy = (2 N)*sin((1 rad/s)*time), fz = 3 N);
initial equation
  O.phi = 750 deg;
  A.phi = -20 deg;
  A.w = 2 rad/s;
end Laws;"""

SLIDERS = """spatial model Sliders "Two sliders, across each other"
  Ground ground;
  Body one(m = 2 kg, I = {0.1, 0.2, 0.3} kg.m2);
  Body two(m = 1 kg, I = {0.1, 0.2, 0.3} kg.m2);
  Prismatic P(ground, one.c, n = {1, 1, 0.2});
  Prismatic Q(one.c, two.c, n = {-1, 1, 0.3});
  TranslationalSpringDamper k(ground, one.c, n = {1, 1, 0.2}, k = 20 N/m, c = 0.1 N.s/m, s0 = 0.1 m);
  TranslationalSpringDamper l(one.c, two.c, n = {-1, 1, 0.3}, force = (30 N/m)*l.s + (1 N.s/m)*l.v);
initial equation
  P.s = 0.2 m;
  Q.v = 1 m/s;
end Sliders;"""

PUCKS = """spatial model Pucks "A box slides on an inclined plane, another one is hinged to it"
  Ground ground;
  Box one(m = 2 kg, length = 0.3 m, width = 0.2 m, height = 0.1 m);
  Box two(m = 2 kg, length = 0.3 m, width = 0.2 m, height = 0.1 m);
  Planar P(ground, one.a, n = {1, 2, 2});
  Revolute W(one.b, two.a, n = {1, 2, 2});
  Force f(two.b, fx = 5 N, fy = 20 N, fz = (1 N.s)*P.w);
initial equation
  P.phi = 3 rad;
  P.w = 5 rad/s;
end Pucks;"""

FOUR_BAR = """spatial model FourBar "A four-bar linkage about y, with hinges of both senses"
  Ground ground(n = {0, 0, -1}, frames(d = {1.2, 0, 0}));
  Rod a(m = 1 kg, length = 0.4 m);
  Box b(m = 2 kg, length = 1 m, width = 0.1 m, height = 0.1 m);
  Rod c(m = 1 kg, length = 0.8 m);
  Revolute O(ground, a.a, n = {0, 1, 0});
  Revolute A(a.b, b.a, n = {0, 1, 0});
  Revolute B(b.b, c.b, n = {0, 1, 0});
  Revolute C(ground.d, c.a, n = {0, -1, 0});
initial equation
  guess O.phi = -1 rad;
  O.w = 3 rad/s;
end FourBar;"""

PAIR = """spatial model Pair "A gyroscope, and a slider crank with a driver, which nothing joins"
  Ground ground(frames(far = {3, 0, 0}));
  Body top(m = 15 kg, I = {0.234375, 0.46875, 0.234375} kg.m2, frames(foot = {0, 1, 0} m));
  Spherical ball(ground, top.foot);
  Rod crank(m = 1 kg, length = 0.3 m);
  Rod rod(m = 1 kg, length = 0.8 m);
  PointMass slider(m = 1 kg);
  Revolute O(ground.far, crank.a, n = {0, 1, 0});
  Revolute A(crank.b, rod.a, n = {0, 1, 0});
  Spherical B(rod.b, slider);
  PointOnLine S(ground.far, slider, n = {1, 0, 0});
  RotationalVelocityDriver d(ground.far, crank.a, n = {0, 1, 0}, w = 5 rad/s - 0.1*rod.wy);
initial equation
  top.y = -1 m;
  top.wx = 1 rad/s;
  top.wy = 10 rad/s;
  top.wz = 2 rad/s;
  guess slider.x = 4.1 m;
  O.phi = 0.3 rad;
end Pair;"""

HINGED = """spatial model Hinged "A body on a hinge whose axis is tilted against gravity"
  Ground ground(n = {0, 0, -1});
  Body door(m = 20 kg, I = {{2, 0.1, 0.2}, {0.1, 1, 0.3}, {0.2, 0.3, 3}} kg.m2, com = {0.4, 0.01, 0.02},
            frames(edge = {0, 0, 0}));
  Revolute hinge(ground, door.edge, n = {0.1, 0, 1});
initial equation
  hinge.phi = 80 deg;
  hinge.w = 0.3 rad/s;
end Hinged;"""


def in_space(name):
    text = (MODELS / f"{name}.mbd").read_text(encoding="utf-8")
    return re.sub(r"^(partial )?model", "spatial model", text, flags=re.MULTILINE)


def planar(name):
    """A planar model put into space, and the numbers n and m of its planar equations."""
    return in_space(name), {"four_bar": (15, 14), "driven_crank": (5, 5), "chain": (24, 16)}.get(name, (6, None))


def follows(trajectory):
    """The trajectory with reactions that follow from its motion."""
    t = trajectory
    return Trajectory(t.system, t.t, t.q, t.v, None, dict(t.stats), (), t.left_out, t.inputs)


def compared(scene, bound, without=None, **given):
    """Run in the plane and in space, and compare all signals, relative to their largest value, of a vector to that of
    all its components, and to 1, but those whose names match ``without``."""
    given = {"step": 1e-3, "stop": 0.4, "interval": 0.02} | given
    flat, solid = (mbdsl.simulate(scene, general=general, **given) for general in (False, True))
    assert solid.stats["solved"]["n"] == solid.system.n
    for key in ("redundant", "not unique"):
        assert flat.stats[key] == solid.stats[key]
    one, other = follows(flat), follows(solid)
    for name in one.names:
        owner, _, key = name.rpartition(".")
        if without and re.search(without, name):
            continue
        difference = one[name] - other[name]
        if key.startswith("phi_") or (key == "phi" and f"{owner}.wx" in other):
            difference -= TURN * np.round(difference / TURN)  # these may jump by turns where an axis is upright
        alike = [f"{owner}.{key[:-1]}{i}" for i in "xyz"] if key[-1] in "xyz" else [name]
        scale = max(1.0, *(np.nanmax(np.abs(other[x])) for x in alike if x in other))
        np.testing.assert_allclose(difference, 0.0, rtol=0, atol=bound * scale, err_msg=name)
    return flat, solid


# -- against the equations in space ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["double_pendulum", "slider_crank", "chain", "four_bar", "driven_crank"])
def test_planar_models_in_space(name):
    """Newton's iteration leaves 1e-8 of reactions that do not depend on the stiffness of springs."""
    text, (n, m) = planar(name)
    flat, _ = compared(mbdsl.parse(text), 1e-7, stop=0.2)
    solved = flat.stats["solved"]
    assert solved["n"] == n
    assert m is None or solved["m"] == m


@pytest.mark.parametrize(
    ("text", "n"),
    [(TILTED, 9), (LAWS, 6), (SLIDERS, 6), (PUCKS, 6), (FOUR_BAR, 9), (PAIR, 14), (HINGED, 3)],
    ids=lambda x: x.split()[2] if isinstance(x, str) else "",
)
def test_against_the_equations_in_space(text, n):
    # the assembly of all bodies at once leaves the gyroscope's attitude, which nothing but its guess says, off by 1e-9
    flat, _ = compared(mbdsl.parse(text), 1e-6 if text is PAIR else 1e-7)
    assert flat.stats["solved"]["n"] == n


def test_joints_without_redundant_constraints():
    """A linkage with a ball joint and a cylindrical joint, as is usual in space, can move in the plane only, too."""
    text = FOUR_BAR.replace("Revolute A(a.b, b.a, n = {0, 1, 0})", "Spherical A(a.b, b.a)")
    text = text.replace("Revolute B(b.b, c.b, n = {0, 1, 0})", "Cylindrical B(b.b, c.b, n = {0, 1, 0})")
    flat, _ = compared(mbdsl.parse(text), 1e-7)
    assert flat.stats["solved"]["n"] == 9 and not flat.stats["redundant"]


def test_slots_along_the_normal():
    """Oldham's coupling, whose driving shaft is a function of time; Cardan angles of frames along x are singular."""
    flat, _ = compared(mbdsl.load(MODELS / "space" / "oldham_coupling.mbd"), 1e-7, r"phi_|w_[xyz]$", stop=0.2)
    assert flat.stats["solved"]["n"] == 6


@pytest.mark.parametrize("method", ["nstiff", "dop853", "radau5"])
def test_other_methods(method):
    compared(mbdsl.parse(LAWS), 1e-7, method=method)


def test_third_party_integrators():
    """LSODA in the plane, and with all equations in space, within ten times its tolerance of a precise run in space."""
    scene = mbdsl.parse(TILTED)
    solid = mbdsl.simulate(scene, method="dop853", step=1e-3, stop=0.3, interval=0.1, general=True)
    for general in (False, True):
        run = mbdsl.simulate(scene, method="scipy-lsoda", tol=1e-8, stop=0.3, interval=0.1, general=general)
        for name in ("rod.x", "rod.y", "rod.z", "S.s", "O.phi"):
            np.testing.assert_allclose(run[name], solid[name], rtol=0, atol=1e-7, err_msg=name)


# -- reactions out of the plane, by closed forms ---------------------------------------------------------------------


def test_bearing_moments_of_an_unbalanced_rotor():
    """A rotor that turns about z with w has the moment of momentum (Jxz, Jyz, Jzz) w in its axes, whose rate is
    w^2 (-Jyz, Jxz, 0): the bearing's moment."""
    scene = mbdsl.parse("""spatial model Rotor
      Ground ground(g = 0);
      Body rotor(m = 3 kg, I = {{2, 0, 0.3}, {0, 2, -0.2}, {0.3, -0.2, 1}} kg.m2);
      Revolute bearing(ground, rotor.c);
    initial equation
      bearing.w = 7 rad/s;
    end Rotor;""")
    t = mbdsl.simulate(scene, step=1e-3, stop=1.0, interval=0.05)
    assert t.stats["solved"] == {"n": 3, "m": 2, "p": 0, "parts": 1}
    c, s = np.cos(7.0 * t.t), np.sin(7.0 * t.t)
    x, y = 49.0 * 0.2, 49.0 * 0.3
    np.testing.assert_allclose(t["bearing.tx"], c * x - s * y, atol=1e-9)  # rounding of 18 N.m and of the angle
    np.testing.assert_allclose(t["bearing.ty"], s * x + c * y, atol=1e-9)


def test_axial_force_of_a_tilted_pendulum():
    """Nothing accelerates along the axis: the hinge carries the weight's part along it."""
    t = mbdsl.simulate(mbdsl.parse(HINGED), step=1e-3, stop=1.0, interval=0.05)
    axis = np.array([0.1, 0.0, 1.0]) / np.hypot(0.1, 1.0)
    force = np.transpose([t[f"hinge.f{i}"] for i in "xyz"]) @ axis
    np.testing.assert_allclose(force, 20.0 * 9.81 * axis[2], rtol=1e-12)


# -- what is reduced -------------------------------------------------------------------------------------------------


def notes(text):
    return [(note.action, note.names) for note in reduce(graph.build(mbdsl.parse(text))).notes]


def test_explain_and_check(tmp_path, capsys):
    """`explain` names the bodies and the plane; `check` counts in space, as without the reduction."""
    path = tmp_path / "tilted.mbd"
    path.write_text(
        TILTED.replace("end Tilted", "annotation(experiment(StopTime = 1 s)); end Tilted"), encoding="utf-8"
    )
    assert main(["explain", str(path)]) == 0
    text = capsys.readouterr().out
    assert "solved for: n = 9, m = 8, p = 0, in 1 part" in text
    assert "planar: crank, rod, slider: can only move in planes with the normal {0.333333, 0.666667, 0.666667}" in text
    assert main(["check", str(path)]) == 0
    text = capsys.readouterr().out
    assert "mobility -2 = 18 coordinates - 20 constraint rows" in text
    assert "true mobility 1 = 18 coordinates - 17 independent constraint rows" in text


def test_parts_are_examined_alone():
    found = notes(PAIR)
    assert ("planar", ("crank", "rod", "slider")) in found
    assert not any("top" in names for action, names in found if action == "planar")


FREE = """spatial model Free
  Ground ground(g = 0);
  Body body(m = 1 kg, I = {1, 2, 3} kg.m2, frames(p = {0.1, 0, 0}, q = {0, 0, 0.5}));
  %s
end Free;"""


@pytest.mark.parametrize(
    "joints",
    [
        "Force f(body.c, fx = 1 N);",  # moves in a plane, but nothing keeps it there
        "Spherical p(ground, body.c); Torque t(body.c, tau = 1 N.m);",
        "PointOnPlane p(ground, body.c);",
        "Cylindrical p(ground, body.c, n = {0, 0, 1});",
        "Revolute p(ground, body.c, mu = 0.1, radius = 1 cm);",  # friction depends on the axial force
        "Revolute p(ground, body.c); Torque t(body.c, tau = (1 m)*p.fz);",
        "Revolute p(ground, body.c); VelocityConstraint v(gamma = body.wx);",
    ],
)
def test_motions_that_may_leave_a_plane_are_not_reduced(joints):
    assert not any(action == "planar" for action, _ in notes(FREE % joints))


def test_hinges_with_axes_that_are_not_parallel():
    text = (
        FREE % "Body other(m = 1 kg, I = {1, 2, 3} kg.m2); Revolute p(ground, body.c); Revolute q(body.p, other.c%s);"
    )
    assert ("planar", ("body", "other")) in notes(text % "")
    assert not any(action == "planar" for action, _ in notes(text % ", n = {0, 0.001, 1}"))


def test_a_spring_out_of_the_plane_is_named():
    found = reduce(
        graph.build(mbdsl.parse(FREE % "Revolute p(ground, body.c); SpringDamper s(ground, body.q, k = 1 N/m);"))
    )
    (note,) = found.notes
    assert "held in a plane, but solved in space because of s: its frames are in different planes" in str(note)


def test_initial_values_out_of_the_plane():
    """They contradict the hinge, as with the equations in space."""
    scene = mbdsl.parse(HINGED.replace("hinge.w = 0.3 rad/s;", "hinge.w = 0.3 rad/s; door.wx = 1 rad/s;"))
    messages = []
    for general in (False, True):
        with pytest.raises(MbdslError) as error:
            mbdsl.simulate(scene, stop=0.1, step=1e-3, general=general)
        messages.append(str(error.value))
    assert messages[0] == messages[1]


def test_turns_that_do_not_exist_in_a_plane():
    """Springs on all four hinges of a linkage, one of them wound by a turn: in a plane the angles of a loop add up."""
    springs = "".join(
        f"RotationalSpringDamper {name}{ends}, n = {{0, 1, 0}}, k = 5 N.m/rad);"
        for name, ends in (("k", "(ground, a.a"), ("l", "(a.b, b.a"), ("m", "(b.b, c.b"), ("n", "(ground.d, c.a"))
    )
    text = FOUR_BAR.replace("initial equation", f"{springs} initial equation")
    text = text.replace("O.w = 3 rad/s", "guess m.phi = 5.1 rad; O.w = 3 rad/s")  # -1.2 rad and a turn
    scene = mbdsl.parse(text)
    flat, solid = (mbdsl.simulate(scene, step=1e-3, stop=0.1, interval=0.05, general=g) for g in (False, True))
    assert flat.stats["solved"] == solid.stats["solved"]
    np.testing.assert_array_equal(flat.q, solid.q)


# -- other ways to run -----------------------------------------------------------------------------------------------


def test_step_by_step_with_an_input():
    """Steps, a restored state and a copy, against the same in space."""
    flat, solid = (mbdsl.Simulation(mbdsl.parse(LAWS), step=1e-3, general=general) for general in (False, True))
    for sim in (flat, solid):
        sim.inputs["u"] = 3.0
        sim.step(50)
        sim.inputs["u"] = -1.0
        sim.step(20)
    for name in ("one.x", "two.p3", "A.w", "O.phi", "energy.total", "A.tx", "O.fz"):
        assert flat[name] == pytest.approx(solid[name], rel=1e-7), name
    state, copy = flat.state, flat.copy()
    flat.step(10)
    there = flat["two.x"]
    flat.state = state
    flat.step(10)
    copy.step(10)
    assert flat["two.x"] == there == copy["two.x"]


def test_verified_by_another_method(tmp_path, capsys):
    """Two methods agree to three digits and more in all signals, as their errors at this step do."""
    path = tmp_path / "hinged.mbd"
    path.write_text(HINGED, encoding="utf-8")
    arguments = ["--stop", "0.2s", "--step", "1ms", "--out", str(tmp_path / "x.csv"), "--verify"]
    assert main(["simulate", str(path), *arguments]) == 0
    digits = re.findall(r"^\S+\.\S+ +(\d+\.\d)  ", capsys.readouterr().out, flags=re.MULTILINE)
    assert len(digits) > 5 and min(map(float, digits)) > 3.0


def test_counterparts_have_the_parameters():
    """A parameter that a kind has in space only would have no effect in the plane: only axes, components along z, and
    the second slip of contacts, which with friction are solved in space."""
    for name in (name for name, kind in kinds(True).items() if _writer(kind)):
        planar, spatial = find(name), find(name, True)
        if planar is not None:
            more = {p.name for p in spatial.parameters} - {p.name for p in planar.parameters}
            assert more <= {"n", "fz", "axes", "slip_2"}, name
