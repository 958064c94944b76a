"""Events that cannot happen: the error names the line, the value and the reason."""

import pytest

import mbdsl
from mbdsl.errors import IntegrationError, ModelError

PENDULUM = """model M
  Ground ground;
  Body b(m = 1 kg, I = 2 kg.m2);
  Revolute J(ground, b.c);
  Real x(start = 0);
  Integer n(start = {start});
initial equation
  J.phi = 0; J.w = 1;
equation
  der(x) = 2/(1 s);
  when x > 0.5 then
    {action}
  end when;
  annotation(experiment(StopTime = 0.5 s));
end M;"""


def pendulum(action, start=0):
    return mbdsl.parse(PENDULUM.format(action=action, start=start))


@pytest.mark.parametrize("given", [{"step": 0.01}, {"tol": 1e-5}, {"tol": 1e-5, "method": "dop853"}])
@pytest.mark.parametrize(
    ("action", "said"),
    [
        ("reinit(J.w, -1/(x - x));", ["reinit of J.w", "t = 0.25", "-inf"]),
        ("reinit(x, log(0*x - 1));", ["reinit of x", "nan"]),
        ("reinit(b.vy, 1 m/s);", ["reinit of b.vy", "t = 0.25", "the constraints do not allow"]),
        ("reinit(b.vy, 1 nm/s);", ["reinit of b.vy", "t = 0.25", "the constraints do not allow"]),
        ("reinit(J.w, 1 rad/s); reinit(b.w, 2 rad/s);", ["reinit of J.w, b.w", "the constraints do not allow"]),
    ],
)
def test_impossible_jumps_end_the_run(action, said, given):
    with pytest.raises(IntegrationError) as found:
        mbdsl.simulate(pendulum(action), **given)
    assert found.value.exit_code == 4
    assert found.value.span is not None and found.value.span.line == 12
    assert all(x in found.value.message for x in said), found.value.message
    assert 0.25 - 0.02 < found.value.trajectory.t[-1] < 0.25 + 1e-9  # what was computed is kept: the last output


def test_a_jump_at_the_start_that_constraints_do_not_allow():
    with pytest.raises(mbdsl.errors.InitialisationError, match=r"reinit of b\.vy at t = 0 s") as found:
        mbdsl.simulate(mbdsl.parse(PENDULUM.format(action="reinit(b.vy, 1);", start=0).replace("x > 0.5", "initial()")))
    assert found.value.span.line == 12


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ("reinit(ground.c.vx, 1 m/s);", r"reinit of `ground\.c\.vx`: it does not move"),
        ("reinit(J.w, J.w + 1 rad/s); reinit(J.w, 0);", r"`J\.w` is set twice in one event"),
        ("reinit(x, 1); reinit(x, 2);", "`x` is set twice in one event"),
        ("n = pre(n) + 0.25;", "`n` is a whole number"),
        ("n = 3*x;", "`n` is a whole number"),
        ("n = pre(n)/2;", "`n` is a whole number"),
    ],
)
def test_impossible_actions_are_errors_of_the_model(action, message):
    with pytest.raises(ModelError, match=message) as found:
        pendulum(action)
    assert found.value.span.line == 12


def test_integers_take_whole_values():
    with pytest.raises(ModelError, match=r"`n` is a whole number, found 0\.5"):
        pendulum("n = 1;", start=0.5)
    model = pendulum("n = if x > 0 then floor(7*x) + 2*pre(n) - mod(pre(n), 3) else min(pre(n), 4);", start=2)
    assert mbdsl.simulate(model, step=0.05)["n"][-1] == 5  # floor(3.5...) + 4 - 2
