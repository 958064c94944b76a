"""Pages of models in space as texts: their data against the motion, their solids, their policy and their library."""

import base64
import hashlib
import json
import re
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import load, parse
from mbdsl.viewing import page
from mbdsl.viewing.motion import motion
from mbdsl.viewing.page import LIBRARY
from mbdsl.viewing.space.shapes import drawing
from mbdsl.viewing.tracks import rotated
from mbdsl.viewing.vectors import loads, vectors

SPACE = Path(__file__).parents[3] / "models" / "space"


def parts(text):
    """The data, the scripts and the policy of a page."""
    data = json.loads(text.partition('id="data">')[2].partition("</script>")[0])
    scripts = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    return data, scripts, re.search(r'Security-Policy" content="([^"]*)"', text)[1].replace("&#x27;", "'")


def array(stored):
    return np.frombuffer(base64.b64decode(stored["data"]), f"<{stored['kind']}")


def solids_of(text, states=None, trajectory_of=None):
    scene = parse(text)
    names = {c.name: np.zeros((1, len(c.kind.coordinates))) for c in scene.bodies()}
    found = motion(trajectory_of(scene, [0.0], names | (states or {})))
    return drawing(found)


def test_the_data_are_the_motion(arm_in_space):
    """Positions and quaternions of the arm at the angle 2 t about z, (cos t, 0, 0, sin t) up to the sign."""
    data, _, _ = parts(arm_in_space.animate().html)
    t = array(data["t"])
    np.testing.assert_array_equal(t, arm_in_space.t)
    poses = array(data["poses"]).reshape(len(t), 2, 7).astype(float)
    assert data["tracks"] == ["arm", "ball"]
    # 32-bit numbers of at most 1.2: half a unit in the last place is 2^-24
    expected = np.column_stack([0.5 * np.cos(2 * t), 0.5 * np.sin(2 * t), 0 * t])
    assert np.abs(poses[:, 0, :3] - expected).max() <= 2**-24
    ball = np.column_stack([np.cos(t), np.sin(t), 0.3 * t])
    assert np.abs(poses[:, 1, :3] - ball).max() <= 2**-23
    sign = np.sign(poses[:, 0, 3] * np.cos(t) + poses[:, 0, 6] * np.sin(t))
    turn = np.column_stack([np.cos(t), 0 * t, 0 * t, np.sin(t)])
    assert np.abs(poses[:, 0, 3:] * sign[:, None] - turn).max() <= 2**-23
    np.testing.assert_array_equal(poses[:, 1, 3:], np.tile([1.0, 0, 0, 0], (len(t), 1)))


def test_large_models_are_stored_as_integers(arm_in_space, monkeypatch):
    monkeypatch.setattr(page, "MANY", 1000)
    data, _, _ = parts(arm_in_space.animate().html)
    length, angle = data["poses"]["scale"]
    poses = array(data["poses"]).reshape(-1, 2, 7) * np.repeat([length, angle], [3, 4])
    assert data["poses"]["kind"] == "i2"
    t = arm_in_space.t
    # half a level of the largest coordinate, and a half for its rounding to nine digits
    assert np.abs(poses[:, 1, 2] - 0.3 * t).max() <= 0.51 * length
    assert length == pytest.approx(np.abs(data["bounds"]).max() / 32767, rel=1e-8)
    assert np.abs(np.abs(poses[:, 0, 6]) - np.abs(np.sin(t))).max() <= 0.51 / 32767


def test_positions_far_from_the_origin_keep_their_digits(trajectory_of):
    scene = parse("spatial model A Ground ground(g = 0); PointMass m(m = 1 kg); FreeMotion f(ground, m); end A;")
    x = 1e6 + np.linspace(0, 1e-3, 11)
    data, _, _ = parts(trajectory_of(scene, np.arange(11.0), {"m": np.column_stack([x, 0 * x, 0 * x])}).animate().html)
    found = array(data["poses"]).reshape(11, 7)[:, 0] + data["origin"][0]
    np.testing.assert_allclose(found, x, atol=1e-8)


def test_the_policy_allows_the_library_and_the_script_only(arm_in_space):
    text = arm_in_space.animate().html
    _, scripts, policy = parts(text)
    allowed = [base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for s in scripts]
    assert len(scripts) == 2 and scripts[0] == LIBRARY.read_text(encoding="utf-8")
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'"
    assert rules["script-src"] == " ".join(f"'sha256-{digest}'" for digest in allowed)
    assert set(rules) == {"default-src", "style-src", "script-src"}


def test_the_page_loads_nothing(arm_in_space):
    """The only address is the name of a namespace; the licence of the library is in the page."""
    text = arm_in_space.animate().html
    assert set(re.findall(r"https?://[^\s\"'`<)]*", text)) <= {"http://www.w3.org/1999/xhtml"}
    assert not re.search(r"@import|url\(|\beval\(|new Function", text)
    assert "SPDX-License-Identifier: MIT" in text
    assert "three.js" in (LIBRARY.parent / "LICENSE").read_text(encoding="utf-8")
    # 0.6 MB are the library
    assert len(text.encode()) < 800_000


def test_pages_of_planar_models_do_without_the_library(slider_crank):
    assert "WebGLRenderer" not in slider_crank.animate().html


@pytest.fixture(scope="module")
def bicycle():
    return drawing(motion(mbdsl.simulate(SPACE / "bicycle.mbd", stop=2.0, step=0.01)))


def test_far_reaching_motions_are_followed(bicycle, arm_in_space):
    """The bicycle rides 10 m, and is 1.7 m long; the camera follows the rider, the heaviest body."""
    drawn = bicycle
    assert drawn.followed == "rider"
    assert 1.02 + 0.3 + 0.35 < drawn.size < 2.2  # from wheel to wheel; with the height of the frame
    wheels = {s.name: s.size[0] for s in drawn.solids if s.draw == "wheel"}
    assert wheels == {"rear": 0.3, "front": 0.35}
    assert drawing(motion(arm_in_space)).followed == ""


def test_the_floor_is_that_of_rolling_discs_or_below_everything(bicycle):
    """The bicycle's plane is z = 0 with z downwards; below the gyroscope, which reaches down to its wheel's rim."""
    floor = bicycle.floor
    assert floor.r == pytest.approx((0, 0, 0))
    assert rotated(np.array(floor.p), np.array([0.0, 0.0, 1.0])) == pytest.approx([0, 0, -1])
    drawn = drawing(motion(mbdsl.simulate(SPACE / "gyroscope.mbd", stop=0.02)))
    assert rotated(np.array(drawn.floor.p), np.array([0.0, 0.0, 1.0])) == pytest.approx([0, 0, 1])
    assert drawn.bounds[0, 2] == pytest.approx(0.4, abs=1e-3)  # its axle is at 0.5 m, the radius 0.1 m
    assert drawn.floor.r[2] < drawn.bounds[0, 2]


@pytest.mark.parametrize(
    ("body", "draw", "size"),
    [
        ("Box b(m = 2 kg, length = 0.3 m, width = 0.2 m, height = 0.1 m)", "box", (0.3, 0.2, 0.1)),
        ("Cylinder b(m = 2 kg, length = 0.3 m, radius = 0.1 m, n = {0, 1, 0})", "cylinder", (0.1, 0.1, 0.3)),
        ("Cylinder b(m = 2 kg, length = 0.3 m, radius = 0.1 m, bore = 0.05 m)", "tube", (0.1, 0.1, 0.3)),
        ("Sphere b(m = 2 kg, radius = 0.1 m)", "ball", (0.1, 0.1, 0.1)),
        # a ball of 5 kg: 2/5 m r^2; a thin disc of 2 kg: m r^2/2; a cuboid: m (b^2 + c^2)/12
        ("Body b(m = 5 kg, I = {0.02, 0.02, 0.02} kg.m2)", "ball", (0.1, 0.1, 0.1)),
        ("Body b(m = 2 kg, I = {0.01, 0.005, 0.005} kg.m2)", "cylinder", (0.1, 0.1, 0.008)),
        ("Body b(m = 12 kg, I = {0.05, 0.1, 0.13} kg.m2)", "box", (0.3, 0.2, 0.1)),
    ],
)
def test_bodies_have_their_dimensions(trajectory_of, body, draw, size):
    drawn = solids_of(f"spatial model A Ground g; {body}; FreeMotion f(g, b.c); end A;", trajectory_of=trajectory_of)
    solid = next(s for s in drawn.solids if s.name == "b")
    assert solid.draw == draw
    assert solid.size == pytest.approx(size)


def test_an_inclined_matrix_of_inertia_turns_its_cuboid(trajectory_of):
    """The cuboid 0.3 x 0.2 x 0.1 m turned by 30 degrees about z: the same edges, the longest along (cos 30, sin 30)."""
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    J = R @ np.diag([0.05, 0.1, 0.13]) @ R.T
    rows = ", ".join("{" + ", ".join(f"{x:.17g}" for x in row) + "}" for row in J)
    text = f"spatial model A Ground g; Body b(m = 12 kg, I = {{{rows}}} kg.m2); FreeMotion f(g, b.c); end A;"
    solid = next(s for s in solids_of(text, trajectory_of=trajectory_of).solids if s.name == "b")
    assert sorted(solid.size) == pytest.approx([0.1, 0.2, 0.3])
    longest = rotated(np.array(solid.at[0].p), np.eye(3)[int(np.argmax(solid.size))])
    assert abs(longest @ [c, s, 0]) == pytest.approx(1.0)


def test_a_rod_and_its_frames_are_bars(trajectory_of):
    """A bar from end to end, and one from a frame 0.2 m beside it to the foot of its perpendicular."""
    drawn = solids_of(
        "spatial model A Ground g; Rod b(m = 1 kg, length = 1 m, frames(side = {0.3, 0.2, 0})); FreeMotion f(g, b.c);"
        " end A;",
        trajectory_of=trajectory_of,
    )
    bars = [(s.size[2], s.at[0].r) for s in drawn.solids if s.draw == "bar"]
    assert [length for length, _ in bars] == pytest.approx([1.0, 0.2])
    assert bars[1][1] == pytest.approx((0.3, 0.1, 0.0))


def test_weights_and_reactions_of_equilibria():
    """The foot of the top carries its weight, at one scale with it."""
    point = mbdsl.static(SPACE / "heavy_top.mbd")
    text = point.show().html
    data, _, _ = parts(text)
    weights = [v for v in data["vectors"] if v["group"] == "forces"]
    (scene_body,) = load(SPACE / "heavy_top.mbd").bodies()
    mass = scene_body.values["m"]
    assert array(weights[0]["values"]) == pytest.approx([0, 0, -9.81 * mass], rel=1e-6)
    (foot,) = [v for v in data["vectors"] if v["group"] == "reactions" and v["kind"] == "force"]
    # the equilibrium is found to 1e-9 of the weight or better; 32-bit numbers
    assert array(foot["values"]) == pytest.approx([0, 0, 9.81 * mass], rel=1e-6, abs=1e-6 * mass)
    assert data["largest"]["forces force"] == data["largest"]["reactions force"]


def test_springs_pull_along_their_line(trajectory_of):
    """k (s - s0) = 10 N/m * (5 - 1) m from (3, 4, 0) towards the origin."""
    scene = parse(
        "spatial model A Ground g(g = 0); PointMass b(m = 1 kg); SpringDamper s(g, b, k = 10 N/m, s0 = 1 m);"
        " FreeMotion f(g, b); end A;"
    )
    run = trajectory_of(scene, [0.0], {"b": np.array([[3.0, 4.0, 0.0]])})
    (spring,) = loads(run, motion(run))
    assert spring.values[0] == pytest.approx([-24.0, -32.0, 0.0])


def test_forces_in_the_axes_of_a_frame(trajectory_of):
    """Along x of a frame that is turned by 90 degrees about z: along y of the world."""
    scene = parse(
        """spatial model A Ground g(g = 0); Frame base(g, r = {0, 0, 0}, n = {0, 0, 1}, phi = 90 deg);
        PointMass b(m = 1 kg); FreeMotion f(g, b); Force push(base, b, fx = 3 N); end A;"""
    )
    run = trajectory_of(scene, [0.0], {"b": np.zeros((1, 3))})
    (push,) = [v for v in vectors(run, motion(run)) if v.group == "forces"]
    assert push.values[0] == pytest.approx([0.0, 3.0, 0.0], abs=1e-12)


def test_gears_have_their_pitch_radii(trajectory_of):
    """A pinion of 20 mm in a ring of 60 mm, which is outside of its pitch circle; the floor is below both."""
    scene = parse(
        """spatial model A Ground g; Body sun(m = 1 kg, I = {1, 1, 1} g.m2);
        Body ring(m = 1 kg, I = {1, 1, 1} g.m2); Frame other(g, r = {0.04, 0, 0});
        Revolute p(other, sun.c); Revolute q(g, ring.c);
        GearPair mesh(sun.c, ring.c, r_a = 20 mm, r_b = 60 mm, internal = true); end A;"""
    )
    states = {"sun": np.array([[0.04, 0, 0, 0, 0, 0]]), "ring": np.zeros((1, 6))}
    drawn = drawing(motion(trajectory_of(scene, [0.0], states)))
    (pinion,) = [s for s in drawn.solids if s.draw == "cylinder" and s.role == "body"]
    (ring,) = [s for s in drawn.solids if s.draw == "tube"]
    assert pinion.size[:2] == pytest.approx((0.02, 0.02)) and pinion.name == "sun"
    assert ring.size[0] * ring.data["bore"] == pytest.approx(0.06) and ring.name == "ring"
    assert drawn.floor.r[1] < -0.06
    for solid in (pinion, ring):
        assert abs(rotated(np.array(solid.at[0].p), np.array([0, 0, 1.0]))) == pytest.approx([0, 0, 1])


def test_a_coil_has_turns_for_its_length(trajectory_of):
    """A spring of 1 m has about twice the turns of one of 0.5 m beside it, because its wire has one thickness."""
    scene = parse(
        """spatial model A Ground g(g = 0); PointMass b(m = 1 kg); PointMass d(m = 1 kg); PointMass e(m = 1 kg);
        FreeMotion f(g, b); FreeMotion h(g, d); FreeMotion i(g, e);
        SpringDamper long(g, b, k = 1 N/m, s0 = 1 m); SpringDamper short(g, d, k = 1 N/m, s0 = 1 m); end A;"""
    )
    places = {"b": [1.0, 0.0, 0.0], "d": [0.0, 0.5, 0.0], "e": [0.0, 0.0, 2.0]}
    run = trajectory_of(scene, [0.0], {name: np.array([r]) for name, r in places.items()})
    turns = {s.name: s.data["turns"] for s in drawing(motion(run)).solids if s.draw == "coil"}
    assert turns["short"] > 5 and turns["long"] == pytest.approx(2 * turns["short"], abs=1)


def test_a_curve_is_a_wire_in_its_frame(trajectory_of):
    """A bead on a helix, drawn in axes that are turned by 90 degrees about x and shifted."""
    scene = parse(
        """spatial model A Ground ground; Frame base(ground, r = {1, 0, 0}, n = {1, 0, 0}, phi = 90 deg);
        PointMass bead(m = 1 kg); PointOnCurve wire(base, bead, f1 = x - 1 m*cos(z/(1 m)), f2 = y - 1 m*sin(z/(1 m)));
        end A;"""
    )
    u = np.linspace(0.0, 6.0, 101)
    # the axes y and z of the frame are z and -y of the world
    run = trajectory_of(scene, u, {"bead": np.column_stack([1 + np.cos(u), -u, np.sin(u)])})
    (wire,) = [s for s in drawing(motion(run)).solids if s.draw == "wire"]
    x, y, z = np.array(wire.data["points"]).T
    assert len(x) > 20
    assert np.column_stack([x, y]) == pytest.approx(np.column_stack([np.cos(z), np.sin(z)]), abs=1e-12)
