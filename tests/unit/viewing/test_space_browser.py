"""Pages of models in space in a browser: the scene graph and pixels against the motion, the camera, keys, console."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbdsl import parse
from mbdsl.viewing.projection import VIEWS, view

#: the centre of the pixels that differ from the paper and their number, and how far they reach, in CSS pixels
PIXELS = """(() => {
  paint();
  const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
  const g = copy.getContext("2d");
  g.drawImage(canvas, 0, 0);
  const { data: pixels } = g.getImageData(0, 0, copy.width, copy.height);
  const paper = [1, 3, 5].map((k) => parseInt(theme.paper.slice(k, k + 2), 16));
  let [n, x, y, low, high, left, right] = [0, 0, 0, 1e9, -1e9, 1e9, -1e9];
  for (let k = 0; k < copy.width * copy.height; k += 1) {
    if (paper.every((part, j) => Math.abs(pixels[4 * k + j] - part) <= 2)) continue;
    const [px, py] = [(k % copy.width) + 0.5, Math.floor(k / copy.width) + 0.5];
    [n, x, y] = [n + 1, x + px, y + py];
    [low, high, left, right] = [Math.min(low, py), Math.max(high, py), Math.min(left, px), Math.max(right, px)];
  }
  return [x / n, y / n, n, left, right, low, high];
})()"""
#: position and axes (columns) of the first solid of a body in the scene graph
MATRIX = """((name) => {
  for (const mesh of painter.solids.meshes) {
    const k = mesh.userData.solids.findIndex((solid) => solid.name === name && solid.role === "body");
    if (k < 0) continue;
    const matrix = new THREE.Matrix4();
    mesh.getMatrixAt(k, matrix);
    return [...matrix.elements];
  }
})"""


@pytest.fixture(scope="module")
def ball(trajectory_of):
    """A mass on a helix, alone and without a floor."""
    scene = parse("spatial model A Ground ground(g = 0); PointMass ball(m = 1 kg); FreeMotion f(ground, ball); end A;")
    t = np.linspace(0.0, 4.0, 201)
    return trajectory_of(scene, t, {"ball": np.column_stack([np.cos(t), np.sin(t), 0.3 * t])})


def drag(browser, by, button="left", modifiers=0):
    """Drag the middle of the picture by (x, y) pixels."""
    x, y = browser.value("(({ left, top }) => [left + 150, top + 120])(canvas.getBoundingClientRect())")
    buttons = {"left": 1, "right": 2}[button]
    about = {"button": button, "buttons": buttons, "modifiers": modifiers, "clickCount": 1}
    browser.send("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, **about)
    browser.send("Input.dispatchMouseEvent", type="mouseMoved", x=x + by[0], y=y + by[1], **about)
    browser.send("Input.dispatchMouseEvent", type="mouseReleased", x=x + by[0], y=y + by[1], **about)
    browser.settle()


def test_the_scene_graph_is_the_trajectory(browser, arm_page):
    """The matrices of the arm's bar, whose z axis is along it, and of the ball, at frames and between them; at 0.39275
    the stored quaternions before and after half a turn have opposite signs."""
    browser.open_small(arm_page)
    for part in (0.0, 0.31, 0.39275, 0.6425, 1.0):
        browser.scrub(part)
        t = browser.state()["time"]
        assert t == pytest.approx(4.0 * part, abs=4e-6)
        arm = np.array(browser.value(f"{MATRIX}('arm')")).reshape(4, 4)  # rows are columns of the matrix
        ball = np.array(browser.value(f"{MATRIX}('ball')")).reshape(4, 4)
        along = np.array([np.cos(2 * t), np.sin(2 * t), 0.0])
        # frames are 20 ms apart; between them positions are interpolated linearly: 0.04^2/8 of the radius
        assert arm[3, :3] == pytest.approx(0.5 * along, abs=0.5 * 2e-4 + 1e-6)
        assert arm[2, :3] == pytest.approx(along, abs=1e-5)  # the length is 1 m; the rotation is interpolated as such
        assert ball[3, :3] == pytest.approx([np.cos(t), np.sin(t), 0.3 * t], abs=6e-5)


def test_attitudes(browser, trajectory_of, tmp_path):
    """The axes of a box at rotation vectors of all directions: those of SciPy; and a frame on it."""
    scene = parse(
        """spatial model A Ground g(g = 0); FreeMotion f(g, b.c);
        Box b(m = 1 kg, length = 1 m, width = 1 m, height = 1 m);
        Frame tip(b.c, r = {0.1, 0.2, 0.3}, n = {1, 2, 0}, phi = 40 deg); end A;"""
    )
    turn = Rotation.from_rotvec(np.radians(40) * np.array([1, 2, 0]) / np.sqrt(5))
    psi = np.array([[0.3, -0.8, 0.5], [-1.2, 0.4, 2.1], [2.0, 1.0, -1.5]])
    r = np.array([[1.0, 2.0, 3.0], [-1.0, 0.5, 0.0], [0.0, 0.0, 1.0]])
    trajectory_of(scene, [0.0, 1.0, 2.0], {"b": np.column_stack([r, psi])}).animate(tmp_path / "page.html")
    browser.open_small(tmp_path / "page.html")
    for k, part in enumerate((0.0, 0.5, 1.0)):
        browser.scrub(part)
        R = Rotation.from_rotvec(psi[k])
        matrix = np.array(browser.value(f"{MATRIX}('b')")).reshape(4, 4)
        assert matrix[:3, :3] == pytest.approx(R.as_matrix().T, abs=1e-6)
        assert matrix[3, :3] == pytest.approx(r[k], abs=1e-6)
        tip = browser.value("motion.pose(data.points.tip)")
        assert tip[:3] == pytest.approx(r[k] + R.apply([0.1, 0.2, 0.3]), abs=1e-6)
        x, y, z, w = (R * turn).as_quat()
        assert abs(np.array(tip[3:]) @ [w, x, y, z]) == pytest.approx(1.0, abs=1e-6)


def test_springs_reach_from_frame_to_frame(browser, trajectory_of, tmp_path):
    """The matrix of a coil: its middle, its z axis from end to end, its radius across, right-handed axes."""
    scene = parse(
        """spatial model A Ground g(g = 0); Frame hook(g, r = {0, 0, 2}); PointMass ball(m = 1 kg);
        FreeMotion f(g, ball); SpringDamper s(hook, ball, k = 1 N/m, s0 = 1 m); end A;"""
    )
    r = np.array([[2.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
    trajectory_of(scene, [0.0, 1.0], {"ball": r}).animate(tmp_path / "page.html")
    browser.open_small(tmp_path / "page.html")
    size = browser.value("data.solids.find((s) => s.draw === 'coil').size[0]")
    for part in (0.0, 0.5, 1.0):
        browser.scrub(part)
        end = r[0] + part * (r[1] - r[0])
        matrix = browser.value(MATRIX.replace(' && solid.role === "body"', "") + "('s')")
        axes = np.array(matrix).reshape(4, 4)
        assert axes[3, :3] == pytest.approx((end + [0, 0, 2]) / 2, abs=1e-6)
        assert axes[2, :3] == pytest.approx(end - [0, 0, 2], abs=1e-6)
        across = axes[:2, :3]
        assert across @ across.T == pytest.approx(size**2 * np.eye(2), abs=1e-6)
        assert np.cross(*across) @ axes[2, :3] > 0.0


def test_prints_have_the_picture(browser, arm_page):
    """The picture can be read at any time after it is painted, as a print does."""
    browser.open_small(arm_page)
    browser.settle()
    assert browser.value(PIXELS.replace("paint();", "", 1))[2] > 100


def test_the_table_of_poses(browser, arm_page):
    browser.open_small(arm_page)
    browser.value("document.getElementById('values').open = true")
    browser.scrub(0.25)
    rows = browser.value(
        "[...document.querySelectorAll('#values tr')].map((r) => [...r.cells].map((c) => c.textContent))"
    )
    assert rows[0] == ["body", "x [m]", "y [m]", "z [m]", "p0", "p1", "p2", "p3"]
    found = [float(x.replace("−", "-")) for x in rows[1][1:]]
    turn = np.array([np.cos(1), 0, 0, np.sin(1)])
    sign = np.sign(found[3] * turn[0])
    assert found == pytest.approx([0.5 * np.cos(2), 0.5 * np.sin(2), 0, *(sign * turn)], abs=1e-5)


def test_pixels_are_where_the_trajectory_is(browser, ball, tmp_path):
    """In parallel projection a ball is a disc about its projected centre, to a pixel; also after zoom and pan."""
    ball.animate(tmp_path / "page.html")
    browser.open_small(tmp_path / "page.html")
    browser.key("p", 80, "p")
    width, height = browser.value("[canvas.clientWidth, canvas.clientHeight]")
    acts = ("", "setView('front')", "zoom(0.7, 100, 90)", "setView('top')", "move(20, -30)")
    for part, act in zip((0.0, 0.25, 0.5, 0.75, 1.0), acts, strict=True):
        browser.scrub(part)
        browser.value(f"{act}; 0")
        browser.settle()
        state = browser.state()
        k = round(200 * part)
        point = np.array([ball[f"ball.{i}"][k] for i in "xyz"]) - [state["x"], state["y"], state["z"]]
        right, up, _ = view(ball.scene, {0.0: "iso", 0.25: "front", 0.5: "front"}.get(part, "top")).of(point)
        x, y, count, *_ = browser.value(PIXELS)
        assert count > 50
        assert x == pytest.approx(width / 2 + state["scale"] * right, abs=1.0)
        assert y == pytest.approx(height / 2 - state["scale"] * up, abs=1.0)


@pytest.mark.parametrize("parallel", [False, True])
def test_the_view_is_fitted_to_the_motion(browser, arm_page, parallel):
    """At any time everything is in the picture; over the motion it fills three quarters of the height or the width."""
    browser.open_small(arm_page)
    browser.value(f"option('ground', false), switchCamera({str(parallel).lower()}), 0")
    width, height = browser.value("[canvas.clientWidth, canvas.clientHeight]")
    found = []
    for part in np.linspace(0.0, 1.0, 9):
        browser.scrub(part)
        found.append(browser.value(PIXELS)[3:])
    left, _, low, _ = np.min(found, axis=0)
    _, right, _, high = np.max(found, axis=0)
    assert left > 2 and right < width - 2 and low > 2 and high < height - 2
    assert max((right - left) / width, (high - low) / height) > 0.75


def test_the_picture_moves_and_has_a_floor(browser, arm_page):
    """A quarter of the pixels show the floor's lines and shadows at most; another time is another picture."""
    browser.open_small(arm_page)
    browser.scrub(0.1)
    first = browser.value(PIXELS)
    browser.scrub(0.3)
    second = browser.value(PIXELS)
    assert abs(first[0] - second[0]) + abs(first[1] - second[1]) > 1.0
    browser.key("g", 71, "g")
    assert 50 < browser.value(PIXELS)[2] < 0.5 * second[2]


def test_a_drag_turns_the_view(browser, arm_page):
    """By 0.008 rad for a pixel, and the drawing with it; with shift, or the right button, the view moves."""
    browser.open_small(arm_page)
    browser.value("switchCamera(true), 0")
    browser.settle()
    before, pixels = browser.state(), browser.value(PIXELS)
    drag(browser, (100, 25))
    after = browser.state()
    assert after["azimuth"] == pytest.approx(before["azimuth"] - 0.8)
    assert after["elevation"] == pytest.approx(before["elevation"] + 0.2)
    assert browser.value(PIXELS)[:2] != pytest.approx(pixels[:2], abs=1.0)
    for button, modifiers in (("left", 8), ("right", 0)):
        before = browser.state()
        place = browser.value("painter.place(data.points['arm.b'])")
        drag(browser, (30, -20), button, modifiers)
        after = browser.state()
        assert (after["azimuth"], after["elevation"]) == (before["azimuth"], before["elevation"])
        moved = browser.value("painter.place(data.points['arm.b'])")
        assert moved[:2] == pytest.approx([place[0] + 30, place[1] - 20], abs=1e-6)


def test_the_wheel_keeps_the_point_below_the_pointer(browser, arm_page):
    browser.open_small(arm_page)
    x, y = browser.value("(({ left, top }) => [left + 300, top + 100])(canvas.getBoundingClientRect())")
    # the point in the plane of the picture through the target that is below the pointer
    point = "(() => { const [r, u] = view.axes; const s = view.scale; return sum([1, view.target],"
    point += " [(300 - canvas.clientWidth/2)/s, r], [(canvas.clientHeight/2 - 100)/s, u]); })()"
    before, scale = browser.value(point), browser.state()["scale"]
    browser.send("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-200)
    browser.settle()
    assert browser.state()["scale"] == pytest.approx(scale * np.exp(0.3))
    assert browser.value(point) == pytest.approx(before, abs=1e-9)


def test_keys(browser, arm_page):
    browser.open_small(arm_page)
    assert browser.state()["playing"] is False
    for key, name in zip("1234", ("front", "side", "top", "iso"), strict=True):
        browser.key(key, ord(key), key)
        state = browser.state()
        assert (state["azimuth"], state["elevation"]) == pytest.approx(VIEWS[name])
    browser.key(".", 190, ".")
    assert browser.state()["azimuth"] == pytest.approx(VIEWS["iso"][0] + np.pi / 36)
    fitted = browser.state()
    browser.key("+", 187, "+")
    assert browser.state()["scale"] == pytest.approx(1.3 * fitted["scale"])
    browser.key("<", 188, "<")
    assert browser.state()["x"] != pytest.approx(fitted["x"])
    browser.key("a", 65, "a")
    shown = {key: fitted[key] for key in ("azimuth", "elevation", "parallel", "x", "y", "z")}
    assert {key: browser.state()[key] for key in shown} == pytest.approx(shown, abs=0.3)
    browser.key("p", 80, "p")
    assert browser.state()["parallel"] == 1.0
    for key, name in (("s", "bodies"), ("j", "joints"), ("g", "ground"), ("x", "axes"), ("l", "labels")):
        before = browser.value(f"show.{name}")
        browser.key(key, ord(key.upper()), key)
        assert browser.value(f"[show.{name}, document.getElementById('{name}').checked]") == [not before] * 2
    browser.settle()
    assert browser.value("painter.solids.meshes.some((mesh) => mesh.visible)") is False
    browser.key("ArrowRight", 39)
    assert browser.state()["frame"] == 1
    browser.key("End", 35)
    assert browser.state()["time"] == 4.0
    browser.key(" ", 32, " ")
    assert browser.state()["playing"] is True
    browser.key(" ", 32, " ")
    assert browser.state()["playing"] is False
    # up and down turn the view where the picture has the focus
    browser.value("canvas.focus(), 0")
    before = browser.state()["elevation"]
    browser.key("ArrowUp", 38)
    assert browser.state()["elevation"] == pytest.approx(before + np.pi / 36)


def test_time_passes_with_the_clock(browser, arm_page):
    browser.open_small(arm_page, still=False)
    assert browser.state()["playing"] is True
    begin = "motion.seek(0.5); playing = true; before = 1000; advance(1100); playing = false; motion.time"
    assert browser.value(begin) == pytest.approx(0.6)


def test_a_followed_body_stays_in_the_middle(browser, arm_page):
    browser.open_small(arm_page)
    browser.key("b", 66, "b")
    browser.key("b", 66, "b")
    assert browser.value("document.getElementById('follow').value") == "ball"
    for part in (0.2, 0.7):
        browser.scrub(part)
        t = browser.state()["time"]
        assert [browser.state()[i] for i in "xyz"] == pytest.approx([np.cos(t), np.sin(t), 0.3 * t], abs=1e-4)
        x, y, *_ = browser.value("painter.place(data.bodies.ball)")
        assert [x, y] == pytest.approx(browser.value("[canvas.clientWidth / 2, canvas.clientHeight / 2]"))


def test_a_click_traces_a_point(browser, arm_page, arm_in_space):
    browser.open_small(arm_page)
    browser.scrub(0.4)
    x, y = browser.value(
        "(({ left, top }) => { const p = painter.place(data.points['arm.b']); return [left + p[0], top + p[1]]; })"
        "(canvas.getBoundingClientRect())"
    )
    for kind in ("mousePressed", "mouseReleased"):
        browser.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
    browser.settle()
    (name,) = browser.value("[...traces.keys()]")
    path = np.array(browser.value(f"traces.get('{name}')"))
    expected = np.column_stack([np.cos(2 * arm_in_space.t), np.sin(2 * arm_in_space.t), 0 * arm_in_space.t])
    np.testing.assert_allclose(path, expected, atol=1e-6)
    assert browser.value(f"painter.lines.get('{name}').part.geometry.instanceCount") == browser.state()["frame"]
    browser.key("t", 84, "t")
    assert browser.value("painter.lines.size") == 0


def test_arrows_are_forces(browser, tmp_path, trajectory_of):
    """The tips of the arrows of a force (6, 8, 0) N t, the longest at the end, and of a torque, with two heads."""
    scene = parse(
        """spatial model A Ground ground(g = 0); PointMass ball(m = 1 kg); Rod arm(m = 1 kg, length = 1 m);
        FreeMotion f(ground, ball); Force push(ball, fx = 6*time, fy = 8*time);
        Revolute pin(ground, arm.a, n = {0, 1, 0}); Torque motor(ground, arm.a, n = {0, 1, 0}, tau = 2*time); end A;"""
    )
    t = np.linspace(0.0, 2.0, 11)
    states = {"ball": np.column_stack([0 * t, 0 * t, 1 + t]), "arm": np.column_stack([0.5 + 0 * t, *[0 * t] * 5])}
    trajectory_of(scene, t, states).animate(tmp_path / "page.html")
    browser.open_small(tmp_path / "page.html")
    browser.scrub(0.5)
    most = browser.value("data.largest")
    assert (most["forces force"], most["forces torque"]) == pytest.approx((20.0, 4.0), rel=1e-6)
    longest = browser.value("0.22 * Math.min(1, canvas.clientWidth / canvas.clientHeight) * view.height")
    heads = "Array.from({ length: 4 }, (_, k) => { const m = new THREE.Matrix4(); painter.heads.getMatrixAt(k, m);"
    heads += " return [...m.elements]; })"
    found = np.array(browser.value(heads)).reshape(4, 4, 4)
    tips = found[:, 3, :3] + 0.5 * found[:, 2, :3]  # the middle of a head, and half of its length
    order = browser.value("vectors.map((v) => v.name)")
    force, torque = order.index("push"), order.index("motor")
    assert tips[2 * force] == pytest.approx(np.array([0, 0, 2]) + 0.5 * longest * np.array([0.6, 0.8, 0]), abs=1e-5)
    assert tips[2 * torque] == pytest.approx([0, 0.5 * longest, 0], abs=1e-5)
    assert not found[2 * force + 1, :3, :3].any() and found[2 * torque + 1, :3, :3].any()
    browser.key("v", 86, "v")
    assert browser.value("painter.heads.instanceMatrix.array.slice(0, 15).every((x) => x === 0)") is True


def test_a_ghost_moves_with_the_motion(browser, ball, trajectory_of, tmp_path):
    other = trajectory_of(ball.scene, ball.t, {"ball": np.column_stack([0 * ball.t, 0 * ball.t, ball.t])})
    ball.animate(tmp_path / "page.html", ghost=other)
    browser.open_small(tmp_path / "page.html")
    browser.scrub(0.5)
    matrix = browser.value(f"{MATRIX.replace('painter.solids', 'painter.behind')}('ball')")
    assert matrix[12:15] == pytest.approx([0, 0, 2.0], abs=1e-6)
    assert browser.value("painter.behind.meshes[0].material.opacity") < 0.5


def test_a_fast_wheel_shows_stored_attitudes(browser, trajectory_of, tmp_path):
    """At 2 rad a frame the nearer frame is shown, as in the plane."""
    scene = parse(
        "spatial model A Ground g(g = 0); Body b(m = 2 kg, I = {5, 5, 10} g.m2); FreeMotion f(g, b.c); end A;"
    )
    t = np.linspace(0.0, 1.0, 5)
    phi = np.angle(np.exp(2j * np.arange(5)))
    trajectory_of(scene, t, {"b": np.column_stack([t, *[0 * t] * 4, phi])}).animate(tmp_path / "page.html")
    browser.open_small(tmp_path / "page.html")
    for part, row in ((0.3, 1), (0.4, 2)):
        browser.scrub(part)
        pose = np.array(browser.value("motion.pose(data.bodies.b)"))
        assert pose[0] == pytest.approx(t[row])
        assert abs(pose[3:] @ [np.cos(row), 0, 0, np.sin(row)]) == pytest.approx(1.0, abs=1e-6)
