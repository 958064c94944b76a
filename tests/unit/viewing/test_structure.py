"""The graph of a mechanism: loops against networkx, merged, driven and redundant parts; layout, picture and text."""

import itertools
import json
import re
from xml.etree import ElementTree

import networkx
import numpy as np
import pytest

from mbdsl import load, parse
from mbdsl.errors import UsageError
from mbdsl.mechanism.graph import GROUND, build
from mbdsl.messages import shortened
from mbdsl.viewing import structure_layout
from mbdsl.viewing.structure import structure
from mbdsl.viewing.structure_files import page, save
from mbdsl.viewing.structure_layout import ROW, layout, spread
from mbdsl.viewing.structure_svg import svg
from mbdsl.viewing.structure_text import text

SCISSOR = """model Scissor "Twelve stages" parameter Integer n = 12; Ground ground;
  Rod l[n](each m = 1 kg, each length = 1 m); Rod r[n](each m = 1 kg, each length = 1 m);
  Body plate(m = 1 kg, I = 1 kg.m2, frames(p = {0, 0}));
  Revolute O(ground, l[1].a); PointOnLine S(ground, r[1].a);
  for k in 1:n loop Revolute M[k](l[k].c, r[k].c); end for;
  for k in 2:n loop Revolute A[k](l[k-1].b, r[k].a); Revolute B[k](r[k-1].b, l[k].a); end for;
  Revolute T(l[n].b, plate.p); PointOnLine W(plate.p, r[n].b); end Scissor;"""
CHAIN = """model Chain parameter Integer n = 50; Ground ground; Rod link[n](each m = 1 kg, each length = 1 m);
  Revolute J1(ground, link[1].a); for k in 2:n loop Revolute J[k](link[k-1].b, link[k].a); end for;
  SpringDamper far(link[3].b, link[40].b, k = 1 N/m, s0 = 1 m); SpringDamper near(ground, link[20].b, k = 1 N/m);
  end Chain;"""
STAR = """model Star Ground ground; Body hub(m = 1 kg, I = 1 kg.m2); Revolute O(ground, hub.c);
  Rod a_spoke_with_a_long_name[50](each m = 1 kg, each length = 1 m);
  for k in 1:50 loop Revolute J[k](hub.c, a_spoke_with_a_long_name[k].a); end for; end Star;"""
WELDED = """model Welded Ground ground; Rod arm(m = 1 kg, length = 1 m); Rod base(m = 1 kg, length = 1 m);
  Body plate(m = 1 kg, I = 1 kg.m2); Body tool(m = 1 kg, I = 1 kg.m2); PointMass ball(m = 1 kg);
  Fixed wall(ground, base.a); Revolute O(ground, arm.a); RotationalDriver d(ground, arm.a, phi = 2*time);
  Revolute A(arm.b, plate.c); Fixed W(plate.c, tool.c); SpringDamper s(tool.c, base.b, k = 1 N/m);
  SpringDamper hang(tool.c, ball.c, k = 10 N/m, s0 = 0.1 m); end Welded;"""
PARTS = """model Parts Ground ground; Rod p[7](each m = 1 kg, each length = 1 m);
  for k in 1:7 loop Revolute J[k](ground, p[k].a); end for; end Parts;"""


def width_of(found):
    return float(re.search(r'viewBox="0 0 ([\d.]+)', svg(found))[1])


def of(model):
    return structure(build(parse(model)), search=False)


@pytest.fixture(scope="module", params=["seven_body", "four_bar", "driven_crank", SCISSOR, CHAIN, STAR, WELDED, PARTS])
def found(request, model_file):
    if request.param.startswith("model"):
        return of(request.param)
    return structure(build(load(model_file(request.param))), search=False)


def test_loops_are_independent_cycles(found):
    """Each follows joints, and their number and rank is that of the cycle space of the graph, by networkx."""
    joints = [link for link in found.links if link.role == "joint" and link.rows]
    graph = networkx.MultiGraph()
    graph.add_nodes_from([GROUND, *found.bodies])
    graph.add_edges_from((link.a, link.b, link.name) for link in joints)
    simple = networkx.Graph(graph)
    rank = graph.number_of_edges() - graph.number_of_nodes() + networkx.number_connected_components(graph)
    rows = []
    for loop in found.loops:
        assert loop.bodies[0] == loop.bodies[-1] and len(set(loop.bodies)) == len(loop.bodies) - 1
        assert all(simple.has_edge(a, b) for a, b in itertools.pairwise(loop.bodies))
        steps = list(itertools.pairwise(loop.bodies))
        rows.append([steps.count(edge) - steps.count(edge[::-1]) for edge in simple.edges])
    assert len(found.loops) == rank
    assert not rows or np.linalg.matrix_rank(np.array(rows, float)) == rank
    assert [link.loop for link in found.links if link.loop] == sorted(link.loop for link in found.links if link.loop)


def test_loops_are_short():
    """Neighbouring stages of a scissor lift form a loop of four bars."""
    loops = of(SCISSOR).loops
    assert [len(set(loop.bodies)) for loop in loops] == [3] + 11 * [4] + [3]


def test_distances_from_the_ground(found):
    """Those of networkx over joints; every joint connects neighbouring columns."""
    graph = networkx.Graph()
    graph.add_edges_from((link.a, link.b) for link in found.links if link.role == "joint" and link.rows)
    expected = networkx.single_source_shortest_path_length(graph, GROUND)
    assert {body: found.levels[body] for body in expected} == expected
    for link in found.links:
        assert link.role == "force" or abs(found.levels[link.a] - found.levels[link.b]) <= 1


def test_what_is_merged_driven_and_held_by_forces():
    found = of(WELDED)
    bodies = found.bodies
    assert [name for name, body in bodies.items() if body.moved] == ["arm"]
    assert [name for name, body in bodies.items() if body.fixed] == ["base"]
    assert [name for name, body in bodies.items() if body.group == 1] == ["plate", "tool"]
    assert found.by["ball"] is None and found.levels["ball"] == found.levels["tool"] + 1
    assert found.remarks == (
        "d moves arm: a known function of time",
        "base is part of the ground, welded by wall",
        "plate, tool are solved as one body: W joins them",
    )


def test_bodies_that_follow(model_file):
    found = structure(build(load(model_file("driven_crank"))), search=False)
    assert [name for name, body in found.bodies.items() if body.follows] == ["rod", "slider"]
    assert found.remarks[0].startswith("drive moves crank")


def test_redundant_joints(model_file):
    """The third of three parallel rockers: one of its two rows follows from the others."""
    found = structure(build(load(model_file("hard/spare_rocker"))))
    assert {link.name: link.redundant for link in found.links if link.redundant} == {"A3": 1}
    assert any(line.startswith("redundant: Revolute A3") for line in found.remarks)
    assert "redundant: 1 of 2" in svg(found)
    assert "1 row redundant" in text(found)


# -- layout ------------------------------------------------------------------------------------------------------------
def test_places_do_not_overlap(found):
    """Nodes with their labels have columns of their own and are a row apart; columns and parts do not meet."""
    boxes = []
    for block in layout(found):
        for node in block.nodes:
            x, y = block.x + node.x, block.y + node.y
            boxes.append((x - node.width / 2, y - ROW / 2 + 1e-6, x + node.width / 2, y + ROW / 2 - 1e-6))
            assert block.down or node.width / 2 <= node.reach
    for a, b in itertools.combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_wide_graphs_go_down(found):
    """A page shows the picture without a scroll bar, whatever the number of bodies in a row."""
    assert width_of(found) < 1.4 * structure_layout.WIDTH
    assert [block.down for block in layout(found)] == [len(found.bodies) in (25, 50)] * len(found.parts)


def test_a_line_over_several_layers_has_places_in_them():
    """A spring between the ends of a chain: lines connect neighbouring layers only."""
    for block in layout(of(CHAIN)) + layout(of(WELDED)):
        assert all(abs(block.nodes[a].layer - block.nodes[b].layer) == 1 for a, b in block.lines)


def test_lines_of_a_tree_do_not_cross():
    """Drawn lines between two columns keep their order from column to column."""
    (block,) = layout(of(STAR))
    lines = [sorted((block.nodes[a], block.nodes[b]), key=lambda node: node.layer) for a, b in block.lines]
    for (a, b), (c, d) in itertools.combinations(lines, 2):
        assert a.layer != c.layer or (a.y - c.y) * (b.y - d.y) >= 0.0


def test_places_of_a_layer_are_near_the_wanted_ones():
    rng = np.random.default_rng(3)
    wanted = rng.normal(size=40) * 100
    assert np.diff(spread(wanted.tolist(), 5.0)).min() >= 5.0 - 1e-9
    assert spread(sorted(10.0 * wanted), 1e-9) == sorted(10.0 * wanted)  # free of each other: where they want to be


# -- picture and text --------------------------------------------------------------------------------------------------
def test_the_picture_has_all_names(found):
    root = ElementTree.fromstring(svg(found))
    words = [element.text or element[0].tail for element in root.iter("{http://www.w3.org/2000/svg}text")]
    for name in (*found.bodies, *(link.name for link in found.links)):
        shown = shortened(name, structure_layout.LETTERS)
        assert shown in words and len(shown) <= structure_layout.LETTERS
    titles = {element.text for element in root.iter("{http://www.w3.org/2000/svg}title")}
    assert f"Graph of {found.name}" in titles
    assert all(any(title.endswith(f" {body}") for title in titles) for body in found.bodies)
    description = next(root.iter("{http://www.w3.org/2000/svg}desc")).text
    assert found.summary.splitlines()[0] in description


@pytest.mark.parametrize("columns", [80, 60])
def test_the_text_fits_the_terminal(found, columns):
    """Every body has one line with its joint, and every other joint and force one."""
    lines = text(found, columns).splitlines()
    assert max(map(len, lines)) <= columns
    tree = [line.lstrip("│├└─ ") for line in lines if re.search("[├└]─", line)]
    first = [line.split("  ")[0].split(" (")[0] for line in tree if line != "..."]
    others = [link for link in found.links if link.name not in found.by.values()]
    signs = {"force": "~", "driver": ">", "joint": "o"}
    assert sorted(first) == sorted([*found.bodies, *(f"{signs[link.role]} {link.name}" for link in others)])
    assert text(found, columns, ascii_only=True).isascii()


def test_the_picture_of_the_docs(model_file):
    """It is the one that the command writes."""
    stored = model_file("seven_body").parents[1] / "docs" / "seven_body_graph.svg"
    assert stored.read_text(encoding="utf-8") == svg(structure(build(load(model_file("seven_body"))), search=False))


def test_a_hostile_text_is_a_text():
    evil = "</title><script>alert(1)</script>\u202e"
    found = of(
        f"model A {json.dumps(evil, ensure_ascii=False)} Ground g; PointMass m(m = 1 kg); FreeMotion f(g, m); end A;"
    )
    assert "<script>" not in page(found) and "\u202e" not in page(found)


def test_files(tmp_path):
    found = of(WELDED)
    for suffix, start in (("svg", b"<svg"), ("html", b"<!DOCTYPE"), ("png", b"\x89PNG"), ("pdf", b"%PDF")):
        save(found, tmp_path / f"a.{suffix}")
        assert (tmp_path / f"a.{suffix}").read_bytes().startswith(start)
    with pytest.raises(UsageError, match=r"unknown suffix `\.dot`"):
        save(found, tmp_path / "a.dot")


def test_pixels_of_the_picture_are_where_its_bodies_are(tmp_path):
    """In the PNG, the border of each box has the colour of a body that is moved, or of the ink."""
    from PIL import Image

    found = of(WELDED)
    save(found, tmp_path / "a.png")
    image = Image.open(tmp_path / "a.png").convert("RGB")
    scale = image.width / width_of(found)
    bounds = {}
    for path, name in re.findall(r'<path class="body[^"]*" d="([^"]+)"><title>\w+ (\w+)<', svg(found)):
        points = np.array([pair.split() for pair in re.findall(r"[\d.]+ [\d.]+", path)], float)
        bounds[name] = points.min(axis=0), points.max(axis=0)
    assert set(bounds) == set(found.bodies)
    for name, (low, high) in bounds.items():
        x, y = scale * low[0], scale * (low[1] + high[1]) / 2
        near = {image.getpixel((round(x) + dx, round(y - 14 * scale))) for dx in (-2, -1, 0, 1, 2)}
        red = [r - b for r, g, b in near if r + g + b < 600]
        assert red and (max(red) > 100) == (name == "arm")


def test_the_command(say, tmp_path):
    (tmp_path / "w.mbd").write_text(WELDED)
    code, out, _ = say("graph", "w.mbd", "--quick")
    assert code == 0 and "└─ base  by wall (Fixed)  [part of the ground]" in out
    assert say("graph", "w.mbd", "--quick", "--out", "w.svg")[:2] == (
        0,
        "w.svg: 5 bodies, 5 joints, 2 forces, 0 independent loops\n",
    )
    code, _, err = say("graph", "w.mbd", "--out", "w.dot")
    assert code == 2 and "known suffixes are .svg, .html, .png, .pdf" in err
    (tmp_path / "w.svg").write_text(WELDED)
    code, _, err = say("graph", "w.svg", "--quick", "--out", "w.svg")
    assert code == 2 and (tmp_path / "w.svg").read_text() == WELDED


def test_the_page_in_a_browser(browser, tmp_path):
    """Texts overlap neither each other nor a box of another body, at three widths; the page is silent."""
    save(of(SCISSOR), tmp_path / "a.html")
    ink = []
    for width, scheme in ((400, "light"), (800, "dark"), (1400, "light")):
        browser.open(tmp_path / "a.html", width, 800, scheme)
        boxes = browser.value(
            "[...document.querySelectorAll('.graph text:not(.number)')].map((e) => { const b = e.getBBox();"
            " return [e.textContent, b.x, b.y + 0.2 * b.height, b.x + b.width, b.y + 0.9 * b.height]; })"
        )
        assert len(boxes) > 2 * 63
        for (_, *a), (_, *b) in itertools.combinations(boxes, 2):
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
        assert browser.value("document.documentElement.scrollWidth") == width
        assert browser.said == [] and browser.loaded == [(tmp_path / "a.html").as_uri()]
        ink.append(browser.value("getComputedStyle(document.querySelector('.graph text.name')).fill"))
    assert ink == ["rgb(31, 35, 40)", "rgb(230, 233, 238)", "rgb(31, 35, 40)"]
