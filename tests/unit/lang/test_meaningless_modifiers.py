"""A modifier without effect is refused at its place; modifiers with an effect are accepted."""

import pytest

from mbdsl import parse
from mbdsl.errors import MbdslError

MODEL = """\
model A
  parameter Length L(min = 0 m) = 1 m;
  Ground ground;
  {}
  Rod r(m = 1 kg, length = L);
  Revolute p(ground, r.a);
  S s(ground);
  S t[2](each tip = ground);
  Table T[2](each table = [0, 1; 1, 2]);
  Frame F(ground, r = {{1, 0}});
  Real y = T[1](time);
end A;
model S
  Frame tip;
  parameter Real k = 1;
  outer Ground ground;
  Rod q(m = 1 kg, length = 1 m);
  Revolute j(tip, q.a);
end S;
"""


def load(line="", overrides=None):
    return parse(MODEL.format(line), "a.mbd", overrides or {}, "A")


@pytest.mark.parametrize(
    ("line", "word", "named"),
    [
        ("Rod x(m(foo = 3) = 1 kg, length = 1 m);", "foo", "m, length, frames"),
        ("Rod x(m = 1 kg, length(min = 5) = 1 m);", "min", "m, length, frames"),
        ("Rod x[2](each m(foo = 3) = 1 kg, each length = 1 m);", "foo", "m, length"),
        ("Rod x(m = 1 kg, length = 1 m, phi(start(a = 3) = 3));", "a =", "start"),
        ("Rod x(m = 1 kg, length = 1 m, frames(tip(foo = 3) = {1, 0}));", "foo", "{x, y}"),
        ("Torque x(r.b, tau(foo = 3) = 1 N.m);", "foo", "tau, frame_a, frame_b"),
        ("Revolute x(frame_a(foo = 3) = ground, frame_b = r.b);", "foo", "frame_a"),
        ("parameter Real z(min(foo = 3) = 1) = 3;", "foo", "min"),
        ("parameter Real z(nominal = unheard_of) = 3;", "unheard_of", "unknown name"),
        ("parameter Real z(fixed = 4) = 3;", "4", "true or false"),
        ("Frame G(ground, r(foo = 3) = {1, 0});", "foo", "r = "),
        ("Frame G(r = {1, 0}) = r.a;", "r =", "r.a"),
        ("S u(tip(foo = 3) = ground);", "foo", "tip"),
        ("S u(ground, ground(g = 3 m/s2));", "ground(g", "outer Ground ground"),
        ("S u(ground, q(m(foo = 3) = 3 kg));", "foo", "m, length"),
        ("Table U(table(foo = 3) = [0, 1; 1, 2]);", "foo", "table"),
        ("annotation(experiment(StopTime(foo = 3) = 1 s));", "foo", "StopTime"),
        ("annotation(experiment(StopTime = 2 s, StopTime = 1 s));", "StopTime = 1", "twice"),
        ("annotation(experiment = 3);", "experiment", "StopTime"),
    ],
)
def test_in_a_model(line, word, named):
    with pytest.raises(MbdslError) as caught:
        load(line)
    problem = caught.value
    assert named in problem.render()
    assert problem.span is not None and problem.span.file == "a.mbd"
    assert (problem.span.line, problem.span.column) == (4, 3 + line.index(word))


@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("r.m.value", "m, length, frames"),
        ("L.value", "attributes: unit, min, max"),
        ("L.min.foo", "min"),
        ("L.start", "has a value"),
        ("y.start", "has a value"),
        ("s.k.foo", "attributes: unit, min, max"),
        ("s.ground.g", "outer Ground ground"),
        ("t[1].q.m.foo", "m, length, frames"),
        ("t[1].tip.foo", "tip"),
        ("T[1].table", "modify all of `T`"),
        ("F.r.x", "r = "),
        ("ground.g.x", "g, n, frames"),
    ],
)
def test_from_outside(name, named):
    with pytest.raises(MbdslError) as caught:
        load(overrides={name: "3"})
    assert named in caught.value.render()
    assert str(caught.value.span).startswith(f"--set {name}:1:1")


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [
        ("r.m", "99", lambda scene: scene.components["r"].values["m"]),
        ("s.q.m", "99", lambda scene: scene.components["s.q"].values["m"]),
        ("t[2].q.m", "99", lambda scene: scene.components["t[2].q"].values["m"]),
        ("t.q.m", "99", lambda scene: scene.components["t[1].q"].values["m"]),
        ("F.r", "{99, 0}", lambda scene: scene.frames["F"].x),
        ("r.phi.start", "99", lambda scene: scene.initial[0].value),
        ("r.frames.tip", "{99, 0}", lambda scene: scene.frames["r.tip"].x),
    ],
)
def test_what_means_something(name, value, read):
    assert read(load(overrides={name: value})) == 99.0
