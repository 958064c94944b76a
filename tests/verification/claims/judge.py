"""The rule for claims, and the true error; only the mechanism's size, which the error norm uses, is from mbdsl."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from claim import Claim

ASKED, SAID = 3.0, 10.0  #: the true error may be this factor times the requested and the stated one
QUIET = 0.1  #: below this part of the stated error, the statement counts as pessimistic
FLOOR = 1e-13  #: rounding: lower statements are raised to this value

TRUE, PESSIMISTIC, STOPPED, UNKNOWN, LATE, LIE = "true", "pessimistic", "stopped", "not known", "too slow", "LIE"


@dataclass(frozen=True)
class Verdict:
    """Verdict: ``truth`` is the error of the run, ``said`` its stated error, ``asked`` the requested accuracy."""

    verdict: str
    asked: float | None = None
    said: float | None = None
    truth: float | None = None
    reason: str = ""


def error(claim: Claim, run, until: float = math.inf) -> float:
    """The largest over outputs up to ``until`` [s].

    Positions over the mechanism's size, angles in radians; velocities likewise, and over the largest of the run (also
    between outputs, where that is known), which is at least one size or radian in the time of the run.
    """
    truth, size = claim.truth(), run.system.tables.size
    times = claim.times
    kept = times <= until
    t = run.t - claim.begin
    rows = np.searchsorted(t, times[kept] - 1e-9 * claim.stop)
    if not len(rows) or rows.max() >= len(t) or np.abs(t[rows] - times[kept]).max() > 1e-9 * claim.stop:
        return math.inf if len(rows) else 0.0
    turned = ("phi", "w")
    speeds = [np.abs(x).max() / (1.0 if key.endswith(".w") else size) for key, x in claim.between().items()
              if key.endswith((".vx", ".vy", ".w"))]  # fmt: skip
    speed = max(1.0 / claim.stop, *speeds)
    worst = 0.0
    for key, x in truth.items():
        quantity = key.rsplit(".", 1)[1]
        scale = (1.0 if quantity in turned else size) * (speed if quantity in ("vx", "vy", "w") else 1.0)
        off = np.abs(run[key][rows] - x[kept])
        worst = max(worst, float(off.max(initial=0.0)) / scale)
    return worst


def judge(claim: Claim, run, asked: float | None, said: float | None, until: float = math.inf) -> Verdict:
    """Whether the run kept its promise."""
    truth = error(claim, run, until)
    floor = max(FLOOR, claim.stored["agrees"])
    if asked is not None and not truth <= ASKED * max(asked, floor):
        return Verdict(LIE, asked, said, truth, "more than three times what was asked for")
    if said is None:
        return Verdict(UNKNOWN, asked, said, truth)
    if not truth <= SAID * max(said, floor):
        return Verdict(LIE, asked, said, truth, "more than ten times what was said")
    return Verdict(PESSIMISTIC if truth < QUIET * said else TRUE, asked, said, truth)


def stopped(claim: Claim, run, asked: float | None, reason: str) -> Verdict:
    """A run that ends with a reason, or states until when it keeps the requested accuracy: the statement has to be
    true."""
    until = None if run is None else run.stats.get("horizon")
    if until is None or asked is None:
        return Verdict(STOPPED, asked, reason=reason)
    truth = error(claim, run, until - claim.begin)
    floor = max(FLOOR, claim.stored["agrees"])
    if truth > ASKED * max(asked, floor):
        return Verdict(LIE, asked, asked, truth, f"kept until t = {until:g} s, it says, but it is not")
    return Verdict(STOPPED, asked, reason=reason)
