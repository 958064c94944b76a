"""Energy of the slider crank without its damper: conserved by the motion, lost by methods, with their order.

The mean error eps(T) = 1/T int |E - E(0)| dt is the paper's (Negrut, Jay, Khude 2009, eq. (14)); E(0) = 0.
"""

import numpy as np
import pytest

import mbdsl

#: Five halvings. Over 2 s, as over longer times the lost part of the energy, which falls with h^3, is the larger one.
STEPS = [2.0**-k for k in range(7, 13)]
STOP = 2.0


@pytest.fixture(scope="module")
def scene(model):
    return mbdsl.load(model("slider_crank"), {"c": 0.0})


def energy(scene, method, h, stop, **options):
    """Time, and the energy at every step."""
    found = mbdsl.simulate(scene, method=method, step=h, stop=stop, interval=0.0, options=options)
    assert len(found) == round(stop / h) + 1
    assert found["energy.total"][0] == pytest.approx(0.0, abs=1e-14)  # datum at O, spring relaxed
    return found.t, found["energy.total"]


def mean_error(scene, method, h):
    t, E = energy(scene, method, h, STOP)
    size = np.abs(E - E[0])
    return ((size[1:] + size[:-1]) / 2 * np.diff(t)).sum() / STOP


def test_mean_error(scene, method, wrong_orders):
    assert not wrong_orders(method, STEPS, {"eps": [mean_error(scene, method, h) for h in STEPS]})


def test_energy_is_lost_not_gained(scene, method):
    """Over 50 s the energy falls, by less than the 2 J that the motion turns around; a method unstable here gains."""
    _, E = energy(scene, method, 2.0**-9, 50.0)
    late, early = E[-1024:].mean(), E[:1024].mean()
    assert -0.5 < late < early < 0.1
