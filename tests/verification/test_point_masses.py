"""Point masses: frames with an attitude of their own, welds, and sliding joints, against closed forms and SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl

both = pytest.mark.parametrize("spatial", ["", "spatial "])

PENDULUM = """model Pendulum
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  PointMass tip(m = 2 kg);
  Revolute pin(ground, rod.a);
  Fixed weld(rod.b, tip);
  annotation(experiment(StopTime = 0.5 s, Interval = 0.1 s, Tolerance = 1e-9));
end Pendulum;"""


def solved(rate, start, t):
    return solve_ivp(rate, (0.0, t[-1]), start, "DOP853", t, rtol=1e-11, atol=1e-12).y


@both
@pytest.mark.parametrize("ends", ["rod.b, tip", "tip, rod.b"])
@pytest.mark.parametrize("general", [False, True])
def test_rod_with_a_mass_at_its_tip(spatial, ends, general):
    """A physical pendulum: (1/3 m + M) phi'' = -(m/2 + M) g cos(phi); the weld carries weight and acceleration of M."""
    run = mbdsl.simulate(mbdsl.parse(spatial + PENDULUM.replace("rod.b, tip", ends)), general=general)
    phi, w = solved(lambda t, y: [y[1], -2.5 * 9.81 / (7 / 3) * np.cos(y[0])], [0.0, 0.0], run.t)
    assert run["pin.phi"] == pytest.approx(phi, abs=1e-7)
    assert run["tip.phi"] == pytest.approx(phi, abs=1e-7)
    force = 2.0 * (-(w**2) * np.cos(phi) + 2.5 * 9.81 / (7 / 3) * np.cos(phi) * np.sin(phi))
    assert run["weld.fx"] * (1 if ends == "rod.b, tip" else -1) == pytest.approx(force, abs=1e-5)


@both
def test_small_motions_of_a_rod_with_a_mass(spatial):
    (mode,) = mbdsl.eigen(mbdsl.parse(spatial + PENDULUM))
    assert mode.eigenvalue == pytest.approx(1j * np.sqrt(2.5 * 9.81 / (7 / 3)), rel=1e-8)


@both
def test_chain_of_welds(spatial):
    """A rod, a point mass, a second rod at 40 deg, another point mass: one pendulum, with a spring and a force."""
    text = f"""{spatial}model Chain
      Ground ground;
      Rod a(m = 1 kg, length = 1 m);
      PointMass p(m = 3 kg);
      Rod b(m = 2 kg, length = 0.5 m);
      PointMass q(m = 0.7 kg);
      Revolute pin(ground, a.a);
      Fixed w1(a.b, p);
      Fixed w2(p, b.a, phi0 = 40 deg);
      Fixed w3(q, b.b);
      SpringDamper spring(q, ground, k = 30 N/m, c = 2 N.s/m, s0 = 0.2 m);
      Force push(p, fx = 3 N, fy = 10 N/s*time);
    initial equation
      pin.phi = 0.3 rad;
      annotation(experiment(StopTime = 0.5 s, Interval = 0.1 s, Tolerance = 1e-9));
    end Chain;"""
    run = mbdsl.simulate(mbdsl.parse(text))
    e = np.exp(1j * np.deg2rad(40.0))
    points = np.array([0.5, 1.0, 1.0 + 0.25 * e, 1.0 + 0.5 * e])
    m = np.array([1.0, 3.0, 2.0, 0.7])
    J = m @ np.abs(points) ** 2 + 1.0 / 12 + 2.0 * 0.5**2 / 12
    length = abs(points[3])

    def rate(t, y):
        at = points * np.exp(1j * y[0])
        turn = -9.81 * (m @ at.real) + at[1].real * 10.0 * t - at[1].imag * 3.0  # the spring points at the pin
        return [y[1], turn / J]

    phi, w = solved(rate, [0.3, 0.0], run.t)
    assert run["pin.phi"] == pytest.approx(phi, abs=1e-7)
    assert run["spring.force"] == pytest.approx(30.0 * (length - 0.2), rel=1e-7)
    # the second weld moves all that hangs on it, and holds it against the spring
    alpha = np.array([rate(*x)[1] for x in zip(run.t, np.transpose([phi, w]), strict=True)])
    turned = np.exp(1j * phi)
    moved = (1j * alpha - w**2) * turned * (m[2:] @ points[2:]) + 1j * 9.81 * m[2:].sum()
    moved += 30.0 * (length - 0.2) * points[3] / length * turned
    assert run["w2.fx"] + 1j * run["w2.fy"] == pytest.approx(moved, abs=2e-5)


@both
def test_bead_on_an_arm(spatial):
    """A sliding joint to a point mass leaves the arm free to turn: s'' = s w^2, (I + m s^2) w constant."""
    text = f"""{spatial}model Bead
      Ground ground(g = 0);
      Body arm(m = 1 kg, I = 1 kg.m2);
      PointMass bead(m = 2 kg);
      Revolute pin(ground, arm.c);
      Prismatic slide(arm.c, bead);
    initial equation
      pin.phi = 0.2 rad; pin.w = 3 rad/s; slide.s = 0.5 m; slide.v = 0 m/s;
      annotation(experiment(StopTime = 0.5 s, Interval = 0.1 s, Tolerance = 1e-9));
    end Bead;"""
    run = mbdsl.simulate(mbdsl.parse(text))
    w = lambda s: 3.0 * (1.0 + 2.0 * 0.25) / (1.0 + 2.0 * s**2)  # noqa: E731
    phi, s, _ = solved(lambda t, y: [w(y[1]), y[2], y[1] * w(y[1]) ** 2], [0.2, 0.5, 0.0], run.t)
    assert run["slide.s"] == pytest.approx(s, abs=1e-7)
    assert run["pin.phi"] == pytest.approx(phi, abs=1e-7)


@pytest.mark.parametrize(
    "guide",
    [
        "spatial model M Ground ground; Prismatic s(ground, p, n = {0, 1, 0});",
        "spatial model M Ground ground; Frame up(ground, phi = 90 deg); Prismatic s(up, p);",
        "model M Ground ground; Frame up(ground, phi = 90 deg); Prismatic s(up, p);",
        "model M Ground ground; Frame up(ground, phi = 60 deg); Frame t(p, phi = -30 deg); Prismatic s(t, up);",
    ],
)
def test_vertical_guide(guide):
    """A point mass falls, along the axis of the ground's frame or of its own."""
    run = mbdsl.simulate(mbdsl.parse(guide + " PointMass p(m = 2 kg); end M;"), stop=0.3, tol=1e-9)
    fall = 9.81 * np.sin(np.deg2rad(60.0)) ** 2 if "t(p" in guide else 9.81  # the guide turns its frame to 60 deg
    assert run["p.y"] == pytest.approx(-0.5 * fall * run.t**2, abs=1e-9)


def test_spring_along_an_axis_of_a_point_mass_in_the_plane():
    """k = 100 N/m along y, from a point mass of 3 kg at y = 0.3 m to a table that cannot move along y."""
    text = """model M
      Ground ground(g = 0);
      Body table(m = 1 kg, I = 0.1 kg.m2);
      Prismatic rail(ground, table.c);
      PointMass w1(m = 3 kg);
      FreeMotion floor(ground, w1);
      Frame up(w1, phi = 90 deg);
      TranslationalSpringDamper s(up, table.c, k = 100 N/m);
    initial equation
      rail.s = 0.4 m; w1.x = 0 m; w1.y = 0.3 m; w1.vx = 0 m/s; w1.vy = 0 m/s; rail.v = 0 m/s;
    end M;"""
    for general in (False, True):
        run = mbdsl.simulate(mbdsl.parse(text), stop=0.5, tol=1e-10, general=general)
        y = 0.3 * np.cos(np.sqrt(100.0 / 3.0) * run.t)
        assert run["w1.y"] == pytest.approx(y, abs=1e-8)
        assert run["s.s"] == pytest.approx(-y, abs=1e-8) and run["s.force"] == pytest.approx(-100 * y, abs=1e-6)
        assert run["energy.total"] == pytest.approx(4.5, rel=1e-8)


@pytest.mark.parametrize("n", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.48, -0.6, 0.64)])
@pytest.mark.parametrize("point", ["w1", "turned"])
def test_spring_along_an_axis_of_a_point_mass_in_space(n, point):
    """It pulls along n, with its own length along n, and has the energy k s^2/2."""
    text = f"""spatial model M
      Ground ground(g = 0);
      PointMass w1(m = 3 kg);
      Frame turned(w1, phi = 90 deg, n = {{0, 0, 1}});
      Body b(m = 1 kg, I = 0.01 kg.m2);
      FreeMotion f(ground, w1); FreeMotion g(ground, b.c);
      TranslationalSpringDamper s({point}, b.c, k = 100 N/m, n = {{{n[0]}, {n[1]}, {n[2]}}});
    initial equation
      b.x = 0.1 m; b.y = 0.2 m; b.z = 0.3 m; w1.x = 0; w1.y = 0; w1.z = 0;
    end M;"""
    axis = np.array(n) if point == "w1" else np.array([-n[1], n[0], n[2]])
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.0)
    s = axis @ [0.1, 0.2, 0.3]
    assert run["s.s"][0] == pytest.approx(s, abs=1e-12)
    # equal and opposite forces; the body carries the moment, and turns only later
    assert [run[f"b.a{i}"][0] for i in "xyz"] == pytest.approx(list(-100.0 * s * axis), abs=1e-9)
    assert [run[f"w1.a{i}"][0] for i in "xyz"] == pytest.approx(list(100.0 / 3.0 * s * axis), abs=1e-9)
    assert run["energy.total"][0] == pytest.approx(50.0 * s**2, rel=1e-12)


@pytest.mark.parametrize(("spatial", "r"), [("", "{0.1, 0}"), ("spatial ", "{0, 0, 0.1}")])
def test_frames_beside_a_point_mass(spatial, r):
    with pytest.raises(mbdsl.ModelError, match="`up` is not at the point mass `p`, which has no extent") as caught:
        mbdsl.parse(f"{spatial}model M Ground g; PointMass p(m = 1 kg); Frame up(p, r = {r} m); end M;")
    assert "Body p(m = ..., I = ..., frames(up = ...))" in str(caught.value)


def test_frames_of_one_point_mass_have_attitudes_of_their_own():
    """Three frames turned by 0, 30 and 100 deg: bushings pull along the axes of the first frame, k R diag(1, 0) R^T."""
    angles, d = (0.0, 30.0, 100.0), np.array([0.1, 0.02])
    springs = "".join(
        f"Frame f{k}(p, phi = {x} deg); Bushing s{k}(f{k}, o, k = {{{100 * (k + 1)} N/m, 0}});\n"
        for k, x in enumerate(angles)
    )
    text = f"""model Frames
      Ground ground(g = 0);
      Frame o(ground, r = {{0.1 m, 0.02 m}});
      PointMass p(m = 2 kg);
      {springs}
    initial equation
      p.x = 0 m; p.y = 0 m;
      annotation(experiment(StopTime = 1 ms));
    end Frames;"""
    run = mbdsl.simulate(mbdsl.parse(text), step=1e-3)
    along = [np.array([np.cos(np.radians(x)), np.sin(np.radians(x))]) for x in angles]
    force = sum(100.0 * (k + 1) * (e @ d) * e for k, e in enumerate(along))
    assert [run["p.ax"][0], run["p.ay"][0]] == pytest.approx(force / 2.0, rel=1e-9)
