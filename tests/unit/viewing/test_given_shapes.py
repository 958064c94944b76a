"""Shapes of the model in pages and films: pixels against the motion, colours, and the drawings that they replace."""

import numpy as np
import pytest

from mbdsl import parse
from mbdsl.viewing.motion import motion
from mbdsl.viewing.shapes import drawing

#: a disc of 20 cm with a red spot of 4 cm at (30 cm, 10 cm) from its reference point, which is not its centre of mass
TEXT = """model Spot
  Ground ground annotation(Shape(Rectangle(extent = {{-1, -1}, {1, -0.9}}, fillColor = "#123456", lineColor = "none")));
  Body disc(m = 1 kg, I = 1 kg.m2, com = {0.2, 0}) annotation(Shape(Circle(radius = 20 cm),
    Circle(center = {30, 10} cm, radius = 4 cm, fillColor = "#ff0000", lineColor = "#ff0000"),
    Path(d = "M 30 -50 h 20 v 20 h -20 z M 35 -45 h 10 v 10 h -10 z", scale = 1 cm, fillColor = "#00ff00",
      lineColor = "none")));
  FreeMotion free(ground, disc.c);
end Spot;"""
PLACES = """(([r, g, b]) => {
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  let [n, x, y] = [0, 0, 0];
  for (let k = 0; k < width * height; k += 1)
    if (data[4 * k] === r && data[4 * k + 1] === g && data[4 * k + 2] === b)
      [n, x, y] = [n + 1, x + (k % width) + 0.5, y + Math.floor(k / width) + 0.5];
  return [x / n, y / n, n];
})"""


@pytest.fixture(scope="module")
def turning(trajectory_of):
    """The centre of mass moves on a line while the body turns."""
    t = np.linspace(0.0, 1.0, 11)
    return trajectory_of(parse(TEXT), t, {"disc": np.column_stack([0.3 * t, 0.1 * t, 2.0 * t])})


def expected(t, x, y):
    """The position of a point at (x, y) from the reference point, (x - 0.2, y) from the centre of mass."""
    c, s = np.cos(2 * t), np.sin(2 * t)
    return 0.3 * t + c * (x - 0.2) - s * y, 0.1 * t + s * (x - 0.2) + c * y


def test_pixels_of_the_page(browser, turning, tmp_path):
    turning.animate(tmp_path / "page.html")
    browser.open(tmp_path / "page.html")
    assert browser.said == []
    for part in (0.0, 0.5, 1.0):
        browser.scrub(part)
        state = browser.state()
        for colour, place, area in (([255, 0, 0], (0.3, 0.1), np.pi * 0.04**2), ([0, 255, 0], (0.4, 0.4), 0.03)):
            x, y, count = browser.value(f"{PLACES}({colour})")
            px, py = expected(state["time"], *place)
            assert x == pytest.approx(state["x"] + state["scale"] * px, abs=1.0)
            assert y == pytest.approx(state["y"] - state["scale"] * py, abs=1.0)
            # pixels on the edge are mixed: at most those of a line around the area, of 1.0 m for the square with a hole
            assert count == pytest.approx(area * state["scale"] ** 2, abs=1.3 * 1.2 * state["scale"])


def test_pixels_of_a_film(turning):
    pytest.importorskip("PIL")
    from mbdsl.viewing.picture import Picture

    moving = motion(turning)
    picture = Picture(moving, drawing(moving), 500, 400)
    for row in (0, 7):
        image = np.asarray(picture.frame(row), int)
        for colour, place in (((255, 0, 0), (0.3, 0.1)), ((0, 255, 0), (0.4, 0.4))):
            y, x = np.nonzero((image == colour).all(axis=-1))
            px, py = expected(0.1 * row, *place)
            assert len(x) > 30
            assert x.mean() + 0.5 == pytest.approx(picture.left + picture.scale * px, abs=1.0)
            assert y.mean() + 0.5 == pytest.approx(picture.top - picture.scale * py, abs=1.0)
        # the hole of the square is paper
        px, py = expected(0.1 * row, 0.4, 0.4)
        at = round(picture.top - picture.scale * py), round(picture.left + picture.scale * px)
        assert image[at].tolist() == [255, 255, 255]


def test_what_shapes_replace(turning, trajectory_of):
    """They replace the drawing of the body, are inside the picture, and lie over those of the ground."""
    drawn = drawing(motion(turning))
    assert [s.draw for s in drawn.shapes] == ["backdrop", "outline", "outline", "outline"]
    x0, y0, x1, y1 = drawn.bounds
    assert (x0, y0, x1) == pytest.approx((-1.0, -1.0, 1.0)) and y1 > 0.5
    hidden = parse(
        TEXT.replace("Circle(radius = 20 cm)", "").partition("annotation(Shape(,")[0] + "annotation(Shape());"
        " FreeMotion free(ground, disc.c); end Spot;"
    )
    still = motion(trajectory_of(hidden, [0.0], {"disc": np.zeros((1, 3))}))
    assert [s.draw for s in drawing(still).shapes] == ["backdrop"]


def test_sliders_and_wheels_with_shapes(trajectory_of):
    scene = parse("""model S Ground ground; Body car(m = 1 kg, I = 1 kg.m2) annotation(Shape(Circle(radius = 1)));
      Body wheel(m = 1 kg, I = 1 kg.m2); Prismatic way(ground, car.c); RollingDisc roll(ground, wheel.c, radius = 1);
      end S;""")
    shapes = drawing(motion(trajectory_of(scene, [0.0], {"car": np.zeros((1, 3)), "wheel": np.zeros((1, 3))}))).shapes
    assert sorted(s.draw for s in shapes) == ["floor", "guide", "outline", "wheel"]


def test_a_beam_keeps_its_axis(trajectory_of):
    scene = parse("""model B Ground ground; FlexibleBeam beam(length = 2 m, density = 7800, S = 1 cm2, I = 1 cm4,
      E = 210 GPa, modes = 1) annotation(Shape(Circle(center = {0, 1}, radius = 1))); FreeMotion f(ground, beam.c);
      end B;""")
    shapes = drawing(motion(trajectory_of(scene, [0.0], {"beam": np.array([[5.0, 0.0, 0.0, 0.0]])}))).shapes
    assert [s.draw for s in shapes] == ["outline", "beam"]
    assert shapes[0].at[0].track >= 0
