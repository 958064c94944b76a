"""Figures of many methods in parts, and pages that open with the answer."""

import pytest

from mbdsl.integrators import available
from mbdsl.plotting.figure_layout import lay_out
from mbdsl.plotting.figures import Figure, Outcome, Page, Series, TextTable
from mbdsl.studies.families import family
from mbdsl.studies.figure_parts import MOST, on_front, parts
from mbdsl.studies.report import Study

EVERY = [f"{name}{' --tol' if kind and len(m.steps) == 2 else ''}" for name, m in available().items()
         for kind in range(len(m.steps))]  # fmt: skip


def figure(names, **more):
    series = [Series(name, [1e-3, 1e-4], [1e-3 * (k + 1), 1e-2 * (k + 1)]) for k, name in enumerate(names)]
    return Figure("q", "Work", "error", "time [s]", [*series, Series("guide", [1, 2], [1, 2], style="guide")], **more)


def plain(part):
    return [s.name for s in part.series if s.style not in ("front", "guide")]


def test_few_series_are_one_picture():
    whole = figure(EVERY[:MOST])
    assert parts(whole) == [whole]


def test_all_methods_are_shown_once_by_family_and_the_best_first():
    whole = figure(EVERY)
    first, *rest = parts(whole)
    assert all(0 < len(plain(part)) <= MOST for part in (first, *rest))
    assert sorted(name for part in rest for name in plain(part)) == sorted(EVERY)
    families = [family(name.split()[0]) for name in plain(first)]
    assert len(families) == len(set(families)) == len({family(name) for name in available()})
    for name in plain(first):  # times grow with the place in the list
        own = [other for other in EVERY if family(other.split()[0]) == family(name.split()[0])]
        assert name == own[0]
    keys = [part.key for part in (first, *rest)]
    assert keys[0] == "q" and len(set(keys)) == len(keys)


def test_parts_have_the_axes_of_the_whole():
    whole = figure(EVERY)
    ends = {(frame.x.low, frame.x.high, frame.y.low, frame.y.high) for frame in map(lay_out, (whole, *parts(whole)))}
    assert len(ends) == 1


def test_failures_are_shown_with_their_family():
    missing = [Outcome("nstiff", None, "diverged"), Outcome("hht-i3", None, "diverged")]
    names = [name for name in EVERY if name != "nstiff"]
    found = parts(figure(names, outcomes=missing))
    where = {o.name: [part.title for part in found if o in part.outcomes] for o in missing}
    assert len(where["nstiff"]) == 1 and "BDF2" in where["nstiff"][0]
    assert any("Newmark" in title for title in where["hht-i3"])


def test_the_best_is_on_the_front():
    one, two = Series("hht-i3", [1e-2, 1e-3], [1.0, 2.0]), Series("hht-si2", [1e-6], [1e-6])
    whole = Figure("q", "t", "x", "y", [Series("least time", [1e-2, 1e-3], [1.0, 2.0], style="front"), one, two])
    assert on_front(whole, one) < on_front(whole, two)


@pytest.mark.parametrize("answers", [0, 1])
def test_a_page_opens_with_the_answer_and_the_pictures(answers, monkeypatch):
    """Tables of single runs come last."""

    class Some(Study):
        title = "P: some"

        def __init__(self):
            pass

        def answers(self):
            return answers

        def tables(self):
            return [TextTable("answer", ("a",), [("1",)]), TextTable("all runs", ("a",), [("1",)])]

        def figures(self):
            return [figure(["hht-i3", "radau5"])]

        def facts(self):
            return {}

        def _texts(self):
            return {}

    page = Some().page()
    assert isinstance(page, Page)
    kinds = [getattr(item, "title", "") for item in page.items]
    assert kinds == (["answer", "Work", "all runs"] if answers else ["Work", "answer", "all runs"])
    assert page.looks["radau5"].mark == "star"
