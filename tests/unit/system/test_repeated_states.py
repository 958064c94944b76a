"""What a run asks for again at one state: accelerations are kept, and conditions are those of the compiled tape."""

import numpy as np
import pytest

import mbdsl
from mbdsl.compilation.native_call import Native
from mbdsl.expressions.array_operations import ARRAY_OPERATIONS
from mbdsl.expressions.symbolic import evaluate
from mbdsl.system import build
from mbdsl.system.accelerations import accelerations

PUSHED = """model Pushed
  Ground ground(g = 0);
  Body b(m = 2 kg, I = 1 kg.m2);
  Prismatic rail(ground, b.c);
  Boolean on(start = false), off(start = false);
  Real x(start = 0);
  Force f(b.c, fx = if on then x*(4 N) else 0 N);
initial equation
  rail.s = 0 m; rail.v = 0 m/s;
equation
  when rail.s > 1 m and not off then on = true; elsewhen rail.v*time < 2 m or x > 3 then on = false; end when;
  when sample(0, 1 s) then x = pre(x) + 1; off = pre(x) > 2; end when;
end Pushed;"""


def test_accelerations_at_a_known_state_take_no_evaluation(monkeypatch):
    """a = 4 x/2 while ``on``: from the numbers and the state, each of which is a part of what is known."""
    system, calls, call = build(mbdsl.parse(PUSHED)), [], Native.__call__

    def counted(self, *arguments):
        calls.append(self)
        return call(self, *arguments)

    monkeypatch.setattr(Native, "__call__", counted)
    q, v = np.zeros(3), np.array([1.0, 0.0, 0.0])
    for k in range(2):
        calls.clear()
        for on in (0.0, 1.0):
            for x in (1.0, 3.0):
                system.set_input("on", on)
                system.set_input("x", x)
                a, _ = accelerations(system, 0.5, q, v)
                assert a == pytest.approx([2.0 * x * on, 0.0, 0.0], abs=1e-14)
                a[:] = 7.0  # the caller's own
        assert bool(calls) == (k == 0)
    system.tables.resize(3.0)  # rows are balanced in another way
    assert accelerations(system, 0.5, q, v)[0] == pytest.approx([6.0, 0.0, 0.0])


def test_conditions_have_the_truth_of_their_expressions():
    """At random states and values, against the expressions themselves."""
    scene = mbdsl.parse(PUSHED)
    system, rng = build(scene), np.random.default_rng(3)
    seen = set()
    for _ in range(50):
        t, (s, w) = rng.uniform(0, 3), rng.uniform(-3, 3, 2)
        given = {name: float(rng.integers(0, 2)) for name in ("on", "off")} | {"x": float(rng.integers(0, 6))}
        given |= {name: 0.0 for name in system.tables.inputs if name not in given}
        for name, x in given.items():
            system.set_input(name, x)
        known = {"x": s, "vx": w, "y": 0.0, "vy": 0.0, "phi": 0.0, "w": 0.0}

        def leaf(n, t=t, known=known, given=given):
            if n.op == "coordinate":
                return np.array([known[n.value[1]] if n.value[0].startswith("b") else 0.0])
            return np.array([t if n.op == "time" else given[str(n.value)]])

        expected = [bool(x[0]) for x in evaluate(scene.conditions, leaf, ARRAY_OPERATIONS)]
        found = system.conditions(t, np.array([s, 0.0, 0.0]), np.array([w, 0.0, 0.0]))
        assert found.tolist() == expected
        seen.add(tuple(expected))
    assert len(seen) >= 3
