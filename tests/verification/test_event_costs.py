"""Many events: their number, their end, and a cost in proportion, by evaluations of the equations."""

import sys
from itertools import pairwise
from pathlib import Path

import pytest

import mbdsl
from mbdsl.compilation.native_call import Native

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from event_costs import CONTINUOUS, SAMPLED, WALLS


def calls(monkeypatch, text, **options):
    """A run, and the number of its calls of compiled functions."""
    count, call = 0, Native.__call__

    def counted(self, *arguments):
        nonlocal count
        count += 1
        return call(self, *arguments)

    with monkeypatch.context() as patched:
        patched.setattr(Native, "__call__", counted)
        found = mbdsl.simulate(mbdsl.parse(text), **options)
    return found, count


@pytest.mark.parametrize(("options", "most"), [({"step": 1e-3}, 100), ({"method": "radau9", "tol": 1e-6}, 200)])
def test_the_cost_of_impacts_is_proportional(options, most, monkeypatch):
    """Every impact takes as many evaluations as those before; bisection of its time would take forty more. A run with
    a tolerance is made twice."""
    runs = [calls(monkeypatch, WALLS, stop=n * 1e-3, interval=n * 1e-5, **options) for n in (20, 40, 80)]
    assert [run.stats["kinds of events"] for run, _ in runs] == [{"impact": n} for n in (20, 40, 80)]
    first, second = (b - a for (_, a), (_, b) in pairwise(runs))
    assert second == pytest.approx(2 * first, rel=0.1)  # 4 if each impact cost in proportion to those before it
    assert first / 20 < most


def test_many_impacts():
    """Half a millisecond behind the last impact the body is in the middle again, whatever the number of impacts."""
    found = mbdsl.simulate(mbdsl.parse(WALLS), stop=0.3, step=1e-3, interval=0.3)
    assert found.stats["kinds of events"] == {"impact": 300}
    assert found["s.s"][-1] == pytest.approx(0.5e-3, abs=1e-13)
    assert found["s.v"][-1] == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("count", [200_000, 1_000_000], ids=["fifth", "million"])
def test_many_samples(count):
    """The last tick is at the end exactly, where the run has its last output; no iterations are added."""
    runs = [
        mbdsl.simulate(mbdsl.parse(text), stop=count * 1e-3, step=1e-3, interval=count * 1e-5)
        for text in (SAMPLED, CONTINUOUS)
    ]
    sampled, without = runs
    assert sampled.t[-1] == count * 1e-3 and len(sampled.t) == 101
    assert sampled.stats["kinds of events"] == {"sample": count + 1}
    assert sampled.stats["steps"] == without.stats["steps"] == count
    assert sampled.stats["iterations"] <= without.stats["iterations"] + count
