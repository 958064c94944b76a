"""Scenes that differ in any number have different keys; scenes of equal content have the same one."""

import os
import subprocess
import sys
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import Builder
from mbdsl.elements.kind import Kind
from mbdsl.expressions.symbolic import Expr, walk
from mbdsl.lang.load import parse_text
from mbdsl.mechanism.scene import Component, Experiment

ROOT = Path(__file__).parents[3]
MODELS = sorted((ROOT / "models").glob("*.mbd"))
#: properties that do not affect a run, or that a run replaces; "unit" is the unit of an initial value in messages
APART = {"span", "doc", "files", "parameters", "unit", "warnings"}
TIMES = {"start", "stop", "interval"}

TEXT = """model T
  Ground g; Rod rod(m = 1 kg, length = 1 m); Revolute pin(g, rod.a);
  Table u(table = [0 s, 0 N.m; 1 s, {y} N.m; {u} s, 2 N.m], smoothness = "{smoothness}", extrapolation = "{beyond}");
  input Real F(start = {start}, unit = "N.m");
  Torque tau(g, rod.a, tau = u(time) + F + {law});
initial equation
  rod.phi = {phi} deg;
  annotation(experiment(StopTime = {stop} s));
end T;"""
SAID = {"y": "1", "u": "2", "smoothness": "linear", "beyond": "hold", "start": "0", "phi": "0", "law": "0 N.m"}


def key_of(**changes):
    return parse_text(TEXT.format(**{**SAID, "stop": "1", **changes})).fingerprint


def law(**factors):
    return " + ".join(f"{factors.get(f'c{k}', 1)}*sin({k + 1}.0*time/1 s)*1 N.m" for k in range(40))


def test_texts_that_differ_in_one_number():
    changes = [{}, {"y": "999"}, {"u": "3"}, {"smoothness": "cubic"}, {"beyond": "linear"}, {"start": "1"}]
    changes += [{"phi": "1"}, *({"law": law(**c)} for c in ({}, {"c39": 500}, {"c30": 70}))]
    assert len({key_of(**c) for c in changes}) == len(changes)
    assert key_of(stop="2") == key_of()  # a run is given its times


def variants(x):
    """Copies of ``x``, each with one of its numbers changed in the last digit."""
    if isinstance(x, Expr):
        nodes = walk(x)
        for n in nodes:
            for value in variants(n.value):
                new = {}
                for k in nodes:
                    new[k] = Expr(k.op, tuple(new[a] for a in k.args), value if k is n else k.value)
                yield new[x]
    elif isinstance(x, float) or (isinstance(x, int) and not isinstance(x, bool)):
        yield float(np.nextafter(x, np.inf)) if isinstance(x, float) else x + 1
    elif isinstance(x, tuple):
        for k, part in enumerate(x):
            yield from ((*x[:k], other, *x[k + 1 :]) for other in variants(part))
    elif isinstance(x, dict):
        for key, part in x.items():
            yield from ({**x, key: other} for other in variants(part))
    elif is_dataclass(x) and not isinstance(x, Kind):
        formulas = {"signals"} if isinstance(x, Component) else TIMES if isinstance(x, Experiment) else set()
        for f in fields(x):
            if f.name not in APART | formulas:
                yield from (replace(x, **{f.name: other}) for other in variants(getattr(x, f.name)))


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_every_number_of_a_shipped_model_is_in_its_key(path):
    scene = mbdsl.load(path)
    texts = [scene.fingerprint, *(other.fingerprint for other in variants(scene))]
    assert len(set(texts)) == len(texts) > 10


def test_builder_and_text():
    b = Builder("T")
    g = b.Ground("g")
    rod = b.Rod("rod", m=1, length=np.float64(1.0))
    b.Revolute("pin", g, rod.a)
    b.table("u", [(0, 0), (1, 1), ("2", "2")])
    b.input("F", unit="N.m")
    b.Torque("tau", g, rod.a, tau="u(time/1 s)*1 N.m + F")
    b.initial(rod.phi, 0)
    b.experiment(stop=3)
    text = TEXT.format(**SAID, stop="1").replace("+ 0 N.m", "").replace("u(time)", "u(time/1 s)*1 N.m")
    read = parse_text(text.replace(" s,", ",").replace(" N.m;", ";").replace(" N.m]", "]"))
    assert b.scene().fingerprint == read.fingerprint


def test_other_processes_come_to_the_same():
    code = f"""
from mbdsl import load
print("\\n".join(load(path).fingerprint for path in {[str(p) for p in MODELS]!r}), end="")
"""
    own = "\n".join(mbdsl.load(path).fingerprint for path in MODELS)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "12345"}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert run.stdout == own


def test_what_is_not_known_is_no_content():
    scene = mbdsl.load(MODELS[0])
    c = next(iter(scene.components.values()))
    odd = {**scene.components, c.name: replace(c, values={**c.values, "new": object()})}
    with pytest.raises(TypeError, match="content of object"):
        _ = replace(scene, components=odd).fingerprint
