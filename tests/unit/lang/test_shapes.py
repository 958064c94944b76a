"""Shapes of bodies in annotations: their meaning, errors with places, and the files that keep them."""

import pickle

import numpy as np
import pytest

from mbdsl import Builder, parse
from mbdsl.errors import MbdslError, ModelError
from mbdsl.lang.stored_model import from_text, to_text
from mbdsl.lang.svg_path import PathError, flattened

TEXT = """model M
  Ground ground;
  Body b(m = 1 kg, length = 0.3 m)
    annotation({});
  Revolute pin(ground, b.a);
end M;"""


def shapes(annotation):
    return parse(TEXT.format(annotation)).shapes["b"]


def test_each_form():
    polygon, box, disc, oval, line, path = shapes(
        'Shape(Polygon(points = {{0, 0}, {20, 0}, {10, 15}} mm, fillColor = {255, 0, 16}, lineColor = "#0ab"),'
        ' Rectangle(extent = {{-1, -2}, {3, 4}} cm, fillColor = "none"), Circle(radius = 2 cm, center = {1, 2} cm),'
        " Ellipse(extent = {{-2, 0}, {2, 2}}, pattern = LinePattern.None, fillPattern = FillPattern.Solid),"
        ' Line(points = {{0, 0}, {1, 0}}, color = "red", thickness = 3 mm),'
        ' Path(d = "M 0 0 h 10 v 5 z", scale = 1 mm, lineThickness = 1 mm))'
    )
    assert (polygon.form, polygon.fill, polygon.line, polygon.width) == ("area", "#ff0010", "#00aabb", 0.0)
    assert polygon.parts == (((0.0, 0.0), (0.02, 0.0), (0.01, 0.015)),)
    assert box.parts == (((-0.01, -0.02), (0.03, -0.02), (0.03, 0.04), (-0.01, 0.04)),) and box.fill == "none"
    assert (disc.form, disc.parts, disc.axes) == ("ellipse", (((0.01, 0.02),),), (0.02, 0.02, 0.0))
    assert (oval.parts, oval.axes, oval.line, oval.fill) == ((((0.0, 1.0),),), (2.0, 1.0, 0.0), "none", "")
    assert (line.form, line.parts, line.width) == ("line", (((0.0, 0.0), (1.0, 0.0)),), 0.003)
    # the y axis of SVG points down
    assert path.parts == (((0.0, -0.0), (0.01, -0.0), (0.01, -0.005)),) and path.width == 0.001


def test_origin_and_rotation():
    """A quarter turn maps (x, y) to (-y, x), before the shift."""
    line, disc = shapes(
        "Shape(Line(points = {{1, 0}, {2, 1}}, rotation = 90 deg, origin = {10, 20}),"
        " Ellipse(extent = {{0, 0}, {4, 2}}, rotation = 90 deg))"
    )
    assert line.parts[0] == (pytest.approx((10.0, 21.0)), pytest.approx((9.0, 22.0)))
    assert disc.parts[0][0] == pytest.approx((-1.0, 2.0))
    assert disc.axes == pytest.approx((2.0, 1.0, np.pi / 2))


def test_what_users_of_modelica_write():
    (box,) = shapes(
        "Icon(graphics = {Rectangle(extent = {{-10, -5}, {10, 5}} mm, lineColor = {0, 0, 255},"
        " fillColor = {0, 127, 255}, fillPattern = FillPattern.Solid, lineThickness = 0.5 mm)})"
    )
    assert (box.line, box.fill, box.width) == ("#0000ff", "#007fff", 0.0005)
    scene = parse(TEXT.format("Placement(transformation(extent = {{-10, -10}, {10, 10}})), Dialog(group = 3)"))
    assert dict(scene.shapes) == {}
    icon = "annotation(Icon(coordinateSystem(extent = {{-100, -100}, {100, 100}}), graphics = {Text(extent = 3)}));"
    assert parse(TEXT.format("Dialog()").replace("end M", icon + " end M")).shapes == {}


@pytest.mark.parametrize(
    ("annotation", "column", "words"),
    [
        ("shape(Circle(radius = 1))", 16, "write `annotation(Shape("),
        ("Circle(radius = 1)", 16, "`Circle` is a part of a Shape"),
        ("Shape = 3", 16, "`Shape` has no value"),
        ("Shape(3)", 22, "Shape takes polygons"),
        ("Shape(Cirle(radius = 1))", 22, "did you mean `Circle`?"),
        ("Shape(Circle)", 22, "Circle needs `radius`"),
        ("Shape(Circle(1))", 29, "Circle takes arguments by name, found `1`"),
        ("Shape(Circle(radius = 1 kg))", 38, "found a mass [kg], expected a length [m]"),
        ("Shape(Circle(radius = -1))", 38, "must not be negative"),
        ("Shape(Circle(radius = 0))", 38, "must be positive"),
        ("Shape(Circle(radius = b.x))", 38, "varies in time"),
        ("Shape(Circle(radius = nothing))", 38, "unknown name `nothing`"),
        ("Shape(Circle(radius = 1, radius = 2))", 41, "`radius` is given twice"),
        ('Shape(Circle(radius = 1, fillColor = "rad"))', 53, "did you mean `red`?"),
        ("Shape(Circle(radius = 1, fillColor = {0, 0, 300}))", 54, "three numbers from 0 to 255"),
        ("Shape(Polygon(points = {{0, 0}, {1, 1}}))", 40, "expected at least 3 points"),
        ("Shape(Polygon(points = {{0, 0}, {1, 1}, {1e10, 0}}))", 40, "the largest coordinate is 1e+09 m"),
        ("Shape(Polygon(points = {{0, 0}, {1, 1}, {1, 0}}, smooth = Smooth.Bezier))", 66, "give curves as `Path("),
        ("Shape(Line(points = {{0, 0}, {1, 1}}, pattern = LinePattern.Dash))", 65, "write `LinePattern.Solid`"),
        ("Shape(Rectangle(extent = {{0, 0}, {0, 1}}))", 42, "has no area"),
        ("Shape(Rectangle(extent = {{0, 0}, {1, 1}}, rotation = 45))", 70, "write `rotation = 45 deg`"),
        ("Icon(graphics = {Line(points = {{0, 0}, {10, 0}})})", 48, "write `points = {{0, 0}, {10, 0}} mm`"),
        ("Icon(coordinateSystem(extent = {{-1, -1}, {1, 1}}))", 21, "lengths in the axes of the body"),
        ('Shape(Bitmap(fileName = "../../etc/passwd"))', 22, "no file is read"),
        ("Shape(graphics = 3)", 22, "`graphics` is a list"),
        ('Shape(Path(d = "M 0 0 L 1 1"))', 22, "write `scale = 1 mm`"),
        ('Shape(Path(d = "L 1 1", scale = 1 mm))', 31, "a path begins with `M x y`"),
        ("Shape(Path(d = 3, scale = 1 mm))", 31, "expected a text"),
    ],
)
def test_what_is_refused_and_where(annotation, column, words):
    with pytest.raises(ModelError) as caught:
        parse(TEXT.format(annotation))
    problem = caught.value
    assert words in f"{problem.message} {problem.hint}"
    assert problem.span.line == 4
    assert abs(problem.span.column - column) <= 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("model M Ground g; annotation(Shape(Circle(radius = 1))); end M;", "not to a model"),
        ("model M Ground g; PointMass m(m = 1); Revolute p(g, m) annotation(Shape()); end M;", "`p` is not a body"),
        ("model M Ground g; Frame f(g, r = {1, 0}) annotation(Shape(Circle(radius = 1))); end M;", "`f` is not a body"),
        (
            "model A outer Ground g annotation(Shape()); end A; model M inner Ground g; A a; end M;",
            "`g` is declared in an enclosing model",
        ),
        ("model A PointMass m(m = 1); end A; model M Ground g; A a annotation(Shape()); end M;", "`a` is not a body"),
    ],
)
def test_shapes_belong_to_bodies(text, words):
    with pytest.raises(ModelError, match=words) as caught:
        parse(text)
    assert caught.value.span is not None and "body" in caught.value.hint


def test_arrays_loops_parameters_and_bases():
    """Elements of an array share a shape, a loop gives each its own, and a parameter that is replaced counts."""
    text = """partial model Base
      parameter Length R = 2 cm; Ground ground annotation(Shape(Line(points = {{0, 0}, {1, 0}})));
      Rod link[3](each m = 1 kg, each length = 1 m) annotation(Shape(Circle(radius = R)));
    end Base;
    model M extends Base;
      for i in 1:2 loop PointMass m[i](m = 1 kg) annotation(Shape(Circle(radius = i*R))); end for;
    end M;"""
    scene = parse(text, overrides={"R": "3 cm"})
    assert list(scene.shapes) == ["ground", "link[1]", "link[2]", "link[3]", "m[1]", "m[2]"]
    assert [x[0].axes[0] for x in list(scene.shapes.values())[1:]] == pytest.approx([0.03, 0.03, 0.03, 0.03, 0.06])


def test_shapes_are_content_but_not_motion():
    """Scenes with other shapes differ, with the same motion; texts, pickles and results keep them."""
    plain, round_ = parse(TEXT.format("Dialog()")), parse(TEXT.format("Shape(Circle(radius = 1 cm))"))
    assert plain != round_ and plain.fingerprint == round_.fingerprint
    assert round_ == parse(TEXT.format("Shape(Circle(radius = 10 mm))"))
    assert pickle.loads(pickle.dumps(round_)) == round_ == from_text(to_text(round_))
    assert dict(from_text(to_text(round_)).shapes) == dict(round_.shapes) != {}
    assert parse(TEXT.format("Shape()")).shapes == {"b": ()}


def test_from_python():
    b = Builder("M")
    ground = b.Ground("ground")
    body = b.Body("b", m="1 kg", length="0.3 m")
    b.Revolute("pin", ground, body.a)
    b.shape(body, "Circle(radius = 1 cm)")
    assert b.scene() == parse(TEXT.format("Shape(Circle(radius = 1 cm))"))
    b.shape("ground", "Circle(radius = 1 kg)")
    with pytest.raises(ModelError, match="expected a length"):
        b.scene()
    b.shape("ground", replace=True)
    with pytest.raises(ModelError, match="`pin` is not a body"):
        b.shape("pin")


def test_the_number_of_points_is_bounded():
    many = "annotation(Shape(Polygon(points = {{i, i^2} for i in 1:1000})))"
    with pytest.raises(ModelError, match="more than 200000 points") as caught:
        parse(f"model M Ground g; PointMass c[300](each m = 1 kg) {many}; end M;")
    assert caught.value.span is not None


# -- paths of SVG ------------------------------------------------------------------------------------------------------


def test_arcs_lie_on_their_ellipse():
    """SVG 1.1, 8.3.8: of the four arcs through two points, the flags select the large one and the direction."""
    for large, sweep, centre, length in (
        (0, 1, (0, 10), 0.5),
        (1, 1, (10, 0), 1.5),
        (0, 0, (10, 0), 0.5),
        (1, 0, (0, 10), 1.5),
    ):
        ((points, closed),) = flattened(f"M 0 0 A 10 10 0 {large} {sweep} 10 10")
        p = np.array(points)
        assert not closed and points[0] == (0, 0) and points[-1] == (10, 10)
        assert np.hypot(*(p - centre).T) == pytest.approx(10.0)
        # lines of at most 10 degrees: shorter than the arc by 0.13 %
        assert np.hypot(*np.diff(p, axis=0).T).sum() == pytest.approx(10 * np.pi * length, rel=2e-3)
    ((points, _),) = flattened("M 20 0 A 20 10 0 0 1 -20 0")
    x, y = np.array(points).T
    assert (x / 20) ** 2 + (y / 10) ** 2 == pytest.approx(1.0) and y.max() == pytest.approx(10.0)
    # radii that are too small are enlarged
    ((points, _),) = flattened("M 0 0 A 1 1 0 0 1 10 0")
    assert np.hypot(*(np.array(points) - [5, 0]).T) == pytest.approx(5.0)


def test_curves_and_their_short_forms():
    """Absolute and relative commands, and smooth curves with the mirrored control point, are the same curves."""
    one = flattened("M 1 2 C 3 4 5 6 7 2 C 9 -2 11 0 12 1 Q 14 4 16 1 Q 18 -2 20 1")
    other = flattened("m1,2c2 2 4 4 6 0s4-2 5-1q2 3 4 0t4 0")
    assert np.array(one[0][0]) == pytest.approx(np.array(other[0][0]))
    # the middle of a cubic is (p0 + 3 p1 + 3 p2 + p3)/8
    assert one[0][0][8] == pytest.approx(((1 + 9 + 15 + 7) / 8, (2 + 12 + 18 + 2) / 8))
    assert flattened("M0 0 1 0 1 1Zm5 5h1V6z")[1] == ([(5, 5), (6, 5), (6, 6)], True)
    assert flattened("M0 0H1.5.5")[0][0] == [(0, 0), (1.5, 0), (0.5, 0)]


def test_texts_that_are_no_paths():
    rng = np.random.default_rng(7)
    letters = list("MmLlHhVvCcSsQqTtAaZz 0123456789.,-+eE \n")
    wrong = 0
    for _ in range(400):
        text = "M0 0" + "".join(rng.choice(letters, rng.integers(1, 40)))
        try:
            points = np.array([p for part, _ in flattened(text) for p in part]).reshape(-1, 2)
            assert points.shape[1] == 2
        except PathError:
            wrong += 1
    assert 100 < wrong < 400
    for text in ("M 1e300 0 L 0 0", "M 0 0 A 1 1 0 2 0 1 1", "M 0 0 L", "5 5", "M 0 0 Z 3"):
        with pytest.raises(PathError):
            flattened(text)


def test_damaged_annotations_are_messages():
    """Every annotation that lacks one letter of a valid one is valid, or gives a message with a place."""
    whole = 'Shape(Path(d = "M0 0h9v9z", scale = 1 mm), Line(points = {{0, 0}, {1, 0}} mm, color = {1, 2, 3}))'
    problems = []
    for k in range(len(whole)):
        try:
            parse(TEXT.format(whole[:k] + whole[k + 1 :]))
        except MbdslError as problem:
            problems.append(problem)
    assert len(problems) > 60 and all(problem.span is not None for problem in problems)
    assert shapes(whole)
