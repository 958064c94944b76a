"""Forces as people name them against closed forms: sections, pins in own axes, sensors, powers; in the plane and in
space, where a planar model has the same values."""

import numpy as np
import pytest

import mbdsl
from mbdsl import UsageError

G = 9.81
SPACES = pytest.mark.parametrize("space", ["", "spatial "])


def run(text, space="", **more):
    """A run of a model; {0} frames have a third zero in space."""
    text = space + text.replace("Z}", ", 0}" if space else "}")
    return mbdsl.simulate(mbdsl.parse(text), **{"stop": 0.4, "interval": 0.01} | more)


PENDULUM = """model Pendulum
  Ground ground(g = 9.81);
  Rod rod(m = 2, length = 1.5, frames(q = {0.25, 0Z}));
  Revolute pin(ground, rod.a);
  Sensor tip(rod.b);
  Sensor base(rod.a);
initial equation
  pin.phi = -20 deg;
  pin.w = 0;
end Pendulum;"""


@SPACES
def test_a_swinging_rod(space):
    """With phi from the horizontal: w^2 = 3 g (sin phi_0 - sin phi)/L, alpha = -3 g cos phi/(2 L). A part beyond x from
    the middle has the mass m (1/2 - x/L) and its centre at r from the pin."""
    r = run(PENDULUM, space, tol=1e-9)
    m, L = 2.0, 1.5
    s, c = np.sin(r["pin.phi"]), np.cos(r["pin.phi"])
    w2, alpha = 3 * G / L * (np.sin(np.radians(-20)) - s), -1.5 * G / L * c
    close = dict(rel=1e-6, abs=1e-5)
    assert r["pin.frame_b.fx"] == pytest.approx(m * G * s - m * w2 * L / 2, **close)
    assert r["pin.frame_b.fy"] == pytest.approx(m * G * c / 4, **close)
    # on the ground: the opposite force, in its axes, those of the world
    assert r["pin.frame_a.fx"] == pytest.approx(-r["pin.fx"], **close)
    assert r["pin.frame_a.fy"] == pytest.approx(-(c * r["pin.frame_b.fy"] + s * r["pin.frame_b.fx"]), **close)
    assert r["pin.frame_a.f"] == pytest.approx(r["pin.frame_b.f"], **close)
    for frame, x in (("a", -L / 2), ("c", 0.0), ("q", 0.25), ("b", L / 2)):
        part, at = m * (0.5 - x / L), (x + L / 2 + L) / 2  # distances from the pin
        assert r[f"rod.{frame}.N"] == pytest.approx(part * (w2 * at - G * s), **close)
        shear = -part * (alpha * at + G * c)
        assert r[f"rod.{frame}.Q"] == pytest.approx(shear, **close)
        rest = L / 2 - x  # moment about the section: of the loads in its middle, and the rotary inertia of the part
        assert r[f"rod.{frame}.M"] == pytest.approx(shear * rest / 2 - part * rest**2 / 12 * alpha, **close)
    assert r["tip.ax"] == pytest.approx(-w2 * L + G * s, **close)
    assert r["tip.ay"] == pytest.approx(alpha * L + G * c, **close)
    assert r["tip.a"] == pytest.approx(np.hypot(r["tip.ax"], r["tip.ay"]), **close)
    assert abs(r["tip.w"]) == pytest.approx(np.sqrt(abs(w2)), abs=1e-5)
    for key in ("fx", "fy", "f"):
        assert r[f"base.{key}"] == pytest.approx(r[f"pin.frame_b.{key}"], **close)
    assert not r["tip.fx"].any() and not r["tip.tau"].any()


@SPACES
def test_a_hanging_rod(space):
    """N = m g (1 - s/L) at the distance s from the pin, above and below a weight that hangs from a frame."""
    text = PENDULUM.replace("-20 deg", "-90 deg").replace("end P", "equation end P")
    text = text.replace("Sensor tip", "Force load(rod.q, fy = -7 N); Sensor tip").replace("equation end", "end")
    r = run(text, space, stop=0.02)
    profile = r.along("rod.N", at=[0.0, "10 ms"])
    line = profile.lines["rod.N"]
    expected = 2.0 * G * (1.0 - line.x / 1.5) + np.where(line.x < 1.0, 7.0, 0.0)
    assert profile["rod.N"][0] == pytest.approx(expected, abs=1e-6)
    assert profile["rod.N"][1] == pytest.approx(expected, abs=1e-6)
    assert sum(abs(line.x - 1.0) < 1e-6) == 2  # both sides of the load
    assert profile.panels[0].x_label == "distance from rod.a [m]"


def test_a_cantilever():
    """The static shear force and bending moment of a stiff beam, whatever its elements: with the tip load F and the
    weight q L, Q = -(F + q r) and M = -(F r + q r^2/2) at the distance r from the tip."""
    text = """model Cantilever
      Ground ground(g = 9.81);
      FlexibleBeam beam(length = 2, mass = 6, S = 1e-2, I = 1e-4, E = 2e11, {0}, frames(q = {{0.5, 0}}));
      Fixed clamp(ground, beam.a);
      Force load(beam.b, fy = -50 N);
      annotation(experiment(StopTime = 0.01));
    end Cantilever;"""
    for form in ("elements = 3", "modes = 4", 'formulation = "ancf", elements = 4'):
        found = mbdsl.static(mbdsl.parse(text.format(form)))
        F, q = 50.0, 6.0 * G / 2.0
        for name, r in (("beam.a", 2.0), ("beam.c", 1.0), ("beam.q", 0.5), ("beam.b", 0.0)):
            assert found[f"{name}.Q"] == pytest.approx(-(F + q * r), rel=1e-5)
            assert found[f"{name}.M"] == pytest.approx(-(F * r + q * r * r / 2), rel=1e-5, abs=1e-6)
        assert found["clamp.Q"] == pytest.approx(found["beam.a.Q"], rel=1e-5)
        assert found["clamp.M"] == pytest.approx(found["beam.a.M"], rel=1e-5)
        assert abs(found["clamp.N"]) < 0.1


@SPACES
def test_a_weld(space):
    """A bracket on a rotor that turns with a given speed: N = m w^2 r in tension, Q and M of the weight."""
    text = """model Weld
      Ground ground(g = 9.81);
      Rod rod(m = 1, length = 1);
      Rod arm(m = 2, length = 0.6);
      Fixed weld(rod.b, arm.a);
      Revolute pin(ground, rod.a);
      RotationalDriver motor(pin, phi = (3 rad/s)*time);
    end Weld;"""
    r = run(text, space)
    c, s = np.cos(3 * r.time), np.sin(3 * r.time)
    assert r["weld.N"] == pytest.approx(2 * (9 * 1.3 - G * s), abs=1e-6)
    assert r["weld.Q"] == pytest.approx(-2 * G * c, abs=1e-6)
    assert r["weld.M"] == pytest.approx(-2 * G * 0.3 * c, abs=1e-6)
    assert r["arm.a.N"] == pytest.approx(r["weld.N"], abs=1e-6)
    assert r["rod.b.M"] == pytest.approx(r["weld.M"], abs=1e-6)
    # the motor lifts both centres of mass: its power is that against gravity
    assert r["motor.power"] == pytest.approx((1 * 0.5 + 2 * 1.3) * G * 3 * c, abs=1e-5)


@SPACES
def test_axial_forces_are_positive_in_tension(space):
    """A mass that hangs from a link; the same on a cylinder that lifts it with constant velocity, and on a spring."""
    text = """model Hanging
      Ground ground(g = 9.81);
      PointMass link_mass(m = 2);
      Distance link(ground, link_mass, length = 1);
      PointMass lifted(m = 3);
      DistanceDriver lift(ground, lifted, s = 2 m - (0.5 m/s)*time);
      Body slider(m = 4, I = 1);
      Prismatic rail(ground, slider.c);
      TranslationalDriver push(rail, s = (0.5 m/s2)*time^2);
      TranslationalDriver hold(ground, other.c, s = 0);
      Body other(m = 1, I = 1);
      Prismatic bed(ground, other.c);
    initial equation
      link_mass.x = 0; link_mass.y = -1; lifted.x = 0; lifted.y = -2;
    end Hanging;""".replace(
        "TranslationalDriver hold(ground, other.c, s = 0);", "TranslationalVelocityDriver hold(bed, v = 2);"
    )
    r = run(text, space)
    assert r["link.force"] == pytest.approx(2 * G, abs=1e-6)
    assert r["lift.force"] == pytest.approx(3 * G, abs=1e-6)
    assert r["lift.power"] == pytest.approx(3 * G * 0.5, abs=1e-6)
    assert r["push.force"] == pytest.approx(-4.0, abs=1e-6)  # it pushes: compression
    assert r["push.power"] == pytest.approx(4.0 * r["rail.v"], abs=1e-6)
    assert r["hold.force"] == pytest.approx(0.0, abs=1e-6)


@SPACES
def test_powers_are_the_change_of_energy(space):
    """The integral of the sum of all powers is the change of kinetic energy and weight m g y, by Simpson's rule."""
    text = """model Powers
      Ground ground(g = 9.81);
      Rod crank(m = 2, length = 0.5);
      Rod rod(m = 1, length = 1);
      Revolute O(ground, crank.a);
      RotationalDriver motor(O, phi = (3 rad/s)*time);
      Revolute A(crank.b, rod.a, radius = 2 cm, mu = 0.3, w_s = 1);
      RotationalSpringDamper hinge(A, k = 3, c = 0.1);
      SpringDamper spring(ground, rod.b, k = 40, c = 2, s0 = 0.7);
      Force push(rod.b, fx = (3 N)*cos((5 rad/s)*time), fy = 1);
      Torque twist(crank.a, rod.c, tau = (0.5 N.m)*sin((3 rad/s)*time));
    initial equation
      A.phi = 0.3; A.w = 0;
    end Powers;"""
    r = run(text, space, method="radau5", tol=1e-7, interval=1e-3)
    names = [f"{x}.power" for x in ("motor", "A", "hinge", "spring", "push", "twist")]
    total = sum(r[name] for name in names)
    energy = r["energy.kinetic"] + G * (2 * r["crank.y"] + r["rod.y"])
    h = 1e-3 / 3
    work = [0.0, *np.cumsum(h * (total[:-2:2] + 4 * total[1:-1:2] + total[2::2]))]
    assert work == pytest.approx(energy[::2] - energy[0], abs=1e-6 * np.ptp(energy))
    assert (r["A.power"] <= 0).all() and r["A.power"].min() < -0.01  # friction takes power
    assert np.ptp(r["motor.power"]) > 1.0


@SPACES
def test_an_accelerometer_falls_and_rests(space):
    text = """model Falling
      Ground ground(g = 9.81, frames(wall = {1, 2Z}));
      Body body(m = 1, I = 2, frames(p = {0.3, 0.1, 40 degX}));
      FreeMotion free(ground, body.c);
      Sensor off(body.p);
      Sensor centre(body.c);
      Sensor resting(ground.wall);
    initial equation
      body.phi = 0; body.w = 2 rad/s;
    end Falling;"""
    text = text.replace(
        "p = {0.3, 0.1, 40 degX}",
        "p(r = {0.3, 0.1, 0}, n = {0, 0, 1}, phi = 40 deg)" if space else "p = {0.3, 0.1, 40 deg}",
    )
    r = run(text, space, tol=1e-8)
    assert abs(r["centre.ax"]).max() < 1e-9 and abs(r["centre.ay"]).max() < 1e-9
    assert r["resting.ay"] == pytest.approx(G, abs=1e-12) and not r["resting.ax"].any()
    # off the centre: w^2 towards it, in the axes of the frame
    turn = np.exp(-1j * np.radians(40))
    expected = -4.0 * (0.3 + 0.1j) * turn
    assert r["off.ax"] == pytest.approx(expected.real, abs=1e-6)
    assert r["off.ay"] == pytest.approx(expected.imag, abs=1e-6)
    assert r["off.w"] == pytest.approx(2.0, abs=1e-9)


def test_gyroscope_of_a_symmetric_top():
    """Euler: in body axes, w_1 + i w_2 turns with (I_3 - I_1)/I_1 w_3, and w_3 is constant (Goldstein, section 5.6)."""
    text = """spatial model Top
      Ground ground(g = 0);
      Body top(m = 1, I = {2, 2, 3});
      FreeMotion free(ground, top.c);
      Sensor gyro(top.c);
    initial equation
      top.wx_local = 0.4; top.wy_local = 0; top.wz_local = 5;
    end Top;"""
    r = run(text, stop=2.0, tol=1e-10)
    turning = 0.4 * np.exp(1j * 2.5 * r.time)
    assert r["gyro.wx"] == pytest.approx(turning.real, abs=1e-7)
    assert r["gyro.wy"] == pytest.approx(turning.imag, abs=1e-7)
    assert r["gyro.wz"] == pytest.approx(5.0, abs=1e-7)
    assert r["gyro.w"] == pytest.approx(5.0, abs=1e-7)
    assert abs(r["top.wx"] - r["gyro.wx"]).max() > 0.1  # not those in world axes


@SPACES
def test_a_sensor_changes_nothing(space):
    """On welded, driven and free bodies, and on parts of their own; in space also on what is solved in a plane."""
    text = """model Parts
      Ground ground(g = 9.81);
      Rod one(m = 1, length = 1); Rod two(m = 1, length = 1); Rod three(m = 1, length = 1);
      Rod alone(m = 1, length = 0.5);
      Revolute a(ground, one.a); RotationalDriver motor(a, phi = time*(2 rad/s));
      Fixed b(one.b, two.a); Revolute c(two.b, three.a); Revolute d(ground, alone.a);
      SENSORS
    end Parts;"""
    sensors = " ".join(
        f"Sensor s{k}({frame});" for k, frame in enumerate(("one.b", "two.b", "three.b", "alone.b", "ground"))
    )
    bare, found = (run(text.replace("SENSORS", more), space) for more in ("", sensors))
    for name in ("three.phi", "alone.phi", "c.fx"):
        assert (found[name] == bare[name]).all()
    # the motor turns one and two as one body
    assert found["s1.ax"] == pytest.approx(-4.0 * 2.0 + G * np.sin(2 * bare.time), abs=1e-6)
    assert found["s1.fx"] == pytest.approx(found["c.frame_a.fx"], abs=1e-9)


def test_a_rotor_with_a_sensor_is_still_part_of_a_gyrostat():
    text = """spatial model Rotor
      Ground ground(g = 9.81);
      Body carrier(m = 1, I = {0.1, 0.2, 0.3});
      Spherical ball(ground, carrier.c);
      Body wheel(m = 1, I = {0.02, 0.01, 0.02});
      Revolute axle(carrier.c, wheel.c, n = {0, 1, 0});
      SENSOR
    initial equation
      axle.w = 30; carrier.wx = 1; carrier.wz = 2;
    end Rotor;"""
    bare, found = (run(text.replace("SENSOR", x)) for x in ("", "Sensor gyro(wheel.c);"))
    assert (bare["carrier.wx"] == found["carrier.wx"]).all()
    assert found["gyro.wy"] == pytest.approx(bare["wheel.wy_local"], abs=1e-12)


@SPACES
def test_in_laws(space):
    """A gyroscope, a power and the force on a frame are parts of laws: a torque -c w of a gyroscope is a damper."""
    text = """model Law
      Ground ground(g = 9.81);
      Rod rod(m = 2, length = 1);
      Revolute pin(ground, rod.a);
      Sensor gyro(rod.b);
      DAMPER
      Real P = brake.power;
      Real radial = pin.frame_b.fx;
    end Law;"""
    law = run(text.replace("DAMPER", "Torque brake(ground, rod.b, tau = -(0.8 N.m.s/rad)*gyro.w);"), space, tol=1e-8)
    damper = run(text.replace("DAMPER", "RotationalSpringDamper brake(pin, c = 0.8);"), space, tol=1e-8)
    assert law["pin.phi"] == pytest.approx(damper["pin.phi"], abs=1e-6)
    assert law["P"] == pytest.approx(-0.8 * law["pin.w"] ** 2, abs=1e-9)
    assert law["radial"] == pytest.approx(law["pin.frame_b.fx"], abs=1e-9)
    assert damper["brake.power"] == pytest.approx(law["P"], abs=1e-5)


@SPACES
def test_a_running_simulation_reads_them(space):
    text = space + PENDULUM.replace("Z}", ", 0}" if space else "}")
    names = ["tip.ax", "tip.w", "base.fx", "pin.frame_b.fy", "rod.c.N", "pin.frame_a.f", "rod.q.M"]
    simulation = mbdsl.Simulation(mbdsl.parse(text), step=1e-3)
    for _ in range(20):
        simulation.step()
    trajectory = simulation.trajectory()
    for name in names:
        assert simulation[name] == pytest.approx(trajectory[name][-1], rel=1e-9, abs=1e-9)
    assert simulation.reader(*names)() == pytest.approx([simulation[name] for name in names])


def test_as_patterns_measures_and_columns(tmp_path):
    scene = mbdsl.parse(PENDULUM.replace("Z}", "}"))
    trajectory = mbdsl.simulate(scene, stop=0.1)
    assert trajectory.select("pin.frame_a.*") == [f"pin.frame_a.{key}" for key in ("fx", "fy", "tau", "f")]
    assert trajectory.select("rod.*.M") == [f"rod.{frame}.M" for frame in "cabq"]
    assert trajectory.unit("rod.q.M") == "N.m" and trajectory.unit("pin.frame_a.tau") == "N.m"
    assert "rod.q.M" not in trajectory.names and "pin.frame_a.fx" not in trajectory.names
    path = tmp_path / "run.npz"
    trajectory.save(path, ["pin.frame_b.*", "rod.a.N", "2*pin.frame_a.f + rod.a.N"])
    plot = mbdsl.plot(path, "pin.frame_b.f?,rod.a.N".split(","))
    assert {s.name for p in plot.panels for s in p.series} == {"pin.frame_b.fx", "pin.frame_b.fy", "rod.a.N"}
    sweep = mbdsl.sweep(scene, {"rod.m": [1, 2]}, ["max(pin.frame_b.f)", "max(rod.a.N)"], stop=0.1, workers=1)
    for measure in ("max(pin.frame_b.f)", "max(rod.a.N)"):  # forces of a mass that falls grow with it
        assert sweep[measure][1] == pytest.approx(2 * sweep[measure][0], rel=1e-4)
    with pytest.raises(UsageError, match=r"there is no signal `pin.frame_a.fq`"):
        trajectory["pin.frame_a.fq"]


@pytest.mark.parametrize("form", ["modes = 4, axial = 1", 'formulation = "ancf", elements = 2'])
def test_the_whole_beam_is_in_equilibrium(form):
    """In motion, the section at the pin transmits what the pin does, which follows from the equations of the beam; the
    moment there is zero, up to the terms of second order of small deformation."""
    text = PENDULUM.replace("Rod rod(m = 2, length = 1.5, frames(q = {0.25, 0Z}));", "FlexibleBeam rod(mass = 2, "
                            f"length = 1.5, S = 1e-3, I = 1e-7, E = 2e9, rotary = 0.01, {form});")  # fmt: skip
    r = run(text, method="radau5", tol=1e-6, stop=0.05)
    assert r["rod.a.N"] == pytest.approx(-r["pin.frame_b.fx"], rel=1e-9, abs=1e-9)
    assert r["rod.a.Q"] == pytest.approx(-r["pin.frame_b.fy"], rel=1e-9, abs=1e-9)
    assert abs(r["rod.a.M"]).max() < 1e-3 * abs(r["rod.c.M"]).max()
    assert abs(r["rod.b.N"]).max() < 1e-9 and abs(r["rod.b.M"]).max() < 1e-9


ON_A_ROD = """model OnARod
  Ground ground(g = 9.81);
  Rod rod(m = 2, length = 1, frames(q = {-0.15, 0Z}));
  JOINTS
end OnARod;"""


@SPACES
def test_a_slider_loads_a_rod_where_it_is(space):
    """Statics of a cantilever of the weight m g with a weight at s = 0.8 m: Q and M are sums of weights and levers."""
    joints = "Fixed w(ground, rod.a); PointMass m(m = 4); Prismatic p(rod.a, m); TranslationalDriver d(p, s = 0.8 m);"
    if space:
        joints = joints.replace("PointMass m(m = 4)", "Body m(m = 4, I = {1, 1, 1})").replace(
            "rod.a, m);", "rod.a, m.c);"
        )
    text = space + ON_A_ROD.replace("JOINTS", joints).replace("Z}", ", 0}" if space else "}")
    found = mbdsl.static(mbdsl.parse(text))
    for frame, x in (("rod.a", 0.0), ("rod.q", 0.35), ("rod.c", 0.5), ("rod.b", 1.0)):
        part, weight = 2.0 * (1.0 - x) * G, (4.0 * G if x < 0.8 else 0.0)
        assert found[f"{frame}.Q"] == pytest.approx(-(part + weight), abs=1e-6)
        assert found[f"{frame}.M"] == pytest.approx(-(part * (1.0 - x) / 2 + weight * (0.8 - x)), abs=1e-6)
    assert found["w.Q"] == pytest.approx(found["rod.a.Q"], abs=1e-6)
    assert found["w.M"] == pytest.approx(found["rod.a.M"], abs=1e-6)


BEADS = [
    ("", "PointMass m(m = 4)", "PointOnLine p(rod.a, m)"),
    ("spatial ", "PointMass m(m = 4)", "PointOnLine p(rod.a, m)"),
    ("spatial ", "Body m(m = 4, I = {1, 1, 1})", "Cylindrical p(rod.a, m.c)"),
    ("spatial ", "PointMass m(m = 4)", "PointOnSurface p(rod.a, m, f = p.y); PointOnPlane e(ground, m)"),
]


@pytest.mark.parametrize(("space", "bead", "joint"), BEADS)
def test_a_bead_passes_a_section(space, bead, joint):
    """On a rod that turns with w = 2 rad/s in a plane without weight, a bead at s has s = s_0 cosh(w t) and pushes the
    rod with 2 m w s' against the rotation; the normal force is that of the rod alone, m w^2 (L^2 - x^2)/(2 L)."""
    joints = f"Revolute pin(ground, rod.a); RotationalDriver motor(pin, phi = (2 rad/s)*time); {bead}; {joint};"
    start = "initial equation p.s = 0.3; p.v = 0; end OnARod"
    if "Surface" in joint:
        start = start.replace("p.s", "p.x").replace("p.v ", "p.vx ")
    text = ON_A_ROD.replace("9.81", "0").replace("JOINTS", joints).replace("end OnARod", start)
    r = run(text, space, tol=1e-9)
    s, v = 0.3 * np.cosh(2 * r.time), 0.6 * np.sinh(2 * r.time)
    push = -2 * 4.0 * 2.0 * v
    assert s[0] < 0.35 < s[-1]
    for frame, x in (("rod.a", 0.0), ("rod.q", 0.35), ("rod.b", 1.0)):
        Q, M = (np.where(s > x, force, 0.0) for force in (push, push * (s - x)))
        assert r[f"{frame}.Q"] == pytest.approx(Q, abs=1e-4)
        assert r[f"{frame}.M"] == pytest.approx(M, abs=1e-4)
        assert r[f"{frame}.N"] == pytest.approx(2.0 * 4.0 * (1.0 - x * x) / 2.0, abs=1e-4)
    profile = r.along("rod.M", at=[0.1, 0.4])
    for k, i in ((0, 10), (1, -1)):
        expected = push[i] * np.maximum(s[i] - profile.lines["rod.M"].x, 0.0)
        assert profile["rod.M"][k] == pytest.approx(expected, abs=1e-4)


@SPACES
def test_wheels_on_a_rod(space):
    """A disc that rolls on a cantilever moves its weight; the teeth of a pinion pull the rack where it is: with the
    force F on the axle, (m + I/r^2) a = F, and the part of the rod before the pinion carries I a/r^2."""
    text = """model Wheels
      Ground ground(g = 9.81);
      Rod rod(m = 2, length = 1);
      Frame rail(ground, r = {0, 0.1Z});
      Fixed fix(ground, rod.a);
      Body w(m = 4, I = IW);
      JOINTS
    initial equation
      w.x = 0.7; w.vx = 0.5;
    end Wheels;"""
    text = text.replace("IW", "{1, 1, 1}" if space else "1")
    disc = "RollingDisc j(rod.a, w.c, radius = 0.1);" + (" Planar plane(ground, w.c);" if space else "")
    r = run(text.replace("JOINTS", disc), space, stop=0.1)
    for frame, x in (("rod.a", 0.0), ("rod.c", 0.5)):
        assert r[f"{frame}.Q"] == pytest.approx(-(2 * (1 - x) + 4) * G, abs=1e-6)
        assert r[f"{frame}.M"] == pytest.approx(-((1 - x) ** 2 + 4 * (0.7 + 0.5 * r.time - x)) * G, abs=1e-5)
    assert r["rod.b.Q"] == pytest.approx(0.0, abs=1e-9)
    guide = "Prismatic guide(rail, slide.c); Body slide(m = 1e-9, I = IW); Revolute axle(slide.c, w.c);"
    guide = guide.replace("IW", "{1, 1, 1}" if space else "1")
    pinion = f"RackAndPinion j(rod.a, w.c, radius = 0.1); {guide} Force push(w.c, fx = 3);"
    r = run(text.replace("JOINTS", pinion), space, stop=0.1)
    for frame, N in (("rod.a", 3 / 0.01 / (4 + 1 / 0.01)), ("rod.c", 3 / 0.01 / (4 + 1 / 0.01)), ("rod.b", 0.0)):
        assert r[f"{frame}.N"] == pytest.approx(N, abs=1e-5)


@SPACES
def test_sections_beside_a_guide_of_its_own(space):
    """A guide off the axis of a rod, or on a beam that deforms, is a part that is not modelled: between its frame and
    the slider, no forces are stated; the other sections carry the whole weight, or none."""
    frames = "frames(q(r = {-0.15, 0.1, 0}), s = {0, 0, 0})" if space else "frames(q = {-0.15, 0.1}, s = {0, 0})"
    joints = (
        "Fixed w(ground, rod.a); PointMass m(m = 4); PointOnLine p(rod.q, m); TranslationalDriver d(rod.q, m, s = 0.3);"
    )
    text = ON_A_ROD.replace("frames(q = {-0.15, 0Z})", frames).replace("JOINTS", joints)
    found = mbdsl.static(mbdsl.parse(space + text))
    with pytest.raises(UsageError, match=r"`p` slides past the section at 0.5 m from rod.a along rod, off its axis"):
        found["rod.c.Q"]
    assert found["rod.a.Q"] == pytest.approx(-6 * G, abs=1e-6)
    assert found["rod.b.Q"] == pytest.approx(0.0, abs=1e-6)


def test_sections_beside_a_slider_on_a_beam():
    text = ON_A_ROD.replace("JOINTS", "Fixed w(ground, rod.a); PointMass m(m = 4); Prismatic p(rod.a, m); "
                            "TranslationalDriver d(p, s = 0.8 m);")  # fmt: skip
    beam = "FlexibleBeam rod(mass = 2, length = 1, E = 2e11, S = 1e-4, I = 1e-6, elements = 4);"
    text = text.replace("Rod rod(m = 2, length = 1, frames(q = {-0.15, 0Z}));", beam)
    found = mbdsl.static(mbdsl.parse(text))
    with pytest.raises(UsageError, match=r"along rod, which deforms as if the load acted at frame_a"):
        found["rod.c.M"]
    assert found["rod.b.Q"] == pytest.approx(0.0, abs=1e-6)


GEARED = """model Geared
  Ground ground(g = 9.81);
  Rod rod(m = 2, length = 1);
  Body fly(m = 1, I = 0.5K);
  Revolute O(ground, rod.a);
  Frame f(ground, r = {0, 2Z});
  Revolute P(f, fly.c);
  LAW
initial equation
  O.phi = 0.3; O.w = 0; START
end Geared;"""


def geared(law, space, start=""):
    text = GEARED.replace("LAW", law).replace("START", start)
    return run(text.replace("0.5K", "{0.5, 0.5, 0.5}" if space else "0.5"), space, stop=0.1, tol=1e-8)


@SPACES
@pytest.mark.parametrize(
    "law",
    [
        "Coupling c(P.phi, rod.b.phi, ratio = 1);",
        "VelocityConstraint c(gamma = rod.b.w - fly.w);",
        "RotationalVelocityDriver c(P, w = rod.b.w);",
    ],
)
def test_a_coupling_twists_the_rod(law, space):
    """A rod that turns a flywheel from its end: (m L^2/3 + I) alpha = -m g L/2 cos phi, the torque -I alpha is in all
    sections, and none at the pin."""
    r = geared(law, space)
    alpha = -G * np.cos(r["O.phi"]) / (2 / 3 + 0.5)
    assert r["rod.b.M"] == pytest.approx(-0.5 * alpha, abs=1e-5)
    assert r["rod.a.M"] == pytest.approx(0.0, abs=1e-5)
    assert r["rod.b.Q"] == pytest.approx(0.0, abs=1e-5)
    assert r["rod.a.Q"] == pytest.approx(-r["O.frame_b.fy"], abs=1e-5)


@SPACES
def test_a_coupling_pushes_the_rod(space):
    """A rack moved by the end of a rod turns the flywheel by y/(1 m): the end feels -I alpha_fly/(1 m) along y."""
    r = geared("Coupling c(P.phi, rod.b.y, ratio = 1 m);", space)
    s, c = np.sin(r["O.phi"]), np.cos(r["O.phi"])
    push = -0.5 * r["fly.alphaz" if space else "fly.alpha"]
    assert np.abs(push).min() > 1.0
    assert r["rod.b.N"] == pytest.approx(push * s, abs=1e-5)
    assert r["rod.b.Q"] == pytest.approx(push * c, abs=1e-5)
    assert r["rod.a.Q"] == pytest.approx(-r["O.frame_b.fy"], abs=1e-5)
    assert r["rod.a.M"] == pytest.approx(0.0, abs=1e-5)


@SPACES
def test_a_planetary_gear_on_a_rod(space):
    """The torques on sun and ring are as 1 : ratio, and that on the sun turns its flywheel."""
    law = """Body arm(m = 1, I = 0.5K);
      Revolute Q(f, arm.c);
      Sensor tip(rod.b);
      PlanetaryGear gear(P.phi, Q.phi, rod.b.phi, ratio = 3);"""
    r = geared(law, space, "Q.phi = 0; Q.w = 0;")
    torque = 3 * 0.5 * r["fly.alphaz" if space else "fly.alpha"]
    assert np.abs(torque).min() > 0.1
    for name in ("rod.b.M", "tip.tau"):
        assert r[name] == pytest.approx(torque, abs=1e-5)
    assert r["rod.a.M"] == pytest.approx(0.0, abs=1e-5)


@SPACES
def test_a_sensor_feels_a_coupling(space):
    """(I + 4 m L^2/3) alpha = 5 N.m of the flywheel; the rod turns twice as fast: T = 2 alpha m L^2/3."""
    law = "Torque t(f, fly.c, tau = 5); Coupling c(P.phi, rod.b.phi, ratio = 2, offset = 0.3);"
    law += "Sensor s(rod.b); Sensor a(rod.a);"
    text = GEARED.replace("9.81", "0").replace("0.5K", "1K")
    r = run(text.replace("LAW", law).replace("START", "").replace("1K", "{1, 1, 1}" if space else "1"), space, stop=0.1)
    assert r["s.tau"] == pytest.approx(2 * (2 / 3) * 5 / (1 + 8 / 3), abs=1e-6)
    assert r["a.tau"] == pytest.approx(0.0, abs=1e-6)


@SPACES
def test_power_of_a_moved_coupling(space):
    """A drum, a rope of the law o(t) and a weight: s = r phi + o, (I + m r^2) phi'' = -m r (g + o''), and the law
    delivers m (g + s'') o'."""
    text = """model Moved
      Ground ground(g = 9.81);
      UP
      Body drum(m = 2, I = 0.02K);
      PointMass load(m = 5);
      Revolute pin(ground, drum.c);
      PRISM
      Coupling c(pin.phi, guide.s, ratio = 80 mm, offset = -1 m + 0.1 m*sin((5 rad/s)*time));
      Coupling still(pin.phi, other.phi, ratio = 2, offset = 0.1);
      Body wheel(m = 1, I = 0.01K);
      Revolute other(ground, wheel.c);
    initial equation
      pin.phi = 0; pin.w = 0;
    end Moved;"""
    guide = "PointOnLine guide(ground, load, n = {0, 1, 0});" if space else "Prismatic guide(up, load);"
    text = text.replace("UP", "" if space else "Frame up(ground, phi = 90 deg);").replace("PRISM", guide)
    for I in ("0.02", "0.01"):
        text = text.replace(f"{I}K", f"{{{I}, {I}, {I}}}" if space else I)
    r = run(text, space, tol=1e-8)
    o1, o2 = 0.5 * np.cos(5 * r.time), -2.5 * np.sin(5 * r.time)
    alpha = -5 * 0.08 * (G + o2) / (0.02 + 4 * 0.01 + 5 * 0.08**2)
    assert r["c.power"] == pytest.approx(5 * (G + 0.08 * alpha + o2) * o1, abs=1e-4)
    assert not r["still.power"].any()
    assert r.unit("c.power") == "W"
