"""Models in space against solutions computed otherwise.

Heavy top and Bricard's linkage, which is over-constrained: every method has its order, and 10 s are right.
"""

import json
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdsl
from mbdsl.cli import main
from mbdsl.initial.start_check import check_start
from mbdsl.integrators import modules
from mbdsl.mechanism.graph import build

ROOT = Path(__file__).parents[2]
SPACE = ROOT / "models" / "space"
REFERENCE = ROOT / "tests" / "data" / "reference"
METHODS = [name for name, module in modules().items() if module.METHOD.chosen and not hasattr(module, "take")]
ORDERS = {name: modules()[name].METHOD.order for name in METHODS}


@pytest.fixture(scope="module")
def top():
    """x, the quaternion, Omega in body axes, and the force on the ball of the heavy top at 0.1 s.

    The force is that of Newton's equation, with the acceleration by Euler's equations about the fixed point."""
    values = json.loads((REFERENCE / "heavy_top.json").read_text(encoding="utf-8"))["values"]
    x, p, w = (np.array(values[key], float) for key in ("x_com", "quat_wxyz", "Omega_body"))
    m, R, arm, weight = 15.0, Rotation.from_quat(p[[1, 2, 3, 0]]).as_matrix(), np.array([0.0, 1, 0]), [0, 0, -9.81]
    J = np.diag([0.234375 + m, 0.46875, 0.234375 + m])
    turning = np.linalg.solve(J, np.cross(arm, R.T @ weight) * m - np.cross(w, J @ w))
    force = m * (R @ (np.cross(turning, arm) + np.cross(w, np.cross(w, arm))) - weight)
    return x, p, w, force


def errors(method, h, top, **given):
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method=method, interval=0.1, **given, **({"step": h} if h else {}))
    x, p, w, force = top
    found = np.array([t[f"top.p{k}"][-1] for k in range(4)])
    attitude = 2.0 * min(np.abs(found - p).max(), np.abs(found + p).max())
    position = max(abs(t[f"top.{key}"][-1] - value) for key, value in zip("xyz", x, strict=True))
    reaction = max(abs(t[f"ball.f{key}"][-1] - value) for key, value in zip("xyz", force, strict=True))
    return np.array([position, attitude, np.abs(t.v[-1, 3:] - w).max(), reaction])


@pytest.mark.parametrize("method", METHODS)
def test_heavy_top_has_the_order_of_the_method(method, top):
    """Position, attitude, angular velocity and reaction; steps of 1/27 and 1/53 of a turn of the top's axis.

    The next term of the error changes the ratio of two errors by less than a tenth at these steps, and of NEWMARK at a
    quarter of them: its velocities have errors of orders 1 and 2 of opposite sign."""
    h = 6.25e-5 if method == "newmark" else 2.5e-4
    coarse, fine = errors(method, h, top), errors(method, h / 2, top)
    assert np.log2(coarse / fine) == pytest.approx(ORDERS[method], abs=0.1)
    # Bruels and Cardona's generalized-alpha has 1e-5 in x at this step; BDF and Newmark are less accurate
    assert fine[0] < 4e-5


@pytest.mark.parametrize("method", ["hht-si2", "nstiff"])
def test_tolerances_keep_their_word_in_space(method, top):
    """The error of the position is below the tolerance times the size, 1 m."""
    for tol in (1e-4, 1e-6):
        assert errors(method, None, top, tol=tol)[:2].max() < tol


@pytest.mark.parametrize("method", METHODS)
def test_energy_of_the_top(method):
    """Its energy, 5,284 J with 147 J of gravity, changes as the error of Omega times the moment of momentum."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method=method, step=1.25e-4, interval=1e-3)
    assert t["energy.total"][0] == pytest.approx(0.5 * 0.46875 * 150**2 + 0.5 * (15 + 0.234375) * 4.61538**2, rel=1e-12)
    assert np.ptp(t["energy.total"]) < (3.0 if ORDERS[method] == 1 else 0.03)


STABILISED = [name for name in METHODS if "dPhi" in modules()[name].METHOD.enforces]
#: model, step [s], largest speed of a centre of mass [m/s]
CONSTRAINED = (
    ("heavy_top", 1e-3, 4.7),  # its spin is 150 rad/s
    ("heavy_top", 2.5e-4, 4.7),
    ("bricard", 1e-3, 1.0),
    ("haug_slider_crank", 1e-3, 1.0),
    ("haug_four_link", 1e-3, 6.3),
)


@pytest.mark.parametrize("method", STABILISED)
@pytest.mark.parametrize(("name", "h", "speed"), CONSTRAINED, ids=lambda x: str(x))
def test_constraints_of_stabilised_methods_hold(name, h, speed, method):
    """Phi is at rounding of positions of up to 10 m, and dPhi below 1e-11 of the largest speed, at least 1 m/s."""
    t = mbdsl.simulate(SPACE / f"{name}.mbd", method=method, step=h, stop=0.1, interval=1e-3)
    centres = [x for x in t.signals if x.count(".") == 1 and x.endswith((".vx", ".vy", ".vz"))]
    assert max(np.abs(t[x]).max() for x in centres) < speed
    assert max(np.abs(t[x]).max() for x in t.signals if ".Phi[" in x) < 1e-12
    assert max(np.abs(t[x]).max() for x in t.signals if ".dPhi[" in x) < 1e-11 * max(1.0, speed)


@pytest.mark.parametrize("method", STABILISED)
def test_matrices_last_where_a_body_spins(method):
    """The derivatives of velocities by the attitude are part of the matrix: the top turns by 0.15 rad in a step.

    Without them, the corrections shrink by a factor of 10 only, and each step takes a new matrix."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method=method, step=1e-3, interval=0.1)
    assert t.stats["factorisations"] < 0.5 * t.stats["steps"]


def test_bricard():
    """30 rows of rank 29: the path of P3 after 1, 2, 5 and 10 s; 5 s is about a period, where errors are smallest."""
    expected = json.loads((REFERENCE / "bricard.json").read_text(encoding="utf-8"))["P3"]
    t = mbdsl.simulate(SPACE / "bricard.mbd", method="hht-si2", step=2e-3, interval=1.0)
    for second, values in expected.items():
        k = int(np.argmin(np.abs(t.t - float(second))))
        found = [t[f"rod3.b.{key}"][k] for key in "xyz"]
        assert found == pytest.approx([float(x) for x in values], abs=1e-5)
    assert np.ptp(t["energy.total"]) < 1e-4


@pytest.fixture(scope="module")
def bricard():
    """Bricard's linkage at 1 and 2 s by a method of order 8: P3 agrees with the reference in 12 digits."""
    t = mbdsl.simulate(SPACE / "bricard.mbd", method="dop853", tol=1e-11, stop=2.0, interval=1.0)
    expected = json.loads((REFERENCE / "bricard.json").read_text(encoding="utf-8"))["P3"]
    for k in (1, 2):
        assert [t[f"rod3.b.{key}"][k] for key in "xyz"] == pytest.approx(
            [float(x) for x in expected[str(k)]], abs=1e-11
        )
    return t


def groups(t):
    """Positions, quaternions, angular velocities and reactions of Bricard's linkage after the start."""
    found = [[], [], [], []]
    for signal in t.signals:
        name, _, key = signal.rpartition(".")
        kinds = (("x", "y", "z"), ("p0", "p1", "p2", "p3"), ("wx", "wy", "wz"), ("fx", "fy", "fz", "tx", "ty", "tz"))
        for values, keys in zip(found, kinds, strict=True):
            if key in keys and re.fullmatch(r"rod\d|J\d", name):
                values.append(t[signal][1:])
    return [np.array(values) for values in found]


@pytest.mark.parametrize("method", METHODS)
def test_bricard_has_the_order_of_the_method(method, bricard):
    """Positions, quaternions, angular velocities, and the reactions of least norm at 1 and 2 s."""
    off = []
    for h in (4e-3, 2e-3):
        t = mbdsl.simulate(SPACE / "bricard.mbd", method=method, step=h, stop=2.0, interval=1.0)
        off.append([np.abs(a - b).max() for a, b in zip(groups(t), groups(bricard), strict=True)])
    assert np.log2(np.divide(*off)) == pytest.approx(ORDERS[method], abs=0.05)


def test_reactions_of_bricard(bricard):
    """They balance weights and inertia of every rod, with accelerations by differences over 2 ms: errors of h^4."""
    t = mbdsl.simulate(SPACE / "bricard.mbd", method="dop853", tol=1e-11, stop=0.984, interval=1e-3)[0.98:]
    hinges = [[f"rod{k}.{end}" for end in "ab"] for k in range(1, 6)]
    for k in range(1, 6):
        R = Rotation.from_quat(np.stack([t[f"rod{k}.p{i}"] for i in (1, 2, 3, 0)], axis=-1))
        w = np.stack([t[f"rod{k}.w{i}"] for i in "xyz"], axis=-1)
        inertia = np.full(3, 1.01 / 12)
        inertia[(k - 1) % 3] = 1 / 600
        momentum = R.apply(inertia * R.inv().apply(w))
        v = np.stack([t[f"rod{k}.v{i}"] for i in "xyz"], axis=-1)
        rates = [(8 * (y[3] - y[1]) - y[4] + y[0]) / (12 * 1e-3) for y in (v, momentum)]
        force, moment = np.array([0, -9.81, 0]), np.zeros(3)
        for point, joint, sign in zip(hinges[k - 1], (k - 1, k), (1, -1), strict=True):
            f, tau = (np.array([t[f"J{joint}.{key}{i}"][2] for i in "xyz"]) for key in "ft")
            arm = np.array([t[f"{point}.{i}"][2] - t[f"rod{k}.{i}"][2] for i in "xyz"])
            force, moment = force + sign * f, moment + sign * (tau + np.cross(arm, f))
        assert force == pytest.approx(rates[0], abs=1e-7)  # of 10 N, and rates to (1e-3/0.3)^4
        assert moment == pytest.approx(rates[1], abs=1e-7)


def test_bricards_redundant_row_is_named(capsys):
    assert main(["check", str(SPACE / "bricard.mbd")]) == 0
    text = capsys.readouterr().out
    assert "mobility 0 = 30 coordinates - 30 constraint rows" in text
    assert re.search(r"redundant: J\d.Phi\[\d\] follows from the other constraints", text)


def test_accelerations_at_many_times():
    """Long results take another path through the equations of motion: accelerations are the rates of the velocities.

    The numerical differences have errors of 0.05 rad/s2, of 661 rad/s2 (the same with half the steps: 0.01)."""
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", step=4e-5, interval=4e-5)
    assert len(t.t) > 2000
    for key in "xyz":
        rate = np.gradient(t[f"top.w{key}"], t.t)[50:-50]
        np.testing.assert_allclose(t[f"top.alpha{key}"][50:-50], rate, rtol=0, atol=0.2)


WHEEL = """spatial model Wheel
  Ground ground(g = 0);
  Body wheel(m = 1 kg, I = {1, 1, 1} kg.m2);
  Revolute pin(ground, wheel.c, n = {1, 2, -1});
initial equation
  pin.phi = 30 deg;
  pin.w = 24*pi*(1 rad/s);
annotation(experiment(StopTime = 1 s));
end Wheel;"""


@pytest.mark.parametrize("general", [False, True])
def test_turns_are_counted(general):
    """A hinge that turns 12 times, output 20 times: fewer than two outputs a turn."""
    t = mbdsl.simulate(mbdsl.parse(WHEEL), step=1e-3, interval=0.05, general=general)
    np.testing.assert_allclose(t["pin.phi"], np.pi / 6 + 24 * np.pi * t.t, atol=1e-9)


def test_turns_of_a_copy_and_of_a_part():
    """The hinge starts at two turns; a pickled trajectory and the part from 0.5 s on have the same angles."""
    model = mbdsl.parse(WHEEL.replace("30 deg", "14 rad"))
    t = mbdsl.simulate(model, step=1e-3, interval=0.05)
    copy = pickle.loads(pickle.dumps(t))
    np.testing.assert_allclose(copy["pin.phi"], 14.0 + 24 * np.pi * t.t, atol=1e-9)
    part = mbdsl.simulate(model, step=1e-3, interval=0.05)[0.5:]
    np.testing.assert_allclose(part["pin.phi"], 14.0 + 24 * np.pi * part.t, atol=1e-9)
    np.testing.assert_allclose(pickle.loads(pickle.dumps(part))["pin.phi"], part["pin.phi"], rtol=0, atol=0)
    for signal in ("wheel.phi", "wheel.p0", "wheel.p3"):
        np.testing.assert_array_equal(part[signal], t[signal][10:])


def test_uncertain_turns_are_reported():
    """A spring that turns a wheel back and forth by 12 turns in pi s: an output each second does not show the turns."""
    spring = "RotationalSpringDamper s(ground, wheel.c, k = 4 N.m/rad, n = {1, 2, -1});"
    text = WHEEL.replace("initial equation", f"{spring} initial equation").replace("30 deg", "40 rad")
    model = mbdsl.parse(text.replace("24*pi*(1 rad/s)", "0"))
    t = mbdsl.simulate(model, step=1e-3, interval=1.0, stop=5.0, general=True)
    assert [w for w in t.stats["warnings"] if "pin.phi may be wrong by whole turns after t = 0 s" in w]
    (warning,) = [w for w in t.stats["warnings"] if "pin.phi may be" in w]
    assert all(name in warning for name in ("s.torque", "energy.potential", "energy.total"))
    t = mbdsl.simulate(model, step=1e-3, interval=0.05, stop=5.0, general=True)
    assert not t.stats["warnings"]
    np.testing.assert_allclose(t["pin.phi"], 40.0 * np.cos(2.0 * t.t), rtol=0, atol=1e-3)


def test_turns_between_outputs_at_rest_are_reported():
    """The prescribed angle is 10 rad at 0.5 s and 0 at 1 s, where the hinge rests: the outputs' rates show nothing."""
    text = """spatial model Swing
      Ground ground;
      Rod a(m = 1 kg, length = 1 m);
      Revolute pin(ground, a.a);
      RotationalDriver d(pin, phi = (5 rad)*(1 - cos((2*pi*(1 rad/s))*time)));
    end Swing;"""
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, interval=0.5, stop=1.0)
    assert [w for w in t.stats["warnings"] if "pin.phi may be wrong by whole turns after t = 0 s" in w]
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, interval=0.05, stop=1.0)
    assert not t.stats["warnings"]
    np.testing.assert_allclose(t["pin.phi"], 5.0 * (1.0 - np.cos(2.0 * np.pi * t.t)), rtol=0, atol=1e-9)


def test_driver_of_a_ball_joint():
    """The angle of a driven body whose axes tilt has the prescribed rate, and the driver's power is the energy's rate.

    Central differences over 1 ms of an energy that changes with about 10 rad/s have errors of 1e-4 of its rate."""
    text = """spatial model Driven
      Ground ground(n = {0, 0, -1});
      Body body(m = 1 kg, I = {0.2, 0.3, 0.4} kg.m2, frames(p = {0.1, 0.2, -0.3} m));
      Spherical ball(ground, body.p);
      RotationalDriver driver(ground, body.p, phi = 4 rad/s*time);
    initial equation
      body.wx = 1 rad/s;
      body.wy = 2 rad/s;
    annotation(experiment(StopTime = 0.5 s));
    end Driven;"""
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3)
    np.testing.assert_allclose(t["driver.w"], 4.0, rtol=0, atol=1e-9)
    assert np.abs(t["body.wz"] - 4.0).max() > 0.5  # the axes of the frames differ
    power = sum(t[f"driver.t{i}"] * t[f"body.w{i}"] for i in "xyz")
    rate = np.gradient(t["energy.total"], t.t)[2:-2]
    np.testing.assert_allclose(power[2:-2], rate, rtol=0, atol=2e-3 * np.abs(rate).max())


@pytest.mark.parametrize(
    "element",
    [
        "RotationalSpringDamper e(ground, body.c, k = 2 N.m/rad, n = {0, 0, 0});",
        "TranslationalSpringDamper e(ground, body.c, k = 2 N/m, n = {0, 0, 0});",
        "Torque e(ground, body.c, tau = 1 N.m, n = {0, 0, 0});",
        "RotationalDriver e(ground, body.c, phi = 1 rad/s*time, n = {0, 0, 0});",
        "TranslationalDriver e(ground, body.c, s = 1 m/s*time, n = {0, 0, 0});",
        "Frame e(body, n = {0, 0, 0}, phi = 30 deg);",
    ],
)
def test_axes_that_are_zero_are_refused(element):
    with pytest.raises(mbdsl.ModelError, match="is zero"):
        mbdsl.parse(f"spatial model M Ground ground; Body body(m = 1 kg, length = 1 m); {element} end M;")


def test_frames_turned_about_an_axis():
    """90 degrees about y: the z axis of the frame is the x axis of the body."""
    text = "spatial model M Ground ground; Frame e(ground, r = {1, 2, 3} m, n = {0, 2, 0}, phi = 90 deg); end M;"
    frame = mbdsl.parse(text).frames["e"]
    assert frame.pose == pytest.approx((1, 2, 3, 0, 0, -1, 0, 1, 0, 1, 0, 0))


def test_free_bodies_are_named_a_kind_that_exists_in_space():
    text = "spatial model M Ground ground; Body body(m = 1 kg, length = 1 m); {} end M;"
    with pytest.raises(mbdsl.ModelError) as problem:
        mbdsl.simulate(mbdsl.parse(text.replace("{}", "")), stop=0.1)
    free = str(problem.value).partition("meant to fly:")[2].strip().splitlines()[0]
    mbdsl.parse(text.replace("{}", free))


def test_angle_of_a_tilted_body():
    """A hinge about a skew axis n: the angle of the body's x axis about z, from Rodrigues' formula, with its turns."""
    text = """spatial model Skew
      Ground ground(g = 0);
      Body wheel(m = 1 kg, I = {1, 1, 1} kg.m2);
      Revolute pin(ground, wheel.c, n = {1, 1, 1.7});
    initial equation
      pin.phi = 0;
      pin.w = 24 rad/s;
    annotation(experiment(StopTime = 3 s));
    end Skew;"""
    t = mbdsl.simulate(mbdsl.parse(text), step=1e-3, interval=0.01)
    n = np.array([1.0, 1.0, 1.7]) / np.linalg.norm([1.0, 1.0, 1.7])
    turn = 24 * t.t
    x = np.cos(turn)[:, None] * [1, 0, 0] + np.sin(turn)[:, None] * np.cross(n, [1, 0, 0])
    x += (1 - np.cos(turn))[:, None] * n * n[0]
    np.testing.assert_allclose(t["wheel.phi"], np.unwrap(np.arctan2(x[:, 1], x[:, 0])), atol=1e-8)
    often = mbdsl.simulate(mbdsl.parse(text), step=1e-3, interval=0.02)
    assert often["wheel.phi"][-1] == pytest.approx(t["wheel.phi"][-1], abs=1e-8)


def test_a_thin_rod_on_a_ball_joint():
    """Nothing determines its rotation about its axis: an error at the start, which names a kind of body that helps."""
    text = "spatial model M Ground ground; {} rod(m = 1 kg, length = 1 m{}); Spherical ball(ground, rod.a); end M;"
    with pytest.raises(mbdsl.InitialisationError, match="rod can move without moving a mass") as problem:
        mbdsl.simulate(mbdsl.parse(text.format("Rod", "")), stop=0.1)
    assert "Rod rod has no moment of inertia about its x axis" in str(problem.value)
    assert "a Cylinder has a moment of inertia about its axis" in str(problem.value)
    mbdsl.simulate(mbdsl.parse(text.format("Cylinder", ", radius = 1 cm")), stop=0.01)


THIN = "spatial model M Ground ground(frames(p = {{0.6, 0.3, 0.2}} m)); {} end M;"
TURNED = "Rod rod(m = 1 kg, length = 1 m); {} initial equation rod.phi = -30 deg;"
CRANKS = """Rod crank(m = 1 kg, length = 0.2 m); Rod rocker(m = 1 kg, length = 0.5 m);
  Revolute A(ground, crank.a, n = {{0, 0, 1}}); Revolute D(ground.p, rocker.a, n = {{0, 1, 0}});
  Rod rod(m = 2 kg, length = 0.7 m); {}"""
BAR = "Body rod(m = 1 kg, I = {0, 0.1, 0.1} kg.m2, frames(a = {-0.5, 0, 0} m)); Spherical ball(ground, rod.a); "


@pytest.mark.parametrize(
    "parts",
    [
        TURNED.format("Spherical ball(ground, rod.a);"),
        TURNED.format("Distance link(ground, rod.a, length = 1 m);"),
        TURNED.format("Spherical ball(ground, rod.a); SpringDamper spring(ground.p, rod.b, k = 1e5 N/m, s0 = 1 m);"),
        BAR + "initial equation rod.phi = -30 deg;",
        CRANKS.format("Spherical B(crank.b, rod.a); Spherical C(rod.b, rocker.b);"),
    ],
    ids=["ball", "distance", "spring", "Body", "RSSR"],
)
def test_thin_rods_that_are_turned_or_loaded(parts):
    """Rounding errors of rows and of torques about their axes, which are zero in theory, determine nothing."""
    model = mbdsl.parse(THIN.format(parts))
    for run in (lambda: check_start(build(model)), lambda: mbdsl.simulate(model, stop=1e-3)):
        with pytest.raises(mbdsl.InitialisationError, match="rod can move without moving a mass") as problem:
            run()
        assert "rod has no moment of inertia about its x axis" in str(problem.value)


@pytest.mark.parametrize(
    "parts",
    [
        CRANKS.format("Universal B(crank.b, rod.a, n_a = {0, 0, 1}, n_b = {0, 1, 0}); Spherical C(rod.b, rocker.b);"),
        TURNED.format(
            "Spherical ball(ground, rod.a); SpringDamper stiff(ground.p, rod.b, k = 1e8 N/m, s0 = 1 m);"
            "Bushing soft(ground, rod.a, k_phi = {1e-3, 1e-3, 1e-3} N.m/rad);"
        ),
    ],
    ids=["universal", "spring"],
)
def test_thin_rods_that_do_not_spin_freely(parts):
    """A joint, or a soft spring beside a stiff one, determines the rotation about the axis."""
    check_start(build(mbdsl.parse(THIN.format(parts))))


def test_the_remedy_where_fixed_steps_do_not_converge_works():
    """The sling of a trebuchet opens at `vx > 0`, which rounding decides while the stone rests: fixed steps of 1 ms do
    not converge at the release, and the message names the option that passes it."""
    text = (SPACE / "trebuchet.mbd").read_text(encoding="utf-8").replace("stone.vx > 1 m/s", "stone.vx > 0")
    with pytest.raises(mbdsl.IntegrationError, match="does not converge") as problem:
        mbdsl.simulate(mbdsl.parse(text), method="hht-si2", step=1e-3)
    assert "--tol" in problem.value.hint
    assert mbdsl.simulate(mbdsl.parse(text), method="hht-si2", tol=1e-3).t[-1] == 1.2


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ("PointOnSurface c(ground, p, f = x^2 + y^2 + z^2);", "PointOnSurface c: the gradient of f is zero"),
        ("PointOnSurface c(ground, p, f = 1e-9*(x - 2*y)^2);", "PointOnSurface c: the gradient of f is zero"),
        ("PointOnCurve c(ground, p, f1 = x, f2 = 2*x);", "PointOnCurve c: the gradients of f1 and f2 are parallel"),
        ("PointOnCurve c(ground, p, f1 = z - 1, f2 = x^2 + y^2 + z^2 - 1);", "of f1 and f2 are parallel"),
        (
            "Frame far(ground, r = {0, 0.15, 0} m); Body a(m = 1 kg, I = 1 kg.m2); Body b(m = 1 kg, I = 1 kg.m2);"
            "Revolute A(ground, a.c, n = {1, 0, 0}); Revolute B(far, b.c, n = {1, 0, 0});"
            "Gear G(a.c, b.c, ratio = 2, n_a = {1, 0, 0}, n_b = {1, 0, 0}); FreeMotion free(ground, p);",
            "the axes of Gear G are parallel",
        ),
    ],
)
def test_joints_that_define_no_direction(parts, message):
    """Zero gradients, parallel gradients and parallel axes, all at the assembled pose: errors of check and simulate."""
    text = f"spatial model M Ground ground; PointMass p(m = 1 kg); {parts} %s end M;"
    text %= "initial equation guess p.x = 0.3 m; guess p.y = 0.2 m; guess p.z = 0.5 m;"
    with pytest.raises(mbdsl.InitialisationError, match=message):
        check_start(build(mbdsl.parse(text)))
    with pytest.raises(mbdsl.InitialisationError, match=message):
        mbdsl.simulate(mbdsl.parse(text), stop=1e-3, step=1e-3)


@pytest.mark.parametrize(
    "parts",
    [
        "PointOnSurface c(ground, p, f = x^2 + y^2 + z^2 - 1e-10);",
        "PointOnCurve c(ground, p, f1 = 1e-6*(x^2 - 1), f2 = 1e6*(x + 1e-3*y - 1));",
    ],
)
def test_small_gradients_and_angles_define_directions(parts):
    """A sphere with a radius of 10 um, and surfaces that cross at an angle of 1e-3 rad."""
    text = f"spatial model M Ground ground; PointMass p(m = 1 kg); {parts} initial equation guess p.x = 1 m; end M;"
    check_start(build(mbdsl.parse(text)))
