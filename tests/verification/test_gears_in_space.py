"""Gears, racks, belts and cams in space: ratios, tooth forces, Newton's and Euler's laws, and what motions conserve."""

import numpy as np
import pytest

import mbdsl


def run(body, step=1e-3, stop=0.2, **given):
    text = f"spatial model M\n{body}\nannotation(experiment(StopTime = 1 s)); end M;"
    return mbdsl.simulate(mbdsl.parse(text), step=step, stop=stop, **given)


BEVEL = """Ground ground(g = 0);
  Body pinion(m = 1 kg, I = {0.02, 0.01, 0.01} kg.m2);
  Body wheel(m = 2 kg, I = {0.05, 0.3, 0.05} kg.m2);
  Revolute A(ground, pinion.c, n = {1, 0, 0});
  Revolute B(ground, wheel.c, n = {0, 1, 0});
  Gear mesh(pinion.c, wheel.c, ratio = 3, n_a = {1, 0, 0}, n_b = {0, 1, 0});
  Torque motor(pinion.c, tau = 0.8 N.m, n = {1, 0, 0});"""


def test_bevel_gears():
    """The torque accelerates I_a + I_b/ratio^2; the teeth exert I_b w_b' about the axis of the wheel.

    With a pitch radius r of the pinion and 3 r of the wheel, both torques are the same tooth force times the radius.
    The motion is a polynomial of degree 2, which methods of order 2 give to rounding; reactions magnify it by 1/h^2.
    """
    t = run(BEVEL)
    rate = 0.8 / (0.02 + 0.3 / 9)
    np.testing.assert_allclose(t["A.w"], rate * t.t, rtol=0, atol=1e-9)
    np.testing.assert_allclose(t["B.w"], -rate * t.t / 3, rtol=0, atol=1e-9)
    np.testing.assert_allclose(t["A.phi"] + 3 * t["B.phi"], 0, atol=1e-10)
    on_wheel = 0.3 * (-rate / 3)
    np.testing.assert_allclose(t["mesh.ty"], on_wheel, rtol=1e-6)
    np.testing.assert_allclose(t["mesh.tx"], -on_wheel / 3, rtol=1e-6)  # the same force on the radius of the pinion


def test_worm_gear_counts_turns():
    """A worm of 40 turns for one of its wheel; its axis passes that of the wheel. 16 turns of the worm in 0.2 s."""
    t = run(
        """Ground ground(g = 0, frames(high = {0, 0, 0.1} m));
        Body worm(m = 1 kg, I = 0.01 kg.m2); Body wheel(m = 2 kg, I = 0.2 kg.m2);
        Revolute A(ground.high, worm.c, n = {1, 0, 0}); Revolute B(ground, wheel.c, n = {0, 1, 0});
        Gear mesh(worm.c, wheel.c, ratio = -40, n_a = {1, 0, 0}, n_b = {0, 1, 0});
        RotationalDriver motor(A, phi = 160*pi*(1 rad/s)*time, n = {1, 0, 0});""",
        interval=1e-3,
    )
    np.testing.assert_allclose(t["B.phi"], t["A.phi"] / 40, atol=1e-9)
    assert t["B.phi"][-1] == pytest.approx(0.8 * np.pi, abs=1e-9)


def test_differential():
    """The carrier has the mean speed of both shafts, and they get the same torque, however unlike their loads are."""
    t = run(
        """Ground ground(g = 0);
        Body carrier(m = 1 kg, I = 0.02 kg.m2); Body left(m = 1 kg, I = 0.01 kg.m2);
        Body right(m = 1 kg, I = 0.03 kg.m2); Body spider(m = 0.1 kg, I = 1e-9 kg.m2);
        Revolute C(ground, carrier.c, n = {1, 0, 0});
        Revolute L(ground, left.c, n = {1, 0, 0}); Revolute R(ground, right.c, n = {1, 0, 0});
        Revolute S(carrier.c, spider.c, n = {0, 1, 0});
        Gear at_left(left.c, spider.c, ratio = 0.5, n_a = {-1, 0, 0}, n_b = {0, 1, 0});
        Gear at_right(right.c, spider.c, ratio = 0.5, n_a = {1, 0, 0}, n_b = {0, 1, 0});
        Torque engine(carrier.c, tau = 2 N.m, n = {1, 0, 0});
        Torque brake(left.c, tau = -0.2 N.m, n = {1, 0, 0});"""
    )
    np.testing.assert_allclose(t["L.w"] + t["R.w"], 2 * t["C.w"], atol=1e-9)
    # 2 = 0.02 c' + 2 T;  T - 0.2 = 0.01 l';  T = 0.03 r';  l' + r' = 2 c';  the spider's inertia is 1e-7 of the others
    c, left, right, torque = np.linalg.solve(
        [[0.02, 0, 0, 2], [0, -0.01, 0, 1], [0, 0, -0.03, 1], [-2, 1, 1, 0]], [2, 0.2, 0, 0]
    )
    np.testing.assert_allclose(t["C.w"], c * t.t, atol=1e-5)
    np.testing.assert_allclose(t["L.w"], left * t.t, atol=1e-5)
    np.testing.assert_allclose(t["R.w"], right * t.t, atol=1e-5)
    assert t["at_right.tx"][-1] == pytest.approx(-torque, rel=1e-5)


def test_rack_across_the_axes():
    """A force on the rack accelerates its mass and the pinion's I/r^2; the rack moves by the arc of the pinion."""
    t = run(
        """Ground ground(g = 0, frames(high = {0, 0, 50 mm}));
        Body rack(m = 2 kg, I = 0.1 kg.m2); Body pinion(m = 1 kg, I = 2e-3 kg.m2);
        Prismatic guide(ground, rack.c, n = {0, 1, 0}); Revolute A(ground.high, pinion.c, n = {1, 0, 0});
        RackAndPinion mesh(rack.c, pinion.c, radius = 50 mm, n = {0, 1, 0}, axis = {1, 0, 0});
        Force push(rack.c, fy = 7 N);"""
    )
    rate = 7 / (2 + 2e-3 / 0.05**2)
    np.testing.assert_allclose(t["guide.v"], rate * t.t, atol=1e-9)
    np.testing.assert_allclose(t["guide.s"], 0.05 * t["A.phi"], atol=1e-12)
    np.testing.assert_allclose(t["mesh.fy"], 7 - 2 * rate, rtol=1e-6)
    np.testing.assert_allclose(t["mesh.tx"], 2e-3 * rate / 0.05, rtol=1e-6)


#: a free body that tumbles and carries two bodies; the second one is held by B, and has equal moments of inertia
TUMBLING = """Ground ground(g = 0);
  FreeMotion free(ground, carrier.c);
  Body carrier(m = 3 kg, I = {0.3, 0.5, 0.6} kg.m2, frames(p = {-0.2, 0, 0.1} m, q = {0.1, 0, 0} m));
  Body a(m = 1 kg, I = {0.02, 0.03, 0.04} kg.m2);
  Body b(m = 2 kg, I = 0.05 kg.m2);
  %s
initial equation
  carrier.x = 0 m; carrier.y = 0 m; carrier.z = 0 m;
  carrier.wx = 1 rad/s; carrier.wy = -2 rad/s; carrier.wz = 1.5 rad/s;
  %s"""
KINDS = {
    "GearPair": (
        "Revolute A(carrier.p, a.c); Revolute B(carrier.q, b.c); GearPair e(a.c, b.c, r_a = 0.2 m, r_b = 0.1 m);",
        "A.w = 5 rad/s;",
    ),
    "BeltDrive": (
        "Revolute A(carrier.p, a.c); Revolute B(carrier.q, b.c); BeltDrive e(a.c, b.c, r_a = 0.1 m, r_b = 0.05 m);",
        "A.w = 5 rad/s;",
    ),
    "RotationalCam": (
        "Revolute A(carrier.p, a.c); Revolute B(carrier.q, b.c); RotationalCam e(a.c, b.c, beta = 0.4*sin(phi));",
        "A.w = 5 rad/s;",
    ),
    "Cam": (
        "Revolute A(carrier.p, a.c); Prismatic B(carrier.p, b.c); Cam e(a.c, b.c, s = 0.3 m + 0.05*sin(phi)*(1 m));",
        "A.w = 5 rad/s;",
    ),
    "RackAndPinion": (
        "Prismatic A(carrier.p, a.c); Revolute B(carrier.q, b.c); RackAndPinion e(a.c, b.c, radius = 0.1 m);",
        "A.v = 0.5 m/s; guess a.x = 0.1 m;",
    ),
    "Gear": (
        "Revolute A(carrier.p, a.c, n = {1, 0, 0}); Revolute B(carrier.q, b.c, n = {1, 2, 0}); "
        "Gear e(a.c, b.c, ratio = -1.5, n_a = {1, 0, 0}, n_b = {1, 2, 0});",
        "A.w = 5 rad/s;",
    ),
}


def vector(t, name, key):
    return np.stack([t[f"{name}.{key}{i}"] for i in "xyz"], axis=-1)


@pytest.mark.parametrize("kind", KINDS)
def test_laws_of_newton_and_euler(kind):
    """The reactions that are reported accelerate the body. Energy and momentum of the free mechanism are conserved.

    DOP853 has reactions and accelerations from the same equations, and steps of 0.005 rad have errors at rounding.
    """
    joints, speed = KINDS[kind]
    t = run(TUMBLING % (joints, speed), interval=1e-2, method="dop853")
    force = vector(t, "B", "f") + (vector(t, "e", "f") if "e.fx" in t else 0.0)
    torque = vector(t, "B", "t") + (vector(t, "e", "t") if "e.tx" in t else 0.0)
    np.testing.assert_allclose(force, 2 * vector(t, "b", "a"), atol=1e-10 * np.abs(force).max())
    np.testing.assert_allclose(torque, 0.05 * vector(t, "b", "alpha"), atol=1e-10 * np.abs(torque).max())
    assert np.abs(vector(t, "e", "t" if kind == "Gear" else "f")).max() > 1e-2
    assert np.ptp(t["energy.total"]) < 1e-11 * t["energy.total"][0]
    momentum = sum(m * vector(t, body, "v") for body, m in (("carrier", 3), ("a", 1), ("b", 2)))
    assert np.ptp(momentum, axis=0).max() < 1e-11 * np.abs(momentum).max() + 1e-12


def test_planets_do_not_depend_on_the_axes():
    """The planar planetary gear, and the same with all axes along x: the same ratio, torque and energies."""
    text = """Ground ground(g = 0);
      Body sun(m = 1 kg, I = {J} kg.m2); Body arm(m = 1 kg, I = 0.02 kg.m2, frames(p = {P} m));
      Body planet(m = 0.5 kg, I = 0.01 kg.m2);
      Revolute S(ground, sun.c{n}); Revolute C(ground, arm.c{n}); Revolute P(arm.p, planet.c{n});
      GearPair at_sun(sun.c, planet.c, r_a = 0.1 m, r_b = 0.05 m{n});
      GearPair at_ring(planet.c, ground, r_a = 0.05 m, r_b = 0.2 m, internal = true{n});
      Torque motor(sun.c, tau = 1 N.m{n});"""
    flat = run(text.replace("{J}", "0.01").replace("{P}", "{0.15, 0}").replace("{n}", ""))
    turned = text.replace("{J}", "0.01").replace("{P}", "{0, 0.15, 0}").replace("{n}", ", n = {1, 0, 0}")
    solid = run(turned)
    for key in ("S.w", "C.w", "P.w", "energy.kinetic"):
        np.testing.assert_allclose(solid[key], flat[key], atol=1e-8, err_msg=key)
    np.testing.assert_allclose(flat["S.w"], 3 * flat["C.w"], atol=1e-9)  # 1 + r_ring/r_sun = 3
    np.testing.assert_allclose(solid["at_ring.tx"], flat["at_ring.tau"], rtol=1e-6)


@pytest.mark.parametrize(
    ("element", "problem"),
    [
        ("Gear e(a.c, b.c, ratio = 0)", "its ratio is zero"),
        ("Gear e(a.c, b.c, ratio = 1, n_a = {0, 0, 0})", "an axis is zero"),
        ("RackAndPinion e(a.c, b.c, radius = 1 m, n = {1, 0, 1})", "not at right angles to the rack"),
        ("Cam e(a.c, b.c, s = 1 m, axis = {1, 0, 0})", "not at right angles to the motion of the follower"),
        ("GearPair e(a.c, b.c, r_a = 2 m, r_b = 1 m, internal = true)", "not larger"),
    ],
)
def test_impossible_gears(element, problem):
    bodies = "Body a(m = 1 kg, length = 1 m); Body b(m = 1 kg, length = 1 m);"
    with pytest.raises(mbdsl.ModelError, match=problem):
        mbdsl.parse(f"spatial model M Ground ground; {bodies} {element}; end M;")


def test_shafts_that_are_parallel():
    """A Gear has no direction to measure angles from; the message names the kind for parallel axes."""
    with pytest.raises(mbdsl.InitialisationError, match="the axes of Gear e are parallel") as problem:
        run(
            """Ground ground; Body a(m = 1 kg, I = 1 kg.m2); Body b(m = 1 kg, I = 1 kg.m2);
            Revolute A(ground, a.c); Revolute B(ground, b.c); Gear e(a.c, b.c, ratio = 2, n_b = {0, 0, 1});"""
        )
    assert "GearPair" in str(problem.value)
