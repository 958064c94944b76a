"""States in the language: what can be declared, how they start, and what is refused."""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import InitialisationError, ModelError

TEXT = """
model M
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
  {}
initial equation
  pin.phi = 0.3; pin.w = 2 rad/s;
  {}
equation
  {}
end M;
"""
MOTOR = "der(i) = (12 V - 1 Ohm*i - 0.5 V.s*pin.w)/(50 mH);"


def model(declared="", initial="", equations=""):
    return mbdsl.parse(TEXT.format(declared, initial, equations))


def ran(*parts, **options):
    return mbdsl.simulate(model(*parts), **{"stop": 0.5, "step": 1e-3, **options})


def refused(*parts):
    with pytest.raises(ModelError) as problem:
        model(*parts)
    return problem.value


def test_signals_and_units():
    run = ran("Current i(start = 1 A);", "", MOTOR)
    assert run["i"][0] == 1.0
    assert run["der(i)"][0] == pytest.approx((12 - 1 - 0.5 * 2) / 0.05)
    assert (run.unit("i"), run.unit("der(i)")) == ("A", "A/s")
    assert not [name for name in run.signals if name.startswith(("i.", "der(i)."))]


def test_arrays_in_loops_and_as_a_whole():
    loop = ran("Real x[3](start = {1, 2, 3});", "x[2] = 5;", "for j in 1:3 loop der(x[j]) = -j*x[j]/(1 s); end for;")
    for j, start in ((1, 1), (2, 5), (3, 3)):
        assert loop[f"x[{j}]"][-1] == pytest.approx(start * np.exp(-j * 0.5), rel=1e-5)
    whole = ran("Real x[2](start = {1, 2});", "", "der(x) = {-x[2], x[1]}/(1 s);")
    assert whole["x[1]"][-1] == pytest.approx(np.cos(0.5) - 2 * np.sin(0.5), abs=1e-5)


def test_sub_models():
    text = """
    model Lag
      parameter Real T(unit = "s") = 1 s, k = 1;
      Real y(start = 0), u = 1;
    equation
      der(y) = (k*u - y)/T;
    end Lag;
    model M
      Ground ground;
      PointMass p(m = 1 kg);
      FreeMotion free(ground, p);
      Lag lag[2](T = {1 s, 2 s}), slow(T = 4 s, y(start = 3), u = lag[1].y);
      Force f(p, fx = 1 N*slow.y);
    end M;
    """
    run = mbdsl.simulate(mbdsl.parse(text), stop=1, step=1e-3)
    assert run["lag[2].y"][-1] == pytest.approx(1 - np.exp(-0.5), rel=1e-5)
    assert run["slow.y"][0] == 3.0
    # T y' + y = 1 - exp(-t): y = 1 + exp(-t)/3 + c exp(-t/4), c = 5/3
    exact = 1 + np.exp(-run.t) / 3 + 5 / 3 * np.exp(-run.t / 4)
    assert run["slow.y"] == pytest.approx(exact, rel=1e-5)
    assert run["p.ax"] == pytest.approx(exact, rel=1e-5)


def test_steady_start_and_rates_of_states():
    run = ran("Current i; Real y = der(2 s*i/(1 A));", "der(i) = 0;", MOTOR)
    assert run["i"][0] == pytest.approx(11.0, rel=1e-12)
    assert run["y"] == pytest.approx(2 * run["der(i)"], rel=1e-12)
    reaction = ran("Real z(start = 1);", "der(z) = 0;", "der(z) = (pin.fy/(1 N) - z^3)/(0.05 s);")
    assert reaction["z"][0] ** 3 == pytest.approx(reaction["pin.fy"][0], rel=1e-9)


@pytest.mark.parametrize(
    "initial", ["i = 4 A; der(i) = 0;", "der(i) = 0; i = 4 A;", "i = 4 A; i = 5 A;", "der(i) = 0; der(i) = 1 A/s;"]
)
def test_two_initial_values_name_both_lines(initial):
    problem = refused("Current i(start = 3 A);", initial, MOTOR)
    assert problem.span is not None and problem.span.line == 9
    assert len(problem.notes) == 1 and problem.notes[0][1].line == 9


def test_fixed_start_and_initial_equation():
    problem = refused("Current i(start = 3 A, fixed = true);", "i = 4 A;", MOTOR)
    assert "two initial values" in problem.message and "fixed" in problem.notes[0][0]


def test_circle_of_definitions():
    circle = "Voltage u = 2*ask, ask = 1 V - error, error = u - 2 V; Current i;"
    problem = refused(circle, "", "der(i) = u/(1 H);")
    assert problem.message == "cyclic definition: `u` -> `ask` -> `error` -> `u`"
    assert len(problem.notes) == 2 and all(span is not None for _, span in problem.notes)
    assert "der(y) = (u - y)/T" in problem.hint and "pre(u)" in problem.hint
    found = refused("Real x, z;", "", "der(x) = der(z); der(z) = der(x);")
    assert found.message == "cyclic definition: der(x) -> der(z) -> der(x)"


@pytest.mark.parametrize(
    ("declared", "equations", "message"),
    [
        ("Real x;", "der(x) = -x;", "expected"),
        ("Length x;", "der(x) = 3 kg;", "expected a velocity"),
        ("Real x;", "der(x) = 1; der(x) = 2;", "given twice"),
        ("Real x = 3;", "der(x) = 1;", "already has a value"),
        ("parameter Real x = 3;", "der(x) = 1;", "a parameter"),
        ("Integer n(start = 1);", "der(n) = 1;", "real number"),
        ("Real x[2];", "der(x[1]) = 1;", "derivative of `x[2]` is not given"),
        ("Real x[2];", "der(x) = 1;", "expected an array"),
        ("", "der(pin.w) = 3;", "motions follow"),
        ("Real a = der(pin.w);", "", "accelerations cannot be used; filter the velocity"),
        ("Real x;", "0.3*der(x) = x;", "alone on one side"),
        ("Real x(start = 1, nominal = -1);", "der(x) = 1;", "must be positive"),
        ("Real x;", "der(y) = 1;", "unknown name `y`"),
    ],
)
def test_refused(declared, equations, message):
    problem = refused(declared, "", equations)
    assert message in problem.message
    assert problem.span is not None


def test_equation_is_solved_for_the_derivative():
    assert refused("Real x;", "", "0.3*der(x) = x;").hint == "write `der(x) = (x)/(0.3);`"


def test_no_steady_value():
    with pytest.raises(InitialisationError, match="do not depend on them"):
        ran("Real x(start = 1);", "der(x) = 0;", "der(x) = 1/(1 s);")


def test_given_initial_values():
    start = {"i": "2 A"}
    assert ran("Current i;", "der(i) = 0;", MOTOR, initial=start)["i"][0] == 2.0
    first = ran("Current i;", "", MOTOR)
    assert ran("Current i;", "", MOTOR, initial=first)["i"][0] == pytest.approx(first["i"][-1], rel=1e-12)


def test_builder():
    b = mbdsl.Builder("M")
    ground = b.add("Ground", "ground")
    rod = b.add("Rod", "rod", m=1.0, length=1.0)
    pin = b.add("Revolute", "pin", ground, rod.a)
    i = b.state("i", "1 A", unit="A", nominal="10 A")
    b.variable("u", "12 V - 0.5 V.s*pin.w")
    b.rate(i, "(u - 1 Ohm*i)/(50 mH)")
    b.state("x", [1.0, 2.0])
    b.rate("x[1]", "-x[1]/(1 s)")
    b.rate("x[2]", "x[1]/(1 s)")
    b.initial(pin.phi, 0.3)
    b.initial(pin.w, 2.0)
    run = mbdsl.simulate(b, stop=0.5, step=1e-3)
    text = ran("Current i(start = 1 A);", "", MOTOR)
    assert run["i"][-1] == pytest.approx(text["i"][-1], rel=1e-9)
    assert run["x[2]"][-1] == pytest.approx(3 - np.exp(-0.5), rel=1e-5)
    with pytest.raises(ModelError, match="given twice"):
        b.rate("i", "1 A/s")
    b.rate("i", "1 A/s", replace=True)
    assert mbdsl.simulate(b, stop=0.5, step=1e-3)["i"][-1] == pytest.approx(1.5)
    assert b.remove("i") == ("i",)


def test_parts_with_states_are_apart():
    """Two pendulums with a motor each, and a state that belongs to neither, are three parts."""
    text = """
    model M
      Ground ground;
      Rod rod[2](each m = 1 kg, each length = 1 m);
      Revolute pin[2](each frame_a = ground, frame_b = rod.a);
      Real i[2], x(start = 1);
      Torque motor[2](pin, tau = {1 N.m*i[1], 1 N.m*i[2]});
    equation
      der(x) = -x/(1 s);
      der(i) = {(1 - pin[1].phi - i[1])/(0.1 s), (2 - pin[2].phi - i[2])/(0.1 s)};
    end M;
    """
    run = mbdsl.simulate(mbdsl.parse(text), stop=1, step=1e-3)
    assert run["x"][-1] == pytest.approx(np.exp(-1), rel=1e-5)
    alone = text.replace("rod[2]", "rod[1]").replace("pin[2](", "pin[1](").replace("i[2], ", "i[1], ")
    alone = alone.replace("motor[2](pin, tau = {1 N.m*i[1], 1 N.m*i[2]})", "motor(pin[1], tau = 1 N.m*i[1])")
    alone = alone.replace("der(i) = {(1 - pin[1].phi - i[1])/(0.1 s), (2 - pin[2].phi - i[2])/(0.1 s)}",
                          "der(i[1]) = (1 - pin[1].phi - i[1])/(0.1 s)")  # fmt: skip
    one = mbdsl.simulate(mbdsl.parse(alone), stop=1, step=1e-3)
    assert one["pin[1].phi"][-1] == pytest.approx(run["pin[1].phi"][-1], rel=1e-9)


def test_space():
    """The same pendulum with a motor in a model in space."""
    text = TEXT.format("Current i(start = 1 A); Torque motor(pin, tau = 0.5 N.m/A*i);", "", MOTOR)
    plane = mbdsl.simulate(mbdsl.parse(text), stop=0.5, step=1e-3)
    for method in ("hht-si2", "radau5"):
        spatial = text.replace("model M", "spatial model M", 1).replace("ground;", "ground(n = {0, -1, 0});", 1)
        space = mbdsl.simulate(mbdsl.parse(spatial), stop=0.5, step=1e-3, method=method)
        assert space["i"][-1] == pytest.approx(plane["i"][-1], rel=1e-5)
        assert space["pin.phi"][-1] == pytest.approx(plane["pin.phi"][-1], rel=1e-5)


def test_accelerations_are_no_initial_values():
    problem = refused("Real x;", "der(pin.w) = 0;", "der(x) = -x/(1 s);")
    assert problem.message == "the initial value of `der(pin.w)`, an acceleration, follows from the forces"
    assert "initial(state = steady);" in problem.hint


def test_numbers_beside_other_values_get_units():
    hint = refused("Real x = pin.phi - pin.w;", "", "").hint
    declared, factor = hint.split("; ")
    assert declared == "a variable has the unit of its type, as `AngularVelocity x`"
    assert factor == "a number gets a unit by a factor, `1 rad/s*...`"
