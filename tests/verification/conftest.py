"""Fixtures of the verification tests: methods, reference data, shipped models."""

import json
from pathlib import Path

import pytest

from mbdsl.integrators import compiled, declared

TESTS = Path(__file__).parents[1]
MODELS = TESTS.parent / "models"

#: the methods of the paper, with which most of these tests compare
PAPER = [name for name, method in compiled().items() if method.source.startswith("Negrut, Jay, Khude")]


@pytest.fixture(params=PAPER, scope="session")
def method(request):
    """Each method of the paper in turn."""
    return request.param


@pytest.fixture(params=[name for name in PAPER if declared(name).order == 2], scope="session")
def second_order(request):
    """Each method of second order."""
    return request.param


@pytest.fixture(params=compiled(), scope="session")
def any_method(request):
    """Each compiled method in turn, with fixed steps."""
    return request.param


@pytest.fixture(params=[name for name in compiled() if declared(name).order <= 8], scope="session")
def any_order(request):
    """Each compiled method whose order is measured with the steps of these tests. With these steps, errors of order 9
    and 13 are those of rounding: test_double_pendulum.py and test_run.py measure these orders with longer ones."""
    return request.param


@pytest.fixture(scope="session")
def reference():
    """``reference(name)``: the data of ``tests/data/reference/name.json``."""
    return lambda name: json.loads((TESTS / "data" / "reference" / f"{name}.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def model():
    """``model(name)``: the path of a shipped model."""
    return lambda name: MODELS / f"{name}.mbd"
