"""Which rotors are parts of gyrostats, and what prevents it."""

import pytest

import mbdsl
from mbdsl.mechanism import graph
from mbdsl.mechanism.reduction import reduce

SATELLITE = """
spatial model Satellite
  Ground ground(g = 0);
  Body bus(m = 200 kg, I = {80, 95, 60} kg.m2,
           frames(a = {0.3, 0.1, -0.2} m, b = {-0.2, 0.3, 0.1} m, d = {0.1, -0.3, 0.2} m));
  Cylinder w1(m = 5 kg, length = 0.05 m, radius = 0.15 m, n = {1, 0, 0});
  Cylinder w2(m = 4 kg, length = 0.05 m, radius = 0.15 m, n = {0, 1, 0}, frames(s = {0, 0.04, 0} m));
  Cylinder w3(m = 3 kg, length = 0.05 m, radius = 0.12 m, n = {0, 0, 1});
  FreeMotion free(ground, bus.c);
  Revolute j1(bus.a, w1.c, n = {1, 0, 0});
  Revolute j2(w2.s, bus.b, n = {0, 1, 0});
  Revolute j3(bus.d, w3.c, n = {0, 0, 1});
  LOADS
initial equation
  bus.wx_local = 0.02 rad/s; bus.wy_local = -0.03 rad/s; bus.wz_local = 0.05 rad/s;
  bus.vx = 0.1 m/s; bus.vy = 0 m/s; bus.vz = 0 m/s;
  j1.w = 100 rad/s; j2.w = 80 rad/s; j3.w = 100 rad/s;
  annotation(experiment(StopTime = 2 s, Interval = 0.02 s));
end Satellite;
"""
LOADS = """
  Torque t1(bus.a, w1.c, n = {1, 0, 0}, tau = 0.3 N.m*sin(2*time));
  RotationalSpringDamper d2(w2.s, bus.b, n = {0, 1, 0}, c = 1e-3 N.m.s/rad);
  Torque t3(bus.d, w3.c, n = {0, 0, 1}, tau = -0.01 N.m.s/rad*(j3.w - 90 rad/s) + 1 N.m.s/rad*bus.wz_local);
"""
FREE = SATELLITE.replace("LOADS", "")


def notes(text):
    return [(n.action, n.names, n.by) for n in reduce(graph.build(mbdsl.parse(text))).notes]


def test_notes():
    assert notes(SATELLITE.replace("LOADS", LOADS)) == [("gyrostat", ("w1", "w2", "w3"), ())]
    assert "w1, w2, w3: symmetric about axles on bus: a gyrostat" in str(
        mbdsl.explain(mbdsl.parse(SATELLITE.replace("LOADS", LOADS)))
    )


W2, W3 = ("gyrostat", ("w2", "w3"), ()), ("gyrostat", ("w1", "w3"), ())


@pytest.mark.parametrize(
    ("load", "by"),
    [
        ("RotationalSpringDamper s(bus.a, w1.c, n = {1, 0, 0}, k = 1 N.m/rad);", "s"),
        ("RotationalStop s(bus.a, w1.c, n = {1, 0, 0}, phi_min = -1 rad, phi_max = 1 rad, k = 10 N.m/rad);", "s"),
        ("RotationalDriver s(bus.a, w1.c, n = {1, 0, 0}, phi = 100 rad/s*time);", "s"),
        ("SpringDamper s(ground, w1.c, k = 1 N/m, s0 = 0.1 m);", "s"),
        ("Torque s(bus.a, w1.c, n = {1, 0, 0}, tau = 1 N.m*sin(j1.phi));", "s"),
        ("Torque s(w1.c, bus.c, n = {0, 1, 0}, tau = 1 N.m);", "s"),
        ("Torque s(ground, bus.c, tau = 1 N.m*w1.p1);", "s"),
        ("Force s(bus.c, fx = 1*j1.fy, fy = 0 N, fz = 0 N);", "s"),
    ],
)
def test_rotors_on_whose_angle_something_depends(load, by):
    assert notes(SATELLITE.replace("LOADS", load)) == [("kept", ("w1",), (by,)), W2]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("Revolute j1(bus.a, w1.c, n = {1, 0, 0})", "Revolute j1(bus.a, w1.c, n = {0, 1, 0})"),
        ("radius = 0.15 m, n = {1, 0, 0})", "radius = 0.15 m, n = {1, 0, 0}, frames(q = {0, 0.01, 0} m))"),
        ("Cylinder w1(m = 5 kg, length = 0.05 m, radius = 0.15 m, n = {1, 0, 0})",
         "Body w1(m = 5 kg, I = {0.05, 0.03, 0.031} kg.m2)"),
    ],
)  # fmt: skip
def test_bodies_that_are_not_symmetric_about_the_hinge(before, after):
    text = FREE.replace(before, after)
    assert text != FREE
    assert notes(text.replace("j1(bus.a, w1.c", "j1(bus.a, w1.q") if "q =" in after else text) == [W2]


def test_rotors_have_one_coordinate():
    (part,) = reduce(graph.build(mbdsl.parse(FREE))).parts
    (gyrostat,) = part.scene.bodies()
    assert gyrostat.coordinates == ("x", "y", "z", "rx", "ry", "rz", "theta1", "theta2", "theta3")
    assert not any(c.kind.name == "Revolute" for c in part.scene.components.values())
