"""A Scene is a value: it is immutable, equal by content, and holds no object of the parser."""

import copy
import pickle
import pickletools
from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import pytest

import mbdsl
from mbdsl.lang.load import parse_text
from mbdsl.mechanism.frozen_dict import FrozenDict
from mbdsl.system import build

MODELS = Path(__file__).parents[3] / "models"
SHIPPED = sorted(MODELS.rglob("*.mbd"))
TEXT = """model T "{doc}"
  Ground g; Rod rod(m = 1 kg, length = 1 m); Rod bar(m = {m}, length = 1 m);
  Revolute pin(g, rod.a); Revolute hinge(rod.b, bar.a);
  Table u(table = [0 s, 0 N.m; 1 s, {y} N.m]);
  Torque tau(g, rod.a, tau = u(time) - {c}*rod.w);
  annotation(experiment(StopTime = {stop} s));
end T;"""
GIVEN = {"doc": "a", "m": "1 kg", "y": "1.25", "c": "0.5 N.m.s", "stop": "1"}


def scene(**changes):
    return parse_text(TEXT.format(**{**GIVEN, **changes}), **({"file": "other.mbd"} if "doc" in changes else {}))


@pytest.fixture(scope="module")
def shipped():
    """Every shipped model, read twice."""
    return [tuple(mbdsl.load(path, allow_imports=MODELS) for _ in range(2)) for path in SHIPPED]


def test_scenes_are_equal_where_their_content_is(shipped):
    for one, other in shipped:
        assert one is not other and one == other and hash(one) == hash(other)
        assert one.fingerprint == other.fingerprint
    assert len({one for one, _ in shipped}) == len({one.fingerprint for one, _ in shipped}) == len(SHIPPED)
    assert scene(doc="b") == scene()  # neither documentation nor the file counts
    assert scene() != "T"


@pytest.mark.parametrize("change", [{"y": "1.26"}, {"c": "0.51 N.m.s"}, {"m": "1.0000000000000002 kg"}, {"stop": "2"}])
def test_a_changed_digit_makes_them_unequal(change):
    assert scene(**change) != scene()
    # a run is given its stop time: it does not belong to the key of its results
    assert (scene(**change).fingerprint == scene().fingerprint) == (change == {"stop": "2"})


def test_the_order_of_components_counts():
    """Coordinates are in this order."""
    found = scene()
    turned = dict(reversed(found.components.items()))
    assert replace(found, components=turned) != found == replace(found, components=dict(found.components))


def test_parts_of_scenes_are_equal_where_their_content_is():
    one, other = scene(), scene(doc="b")
    for kind in ("components", "frames"):
        for name, part in getattr(one, kind).items():
            assert part == getattr(other, kind)[name] and hash(part) == hash(getattr(other, kind)[name])
            assert part.span != getattr(other, kind)[name].span or name.startswith("g")
    assert scene(m="2 kg").components["bar"] != one.components["bar"]
    assert scene(m="2 kg").components["rod"] == one.components["rod"]


def mappings(found):
    yield from (x for x in vars(found).values() if isinstance(x, dict))
    yield from (x for c in found.components.values() for x in (c.values, c.ports))


def test_nothing_in_a_scene_can_be_changed():
    found = mbdsl.load(MODELS / "slider_crank.mbd")
    before, text = found.fingerprint, repr(sorted(map(repr, mappings(found))))
    changes = (
        lambda d: d.__setitem__("x", 1),
        lambda d: d.__delitem__(next(iter(d), "x")),
        lambda d: d.update(x=1),
        lambda d: d.__ior__({"x": 1}),
        lambda d: d.setdefault("x", 1),
        lambda d: d.pop("x", None),
        lambda d: d.popitem(),
        lambda d: d.clear(),
    )
    count = 0
    for mapping in mappings(found):
        for change in changes:
            with pytest.raises(TypeError, match="replace"):
                change(mapping)
            count += 1
    assert count > 100 and repr(sorted(map(repr, mappings(found)))) == text
    for part in (found, found.components["crank"], found.frames["crank.a"], found.initial[0], found.experiment):
        with pytest.raises(FrozenInstanceError):
            part.name = "other"
    assert replace(found, components=found.components).fingerprint == before
    assert isinstance(found.components["O"].values | {"x": 1}, dict)  # a new one


def test_what_is_given_as_a_dict_is_copied():
    found = scene()
    components = dict(found.components)
    other = replace(found, components=components)
    components.clear()
    assert other == found and isinstance(other.components, FrozenDict)


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_copies(again):
    found = scene()
    found.signals()
    other = again(found)
    assert other == found and other.components == found.components and other.signals() == found.signals()
    with pytest.raises(TypeError):
        other.components["rod"].values["m"] = 2.0


ALLOWED = {"mechanism", "elements", "expressions", "errors", "lang", "messages"}  #: rooms in a pickle


def test_pickles_hold_nothing_of_the_parser(shipped):
    """Nor do they hold results computed from the scene. They hold its origin: texts, or the model of a Builder."""
    made = mbdsl.Builder("M")
    made.Revolute("pin", made.Ground("g"), made.Rod("rod", m=1.0, length=1.0).a)
    for found in (made.scene(), *(one for one, _ in shipped)):
        text = pickle.dumps(found)
        words = {str(argument) for _, argument, _ in pickletools.genops(text) if argument is not None}
        rooms = {word.split(".")[1] for word in words if word.startswith("mbdsl.")}
        assert "mechanism" in rooms and rooms <= {
            "mechanism",
            "elements",
            "expressions",
            "errors",
            "lang",
            "messages",
        }
        parts = {word for word in words if word.startswith("mbdsl.lang.")}
        built = {"mbdsl.lang.builder.draft", "mbdsl.lang.calls"}
        built |= {"mbdsl.lang.syntax", "mbdsl.lang.source", "mbdsl.lang.units"}
        assert parts <= (built if found.name == "M" else {"mbdsl.lang.load"})
        found.signals(), found.fingerprint, hash(found)
        assert pickle.dumps(found) == text


def test_they_say_what_they_are():
    found = mbdsl.load(MODELS / "slider_crank.mbd")
    assert repr(found) == str(found) == "<Scene SliderCrank: 2 bodies, 3 joints, 1 force>"
    assert repr(found.components["A"]) == "<Revolute A(frame_a = crank.b, frame_b = rod.a)>"
    assert repr(found.components["crank"]) == "<Rod crank>"


@pytest.mark.parametrize("formulation", ["floating", "ancf"])
def test_bodies_that_deform_are_known_without_their_equations(formulation):
    found = parse_text(f"""model M
      Ground g; Rod rod(m = 1 kg, length = 1 m);
      FlexibleBeam beam(length = 1 m, density = 7800 kg/m3, E = 200 GPa, S = 1 cm2, I = 1e-9 m4,
                        formulation = "{formulation}");
      Revolute pin(g, beam.a); Revolute hinge(beam.b, rod.a);
    end M;""")
    assert [c.name for c in found.components.values() if c.deforms] == list(build(found).tables.flexible) == ["beam"]
