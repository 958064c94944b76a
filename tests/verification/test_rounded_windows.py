"""Windows whose width is a difference of decimals: the stated error contains the rounding of their ends.

The impulse of a force F between t1 and t2 is F (t2 - t1) with the exact decimals; in double precision the width is
uncertain by half a digit of each end.
"""

from fractions import Fraction

import pytest

import mbdsl

TEXT = """model Window
  Ground ground(g = 0);
  Body A(m = 1 kg, I = 1 kg.m2);
  Prismatic j(ground, A.c);
  Force push(A.c, fx = if time > T1 s and time < T2 s then F N else 0 N);
initial equation
  j.s = 0 m; j.v = 0 m/s;
  annotation(experiment(StopTime = 10 s));
end Window;"""


@pytest.mark.parametrize("method", ["hht-si2", "radau5", "dop853", "nstiff-si2"])
@pytest.mark.parametrize(("t1", "width"), [("3.3337", "0.000001"), ("7.123", "0.00000003"), ("3600.1", "0.000001")])
def test_the_claim_contains_rounding(t1, width, method):
    t2 = str(float(Fraction(t1) + Fraction(width)))
    text = TEXT.replace("T1", t1).replace("T2", t2).replace("F N", f"{1 / float(width)!r} N")
    start = 3600.0 if t1.startswith("36") else 0.0
    run = mbdsl.simulate(mbdsl.parse(text), method=method, tol=1e-5, start=start, stop=start + 10)
    truth = float((Fraction(t2) - Fraction(t1)) * Fraction(1 / float(width)))
    assert abs(run["j.v"][-1] - truth) <= 10 * run.stats["error"] < 1e-4
