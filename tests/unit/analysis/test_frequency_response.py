"""Frequency responses against closed forms, and against the amplitude of a simulated steady oscillation."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.errors import UsageError

QUARTER_CAR = """model QuarterCar
  Ground ground;
  Frame up(ground, phi = 90 deg);
  Body road(m = 1 kg, I = 1 kg.m2);
  Body wheel(m = 40 kg, I = 1 kg.m2);
  Body body(m = 300 kg, I = 1 kg.m2);
  TranslationalDriver base(up, road.c, s = 0 m);
  Prismatic road_guide(up, road.c, phi0 = -90 deg);
  Prismatic wheel_guide(up, wheel.c, phi0 = -90 deg);
  Prismatic body_guide(up, body.c, phi0 = -90 deg);
  SpringDamper tyre(road.c, wheel.c, k = 200 N/mm, c = 50 N.s/m, s0 = 0.5 m);
  SpringDamper suspension(wheel.c, body.c, k = 20 N/mm, c = 1200 N.s/m, s0 = 0.5 m);
initial equation
  guess wheel.y = 0.4 m;
  guess body.y = 0.8 m;
end QuarterCar;"""

OSCILLATOR = """model Oscillator
  parameter Real D = 0.05;
  parameter Real f0(unit = "Hz") = 2 Hz;
  Ground ground(g = 0);
  Body base(m = 1 kg, I = 1 kg.m2);
  Body mass(m = 3 kg, I = 1 kg.m2);
  TranslationalDriver shaker(ground, base.c, s = 0 m);
  Prismatic rail(ground, base.c);
  Prismatic guide(base.c, mass.c);
  TranslationalSpringDamper spring(base.c, mass.c, k = 3 kg*(2*pi*f0)^2, c = 2*D*3 kg*2*pi*f0);
  Force push(frame_b = mass.c);
end Oscillator;"""

CRANK = Path(__file__).parents[3] / "models" / "driven_crank.mbd"
F = np.array([0.11, 0.9, 2.0, 2.1, 7.0, 40.0])
S = 2j * np.pi * F


def test_quarter_car():
    """Two masses above a road that moves: M q'' + C q' + K q = (0, k_t + c_t s) of the road."""
    found = mbdsl.response(
        mbdsl.parse(QUARTER_CAR), "base", "body.y, body.ay, wheel.vy, base.fy, road.y - wheel.y", "0.1:100Hz"
    )
    expected = []
    for s in S:
        suspension, tyre = 1200.0 * s + 2e4, 50.0 * s + 2e5
        A = np.array([[300.0 * s * s + suspension, -suspension], [-suspension, 40.0 * s * s + suspension + tyre]])
        body, wheel = np.linalg.solve(A, [0.0, tyre])
        expected.append([body, s * s * body, s * wheel, s * s + tyre * (1.0 - wheel), 1.0 - wheel])
    assert found.at_frequency(F)[:, :, 0] == pytest.approx(np.array(expected), rel=1e-9)
    assert found.inputs == ["base.s"] and found.output_units == ["m", "m/s2", "m/s", "N", "m"]
    peaks = [peak for peak in found.peaks if peak.output == "body.y"]
    assert [peak.mode for peak in peaks] == [1, 2] and [peak.highest for peak in peaks] == [True, True]
    assert [next(iter(mode.bodies)) for mode in found.modes] == ["body", "wheel"]


@pytest.mark.parametrize("damping", [0.05, 1e-5])
def test_transmissibility(damping):
    """Base excitation; the largest amplitude is at r^2 = (sqrt(1 + 8 D^2) - 1)/(4 D^2)."""
    found = mbdsl.response(
        mbdsl.parse(OSCILLATOR), "shaker.s", ["mass.x", "guide.s"], (0.1, 100), parameters={"D": damping}
    )
    r = F / 2.0
    T = (1.0 + 2j * damping * r) / (1.0 - r**2 + 2j * damping * r)
    assert found.at_frequency(F)[:, 0, 0] == pytest.approx(T, rel=1e-9)
    assert found.at_frequency(F)[:, 1, 0] == pytest.approx(r**2 / (1.0 - r**2 + 2j * damping * r), rel=1e-8)
    peak = found.peaks[0]
    square = 4.0 / (1.0 + np.sqrt(1.0 + 8.0 * damping**2))  # without cancellation, times f0^2 = 4
    square = 2.0 * square
    assert peak.frequency == pytest.approx(np.sqrt(square), rel=1e-7)
    r2 = square / 4.0
    height = np.sqrt((1.0 + 4.0 * damping**2 * r2) / ((1.0 - r2) ** 2 + 4.0 * damping**2 * r2))
    assert peak.amplitude == pytest.approx(height, rel=1e-6)
    assert peak.damping == pytest.approx(damping, rel=1e-6) and 2.0 * damping * peak.Q == pytest.approx(1.0, rel=1e-6)
    assert found.amplitude[:, 0, 0].max() == pytest.approx(height, rel=1e-6)  # the points reach the narrow peak
    assert len(found.f) < 700


def test_constant_acceleration_of_a_driver():
    """Relative displacement for a unit acceleration: 1/(w0^2 - w^2 + 2 j D w0 w), but for the sign."""
    found = mbdsl.response(mbdsl.parse(OSCILLATOR), "shaker", "guide.s", "0.1:100Hz", amplitude="1/w^2")
    w0 = 4.0 * np.pi
    assert found.at_frequency(F)[:, 0, 0] == pytest.approx(1.0 / (w0**2 + S**2 + 0.1 * w0 * S), rel=1e-9)
    assert found.input_units == ["m/s2"] and found.unit(0, 0) == "m/(m/s2)"


def test_unbalance():
    """A rotating force m e w^2 on a rotor with different bearings, of which each has its own resonance."""
    text = """model Rotor
      Ground ground(g = 0);
      Body rotor(m = 5 kg, I = 1 kg.m2);
      Bushing bearing(ground, rotor.c, k = {2000, 8000} N/m, c = {7, 9} N.s/m, k_phi = 100 N.m/rad);
      Force unbalance(frame_b = rotor.c);
    end Rotor;"""
    found = mbdsl.response(
        mbdsl.parse(text), "rotating(unbalance.fx, unbalance.fy)", ["rotor.x", "rotor.y"], "1:50Hz", amplitude="w^2"
    )
    x, y = (-(S**2) / (k + c * S + 5.0 * S**2) for k, c in ((2000.0, 7.0), (8000.0, 9.0)))
    assert found.at_frequency(F)[:, :, 0] == pytest.approx(np.stack([x, -1j * y], axis=1), rel=1e-9)
    assert found.input_units == ["kg.m"]
    assert [peak.output for peak in found.peaks] == ["rotor.x", "rotor.y"]
    w0, D = np.sqrt(8000.0 / 5.0), 9.0 / (2.0 * np.sqrt(8000.0 * 5.0))
    assert found.peaks[1].frequency == pytest.approx(w0 / np.sqrt(1.0 - 2.0 * D**2) / (2.0 * np.pi), rel=1e-7)


ABSORBER = """model Absorber
  Ground ground(g = 0);
  Body machine(m = 10 kg, I = 1 kg.m2);
  Body absorber(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, machine.c);
  Prismatic guide(machine.c, absorber.c);
  TranslationalSpringDamper mount(ground, machine.c, k = 4000 N/m);
  TranslationalSpringDamper spring(machine.c, absorber.c, k = 400 N/m);
  Force push(frame_b = machine.c);
end Absorber;"""


def test_vibration_absorber():
    """Without damping: the machine rests at the frequency of the absorber, w = 20 rad/s, and the resonances are
    infinite, at the roots of (4400 - 10 w^2)(400 - w^2) = 400^2."""
    found = mbdsl.response(mbdsl.parse(ABSORBER), "push.fx", "machine.x", "1:10 Hz")
    low, high = np.sort(np.roots([10.0, -8400.0, 1.6e6]))
    low, dip, high = np.sqrt([low, 400.0, high]) / (2.0 * np.pi)
    first, rest, second = found.peaks
    assert (first.highest, rest.highest, second.highest) == (True, False, True)
    assert [first.frequency, rest.frequency, second.frequency] == pytest.approx([low, dip, high], rel=1e-6)
    assert rest.amplitude < 1e-9 and np.isinf(first.amplitude) and np.isinf(second.amplitude)
    assert (first.mode, second.mode, first.damping) == (1, 2, 0.0)


def test_upright_oscillator_on_a_stiff_spring():
    """1/(k + c s + m s^2) with a weight that the spring carries, so that the reactions of the guide are zero."""
    text = """model Upright
      Ground ground;
      Frame up(ground, phi = 90 deg);
      PointMass mass(m = 100 kg);
      Prismatic guide(up, mass);
      TranslationalSpringDamper mount(guide, k = 400 kN/m, c = 500 N.s/m, s0 = 0.3 m);
      Force push(frame_b = mass);
    end Upright;"""
    found = mbdsl.response(mbdsl.parse(text), "push.fy", "mass.y", "1:30 Hz")
    assert found.at_frequency(F)[:, 0, 0] == pytest.approx(1.0 / (4e5 + 500.0 * S + 100.0 * S**2), rel=1e-9)
    assert [peak.mode for peak in found.peaks] == [1] and not found.notes


def test_pendulum_on_a_driven_support():
    """phi/X = w^2/(L (w0^2 - w^2)) about hanging down: m L^2 phi'' + m g L phi = -m L X''."""
    text = """model Pendulum
      Ground ground;
      Body carriage(m = 2 kg, I = 1 kg.m2);
      TranslationalDriver drive(ground, carriage.c, s = 0 m);
      Prismatic rail(ground, carriage.c);
      PointMass ball(m = 3 kg);
      Distance thread(carriage.c, ball, length = 0.5 m);
    initial equation
      ball.x = 0 m;
      guess ball.y = -0.5 m;
    end Pendulum;"""
    found = mbdsl.response(mbdsl.parse(text), "drive", ["ball.x - carriage.x", "thread.f", "ball.ay"], "0.1:3Hz")
    w2 = -(S**2).real
    expected = w2 / (9.81 / 0.5 - w2)
    assert found.at_frequency(F)[:, 0, 0] == pytest.approx(expected, rel=1e-9)
    assert any("thread.f" in note and "not respond" in note for note in found.notes)
    assert not found.H[:, 1:].any()


def arm(drive, first="", inertias=("0.2", "0.1"), spatial=""):
    """A slider on an arm that turns with 3 rad/s; ``first``: the first of the initial equations."""
    declared = "      input AngularVelocity u(start = 3 rad/s);\n" if "= u)" in drive else ""
    return f"""{spatial}model Arm
{declared}      Ground ground(g = 0);
      Body arm(m = 1 kg, I = {inertias[0]} kg.m2);
      Body slider(m = 2 kg, I = {inertias[1]} kg.m2);
      {drive};
      Revolute pivot(ground, arm.c);
      Prismatic guide(arm.c, slider.c);
      TranslationalSpringDamper spring(arm.c, slider.c, k = 100 N/m, c = 4 N.s/m, s0 = 0.5 m);
    initial equation
      {first}guide.s = 50/82*1 m;
      guide.v = 0 m/s;
    end Arm;"""


ARM = {
    "": arm("RotationalDriver drive(ground, arm.c, phi = 3 rad/s*time)"),
    "velocity": arm("RotationalVelocityDriver drive(ground, arm.c, w = 3 rad/s)", "pivot.phi = 0 rad; "),
    "input": arm("RotationalVelocityDriver drive(ground, arm.c, w = u)", "pivot.phi = 0 rad; "),
    "space": arm(
        "RotationalDriver drive(ground, arm.c, phi = 3 rad/s*time)",
        inertias=("{0.3, 0.3, 0.2}", "{0.3, 0.3, 0.1}"),
        spatial="spatial ",
    ),
}


@pytest.mark.parametrize("variant", ARM)
def test_slider_on_a_turning_arm(variant):
    """m r'' + c r' + k (r - r0) = m W^2 r; the angle of the drive changes by w, its rate and torque with it:
    dr (m s^2 + c s + k - m W^2) = 2 m W r s w, dtau = (I + m r^2) s^2 w + 2 m W r s dr."""
    scene, W, r, m = mbdsl.parse(ARM[variant]), 3.0, 50.0 / 82.0, 2.0
    name = "u" if variant == "input" else "drive"
    torque = "drive.tz" if variant == "space" else "drive.tau"
    found = mbdsl.response(scene, name, ["guide.s", "guide.v", torque], "0.1:100Hz", at="start")
    w = 1.0 if variant in ("", "space") else 1.0 / S
    dr = 2.0 * m * W * r * S * w / (m * S**2 + 4.0 * S + 100.0 - m * W**2)
    tau = (0.3 + m * r**2) * S**2 * w + 2.0 * m * W * r * S * dr
    expected = np.stack([dr, S * dr, tau], axis=1)
    assert found.at_frequency(F)[:, :, 0] == pytest.approx(expected, rel=1e-7)


def test_drivers_of_positions_and_of_velocities_together():
    """The arm on a carriage: dr (m s^2 + c s + k - m W^2) = -m s^2 X + 2 m W r w, at the moment when it is along x."""
    text = ARM["velocity"].replace(
        "Body arm", "Body cart(m = 1 kg, I = 1 kg.m2);\n  TranslationalDriver move(ground, cart.c, s = 0 m);\n  "
        "Prismatic rail(ground, cart.c);\n  Body arm"
    )  # fmt: skip
    text = text.replace("drive(ground, arm.c", "drive(cart.c, arm.c").replace("pivot(ground", "pivot(cart.c")
    found = mbdsl.response(mbdsl.parse(text), ["move", "drive"], ["guide.s", "move.fx"], "0.1:100Hz", at="start")
    W, r, m = 3.0, 50.0 / 82.0, 2.0
    below = m * S**2 + 4.0 * S + 100.0 - m * W**2
    dr = np.stack([-m * S**2 / below, 2.0 * m * W * r / below], axis=1)
    assert found.at_frequency(F)[:, 0] == pytest.approx(dr, rel=1e-8)
    # the force on the carriage moves 2 kg of it and the arm, and 2 kg whose acceleration along x is (s^2 - W^2) dr
    force = (2.0 + m) * S**2 + m * (S**2 - W**2) * dr[:, 0]
    assert found.at_frequency(F)[:, 1, 0] == pytest.approx(force, rel=1e-8)


def test_nothing_moves_but_the_drive():
    """A slider crank that turns: x(phi) = L1 cos phi + sqrt(L2^2 - L1^2 sin^2 phi), and its rates, at 30 degrees."""
    found = mbdsl.response(CRANK, "drive", ["slider.x", "slider.vx", "slider.ax"], "0.1:50Hz", at="start")
    w, t = 2.0 * np.pi, np.linspace(0.0, 2.0 * np.pi, 65)[:-1]  # a Fourier series has its derivatives exactly
    c = np.fft.fft(0.3 * np.cos(t) + np.sqrt(0.36 - 0.09 * np.sin(t) ** 2)) / 64.0
    k = np.fft.fftfreq(64, 1.0 / 64.0)
    d1, d2, d3 = (float(((1j * k) ** n * c * np.exp(1j * k * np.pi / 6.0)).sum().real) for n in (1, 2, 3))
    one = np.ones_like(S)
    expected = np.stack([d1 * one, d2 * w + d1 * S, d3 * w**2 + 2.0 * d2 * w * S + d1 * S**2], axis=1)
    assert found.at_frequency(F)[:, :, 0] == pytest.approx(expected, rel=1e-6)
    with pytest.raises(UsageError, match="nothing can move"):
        mbdsl.response(CRANK, "drive", at="start")


def test_force_and_driver_in_space():
    """A pendulum about the z axis with a torque, on a carriage that moves along x; gravity is along -y."""
    text = """spatial model Pendulum
      Ground ground;
      Body carriage(m = 2 kg, I = {1, 1, 1} kg.m2);
      Prismatic rail(ground, carriage.c, n = {1, 0, 0});
      TranslationalDriver drive(ground, carriage.c, s = 0 m, n = {1, 0, 0});
      Body rod(m = 3 kg, I = {0.1, 0.1, 0.1} kg.m2, frames(top = {0, 0.5 m, 0}));
      Revolute pin(carriage.c, rod.top, n = {0, 0, 1});
      RotationalSpringDamper damper(carriage.c, rod.top, c = 0.4 N.m.s/rad, n = {0, 0, 1});
      Torque motor(carriage.c, rod.top, tau = 0 N.m, n = {0, 0, 1});
    end Pendulum;"""
    found = mbdsl.response(mbdsl.parse(text), ["motor", "drive"], ["pin.phi", "rod.ax"], "0.1:10Hz")
    inertia = 0.1 + 3.0 * 0.25
    below = inertia * S**2 + 0.4 * S + 3.0 * 9.81 * 0.5
    phi = np.stack([1.0 / below, -3.0 * 0.5 * S**2 / below], axis=1)  # rod.x = X + 0.5 phi
    assert found.at_frequency(F)[:, 0] == pytest.approx(phi, rel=1e-9)
    ax = S[:, None] ** 2 * (np.array([0.0, 1.0]) + 0.5 * phi)
    assert found.at_frequency(F)[:, 1] == pytest.approx(ax, rel=1e-9)


def test_simulated_steady_oscillation():
    """The amplitude and the phase of the last periods of a run with a small oscillation of the drive."""
    f, size = 1.3, 1e-5
    text = OSCILLATOR.replace("s = 0 m", f"s = {size} m*sin(2*pi*{f}*time*1 Hz)").replace("D = 0.05", "D = 0.3")
    run = mbdsl.simulate(mbdsl.parse(text), method="radau5", tol=1e-8, stop=8.0 / f, interval=1.0 / f / 64)
    last = slice(-129, -1)
    wave = np.exp(-2j * np.pi * f * run.t[last])
    measured = 2.0 * (run["mass.x"][last] * wave).mean() / (-1j * size)
    found = mbdsl.response(mbdsl.parse(OSCILLATOR), "shaker", "mass.x", "1:2Hz", parameters={"D": 0.3})
    assert found.at_frequency([f])[0, 0, 0] == pytest.approx(measured, rel=1e-4)


def test_linear_models_take_forces():
    linear = mbdsl.linearise(mbdsl.parse(OSCILLATOR), inputs=["push.fx"])
    assert linear.inputs == ["push.fx"] and linear.B[-1, 0] == pytest.approx(1.0 / 3.0)
    with pytest.raises(UsageError, match="acts by its rates"):
        mbdsl.linearise(mbdsl.parse(OSCILLATOR), inputs=["shaker"])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"input": "shakr"}, "did you mean `shaker.s`"),
        ({"input": "rail"}, "nothing that can oscillate"),
        ({"input": "push"}, r"has 2 amplitudes\n.*push.fx"),
        ({"input": "push.fz"}, "no amplitude `fz`"),
        ({"input": "rotating(push.fx, shaker)"}, "does not rotate"),
        ({"input": "rotating(push.fx)"}, r"`rotating` takes two forces(?s:.*)rotating\(push.fx, push.fy\)"),
        ({"input": "nothing"}, "what can oscillate: shaker.s"),
        ({"input": []}, "needs an input"),
        ({"output": "max(mass.x)"}, "`max` takes two values or more(?s:.*)over all steps"),
        ({"range": "10:10Hz"}, "the range is empty: both ends are 10 Hz"),
        ({"output": "mass.z"}, "no signal `mass.z`"),
        ({"input": "push.fx", "output": "push.fx"}, "does not contain the input"),
        ({"range": "0.1:100"}, "has no unit"),
        ({"range": "100:0.1Hz"}, "ends at 0.1 Hz"),
        ({"range": "0:1Hz"}, "above zero"),
        ({"range": "0.1:100 1/s"}, "not a unit of a frequency"),
        ({"range": "0.1Hz"}, "expected two frequencies"),
        ({"range": "a:3Hz"}, "not a frequency"),
        ({"amplitude": "w^3"}, "expected one of 1, w"),
        ({"at": "never"}, "expected `static`"),
    ],
)
def test_wrong_arguments(given, message):
    with pytest.raises(UsageError, match=message):
        mbdsl.response(mbdsl.parse(OSCILLATOR), **({"input": "shaker"} | given))


def test_units_of_ranges():
    for text in ("0.5:2Hz", "0.5Hz:2Hz", f"{np.pi}:{4 * np.pi} rad/s", "30:120rpm"):
        f = mbdsl.response(mbdsl.parse(OSCILLATOR), "shaker", range=text).f
        assert (f[0], f[-1]) == pytest.approx((0.5, 2.0))


def test_what_to_add_where_nothing_oscillates():
    scene = mbdsl.parse("model M Ground g; Rod r(m = 1 kg, length = 1 m); Revolute pin(g, r.a); end M;")
    for name in ("pin.tau", "motor"):
        with pytest.raises(UsageError, match="declare `input Torque u;`, or add a Force or a Torque or a driver"):
            mbdsl.response(scene, name)
        with pytest.raises(UsageError, match=r"declare `input Torque u;`, or add a Force or a Torque$"):
            mbdsl.linearise(scene, inputs=[name])


def test_a_linear_model_does_not_offer_drivers():
    with pytest.raises(UsageError, match=r"what can oscillate: (?!.*shaker)"):
        mbdsl.linearise(mbdsl.parse(OSCILLATOR), inputs=["nothing"])


def test_a_driver_that_other_constraints_hold():
    text = OSCILLATOR.replace("Force push", "Distance held(ground, base.c, length = 0 m);\n  Force push")
    text = text.replace("Distance held(ground, base.c, length = 0 m)", "Fixed held(ground, base.c)")
    with pytest.raises(UsageError, match="cannot oscillate"):
        mbdsl.response(mbdsl.parse(text), "shaker", "mass.x")


def test_unstable_state():
    text = """model Inverted
      input Torque u;
      Ground ground;
      Rod rod(m = 1 kg, length = 1 m);
      Revolute pin(ground, rod.a);
      Torque motor(ground, rod.a, tau = u);
    initial equation
      pin.phi = 90 deg;
    end Inverted;"""
    found = mbdsl.response(mbdsl.parse(text), at="start", range="0.1:10Hz")
    assert found.inputs == ["u"] and found.outputs == ["pin.phi"] and not found.peaks
    assert found.at_frequency(F)[:, 0, 0] == pytest.approx(1.0 / (S**2 / 3.0 - 9.81 / 2.0), rel=1e-9)
    assert any("unstable: mode 1 grows" in note for note in found.notes)


def test_command_and_files(tmp_path, capsys):
    model = tmp_path / "car.mbd"
    model.write_text(QUARTER_CAR)
    names = ["car.csv", "car.json", "car.md", "car.svg", "car.html"]
    asked = ["response", str(model), "--input", "base", "--output", "body.y,wheel.y", "--range", "0.1:100Hz", "--plot"]
    assert main([*asked, *(word for name in names for word in ("--out", str(tmp_path / name)))]) == 0
    shown = capsys.readouterr().out
    assert "resonance       1.20344     2.6562" in shown and "phase [deg]" in shown
    assert shown.count("frequency response about its static equilibrium") == 1
    assert max(len(line) for line in shown.splitlines() if str(tmp_path) not in line) <= 80
    content = json.loads((tmp_path / "car.json").read_text())
    table = np.genfromtxt(tmp_path / "car.csv", delimiter=",", skip_header=1)
    assert content["responses"][1]["amplitude"] == pytest.approx(table[:, 3].tolist())
    assert content["peaks"][0]["mode"] == 1
    picture = (tmp_path / "car.svg").read_text()
    assert "phase [deg]" in picture and "frequency [Hz]" in picture
    assert main([*asked[:5], "car.csv"]) == 2 and "--out car.csv" in capsys.readouterr().err
    assert main(["response", str(model), "--inputs", "base", "--signals", "body.y", "--at", "suspension.s=0.3 m"]) == 0
    assert "about its state with suspension.s = 0.3 m" in capsys.readouterr().out


def test_panels():
    """Amplitudes by unit, and one panel of phases, whose turns are unwrapped."""
    plot = mbdsl.response(mbdsl.parse(QUARTER_CAR), "base", ["body.y", "wheel.y", "base.fy"], "0.1:100Hz").plot()
    assert [panel.y_log for panel in plot.panels] == [True, True, False]
    for series in plot.panels[2].series:
        assert np.abs(np.diff(series.y)).max() < 60.0
    assert min(plot.panels[2].series[0].y) < -250.0  # two modes and a zero: beyond half a turn
