"""The placement of bodies depends on the declarations of kinds, not on names."""

import sys
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

from mbdsl import elements
from mbdsl.elements.kind import Placing
from mbdsl.initial.placement import place
from mbdsl.lang.load import parse_text
from mbdsl.mechanism import graph
from mbdsl.system import build

#: kind -> its new name, and new names of its signals and parameters
OTHERS = {
    "Revolute": ("Hinge", {"phi": "theta"}),
    "RotationalDriver": ("Turner", {"phi": "theta"}),
    "Prismatic": ("Slider", {"s": "path", "phi0": "tilt"}),
    "Distance": ("Strut", {"s": "gap", "length": "span"}),
    "Fixed": ("Weld", {"phi0": "tilt"}),
    "Rod": ("Bar", {"length": "span"}),
}
MODEL = """model Placed Ground g;
  Rod a(m = 1, length = 0.4); Revolute p(g, a.a); RotationalDriver drive(p, phi = 0.7 + 1 rad/s*time);
  Rod b(m = 1, length = 0.5); Revolute q(a.b, b.a);
  Rod c(m = 1, length = 0.3); Prismatic s(b.b, c.a, phi0 = 0.2);
  Rod d(m = 1, length = 0.6); Fixed w(c.b, d.a, phi0 = -0.3);
  PointMass m(m = 1); Distance l(d.b, m, length = 0.9);
initial equation
  q.phi = 0.5; s.s = 0.25;
end Placed;"""


def placed(text):
    scene = parse_text(text)
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    return place(system, mechanism, 0.1, list(scene.initial)), system.tables.size


@pytest.fixture
def renamed(monkeypatch):
    """The model with kinds whose names, and whose parameters and signals, are all renamed."""
    text = MODEL
    for kind, (name, changes) in OTHERS.items():
        source = elements.modules()[kind]

        def new(x, changes=changes):
            return changes.get(x, x)

        def under(values, changes=changes):
            return {old: values[key] for old, key in changes.items() if key in values} | dict(values)

        def signal(x, changes=changes):
            formula = x.formula
            for old, key in changes.items():
                formula = formula.replace(f"der({old})", f"der({key})")
            return replace(x, name=new(x.name, changes), formula=formula)

        given = source.KIND
        found = {
            "name": name,
            "parameters": tuple(replace(p, name=new(p.name)) for p in given.parameters),
            "signals": tuple(map(signal, given.signals)),
            "size": new(given.size),
        }
        if hasattr(given, "frames"):
            found["frames"] = lambda v, given=given, under=under: given.frames(under(v))
            found["derive"] = lambda v, given=given, under=under: given.derive(under(v))
            found["table"] = lambda v, given=given, under=under: given.table(under(v))
        else:
            placing = {key: tuple(map(new, getattr(given.placing, key))) for key in ("angle", "along")}
            found["placing"] = replace(given.placing, free=new(given.placing.free), **placing)
            for old, key in changes.items():
                rows = found.get("g", given.g)
                found["g"] = tuple(row._replace(plane=row.plane.replace(f"- {old}", f"- {key}")) for row in rows)
            found |= {"driver": new(given.driver), "reactions": (), "friction": ""}
        module = ModuleType(f"mbdsl.elements.{name.lower()}")
        names = {k: v for k, v in vars(source.file).items() if k[:2] != "__"}
        vars(module).update(names, KIND=replace(given, **found))
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setitem(elements.modules(), name, elements.Declared(module.KIND, module))
        text = text.replace(f"{kind} ", f"{name} ")
    for old, key in (("phi0 =", "tilt ="), ("length =", "span ="), (".phi =", ".theta ="), (".s =", ".path =")):
        text = text.replace(old, key)
    return text.replace("phi = 0.7", "theta = 0.7")


def test_kinds_with_other_names_are_placed_the_same(renamed):
    assert not any(name in renamed for name in ("phi", "length", "Revolute", "Rod"))
    expected, size = placed(MODEL)
    found, other = placed(renamed)
    assert np.array_equal(found, expected)
    assert other == size > 0.0


def test_the_model_shows_it():
    """By hand: rods one behind the other, each turned by the value of its joint."""
    q, _ = placed(MODEL)
    angles = np.cumsum([0.7 + 0.1, 0.5, 0.2, -0.3])
    assert q[2:12:3] == pytest.approx(angles)
    x, y = np.zeros(5), np.zeros(5)
    lengths, shift = (0.4, 0.5, 0.3, 0.6), (0.0, 0.0, 0.25, 0.0)  # the slider is moved along the axis of rod b
    at = np.zeros(2)
    before = 0.0
    for k, (angle, length, s) in enumerate(zip(angles, lengths, shift, strict=True)):
        at = at + s * np.array([np.cos(before), np.sin(before)])
        x[k], y[k] = at + length / 2 * np.array([np.cos(angle), np.sin(angle)])
        at, before = at + length * np.array([np.cos(angle), np.sin(angle)]), angle
    x[4], y[4] = at + 0.9 * np.array([np.cos(before), np.sin(before)])
    assert q[[0, 3, 6, 9, 12]] == pytest.approx(x)
    assert q[[1, 4, 7, 10, 13]] == pytest.approx(y)


def test_parameters_are_declared():
    """The names that a kind declares for placement are its own signals and parameters."""
    for module in elements.modules().values():
        kind = module.KIND
        has = {x.name for x in (*kind.signals, *kind.parameters)}
        placing = getattr(kind, "placing", Placing())
        assert has >= {*placing.angle, *placing.along} | ({kind.size} - {""})
