"""A soft cable that is released: large deformation compared with two other programs, within their error bounds."""

import numpy as np
import pytest

import mbdsl

TRUSTED = 2e-6  #: m, of the reference


@pytest.fixture(scope="module")
def distance(model, reference):
    """``distance(elements, h)``: the largest of the tip from the reference, at 0.1, 0.2, ..., 1 s."""
    rows = np.array(reference("flexible_pendulum")["rows"])

    def find(elements, h):
        run = mbdsl.simulate(
            model("flexible_pendulum"), step=h, interval=0.1, parameters={"elements": elements}, method="hht-si2"
        )
        assert run.t[1:] == pytest.approx(rows[:, 0])
        return np.abs(np.stack([run["cable.b.x"], run["cable.b.y"]], axis=1)[1:] - rows[:, 1:]).max()

    return find


def test_tip(distance, optimised):
    """More elements and shorter steps come closer: 16 elements do not resolve short waves, 64 reach the error bound."""
    coarse, middle, fine = distance(16, 1e-4), distance(32, 1e-4), distance(64, 5e-5)
    assert fine < TRUSTED
    assert fine < middle < coarse / 8
    assert coarse > 5 * TRUSTED  # otherwise the difference could not be seen
