"""Specialisation changes the computation, not its results.

Every shipped model against the general computation: the code of all kinds, nothing merged, carried, split or solved
beforehand. If only code is left out, both do the same operations in the same order: results are equal to the last bit
(compilers must not reorder them). If drivers were turned into functions of time, the general computation solves for
quantities that the specialised one knows.
"""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators import available

MODELS = Path(__file__).parents[2] / "models"
#: models whose drivers became functions of time
REDUCED = {"crank_ivp", "driven_crank", "spin_up_beam", "stick_slip_belt"}
SAME = sorted({path.stem for path in MODELS.glob("*.mbd")} - REDUCED)
#: methods that enforce velocity constraints, so that velocities do not have the method's error
STABILISED = {name for name, method in available().items() if "dPhi" in method.enforces}
#: model -> (step, stop) if its own would take long for another method; otherwise 100 steps of 1 ms
SHORT = {"seven_body": (1e-5, 1e-3), "stick_slip_belt": (1e-4, 0.1)}


def both(name, **given):
    """Specialised, then general."""
    path = MODELS / f"{name}.mbd"
    return [mbdsl.simulate(path, general=general, **given) for general in (False, True)]


def apart(a, b, key, first=0):
    """Largest difference of q, v or lam, from the output ``first`` on, relative to the largest value."""
    one, other = getattr(a, key), getattr(b, key)
    assert one.shape == other.shape and one[first:].size
    return np.abs(one - other)[first:].max() / np.abs(other).max()


def test_all_models_are_compared():
    assert len(SAME) >= 9
    for name in SAME:
        assert mbdsl.load(MODELS / f"{name}.mbd").name


@pytest.mark.parametrize("name", SAME)
def test_equal_over_the_whole_run(name):
    a, b = both(name)
    assert len(a) > 100 and a.stats["solved"] == b.stats["solved"]
    for key in ("q", "v", "lam"):
        assert np.array_equal(getattr(a, key), getattr(b, key)), key
    assert a.stats["iterations"] == b.stats["iterations"]


@pytest.mark.parametrize("name", SAME)
def test_equal_with_every_method(name, method):
    step, stop = SHORT.get(name, (1e-3, 0.1))
    parameters = {"N": 6} if name == "chain" else {}
    a, b = both(name, method=method, step=step, stop=stop, interval=step, parameters=parameters)
    for key in ("q", "v", "lam"):
        assert np.array_equal(getattr(a, key), getattr(b, key)), key


def test_codes_differ():
    """Otherwise nothing was compared: the general code has functions that the scene does not need."""
    a, b = both("pendulum", stop=0.01)
    assert "mbdsl_kind_revolute" not in a.system.code and "loops.springs" not in a.system.code
    assert "mbdsl_kind_revolute" in b.system.code and "loops.springs" in b.system.code


# -- quantities known as functions of time ---------------------------------------------------------------------------


def test_belt(method):
    """The belt is carried in one and driven in the other: Newton's iteration ends at another point.

    It leaves 1e-11 of the mechanism, or 1e-5 of the method's own error; friction that changes its sign over 0.1 mm/s
    turns differences of velocities, of 8e-12 of the largest, into forces some 1e3 times as large.
    """
    step, stop = (5e-5, 2.0) if method == "hht-si2" else (1e-4, 0.6)
    a, b = both("stick_slip_belt", method=method, step=step, stop=stop)
    assert (a.stats["solved"]["n"], b.stats["solved"]["n"]) == (3, 6)
    assert apart(a, b, "q") < 1e-8
    assert apart(a, b, "v") < 1e-7
    assert apart(a, b, "lam") < 1e-6


@pytest.mark.parametrize(("name", "step", "stop"), [("crank_ivp", 2e-5, 5e-3), ("spin_up_beam", 2e-3, 1.0)])
def test_beams_on_what_is_driven(name, step, stop, method):
    """Phi of the driver is enforced by all methods: positions are equal to the tolerance of Newton's iteration, 1e-11
    of the mechanism; velocities likewise (8e-12 of the largest a step) if dPhi is enforced, otherwise the driven body's
    differ by the residual dPhi of index-3 methods, which is of order 2."""
    gaps = []
    for h in (step, step / 2):
        a, b = both(name, method=method, step=h, stop=stop, interval=stop / 10)
        assert (a.stats["solved"]["n"], b.stats["solved"]["n"]) == (9, 12)
        assert apart(a, b, "q") < 1e-11
        gaps.append(apart(a, b, "v"))
    if method in STABILISED:
        assert max(gaps) < 1e-9
    else:
        assert 3.5 < gaps[0] / gaps[1] < 4.5


def test_driven_crank(method):
    """Kinematics is exact: the general computation comes to it with the order of its method.

    Positions are equal to the tolerance of Newton's iteration, 1e-11 of the mechanism, since all methods enforce Phi;
    so are velocities, to 8e-12 of the largest, where dPhi is enforced. All else falls with the order; of methods of
    index 3 multipliers do so once the start is forgotten, whose error is of order 1: the second half of the run is
    compared.
    """
    order = available()[method].order
    gaps = []
    for step in (2e-3, 1e-3, 5e-4):
        stop = 2.0 if method == "hht-si2" else 0.5
        a, b = both("driven_crank", method=method, step=step, stop=stop, interval=2e-3)  # all of them ends of steps
        assert apart(a, b, "q") < 1e-11
        assert a.stats["solved"]["n"] == 5 and b.stats["solved"]["n"] == 8
        if method in STABILISED:
            assert apart(a, b, "v") < 1e-10
        gaps.append([apart(a, b, key, len(a) // 2) for key in ("v", "lam")])
    slopes = np.log2(np.array(gaps[:-1]) / gaps[1:])
    if method not in STABILISED:
        assert np.all(slopes[:, 0] > order - 0.15), slopes
    if available()[method].own_reactions:
        assert np.all(slopes[:, 1] > order - 0.15), slopes
    else:  # found from q and v, by both
        assert max(lam for _, lam in gaps) < 1e-10


# -- with effects left out -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("effects", [("gravity",), ("damping",), ("damping", "gravity")])
def test_general_and_specialised_agree_without(effects):
    a, b = both("slider_crank", without=effects)
    whole = mbdsl.simulate(MODELS / "slider_crank.mbd")
    assert np.array_equal(a.q, b.q) and np.array_equal(a.lam, b.lam)
    assert np.abs(a.q - whole.q).max() > 1e-2  # the effect does matter


def test_general_and_specialised_agree_without_friction():
    a, b = both("stick_slip_belt", without=("friction",), step=1e-4)
    assert "loops.laws" not in a.system.code and "loops.laws" in b.system.code
    # no friction: an oscillation of the block by itself, as exact as Newton's iteration
    assert apart(a, b, "q") < 1e-10
    assert apart(a, b, "v") < 1e-9
