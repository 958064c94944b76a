"""`mbdsl check` assembles: what cannot be assembled, with names, source lines, and values as they were written."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from mbdsl import simulate
from mbdsl.compilation import code_cache
from mbdsl.errors import InitialisationError
from mbdsl.initial.consistent import initial_state
from mbdsl.initial.start_check import check_start
from mbdsl.lang.load import load, parse_text
from mbdsl.mechanism.assembly_need import has_to_be_assembled
from mbdsl.mechanism.graph import build
from mbdsl.system import build as system_of

MODELS = Path(__file__).parents[3] / "models"
PENDULUM = """\
model M
  Ground ground;
  Rod rod(m = 1 kg, length = 300 mm);
  Revolute pin(ground, rod.a);
{more}
end M;
"""
TEXT = "def f(x):\n    return 2.0*x\n"
OTHER = "  Rod other(m = 1 kg, length = 1 m);\n"
FREE = "  PointMass ball(m = 1 kg);\n  FreeMotion free(ground, ball);\n"
LOOP = """\
model M
  Ground ground;
  Frame wall(ground, r = {2 m, 0 m});
  Rod crank(m = 1 kg, length = 300 mm);
  Rod rod(m = 1 kg, length = 600 mm);
  Revolute O(ground, crank.a);
  Revolute A(crank.b, rod.a);
  Revolute B(rod.b, wall);
end M;
"""


@pytest.fixture
def check(say, tmp_path):
    """Check a text, or a PENDULUM with more lines."""

    def run(text, *words):
        text = text if text.startswith(("model", "spatial")) else PENDULUM.replace("{more}", text)
        (tmp_path / "m.mbd").write_text(text, encoding="utf-8")
        return say("check", "m.mbd", *words)

    return run


# -- found ----------------------------------------------------------------------------------------------------------
def test_a_loop_that_cannot_close(check):
    """The bars of 0.3 and 0.6 m are 1.1 m short; in the least-squares solution each of three pins takes a third."""
    code, out, err = check(LOOP)
    assert code == 3
    assert out.splitlines()[0] == "M: 2 bodies, 3 joints, 0 forces, 1 independent loop"
    assert "assembled" not in out
    assert err.startswith("m.mbd:6:12: error: no consistent initial positions found at time 0\n")
    for line, name in ((6, "O"), (7, "A"), (8, "B")):
        assert f"m.mbd:{line}:12: note: Revolute {name} is violated by 0.367 m\n" in err


@pytest.mark.parametrize(
    ("lines", "first", "second"),
    [
        # an angle demanded to be 30 and 40 deg is 35 deg in the least-squares solution
        (
            ("pin.phi = 2*tilt - 15 deg/3;", "rod.phi = 40 deg;"),
            "pin.phi = 30 deg # 35 deg",
            "rod.phi = 40 deg # 35 deg",
        ),
        (("rod.x = 150 mm;", "rod.y = 2 cm;"), "rod.x = 150 mm #", "rod.y = 2 cm #"),
        (("pin.w = 60 rpm;", "rod.w = 5;"), "pin.w = 60 rpm #", "rod.w = 5 rad/s #"),
    ],
)
def test_initial_values_that_contradict_each_other(check, lines, first, second):
    """Both are shown in the unit that they were written with, each with its line."""
    code, _, err = check("  parameter Angle tilt = 17.5 deg;\ninitial equation\n  " + "\n  ".join(lines))
    assert code == 3
    for place, text in ((7, first), (8, second)):
        assert f"m.mbd:{place}:3: note: {text.replace('#', 'is fixed, but comes out as')}" in err


def test_a_modifier_keeps_its_unit(check):
    text = PENDULUM.replace("pin(ground, rod.a)", "pin(ground, rod.a, phi(start = 30 deg, fixed = true))")
    _, _, err = check(text.replace("{more}", "initial equation\n  rod.phi = 700 mrad;"))
    assert "pin.phi = 30 deg is fixed" in err and "rod.phi = 700 mrad is fixed" in err


def test_a_value_of_the_command_line_keeps_its_unit(check):
    text = "  parameter Angle angle = 0;\ninitial equation\n  pin.phi = angle;\n  rod.phi = 40 deg;"
    assert "pin.phi = 20 deg is fixed" in check(text, "--set", "angle=20 deg")[2]


def test_masses_that_make_the_equations_singular(check):
    code, _, err = check(PENDULUM.replace("m = 1 kg", "m = 0 kg").replace("{more}", ""))
    assert (code, err) == (
        3,
        "m.mbd:3:7: error: the mass matrix is singular: rod can move without moving a mass\n"
        "      Rod rod(m = 0 kg, length = 300 mm);\n          ^^^\n"
        "m.mbd:3:7: note: Rod rod has m = 0 and I = 0\n"
        "      Rod rod(m = 0 kg, length = 300 mm);\n          ^^^\n"
        "  = give it a mass and a moment of inertia, or hold it by further joints\n",
    )


def test_a_body_without_inertia_that_can_turn_is_named_alone(check):
    """The mass of a Body without I moves on a line; its rotation about its centre of mass moves nothing."""
    text = """model M
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Body wheel(m = 2 kg, I = 0 kg.m2);
  Revolute pin(ground, rod.a);
  Revolute hub(rod.b, wheel.c);
end M;
"""
    code, _, err = check(text)
    assert code == 3 and "note: Body wheel has I = 0\n" in err and "Rod rod has" not in err


@pytest.mark.parametrize(
    "text",
    [
        # the mass at its end moves with every motion of the massless link
        "  Rod link(m = 0 kg, length = 1 m);\n  Revolute tip(rod.b, link.a);\n"
        "  PointMass ball(m = 1 kg);\n  Revolute far(link.b, ball);",
        # the rod carries it
        "  Rod link(m = 0 kg, length = 1 m);\n  Fixed weld(rod.b, link.a);",
    ],
)
def test_massless_bodies_that_move_masses_are_accepted(check, text):
    assert check(text)[0] == 0


def test_a_massless_slider_between_springs_is_accepted(check):
    """Stiffness determines its position, although nothing accelerates it."""
    text = """model M
  Ground ground;
  Frame far(ground, r = {2 m, 0 m});
  Body slider(m = 0 kg, I = 0 kg.m2);
  Prismatic guide(ground, slider.c);
  SpringDamper one(ground.c, slider.c, k = {k}, s0 = 1 m);
  SpringDamper two(slider.c, far, k = {k}, s0 = 1 m);
initial equation
  guide.s = 1 m;
end M;
"""
    code, out, _ = check(text.replace("{k}", "10 N/m"))
    assert code == 0 and "slider can move without moving a mass; springs alone determine where it is" in out
    code, _, err = check(text.replace("{k}", "0 N/m"))
    assert code == 3 and "slider can move without moving a mass" in err


def test_the_start_of_a_simulation_names_them_too():
    """A torque acts on the massless rod: no acceleration satisfies the equations."""
    text = PENDULUM.replace("m = 1 kg", "m = 0 kg").replace("{more}", "  Torque motor(ground, rod.a, tau = 1 N.m);")
    with code_cache.uncompiled():
        system = system_of(parse_text(text))
        with pytest.raises(InitialisationError, match="rod can move without moving a mass"):
            initial_state(system, system.graph, 0.0)


# -- reported -------------------------------------------------------------------------------------------------------
def test_guesses_that_move_are_reported_as_they_were_written(say):
    """The slider is 150 mm + 450 mm ... from the geometry: x = L1 cos 30 + sqrt(L2^2 - (L1 sin 30)^2) for the crank."""
    code, out, err = say("check", MODELS / "driven_crank.mbd")
    assert (code, err) == (0, "")
    assert out.splitlines()[-2].startswith("assembled at t = 0 s; 1 guess moved: slider.x from 0.9 m to 0.84")


def test_redundant_constraints_are_reported(say):
    code, out, _ = say("check", MODELS / "hard" / "spare_rocker.mbd", "--allow-imports")
    lines = out.splitlines()
    assert code == 0 and lines[2] == "assembled at t = 0 s"
    assert lines[3] == "true mobility 1 = 12 coordinates - 11 independent constraint rows"
    assert lines[4] == "redundant: A3.Phi[2] follows from the other constraints"
    assert lines[5].startswith("  Revolute A3 (spare_rocker.mbd:14) follows from Revolute O1 (spare_rocker.mbd:9), ")


@pytest.mark.parametrize("spatial", [False, True])
def test_a_point_mass_on_a_rail_is_counted_without_its_attitude_and_contacts(check, spatial):
    """It has one degree of freedom; neither the row of a rigid contact nor that of friction that sticks counts."""
    code, out, _ = check(
        "model M\n  Ground g;\n  PointMass p(m = 1 kg);\n  Prismatic rail(g, p, mu = 0.1, sticks = true);\n"
        "  TranslationalStop buffer(rail, s_max = 1 m, e = 0.5);\nend M;\n".replace(
            "model", "spatial model" * spatial or "model", 1
        )
    )
    rows = (
        "3 coordinates - 2 independent constraint rows" if spatial else "2 coordinates - 1 independent constraint row"
    )
    assert code == 0 and f"\ntrue mobility 1 = {rows}\n" in out
    assert "  Prismatic rail (m.mbd:4) constrains the attitude of p, a point mass, which has none\n" in out


def test_it_can_be_skipped(check):
    code, out, err = check(LOOP, "--quick")
    assert (code, err) == (0, "") and "assembled" not in out


def test_large_models_are_not_assembled(monkeypatch):
    monkeypatch.setattr("mbdsl.initial.start_check.MOST", 10)
    graph = build(load(MODELS / "slider_crank.mbd"))
    assert check_start(graph) == ["not assembled: 11 unknowns, more than 10; mbdsl simulate assembles the model"]


def test_a_long_search_ends_with_the_worst_constraints(monkeypatch):
    monkeypatch.setattr("mbdsl.initial.start_check.LIMIT", 1e-9)
    first, second = check_start(build(parse_text(LOOP)))
    assert first.startswith("no consistent initial positions found within 1e-09 s; mbdsl simulate searches further")
    assert second.startswith("  the best so far: Revolute ")


# -- without compilation --------------------------------------------------------------------------------------------
def test_it_finds_what_simulate_finds():
    """The same state, by kernels run as Python and as machine code."""
    scene = load(MODELS / "slider_crank.mbd")
    states = []
    for _ in range(2):
        system = system_of(scene)
        with code_cache.uncompiled():
            states.append(initial_state(system, system.graph, 0.0))
    trajectory = simulate(scene, stop=0.0, step=1e-3)
    assert np.array_equal(states[0].q, states[1].q)
    # rounding of sums in another order
    assert np.abs(states[0].q - trajectory.q[0]).max() < 1e-14


def test_code_of_a_block_that_runs_as_python_is_not_kept():
    with code_cache.uncompiled():
        (f,) = code_cache.functions("mbdsl_test_plain", TEXT, {"f": code_cache.Signature(("float",))}, list)
        assert f(3.0) == 6.0 and "mbdsl_test_plain" not in code_cache._functions
    sys.modules.pop("mbdsl_test_plain", None)


# -- what has to be assembled ---------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ("", False),
        ("initial equation\n  rod.phi = 30 deg;\n  rod.w = 1 rad/s;", False),
        ("initial equation\n  pin.phi = 30 deg;\n  pin.w = 1 rad/s;", False),
        ("initial equation\n  guess rod.x = 1 m;\n  pin.phi = 30 deg;", False),
        ("initial equation\n  pin.phi = 30 deg;\n  rod.phi = 30 deg;", True),
        ("initial equation\n  rod.x = 0.1 m;", True),
        ("  Force f(rod.b, fx = 1 N);", False),
        ("  Force f(rod.b, fx = 1/time);", True),
        ("  RotationalDriver drive(ground, rod.a, phi = 1 rad/s*time);", True),
        ("  Rod light(m = 0 kg, length = 1 m);\n  Revolute tip(rod.b, light.a);", True),
        (f"{OTHER}  Prismatic slide(rod.b, other.a);\ninitial equation\n  slide.s = 1 m;", False),
        (f"{OTHER}  Prismatic slide(rod.b, other.a);\ninitial equation\n  other.x = 1 m;", True),
        ("  Distance string(rod.b, ground, length = 0.2 m);", True),
        (f"{FREE}initial equation\n  ball.x = 1 m;\n  ball.vy = 1 m/s;", False),
    ],
)
def test_what_has_to_be_assembled(more, expected):
    assert has_to_be_assembled(build(parse_text(PENDULUM.replace("{more}", more)))) is expected


@pytest.mark.parametrize("path", sorted(MODELS.glob("*.mbd")), ids=lambda path: path.stem)
def test_models_that_need_no_assembly_are_assembled_at_once(path):
    """Their guess is consistent: the assembly finds no redundant constraint and moves no fixed value."""
    graph = build(load(path))
    if not has_to_be_assembled(graph):
        assert check_start(graph)[0].startswith("assembled at t = 0 s") and len(check_start(graph)) == 2


def test_the_start_time_is_that_of_the_model():
    text = PENDULUM.replace("{more}", "  annotation(experiment(StartTime = 2 s, StopTime = 3 s));")
    assert check_start(build(parse_text(text)))[0] == "assembled at t = 2 s"


def test_misfits_of_angles_are_in_degrees_too(check):
    """A rod that is fixed at 0 and driven to 20 deg turns by nothing: the driver lacks all of them, or half."""
    text = """model M
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Fixed left(ground, rod.a);
  RotationalDriver right(ground, rod.b, phi = 20 deg);
end M;
"""
    code, _, err = check(text)
    print(err)
    assert code == 3
    assert "RotationalDriver right is violated by 0.175 rad (10 deg)" in err


@pytest.mark.parametrize(
    "model", [MODELS / "driven_crank.mbd", MODELS / "space" / "delta_robot.mbd"], ids=lambda m: m.stem
)
def test_a_search_that_ends_early_gives_closed_joints_or_says_how_far_they_are_open(model, monkeypatch):
    """A clock that ends the search after any number of iterations: a misfit of rounding is no open joint."""
    graph, ends = build(load(model)), []
    for most in (1, 3, 4, 5, 6, 8, 12):
        ticks = iter([0.0] * (most + 1))  # the first is that of the start of the search
        clock = lambda ticks=ticks: next(ticks, 1e9)  # noqa: E731
        monkeypatch.setattr("mbdsl.initial.start_check.process_time", clock)
        monkeypatch.setattr("mbdsl.initial.pose_search.process_time", clock)
        lines = check_start(graph)
        ends.append(lines[0].startswith("assembled"))
        assert ends[-1] or float(re.search(r"(?:open|violated) by ([-+.e\d]+)", lines[1])[1]) > 1e-12
    assert not ends[0] and ends[-1]
