"""What the verification tests share: the six methods, reference data, shipped models, observed orders."""

import json
from pathlib import Path

import numpy as np
import pytest

TESTS = Path(__file__).parents[1]
MODELS = TESTS.parent / "models"

#: method -> its order; the same six wherever tests are about methods
ORDERS = {"newmark": 1, "hht-i3": 2, "nstiff": 2, "nstiff-si2": 2, "hht-add": 2, "hht-si2": 2}
#: later ones, in tests that ask for every method
LATER = {"generalized-alpha": 2, "generalized-alpha-i3": 2, "radau5": 5}
#: what the slope over all of the steps may be; newmark with gamma = 0.6
SLOPES = {1: (0.9, 1.15), 2: (1.85, 2.15), 5: (4.75, 5.25)}


@pytest.fixture(params=ORDERS, scope="session")
def method(request):
    """Each of the six methods in turn."""
    return request.param


@pytest.fixture(params=[*ORDERS, *LATER], scope="session")
def any_method(request):
    """Each method of our own in turn, with fixed steps."""
    return request.param


@pytest.fixture(scope="session")
def reference():
    """``reference(name)``: the data of ``tests/data/reference/name.json``."""
    return lambda name: json.loads((TESTS / "data" / "reference" / f"{name}.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def model():
    """``model(name)``: the path of a shipped model."""
    return lambda name: MODELS / f"{name}.mbd"


@pytest.fixture(scope="session")
def order():
    """``order(steps, errors)``: the slope of a straight line through log(error) over log(step)."""
    return lambda steps, errors: float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


@pytest.fixture(scope="session")
def order_of():
    """``order_of(method)``."""
    return lambda method: (ORDERS | LATER)[method]


@pytest.fixture(scope="session")
def wrong_orders(order):
    """``wrong_orders(method, steps, errors)``: those of ``{name: errors}`` whose slope is not the method's, with it."""

    def find(method, steps, errors):
        low, high = SLOPES[(ORDERS | LATER)[method]]
        slopes = {name: order(steps, values) for name, values in errors.items()}
        return {name: round(slope, 3) for name, slope in slopes.items() if not low <= slope <= high}

    return find
