"""The Builder makes the Scene that the text makes, with the same checks."""

import doctest
from dataclasses import replace
from pathlib import Path

import pytest

import mbdsl
import mbdsl.lang.builder.builder
from mbdsl import Builder
from mbdsl.expressions import symbolic as ex

MODELS = Path(__file__).parents[3] / "models"


def slider_crank():
    b = Builder("SliderCrank", "Slider crank with a spring and damper at its end")
    m1 = b.parameter("m1", "3 kg", "mass of the crank", type="Mass")
    b.parameter("L1", "0.3 m", type="Length")
    ground = b.Ground("ground")
    wall = b.frame("wall", ground, r=(1.2, 0))
    crank = b.Rod("crank", m=m1, length="L1")
    rod = b.Rod("rod", m=0.9, length="60 cm")
    b.Revolute("O", ground, crank.a)
    b.Revolute("A", crank.b, rod.a)
    b.PointOnLine("B", ground, "rod.b")
    b.SpringDamper("spring", wall, rod.b, k="100 N/m", c=5, s0=0.3)
    b.initial(crank.phi, "0 deg")
    b.initial("crank.w", 0)
    b.initial(rod.phi, 0, fixed=False)
    b.experiment(stop="2 s")
    return b


def test_same_scene_as_the_text():
    built, read = slider_crank().scene(), mbdsl.load(MODELS / "slider_crank.mbd")
    assert replace(built, parameters=read.parameters) == read
    assert built.parameters["m1"].value == 3.0
    assert built.signals() == read.signals()


def test_handles():
    b = slider_crank()
    rod = b.Rod("bar", m=1, length=1, frames={"tip": (0.1, 0)})
    assert str(rod) == "bar" and str(rod.b) == "bar.b" and str(rod.tip.x) == "bar.tip.x" and str(rod.phi) == "bar.phi"
    assert {"a", "b", "c", "tip", "phi"} <= set(dir(rod)) and "Rod" in dir(b)
    assert "bar" in repr(rod)
    wall = b.frame("post", rod.b)
    assert str(wall.x) == "post.x" and "vx" in dir(wall) and dir(b.parameter("M", 1)) == []
    with pytest.raises(AttributeError, match="did you mean"):
        _ = rod.tipp
    with pytest.raises(AttributeError, match="did you mean `Revolute`"):
        _ = b.Revolut


def test_laws_arrays_tables_variables():
    b = Builder("M")
    g = b.World("g")
    links = [b.Rod(f"link[{i}]", m=i, length=1.0) for i in (1, 2)]
    j = b.Revolute("J", g, links[0].a)
    b.Revolute("K", "link[1].b", links[1].a)
    b.table("p", [(0, 0), (1, 2)], smoothness="cubic")
    b.table("q", "[0 s, 0 N.m; 1 s, 2 N.m]")
    b.variable("M0", "p(time)*1 N.m")
    b.Torque("t1", j, tau="2 N.m*sin(3*time) - 0.1*link[2].w")
    b.Torque("t2", j, tau=ex.TIME * 2.0)
    b.Torque("t3", j, tau="M0 + q(time)")
    b.RotationalSpringDamper("s", torque="3*phi", doc="a spring")
    b.connect("s.frame_a", g)
    b.connect("s.frame_b", links[0].b)
    b.Body("c", m=1, I=1, com=(0.1, 0.2), phi={"start": "90 deg", "fixed": True})
    scene = b.scene()
    assert scene.components["t2"].values["tau"] is ex.TIME * 2.0
    assert scene.components["link[2]"].values["m"] == 2.0
    assert scene.components["s"].doc == "a spring"
    assert scene.components["s"].ports == {"frame_a": "g.c", "frame_b": "link[1].b"}
    assert "M0" in scene.variables
    assert [(i.name, i.fixed) for i in scene.initial] == [("c.phi", True)]
    assert {n.value[0].name for n in ex.walk(scene.components["t3"].values["tau"]) if n.op == "table"} == {"p", "q"}


def test_numpy_values():
    np = pytest.importorskip("numpy")
    b = Builder("M")
    b.Ground("g")
    b.Body("c", m=np.float64(2.0), I=np.int64(1), com=np.array([0.1, 0.2]))
    assert b.scene().components["c"].values["com"] == (0.1, 0.2)


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (lambda b: b.Rod("r", m="1 m", length=1), "found a length [m], expected a mass [kg]"),
        (lambda b: b.Rod("r", mm=1), "no parameter `mm`"),
        (lambda b: b.Rod("r", m=1), "needs `length`"),
        (lambda b: b.Rod("rod", m=1, length=1), "declared twice"),
        (lambda b: b.Rod("r[1", m=1, length=1), "is not a name"),
        (lambda b: b.add("Rodd", "r"), "did you mean `Rod`"),
        (lambda b: b.Rod("r", m=object(), length=1), "expected a number"),
        (lambda b: b.Revolute("J", 3, "rod.a"), "expected a frame"),
        (lambda b: b.Revolute("J", "ground", "rod"), "expected one of its frames"),
        (lambda b: b.Revolute("J", "ground", "rodd.a"), "unknown name `rodd`"),
        (lambda b: b.Revolute("J", "ground"), "is not connected"),
        (lambda b: b.Torque("t", "O", tau="2 N*time"), "expected a torque"),
        (lambda b: b.Torque("t", "O", tau="2 +"), "<t.tau>:1:4"),
        (lambda b: b.initial("rod.phi", "2 m"), "found a length [m]"),
        (lambda b: b.experiment(stop="2 m"), "expected a time [s]"),
        (lambda b: b.experiment(step=-1), "must be positive"),
    ],
)
def test_same_messages(action, message):
    b = slider_crank()

    def build():
        action(b)
        b.scene()

    with pytest.raises(mbdsl.MbdslError) as caught:
        build()
    assert message in str(caught.value)


def test_a_failed_component_leaves_its_name_free():
    b = slider_crank()
    with pytest.raises(mbdsl.ModelError):
        b.Rod("r", mm=1)
    b.Rod("r", m=1, length=1)
    assert "r" in b.scene().components


def test_scene_can_be_asked_for_again():
    b = slider_crank()
    first = b.scene()
    b.Force("f", "rod.b", fx=1)
    assert "f" not in first.components and "f" in b.scene().components


def test_doc_examples():
    assert doctest.testmod(mbdsl.lang.builder.builder).failed == 0


def test_public_names():
    assert mbdsl.parse("model M Ground g; end M;").name == "M"
    assert set(mbdsl.__all__) <= set(dir(mbdsl))
    with pytest.raises(AttributeError):
        _ = mbdsl.nothing
