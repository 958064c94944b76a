"""Kinship of methods: errors of one family may agree with each other, those of two families hardly do."""

from __future__ import annotations

from mbdsl.integrators import available, compiled

#: those of order 2 that are extrapolated where there is no better
EXTRAPOLATED = ("hht-si2", "nstiff-si2")


def family(method: str) -> str:
    """What a method says that it belongs to; one that says nothing is a family of its own."""
    found = available().get(method)
    return found.family if found is not None and found.family else method


def precise() -> list[str]:
    """Methods of high order with error control, the best reference first: our own, then what needs nothing more."""
    own = compiled()
    high = {name: m for name, m in available().items() if m.order > 4 and "controlled" in m.steps}
    return sorted(high, key=lambda name: (name not in own, high[name].needs != ""))


def of_another_family(method: str, kind: str) -> str | None:
    """A method to check ``method`` with, of another family, whose steps are of ``kind`` ("fixed", "controlled")."""
    wanted = [*precise(), *EXTRAPOLATED] if kind == "controlled" else [*EXTRAPOLATED]
    there = available()
    return next((n for n in wanted if n in there and kind in there[n].steps and family(n) != family(method)), None)
