"""Two parallelograms of equal bars through poses in which the constraints lose rank.

Every 0.5 or 1.4 s all bars lie on one line, and the mechanism could go on as an antiparallelogram. The reference goes
on as the parallelogram. All methods pass; at large steps hht-add passes on some processors only, and stops on others.
"""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError

STEPS = (1e-2, 5e-3, 2e-3, 1e-3)
#: method -> for each of STEPS the largest error of the first rocker's angle and angular velocity at TIMES that is
#: allowed, one and a half times what was measured
ALLOWED = {
    "newmark": (1.5, 0.8, 0.33, 0.16),
    "hht-i3": (9e-2, 1.5e-2, 1.5e-3, 3e-4),
    "nstiff": (1.0, 0.2, 1.5e-2, 2.5e-3),
    "nstiff-si2": (0.8, 0.12, 9e-3, 1.5e-3),
    "hht-add": (1.1e-2, 3e-3, 5e-4, 1.2e-4),
    "hht-si2": (9e-2, 1.5e-2, 1.5e-3, 3e-4),
}
#: 14 poses in line are passed in 10 s, two in 2 s. newmark passes all, but damps the motion: with h = 1 ms it loses
#: 1.3 J in 10 s, and sooner or later does not get over the top any more.
TIMES = {**dict.fromkeys(ALLOWED, (1, 2, 5, 10)), "newmark": (1, 2)}


@pytest.fixture(scope="module")
def rows(reference):
    return {row["t"]: row for row in reference("four_bar_N2")["reference_N2"]}


@pytest.mark.parametrize(("k", "h"), list(enumerate(STEPS)))
def test_right_or_refused(model, rows, method, k, h):
    try:
        found = mbdsl.simulate(model("four_bar"), method=method, step=h, stop=10.0, interval=1.0)
    except IntegrationError as stopped:  # whether hht-add passes depends on rounding
        if method != "hht-add" or "hht-add does not pass all singular poses" not in str(stopped):
            raise
        found = stopped.trajectory
        assert found.t[-1] > 1.0
    error = max(
        abs(found[name][t] - float(rows[t][key]))
        for t in TIMES[method]
        if t <= found.t[-1]
        for name, key in (("R[1].phi", "theta"), ("R[1].w", "thetadot"))
    )
    assert error < ALLOWED[method][k]
    for rocker in ("R[2]", "R[3]"):  # still parallelograms
        assert np.abs(found[f"{rocker}.phi"] - found["R[1].phi"]).max() < 1e-9


@pytest.mark.parametrize("method", ["hht-i3", "nstiff", "nstiff-si2", "hht-si2"])
def test_small_steps(model, rows, method):
    """A twentieth of the smallest of STEPS comes closer to the singular poses; the errors are a 400th."""
    found = mbdsl.simulate(model("four_bar"), method=method, step=STEPS[-1] / 20, stop=10.0, interval=1.0)
    for t in (1, 2, 5):
        for name, key in (("R[1].phi", "theta"), ("R[1].w", "thetadot")):
            assert abs(found[name][t] - float(rows[t][key])) < ALLOWED[method][-1] / 400
    for rocker in ("R[2]", "R[3]"):
        assert np.abs(found[f"{rocker}.phi"] - found["R[1].phi"]).max() < 1e-9


@pytest.mark.parametrize("h", [1e-3, 2e-3])
def test_where_hht_add_stops_with_five_loops(model, h):
    """Rounding decides whether it stops. Until then energy is conserved; the message gives the reason and a remedy."""
    failure, five = None, {"N": 5}
    try:
        found = mbdsl.simulate(model("four_bar"), method="hht-add", step=h, stop=10.0, parameters=five)
    except mbdsl.IntegrationError as problem:
        failure, found = problem, problem.trajectory
    assert np.ptp(found["energy.total"]) < 1e-3 * found["energy.kinetic"].max()
    if failure is not None:
        assert "a singular value of Phi_q falls by more than half within a step; hht-si2 or hht-i3" in failure.hint
        until = found.t[-1] + 10 * h
        assert mbdsl.simulate(model("four_bar"), method="hht-si2", step=h, stop=until, parameters=five).status == "done"
