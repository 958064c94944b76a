"""Linear models against closed forms, eigenvalues of `mbdsl.eigen`, and small motions of a simulation."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import io, signal

import mbdsl
from mbdsl import cli
from mbdsl.analysis.input_forces import input_forces
from mbdsl.analysis.named_basis import AtRest
from mbdsl.errors import UsageError
from mbdsl.system import build

G = 9.81
MODELS = Path(__file__).parents[3] / "models"
CART = """
model CartPendulum
  input Force u;
  input Torque w;
  Ground ground;
  Body cart(m = 1.5 kg, I = 0.01 kg.m2);
  Prismatic slide(ground, cart.c);
  Rod pole(m = 0.2 kg, length = 0.6 m);
  Revolute pin(cart.c, pole.a);
  Force drive(frame_b = cart.c, fx = u);
  Torque motor(cart.c, pole.a, tau = w*cos(pin.phi));
initial equation
  slide.s = 0 m; slide.v = 0 m/s; pin.phi = {phi} deg; pin.w = 0 rad/s;
end CartPendulum;
"""
CRANK = """
model Crank
  input Torque u(start = 1.2 N.m);
  input Force f;
  Ground ground;
  Rod crank(m = 1 kg, length = 0.3 m);
  Rod rod(m = 2 kg, length = 0.7 m);
  Body block(m = 0.5 kg, I = 0.01 kg.m2);
  Revolute O(ground, crank.a);
  Revolute A(crank.b, rod.a);
  Revolute B(rod.b, block.c);
  Prismatic slide(ground, block.c);
  SpringDamper spring(ground, block.c, k = 400 N/m, c = 3 N.s/m, s0 = 0.75 m);
  Torque motor(ground, crank.a, tau = u*(1 + 0.1*O.phi/1 rad));
  Force push(frame_b = block.c, fx = f);
initial equation
  guess crank.phi = 60 deg; guess rod.phi = -20 deg; crank.w = 0 rad/s;
end Crank;
"""


def cart(phi):
    """A and B by hand: (M + m) s'' - m l (phi'' sin phi) = u, I phi'' - m l s'' sin phi + m g l cos phi = w cos phi."""
    M, m, l = 1.5, 0.2, 0.3
    inertia = m * (2 * l) ** 2 / 12 + m * l**2
    c, s = np.cos(phi), np.sin(phi)
    mass = np.array([[M + m, -m * l * s], [-m * l * s, inertia]])
    A, B = np.zeros((4, 4)), np.zeros((4, 2))
    A[:2, 2:] = np.eye(2)
    A[2:, 1] = np.linalg.solve(mass, [0.0, m * G * l * s])
    B[2:] = np.linalg.solve(mass, [[1.0, 0.0], [0.0, c]])
    return A, B


@pytest.mark.parametrize(("phi", "at"), [(90, "start"), (-90, "static")])
def test_cart_and_pendulum(phi, at):
    found = mbdsl.linearise(mbdsl.parse(CART.format(phi=phi)), at)
    A, B = cart(np.radians(phi))
    np.testing.assert_allclose(found.A, A, atol=1e-12 * np.abs(A).max())
    np.testing.assert_allclose(found.B, B, atol=1e-12 * np.abs(B).max())
    assert np.array_equal(found.C, np.eye(4)) and not found.D.any()
    assert found.states == found.outputs == ["slide.s", "pin.phi", "slide.v", "pin.w"]
    assert found.state_units == ["m", "rad", "m/s", "rad/s"]
    assert (found.inputs, found.input_units) == (["u", "w"], ["N", "N.m"])
    assert found.x0 == pytest.approx([0.0, np.radians(phi), 0.0, 0.0], abs=1e-12)
    assert found.notes == [] or at == "static"


def test_reactions_accelerations_and_inputs_as_outputs():
    """The force on the pole is m times the acceleration of its centre; upright, that is s'' - l phi'' along x."""
    outputs = ["slide.s", "pin.fx", "pole.ax", "cart.ax", "pole.alpha", "u", "pole.b.vx"]
    found = mbdsl.linearise(mbdsl.parse(CART.format(phi=90)), "start", ["u"], outputs)
    A, B = cart(np.pi / 2)
    states, unit = np.vstack([A[2:], np.zeros(4)]), np.vstack([B[2:, :1], [[1.0]]])
    rows = np.array([[1.0, -0.3, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])  # of s'', phi'', u
    np.testing.assert_allclose(found.C[2:6], rows @ states, atol=1e-11)
    np.testing.assert_allclose(found.D[2:6], rows @ unit, atol=1e-12)
    np.testing.assert_allclose(np.abs(found.C[1]), 0.2 * np.abs(found.C[2]), atol=1e-11)
    np.testing.assert_allclose(np.abs(found.D[1]), 0.2 * np.abs(found.D[2]), atol=1e-12)
    np.testing.assert_allclose(found.C[0], [1.0, 0.0, 0.0, 0.0], atol=1e-13)
    np.testing.assert_allclose(found.C[6], [0.0, 0.0, 1.0, -0.6], atol=1e-13)
    assert (
        found.output_units == ["m", "N", "m/s2", "m/s2", "rad/s2", "N", "m/s"] and np.abs(found.D[[0, 6]]).max() < 1e-13
    )


def test_a_moving_pendulum():
    """phi'' = -3 g/(2 l) cos phi + 3 u/(m l^2): frozen, with the force of the pin by hand."""
    text = """model P input Torque u; Ground ground; Rod rod(m = 2 kg, length = 1 m); Revolute pin(ground, rod.a);
        Torque motor(ground, rod.a, tau = u);
        initial equation pin.phi = 20 deg; pin.w = 3 rad/s; end P;"""
    found = mbdsl.linearise(mbdsl.parse(text), "start", signals=["pin.fx", "rod.b.vy"])
    phi, w, l = np.radians(20), 3.0, 1.0
    k, b = 1.5 * G / l * np.sin(phi), 3.0 / (2.0 * l**2)
    np.testing.assert_allclose(found.A, [[0.0, 1.0], [k, 0.0]], atol=1e-8)
    np.testing.assert_allclose(found.B, [[0.0], [b]], atol=1e-12)
    alpha = -1.5 * G / l * np.cos(phi)
    ax = -0.5 * l * np.array([np.cos(phi) * alpha - np.sin(phi) * w**2 + np.sin(phi) * k, 2.0 * w * np.cos(phi)])
    sign = np.sign(found.C[0, 0] / ax[0])
    np.testing.assert_allclose(sign * found.C[0], 2.0 * ax, rtol=1e-8)
    np.testing.assert_allclose(sign * found.D[0], -2.0 * 0.5 * l * np.sin(phi) * b, rtol=1e-10)
    np.testing.assert_allclose(found.C[1], [-l * np.sin(phi) * w, l * np.cos(phi)], rtol=1e-9)
    assert any("frozen" in note for note in found.notes)


def test_a_pose_that_is_no_equilibrium(monkeypatch):
    """Released from rest at other angles, the crank has other accelerations; their difference quotient is A."""
    text = CRANK.replace("guess crank.phi = 60 deg", "O.phi = {phi} rad")

    def at(phi):
        return mbdsl.linearise(mbdsl.parse(text.format(phi=phi)), "start", signals=["crank.alpha"])

    found, e = at(1.0), 1e-3
    assert found.states == ["O.phi", "O.w"] and any("begins to move" in note for note in found.notes)
    near, far = ((at(1.0 + x).y0[0] - at(1.0 - x).y0[0]) / (2.0 * x) for x in (e, 2.0 * e))
    assert found.A[1, 0] == pytest.approx((4.0 * near - far) / 3.0, rel=1e-8)  # an error of order e^4
    assert found.C[0] == pytest.approx(found.A[1], rel=1e-12)
    monkeypatch.setattr(AtRest, "suits", lambda *state: False)  # by differences along the motion, as if it moved
    np.testing.assert_allclose(at(1.0).A, found.A, atol=1e-8 * np.abs(found.A).max())


def assert_eigenvalues(found, modes, tolerance):
    wanted = [mode.eigenvalue for mode in modes]
    wanted += [s.conjugate() for s in wanted if s.imag] + [0.0] * sum(s == 0.0 for s in wanted)
    values = list(np.linalg.eigvals(found.A).astype(complex))
    size = max(map(abs, wanted))
    for s in wanted:
        nearest = min(values, key=lambda x: abs(x - s))
        # zeros of free motions are double eigenvalues, which rounding splits by its square root
        assert abs(nearest - s) <= (1e-6 * size if s == 0.0 else tolerance * size)
        values.remove(nearest)
    assert len(values) == len(found.A) - len(wanted)


@pytest.mark.parametrize(
    ("name", "at"),
    [("spring_mass", "static"), ("slider_crank", "start"), ("rolling_disc", "static"), ("double_pendulum", "start")],
)
def test_eigenvalues(name, at):
    found = mbdsl.linearise(MODELS / f"{name}.mbd", at)
    assert_eigenvalues(found, mbdsl.eigen(MODELS / f"{name}.mbd", at, count=None), 1e-9)
    assert len(set(found.states)) == len(found.states)


def test_eigenvalues_of_a_beam():
    """Lengths of a millimetre beside angles, and coordinates of the beam by their names."""
    text = """model B Ground ground; FlexibleBeam beam(length = 1 m, S = 50 mm2, I = 104 mm4, E = 70 GPa,
        density = 2700 kg/m3, modes = 3); Fixed weld(ground, beam.a); end B;"""
    scene = mbdsl.parse(text)
    found = mbdsl.linearise(scene)
    assert_eigenvalues(found, mbdsl.eigen(scene, count=None), 1e-9)
    assert found.states[0].startswith("beam.") and found.states[3].startswith("der(beam.")


def test_friction_that_depends_on_reactions():
    text = """model F input Torque u; Ground ground; Rod a(m = 1 kg, length = 1 m);
        Revolute A(ground, a.a, mu = 0.3, radius = 2 cm, w_s = 0.1 rad/s); Torque T(ground, a.a, tau = u); end F;"""
    found = mbdsl.linearise(mbdsl.parse(text))
    # hanging, friction is r mu N tanh(w/w_s) with N = m g, and dN = 0 to first order
    damping = 0.02 * 0.3 * G / 0.1
    np.testing.assert_allclose(found.A, [[0.0, 1.0], [-1.5 * G, -3.0 * damping]], atol=1e-9)
    np.testing.assert_allclose(found.B, [[0.0], [3.0]], atol=1e-12)


def test_gears():
    """One speed for two coordinates: a.phi and b.phi keep their angles, y' = T u."""
    found = mbdsl.linearise(
        mbdsl.parse("""model R input Torque u; Ground ground(g = 0); Body a(m = 1 kg, I = 2 kg.m2);
        Body b(m = 1 kg, I = 9 kg.m2); Revolute A(ground, a.c); Revolute B(ground, b.c);
        VelocityConstraint c(gamma = a.w + 3*b.w); RotationalSpringDamper s(A, k = 12 N.m/rad);
        Torque T(ground, b.c, tau = u); end R;""")
    )
    assert found.states[:2] == ["A.phi", "B.phi"] and found.states[2:] == ["A.w"]
    np.testing.assert_allclose(found.A, [[0, 0, 1], [0, 0, -1 / 3], [-4, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(found.B, [[0.0], [0.0], [-1 / 9]], atol=1e-12)


def test_forces_of_inputs_are_those_of_the_equations():
    """The laws are linear in the inputs, so that a difference of forces is exact."""
    scene = mbdsl.parse(CRANK)
    system = build(scene)
    q = np.random.default_rng(3).normal(size=system.n)
    v, lam = np.ones(system.n), np.zeros(system.m)
    found = input_forces(system, ["u", "f"], 0.0, q, v, lam)
    for k, name in enumerate(("u", "f")):
        system.set_input(name, 1.0)
        more = system.Q(0.0, q, v)
        system.set_input(name, 0.0)
        np.testing.assert_allclose(found[:, k], more - system.Q(0.0, q, v), atol=1e-13)


def test_step_responses():
    """The deviation from the motion is of second order: an eighth of the step of the inputs, a sixty-fourth of it."""
    outputs = ["O.phi", "block.vx", "A.fx", "slide.fy", "rod.alpha", "spring.force"]
    linear = mbdsl.linearise(mbdsl.parse(CRANK), signals=outputs)
    assert linear.inputs == ["u", "f"] and linear.states == ["O.phi", "O.w"]
    rest = CRANK.replace("guess crank.phi = 60 deg", f"crank.phi = {float(linear.x0[0])!r} rad")
    errors = []
    for size in (1.0, 1.0 / 8.0):
        u, f = step = size * np.array([0.1, 2.0])
        text = rest.replace("u(start = 1.2 N.m)", f"u(start = {1.2 + u} N.m)").replace("f;", f"f(start = {f} N);")
        run = mbdsl.simulate(mbdsl.parse(text), method="scipy-dop853", tol=1e-10, stop=0.25, interval=0.01)
        _, y, _ = signal.lsim(signal.StateSpace(*linear), np.tile(step, (len(run), 1)), run.t)
        found = np.transpose([run[name] for name in outputs]) - linear.y0
        errors.append(np.abs(found - y).max(axis=0))
    assert (np.abs(y).max(axis=0) > 10.0 * errors[1]).all()
    assert (errors[0] > 40.0 * errors[1]).all() and (errors[0] < 90.0 * errors[1]).all()


def test_python_control_reads_it():
    control = pytest.importorskip("control")
    found = mbdsl.linearise(mbdsl.parse(CART.format(phi=90)), "start", ["u"])
    assert np.array_equal(control.ss(*found).A, found.A)
    states = [name.replace(".", "_") for name in found.states]  # it does not allow dots
    assert control.ss(*found, states=states, inputs=found.inputs).state_labels == states


def test_a_notebook_shows_the_matrices_without_residues():
    """The mass hangs at x = 0, which the iteration reaches but for 1e-110 m."""
    found = mbdsl.linearise(Path(__file__).parents[3] / "models" / "pendulum.mbd")
    assert found._repr_html_().startswith("<pre") and "e-" not in str(found)
    assert "x1  mass.x            0 m" in found._repr_html_()


def test_outputs_is_the_former_name_of_signals():
    with pytest.warns(DeprecationWarning, match="called `signals`"):
        found = mbdsl.linearise(mbdsl.parse(CART.format(phi=90)), "start", outputs=["pin.phi"])
    assert found.outputs == mbdsl.linearise(mbdsl.parse(CART.format(phi=90)), "start", signals="pin.phi").outputs


# -- what is refused ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"inputs": ["x"]}, "no input or force `x`"),
        ({"at": -2.0}, "t = -2 s is before the start of the run, 0 s"),
        ({"signals": ["pin.angle"]}, "no signal"),
        ({"signals": ["pin.Phi[1]"]}, "cannot be an output"),
        ({"signals": ["pole.a.M"]}, "cannot be an output(?s:.*)forces in sections are those of a run"),
        ({"at": "now"}, "expected `static`, `start` or a time"),
        ({"at": float("nan")}, "not a finite number"),
    ],
)
def test_wrong_arguments(given, message):
    with pytest.raises(UsageError, match=message):
        mbdsl.linearise(mbdsl.parse(CART.format(phi=90)), **{"at": "start", **given})


def test_an_input_that_prescribes_a_velocity():
    scene = mbdsl.parse("""model V input AngularVelocity u; Ground ground; Rod a(m = 1 kg, length = 1 m);
        Revolute A(ground, a.a); RotationalVelocityDriver D(ground, a.a, w = u); end V;""")
    with pytest.raises(UsageError, match=r"prescribes a velocity in `D`(?s:.*)`mbdsl response` takes this input"):
        mbdsl.linearise(scene, "start")
    assert mbdsl.linearise(scene, "start", inputs=[]).B.shape == (1, 0)


def test_a_coordinate_without_mass():
    scene = mbdsl.parse("""model V Ground ground(g = 0); Body a(m = 1 kg, I = 0 kg.m2); Revolute R(ground, a.c);
        RotationalSpringDamper k(R, k = 1 N.m/rad, c = 1 N.m.s/rad); end V;""")
    with pytest.raises(UsageError, match="without mass"):
        mbdsl.linearise(scene, "start")


# -- the command line --------------------------------------------------------------------------------------------------


def test_command(tmp_path, capsys):
    model = tmp_path / "cart.mbd"
    model.write_text(CART.format(phi=90))
    wanted = mbdsl.linearise(model, "start", ["u"], ["pin.phi", "pin.fx"])
    for suffix in ("json", "mat", "npz"):
        file = tmp_path / f"linear.{suffix}"
        command = ["linearise", str(model), "--at", "start", "--inputs", "u", "--signals", "pin.phi,pin.fx"]
        assert cli.main([*command, "--output", str(file)]) == 0
        printed = capsys.readouterr().out
        assert printed.startswith(str(wanted)) and max(map(len, str(wanted).splitlines())) <= 80
        if suffix == "json":
            found = json.loads(file.read_text())
            assert found["states"] == wanted.states and found["at"] == "start"
        else:
            found = io.loadmat(file) if suffix == "mat" else np.load(file)
            names = [str(np.squeeze(x)) for x in np.ravel(found["states"])]
            assert names == wanted.states
        for letter in "ABCD":
            assert np.array_equal(np.asarray(found[letter], float), getattr(wanted, letter))
    assert cli.main(["linearise", str(model), "--output", str(tmp_path / "linear.txt")]) == 2
    assert "known suffixes are .json, .mat, .npz" in capsys.readouterr().err


def test_accelerations_of_sensors_are_refused():
    text = """model M
      Ground ground;
      Rod rod(m = 1 kg, length = 1 m);
      Revolute pin(ground, rod.a);
      Sensor imu(rod.b);
      Torque brake(pin, tau = -(0.2 N.m.s/rad)*imu.w);
    end M;"""
    with pytest.raises(mbdsl.UsageError, match=r"`imu\.ax` cannot be an output of a linear model: `imu` is not a body"):
        mbdsl.linearise(mbdsl.parse(text), inputs=["brake.tau"], signals=["imu.ax"])
