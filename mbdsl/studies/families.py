"""Kinship of methods: errors of one family may agree with each other, those of two families hardly do."""

from __future__ import annotations

from mbdsl.integrators import methods

FAMILIES = {
    "newmark": "Newmark",
    "hht-i3": "Newmark",
    "hht-si2": "Newmark",
    "hht-add": "Newmark",
    "generalized-alpha": "Newmark",
    "generalized-alpha-si2": "Newmark",
    "nstiff": "BDF2",
    "nstiff-si2": "BDF2",
    "radau5": "Radau IIA",
    "scipy-radau": "Radau IIA",
    "scipy-dop853": "Dormand-Prince",
    "scipy-lsoda": "Adams/BDF",
    "ida": "BDF",
}
#: methods of high order with error control, the best reference first
PRECISE = ("radau5", "scipy-dop853", "ida", "scipy-radau", "scipy-lsoda")
#: those of order 2 that are extrapolated where there is no better
EXTRAPOLATED = ("hht-si2", "nstiff-si2")


def family(method: str) -> str:
    """Methods that nobody has said anything about are families of their own."""
    return FAMILIES.get(method, method)


def precise() -> list[str]:
    """Methods of high order that are there, the best reference first; unknown ones with an order above 4 last."""
    own = [name for name in PRECISE if name in methods()]
    others = [n for n, m in methods().items() if n not in FAMILIES and m.order > 4 and "controlled" in m.steps]
    return own + others


def of_another_family(method: str, kind: str) -> str | None:
    """A method to check ``method`` with, of another family, whose steps are of ``kind`` ("fixed", "controlled")."""
    wanted = [*precise(), *EXTRAPOLATED] if kind == "controlled" else [*EXTRAPOLATED]
    there = methods()
    return next((n for n in wanted if n in there and kind in there[n].steps and family(n) != family(method)), None)
