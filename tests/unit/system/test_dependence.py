"""Joints that repeat others, contradict them, or meet in a singular pose are named with their lines."""

from pathlib import Path

import pytest

import mbdsl
from mbdsl.errors import InitialisationError, IntegrationError

HARD = Path(__file__).parents[3] / "models" / "hard"


def line_of(name, text):
    lines = (HARD / name).read_text(encoding="utf-8").splitlines()
    return f"{name}:{1 + next(k for k, line in enumerate(lines) if text in line)}"


def test_redundant_joints_are_told_with_those_they_follow_from():
    """The third rocker's pin, from all five others: the two loops that they make have one bar too many."""
    said = []
    mbdsl.simulate(HARD / "spare_rocker.mbd", step=1e-3, stop=2e-3, announce=said.append)
    notice = next(line for line in said if " follows from Revolute" in line)
    left_out, others = notice.split(" follows from ")
    assert left_out.strip() == f"Revolute A3 ({line_of('spare_rocker.mbd', 'Revolute A3')})"
    for joint in ("O1", "O2", "O3", "A1", "A2"):
        assert f"Revolute {joint} ({line_of('spare_rocker.mbd', f'Revolute {joint}')})" in others


def test_a_repeated_joint_follows_from_its_twin_alone():
    said = []
    mbdsl.simulate(HARD / "two_lengths.mbd", step=1e-3, stop=2e-3, announce=said.append)
    other, one = (line_of("two_lengths.mbd", f"Distance {name}") for name in ("other", "one"))
    assert f"  Distance other ({other}) follows from Distance one ({one})" in said


def test_a_misfit_that_is_let_pass_is_told():
    """Joints may close to some 1e-10 of the size; the run then reports that they do not close to rounding."""
    for misfit, expected in ((0.0, False), (1e-15, False), (1e-10, True)):
        said = []
        mbdsl.simulate(
            HARD / "two_lengths.mbd", step=1e-3, stop=2e-3, announce=said.append, parameters={"misfit": misfit}
        )
        assert any("its misfit is" in line for line in said) is expected, misfit


@pytest.mark.parametrize("misfit", [1e-8, 1e-6, 1e-3, 0.1])
def test_contradictory_joints_are_named_however_small_the_misfit_is(misfit):
    with pytest.raises(InitialisationError) as caught:
        mbdsl.simulate(HARD / "spare_rocker.mbd", step=1e-3, stop=2e-3, parameters={"misfit": misfit})
    said = caught.value.render()
    for joint in ("O1", "O2", "O3", "A1", "A2", "A3"):
        assert f"{line_of('spare_rocker.mbd', f'Revolute {joint}')}:" in said
        assert f"Revolute {joint} is violated by" in said


@pytest.mark.parametrize("how", [{"step": 1e-3}, {"tol": 1e-4}])
def test_a_singular_pose_is_named_where_a_run_stops(how):
    """Stretched out, the arm's pins and the actuator along it depend on each other."""
    with pytest.raises(IntegrationError) as caught:
        mbdsl.simulate(HARD / "beyond_reach.mbd", stop=2.0, **how)
    assert "the pose is singular, or close to it" in caught.value.message
    assert all(name in caught.value.message.split("close to it")[1] for name in ("O", "A", "actuator"))


def test_a_run_that_stops_elsewhere_says_nothing_of_poses():
    with pytest.raises(IntegrationError) as caught:
        mbdsl.simulate(HARD / "pole.mbd", stop=2.0, step=1e-3)
    assert "singular" not in caught.value.message
