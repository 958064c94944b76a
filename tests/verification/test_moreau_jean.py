"""The method of Moreau and Jean against closed forms, an ODE solver, and published numbers of a woodpecker toy."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.errors import IntegrationError, UsageError

MODELS = Path(__file__).parents[2] / "models"
MACHINES = Path(__file__).parents[1] / "data" / "machines"
G = 9.81


def run(text, step, stop, **more):
    return mbdsl.simulate(mbdsl.parse(text), method="moreau-jean", step=step, stop=stop, **more)


def slopes(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


# -- without contacts -----------------------------------------------------------------------------------------------

PENDULUM = """model M
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a, mu = 0.3, radius = 0.1 m, w_s = 0.1 rad/s);
initial equation
  pin.phi = -30 deg; pin.w = 2 rad/s;
end M;"""


def pendulum(t, y):
    """Its reaction N, of which friction of the pin takes mu N r tanh(w/w_s), depends on the acceleration."""
    phi, w = y
    rub, alpha = 0.03 * np.tanh(w / 0.1), 0.0
    for _ in range(50):
        n, s = -0.5 * w**2 + G * np.sin(phi), 0.5 * alpha + G * np.cos(phi)
        alpha = 3.0 * (-0.5 * G * np.cos(phi) - rub * np.hypot(n, s))
    return w, alpha


def test_order_2_with_constraints_and_friction_of_joints():
    exact = solve_ivp(pendulum, (0.0, 0.5), (-np.pi / 6, 2.0), rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
    errors = []
    for step in (1 / 200, 1 / 400, 1 / 800):
        found = run(PENDULUM, step, 0.5)
        errors.append(np.abs(exact - [found["pin.phi"][-1], found["pin.w"][-1]]))
        assert np.abs(found["pin.Phi[1]"]).max() < 1e-12 and np.abs(found["pin.dPhi[2]"]).max() < 1e-10
    assert slopes(errors) == pytest.approx(2.0, abs=0.02)


def test_order_2_of_states_and_stiff_springs():
    """A filter x' = (u - x)/T drives an oscillator; a stiff spring beside it stays at rest, whatever the step."""
    text = """model M
      Ground ground;
      Body a(m = 1 kg, I = 1 kg.m2), b(m = 1 kg, I = 1 kg.m2);
      Prismatic one(ground, a.c), two(ground, b.c);
      TranslationalSpringDamper soft(one, k = 100 N/m), stiff(two, k = 1e12 N/m, c = 1e3 N.s/m);
      Real x(start = 0);
      Force f(a.c, fx = 10 N*x);
    initial equation
      one.s = 0 m; one.v = 0 m/s; two.s = 0 m; two.v = 0 m/s;
    equation
      der(x) = (1 - x)/(0.1 s);
    end M;"""
    exact = solve_ivp(
        lambda t, y: (y[1], 10 * y[2] - 100 * y[0], 10 * (1 - y[2])), (0, 1), (0, 0, 0), rtol=1e-11, atol=1e-12
    ).y[:, -1]
    errors = []
    for step in (1 / 50, 1 / 100, 1 / 200):
        found = run(text, step, 1.0)
        errors.append(np.abs(exact - [found[name][-1] for name in ("one.s", "one.v", "x")]))
        np.testing.assert_array_equal(found["two.s"], 0.0)
    assert slopes(errors) == pytest.approx(2.0, abs=0.1)


def test_theta_damps_stiff_vibrations():
    text = """model M
      Ground ground;
      Body a(m = 1 kg, I = 1 kg.m2);
      Prismatic one(ground, a.c);
      TranslationalSpringDamper stiff(one, k = 1e10 N/m);
    initial equation
      one.s = 1e-6 m; one.v = 0 m/s;
    end M;"""
    half, one = run(text, 0.01, 1.0), run(text, 0.01, 1.0, options={"theta": 1.0})
    assert half["energy.total"][-1] == pytest.approx(half["energy.total"][0], rel=1e-6)
    assert one["energy.total"][-1] < 1e-10 * one["energy.total"][0]


# -- impacts ----------------------------------------------------------------------------------------------------------

BALL = """model Ball
  Ground ground;
  PointMass p(m = 2 kg);
  Contact floor(gap = p.y, e = 0.8);
initial equation
  p.x = 0 m; p.y = 1 m; p.vx = 0 m/s; p.vy = 0 m/s;
end Ball;"""


def test_order_1_across_impacts():
    """The height after an impact. The error depends on where in a step the impact is: the mean of several steps."""
    first = np.sqrt(2 / G)
    rest = 1.0 - first
    exact = 0.8 * G * first * rest - G * rest**2 / 2

    def error(step):
        steps = round(1.0 / step) + np.arange(0, 16)
        return np.sqrt(np.mean([(run(BALL, 1.0 / n, 1.0)["p.y"][-1] - exact) ** 2 for n in steps]))

    errors = [error(1e-2), error(2.5e-3)]
    assert errors[0] < 2 * 1e-2 and slopes(errors) / 2 == pytest.approx(1.0, abs=0.1)


def test_ball_comes_to_rest():
    """All impacts end at t1 (1 + e)/(1 - e) = 4.06 s; then the floor carries m g. Energy does not grow by more than
    the work of the weight over the way of half a step before the ball rests, m (g h)^2/8."""
    found = run(BALL, 2e-3, 5.0, interval=2e-3)
    last = 9 * np.sqrt(2 / G)
    rests = found.t > last + 0.02
    assert found["floor.force"][rests] == pytest.approx(2 * G, rel=1e-9)
    np.testing.assert_array_equal(found["floor.active"][rests], 1.0)
    np.testing.assert_array_equal(found["floor.active"][found.t < last - 0.05], 0.0)
    assert 10 < found["floor.impacts"][-1] < 40
    assert np.ptp(found["floor.impacts"][rests]) == 0
    assert -2e-3 * np.sqrt(2 * G) < found["floor.gap"][-1] <= 0.0
    assert np.diff(found["energy.total"]).max() < 2 * (G * 2e-3) ** 2 / 8 + 1e-12
    first = np.searchsorted(found.t, np.sqrt(2 / G) + 4e-3)
    # the impact is up to a step late, in which the weight adds g h to the speed
    assert 0.0 <= found["floor.impulse"][first] - 2 * 1.8 * np.sqrt(2 * G) <= 2 * 1.8 * G * 2e-3


CRADLE = """model Cradle
  Ground ground(g = 0 m/s2);
  PointMass p[3](each m = 1 kg);
  Contact a(gap = p[2].x - p[1].x - 0.1 m, e = {e}, impacts = "{impacts}");
  Contact b(gap = p[3].x - p[2].x - 0.1 m, e = {e}, impacts = "{impacts}");
initial equation
  p[1].x = -0.01 m; p[2].x = 0.1 m; p[3].x = 0.2 m; p[1].vx = 1 m/s; p[2].vx = 0 m/s; p[3].vx = 0 m/s;
  for i in 1:3 loop
    p[i].y = 0 m; p[i].vy = 0 m/s;
  end for;
end Cradle;"""


@pytest.mark.parametrize(
    ("impacts", "e", "speeds"),
    [
        ("sequential", 1, (0, 0, 1)),
        ("simultaneous", 1, (-1 / 3, 2 / 3, 2 / 3)),
        ("sequential", 0.9, (0.047625, 0.049875, 0.9025)),
        ("sequential", 0, (1 / 3, 1 / 3, 1 / 3)),
    ],
)
def test_cradle(impacts, e, speeds):
    found = run(CRADLE.format(impacts=impacts, e=e), 1e-3, 0.1)
    assert [found[f"p[{i}].vx"][-1] for i in (1, 2, 3)] == pytest.approx(speeds, abs=1e-9)


ROD = """model Rod
  Ground ground(g = 0 m/s2);
  Body b(m = 1 kg, I = 0.02 kg.m2, frames(a = {-0.2 m, 0}, c2 = {0.3 m, 0.05 m}));
  Contact x1(gap = b.a.x + 0.5 m, slip = b.a.vy, mu = 0.6, e = 0.9);
  Contact x2(gap = 0.5 m - b.c2.x, slip = b.c2.vy, mu = 0.6, e = 1);
  Contact y1(gap = b.a.y + 0.4 m, slip = b.a.vx, mu = 0.6, e = 1);
  Contact y2(gap = 0.4 m - b.c2.y, slip = b.c2.vx, mu = 0.6, e = 0.9);
  Contact y3(gap = b.c2.y + 0.4 m, slip = b.c2.vx, mu = 0.6, e = 0.9);
  Contact y4(gap = 0.4 m - b.a.y, slip = b.a.vx, mu = 0.6, e = 1);
initial equation
  b.x = 0 m; b.y = 0 m; b.phi = 0.2; b.vx = 3 m/s; b.vy = -2 m/s; b.w = 9 rad/s;
end Rod;"""


def test_energy_never_grows_in_impacts_with_friction():
    found = run(ROD, 2e-3, 4.0, interval=2e-3)
    energy = found["energy.total"]
    assert sum(found[f"{name}.impacts"][-1] for name in ("x1", "x2", "y1", "y2", "y3", "y4")) > 10
    assert np.diff(energy).max() <= 1e-12 * energy[0]


def test_stack_of_many_contacts():
    """Eight blocks on each other: contact i carries those above it; all modes of the step before are tried first."""
    touch = "Contact c{1}(gap = p[{1}].y - p[{0}].y - 0.1 m, slip = p[{1}].vx - p[{0}].vx, mu = 0.5, e = 0.3);"
    text = f"""model Stack
      Ground ground;
      PointMass p[8](each m = 0.5 kg);
      Contact c1(gap = p[1].y, slip = p[1].vx, mu = 0.5, e = 0.3);
      {" ".join(touch.format(i, i + 1) for i in range(1, 8))}
    initial equation
      for i in 1:8 loop
        p[i].x = 0 m; p[i].y = 0.1 m*i - 0.1 m; p[i].vx = 0 m/s; p[i].vy = 0 m/s;
      end for;
    end Stack;"""
    found = run(text, 1e-3, 0.05)
    forces = [found[f"c{i}.force"][-1] for i in range(1, 9)]
    assert forces == pytest.approx([0.5 * G * (8 - i) for i in range(8)], rel=1e-6)
    assert max(np.ptp(found[f"p[{i}].y"]) for i in range(1, 9)) < 1e-8


# -- friction ---------------------------------------------------------------------------------------------------------


def test_coulomb_oscillator():
    """Each half period of pi/10 s takes 2 mu N/k = 4 cm of the amplitude: it rests at 1 cm, from 6 pi/10 s on."""
    text = """model Oscillator
      Ground ground;
      PointMass p(m = 1 kg);
      Force spring(p, fx = -100 N/m*p.x);
      Contact floor(gap = p.y, slip = p.vx, mu = 2/9.81, e = 0);
    initial equation
      p.x = 0.25 m; p.y = 0 m; p.vx = 0 m/s; p.vy = 0 m/s;
    end Oscillator;"""
    errors = []
    for step in (4e-3, 1e-3):
        found = run(text, step, 2.0)
        errors.append(found["p.x"][-1] - 0.01)
        stops = found.t[np.flatnonzero(np.abs(found["p.vx"]) > 1e-9)[-1]]
        assert stops == pytest.approx(6 * np.pi / 10, abs=2 * step + 4e-3)
        assert found["floor.force"][-1] == pytest.approx(G, rel=1e-9)
        assert found["floor.friction"][-1] == pytest.approx(-100 * found["p.x"][-1], abs=1e-9)
        np.testing.assert_allclose(found["floor.friction"][5:40], -2.0)
        np.testing.assert_allclose(found["p.ax"][5:40], 2.0 - 100 * found["p.x"][5:40], atol=1e-9)
        assert abs(found["p.ax"][-1]) < 1e-9
        assert (found["floor.sliding"][10], found["floor.sliding"][-1]) == (-1.0, 0.0)
    assert abs(errors[0]) < 1e-4 and abs(errors[1]) < abs(errors[0]) / 4


def test_slide_across_a_slope():
    """Plane of 20 deg, mu = 0.5, 2 m/s across it: it stops at k v0/(g sin(20 deg) (k^2 - 1)), k = mu/tan(20 deg)."""
    text = """spatial model Slope
      Ground ground(g = 9.81 m/s2, n = {sin(20 deg), 0, -cos(20 deg)});
      PointMass p(m = 1 kg);
      Contact plane(gap = p.z, slip = p.vx, slip_2 = p.vy, mu = 0.5, e = 0);
    initial equation
      p.x = 0 m; p.y = 0 m; p.z = 0 m; p.vx = 0 m/s; p.vy = 2 m/s; p.vz = 0 m/s;
    end Slope;"""
    found = run(text, 2e-3, 1.2, interval=2e-3)
    speed = np.hypot(found["p.vx"], found["p.vy"])
    assert found.t[np.flatnonzero(speed > 1e-9)[-1]] == pytest.approx(0.92302284, abs=6e-3)
    assert np.abs(found["p.vz"]).max() < 1e-12 and speed[-1] < 1e-12
    assert found["plane.force"][-1] == pytest.approx(G * np.cos(np.deg2rad(20)), rel=1e-9)


def test_static_friction_is_larger():
    """A force of 1 N/s moves a block of 1 kg, mu_s = 0.5, when it exceeds 4.905 N; then mu = 0.3."""
    text = """model Block
      Ground ground;
      PointMass p(m = 1 kg);
      Force pull(p, fx = 1 N/s*time);
      Contact floor(gap = p.y, slip = p.vx, mu = 0.3, mu_s = 0.5, e = 0);
    initial equation
      p.x = 0 m; p.y = 0 m; p.vx = 0 m/s; p.vy = 0 m/s;
    end Block;"""
    found = run(text, 5e-3, 6.0, interval=5e-3)
    assert 4.905 < found.t[np.flatnonzero(found["p.vx"] > 1e-9)[0]] < 4.905 + 2 * 5e-3
    rest = 6.0 - 4.905  # it begins up to two steps late, with an acceleration of 4.905 - 2.943 m/s2
    late = (4.905 - 2.943) * rest + rest**2 / 2 - found["p.vx"][-1]
    assert 0.0 < late < 2 * 5e-3 * (4.905 - 2.943)


# -- machines ---------------------------------------------------------------------------------------------------------


def test_verge_clock():
    """Limit cycle of 0.9529336667 s (momentum at the strike, constant torque), to the error of the step."""
    found = mbdsl.simulate(MACHINES / "verge_clock.mbd", method="moreau-jean", step=5e-4, stop=2.9, interval=5e-4)
    beats = found.t[np.flatnonzero(np.diff(found["up"]) > 0)]
    assert len(beats) == 4
    assert np.diff(beats)[-1] == pytest.approx(0.9529336667, abs=4e-3)
    assert found["upper.impacts"][-1] >= 3 and np.abs(found["arbor.Phi[1]"]).max() < 1e-12


def test_a_slide_along_a_jump_of_forces():
    """x' = u - 2 sgn(x) stays at zero while |u| < 2, u = 3 - 2 t, from the time it gets there on: x = 3 t - t^2 - 2 t =
    0 at 1 s; u = -2 at 2.5 s; then x = -(t - 2.5)^2."""
    text = """model M
      Real x(start = 0);
      Ground ground;
      PointMass p(m = 1 kg);
      FreeMotion free(ground, p);
    initial equation
      p.x = 0 m; p.y = 0 m; p.vx = 0 m/s; p.vy = 0 m/s;
    equation
      der(x) = (3 - 2*time/(1 s) - (if x > 0 then 2 else -2))/(1 s);
    end M;"""
    found = run(text, 1e-3, 3.0, interval=1e-2)
    t = found.t
    exact = np.where(t < 1.0, t - t * t, np.where(t < 2.5, 0.0, -((t - 2.5) ** 2)))
    np.testing.assert_allclose(found["x"], exact, atol=5e-3)


# -- events, and what is refused --------------------------------------------------------------------------------------


def test_when_equations_at_the_ends_of_steps():
    text = BALL.replace("initial equation", "Integer k(start = 0), ticks(start = 0); initial equation").replace(
        "end Ball;",
        """equation
        when p.y < 0.5 m then k = pre(k) + 1; end when;
        when sample(0.05, 0.1) then ticks = pre(ticks) + 1; end when;
        when floor.force > 100 N then reinit(p.vx, 1 m/s); end when;
        when p.x > 0.25 m then terminate("far enough"); end when;
        end Ball;""",
    )
    found = run(text, 1e-3, 3.0)
    first = np.sqrt(2 / G)
    assert found.t[-1] == pytest.approx(first + 0.25, abs=3e-3)
    assert (found["k"][-1], found["ticks"][-1]) == (1, 7)
    assert found["p.vx"][-1] == pytest.approx(1.0, abs=1e-12)


def test_impact_at_the_start():
    found = run(BALL.replace("p.y = 1 m", "p.y = 0 m").replace("p.vy = 0 m/s", "p.vy = -1 m/s"), 1e-3, 0.1)
    assert found["p.vy"][0] == pytest.approx(0.8, abs=1e-12)
    assert found["floor.impacts"][0] == 1.0


def test_assertion():
    text = BALL.replace("end Ball;", 'equation when p.y < 0.5 m then assert(p.y > 1 m, "low"); end when; end Ball;')
    with pytest.raises(IntegrationError, match="low"):
        run(text, 1e-3, 1.0)


def test_what_is_refused():
    sticks = PENDULUM.replace("w_s = 0.1 rad/s", "sticks = true")
    with pytest.raises(UsageError, match="moreau-jean does not know friction that sticks, of `pin`"):
        run(sticks, 1e-3, 0.1)
    reads = BALL.replace("initial equation", "Force f(p, fx = 0.1*floor.force); initial equation")
    with pytest.raises(UsageError, match="solves the reaction of `floor` as an impulse: Force `f` cannot read it"):
        run(reads, 1e-3, 0.1)
    rests = mbdsl.parse(reads.replace("p.y = 1 m", "p.y = 0 m"))
    assert mbdsl.simulate(rests, method="hht-si2", step=1e-2, stop=1.0)["p.vx"][-1] == pytest.approx(0.1 * G, rel=1e-6)
    with pytest.raises(UsageError, match="no error-controlled steps"):
        mbdsl.simulate(mbdsl.parse(BALL), method="moreau-jean", tol=1e-4, stop=1.0)
    with pytest.raises(UsageError, match="moreau-jean"):
        mbdsl.Simulation(mbdsl.parse(PENDULUM), method="moreau-jean", step=1e-3)
