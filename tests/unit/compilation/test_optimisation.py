"""Tests run code that is compiled with little optimisation; code with full optimisation has the same bits."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from mbdsl.compilation import code_cache, object_code

MODELS = Path(__file__).parents[3] / "models"
#: a loop with a spring, a beam and friction, of each family of methods
RUNS = [("slider_crank", "hht-si2"), ("flexible_slider_crank", "radau5"), ("stick_slip_belt", "dop853")]
SCRIPT = """
import hashlib, sys, mbdsl
for path, method in zip(sys.argv[1::2], sys.argv[2::2]):
    found = mbdsl.simulate(path, method=method, step=2e-4, stop=0.02, interval=1e-3)
    print(method, *(hashlib.sha256(x.tobytes()).hexdigest() for x in (found.q, found.v, found.lam)))
"""


def bits(level):
    given = [x for name, method in RUNS for x in (str(MODELS / f"{name}.mbd"), method)]
    environment = {**os.environ, "MBDSL_OPTIMISATION": level}
    run = [sys.executable, "-c", SCRIPT, *given]
    return subprocess.run(run, env=environment, capture_output=True, text=True, check=True).stdout


def test_results_have_the_same_bits():
    quick = bits("0")
    assert len(quick.splitlines()) == len(RUNS)
    assert bits("3") == quick


@pytest.mark.parametrize(("setting", "level"), [(None, 3), ("0", 0), ("3", 3)])
def test_the_level_is_part_of_the_name_of_the_cache(setting, level, monkeypatch):
    """Code of one level is never run where another one is asked for."""
    if setting is None:
        monkeypatch.delenv("MBDSL_OPTIMISATION", raising=False)
    else:
        monkeypatch.setenv("MBDSL_OPTIMISATION", setting)
    assert object_code.optimisation() == level
    found = code_cache.version()
    monkeypatch.setenv("MBDSL_OPTIMISATION", "0" if level else "3")
    assert code_cache.version() != found
