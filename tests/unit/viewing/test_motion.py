"""Poses and shapes of mechanisms against closed forms."""

import numpy as np
import pytest

from mbdsl import load, parse
from mbdsl.elements import kinds
from mbdsl.elements.kind import BodyKind
from mbdsl.errors import UsageError
from mbdsl.viewing.motion import chosen_rows, motion
from mbdsl.viewing.shapes import drawing, outline
from mbdsl.viewing.signals import extremes, signals, thinned
from mbdsl.viewing.symbols import SYMBOLS
from mbdsl.viewing.tracks import GROUND, Curve, largest_strain
from mbdsl.viewing.vectors import vectors


def shapes_of(trajectory, draw):
    return [shape for shape in drawing(motion(trajectory)).shapes if shape.draw == draw]


def test_pins_of_the_slider_crank(slider_crank):
    """The pins O, A and B from the crank's angle phi = 2 t alone."""
    found = motion(slider_crank)
    phi = 2.0 * slider_crank.t
    pins = {shape.name: found.pose(shape.at[0])[:, :2] for shape in shapes_of(slider_crank, "pin")}
    np.testing.assert_allclose(pins["O"], np.zeros((301, 2)), atol=1e-15)
    np.testing.assert_allclose(pins["A"], 0.3 * np.stack([np.cos(phi), np.sin(phi)], axis=1), atol=1e-14)
    x = 0.3 * np.cos(phi) + np.sqrt(0.36 - 0.09 * np.sin(phi) ** 2)
    np.testing.assert_allclose(pins["B"], np.stack([x, 0 * x], axis=1), atol=1e-14)


def test_the_rail_is_as_long_as_the_way_of_the_slider(slider_crank):
    """In three seconds the crank has turned by 6 rad: the slider reaches 0.9 m at phi = 0 and 0.3 m near phi = pi."""
    (rail,) = shapes_of(slider_crank, "guide")
    (line,) = rail.items
    assert line.metres == (pytest.approx((0.3, 0.0), abs=1e-4), pytest.approx((0.9, 0.0)))
    assert line.hatch == -1 and line.units[0][1] < 0.0  # it is fixed, and below the slider


def test_the_spring_is_between_the_wall_and_the_slider(slider_crank):
    (spring,) = shapes_of(slider_crank, "spring-damper")
    found = motion(slider_crank)
    np.testing.assert_allclose(found.pose(spring.at[0])[:, :2], np.full((301, 2), (1.2, 0.0)))
    piston = next(item for item in spring.items if item.state)
    assert (piston.low, piston.high) == (pytest.approx(0.3), pytest.approx(0.9, abs=1e-4))


def test_the_bounds_contain_all_points(slider_crank):
    x0, y0, x1, y1 = drawing(motion(slider_crank)).bounds
    assert (x0, y0, x1, y1) == pytest.approx((-0.3, -0.3, 1.2, 0.3), abs=1e-3)


def test_a_beam_bends_by_its_shape_functions(trajectory_of):
    """One ANCF element whose slopes at the ends are those of y = x^2: a cubic in between is this parabola."""
    scene = parse("""model A
      Ground ground; FlexibleBeam beam(length = 1 m, mass = 1 kg, S = 1 m2, I = 1 m4, E = 1 Pa, elements = 1,
      formulation = "ancf"); Revolute pin(ground, beam.a); annotation(experiment(StopTime = 1)); end A;""")
    q = np.array([[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 2.0]])
    (curve,) = motion(trajectory_of(scene, [0.0], {"beam": q})).curves
    x = curve.along + 0.5
    np.testing.assert_allclose(curve.points[0], np.stack([x, x**2], axis=1), atol=1e-14)
    np.testing.assert_allclose(curve.angles[0], np.arctan(2 * x), atol=1e-14)


def test_a_wheel_touches_its_floor(trajectory_of, model_file):
    scene = load(model_file("rolling_disc"))
    down = np.array([np.cos(np.pi / 6), -np.sin(np.pi / 6)])
    up = np.array([np.sin(np.pi / 6), np.cos(np.pi / 6)])
    s = np.linspace(0.3, 0.8, 11)
    q = np.column_stack([s[:, None] * down + 0.1 * up, -s / 0.1])
    trajectory = trajectory_of(scene, np.linspace(0, 1, 11), {"disc": q})
    (wheel,), (floor,) = shapes_of(trajectory, "wheel"), shapes_of(trajectory, "floor")
    assert wheel.radius == wheel.items[0].radius.metres == 0.1
    assert [x for x, _ in floor.items[0].metres] == pytest.approx([0.2, 0.9])


def test_plates_are_hulls_and_bars_are_lines():
    square = [(0.0, 0.0), (1.0, 0.0), (0.5, 0.5), (1.0, 1.0), (0.0, 1.0)]
    assert set(outline(square)) == {(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)}
    assert set(outline([(0.0, 0.0), (0.5, 0.5), (1.0, 1.0)])) == {(0.0, 0.0), (1.0, 1.0)}


def test_all_kinds_have_a_symbol():
    """A new kind without a symbol is drawn as a mark; none of the kinds of mbdsl relies on it."""
    own = {name for name, kind in kinds().items() if not isinstance(kind, BodyKind) and len(kind.ports) == 2}
    named = {name: kinds()[name].drawing for name in own}
    assert {name for name, symbol in named.items() if symbol not in SYMBOLS} == set()


def test_long_motions_are_shown_at_even_times():
    """10,000 rows in the first second and 100 in the next nine: all parts of the duration have frames."""
    t = np.concatenate([np.linspace(0, 1, 10_000), np.linspace(1.09, 10, 100)])
    rows = chosen_rows(t, 500)
    assert len(rows) <= 500 and (rows[0], rows[-1]) == (0, len(t) - 1)
    assert np.diff(t[rows]).max() < 0.1
    assert chosen_rows(t[:5], 500).tolist() == [0, 1, 2, 3, 4]


def test_long_lines_keep_their_extremes():
    """A peak of one row among 100,000 is in the line."""
    t = np.linspace(0.0, 1.0, 100_000)
    y = np.sin(20 * t)
    y[51_234], y[77_777] = 5.0, -7.0
    times, limits = thinned(t, 2000)
    line = extremes(y, limits)
    assert len(line) == len(times) == 2000
    assert (line.max(), line.min()) == (5.0, -7.0)
    assert times[np.argmax(line)] == pytest.approx(t[51_234], abs=1e-3)
    assert (np.diff(times) > 0).all()


def test_signals_that_change_are_shown(slider_crank):
    """Angles change; the velocities of this trajectory, all zero, do not."""
    found = signals(slider_crank, None)
    names = [s.name for s in found.signals]
    assert {"crank.phi", "rod.phi", "spring.s", "B.s"} <= set(names) and "crank.w" not in names
    assert found.shown[:2] == ["crank.phi", "rod.phi"]
    chosen = signals(slider_crank, ["rod.x"])
    assert [s.name for s in chosen.signals] == chosen.shown == ["rod.x"]
    assert chosen.signals[0].high == slider_crank["rod.x"].max()


def test_forces_are_arrows_in_world_axes(trajectory_of):
    """A follower force of 2 N along the rod's axis, which turns by a quarter; a torque of 3 N.m."""
    scene = parse("""model A Ground ground; Rod rod(m = 1 kg, length = 2 m); Revolute pin(ground, rod.a);
      Force push(rod.b, rod.b, fx = 2 N); Torque turn(rod.c, tau = 3 N.m); end A;""")
    phi = np.array([0.0, np.pi / 2])
    q = np.column_stack([np.cos(phi), np.sin(phi), phi])
    trajectory = trajectory_of(scene, [0.0, 1.0], {"rod": q})
    found = {v.name: v for v in vectors(trajectory, motion(trajectory))}
    np.testing.assert_allclose(found["push"].values, [[2.0, 0.0], [0.0, 2.0]], atol=1e-15)
    np.testing.assert_allclose(found["turn"].values, [[3.0], [3.0]])


def test_reactions_are_shown_where_they_are_at_hand(slider_crank, trajectory_of):
    """Not if they would have to be solved for; if a file supplies them, these values."""
    moving = motion(slider_crank)
    assert not slider_crank.is_at_hand("O.fx") and slider_crank.is_at_hand("rod.b.x")
    assert not [v for v in vectors(slider_crank, moving) if v.group == "reactions"]
    again = trajectory_of(slider_crank.scene, slider_crank.t, {})
    again.supply({"O.fx": 2.0 * again.t, "O.fy": -again.t, "time": again.t, "unknown": again.t})
    (reaction,) = [v for v in vectors(again, motion(again)) if v.group == "reactions"]
    assert reaction.name == "O"
    np.testing.assert_array_equal(reaction.values, np.column_stack([2.0 * again.t, -again.t]))


def test_a_frame_of_the_ground_does_not_move(slider_crank):
    assert motion(slider_crank).spot_of("wall").track == GROUND
    with pytest.raises(UsageError, match="`wall` does not move"):
        slider_crank.animate(traces=["wall"])
    with pytest.raises(UsageError, match=r"there is no frame or joint `rod\.d`") as caught:
        slider_crank.animate(traces=["rod.d"])
    assert "rod.a" in caught.value.hint


def test_an_empty_trajectory_has_no_animation(trajectory_of, slider_crank):
    with pytest.raises(UsageError, match="the trajectory of SliderCrank is empty"):
        trajectory_of(slider_crank.scene, [], {}).animate()


def test_a_kind_names_its_symbol(slider_crank, monkeypatch):
    given = vars(kinds()["PointOnLine"])
    monkeypatch.setitem(given, "drawing", "pin")
    assert shapes_of(slider_crank, "guide") == []
    monkeypatch.setitem(given, "drawing", "")
    (mark,) = shapes_of(slider_crank, "mark")
    assert mark.name == "B"


def test_the_strain_of_a_beam(trajectory_of):
    """Half a sine wave of height A has the curvature A (pi/L)^2 in its middle, the edge of a 2 cm square is at 1 cm."""
    scene = parse("""model B Ground ground; FlexibleBeam beam(length = 2 m, density = 7800, S = 4 cm2, I = (2 cm)^4/12,
      E = 210 GPa, modes = 1); FreeMotion f(ground, beam.c); end B;""")
    (curve,) = motion(trajectory_of(scene, [0.0, 1.0], {"beam": np.array([[0.0] * 4, [0.0, 0.0, 0.0, 1e-3]])})).curves
    height = abs(curve.points[1, 12, 1])
    # differences over two parts of 24 of the length: (pi/24)^2/6 = 0.3 % below
    assert curve.strain()[1, 12] == pytest.approx(0.01 * height * (np.pi / 2) ** 2, rel=5e-3)
    assert not curve.strain()[0].any()
    assert largest_strain([curve]) == curve.strain()[1].max()


def test_the_strain_of_a_cantilever_is_largest_where_it_is_clamped():
    """F c L/(E I) there and zero at the tip, where the force F acts: the closed form of a slender beam."""
    L, half, E, F, along = 2.0, 0.01, 210e9, 1.0, np.linspace(0.0, 2.0, 25)
    inertia = (2 * half) ** 4 / 12
    angles = F * (L * along - along**2 / 2) / (E * inertia)
    curve = Curve("beam", along - L / 2, np.stack([along, 0 * along], axis=1)[None], angles[None], half)
    assert curve.strain()[0, [0, -1]] == pytest.approx([F * half * L / (E * inertia), 0.0], rel=1e-9, abs=1e-15)
