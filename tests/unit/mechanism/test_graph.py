"""The MechanismGraph: checks, counts and orders, on scenes made by hand and at random (networkx as the judge)."""

from itertools import combinations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbdsl.elements import kinds
from mbdsl.errors import ModelError, Span
from mbdsl.expressions.symbolic import coordinate
from mbdsl.lang.load import parse_text
from mbdsl.mechanism.graph import GROUND, build
from mbdsl.mechanism.graph_algorithms import Loop
from mbdsl.mechanism.scene import Component, Frame, Scene


class Mechanism:
    """A short way to make a scene: frames are made when they are named, and components get a line of their own."""

    def __init__(self):
        self.components, self.frames = {}, {}

    def add(self, name, kind, *frames, **values):
        for frame in frames:
            self.frames.setdefault(frame, Frame(frame, frame.partition(".")[0]))
        ports = dict(zip(kinds()[kind].ports, frames, strict=True))
        line = len(self.components) + 1
        span = Span("m.mbd", line, 3, len(name), f"  {name} {kind};")
        self.components[name] = Component(name, kinds()[kind], values, ports, span=span)
        return self

    def body(self, *names, kind="Rod"):
        for name in names:
            self.add(name, kind)
        return self

    def build(self):
        return build(Scene("Test", self.components, self.frames))


def mechanism(*bodies):
    return Mechanism().add("world", "Ground", g=9.81, n=(0.0, -1.0)).body(*bodies)


def chain(n):
    m = mechanism(*(f"link{i}" for i in range(n)))
    for i in range(n):
        m.add(f"J{i}", "Revolute", "world" if i == 0 else f"link{i - 1}.b", f"link{i}.a")
    return m


def slider_crank():
    m = mechanism("crank", "rod")
    m.add("O", "Revolute", "world", "crank.a")
    m.add("B", "PointOnLine", "world", "rod.b")
    m.add("A", "Revolute", "crank.b", "rod.a")
    return m.add("S", "SpringDamper", "world.w", "rod.b")


def four_bar(loops):
    m = mechanism(*(f"R{i}" for i in range(loops + 1)), *(f"C{i}" for i in range(loops)))
    for i in range(loops + 1):
        m.add(f"G{i}", "Revolute", f"world.p{i}", f"R{i}.a")
    for i in range(loops):
        m.add(f"L{i}", "Revolute", f"R{i}.b", f"C{i}.a")
        m.add(f"T{i}", "Revolute", f"C{i}.b", f"R{i + 1}.b")
    return m


def written(text):
    bodies = " ".join(f"Rod {name}(m = 1, length = 1);" for name in "abc")
    return build(parse_text(f"model M Ground ground; {bodies} {text} end M;"))


def refused(m):
    with pytest.raises(ModelError) as caught:
        m.build()
    return caught.value


# -- counts ------------------------------------------------------------------------------------------------------
def test_slider_crank_is_counted():
    g = slider_crank().build()
    assert (g.coordinates, g.rows, g.mobility, g.loops) == (6, 5, 1, 1)
    assert [p.bodies for p in g.sub_mechanisms] == [("crank", "rod")]
    assert not g.warnings


def test_each_loop_of_a_ladder_is_counted():
    g = four_bar(7).build()
    assert (g.loops, g.mobility) == (7, 1)


def test_driver_beside_its_joint_closes_no_loop_but_a_second_pin_does():
    driven = chain(1).add("D", "RotationalDriver", "world", "link0.a").build()
    assert (driven.loops, driven.mobility) == (0, 0)
    pinned = chain(1).add("P", "Revolute", "world.p", "link0.b").build()
    assert (pinned.loops, pinned.mobility) == (1, -1)
    assert "at least 1 constraint row of link0 must be redundant" in pinned.summary()


def test_parts_that_share_only_the_ground_are_independent():
    m = mechanism("a", "b", "c", "d")
    for name in "abcd":
        m.add(f"J{name}", "Revolute", "world", f"{name}.a")
    m.add("spring", "SpringDamper", "a.b", "c.b")
    m.frames["d.c"] = Frame("d.c", "d")
    m.add("torque", "Torque", "world", "b.a", tau=coordinate("d.c", "phi"))
    parts = m.build().sub_mechanisms
    assert [p.bodies for p in parts] == [("a", "c"), ("b", "d")]  # a law that reads d couples b to it
    assert [p.mobility for p in parts] == [2, 2]


@settings(derandomize=True, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=14))
def test_loops_and_parts_agree_with_networkx(pairs):
    names = [f"b{i}" for i in range(6)]
    m = mechanism(*names)
    for name in names:
        m.add(f"free_{name}", "FreeMotion", "world", f"{name}.c")
    used = [(i, j) for i, j in pairs if i != j]
    for k, (i, j) in enumerate(used):
        m.add(f"J{k}", "Revolute", *("world.c" if x == 6 else f"b{x}.c" for x in (i, j)))
    g = m.build()
    judge = nx.MultiGraph(used)
    judge.add_nodes_from(range(7))
    assert g.loops == judge.number_of_edges() - 7 + nx.number_connected_components(judge)
    judge.remove_node(6)
    assert len(g.sub_mechanisms) == nx.number_connected_components(judge)
    assert g.networkx().number_of_edges() == len(used) + 6


def test_what_networkx_finds():
    """A four-bar linkage between A and B on the ground, with a free pendulum and a body that a spring holds."""
    g = written(
        "Revolute p(ground, a.a); Revolute q(a.b, b.a); Revolute r(b.b, c.a); Revolute s(ground, c.b); "
        "RotationalDriver d(ground, a.a, phi = 2*time); Rod e(m = 1, length = 1); Revolute t(ground, e.a); "
        "Body f(m = 1, I = 1); SpringDamper k(c.c, f.c, k = 1);"
    )
    assert [e.name for e in g.cut_joints] == ["r"]
    assert g.cycles() == (Loop(("", "c", "b", "a", ""), "r"),)
    assert g.components() == [{"a", "b", "c"}, {"e"}, {"f"}]
    assert g.distances() == {"": 0, "a": 1, "b": 2, "c": 1, "e": 1, "f": 2}
    assert (g.chain("b"), g.chain("b", "e"), g.chain("f")) == (("b", "a", ""), ("b", "a", "", "e"), ())
    tree = g.spanning_tree()
    assert nx.is_arborescence(tree) and tree.edges["", "a"]["joint"] == "p" and tree.edges["c", "f"]["joint"] is None
    places = g.layout()
    assert len({x for x, _ in places.values()}) == 3 and len(set(places.values())) == 6


def test_rows_of_velocities_count_for_velocities_only():
    g = written(
        "Revolute p(ground, a.a); RotationalVelocityDriver d(p, w = 1); KnifeEdge k(c.c); RollingDisc r(ground, b.c, "
        "radius = 1); Body sky(m = 1, I = 1); VelocityConstraint v(gamma = sky.vx*sky.vy - 1); input Torque u;"
    )
    assert (g.rows, g.mobility, g.velocity_rows, g.velocity_mobility) == (3, 9, 4, 5)
    assert [(p.bodies, p.mobility, p.velocity_mobility) for p in g.sub_mechanisms] == [
        (("a",), 1, 0), (("b",), 2, 1), (("c",), 3, 2), (("sky",), 3, 2),
    ]  # fmt: skip
    assert g.loops == 0
    assert g.summary().splitlines()[1:4] == [
        "mobility 9 = 12 coordinates - 3 constraint rows (Gruebler count)",
        "mobility of velocities 5 = 9 - 4 velocity-level rows",
        "1 input: u",
    ]
    assert "  mobility 1 (0 of velocities): a" in g.summary()
    assert "  v  VelocityConstraint(sky)  0 rows, 1 velocity-level row" in g.describe()
    assert g.networkx().edges[GROUND, "sky", "v"]["velocity_rows"] == 1


def test_too_many_rows_of_velocities_are_redundant():
    held = "FreeMotion f(b.a, c.a); FreeMotion e(ground, b.a);"
    g = written(f"Revolute p(ground, a.a); RotationalVelocityDriver d(p, w = 1); KnifeEdge k(a.b); {held}")
    assert "at least 1 constraint row of a must be redundant" in g.summary()


def test_reactions_and_velocities_that_a_law_reads_couple():
    base = "Revolute p(ground, a.a); Revolute q(ground, b.a); Revolute r(ground, c.a); "
    coupled = written(base + "Torque t(q, tau = 0.1 m*p.fx);")
    assert [p.bodies for p in coupled.sub_mechanisms] == [("a", "b"), ("c",)]
    (torque,) = coupled.forces
    assert (torque.also, torque.reads) == (("a",), ("p",))
    geared = written(base + "VelocityConstraint v(gamma = a.w + b.w + c.w);")
    assert [p.bodies for p in geared.sub_mechanisms] == [("a", "b", "c")]
    driven = written(base + "RotationalVelocityDriver d(p, w = c.w);")
    assert [p.bodies for p in driven.sub_mechanisms] == [("a", "c"), ("b",)]


# -- orders ------------------------------------------------------------------------------------------------------
def test_bodies_are_placed_from_placed_ones_by_the_joint_that_fixes_most():
    tree = slider_crank().build().tree()
    assert tree == (("crank", GROUND, "O"), ("rod", "crank", "A"))


def test_body_held_by_a_spring_alone_has_no_joint_to_be_placed_by():
    tree = mechanism("a").add("s", "SpringDamper", "world", "a.b").build().tree()
    assert tree == (("a", GROUND, None),)


def fill(g):
    """Entries of the block factor's lower triangle, by plain symbolic elimination in the order given."""
    size = dict.fromkeys(g.bodies, 3) | {e.name: e.rows for e in g.joints}
    near = {name: set() for name in size}
    for e in (*g.joints, *g.forces):
        nodes = {n for n in (e.body_i, e.body_j, *e.also, e.name) if n in near}
        for n in nodes:
            near[n] |= nodes - {n}
    entries, order = 0, g.elimination_order()
    assert sorted(order) == sorted(size)
    for n in order:
        front = near.pop(n)
        entries += size[n] * (size[n] + sum(size[o] for o in front))
        for o in front:
            near[o] = (near[o] | front) - {o, n}
    return entries


@pytest.mark.parametrize("make", [chain, four_bar])
def test_fill_is_linear_in_the_number_of_parts(make):
    few, more, most = (fill(make(n).build()) for n in (10, 20, 40))
    assert most - more == 2 * (more - few)
    assert most < 45 * 40 * (1 if make is chain else 3)


def test_a_hub_with_many_arms_does_not_fill():
    m = mechanism("hub").add("J", "Revolute", "world", "hub.a")
    for i in range(30):
        m.body(f"arm{i}").add(f"P{i}", "Revolute", "hub.b", f"arm{i}.a")
    assert fill(m.build()) < 31 * 45


def triangle():
    """A loop that must not be closed on b and c alone: they would be determined twice until a is eliminated."""
    m = mechanism("a", "b", "c", "z").add("A", "Revolute", "world", "a.a")
    m.add("W", "Fixed", "world", "z.a").add("Z", "Fixed", "z.b", "c.a")
    m.add("B", "Revolute", "a.b", "b.a").add("C", "Revolute", "b.b", "c.b").body(*"defgh")
    for k, (i, j) in enumerate(combinations("adefgh", 2)):  # springs that make a the most expensive body to eliminate
        m.add(f"S{k}", "SpringDamper", f"{i}.b", f"{j}.b")
    return m


@pytest.mark.parametrize("make", [slider_crank, triangle, lambda: four_bar(4), lambda: chain(6)])
def test_block_elimination_in_this_order_needs_no_pivoting(make):
    g = make().build()
    rng = np.random.default_rng(7)
    size = dict.fromkeys(g.bodies, 3) | {e.name: e.rows for e in g.joints}
    blocks = {(n, n): np.eye(k) * (n in g.bodies) for n, k in size.items()}
    for e in g.joints:
        for body in {e.body_i, e.body_j} - {GROUND}:
            blocks[e.name, body] = rng.normal(size=(e.rows, 3))
            blocks[body, e.name] = blocks[e.name, body].T
    for n in g.elimination_order():
        pivot = blocks.pop((n, n))
        assert np.linalg.cond(pivot) < 1e6
        column = {i: blocks.pop((i, j)) for i, j in list(blocks) if j == n}
        row = {j: blocks.pop((i, j)) for i, j in list(blocks) if i == n}
        for i, left in column.items():
            for j, right in row.items():
                update = left @ np.linalg.solve(pivot, right)
                blocks[i, j] = blocks.get((i, j), np.zeros_like(update)) - update


def test_point_mass_goes_with_its_neighbour_before_their_joint():
    m = chain(1).body("p", kind="PointMass").add("L", "Distance", "link0.b", "p", length=1.0)
    order = m.build().elimination_order()
    assert order.index("L") > max(order.index("p"), order.index("link0"))


@pytest.mark.parametrize(
    ("row", "needed"),
    [
        ("KnifeEdge x(c.b)", "abc"),
        ("TranslationalVelocityDriver x(ground, c.b, v = 1)", "abc"),
        ("RotationalVelocityDriver x(b.b, c.a, w = 1)", "bc"),
        ("RotationalVelocityDriver x(ground, a.a, w = 2*c.w)", "abc"),
        ("VelocityConstraint x(gamma = c.w)", "abc"),
        ("VelocityConstraint x(gamma = b.w - 1)", "ab"),
    ],
)
def test_rows_of_velocities_come_after_all_bodies_that_they_see_move(row, needed):
    """Otherwise they may vanish with the other bodies held: a blade at the end of the last link, across the link."""
    chain = "Revolute p(ground, a.a); Revolute q(a.b, b.a); Revolute r(b.b, c.a); "
    order = written(f"{chain} {row}; Torque t(p, tau = 0.1 m*r.fx);").elimination_order()
    assert sorted(order) == sorted("abcpqrx")
    assert all(order.index("x") > order.index(body) for body in needed)


def test_disc_and_its_contact_go_together():
    g = written("RollingDisc x(ground, a.c, radius = 1); FreeMotion f(ground, b.c); FreeMotion e(ground, c.c);")
    order = g.elimination_order()
    assert order.index("x") > order.index("a")
    assert g.tree()[0] == ("a", GROUND, "x")


def test_a_long_chain_is_no_recursion_and_no_square():
    g = chain(4096).build()
    assert len(g.elimination_order()) == 8192
    assert fill(g) < 45 * 4096
    assert [p.body for p in g.tree()] == list(g.bodies)
    assert g.loops == 0 and len(g.sub_mechanisms) == 1
    assert "link4095" in g.describe()


# -- refused scenes -----------------------------------------------------------------------------------------------
def test_floating_body_is_named_with_its_place_and_the_ways_out():
    assert refused(chain(1).body("other")).render() == (
        "m.mbd:4:3: error: body `other` has no path to ground: no joint or force holds it\n"
        "      other Rod;\n"
        "      ^^^^^\n"
        "  = add a joint or a force; if it is meant to fly:  FreeMotion free(world, other.c);"
    )


def test_every_floating_group_is_told():
    error = refused(chain(1).body("a", "b", "c").add("s", "SpringDamper", "a.b", "b.a"))
    assert "bodies a, b have no path to ground" in error.message
    assert [text for text, _ in error.notes] == ["body `c` has no path to ground: no joint or force holds it"]


def test_floating_point_mass_is_its_own_frame():
    assert refused(chain(1).body("p", kind="PointMass")).hint.endswith("FreeMotion free(world, p);")


@pytest.mark.parametrize(("kind", "frames"), [("FreeMotion", ("world", "a.c")), ("Force", ("world", "a.b"))])
def test_free_motion_and_forces_hold(kind, frames):
    g = mechanism("a").add("F", kind, *frames).build()
    assert (g.mobility, g.loops) == (3, 0)


def test_follower_force_has_both_ends_on_one_body():
    g = chain(1).add("F", "Force", "link0.b", "link0.b").build()
    assert g.mobility == 1 and not g.warnings


def test_follower_force_alone_holds_nothing():
    assert "no path to ground" in refused(mechanism("a").add("F", "Force", "a.b", "a.b")).message


def test_no_ground():
    assert "has no Ground" in refused(Mechanism().body("a")).message


def test_no_bodies():
    error = refused(mechanism())
    assert "has no bodies" in error.message and error.span.line == 1


def test_a_body_held_by_a_law_of_its_velocity_flies_on_purpose_and_one_without_does_not():
    text = "Revolute p(ground, a.a); VelocityConstraint v(gamma = b.w + c.w); KnifeEdge k(b.c);"
    assert {p.body: p.joint for p in written(text).tree()} == {"a": "p", "b": None, "c": None}
    with pytest.raises(ModelError, match="body `c` has no path to ground"):
        written("Revolute p(ground, a.a); KnifeEdge k(b.c);")


def test_velocity_constraint_of_what_stands_still():
    with pytest.raises(ModelError, match="`v` depends on no body: nothing in its expression can move"):
        written("Fixed e(ground, a.a); Fixed f(a.b, b.a); Fixed g(b.b, c.a); VelocityConstraint v(gamma = ground.w);")


def test_the_same_velocity_driver_twice():
    (warning,) = written(
        "Revolute p(ground, a.a); Fixed f(a.b, b.a); Fixed g(b.b, c.a); "
        "RotationalVelocityDriver d(p, w = 1); RotationalVelocityDriver e(p, w = 1);"
    ).warnings
    assert "repeats `d`" in warning.message


def test_grounds_that_disagree():
    error = refused(chain(1).add("moon", "Ground", g=1.62, n=(0.0, -1.0)))
    assert "`world` and `moon` disagree about gravity" in error.message
    assert chain(1).add("again", "Ground", g=9.81, n=(0.0, -1.0)).build().mobility == 1


@pytest.mark.parametrize("frames", [("link0.a", "link0.b"), ("world.a", "world.b")])
def test_joint_of_a_body_with_itself(frames):
    error = refused(chain(1).add("J", "Revolute", *frames))
    assert "joins" in error.message and "to itself" in error.message and error.span.line == 4


# -- suspicious, but not refused -------------------------------------------------------------------------------------
def test_the_same_joint_twice():
    (warning,) = chain(1).add("again", "Revolute", "link0.a", "world").build().warnings
    assert warning.render().startswith("m.mbd:4:3: warning: Revolute `again` repeats `J0`: same frames, same values")


def test_spring_that_moves_nothing():
    (warning,) = chain(1).add("s", "SpringDamper", "link0.a", "link0.b").build().warnings
    assert "cannot move anything" in warning.message


def test_description_tells_the_structure():
    assert (
        slider_crank().build().describe()
        == """\
Test: 2 bodies, 3 joints, 1 force, 1 independent loop
mobility 1 = 6 coordinates - 5 constraint rows (Gruebler count)

bodies
  crank  Rod  x, y, phi
  rod  Rod  x, y, phi

joints
  O  Revolute(world, crank.a)  2 rows
  B  PointOnLine(world, rod.b)  1 row  closes a loop
  A  Revolute(crank.b, rod.a)  2 rows

forces
  S  SpringDamper(world.w, rod.b)

placed from the ground
  crank  by O, from world
  rod  by A, from crank"""
    )
