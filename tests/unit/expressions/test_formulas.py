"""Formulas of elements as text, against the same expressions made by hand."""

import pytest

from mbdsl.expressions import derivatives, formulas
from mbdsl.expressions import symbolic as ex

S, V = ex.coordinate("a", "x"), ex.coordinate("a", "vx")
K, L = ex.input_signal("k"), ex.input_signal("l")


class Names:
    def value(self, name):
        return {"s": S, "v": V, "k": K, "l": L, "two": 2.0}[name]

    def element(self, name, index):
        return ex.multiplier(name, index - 1)

    def coordinate(self, port, key):
        return ex.coordinate(port, key)


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        ("k*(s - 0.5)^2 + l*v/two", K * ((S - 0.5) * (S - 0.5)) + L * V / 2.0),
        ("-(s/l)^2", -((S / L) * (S / L))),
        ("k - l - s", (K - L) - S),
        ("k/l*s", (K / L) * S),
        ("2^k", ex.call("pow", 2.0, K)),
        ("hypot(lam[1], -lam[2])", ex.call("hypot", ex.multiplier("lam", 0), -ex.multiplier("lam", 1))),
        ("der(s^2)", derivatives.der(S * S)),
        ("frame_a.phi*two", ex.coordinate("frame_a", "phi") * 2.0),
        ("two*two - 1", ex.const(3.0)),
    ],
)
def test_formula(formula, expected):
    assert formulas.evaluate(formula, Names()) is expected


@pytest.mark.parametrize(
    "formula", ["s if k else v", "s.x.y", "[s]", "'s'", "s(k)", "__import__('os')", "k < s", "lam[k]", "sin(s, k=1)"]
)
def test_anything_else_is_refused(formula):
    with pytest.raises(ValueError, match="cannot be part of a formula"):
        formulas.evaluate(formula, Names())
