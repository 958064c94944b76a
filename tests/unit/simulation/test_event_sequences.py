"""Sequences of events of two runs: which pairs of times belong together, and where the sequences part."""

from types import SimpleNamespace

import numpy as np
import pytest

from mbdsl.simulation import event_sequences
from mbdsl.simulation.event_sequences import CLOSES, IMPACT, Event, between, compared

A, B, C = (("when", f"m.mbd:{k}") for k in (1, 2, 3))
HITS, RESTS = (IMPACT, "floor"), (CLOSES, "floor")


def of(monkeypatch, one, other, near=1e-6, stop=10.0):
    """What is found for events (t, source) of two runs."""
    lists = [[Event(t, *what) for t, what in x] for x in (one, other)]
    monkeypatch.setattr(event_sequences, "sequence", lambda run: list(lists[run.k]))
    return compared(*(SimpleNamespace(k=k, contacts=None) for k in (0, 1)), near, stop)


def test_the_same_events_at_other_times(monkeypatch):
    found = of(monkeypatch, [(1.0, A), (2.0, B)], [(1.1, A), (1.9, B)])
    assert found.first is None
    assert found.times.tolist() == [[1.0, 1.1], [2.0, 1.9]]


@pytest.mark.parametrize("other", [[(1.0, A), (2.0, C)], [(1.0, A)], [(1.0, A), (2.5, C), (2.6, B)]])
def test_sequences_that_part(monkeypatch, other):
    found = of(monkeypatch, [(1.0, A), (2.0, B), (3.0, A)], other)
    assert found.end == 2.0
    assert "at t = 2 s" in found.first.text and "m.mbd:" in found.first.text


def test_an_event_of_the_other_run_that_comes_first(monkeypatch):
    found = of(monkeypatch, [(2.0, B)], [(1.0, A), (2.0, B)])
    assert (found.end, found.first) == (1.0, Event(1.0, *A))


def test_events_at_one_time_have_no_order(monkeypatch):
    close = 1.0 + 1e-9
    assert of(monkeypatch, [(1.0, A), (1.0, B)], [(1.0, B), (close, A)]).first is None
    assert of(monkeypatch, [(1.0, A), (1.0, B)], [(1.0, B), (1.1, A)]).first is not None


@pytest.mark.parametrize("turned", [False, True])
def test_a_contact_that_rests_after_more_impacts(monkeypatch, turned):
    runs = [(1.0, HITS), (2.0, RESTS)], [(1.0, HITS), (2.0, HITS), (2.0 + 1e-8, HITS), (2.0 + 2e-8, RESTS)]
    assert of(monkeypatch, *(runs[::-1] if turned else runs)).first is None
    late = [(1.0, HITS), (2.1, HITS), (2.2, RESTS)]
    runs = runs[0], late
    assert of(monkeypatch, *(runs[::-1] if turned else runs)).first is not None


def test_an_event_at_the_end(monkeypatch):
    found = of(monkeypatch, [(1.0, A), (10.0 - 1e-7, B)], [(1.0, A)])
    assert found.first is None and found.times[-1].tolist() == [10.0 - 1e-7, 10.0]


def test_outputs_between_two_times():
    times = np.array([[1.0, 1.25], [3.0, 3.0], [2.0, 1.75]])
    late = between(np.array([0.9, 1.0, 1.1, 1.3, 1.8, 2.0, 2.1, 3.0]), times)
    assert late.tolist() == [0.0, 0.25, 0.25, 0.0, 0.25, 0.25, 0.0, 0.0]
