"""The same source without a compiler gives the same results; Newton's corrections are compared with differences of
residuals."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mbdsl.integrators import compiled as methods
from mbdsl.integrators import modules

SCRIPT = Path(__file__).with_name("uncompiled.py")
#: methods whose correction is Newton's with the exact matrix (the matrices of the others may neglect terms of order h)
NAMES = [name for name in methods() if not hasattr(modules()[name], "take")]  # see uncompiled.py
EXACT = {name for name, method in methods().items() if method.index == 3}


@pytest.fixture(scope="module")
def uncompiled():
    environment = {**os.environ, "MBDSL_NO_COMPILE": "1", "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    done = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_compiled_and_uncompiled_results_are_the_same(uncompiled):
    """Compilers may contract and reorder operations; twenty steps with values of size 1 keep twelve digits, and
    multipliers of size 100 (found from differences over h^2) eight."""
    spec = importlib.util.spec_from_file_location("uncompiled", SCRIPT)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    compiled = script.runs()
    assert set(compiled) == set(uncompiled["runs"])
    assert len(compiled) == 2 * len(methods())
    for name, (t, q, v, lam) in compiled.items():
        other = [np.array(x) for x in uncompiled["runs"][name]]
        assert other[0].tolist() == t
        assert np.ptp(np.array(q), axis=0).max() > 1e-3  # it moves
        assert other[1] == pytest.approx(np.array(q), abs=1e-12), name
        assert other[2] == pytest.approx(np.array(v), abs=1e-10), name
        assert other[3] == pytest.approx(np.array(lam), abs=1e-7), name


def test_corrections_are_newtons(uncompiled):
    """The part of an error that one correction leaves: with the exact matrix only rounding (5e-16 of residuals of size
    1e5, over differences of 1e-5 in q); with a splitting, terms of order h."""
    assert set(uncompiled["contraction"]) == {f"{m.stem} {name}" for m in COMPARED for name in NAMES}
    for key, steps in uncompiled["contraction"].items():
        (_, coarse), (largest, fine) = steps[0], steps[-1]
        if key.split()[1] in EXACT:
            assert largest < 1e-8, key
        else:
            assert fine < 0.1, key
            if key.startswith("crank_ivp"):  # h^2 K is large at any step, and the neglected terms are a part of it
                assert fine < 3e-3, key
                continue
            if key.startswith("stick_slip"):  # the dependence of friction on the projection's multipliers is neglected
                assert fine < 0.01, key
                continue
            assert fine < max(0.4 * coarse, 1e-6), key  # eigenvalues of a nilpotent matrix: the root of rounding


def test_corrections_at_rest_without_dampers_are_exact(uncompiled):
    """Then no term of order h is neglected, and the test covers every block of a split matrix. Some entries of beams
    are 1e3 times larger than others, which does not matter for rounding; the term M of psi_I at the start of the step
    in hht-add changes with M(q), which is of order h^2 and neglected."""
    assert len(uncompiled["at rest"]) >= 4 * len(NAMES)
    for key, steps in uncompiled["at rest"].items():
        (coarse, _), (left, radius) = steps[0], steps[-1]
        flexible = key.split()[0] in FLEXIBLE
        if flexible and key.endswith("hht-add") and not key.startswith("flexible_pendulum"):
            assert left < 0.1 * coarse < 1e-3, key
        else:
            assert left < (1e-6 if flexible else 1e-8) and radius < 1e-8, key


FLEXIBLE = ("crank_ivp", "flexible_pendulum", "flexible_slider_crank", "spin_up_beam")
MODELS = sorted((Path(__file__).parents[3] / "models").glob("*.mbd"))
#: all elements of the others are in smaller models: those of four_bar in chain, those of seven_body in slider_crank
COMPARED = [m for m in MODELS if m.stem not in ("four_bar", "seven_body")]


def test_the_comparison_sees_a_wrong_matrix():
    """Kernels may be compiled in this process; therefore a process of its own modifies K, or M if a pendulum has no
    K."""
    code = f"""
import runpy, sys
sys.argv = ["uncompiled.py"]
names = runpy.run_path({str(SCRIPT)!r}, run_name="script")
from mbdsl.integrators import modules
for name, module in modules().items():
    if not module.METHOD.chosen or hasattr(module, 'take'):
        continue
    def wrong(t, h, run, right=module.matrix):
        def off(t, cM, cK, *more, m=1.01 if name == "hht-add" else 1.0):
            return run.tangent_at(t, m * cM, 1.01 * cK, *more)
        return right(t, h, run._replace(tangent_at=off))
    module.matrix = wrong
    path = next(m for m in names["MODELS"] if m.stem == "pendulum")
    print(names["contraction"](path, name, 1e-2, True)[0])
"""
    environment = {**os.environ, "MBDSL_NO_COMPILE": "1", "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    found = [float(x) for x in done.stdout.split()]
    assert len(found) == len(NAMES)
    assert min(found) > 1e-8
