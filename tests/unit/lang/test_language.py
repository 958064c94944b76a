"""Every feature of the language, checked in the resulting Scene."""

# ruff: noqa: E501  models in one line

import math

import pytest

from mbdsl.errors import ModelError, UsageError
from mbdsl.expressions import printing as et
from mbdsl.expressions import symbolic as ex
from mbdsl.lang.load import load, parse_text
from mbdsl.lang.parser import parse
from mbdsl.lang.unparse import dump

ROD = "Rod rod(m = 1 kg, length = 1 m);"


def scene(body, before="", **kwargs):
    """A model with a ground named g0."""
    return parse_text(f"{before} model M Ground g0; {body} end M;", **kwargs)


def parameter(text, name="x"):
    return scene(text).parameters[name].value


# -- parameters ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("parameter Real x = 3;", 3.0),
        ("parameter x = 3 kg;", 3.0),
        ("parameter Mass x = 500 g;", 0.5),
        ("parameter SI.Mass x = 3;", 3.0),
        ("parameter Modelica.Units.SI.Length x = 3 mm;", 0.003),
        ("constant Real x = 3;", 3.0),
        ("final parameter Real x = 3;", 3.0),
        ('parameter Real x(unit = "kg") = 3;', 3.0),
        ('parameter Real x(unit = "deg") = 180;', math.pi),
        ("parameter Integer x = 2*4;", 8),
        ("parameter Boolean x = 1 < 2 and not 3 < 2;", True),
        ('parameter String x = "a" "doc";', "a"),
        ("parameter Real x = 2*y; parameter Real y = z + 1; parameter Real z = 1;", 4.0),
        ("parameter Real x[3] = {1, 2, 3} m;", (1.0, 2.0, 3.0)),
        ("parameter Real[3] x = {1, 2, 3};", (1, 2, 3)),
        ("parameter Real x[:] = {1, 2};", (1, 2)),
        ("parameter Real x[2, 2] = [1, 2; 3, 4];", ((1, 2), (3, 4))),
        ("parameter Real y[3] = {1, 2, 3}; parameter Real x = y[2] + y[end];", 5),
        ("parameter Real y[3] = {1, 2, 3}; parameter Real x[2] = y[2:end];", (2, 3)),
        ("parameter Real y[3] = {1, 2, 3}; parameter Real x = sum(y[:])/size(y, 1);", 2.0),
        ("parameter Real y[2, 2] = [1, 2; 3, 4]; parameter Real x = y[2, 1];", 3),
        ("parameter Real x = if 1 > 2 then 1 elseif 2 > 1 then 2 else 3;", 2),
        ("parameter Real x(min = 0, max = 5) = 4;", 4),
        ("parameter Real x(start = 4);", 4),
        ("parameter Real x = rod.length + rod.m*(1 m/kg); " + ROD, 2.0),
        ("parameter Real x[3] = {i^2 for i in 1:3};", (1, 4, 9)),
        ('parameter Real a = 1, x = 2 "two", b = 3;', 2),
    ],
)
def test_parameters(text, value):
    found = parameter(text)
    assert found == (pytest.approx(value) if isinstance(value, float) else value)


def test_parameters_keep_their_unit_and_doc():
    found = scene('parameter Stiffness k = 100 N/mm "how stiff"; parameter b = 2 m; parameter c = 3;').parameters
    assert (found["k"].value, found["k"].unit, found["k"].doc) == (1e5, "N/m", "how stiff")
    assert (found["b"].unit, found["c"].unit) == ("m", "")
    assert found["k"].span.line == 1


def test_comments_and_docs():
    text = 'model M "doc" // comment\n /* more\n comment */ Ground g "the world"; end M;'
    found = parse_text(text)
    assert found.doc == "doc" and found.components["g"].doc == "the world"


# -- components ----------------------------------------------------------------------------------------------------


def test_component():
    found = scene('Rod rod(m = 2 kg, length = 50 cm) "a rod";')
    rod = found.components["rod"]
    assert rod.kind.name == "Rod" and rod.doc == "a rod" and rod.span.column > 1
    assert rod.values["m"] == 2.0 and rod.values["length"] == 0.5 and rod.values["I"] == pytest.approx(0.5 / 12)
    assert {n: (f.x, f.y, f.phi) for n, f in found.frames.items()} == {
        "g0.c": (0, 0, 0), "rod.c": (0, 0, 0), "rod.a": (-0.25, 0, 0), "rod.b": (0.25, 0, 0),
    }  # fmt: skip


def test_user_frames_and_centre_of_mass():
    found = scene("Body b(m = 1, I = 1, com = {0.1, 0.2} m, frames(tip = {0.3 m, 0}, rim = {0, 0.1 m, 90 deg}));")
    rim = found.frames["b.rim"]
    assert (rim.body, rim.x, rim.y, rim.phi) == ("b", 0.0, 0.1, math.pi / 2)
    assert (found.frames["b.c"].x, found.frames["b.c"].y) == (0.1, 0.2)


def test_frame_declarations():
    found = scene(
        f"{ROD} Frame wall(g0, r = {{1.2 m, 0}}, phi = 90 deg); Frame next(wall, r = {{1 m, 0}}); Frame tip(rod.b, r = {{0.1, 0}});"
        "Frame same = rod.a; Revolute J(next, same);"
    )
    assert found.frames["wall"].body == "g0"
    assert (found.frames["next"].x, found.frames["next"].y) == (pytest.approx(1.2), pytest.approx(1.0))
    assert (found.frames["tip"].body, found.frames["tip"].x) == ("rod", 0.6)
    assert found.components["J"].ports == {"frame_a": "next", "frame_b": "rod.a"}
    assert "same" not in found.frames


def test_arrays_of_components():
    found = scene(
        "parameter Integer N = 3; Rod link[N](each m = 1 kg, length = {1, 2, 3} m, frames(tip = {0.1, 0}));"
        "Revolute J[N - 1](link[1:N - 1].b, link[2:end].a); Torque t[N](link.c, tau = {1, 2, 3} N.m);"
    )
    assert [found.components[f"link[{i}]"].values["length"] for i in (1, 2, 3)] == [1, 2, 3]
    assert found.components["J[2]"].ports == {"frame_a": "link[2].b", "frame_b": "link[3].a"}
    assert found.components["t[3]"].values["tau"] is ex.const(3.0)
    assert found.components["t[3]"].ports == {"frame_a": "g0.c", "frame_b": "link[3].c"}
    assert found.frames["link[3].b"].x == 1.5 and found.frames["link[2].tip"].x == 0.1


def test_arrays_of_two_dimensions():
    found = scene("PointMass p[2, 3](each m = 1); Distance d(p[1, 2], p[2, 3], length = 1);")
    assert "p[2,3]" in found.components
    assert found.components["d"].ports == {"frame_a": "p[1,2].c", "frame_b": "p[2,3].c"}


def test_arrays_of_nothing():
    assert set(scene("Rod r[0](each m = 1, each length = 1);").components) == {"g0"}


def test_loops():
    found = scene(
        "Rod link[4](each m = 1, each length = 1); Revolute J[3];"
        "for i in 1:2:3 loop Revolute K[i](link[i].b, link[i + 1].a); for j in 1:i loop FreeMotion F[i, j](g0, link[j].c);"
        "end for; end for;"
        "equation for i in 1:3 loop connect(J[i].frame_a, g0); connect(link[i + 1].c, J[i].frame_b); end for;"
    )
    assert [n for n in found.components if n[0] in "KF"] == ["K[1]", "F[1,1]", "K[3]", "F[3,1]", "F[3,2]", "F[3,3]"]
    assert found.components["K[3]"].ports == {"frame_a": "link[3].b", "frame_b": "link[4].a"}
    assert found.components["J[2]"].ports == {"frame_a": "g0.c", "frame_b": "link[3].c"}


def test_pieces_of_an_array():
    found = scene(
        "Rod r[3](each m = 1, each length = 1); Revolute J[3](g0, r[3].a);"
        "for i in 1:2 loop Revolute J[i](r[i].b, r[i + 1].a); end for;"
    )
    assert [n for n in found.components if n[0] == "J"] == ["J[3]", "J[1]", "J[2]"]
    with pytest.raises(ModelError, match=r"`J\[1\]` is declared twice"):
        scene("Revolute J[1](g0, g0); for i in 1:2 loop Revolute J[i](g0, g0); end for;")
    with pytest.raises(ModelError, match="`J` is declared twice"):
        scene("Revolute J(g0, g0); for i in 1:2 loop Revolute J[i](g0, g0); end for;")


@pytest.mark.parametrize("damped", [True, False])
def test_conditions(damped):
    found = scene(
        f"parameter Boolean damped = {str(damped).lower()}; {ROD} Revolute J(g0, rod.a);"
        "RotationalSpringDamper s(c = 1) if damped; RotationalSpringDamper u(J, c = 1) if not damped;"
        "if damped then Torque t1(J, tau = 1); else Torque t2(J, tau = 2); end if;"
        "equation connect(s.frame_a, g0); if damped then connect(s.frame_b, rod.a); end if;"
    )
    expected = {"s", "t1"} if damped else {"u", "t2"}
    assert set(found.components) == {"g0", "rod", "J"} | expected


def test_order_of_declarations_plays_no_part():
    found = parse_text("model M Revolute J(g, rod.a); Rod rod(m = m, length = L); Ground g; parameter L = 2*m; "
                       "parameter m = 3; end M;")  # fmt: skip
    assert list(found.components) == ["J", "rod", "g"] and found.components["rod"].values["length"] == 6


# -- attaching -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "a", "b"),
    [
        ("Revolute J(g0, rod.a);", "g0.c", "rod.a"),
        ("Revolute J(frame_b = rod.a, frame_a = g0);", "g0.c", "rod.a"),
        ("Revolute J(g0, frame_b = rod.a);", "g0.c", "rod.a"),
        ("Revolute J(frame_a = g0); equation connect(rod.a, J.frame_b);", "g0.c", "rod.a"),
        ("Revolute J; equation connect(J.frame_a, g0); connect(J.frame_b, rod.a);", "g0.c", "rod.a"),
        ("Force J(rod.a, fx = 1 N);", "g0.c", "rod.a"),
        ("Force J(rod.b, rod.a, fx = 1 N);", "rod.b", "rod.a"),
        ("Force J(frame_b = rod.a, fx = 1 N);", "g0.c", "rod.a"),
        ("Force J(fx = 1 N); equation connect(J.frame_b, rod.a);", "g0.c", "rod.a"),
        ("Revolute K(g0, rod.a); Torque J(K, tau = 1);", "g0.c", "rod.a"),
        ("Revolute K(g0, rod.a); Revolute J(K.frame_a, K.frame_b);", "g0.c", "rod.a"),
        ("PointMass p(m = 1); Distance J(g0, p, length = 1);", "g0.c", "p.c"),
        ("Frame f; Revolute J(g0, f); equation connect(f, rod.a);", "g0.c", "rod.a"),
    ],
)
def test_ways_to_attach(text, a, b):
    assert scene(ROD + text).components["J"].ports == {"frame_a": a, "frame_b": b}


def test_world_is_another_word_for_ground():
    assert parse_text("model M World w(g = 0); end M;").components["w"].kind.name == "Ground"


# -- sub-models ----------------------------------------------------------------------------------------------------

ARM = """
model Arm "an arm"
  parameter Length L = 1 m;
  parameter Mass m = 1 kg;
  Frame root;
  connector Frame tip = rod.b;
  Rod rod(m = m, length = L);
  Revolute pin(root, rod.a);
initial equation
  guess rod.phi = 1;
end Arm;
"""


def test_sub_models():
    found = scene(
        "Arm left(L = 2 m, rod(m = 5 kg)); Arm right(left.tip, m = 3 kg); equation connect(left.root, g0);", ARM
    )
    assert found.components["left.rod"].values["length"] == 2.0 and found.components["left.rod"].values["m"] == 5.0
    assert found.components["right.rod"].values["m"] == 3.0
    assert found.components["left.pin"].ports == {"frame_a": "g0.c", "frame_b": "left.rod.a"}
    assert found.components["right.pin"].ports == {"frame_a": "left.rod.b", "frame_b": "right.rod.a"}
    assert [i.name for i in found.initial] == ["left.rod.phi", "right.rod.phi"]


def test_arrays_of_sub_models():
    found = scene(
        "Arm arm[2](root = {g0, g0}, L = {1, 2} m, each rod(m = 2 kg));".replace("root = {g0, g0}, ", "g0, "), ARM
    )
    assert [found.components[f"arm[{i}].rod"].values["length"] for i in (1, 2)] == [1.0, 2.0]
    assert found.components["arm[2].pin"].ports["frame_a"] == "g0.c"


def test_outer_ground():
    inner = "model Leg outer Ground g0; Rod r(m = 1, length = 1); Revolute J(g0, r.a); end Leg;"
    assert scene("Leg leg;", inner).components["leg.J"].ports["frame_a"] == "g0.c"


def test_extends():
    base = "partial model Base parameter Mass m = 1 kg; Rod rod(m = m, length = 1 m); end Base;"
    found = scene("extends Base(m = 4 kg, rod(length = 3 m)); Revolute J(g0, rod.a);", base)
    assert found.components["rod"].values["m"] == 4.0 and found.components["rod"].values["length"] == 3.0
    assert found.parameters["m"].value == 4.0


def test_extends_in_steps():
    base = "model A parameter x = 1; end A; model B extends A(x = 2); end B;"
    assert scene("extends B;", base).parameters["x"].value == 2
    assert scene("extends B(x = 3);", base).parameters["x"].value == 3


def test_main_model(tmp_path):
    text = "model First Ground g; end First; model Other Ground h; end Other; partial model P end P;"
    assert parse_text(text).name == "Other"
    path = tmp_path / "first.mbd"
    path.write_text(text)
    assert load(path).name == "First"
    assert load(path, model="Other").name == "Other"
    with pytest.raises(UsageError, match="Othr"):
        load(path, model="Othr")


def test_imports(tmp_path):
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "arm.mbd").write_text('import "../main.mbd";' + ARM)
    (tmp_path / "lib" / "leg.mbd").write_text(ARM.replace("Arm", "Leg"))
    (tmp_path / "main.mbd").write_text(
        'import "lib/arm.mbd"; import "lib/leg.mbd" as parts; model Main Ground g; Arm arm(g); parts.Leg leg(g); end Main;'
    )
    found = load(tmp_path / "main.mbd")
    assert {"arm.rod", "leg.rod"} <= set(found.components)
    assert [f.rpartition("/")[2] for f in found.files] == ["main.mbd", "arm.mbd", "leg.mbd"]
    assert found.components["arm.rod"].span.file.endswith("arm.mbd")


# -- laws and signals ----------------------------------------------------------------------------------------------


def test_laws():
    found = scene(
        f"{ROD} parameter k1 = 50 N/m; Revolute J(g0, rod.a); SpringDamper s(g0, rod.b, "
        "force = k1*(s - s0) + 2 N.s/m*v, s0 = 1 m); Torque t(J, tau = 0.033 N.m*sin(2*time) - 0.1*J.w + rod.b.x*1 N);"
    )
    at = {("rod.b", "x"): 3.0, ("rod.b", "y"): 4.0, ("rod.b", "vx"): 1.0, ("rod.b", "vy"): 2.0, ("rod.a", "w"): 7.0}
    leaf = lambda n: 0.5 if n.op == "time" else at.get(n.value, 0.0)  # noqa: E731
    force, tau = ex.evaluate([found.components["s"].values["force"], found.components["t"].values["tau"]], leaf)
    assert force == pytest.approx(50 * (5 - 1) + 2 * 11 / 5)
    assert tau == pytest.approx(0.033 * math.sin(1.0) - 0.7 + 3.0)
    assert found.signal("s.force") is found.components["s"].values["force"]
    assert found.signal("t.tau") is found.components["t"].values["tau"]


def test_names_of_the_model_around_win_in_laws():
    """As in Modelica: a modifier is written, and evaluated, in the enclosing model."""
    found = scene(
        f"{ROD} parameter AngularVelocity w = 10 rad/s; parameter Length s = 3 m; Revolute J(g0, rod.a);"
        "Torque t(rod.b, tau = 0.033 N.m*sin(w*time)); RotationalDriver d(J, phi = w*time);"
        "SpringDamper spring(g0, rod.b, force = 2 N/m*s); SpringDamper own(g0, rod.b, force = 2 N/m*own.s + 1 N.s/m*v);"
    )
    at = {("rod.b", "x"): 3.0, ("rod.b", "y"): 4.0, ("rod.b", "w"): 7.0}
    leaf = lambda n: 0.5 if n.op == "time" else at.get(n.value, 0.0)  # noqa: E731
    laws = [("t", "tau"), ("d", "phi"), ("spring", "force"), ("own", "force")]
    given = ex.evaluate([found.components[name].values[law] for name, law in laws], leaf)
    assert given == pytest.approx([0.033 * math.sin(5.0), 5.0, 6.0, 10.0])


def test_point_masses_and_links_have_the_signals_of_their_families():
    found = scene("PointMass p(m = 1); Distance d(g0, p, length = 1); initial equation p.x = 1 m; p.vy = 2 m/s;")
    assert (found.signal("p.phi"), found.signal("p.w")) == (ex.coordinate("p.c", "phi"), ex.coordinate("p.c", "w"))
    at = {("p.c", "x"): 3.0, ("p.c", "y"): 4.0, ("p.c", "vx"): 1.0, ("p.c", "vy"): 2.0}
    assert ex.evaluate([found.signal("d.s"), found.signal("d.v")], lambda n: at.get(n.value, 0.0)) == [5.0, 2.2]


def test_a_driver_does_not_hide_the_measured_angle():
    found = scene(f"{ROD} Revolute J(g0, rod.a); RotationalDriver d(J, phi = 2*time);")
    assert et.text(found.signal("d.phi")) == "(rod.a.phi - g0.c.phi)"
    assert found.components["d"].values["phi"] is 2.0 * ex.TIME


def test_variables():
    found = scene(f"{ROD} Revolute J(g0, rod.a); Real F = 2 N*sin(2*time); Force f(rod.b, fx = F, fy = 2*F);")
    assert found.components["f"].values["fx"] is found.variables["F"] is found.signal("F")
    assert found.components["f"].values["fy"] is 2.0 * found.variables["F"]


def test_tables():
    found = scene(
        f'{ROD} Table p(table = [0 s, 0 N; 1 s, 2 N], smoothness = "cubic", extrapolation = "periodic") if false;'
        'Table q(table = [0 s, 0 N; 1 ms, 2 kN; 3, 1], smoothness = "monotone"); Force f(rod.b, fx = 2*q(time), fy = q(2*time));'
    )
    node = next(n for n in ex.walk(found.components["f"].values["fx"]) if n.op == "table")
    table, order = node.value
    assert (table.u, table.y, order) == ((0.0, 1e-3, 3.0), (0.0, 2000.0, 1.0), 0)
    assert (table.smoothness, table.extrapolation) == ("monotone", "hold")


def test_signals():
    found = scene(f"{ROD} PointMass p(m = 1); Revolute J(g0, rod.a);")
    assert et.text(found.signal("rod.phi")) == "rod.c.phi"
    assert found.signal("rod.b.vx") is ex.coordinate("rod.b", "vx")
    assert found.signal("p.c.phi") is ex.coordinate("p.c", "phi")
    own = found.signals_of(found.components["J"])
    assert "J.w" in found.signals() and own["phi"] is found.signal("J.phi") is found.signals()["J.phi"]
    for wrong in ("rod.b.q", "J.ph", "jj.x", "rod", "p.c"):
        with pytest.raises(ModelError, match="no signal"):
            found.signal(wrong)
    assert found.signal_of(found.components["J"], "x") is None


def test_every_signal_of_every_kind_has_the_dimension_it_declares():
    from mbdsl.elements import kinds
    from mbdsl.elements.kind import PairKind
    from mbdsl.lang import units
    from mbdsl.lang.evaluate import Budget, Names, evaluate
    from mbdsl.lang.flat_model import _COORDINATE_DIMENSION
    from mbdsl.lang.parser import parse_expression
    from mbdsl.lang.values import Quantity

    class Declared(Names):
        """Values with the units that the kind declares."""

        def __init__(self, kind):
            self.kind, self.budget = kind, Budget()

        def value(self, reference):
            name, *rest = (step.name for step in reference.steps)
            if rest:
                return Quantity(ex.coordinate(name, *rest), _COORDINATE_DIMENSION[rest[0]])
            if name == "lam":
                return Quantity(ex.multiplier("x", 0))
            parameter = self.kind.parameter(name)
            if parameter is not None and not parameter.law:
                return Quantity(2.0, units.dimension(parameter.unit))
            signal = next((x for x in self.kind.signals if x.name == name), None)
            return Quantity(2.0) if signal is None else self.signal(signal)  # values that a kind derives have no unit

        def with_locals(self, names):
            return self

        def call(self, e):
            """angle(y, x, rate), a function of formulas only: that of the direction (x, y), with its turns."""
            if len(e.arguments) == 2:  # lt(gap, 0), also of formulas only
                return Quantity(1.0)
            y, x, rate = (evaluate(argument.value, self) for argument in e.arguments)
            assert y.dimension == x.dimension
            assert rate.dimension == units.dimension("rad/s")
            return Quantity(2.0, units.dimension("rad"))

        def rate(self, leaf):
            return None  # no state

        def signal(self, signal):
            formula = signal.formula.replace("start(", "(")  # the value at the start has the same dimension
            return evaluate(parse_expression(formula, "<formula>"), self)

    checked = 0
    for kind in kinds().values():
        if isinstance(kind, PairKind):
            # reactions of rows have no formula
            for signal in (x for x in (*kind.signals, *getattr(kind, "reactions", ())) if x.formula):
                found = Declared(kind).signal(signal)
                assert found.dimension in (None, units.dimension(signal.unit)), (kind.name, signal.name)
                checked += found.dimension is not None
    assert checked > 40


# -- initial values, experiment ------------------------------------------------------------------------------------


def test_initial_values():
    found = scene(
        "Rod rod(m = 1, length = 1, phi(start = 10 deg, fixed = true), w(start = 2)); Rod r[2](each m = 1, each length = 1,"
        "phi(start = {1, 2})); Revolute J(g0, rod.a);"
        "initial equation J.w = 3; guess rod.x = 1 m; fixed rod.b.y = 2 m; der(r[1].phi) = 4 rad/s;"
        "for i in 1:2 loop guess r[i].phi = 5*i; end for;"
    )
    assert {i.name: (i.value, i.fixed) for i in found.initial} == {
        "rod.phi": (math.radians(10), True), "rod.w": (2.0, False), "r[1].phi": (5.0, False), "r[2].phi": (10.0, False),
        "J.w": (3.0, True), "rod.x": (1.0, False), "rod.b.y": (2.0, True), "der(r[1].phi)": (4.0, True),
    }  # fmt: skip
    assert next(i for i in found.initial if i.name == "rod.b.y").target is ex.coordinate("rod.b", "y")


def test_experiment():
    found = scene(
        'annotation(experiment(StartTime = 1, StopTime = 2 min, Interval = 1 ms, Tolerance = 1e-6, Method = "hht-si2", Step = 1e-3),'
        'Icon(graphics = {Line(points = {{0, 0}, {1, 1}})}), Documentation(info = "<html></html>"));'
    ).experiment
    assert (found.start, found.stop, found.interval, found.tolerance) == (1.0, 120.0, 1e-3, 1e-6)
    assert (found.method, found.step) == ("hht-si2", 1e-3)
    assert scene("annotation(experiment(StopTime = 2, NumberOfIntervals = 100));").experiment.interval == 0.02


# -- overrides -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("overrides", "k", "m"),
    [
        ({}, 100.0, 1.0),
        ({"k": "120 N/mm"}, 120e3, 1.0),
        ({"k": 7}, 7.0, 1.0),
        ({"k": "2*k0"}, 10.0, 1.0),
        ({"rod.m": "4 kg"}, 100.0, 4.0),
        ({"rod.m": 5.0, "k": "1 N/m"}, 1.0, 5.0),
    ],
)
def test_overrides(overrides, k, m):
    found = scene(f"parameter k = 100 N/m; parameter k0 = 5 N/m; {ROD}", overrides=overrides)
    assert found.parameters["k"].value == k and found.components["rod"].values["m"] == m


def test_overrides_reach_inside():
    found = scene(
        "Arm arm[2](each L = 1 m, g0); ".replace("(each L = 1 m, g0)", "(g0, each L = 1 m)")
        + "Rod r[2](each m = 1, each length = 1);",
        ARM,
        overrides={"arm.m": "7 kg", "arm[2].L": "4 m", "r[2].m": "3 kg"},
    )
    assert found.components["arm[2].rod"].values["length"] == 4.0
    assert found.components["arm[2].rod"].values["m"] == 7.0
    assert [found.components[f"r[{i}]"].values["m"] for i in (1, 2)] == [1.0, 3.0]


def test_overrides_reach_into_loops():
    text = "Rod r[2](each m = 1, each length = 1); for i in 1:2 loop Prismatic K[i](g0, r[i].a); end for;"
    found = scene(text, overrides={"K[2].phi0": "90 deg"})
    assert [found.components[f"K[{i}]"].values["phi0"] for i in (1, 2)] == [0.0, math.pi / 2]
    with pytest.raises(ModelError, match=r"no `K\[3\]`"):
        scene(text, overrides={"K[3].phi0": "90 deg"})


@pytest.mark.parametrize(
    ("overrides", "error", "text"),
    [
        ({"kk": "1"}, UsageError, "did you mean `k`"),
        ({"k": "3 kg"}, ModelError, "found a mass [kg], expected a stiffness [N/m]"),
        ({"k": "3 +"}, Exception, "--set k:1:4"),
        ({"rod": "3"}, UsageError, "is not a parameter"),
        ({"rod.mm": "3"}, ModelError, "no parameter `mm`"),
        ({"1": "3"}, UsageError, "not the name"),
        ({"rod[1].m": "3"}, ModelError, "there is no `rod[1]`"),
        ({"c": "3"}, ModelError, "constant"),
    ],
)
def test_wrong_overrides(overrides, error, text):
    with pytest.raises(error) as caught:
        scene(f"parameter k = 100 N/m; constant Real c = 1; {ROD}", overrides=overrides)
    assert text in str(caught.value)


# -- syntax --------------------------------------------------------------------------------------------------------


def test_dump():
    text = (
        "model M extends B(x = 1); parameter Real k[2](min = 0) = {1, 2} N/m; Rod r(m = -(1 + 2)*3, phi(start = 1)) if a and not b;"
        "for i in 1:2 loop Rod q[i](m = i); end for; equation connect(r.a, q[1].b); initial equation guess r.phi = if a then 1 else 2;"
        "end M;"
    )
    shown = dump(parse(text, "f.mbd"))
    for part in (
        "File f.mbd",
        "Extends base=B arguments=x = 1",
        "name=k indices=2 arguments=min = 0 value={1, 2} N/m",
        "condition=a and (not b)",
        "For i in 1:2",
        "Connect first=r.a second=q[1].b",
        "Initial mode=guess target=r.phi value=if a then 1 else 2",
    ):
        assert part in shown


def test_expressions_written_are_read_back_the_same():
    from mbdsl.lang.parser import parse_expression
    from mbdsl.lang.unparse import write

    for text in ("a - b - c", "a - (b - c)", "-a^2", "(-a)^2", "a^b^c", "(a^b)^c", "a/b*c", "a/(b*c)", "not (a and b)",
                 "1:2:3", "if a then b else c", "{1, 2} m", "f(x, g(y))", 'f("a\\"b")', "a[1, :].b", "{i for i in 1:3}"):  # fmt: skip
        tree = parse_expression(text)
        assert parse_expression(write(tree)) == tree, text


def test_the_work_of_reading_grows_with_the_number_of_components():
    """Counted in executed lines of Python: a step over all components for each of them would be seen."""
    import sys
    from pathlib import Path

    chain = Path(__file__).parents[3] / "models" / "chain.mbd"
    load(chain)

    def lines(bodies):
        count = 0

        def trace(frame, event, argument):
            nonlocal count
            count += event == "line"
            return trace

        before = sys.gettrace()
        sys.settrace(trace)
        try:
            found = load(chain, {"N": bodies})
        finally:
            sys.settrace(before)
        assert len(found.components) == 2 * bodies + 1
        return count

    few, more, many = (lines(bodies) for bodies in (64, 128, 256))
    assert many - more == pytest.approx(2 * (more - few), rel=0.01)
