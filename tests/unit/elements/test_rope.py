"""Ropes over discs, in the plane and in space: derivatives, virtual work, and messages about what cannot be used.

Derivatives are compared with five-point differences of step H: the truncation error is H^4/30 f^(5), with f^(5) up to
5!/l^5 = 4e3 at the distances of about 0.5 m here and forces of some 10 N: 1e-9 relative to these.
"""

import numpy as np
import pytest

import mbdsl
from mbdsl import Builder
from mbdsl.mechanism.graph import build as build_graph
from mbdsl.system import build
from mbdsl.system.signals import begin, values

H = 1e-3
TOLERANCE = 1e-8
#: sliding with friction, without, and holding fast
WAYS = {"friction": {"mu": 0.3, "v_s": 0.5}, "smooth": {"mu": 0.0}, "fast": {}}


def flat(**given):
    """A rope from a point over two free discs, on both of their sides, to a drum."""
    b = Builder("Flat")
    b.Ground("ground", g=0.0)
    for name in ("p", "q", "d"):
        b.Body(name, m=1.0, I=0.5, frames={"e": (0.1, 0.05, 0.3)})
    b.PointMass("a", m=1.0)
    b.FreeMotion("free", "ground", "a")
    b.Rope("rope", "a", "d.e", over=["p", "q.e"], radius=(0.2, -0.15), drum=0.1, k=30.0, c=2.0, length=3.2, **given)
    place = {"a": (0.0, 0.0), "p": (-0.3, 1.2), "q": (-1.3, 1.3), "d": (-1.2, 2.6)}
    for name, (x, y) in place.items():
        b.initial(f"{name}.x", x)
        b.initial(f"{name}.y", y)
    return b.scene()


def spatial(**given):
    """The same with axes in different directions, and out of plane."""
    b = mbdsl.SpatialBuilder("Spatial")
    b.Ground("ground", g=0.0)
    turned = {"e": {"r": (0.1, 0.05, 0.02), "angles": (0.5, -0.3, 0.3)}}
    for name in ("p", "q", "d"):
        b.Body(name, m=1.0, I=(0.5, 0.6, 0.7), frames=turned)
    b.PointMass("a", m=1.0)
    b.FreeMotion("free", "ground", "a")
    b.Rope("rope", "a", "d.e", over=["p", "q.e"], radius=(0.2, -0.15), drum=0.1, k=30.0, c=2.0, length=3.2, **given)
    place = {"a": (0.0, 0.0, 0.1), "p": (-0.3, 1.2, 0.0), "q": (-1.3, 1.3, 0.2), "d": (-1.2, 2.6, 0.1)}
    for name, r in place.items():
        for key, x in zip("xyz", r, strict=True):
            b.initial(f"{name}.{key}", x)
    return b.scene()


def started(scene):
    """The system with its start, and a state near it with velocities."""
    system = build(scene, build_graph(scene))
    from mbdsl.initial.consistent import initial_position

    q, rng = initial_position(system, system.graph, 0.0), np.random.default_rng(2)
    begin(system, 0.0, q, np.zeros(system.n))
    return system, system.moved(q, 0.05 * rng.uniform(-1, 1, system.n)), rng.uniform(-1, 1, system.n)


def difference(f, n):
    columns = []
    for e in np.eye(n):
        columns.append((8 * (f(H * e) - f(-H * e)) - (f(2 * H * e) - f(-2 * H * e))) / (12 * H))
    return np.array(columns).T


def signal(system, name, q, v):
    return values(system, [system.scene.signal(name)], np.zeros(1), q[None], v[None])[0][0]


@pytest.mark.parametrize("scene", [flat, spatial])
@pytest.mark.parametrize("way", WAYS)
def test_tangents_are_derivatives(scene, way):
    system, q, v = started(scene(**WAYS[way]))
    assert min(signal(system, f"rope{x}.tension", q, v) for x in ("", ".span2", ".span3")) > 0.1
    for found, expected in (
        (system.stiffness(0.0, q, v), difference(lambda d: -system.Q(0.0, system.moved(q, d), v), system.n)),
        (system.damping(0.0, q, v), difference(lambda d: -system.Q(0.0, q, v + d), system.n)),
    ):
        np.testing.assert_allclose(found, expected, rtol=0, atol=TOLERANCE * np.abs(expected).max())


@pytest.mark.parametrize("scene", [flat, spatial])
@pytest.mark.parametrize("way", WAYS)
def test_the_virtual_work_of_the_tensions_is_that_of_the_spring(scene, way):
    """At rest, and without friction, the force is minus the derivative of the potential energy."""
    given = WAYS[way] | ({"mu": 0.0} if way == "friction" else {})
    system, q, v = started(scene(**given))
    v = 0.0 * v
    expected = difference(lambda d: -signal_of_energy(system, system.moved(q, d)), system.n)
    found = system.Q(0.0, q, v)
    np.testing.assert_allclose(found, expected[0], rtol=0, atol=TOLERANCE * np.abs(found).max())


def signal_of_energy(system, q):
    from mbdsl.mechanism.energies import energies

    return values(system, [energies(system.scene)[1]], np.zeros(1), q[None], 0.0 * q[None])[0]


@pytest.mark.parametrize("scene", [flat, spatial])
def test_friction_dissipates(scene):
    """The power of a rope that slides is that of its spring and damper, less what friction takes."""
    power = {}
    for mu in (0.0, 0.3):
        system, q, v = started(scene(mu=mu, v_s=0.5))
        power[mu] = system.Q(0.0, q, v) @ v
        if not mu:
            own = -signal(system, "rope.tension", q, v) * signal_rate(system, q, v)
            assert power[mu] == pytest.approx(own, rel=1e-10)
    assert power[0.3] < power[0.0] - 0.01


def signal_rate(system, q, v):
    """The rate of the stretch by differences."""
    at = [signal(system, "rope.stretch", system.moved(q, k * H * v), v) for k in (-2, -1, 1, 2)]
    return (8 * (at[2] - at[1]) - (at[3] - at[0])) / (12 * H)


# -- where values at the start are needed ------------------------------------------------------------------------

REDUCED = """
model Reduced
  Ground ground(frames(axle = {0, 0}));
  Body boss(m = 0.5 kg, I = 0.01 kg.m2);
  Body wheel(m = 1 kg, I = 0.02 kg.m2);
  Body left(m = 2 kg, I = 0.1 kg.m2);
  Body arm(m = 3 kg, I = 0.1 kg.m2);
  Body other(m = 1 kg, I = 1 kg.m2);
  Revolute pin(ground.axle, boss.c);
  Fixed weld(boss.c, wheel.c);
  Frame rail(ground, r = {0.2 m, -1 m}, phi = 90 deg);
  Prismatic slide(rail, arm.c);
  TranslationalDriver lift(slide, s = 0.1 m*sin(2*time/(1 s)));
  FreeMotion free(ground, left.c);
  Revolute another(ground, other.c);
  Rope rope(arm.c, left.c, over = {wheel}, radius = 0.2 m, k = 1e4 N/m, c = 60 N.s/m);
initial equation
  left.x = -0.2 m; left.y = -1 m; wheel.phi = 0.3; other.phi = 1;
end Reduced;
"""


def test_welded_and_driven_bodies_and_steps_from_python():
    """Reductions change no result; a Simulation reads the same signals; the mass obeys Newton's law."""
    scene = mbdsl.parse(REDUCED)
    given = {"method": "hht-si2", "step": 1e-3}
    run, general = (mbdsl.simulate(scene, stop=0.2, interval=0.02, general=x, **given) for x in (False, True))
    for name in ("rope.stretch", "rope.tension_b", "left.y"):
        np.testing.assert_allclose(run[name], general[name], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(run["left.ay"], run["rope.tension_b"] / 2.0 - 9.81, atol=1e-3)
    steps = mbdsl.Simulation(scene, **given)
    steps.step(200)
    assert steps["rope.tension_b"] == pytest.approx(run["rope.tension_b"][-1], rel=1e-12)


@pytest.mark.parametrize("law", [False, True])
def test_the_force_at_the_end_is_that_of_the_last_span(law):
    """In a model as in results: the mass at the end feels the tension of the last span, upwards."""
    text = machine("over = {wheel}, radius = 0.2 m, length = 3 m")
    if law:
        text = text.replace("initial equation", "Real load = rope.frame_b.fy;\ninitial equation")
    scene = mbdsl.parse(text)
    run = mbdsl.simulate(scene, stop=1e-3, interval=5e-4, method="hht-si2", step=1e-4)
    np.testing.assert_allclose(run["load" if law else "rope.frame_b.fy"], run["rope.tension_b"], rtol=1e-6)
    assert (run["rope.tension_b"] > 1e3).all()


# -- messages ------------------------------------------------------------------------------------------------------

BAD = {
    "over = {pin}, radius = 0.2 m": (7, "`over`: `pin` is a Revolute, expected a body or one of its frames"),
    "over = {0.3 m}, radius = 0.2 m": (7, "`over`: found `0.3 m`, expected a frame or a body"),
    "over = {ground.axle}, radius = 0.2 m": (7, "cannot turn the disc at `ground.axle`: a Ground does not turn"),
    "over = {wheel}": (7, "`over` needs `radius`"),
    "over = {wheel}, radius = {0.1, 0.2}": (7, "`radius` has 2 values, and `over` names 1"),
    "over = {wheel}, radius = 0": (7, "`radius` of a disc is 0 m"),
    "over = {wheel, wheel}, radius = 0.1": (7, "runs from `wheel.c` to the same frame"),
    "mu = 0.3": (7, "`mu` is that of the discs in `over`, which names none"),
    "over = {wheel}, radius = 3 m": (7, "`right.c` is inside the disc of radius 3 m at `wheel.c`"),
}


def machine(arguments):
    return f"""model T
  Ground ground(frames(axle = {{0, 0}}));
  Body wheel(m = 1 kg, I = 0.02 kg.m2);
  PointMass left(m = 2 kg);
  PointMass right(m = 3 kg);
  Revolute pin(ground.axle, wheel.c);
  Rope rope(right, left, k = 1e5 N/m, {arguments});
initial equation
  left.x = -0.2 m; left.y = -1 m; right.x = 0.2 m; right.y = -1.5 m;
end T;
"""


@pytest.mark.parametrize("arguments", BAD)
def test_what_a_rope_cannot_be(arguments):
    line, message = BAD[arguments]
    with pytest.raises(mbdsl.MbdslError, match=f".*{line}.*") as found:
        mbdsl.check(mbdsl.parse(machine(arguments)))
    assert message in str(found.value)


@pytest.mark.parametrize("extra", [0, 2])
def test_check_states_how_far_a_rope_turns(extra):
    """Both sides hang vertically from the rim: half a turn, and the full turns that are given."""
    found = str(mbdsl.check(mbdsl.parse(machine(f"over = {{wheel}}, radius = 0.2 m, turns = {extra}"))))
    assert f"rope: turns {180 + 360 * extra} deg to the left around wheel\n" in found


def test_meanings_of_spans():
    run = mbdsl.simulate(mbdsl.parse(machine("over = {wheel}, radius = 0.2 m")), stop=0.01)
    assert run.signals["rope.span2.s"].doc == "length of this span"
    assert run.signals["rope.tension"].doc == "tension at frame_a"


def test_a_rope_shorter_than_its_path():
    """The path is 1.5 m, half a turn around 0.2 m, and 1 m."""
    text = str(mbdsl.check(mbdsl.parse(machine("over = {wheel}, radius = 0.2 m, length = 3 m"))))
    assert "Rope rope: its path is 3.12832 m at the start, longer than its free length by 0.128 m" in text


# -- pictures ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("spatial", [False, True])
def test_a_slack_rope_sags(spatial):
    """Between points 1 m apart, a rope of 1.06 m sags by sqrt(3/8 * 0.06) m = 0.15 m; a taut one is straight."""
    from mbdsl.viewing import motion, rope_lines

    b = mbdsl.SpatialBuilder("Sag") if spatial else Builder("Sag")
    b.Ground("ground", g=9.81, n=(0.0, -1.0, 0.0) if spatial else (0.0, -1.0))
    b.PointMass("a", m=1.0)
    b.FreeMotion("free", "ground", "a")
    b.Rope("rope", "ground.c", "a", k=1e3, length=1.06)
    b.initial("a.x", 1.0)
    b.initial("a.vx", 10.0)
    b.initial("a.vy", 0.0)
    run = mbdsl.simulate(b.scene(), method="hht-si2", step=1e-4, stop=8e-3, interval=8e-3)
    found = motion.motion(run)
    places = {"ground.c": [0.0, 0.0], "a.c": [run["a.x"], run["a.y"]]}
    c = run.scene.components["rope"]
    first, last, middle = rope_lines.line(
        c, found, lambda f, k: np.zeros(2) + (places[f]["xy".index(k)] if k != "z" else 0)
    )
    sag = np.linalg.norm(middle - 0.5 * (first + last), axis=1)
    np.testing.assert_allclose(sag, [np.sqrt(0.375 * 0.06), 0.0], atol=1e-6)
    assert run["rope.slack"].tolist() == [1.0, 0.0]
