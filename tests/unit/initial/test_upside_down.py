"""Bodies without initial values that a loop holds in two attitudes: the one nearer to zero is taken, and named."""

import numpy as np
import pytest

import mbdsl
from mbdsl.initial.start_check import check_start
from mbdsl.mechanism.graph import build

#: a board on a post that leans to the left, its other end on a post to the right: level, or upside down
BOARD = """{spatial} model Flip
  Ground ground;
  Body left(m = 1 kg, I = 0.1 kg.m2, frames(a = {{-0.5, 0{z}}} m, b = {{0.5, 0{z}}} m));
  Body board(m = 2 kg, I = 0.5 kg.m2);
  {more}
  Revolute A(ground, left.a);
  Revolute B(left.b, board.c);
  Frame pole(ground, r = {{1 m, 0.17364817766693 m{z}}});
  {slot}
  RotationalDriver drive(ground, left.a, phi = {angle} deg + 1 deg/s*time);
{initial}
  annotation(experiment(StopTime = 0.1 s));
end Flip;"""
PLANE = "PointOnLine slot(board.c, pole);"
SPACE = "PointOnPlane slot(board.c, pole, n = {0, 1, 0});"


def text(spatial="", slot=None, initial="", more="", angle="170"):
    slot = slot or (SPACE if spatial else PLANE)
    z = ", 0" if spatial else ""
    return BOARD.format(spatial=spatial, slot=slot, initial=initial, more=more, angle=angle, z=z)


def start(text):
    run = mbdsl.simulate(mbdsl.parse(text), step=1e-2)
    return run, {name: np.degrees(run[name][0]) for name in ("board.phi", "B.phi")}


@pytest.mark.parametrize("spatial", ["", "spatial"])
def test_the_board_is_not_upside_down(spatial):
    """sin 170 deg is the height of both posts: the board is level, and B is at -170 deg."""
    run, found = start(text(spatial))
    assert found == pytest.approx({"board.phi": 0.0, "B.phi": -170.0}, abs=1e-9)
    assert any("board: assembled at" in x and "it would be at 180 deg" in x for x in run.stats["warnings"])


@pytest.mark.parametrize("spatial", ["", "spatial"])
@pytest.mark.parametrize("given", ["guess board.phi = 175 deg;", "B.phi = 10 deg;", "guess B.phi = 20 deg;"])
def test_what_the_model_gives_decides(spatial, given):
    _, found = start(text(spatial, initial=f"initial equation {given}"))
    assert found["board.phi"] % 360.0 == pytest.approx(180.0, abs=1e-9)


def test_what_hangs_on_the_board_turns_with_it():
    """A load that is hinged to the board, without a value: it was placed at 170 deg, and keeps that as seen from the
    board."""
    more = "Rod load(m = 1 kg, length = 0.2 m); Revolute C(board.c, load.a);"
    run, found = start(text(more=more))
    assert found["board.phi"] == pytest.approx(0.0, abs=1e-9)
    assert np.degrees(run["C.phi"][0]) == pytest.approx(-10.0, abs=1e-9)


def test_an_open_chain_starts_in_line():
    """No loop holds the second rod: its joint starts at zero, as is documented."""
    run = mbdsl.simulate(
        mbdsl.parse("""model Chain
          Ground ground; Rod a(m = 1 kg, length = 1 m); Rod b(m = 1 kg, length = 1 m);
          Revolute A(ground, a.a); Revolute B(a.b, b.a);
        initial equation A.phi = 170 deg;
          annotation(experiment(StopTime = 0.1 s));
        end Chain;"""),
        step=1e-2,
    )
    assert np.degrees(run["b.phi"][0]) == pytest.approx(170.0)


@pytest.mark.parametrize("crank", [60.0, 120.0])
def test_branches_of_a_four_bar_are_not_exchanged(crank):
    """The other branch moves several bodies: the one near the placement stays, whatever the angles of its bodies are.

    Both branches by the law of cosines; the crossed one has the coupler below the diagonal.
    """
    run = mbdsl.simulate(
        mbdsl.parse(f"""model FourBar
          Ground ground(frames(C = {{1 m, 0}}));
          Rod crank(m = 1 kg, length = 0.4 m); Rod coupler(m = 1 kg, length = 0.9 m);
          Rod rocker(m = 1 kg, length = 0.8 m);
          Revolute A(ground, crank.a); Revolute B(crank.b, coupler.a);
          Revolute C(coupler.b, rocker.a); Revolute D(ground.C, rocker.b);
        initial equation crank.phi = {crank} deg; guess coupler.phi = 20 deg;
          annotation(experiment(StopTime = 0.1 s));
        end FourBar;"""),
        step=1e-2,
    )
    tip = 0.4 * np.exp(1j * np.radians(crank))
    line = 1.0 - tip
    inner = np.arccos((0.9**2 + abs(line) ** 2 - 0.8**2) / (2 * 0.9 * abs(line)))
    assert run["coupler.phi"][0] == pytest.approx(np.angle(line) + inner, abs=1e-9)


@pytest.mark.parametrize("spatial", ["", "spatial "])
def test_bodies_that_had_to_turn_far_are_named(spatial):
    """A gear of ratio -1 turns the wheel to -135 deg, where no value was given."""
    gear = "Gear mesh(a.c, b.c, ratio = -1);" if spatial else "GearPair mesh(a.c, b.c, r_a = 0.5 m, r_b = 0.5 m);"
    lines = check_start(
        build(
            mbdsl.parse(f"""{spatial}model Wheels
              Ground ground(frames(right = {{1, 0{", 0" if spatial else ""}}} m));
              Body a(m = 1 kg, I = 1 kg.m2); Body b(m = 1 kg, I = 1 kg.m2);
              Revolute A(ground, a.c); Revolute B(ground.right, b.c); {gear}
            initial equation fixed A.phi = 135 deg;
            end Wheels;""")
        )
    )
    assert "b: turned by 135 deg from where it was placed, to be assembled" in lines
