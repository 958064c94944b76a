"""What the verification tests share: reference data, shipped models, observed orders."""

import json
from pathlib import Path

import numpy as np
import pytest

TESTS = Path(__file__).parents[1]
MODELS = TESTS.parent / "models"


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
