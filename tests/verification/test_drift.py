"""Constraints on velocities of the slider crank, over 10 s and at every step: satisfied to rounding, or with an error
of order h^p.

The stabilised methods solve for them. The index-3 methods do not: there dPhi is an error like others, bounded, and
falls with the method's order; while the mechanism goes round its violation runs along a closed curve.
"""

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators import compiled

#: Four halvings up to the paper's 2^-10 and 2^-12
STEPS = [2.0**-k for k in range(8, 13)]
STOP = 10.0


@pytest.fixture(scope="module")
def violation(model):
    """``violation(method, h)``: dPhi (5, N) of the two pins and the slot at every step; without the damper."""
    scene, known = mbdsl.load(model("slider_crank"), {"c": 0.0}), {}

    def find(method, h):
        if (method, h) not in known:
            found = mbdsl.simulate(scene, method=method, step=h, stop=STOP, interval=0.0)
            assert len(found) == round(STOP / h) + 1
            names = found.select(["*.dPhi[*]"])
            assert names == ["O.dPhi[1]", "O.dPhi[2]", "A.dPhi[1]", "A.dPhi[2]", "B.dPhi[1]"]
            known[method, h] = np.array([found[name] for name in names])
        return known[method, h]

    return find


@pytest.mark.parametrize("method", [name for name, method in compiled().items() if "dPhi" in method.enforces])
def test_kept(violation, method):
    """Newton's iteration stops at 1e-12 of the velocities, here some m/s."""
    for h in STEPS:
        assert np.abs(violation(method, h)).max() < 1e-10, h


@pytest.mark.parametrize(("method", "order_of_method"), [("newmark", 0.9), ("hht-i3", 1.85), ("nstiff", 1.85)])
def test_falls(violation, order, method, order_of_method):
    """At least with the method's order; newmark's falls with h^2 as well."""
    worst = np.transpose([np.abs(violation(method, h)).max(axis=1) for h in STEPS])
    assert worst.max() < 1e-2
    assert worst.min() > 1e-9  # the violation is large enough to be measured
    for row in worst:
        assert order(STEPS, row) > order_of_method


@pytest.mark.parametrize("method", ["newmark", "hht-i3", "nstiff"])
def test_bounded(violation, method):
    """A limit cycle: no more in the second five seconds than in the first. It fades only as the energy is lost."""
    dPhi = np.abs(violation(method, 2.0**-12))
    half = dPhi.shape[1] // 2
    first, second = dPhi[:, :half].max(axis=1), dPhi[:, half:].max(axis=1)
    assert (second <= 1.01 * first).all()
    assert (second > 0.5 * first).all()
