"""The motion of every shipped model is the same, to the last bit, in all units of length, mass and time of its numbers.

With factors that are powers of two, the arithmetic is the same except for exponents: a difference reveals a constant
that should have a unit and has none. Text is read in units whose base is not the metre, the kilogram and the second.
"""

import json
import re
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.elements import modules
from mbdsl.elements.declaration import ANY
from mbdsl.lang import parser, units

MODELS = Path(__file__).parents[2] / "models"
SPACE = ["space/flyball_governor", "space/heavy_top", "space/rolling_coin"]
#: model -> (stop, step, parameters): the first hundred steps of the table of runs
RUNS = json.loads((Path(__file__).parents[1] / "data" / "runs.json").read_text(encoding="utf-8"))
RUNS = {name: (100 * step, step, given) for name, (_, step, given) in RUNS.items() if "/" not in name or name in SPACE}
#: factors on the numbers: mechanisms of micrometres, micrograms and milliseconds, and the reverse; even powers, so that
#: the square root of a mass is scaled exactly, too
SCALES = {"small": (2.0**-20, 2.0**-16, 2.0**-10), "large": (2.0**14, 2.0**8, 2.0**6), "slow": (1.0, 1.0, 2.0**10)}
COUNTS = ("steps", "rejected", "iterations", "evaluations", "matrix_evaluations", "events")


def factor(unit: str, scales: tuple[float, float, float]) -> float:
    """The factor on a number in ``unit``."""
    if unit in ("", "1", ANY):
        return 1.0
    of = dict(zip(units.BASE, units.dimension(unit), strict=True))
    length, mass, time = scales
    return length ** of["m"] * mass ** of["kg"] * time ** of["s"]


@contextmanager
def written_in(scales):
    """Within this context, texts are read, and defaults taken, in the units of ``scales``."""
    with pytest.MonkeyPatch.context() as patch:
        for table in (units._PREFIXED, units._PLAIN):
            for name, (value, dimension) in list(table.items()):
                unit = ".".join(f"{base}^({e})" for base, e in zip(units.BASE, dimension, strict=True) if e)
                patch.setitem(table, name, (value * factor(unit, scales), dimension))
        for module in (*modules().values(), *modules(True).values()):
            parameters = tuple(
                replace(p, default=p.default * factor(p.unit, scales)) if isinstance(p.default, float) else p
                for p in module.KIND.parameters
            )
            patch.setattr(module, "KIND", replace(module.KIND, parameters=parameters))
        _forget()
        yield
    _forget()


def _forget():
    units.symbol.cache_clear()
    units.parse.cache_clear()
    parser._parsed.cache_clear()  # syntax trees with numbers in other units


def text_with_units(name: str) -> str:
    """The model with units on all of its numbers: bare numbers would be taken as SI."""
    text = (MODELS / f"{name}.mbd").read_text(encoding="utf-8")
    text = re.sub(r'(\(unit = "([^"]+)"\) = [0-9.e+-]+)(?=[ ;])', r"\1 \2", text)
    return re.sub(r"\bg = ([1-9][0-9.]*)\)", r"g = \1 m/s2)", text)


def signals(trajectory) -> dict[str, np.ndarray]:
    """The quantities to compare: all coordinates of frames and signals of joints and forces; {name: (N,)}."""
    keys = ("x", "y", "phi", "vx", "vy", "w", "s", "v", "fx", "fy", "tau", "force", "torque", "friction")
    keys += ("z", "vz", "wx", "wy", "wz", "p0", "p1", "p2", "p3", "fz", "tx", "ty", "tz")
    return {name: trajectory[name] for name in trajectory.names if name.rsplit(".", 1)[-1] in keys}


CASES = [(name, how) for name in RUNS for how in ("hht-si2", "nstiff", "radau5", "hht-si2 --tol")]
CASES = [case for case in CASES if case[0] not in SPACE]
CASES += [(name, how) for name in SPACE[1:] for how in ("hht-si2", "nstiff", "dop853", "hht-si2 --tol")]
CASES += [(SPACE[0], "hht-si2")]
#: Newton's method asks for one more correction where the sum of all residuals grows tenfold, forces and lengths alike
MIXED = [(name, "nstiff") for name in ("crank_ivp", "flexible_slider_crank")]


@pytest.mark.parametrize(("name", "how"), [case for case in CASES if case not in MIXED])
def test_bit_for_bit(name, how, tmp_path):
    stop, step, parameters = RUNS[name]
    model = tmp_path / f"{Path(name).name}.mbd"
    model.write_text(text_with_units(name), encoding="utf-8")

    def run(time):
        method, *controlled = how.split()
        given = {"tol": 1e-4, "step": None} if controlled else {"step": step * time}
        given |= {"stop": stop * time, "interval": stop / 10 * time, "parameters": parameters}
        return mbdsl.simulate(model, method=method, **given)

    before = run(1.0)
    of = signals(before)
    for which, scales in SCALES.items():
        with written_in(scales):
            after = run(scales[2])
        found = signals(after)
        assert found.keys() == of.keys()
        wrong = [k for k in of if not np.array_equal(found[k], of[k] * factor(before.unit(k), scales))]
        assert not wrong, which
        assert [after.stats[k] for k in (*COUNTS, "error")] == [before.stats[k] for k in (*COUNTS, "error")], which
