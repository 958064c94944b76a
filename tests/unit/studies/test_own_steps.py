"""Studies measure at the ends of steps; the selection of these steps."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import UsageError
from mbdsl.studies.cases import Case, setting
from mbdsl.studies.convergence import convergence
from mbdsl.studies.drift import drift
from mbdsl.studies.energy import energy
from mbdsl.studies.runtime import runtime
from mbdsl.studies.store import key_of
from mbdsl.studies.work_precision import work_precision

MODELS = Path(__file__).parents[3] / "models"
CRANK, PENDULUM = MODELS / "slider_crank.mbd", MODELS / "pendulum.mbd"


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """A store, so that references are computed once; half a second of motion."""
    return {"store": tmp_path_factory.mktemp("store"), "stop": 0.5, "workers": 1, "budget": 1e3}


@pytest.mark.parametrize("sizes", [{}, {"steps": [4.1e-3, 1.7e-3]}, {"tols": [1e-4]}])
def test_what_is_left_of_constraints_is_seen_where_steps_end(given, sizes):
    """Between steps, interpolation moves positions off the constraints, by a thousand times more."""
    found = drift(CRANK, methods=["hht-si2"], **sizes, **given)
    for row in found.survey.rows:
        run = mbdsl.simulate(CRANK, method="hht-si2", step=row.case.step, tol=row.case.tol, stop=0.5, interval=0.0)
        for key in ("Phi", "dPhi"):
            most = max(np.abs(run[name]).max() for name in run.select([f"*.{key}[*]"]))
            assert row.errors[key].largest <= most + 1e-13, (row.case, key)
        assert row.errors["Phi"].largest < 1e-12 and row.errors["dPhi"].largest < 1e-10
        assert not [line for line in found.summary() if "interpolated" in line]


def test_a_long_run_is_not_kept_as_a_whole(given):
    (row,) = drift(CRANK, methods=["hht-si2"], steps=[1.1e-5], **given).survey.rows
    assert row.run.stats["steps"] == 45455 and len(row.own.t) <= 501
    assert row.own.t[-1] == pytest.approx(0.5) and row.errors["Phi"].largest < 1e-14
    (row,) = drift(CRANK, methods=["hht-si2"], tols=[1e-6], **given).survey.rows
    assert row.run.stats["steps"] > 3000 and len(row.own.t) == 501


def test_a_case_goes_to_another_process_as_it_is():
    of = setting(CRANK, 0.5)
    case = Case("hht-si2", tol=1e-3, options=(("alpha", -0.1),), ends=True)
    there, at_home = pickle.loads(pickle.dumps((of, case))), (of, case)
    assert there[1] == case and there[0].scene == of.scene
    assert key_of(*there) == key_of(*at_home)


def test_what_could_not_be_run_again_is_told(given, monkeypatch):
    """A run with too many steps is measured at the output times alone."""
    monkeypatch.setattr("mbdsl.studies.survey.MANY", 100)
    found = drift(CRANK, methods=["hht-si2"], tols=[1e-4], **given)
    assert "Constraints and energy of 1 case are those of output interpolated between steps." in found.summary()
    assert found.survey.rows[0].errors["dPhi"].largest > 1e-8  # a thousand times the value at the ends of steps


def test_energy_is_seen_where_steps_end(given):
    """Interpolated velocities have a different energy."""
    found = energy(PENDULUM, methods=["hht-si2"], tols=[1e-4], **given)
    (row,) = found.survey.rows
    E = mbdsl.simulate(PENDULUM, method="hht-si2", tol=1e-4, stop=0.5, interval=0.0)["energy.total"]
    t, e = found.error(row)
    assert found.conserved and len(t) == min(len(E), 501)
    # a mean over time, not over steps
    assert found.mean(row) == pytest.approx(np.interp(np.linspace(0.0, 0.5, 20001), t, np.abs(e)).mean(), rel=1e-3)
    compared = convergence(PENDULUM, methods=["hht-si2"], tols=[1e-4], **given)
    assert compared.survey.rows[0].errors["energy"].largest == pytest.approx(np.abs(e).max(), rel=1e-6)
    assert np.abs(e).max() <= np.abs(E - E[0]).max() * (1.0 + 1e-9)


def test_the_steps_around_the_own_reach_the_output_times(given):
    for study in (energy, drift):
        found = study(CRANK, methods=["hht-si2"], **given)
        assert [row.trajectory is row.own for row in found.survey.rows] == [True] * len(found.survey.rows)
    found = energy(CRANK, methods=["hht-si2"], **given)
    assert not found.conserved and found.slope(found.survey.rows).count == 5
    assert [row.run.stats["steps"] for row in found.survey.rows] == [100, 200, 400, 800, 1600]


def test_steps_are_those_that_are_taken(given):
    short = {**given, "stop": 0.1}
    found = convergence(CRANK, methods=["hht-si2"], steps=[36e-3, 18e-3, 9e-3, 4.5e-3, 4.4e-3], **short)
    assert [row.case.step for row in found.survey.rows] == pytest.approx([0.1 / n for n in (3, 6, 12, 23)])
    assert [row.run.stats["steps"] for row in found.survey.rows] == [3, 6, 12, 23]
    assert "does not converge" not in str(found)
    twice = convergence(CRANK, methods=["hht-si2"], steps=[2e-3, 2e-3, 1e-3, 5e-4], tols=[1e-4, 1e-4], **short)
    assert [row.case.size for row in twice.survey.rows] == [2e-3, 1e-3, 5e-4, 1e-4]
    assert twice.fits["hht-si2"]["q"].count == 3
    with pytest.raises(UsageError, match=r"a step of 0.4 s is longer than the studied time, 0.1 s"):
        convergence(CRANK, methods=["hht-si2"], steps=[0.4, 0.1], **short)
    with pytest.raises(UsageError, match="-1 is not a step"):
        convergence(CRANK, methods=["hht-si2"], steps=[-1.0, 0.1], **short)


@pytest.mark.parametrize("study", [convergence, energy, drift, runtime, work_precision])
def test_nothing_to_run_is_said_before_anything_is(study, given):
    with pytest.raises(UsageError, match="nothing to run: scipy-dop853: it has no fixed steps"):
        study(CRANK, methods=["scipy-dop853"], steps=[1e-3], **given)
    with pytest.raises(UsageError, match="steps without any"):
        study(CRANK, methods=["hht-si2"], steps=[], **given)
