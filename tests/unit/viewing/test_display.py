"""Display lists: the canvas of pages and the pictures of Python place every item alike, in the same colours."""

import re
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import load, parse
from mbdsl.viewing.display import ALONG, Circle, DrawnPath, Size
from mbdsl.viewing.marks import THEME, DiscMark, LineMark
from mbdsl.viewing.motion import motion
from mbdsl.viewing.picture import Picture
from mbdsl.viewing.shapes import drawing
from mbdsl.viewing.writers import svg_element

#: every way to place a path: fixed and moving frames, lines between two, turned ones, one frame a point, curves
ALL = """model All Ground ground(n = {0, -1});
  Rod arm(m = 1 kg, length = 1 m); Body disc(m = 1 kg, I = 1 kg.m2); Body cart(m = 1 kg, I = 1 kg.m2);
  PointMass ball(m = 1 kg);
  Revolute pin(ground, arm.a); RollingDisc roll(ground, disc.c, radius = 0.2 m); Prismatic way(ground, cart.c);
  SpringDamper s(ground, cart.c, k = 1 N/m, c = 1 N.s/m); RotationalSpringDamper w(ground, arm.a, k = 1 N.m/rad);
  Distance d(arm.b, ball, length = 1 m); BeltDrive belt(arm.b, disc.c, r_a = 0.1 m, r_b = 0.2 m);
end All;"""


def test_the_canvas_and_pictures_place_points_alike(browser, trajectory_of, tmp_path):
    """All points of all items in the view of the page, at a time between the first and the last."""
    t = np.linspace(0.0, 1.0, 11)
    run = trajectory_of(
        parse(ALL),
        t,
        {
            "arm": np.column_stack([0.5 * np.cos(t), 0.5 * np.sin(t), t]),
            "disc": np.column_stack([1.0 + t, 0.2 + 0 * t, -5 * t]),
            "cart": np.column_stack([2.0 + 0.5 * t, 0 * t, 0 * t]),
            "ball": np.column_stack([np.cos(t) + 0.6, np.sin(t) - 0.8]),
        },
    )
    run.animate(tmp_path / "page.html")
    browser.open(tmp_path / "page.html")
    browser.scrub(0.7)
    view = browser.value("({ ...view, U: painter.U })")
    moving = motion(run)
    picture = Picture(moving, drawing(moving), 400, 300)
    picture.row, picture.scale, picture.left, picture.top = 7, view["scale"], view["x"], view["y"]
    picture.U = view["U"]
    paths = [item for item in picture.items if isinstance(item, DrawnPath)]
    assert {path.axes for path in paths} == {"own", "turned", "along", "on"}
    found = browser.value(
        "data.items.filter((item) => !item.radius).map((item) => painter.points(item).map((p) => p.slice(0, 2)))"
    )
    for path, points in zip(paths, found, strict=True):
        # the page stores 32-bit numbers of about 2 m, at some hundred pixels a metre
        assert np.array(points) == pytest.approx(picture._points(path), abs=1e-3)
    rounds = [picture.length(item.radius) for item in picture.items if isinstance(item, Circle)]
    assert rounds == pytest.approx(
        browser.value("data.items.filter((x) => x.radius).map((x) => painter.length(x.radius))")
    )


def test_pictures_have_the_colours_of_pages():
    """The light colours of the style sheet."""
    sheet = (Path(mbdsl.__file__).parent / "viewing" / "player.css").read_text(encoding="utf-8")
    light = dict(re.findall(r"--(\w+): (#\w+);", sheet.partition("@media")[0]))
    assert {name: light.get(name) for name in THEME} == THEME


def test_a_piston_is_at_the_part_of_its_stroke(trajectory_of):
    """A damper between 1 m and 3 m: at 2 m its piston is half of 1.8 units further than at 1 m, beside the cylinder."""
    scene = parse(
        "model A Ground g; PointMass m(m = 1 kg); SpringDamper d(g, m, c = 1 N.s/m); FreeMotion f(g, m); end A;"
    )
    x = np.array([1.0, 2.0, 3.0])
    moving = motion(trajectory_of(scene, x, {"m": np.column_stack([x, 0 * x])}))
    picture = Picture(moving, drawing(moving), 900, 300)
    piston = next(item for item in picture.items if isinstance(item, DrawnPath) and item.axes == ALONG and item.state)
    places = []
    for row in range(3):
        picture.row = row
        places.append(picture._points(piston)[0, 0] - picture.left - 0.25 * picture.scale * x[row])
    assert np.diff(places) == pytest.approx([0.9 * picture.U] * 2)


def test_sizes_are_limited_in_pixels(slider_crank):
    moving = motion(slider_crank)
    picture = Picture(moving, drawing(moving), 400, 300)
    assert picture.length(Size(least=5.0)) == 5.0
    assert picture.length(Size(1.0, 2.0, 3.0)) == 2.0 * picture.U + 3.0 * picture.scale


def test_elements_of_svg():
    line = LineMark([np.array([[0.0, 0.0], [1.0, 2.0]])], "#123456", 1.0)
    assert svg_element(line) == '<path fill="none" stroke="#123456" stroke-width="1.00" d="M0.00 0.00L1.00 2.00"/>'
    assert (
        svg_element(DiscMark(1.0, 2.0, 3.0, "#ffffff", None, 1.0))
        == '<circle fill="#ffffff" cx="1.00" cy="2.00" r="3.00"/>'
    )


def test_links_of_large_models_are_lines(model_file, trajectory_of):
    """Their list has one item a link and one a pin."""
    count = 400
    scene = load(model_file("chain"), {"N": count})
    states = {f"link[{k + 1}]": np.array([[k + 0.5, 0.0, 0.0]]) for k in range(count)}
    shapes = drawing(motion(trajectory_of(scene, [0.0], states))).shapes
    links = [shape for shape in shapes if shape.draw == "link"]
    assert len(links) == count and {item.stroke for shape in links for item in shape.items} == {"s0"}
