"""Every method of the Builder refuses wrong names by its own call, and wrong values are found by `scene`."""

import re

import numpy as np
import pytest

from mbdsl import Builder, MbdslError, UsageError
from mbdsl.expressions import symbolic as ex


def model():
    b = Builder("M")
    b.parameter("L", "1 m", type="Length")
    g = b.Ground("g")
    rod = b.Rod("rod", m="2 kg", length="L")
    b.Rod("link[1]", m=1, length=1)
    b.Revolute("pin", g, rod.a)
    b.Torque("T", "pin", tau="1 N.m*sin(2*time)")
    b.initial(rod.phi, "30 deg")
    b.experiment(stop=1)
    return b


def rod(**given):
    return lambda b: b.Rod("r", **{"m": 1, "length": 1, **given})


def torque(tau):
    return lambda b: b.Torque("t", "pin", tau=tau)


BEAM = {"length": 1, "density": 1, "S": 1, "I": 1, "E": 1}
#: (call, a part of its message); wrong texts are in lang/test_wrong_models.py
#: names, kinds and forms: the call raises the error
AT_ONCE = [
    # kinds, names, descriptions
    (lambda b: b.add("Rodd", "r"), "no kind of component called `Rodd`\n  = did you mean `Rod`"),
    (lambda b: b.add(3, "r"), "kind: found 3"),
    (lambda b: b.Rod(m=1, length=1), "Rod needs a name"),
    (lambda b: b.Rod(3, m=1, length=1), "Rod: found 3, expected a name"),
    (lambda b: b.Rod("my rod", m=1, length=1), "Rod: 'my rod' is not a name"),
    (lambda b: b.Rod("end", m=1, length=1), "`end` is a word of the language"),
    (lambda b: b.Rod("time", m=1, length=1), "`time` is the name of the simulated time"),
    (lambda b: b.Rod("rod", m=1, length=1), "`rod` is declared twice"),
    (lambda b: b.Rod("link[1]", m=1, length=1), "`link[1]` is declared twice"),
    (lambda b: b.Rod("rod[1]", m=1, length=1), "`rod[1]` is already declared"),
    (lambda b: b.Rod("link[0]", m=1, length=1), "an index is 0"),
    (rod(doc=3), "r.doc: found 3"),
    (rod(replace="yes"), "replace: found 'yes', expected True or False"),
    # values
    (rod(lenght=1), "Rod `r` has no parameter `lenght`\n  = did you mean `length`?"),
    (rod(m="1 kq"), "<r.m>:1:3: unknown unit `kq`"),
    (rod(m=""), "<r.m>:1:1: the text ends"),
    (rod(m="mass"), "<r.m>:1:1: unknown name `mass`"),
    (rod(m=object()), "`r.m`: found <object"),
    (rod(m=b"1"), "`r.m`: found b'1'"),
    (rod(m={"a": 1}), "`m` of Rod `r` takes a value only"),
    (rod(frames=[1, 2]), "r.frames: found [1, 2], expected frames by their names"),
    (rod(frames={"x y": (1, 2)}), "r.frames: 'x y' is not a name"),
    (rod(phi=0.1), "r.phi is a signal, found 0.1"),
    (rod(phi={"begin": 1}), "a signal has no attribute `begin`"),
    # frames
    (lambda b: b.Revolute("p", 3, "rod.a"), "p.frame_a: found 3, expected a frame"),
    (lambda b: b.Revolute("p", "g", "rodd.a"), "<p.frame_b>:1:1: unknown name `rodd`"),
    (lambda b: b.Rod("r", 1.0, 1.0), "Rod `r` takes no frames, found 1.0"),
    (lambda b: b.connect("pin", 3), "connect.second: found 3"),
    # laws
    (torque("2 N.m*fi"), "<t.tau>:1:7: unknown name `fi`"),
    (torque("1 N.m*later.w"), "unknown name `later`"),
    (torque("2 +"), "<t.tau>:1:4: the text ends"),
    # other declarations
    (lambda b: b.parameter("m", "3 kg", type="Mas"), "`Mas` is not a type of a parameter\n  = did you mean `Mass`?"),
    (lambda b: b.parameter("m", None), "`m`: found None"),
    (lambda b: b.parameter("k[3]", [1, 2, 3]), "'k[3]': only components, frames and tables have indices"),
    (lambda b: b.parameter("L", 2), "`L` is declared twice"),
    (lambda b: b.table("t", [(0, 0), (1, 1)], smoothness=3), "t.smoothness: found 3"),
    (lambda b: b.shape("rod", 3), "the shape of rod: found 3"),
    (lambda b: b.shape("pin"), "`pin` is not a body"),
    (lambda b: b.initial("rod.phi", 0), "the initial value of `rod.phi` is fixed twice"),
    (lambda b: b.initial("rod.w", 0, fixed=3), "fixed: found 3"),
    (lambda b: b.initial("rod.w", None), "no initial value was given for `rod.w`"),
    (lambda b: b.experiment(method=3), "method: found 3"),
    (lambda b: b.experiment(without=["frction"]), "no effect `frction` to leave out"),
    # changes and new parameters
    (lambda b: b.remove("rodd"), "there is no `rodd` to remove\n  = did you mean `rod`?"),
    (lambda b: b.scene({"LL": 1}), "the model has no parameter `LL` to set\n  = did you mean `L`?"),
    (lambda b: b.scene({"L": object()}), "`--set L`: found <object"),
    (lambda b: b.scene({3: 1}), "`3` is not the name of a parameter"),
    (lambda b: b.scene(3), "parameters: found 3, expected a mapping"),
    (lambda b: b.scene().with_parameters(L=-3), "`length` of `rod` is -3"),
]
#: values: ``scene`` raises the error
IN_SCENE = [
    # values
    (rod(length=None), "Rod `r` needs `length`"),
    (rod(m="1 m"), "`m` of `r`: found a length [m], expected a mass [kg]"),
    (rod(m=float("nan")), "`m` of `r` is not a finite number"),
    (rod(m=10**400), "`m` of `r` is not a finite number"),
    (rod(m=True), "`m` of `r`: found a Boolean"),
    (rod(m=-1), "`m` of `r` is -1"),
    (rod(m=[1, 2]), "`m` of `r`: found an array of 2 values"),
    (rod(m=ex.TIME), "`m` of `r` must be known before the start"),
    (lambda b: b.Body("r", m=1, I=1, com=(1, 2, 3)), "`com` of `r`: found an array of 3 values"),
    (lambda b: b.Body("r", m=1, I=1, com=np.zeros((2, 2))), "`com` of `r`: found an array of 2 x 2 values"),
    (lambda b: b.Body("r", m=1, I=1, com=[[1, 2], [3]]), "<r.com>:1:1: the elements of an array have the same size"),
    (lambda b: b.FlexibleBeam("f", **BEAM, formulation="ancff"), '`formulation` of `f`: found "ancff"'),
    (rod(frames={"tip": 3}), "frame `tip` of `r`: found a number"),
    (rod(phi={"start": "1 m"}), "the initial value of `r.phi`: found a length [m]"),
    # frames
    (lambda b: b.Revolute("p", "g", "rod.tip"), "<p.frame_b>:1:5: Rod `rod` has no `tip`"),
    (lambda b: b.Revolute("p", "g", "rod"), "`rod` is a Rod, expected one of its frames"),
    (lambda b: b.Revolute("p", frame_a="g", frame_b="rod.phi"), "<p.frame_b>:1:1: `rod.phi` is a value"),
    (lambda b: b.Revolute("p", "g", "rod.a", "rod.b"), "takes 2 frames, found 3"),
    (lambda b: b.frame("f", "pin"), "`pin` is a port or connector"),
    (lambda b: b.frame("f", "g", r=(1, 2, 3)), "`r` of `f`: found an array of 3"),
    (lambda b: b.frame("f", "g", phi="1 m"), "`phi` of `f`: found a length [m]"),
    (lambda b: b.connect("rod.a", "link[1].b"), "<connect.second>:1:1: `rod.a` and `link[1].b` are frames of bodies"),
    (lambda b: b.connect("pin.frame_a", "rod.b"), "`pin.frame_a` is connected twice"),
    # laws
    (torque("2 N"), "`tau` of `t`: found a force [N], expected a torque"),
    (torque([1, 2]), "`tau` of `t`: found an array of 2"),
    (torque("t.tau"), "cyclic definition"),
    (torque("rod.alpha*1 kg.m2"), "`rod.alpha` is a result of the simulation"),
    (lambda b: b.Force("f", "rod.b", fx="2 m"), "`fx` of `f`: found a length [m]"),
    (lambda b: b.RotationalDriver("d", "g", "rod.b"), "RotationalDriver `d` needs `phi`"),
    (lambda b: b.RotationalDriver("d", "g", "rod.b", phi="rod.w*1 s"), "a driver prescribes a motion in time"),
    (lambda b: b.SpringDamper("s", "g", "rod.b", k=1, s0=1, force="3 N"), "`force` replaces k and c"),
    # other declarations
    (lambda b: b.parameter("m", "3 kg", type="Length"), "<m>:1:1: `m`: found a mass [kg], expected a length [m]"),
    (lambda b: b.variable("v", "rod.x + rod.phi"), "<v>:1:1: `+` takes two values of the same dimension"),
    (lambda b: b.input("u", "1 kg", unit="N"), "<u.start>:1:1: `u`: found a mass [kg]"),
    (lambda b: b.input("u", unit="Nmm2x"), 'unknown unit "Nmm2x"'),
    (lambda b: (b.table("t", [(0, 0)]), b.variable("v", "t(time)")), "`table` of `t` has 1 row"),
    (
        lambda b: (b.table("t", [(0, 0), (1, 1)], smoothness="cubik"), b.variable("v", "t(time)")),
        '`smoothness` of `t`: found "cubik"',
    ),
    (lambda b: b.shape("rod", "Circle(radius = 2 kg)"), "<shape of rod>:1:17: `radius` of Circle: found a mass"),
    (lambda b: b.initial("rod.w", "2 m"), "the initial value of `rod.w`: found a length [m]"),
    (lambda b: b.initial("rod.ww", 0), "<initial.target>:1:5: Rod `rod` has no `ww`"),
    (lambda b: b.initial("pin.fx", 0), "`pin.fx` depends on a reaction"),
    (lambda b: b.experiment(stop="2 m"), "<stop>:1:1: `StopTime`: found a length [m]"),
    (lambda b: b.experiment(start=5), "StopTime 1 s is not after StartTime 5 s"),
    (lambda b: b.experiment(tolerance=-1), "`Tolerance` is -1"),
    # changes and new parameters
    (lambda b: b.Rod("rod", m="1 m", length=1, replace=True), "found a length [m], expected a mass [kg]"),
]


def test_a_wrong_name_is_refused_at_once_and_changes_nothing():
    b = model()
    before, shown = b.scene(), b._repr_html_()
    for call, message in AT_ONCE:
        with pytest.raises(MbdslError, match=re.escape(message)):
            call(b)
        assert b._repr_html_() == shown, message
        assert b.scene() == before, message
    b.Rod("r", m=1, length=1)
    torque("2 N.m")(b)
    assert {"r", "t"} <= set(b.scene().components)


def test_a_wrong_value_is_found_with_the_line_that_gave_it():
    for call, message in IN_SCENE:
        b = model()
        call(b)
        with pytest.raises(MbdslError, match=re.escape(message)) as caught:
            b.scene()
        assert f"{__file__}:" in str(caught.value), str(caught.value)


def test_an_error_shows_the_call():
    b = Builder("M")
    b.Ground("g")
    rod = b.Rod("rod", m=-1, length=1)  # the line that is shown
    with pytest.raises(MbdslError) as caught:
        b.scene()
    assert caught.value.span.text.endswith("# the line that is shown") and caught.value.span.file == __file__
    with pytest.raises(MbdslError, match="`m` of `rod` is -1"):
        _ = rod.a
    b.Rod("rod", m="2 s", length=1, replace=True)  # another line
    with pytest.raises(MbdslError) as caught:
        b.scene()
    (text, span), written = caught.value.notes[0], caught.value.span
    assert (written.file, written.text, text) == ("<rod.m>", "2 s", "it was given here")
    assert span.text.endswith("# another line") and span.file == __file__


def test_own_signals_of_a_joint_exist_once_it_is_connected():
    b = model()
    b.RotationalSpringDamper("s", torque="3*phi - 0.1*w")  # bare numbers adopt the unit
    b.RotationalSpringDamper("u", torque="3 N*phi")
    b.variable("x", "2*s.phi")
    b.connect("s.frame_a", "g")
    b.connect("s.frame_b", "link[1].b")
    b.connect("u.frame_a", "g")
    with pytest.raises(MbdslError, match="`frame_b` of RotationalSpringDamper `u` is not connected"):
        b.scene()
    b.connect("u.frame_b", "rod.b")
    with pytest.raises(MbdslError, match=r"`torque` of `u`: found a force"):
        b.scene()
    b.remove("u")
    assert {"s", "x"} <= {*b.scene().components, *b.scene().variables}


def test_a_force_from_the_ground_waits_for_it():
    b = Builder("M")
    b.PointMass("ball", m=1)
    b.KnifeEdge("k", "ball")
    b.Force("f", "ball", fx="1 N*sin(2*time)")
    with pytest.raises(MbdslError, match="`k` acts from the ground, but none is declared"):
        b.scene()
    b.Ground("g")
    assert b.scene().components["f"].ports["frame_a"] == "g.c"


@pytest.mark.parametrize(
    "wrong", [lambda x: -x, lambda x: 2 * x, lambda x: x + x, lambda x: x > 1], ids=["-", "*", "+", ">"]
)
def test_python_does_not_calculate_with_names(wrong):
    b = Builder("M")
    with pytest.raises(UsageError, match="`x` is a name of the model") as found:
        wrong(b.state("x", start=1.0))
    assert '"2*x"' in found.value.hint
