"""Newton's corrections in space are exact, however far bodies turn in a step: a comparison with differences."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mbdsl.integrators import compiled as methods
from mbdsl.integrators import modules

SCRIPT = Path(__file__).with_name("uncompiled_in_space.py")
NAMES = [name for name in methods() if not hasattr(modules()[name], "take")]
MODELS = ("sprung", "driven", "rotors")
FULL = [name for name in NAMES if modules()[name].METHOD.coupled]


@pytest.fixture(scope="module")
def found():
    environment = {**os.environ, "MBDSL_NO_COMPILE": "1", "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    done = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_all_methods_that_hold_both_levels_have_a_full_system():
    assert [name for name in NAMES if "dPhi" in modules()[name].METHOD.enforces] == FULL


@pytest.mark.parametrize("name", NAMES)
def test_corrections_are_newtons(found, name):
    """The part of an error that one correction leaves is that of rounding, over differences of five points."""
    assert [key for key in found if key.endswith(f" {name}")] == [f"{model} {name}" for model in MODELS]
    for model in MODELS:
        (near, small, _), (far, large, _) = steps = found[f"{model} {name}"]
        assert 0.1 < small < 0.3 and large > 1.0
        assert near < 1e-9 and far < 1e-7
        assert {full for _, _, full in steps} == {int(name in FULL)}
