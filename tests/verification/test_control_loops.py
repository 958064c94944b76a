"""Control loops against their transfer functions, closed forms and SciPy; a drive of Modelica's library."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.editor import all_errors
from mbdsl.errors import InitialisationError
from mbdsl.lang.load import parse_text

PAGE = Path(__file__).parents[2] / "docs" / "from-modelica.md"
LOOP = """model Loop "speed of a rotor, J w' = kp e + ki z - c w"
  parameter Inertia J = 0.02 kg.m2;
  parameter RotationalDamping c = 0.1 N.m.s/rad, kp = 0.5 N.m.s/rad;
  parameter RotationalStiffness ki = 4 N.m/rad;
  input AngularVelocity w_ref(start = 3 rad/s);
  Ground ground;
  Body rotor(m = 1 kg, I = J);
  Revolute pin(ground, rotor.c);
  Angle z(start = 0);
  AngularVelocity error = w_ref - pin.w;
  Torque motor(pin, tau = kp*error + ki*z - c*pin.w);
initial equation
  pin.phi = 0; pin.w = 0 rad/s;
equation
  der(z) = error;
end Loop;
"""
#: numerator and denominator of w/w_ref
CLOSED = [0.5, 4.0], [0.02, 0.6, 4.0]
MOTOR = """model Motor
  parameter Resistance R = 0.5 Ohm;
  parameter Inductance L = INDUCTANCE;
  parameter Real k(unit = "N.m/A") = 0.1;
  parameter RotationalDamping c = 1e-3 N.m.s/rad;
  Ground ground;
  Body rotor(m = 1 kg, I = 2e-3 kg.m2);
  Revolute pin(ground, rotor.c);
  Current i(start = 0 A);
  Voltage back = k*pin.w;
  Torque torque(pin, tau = k*i - c*pin.w);
initial equation
  pin.phi = 0; pin.w = 0 rad/s;
equation
  der(i) = (12 V - R*i - back)/L;
end Motor;
"""


def test_pi_loop_against_its_transfer_function():
    linear = mbdsl.linearise(mbdsl.parse(LOOP), "start", ["w_ref"], ["pin.w"])
    frequencies = np.geomspace(0.05, 50.0, 40)
    _, expected = signal.freqs(*CLOSED, 2 * np.pi * frequencies)
    found = linear.bode(frequencies)
    assert found.amplitude[:, 0, 0] == pytest.approx(np.abs(expected), rel=1e-9)
    # the angle of the rotor has no influence: an integrator beside the loop
    poles = sorted(linear.poles(), key=abs)
    assert poles[0] == pytest.approx(0.0, abs=1e-12)
    assert np.sort_complex(poles[1:]) == pytest.approx(np.sort_complex(np.roots(CLOSED[1])), rel=1e-9)


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "nstiff-si2", "generalized-alpha", "radau5"])
def test_pi_loop_after_a_step(method):
    given = {"tol": 1e-8} if method == "radau5" else {"step": 2e-4}
    run = mbdsl.simulate(mbdsl.parse(LOOP), method=method, stop=1.0, interval=0.01, **given)
    _, expected = signal.step(CLOSED, T=run.t)
    assert run["pin.w"] == pytest.approx(3 * expected, abs=2e-5)


@pytest.mark.parametrize(("inductance", "oscillates"), [("1 mH", False), ("20 mH", True)])
def test_dc_motor_after_a_step(inductance, oscillates):
    """w'' + 2 D w' + w0^2 w = k u/(L J): w = w_end (1 + (s2 exp(s1 t) - s1 exp(s2 t))/(s1 - s2))."""
    R, L, k, c, J, u = 0.5, float(inductance.split()[0]) * 1e-3, 0.1, 1e-3, 2e-3, 12.0
    s1, s2 = np.roots([1.0, R / L + c / J, (k**2 + c * R) / (L * J)]).astype(complex)
    assert (abs(s1.imag) > 0) == oscillates
    run = mbdsl.simulate(mbdsl.parse(MOTOR.replace("INDUCTANCE", inductance)), tol=1e-8, stop=0.6, interval=0.01)
    end = k * u / (k**2 + c * R)
    shape = (s2 * np.exp(s1 * run.t) - s1 * np.exp(s2 * run.t)) / (s1 - s2)
    rate = s1 * s2 * (np.exp(s1 * run.t) - np.exp(s2 * run.t)) / (s1 - s2)
    assert run["pin.w"] == pytest.approx(end * (1 + shape.real), abs=1e-6 * end)
    assert run["i"] == pytest.approx((J * end * rate.real + c * end * (1 + shape.real)) / k, abs=1e-5 * u / R)


#: the drive of Modelica.Blocks.Examples.PID_Controller as its user declares it, without connections
DECLARED = """model Drive
  parameter SI.Angle way = 1.570796326794897;
  Modelica.Blocks.Sources.KinematicPTP plan(startTime = 0.5, deltaq = {way}, qd_max = {1}, qdd_max = {1});
  Modelica.Blocks.Continuous.Integrator speed(initType = Modelica.Blocks.Types.Init.InitialState);
  Modelica.Blocks.Continuous.LimPID PI(k = 100, Ti = 0.1, yMax = 12, Ni = 0.1,
    controllerType = Modelica.Blocks.Types.SimpleController.PI);
  Modelica.Mechanics.Rotational.Components.Inertia motor(phi(fixed = true, start = 0), J = 1);
  Modelica.Mechanics.Rotational.Components.Inertia load(J = 2);
  Modelica.Mechanics.Rotational.Sources.ConstantTorque weight(tau_constant = 10);
equation
  connect(motor.flange_b, load.flange_a);
end Drive;
"""


def drive_of_the_page() -> str:
    (text,) = re.findall(r"```mbd\n(// drive\.mbd\n.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    return text


def test_a_drive_of_modelica_is_brought_over_by_the_advice():
    """One message for each part, and the model on the page consists of what they say."""
    problems, _ = all_errors.find(DECLARED, "a.mbd", lambda left: parse_text(left, "a.mbd"))
    assert [p.span.line for p in problems] == [3, 4, 5, 7, 8, 9]
    text = drive_of_the_page()
    for problem in problems:
        advice = problem.hint.partition("; as in blocks")[0].partition("; elements")[0]
        statements = [x for piece in re.findall(r"`(.*?;)`", advice) for x in re.findall(r"[^;]+;", piece)]
        assert statements
        for statement in statements:  # but for what is left to the user
            for known in statement.replace("u/(1 s)", "plan/(1 s)").split("..."):
                assert known.strip(" -").replace("Torque weight(shaft", "Torque weight(load_shaft") in text


def test_the_drive_against_scipy():
    """At rest at first: the controller holds the load of 10 N.m, which has wound the shaft by 1 mrad."""
    way = np.pi / 2
    times = [0.0, 0.5, 1.5, 0.5 + way, 1.5 + way, 4.0]

    def rates(t, x, acceleration):
        p1, p2, w1, w2, integral, reference = x
        error = reference - w1
        ask = 100 * (error + integral)
        torque = np.clip(ask, -12, 12)
        shaft = 1e4 * (p2 - p1) + 100 * (w2 - w1)
        return [w1, w2, torque + shaft, (10 - shaft) / 2, (error + (torque - ask) / 10) / 0.1, acceleration]

    x, expected = np.array([0.0, 1e-3, 0.0, 0.0, -0.1, 0.0]), []
    for start, end, acceleration in zip(times, times[1:], (0, 1, 0, -1, 0), strict=False):
        given = {"args": (acceleration,), "rtol": 1e-10, "atol": 1e-12, "max_step": 1e-3}
        x = solve_ivp(rates, (start, end), x, "DOP853", **given).y[:, -1]
        expected.append(x)
    scene = mbdsl.parse(drive_of_the_page())
    for end, values in zip(times[1:], expected, strict=True):
        run = mbdsl.simulate(scene, tol=1e-8, stop=end, interval=end)
        found = [
            run[name][-1] for name in ("motor_shaft.phi", "load_shaft.phi", "motor_shaft.w", "load_shaft.w", "PI_x")
        ]
        assert found == pytest.approx(values[:5], abs=1e-6)
    assert np.abs(expected[3][2]) > 0.05  # the torque is at its limit, and the motor late


@pytest.mark.parametrize("start", ["steady", "rates"])
def test_the_drive_begins_at_rest(start):
    """The controller alone holds the load of 10 N.m: its integral is -0.1 and the twist 1 mrad; nothing holds the
    angles."""
    text, initial = drive_of_the_page(), "initial equation"
    at, end = text.index(initial), text.index("equation\n  der(speed)")
    if start == "steady":
        text = f"{text[:at]}initial(state = steady);\n{text[end:]}"
    else:
        text = text.replace("PI_x = -0.1;", "der(PI_x) = 0;")
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.5)
    for k in (0, -1):
        assert run["PI_x"][k] == pytest.approx(-0.1, abs=1e-9)
        assert run["load_shaft.phi"][k] - run["motor_shaft.phi"][k] == pytest.approx(1e-3, abs=1e-9)
        assert abs(run["motor_shaft.w"][k]) < 1e-9


SPEED = """
model Speed "a PI controller holds 20 rad/s: 0.5 N.m/A i = 0.02 N.m.s w, 10 z = i + 0.5 w"
  Ground ground(g = 0 m/s2);
  Body rotor(m = 1 kg, I = 0.01 kg.m2);
  Revolute pin(ground, rotor.c);
  Current i(start = 0 A);
  Angle z(start = 0);
  Torque motor(pin, tau = 0.5 N.m/A*i - 0.02 N.m.s*pin.w);
initial equation
  pin.phi = 0; pin.w = {w} rad/s; der(i) = 0; der(z) = 0;
equation
  der(i) = (10 V*z + 3 V.s*(20 rad/s - pin.w) - 1 Ohm*i - 0.5 V.s*pin.w)/(1e-3 H);
  der(z) = 20 rad/s - pin.w;
end Speed;
"""


def test_a_drive_begins_in_steady_rotation():
    run = mbdsl.simulate(mbdsl.parse(SPEED.format(w=20)), stop=0.1)
    for k in (0, -1):
        assert [run[x][k] for x in ("i", "z", "pin.w")] == pytest.approx([0.8, 1.08, 20.0], abs=1e-9)
    with pytest.raises(InitialisationError, match=r"der\(z\) = 0: their derivatives do not depend on them"):
        mbdsl.simulate(mbdsl.parse(SPEED.format(w=19)), stop=0.1)
