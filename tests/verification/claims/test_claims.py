"""Models made to mislead an error estimate: the stated accuracy is true, or the run ends with the reason.

A subset of cheap cells; ``table.py`` runs the rest and makes docs/claims.md.
"""

import math
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import judge
from claim import OUTPUTS
from jets import Jet, acos, asin, atan2, cos, sin, sqrt
from subset import REACHED, SUBSET
from table import cell

from models import CLAIMS

CELLS = [pytest.param(*job, id="-".join(str(x) for x in job)) for job in SUBSET]


@pytest.mark.parametrize(("name", "way", "method", "asked"), CELLS)
def test_claim(name, way, method, asked):
    found = cell(name, way, method, asked, limit=math.inf)
    assert found.verdict not in (judge.LIE, judge.LATE), found


@pytest.mark.parametrize("job", REACHED, ids=lambda job: "-".join(str(x) for x in job))
def test_a_good_run_is_not_stopped(job):
    found = cell(*job, limit=math.inf)
    assert found.verdict == judge.TRUE, found


def test_every_model_has_an_answer():
    assert len(CLAIMS) >= 100
    assert {name for name, *_ in SUBSET + REACHED} <= set(CLAIMS)
    for claim in CLAIMS.values():
        assert len(claim.stored["z"]) == len(claim.stored["v"]) == OUTPUTS
        assert claim.stored["agrees"] < 1e-4


def test_lies_are_found():
    """The judge itself: a run that states a tenth of a thousandth of its error, and one whose statement is true."""
    import mbdsl

    claim = CLAIMS["TwoHundred"]
    run = mbdsl.simulate(mbdsl.parse(claim.text), method="newmark", step=0.5, interval=claim.stop / OUTPUTS)
    truth = judge.error(claim, run)
    assert truth > 0.5
    assert judge.judge(claim, run, None, truth / 11).verdict == judge.LIE
    assert judge.judge(claim, run, truth / 3.1, truth).verdict == judge.LIE
    assert judge.judge(claim, run, truth / 2.9, truth / 9).verdict == judge.TRUE
    assert judge.judge(claim, run, None, truth * 11).verdict == judge.PESSIMISTIC
    assert judge.judge(claim, run, truth, None).verdict == judge.UNKNOWN


@pytest.mark.parametrize("t", [0.3, 0.8])
def test_jets(t):
    """First and second derivatives, against differences."""

    def f(x):
        a, b = sin(x) + 2.0, cos(x * x) / (x + 1.0)
        return sqrt(a) * b - asin(b) + atan2(a, b) + acos(0.3 * b)

    h = 1e-4
    low, mid, high = (f(Jet(t + d)).f for d in (-h, 0.0, h))
    found = f(Jet(t, 1.0, 0.0))
    assert found.f == mid
    assert found.d == pytest.approx((high - low) / (2 * h), abs=1e-6)
    assert found.e == pytest.approx((high - 2 * mid + low) / h**2, abs=1e-5)
