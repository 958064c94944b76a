"""Motions that are known from other sources: closed forms, published values, an independent solver, symmetry.

Errors of the methods are C h^2; a test either checks that they fall with order 2, or compares cases in which the method
is exact. Steps are chosen so that errors at the smallest stay far above rounding and at the largest are asymptotic.

Two runs that solve the same discrete equations in different forms differ by the tolerance of Newton's method: in each
step it may stop at 1e-4 h^4 |a| in a position and 2e-4 h^3 |a| in a velocity. With h = 1e-3, |a| up to 50 and up to
1000 steps velocities differ by up to 1e-8 and positions by less. The discretisation error, which is the same in both,
is of the order of 1e-5.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

import mbdsl
from mbdsl import Builder

STEPS = [2.0**-k for k in range(7, 11)]
LOW, HIGH = 1.9, 2.1
G = 9.81


@pytest.fixture
def method(second_order):
    """Each method of second order of the paper, unless a test says otherwise."""
    return second_order


def ends(scene, method, stop, steps=STEPS, **more):
    """Trajectories with the start and the end only, one for each step."""
    return [mbdsl.simulate(scene, method=method, step=h, stop=stop, interval=stop, **more) for h in steps]


# -- the pendulum ----------------------------------------------------------------------------------------------


def pendulum(t, L=1.0):
    """x, y, vx, vy of the pendulum let go level at the left: sin(phi/2) = sin(pi/4) sn(K + w0 t | 1/2), phi from -y."""
    k, w0 = 0.5, np.sqrt(G / L)
    sn, cn, _, _ = ellipj(ellipk(k) + w0 * t, k)
    phi, rate = -2 * np.arcsin(np.sqrt(k) * sn), -2 * np.sqrt(k) * w0 * cn
    return L * np.sin(phi), -L * np.cos(phi), L * np.cos(phi) * rate, L * np.sin(phi) * rate


def test_elliptic_functions_give_the_published_rows(reference):
    for row in reference("simple_pendulum")["reference"]:
        published = [float(row[key]) for key in ("x", "y", "vx", "vy")]
        assert pendulum(float(row["t"])) == pytest.approx(published, abs=1e-13)


def test_pendulum(model, order, method):
    found = [mbdsl.simulate(model("pendulum"), method=method, step=h, stop=2.0, interval=0.125) for h in STEPS]
    for key, exact in zip(("x", "y", "vx", "vy"), pendulum(found[0].t), strict=True):
        errors = [np.abs(f[f"mass.{key}"] - exact).max() for f in found]
        assert LOW < order(STEPS, errors) < HIGH, key
    # tension of the rod, m (v^2/L - y g/L); its reaction on the mass points to the origin
    _, y, vx, vy = pendulum(found[0].t)
    tension = vx**2 + vy**2 - G * y
    errors = [np.abs(np.hypot(f["rod.fx"], f["rod.fy"]) - tension).max() for f in found]
    assert LOW < order(STEPS, errors) < HIGH
    assert found[-1]["rod.fy"][8] == pytest.approx(-tension[8] * y[8], rel=1e-3)


# -- driven crank ----------------------------------------------------------------------------------------------


def driven_crank(t, r=0.3, l=0.6, w=2 * np.pi, phi0=np.pi / 6, m1=3.0, m2=0.9, m3=0.5):
    """Positions of the driven slider crank, and its drive's torque by the balance of power."""
    th = phi0 + w * t
    u = r / l * np.sin(th)
    ph = -np.arcsin(u)
    root = np.sqrt(1 - u**2)
    du, ddu = r / l * np.cos(th) * w, -r / l * np.sin(th) * w**2
    dph = -du / root
    ddph = -ddu / root - u * du**2 / root**3
    x = r * np.cos(th) + l * np.cos(ph)
    vx = -r * np.sin(th) * w - l * np.sin(ph) * dph
    ax = -r * np.cos(th) * w**2 - l * np.cos(ph) * dph**2 - l * np.sin(ph) * ddph
    c = np.array([r * np.cos(th) + l / 2 * np.cos(ph), r * np.sin(th) + l / 2 * np.sin(ph)])
    v = np.array([-r * np.sin(th) * w - l / 2 * np.sin(ph) * dph, r * np.cos(th) * w + l / 2 * np.cos(ph) * dph])
    a = np.array(
        [
            -r * np.cos(th) * w**2 - l / 2 * (np.cos(ph) * dph**2 + np.sin(ph) * ddph),
            -r * np.sin(th) * w**2 - l / 2 * (np.sin(ph) * dph**2 - np.cos(ph) * ddph),
        ]
    )
    power = m2 * (v * a).sum(axis=0) + m2 * l**2 / 12 * dph * ddph + m3 * vx * ax
    power = power + m1 * G * r / 2 * np.cos(th) * w + m2 * G * v[1]
    return {
        "crank.phi": th, "rod.phi": ph, "rod.w": dph, "slider.x": x, "slider.vx": vx,
        "rod.x": c[0], "rod.vy": v[1], "drive.tau": power / w,
    }  # fmt: skip


@pytest.mark.parametrize("h", STEPS)
def test_driven_crank_is_a_matter_of_kinematics(model, h):
    """There is no degree of freedom: all results are exact to rounding at any step, including the reactions."""
    found = mbdsl.simulate(model("driven_crank"), step=h, stop=1.0, interval=0.125)
    for name, value in driven_crank(found.t).items():
        assert np.abs(found[name] - value).max() < 1e-12 * max(1.0, np.abs(value).max()), name


def test_driven_crank(model, order, method):
    """As a differential-algebraic equation, which only the general computation solves."""
    driven = model("driven_crank")
    found = [mbdsl.simulate(driven, method=method, step=h, stop=1.0, interval=0.125, general=True) for h in STEPS]
    exact = driven_crank(found[0].t)
    for name in ("crank.phi", "rod.phi", "slider.x", "rod.x"):
        # no degree of freedom is left: positions satisfy the constraints, to Newton's tolerance of 1e-4 h^4 |a|
        assert max(np.abs(f[name] - exact[name]).max() for f in found) < 1e-10, name
    late = (
        found[0].t >= 0.5
    )  # the drive starts with a jump of the discrete accelerations, which hht damps in some 50 steps
    for name in ("rod.w", "slider.vx", "rod.vy", "drive.tau"):
        errors = [np.abs(f[name] - exact[name])[late].max() for f in found]
        exactly = {"hht-si2": name != "drive.tau", "nstiff-si2": name != "drive.tau", "hht-add": True}
        if exactly.get(method, False):  # velocities follow from the constraints, and hht-add's reactions from them
            assert max(errors) < 1e-10, name
        else:
            assert LOW < order(STEPS, errors) < HIGH, name


# -- oscillators and free flight -------------------------------------------------------------------------------


def oscillator(t, s1, m=2.0, k=200.0, c=4.0, s0=0.5):
    d, s = c / (2 * m), s0 + m * G / k
    w = np.sqrt(k / m - d**2)
    A, B = s1 - s, d * (s1 - s) / w
    e = np.exp(-d * t)
    x = e * (A * np.cos(w * t) + B * np.sin(w * t))
    return s + x, -d * x + e * w * (B * np.cos(w * t) - A * np.sin(w * t))


def test_spring_mass_damper(model, order, method):
    found = [mbdsl.simulate(model("spring_mass"), method=method, step=h, stop=2.0, interval=0.125) for h in STEPS]
    s, v = oscillator(found[0].t, 0.7)
    assert LOW < order(STEPS, [np.abs(f["slide.s"] - s).max() for f in found]) < HIGH
    assert LOW < order(STEPS, [np.abs(f["slide.v"] - v).max() for f in found]) < HIGH
    # the force is k (s - s0) + c v of the computed states, so its error is that of the states
    bound = 200 * np.abs(found[-1]["slide.s"] - s).max() + 4 * np.abs(found[-1]["slide.v"] - v).max()
    assert found[-1]["spring.force"] == pytest.approx(200 * (s - 0.5) + 4 * v, rel=1e-12, abs=bound)


@pytest.mark.parametrize("h", [0.1, 0.013])
def test_free_flight_is_exact(method, h):
    """Accelerations are constant: the formulas for q and v are exact, at any step, up to rounding of the steps."""
    b = Builder("Flight")
    ground = b.Ground("ground")
    stone = b.Body("stone", m=2.0, I=0.1, com=(0.1, 0.2))
    b.FreeMotion("free", ground, stone.c)
    for name, value in {"x": 1.0, "y": 2.0, "phi": 0.3, "vx": 3.0, "vy": 4.0, "w": 5.0}.items():
        b.initial(getattr(stone, name), value)
    found = mbdsl.simulate(b, method=method, step=h, stop=1.0, interval=0.05)
    t = found.t
    assert found["stone.x"] == pytest.approx(1 + 3 * t, abs=1e-13)
    assert found["stone.y"] == pytest.approx(2 + 4 * t - G / 2 * t**2, abs=1e-13)
    assert found["stone.vy"] == pytest.approx(4 - G * t, abs=1e-12)
    assert found["stone.phi"] == pytest.approx(0.3 + 5 * t, abs=1e-13)
    assert found["stone.ay"] == pytest.approx(np.full(len(t), -G), rel=1e-13)


def test_follower_force(order, method):
    """A force F fixed in a body that spins at w: velocity F/(m w) (sin wt, 1 - cos wt), a cycloid."""
    b = Builder("Follower")
    ground = b.Ground("ground", g=0.0)
    body = b.Body("body", m=2.0, I=0.5)
    b.FreeMotion("free", ground, body.c)
    b.Force("thrust", body.c, body.c, fx=3.0)
    b.initial(body.w, 4.0)
    found = ends(b.scene(), method, 1.0)
    r = 3.0 / (2.0 * 4.0)
    exact = {
        "body.vx": r * np.sin(4.0),
        "body.vy": r * (1 - np.cos(4.0)),
        "body.x": r / 4 * (1 - np.cos(4.0)),
        "body.y": r * (1 - np.sin(4.0) / 4),
    }
    for name, value in exact.items():
        assert LOW < order(STEPS, [abs(f[name][-1] - value) for f in found]) < HIGH, name


def test_double_pendulum_of_distances(order, method):
    """Two point masses on massless links against DOP853 on the two angles (textbook equations)."""
    b = Builder("DoublePendulum")
    ground = b.Ground("ground")
    p1, p2 = b.PointMass("p1", m=1.0), b.PointMass("p2", m=2.0)
    b.Distance("l1", ground, p1, length=1.0)
    b.Distance("l2", p1, p2, length=0.5)
    b.initial(p1.x, 1.0)
    b.initial(p1.y, 0.0, fixed=False)
    b.initial(p2.x, 1.5)
    b.initial(p2.y, 0.0, fixed=False)
    m1, m2, l1, l2 = 1.0, 2.0, 1.0, 0.5

    def rhs(t, y):  # angles from -y
        a, c, da, dc = y
        M = np.array([[(m1 + m2) * l1, m2 * l2 * np.cos(a - c)], [m2 * l1 * np.cos(a - c), m2 * l2]])
        f = [
            -m2 * l2 * dc**2 * np.sin(a - c) - (m1 + m2) * G * np.sin(a),
            m2 * l1 * da**2 * np.sin(a - c) - m2 * G * np.sin(c),
        ]
        return [da, dc, *np.linalg.solve(M, f)]

    a, c, da, dc = solve_ivp(rhs, (0, 1), [np.pi / 2] * 2 + [0.0] * 2, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    exact = {
        "p1.x": l1 * np.sin(a),
        "p2.y": -l1 * np.cos(a) - l2 * np.cos(c),
        "p2.vx": l1 * np.cos(a) * da + l2 * np.cos(c) * dc,
    }
    found = ends(b.scene(), method, 1.0)
    for name, value in exact.items():
        assert LOW < order(STEPS[1:], [abs(f[name][-1] - value) for f in found[1:]]) < HIGH, name


# -- four bars through their singular poses --------------------------------------------------------------------


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2"])
def test_four_bar(model, reference, order, method):
    """Two parallelograms of equal bars pass poses in which the constraints lose rank, and remain parallelograms.

    Order 2 shows at every published time; a step that ends close to such a pose disturbs single values.
    """
    steps = [2e-3, 1e-3, 5e-4]
    found = [mbdsl.simulate(model("four_bar"), method=method, step=h, stop=10.0, interval=1.0) for h in steps]
    for row in reference("four_bar_N2")["reference_N2"]:
        k = row["t"]
        if not 0 < k <= 10:
            continue
        for name, key in (("R[1].phi", "theta"), ("R[1].w", "thetadot"), ("R[1].b.x", "B0x"), ("R[1].b.vy", "B0vy")):
            errors = [abs(f[name][k] - float(row[key])) for f in found]
            assert (LOW if k == 1 else 1.7) < order(steps, errors) < (HIGH if k == 1 else 2.5), (k, name)
    assert np.abs(found[-1]["R[1].phi"] - found[-1]["R[3].phi"]).max() < 1e-8  # still parallelograms


# -- one mechanism written in two ways -------------------------------------------------------------------------


def same(first, second, names, tolerance):
    for name in names:
        assert first[name] == pytest.approx(second[name], abs=tolerance), name


def test_slider_by_slot_and_by_prismatic():
    """A point held on a line and a body held by a prismatic joint agree if no torque turns the body."""

    def crank(prismatic):
        b = Builder("Crank")
        ground = b.Ground("ground")
        link = b.Rod("link", m=1.0, length=0.5)
        b.Revolute("pin", ground, link.a)
        rod = b.Rod("rod", m=1.0, length=1.0)
        b.Revolute("knee", link.b, rod.a)
        slider = b.Body("slider", m=0.7, I=0.2)
        b.Revolute("wrist", rod.b, slider.c)
        if prismatic:
            b.Prismatic("guide", ground, slider.c)
        else:
            b.PointOnLine("guide", ground, slider.c)
        b.initial(link.phi, 0.5)
        b.initial(slider.x, 1.4, fixed=False)
        b.initial(slider.phi, 0.0)
        return mbdsl.simulate(b, method="hht-si2", step=1e-3, stop=1.0)

    by_slot, by_joint = crank(False), crank(True)
    same(by_slot, by_joint, ["link.phi", "slider.x", "slider.vx", "guide.s", "guide.v"], 1e-8)
    assert np.ptp(by_joint["slider.x"]) > 0.1


def test_springs_along_a_line_and_between_points():
    """On a line whose ends do not pass each other, both kinds of spring and damper are equivalent."""

    def hung(kind):
        b = Builder("Hung")
        b.Ground("ground", frames={"hook": (0.2, 0.1, -0.4)}, n=(np.cos(-0.4), np.sin(-0.4)))
        block = b.Body("block", m=1.5, I=0.1)
        slide = b.Prismatic("slide", "ground.hook", block.c)
        b.add(kind, "spring", "ground.hook", block.c, k=80.0, c=1.0, s0=0.6)
        b.initial(slide.s, 0.7)
        return mbdsl.simulate(b, method="hht-i3", step=1e-3, stop=2.0)

    along, between = hung("TranslationalSpringDamper"), hung("SpringDamper")
    assert along["slide.s"].min() > 0.3
    same(along, between, ["slide.s", "slide.v", "spring.s"], 1e-8)


def test_bushing_and_springs():
    """A bushing in world axes is a spring along x, one along y, and one that turns."""
    k, c = (50.0, 80.0), (1.0, 2.0)

    def mounted(bushing):
        b = Builder("Mounted")
        ground = b.Ground("ground", frames={"up": (0.0, 0.0, np.pi / 2)})
        body = b.Body("body", m=1.0, I=0.1)
        if bushing:
            b.Bushing("mount", ground, body.c, k=k, c=c, k_phi=3.0, c_phi=0.1)
        else:
            b.TranslationalSpringDamper("x", ground, body.c, k=k[0], c=c[0])
            b.TranslationalSpringDamper("y", "ground.up", body.c, k=k[1], c=c[1])
            b.RotationalSpringDamper("phi", ground, body.c, k=3.0, c=0.1)
        for name, value in {"x": 0.1, "y": 0.3, "phi": 0.5}.items():
            b.initial(getattr(body, name), value)
        return mbdsl.simulate(b, method="hht-si2", step=1e-3, stop=1.0)

    one, three = mounted(True), mounted(False)
    same(one, three, ["body.x", "body.y", "body.phi", "body.vx", "body.w", "energy.total"], 1e-8)
    # x alone is an oscillator of its own
    d, w = 0.5, np.sqrt(50 - 0.25)
    t = one.t
    assert one["body.x"] == pytest.approx(0.1 * np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t)), abs=1e-5)


@pytest.mark.parametrize(("angle", "mirror"), [(0.7, 1), (2.9, 1), (0.0, -1), (-1.3, -1)])
def test_turned_and_mirrored_worlds(method, angle, mirror):
    """A mechanism in a turned (or mirrored) world moves as the turned (or mirrored) mechanism.

    The residual error of Newton's method is 1e-4 of the local error; ten times that is allowed, relative to the
    discretisation error as halving the step shows it.
    """

    def built(angle, mirror, h=1e-3):
        c, s = np.cos(angle), np.sin(angle)

        def place(x, y, phi=0.0):
            y, phi = mirror * y, mirror * phi
            return c * x - s * y, s * x + c * y, angle + phi

        gx, gy, _ = place(0.0, -1.0)
        b = Builder("World")
        ground = b.Ground("ground", n=(gx, gy), frames={"rail": place(0.1, -0.2, 0.3), "wall": place(2.0, 0.5)})
        crank, rod = b.Rod("crank", m=1.0, length=0.4), b.Rod("rod", m=2.0, length=1.0)
        b.Revolute("pin", ground, crank.a)
        b.Revolute("knee", crank.b, rod.a)
        b.PointOnLine("slot", "ground.rail", rod.b)
        b.SpringDamper("spring", "ground.wall", rod.b, k=30.0, c=1.0, s0=0.5)
        b.RotationalSpringDamper("twist", crank.b, rod.a, k=1.0)
        b.initial(crank.phi, place(0, 0, 0.6)[2])
        b.initial(rod.phi, place(0, 0, -0.5)[2], fixed=False)
        b.initial(crank.w, 2.0 * mirror)
        return mbdsl.simulate(b, method=method, step=h, stop=0.5), np.array([[c, -s], [s, c]]) * (1, mirror)

    (plain, _), (coarse, _), (turned, R) = built(0.0, 1), built(0.0, 1, 2e-3), built(angle, mirror)

    def equal(expected, found, error):
        assert np.abs(np.subtract(expected, found)).max() < 1e-3 * np.abs(error).max()

    def error(name):
        return plain[name] - coarse[name]

    for x, y in [(f"{a}.{b}x", f"{a}.{b}y") for a, b in (("crank", ""), ("rod", ""), ("rod", "v"), ("knee", "f"))]:
        expected = R @ (plain[x], plain[y])
        equal(expected, (turned[x], turned[y]), (error(x), error(y)))
    for name in ("crank.phi", "rod.phi"):
        equal(mirror * plain[name] + angle, turned[name], error(name))
    equal(np.diff(plain["energy.total"]), np.diff(turned["energy.total"]), error("energy.total"))
