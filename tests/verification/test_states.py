"""Models with states against numbers that were computed without mbdsl: in minimal coordinates, by classical Runge-Kutta
methods with fixed steps, or by SciPy."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl

MACHINES = Path(__file__).parents[1] / "data" / "machines"
GALLERY = Path(__file__).parents[2] / "models" / "gallery"
#: angles of the boom [deg] at 1, 2, 3 s, in minimal coordinates
BOOM = [20.3535, 33.2030, 34.5896]


@pytest.mark.parametrize(
    "method", ["hht-i3", "hht-si2", "hht-add", "nstiff", "nstiff-si2", "generalized-alpha", "generalized-alpha-i3"]
)
def test_boom(method):
    run = mbdsl.simulate(MACHINES / "boom.mbd", stop=3, step=1e-3, interval=1, method=method)
    assert np.rad2deg(run["pin.phi"][1:]) == pytest.approx(BOOM, abs=1e-4)


def test_motor_crank():
    run = mbdsl.simulate(MACHINES / "motor_crank.mbd", stop=1.4, tol=1e-7, method="radau9", interval=1e-4)
    assert run["O.w"][10_000] == pytest.approx(47.71417, abs=1e-5)
    peak = np.argmax(run["O.w"])
    assert run["O.w"][peak] == pytest.approx(51.59834, abs=2e-5)
    assert run.t[peak] == pytest.approx(1.36596, abs=1e-4)
    # the limit of the current is reached, and the integrator stops there
    assert run["i"].max() == pytest.approx(10.0, abs=1e-3)
    assert np.abs(run["der(z)"]).max() <= 50.0


@pytest.mark.parametrize(("name", "model"), [("boom", "hydraulic_boom"), ("motor_crank", "motor_crank")])
def test_models_of_the_gallery_are_these(name, model):
    one, other = mbdsl.load(MACHINES / f"{name}.mbd"), mbdsl.load(GALLERY / f"{model}.mbd")
    assert one.components == other.components
    assert one.initial == other.initial
