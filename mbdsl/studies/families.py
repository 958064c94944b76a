"""Families of methods: the errors of methods of one family may agree; those of two families rarely do."""

from __future__ import annotations

from mbdsl.integrators import available, compiled

#: methods of order 2 to extrapolate if there is none of high order
EXTRAPOLATED = ("hht-si2", "nstiff-si2")


def family(method: str) -> str:
    """The declared family of a method; without a declaration its own name."""
    found = available().get(method)
    return found.family if found is not None and found.family else method


def precise(spatial: bool) -> list[str]:
    """Methods of high order with error control, for models in the plane or in space, the best reference first: mbdsl's
    own, then those without an extra; in each group those without a limit of stability first."""
    own = compiled()
    high = {name: m for name, m in available(spatial).items() if m.order > 4 and "controlled" in m.steps}
    return sorted(high, key=lambda name: (name not in own, high[name].needs != "", high[name].explicit))


def of_another_family(method: str, kind: str, spatial: bool) -> str | None:
    """A method of another family to check ``method`` with, with steps of ``kind`` ("fixed", "controlled")."""
    wanted = [*precise(spatial), *EXTRAPOLATED] if kind == "controlled" else [*EXTRAPOLATED]
    there = available()
    return next((n for n in wanted if n in there and kind in there[n].steps and family(n) != family(method)), None)
