"""Steps of controlled size: estimates of local errors, variable steps, and the events around them."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators import available, compiled, modules
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.compiled_loop import controls_locally
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism import graph
from mbdsl.system import build
from mbdsl.system.accelerations import accelerations

MODELS = Path(__file__).parents[3] / "models"
METHODS = [name for name, method in compiled().items() if controls_locally(name) and "controlled" in method.steps]
#: so large that no step is rejected
ANY = 0.999


def oscillator(w=1.0):
    b = mbdsl.Builder("Oscillator")
    body = b.Body("body", m=1.0, I=1.0)
    b.Bushing("spring", b.Ground("ground", g=0.0), body.c, k=(w * w, 1.0), k_phi=1.0)
    b.initial(body.x, 1.0)
    return b.scene()


def started(scene, method, h, stop, tol=None):
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    first = initial_state(system, mechanism, 0.0)
    run = MethodRun(system, method, h, 0.0, stop, np.array([]), tol=tol)
    run.begin(first.q, first.v, first.a, first.lam)
    return system, run


@pytest.mark.parametrize("method", METHODS)
def test_local_errors_add_up_to_the_error_attained(method):
    """x'' = -x from x = 1, at rest: the declared local errors, with the exact jerk sin t and snap cos t, carried to t =
    2 by the exact solution, are the error there, except for a part that vanishes with h. In a two-step method, the
    carry-over from the step before multiplies this by 1/(1 - 1/3)."""
    module, ratios = modules()[method], []
    local_error = module.local_error
    for h in (2e-2, 1e-2, 5e-3):
        system, run = started(oscillator(), method, h, 2.0)
        assert run.advance() == S.DONE
        k = system.names().index("body.x")
        t = np.arange(h, 2.0 + h / 2, h)
        e_q, e_v = (
            np.array(x)
            for x in zip(*(local_error(h, h, run.coefficients, np.sin(s), np.cos(s)) for s in t - h / 2), strict=True)
        )
        if module.METHOD.family == "BDF2":
            e_q, e_v = 1.5 * e_q, 1.5 * e_v
        left = 2.0 - t
        said = [np.sum(np.cos(left) * e_q + np.sin(left) * e_v), np.sum(-np.sin(left) * e_q + np.cos(left) * e_v)]
        q, v, _ = run.state()
        ratios.append([(np.cos(2.0) - q[k]) / said[0], (-np.sin(2.0) - v[k]) / said[1]])
    off = np.abs(np.array(ratios) - 1.0)
    assert (off[-1] < 0.03).all(), ratios
    assert (off[-1] < 0.7 * off[0]).all(), ratios  # towards 1


def prescribed(scene, method, steps):
    """A run with just these steps, which differ by factors of two at most, and the time it ends at."""
    system, run = started(scene, method, 1.0, 1e3, tol=ANY)
    first = initial_state(system, graph.build(scene), 0.0)
    run.begin(first.q, first.v, first.a, first.lam, h=float(steps[0]))
    run.reals[S.TOL] = 1e9
    for h in [*steps[1:], steps[-1]]:
        run.reals[S.MOST_H] = h
        assert run.advance(1) == S.RUNNING
    assert run.count("rejected") == 0 and run.steps == len(steps)
    return system, run


SEQUENCES = {
    "alternating": lambda n: np.where(np.arange(n) % 2, 2.0, 1.0),
    "random": lambda n: np.random.default_rng(3).uniform(0.71, 1.41, n),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_order_is_kept_whatever_the_steps(method, sequence):
    """In q, v and multipliers, on the slider crank at 0.4 s; the reference is hht-si2 at a fortieth of the step."""
    scene, T = mbdsl.load(MODELS / "slider_crank.mbd"), 0.4
    exact = [mbdsl.simulate(scene, method="hht-si2", step=h, stop=T, interval=T) for h in (4e-5, 2e-5)]
    q, v = (getattr(exact[1], x)[-1] + (getattr(exact[1], x)[-1] - getattr(exact[0], x)[-1]) / 3 for x in ("q", "v"))
    errors, sizes = [], (100, 200, 400, 800)
    for n in sizes:
        h = SEQUENCES[sequence](n)
        system, run = prescribed(scene, method, T * h / h.sum())
        assert run.time == pytest.approx(T, rel=1e-9)  # steps are rounded to the resolution of the stop time
        found = run.out, run.state()
        lam = accelerations(system, T, q, v)[1]
        parts = [np.abs(a - b).max() for a, b in zip(found[1], (q, v, lam), strict=True)]
        errors.append(parts if available()[method].own_reactions else parts[:2])
    slopes = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    order = available()[method].order
    assert (slopes > order - 0.25).all() and (slopes < order + 0.5).all(), slopes


@pytest.mark.parametrize("ratio", [0.2, 0.7, 1.0, 2.0])
def test_bdf2_is_exact_for_quadratics(ratio):
    from mbdsl.integrators.methods import nstiff

    run = SimpleNamespace(memory=np.zeros(4))
    nstiff.set_ratio(ratio, run)
    s_squared, s, p = run.memory[[nstiff.S_SQUARED, nstiff.S, nstiff.P]]
    h, last, s, s_squared = ratio, 1.0, s * ratio, s_squared * ratio**2
    for k in range(3):
        now, before, end = 0.0**k, (-last) ** k, h**k
        assert now + p * (now - before) + s * k * h ** (k - 1 if k else 0) == pytest.approx(end, abs=1e-14)
    assert s_squared == pytest.approx(s**2, rel=1e-14)


def test_few_changes_of_the_step(tmp_path):
    """The step is kept while the optimal one differs little: one matrix for a hundred steps, and hardly a rejected
    step."""
    run = mbdsl.simulate(MODELS / "slider_crank.mbd", tol=1e-6, method="hht-si2")
    assert run.stats["rejected"] < 0.01 * run.stats["steps"]
    assert run.stats["matrix_evaluations"] < 0.02 * run.stats["steps"]
    assert run.stats["h"] is None and run.stats["tol"] == 1e-6
    assert 0.0 < run.stats["error"] <= 1e-6


def test_every_step_is_written_and_the_last_ends_at_the_stop_time():
    run = mbdsl.simulate(MODELS / "slider_crank.mbd", tol=1e-6, stop=0.7, interval=0)
    h = np.diff(run.t)
    assert len(run.t) == run.stats["steps"] + 1 > 4096  # more outputs in one step than the buffer can hold
    assert run.t[0] == 0.0 and run.t[-1] == 0.7
    assert h.min() > 0.0
    assert h[-1] > 0.4 * h[-2]  # no rest


def test_parts_have_steps_of_their_own():
    text = """
model Two
  Ground ground;
  PointMass slow(m = 1 kg);
  PointMass fast(m = 1 kg);
  Bushing one(ground, slow, k = {1 N/m, 1 N/m});
  Bushing two(ground, fast, k = {400 N/m, 400 N/m});
initial equation
  slow.x = 1 m;
  fast.x = 1 m;
  annotation(experiment(StopTime = 3 s));
end Two;
"""
    scene = mbdsl.parse(text)
    for interval in (0, None):
        run = mbdsl.simulate(scene, tol=1e-5, interval=interval)
        assert run.stats["solved"]["parts"] == 2
        assert np.abs(run["slow.x"] - np.cos(run.t)).max() < 1e-4
        assert np.abs(run["fast.x"] - np.cos(20 * run.t)).max() < 1e-4


def test_what_is_determined_by_constraints_moves_in_small_steps():
    exact = mbdsl.simulate(MODELS / "driven_crank.mbd", step=1e-3)
    run = mbdsl.simulate(MODELS / "driven_crank.mbd", tol=1e-4)
    assert np.abs(run.q - exact.q).max() < 1e-12  # steps end at outputs
    every = mbdsl.simulate(MODELS / "driven_crank.mbd", tol=1e-4, interval=0)
    # only the rod is solved for; the crank is a function of time
    assert np.abs(np.diff(every["rod.phi"])).max() <= 0.1
    assert every.stats["steps"] < 200


def test_begin_anew_at_a_later_time():
    """A restart, as after a jump: the same motion from another time, with a history of its own."""
    system, run = started(oscillator(), "hht-si2", 1.0, 2.0, tol=1e-6)
    while run.time < 1.0:
        assert run.advance(1) == S.RUNNING
    t, (q, v, _) = run.time, (x.copy() for x in run.state())
    a, lam = accelerations(system, t, q, v)
    run.begin(q, v, a, lam, t=t)
    assert run.time == t
    while run.advance(1000) == S.RUNNING:
        pass
    assert run.time == 2.0
    assert run.state()[0][system.names().index("body.x")] == pytest.approx(np.cos(2.0), abs=2e-6)


def test_a_force_that_is_no_number_ends_it():
    text = """
model Gone
  Ground ground(g = 0);
  PointMass body(m = 1 kg);
  Force f(ground, body, fx = 1 N*sqrt(1 - time/1 s));
initial equation
  body.x = 0 m;
  annotation(experiment(StopTime = 2 s));
end Gone;
"""
    scene = mbdsl.parse(text)
    with pytest.raises(IntegrationError, match="not finite"):
        mbdsl.simulate(scene, tol=1e-4)


def test_rows_of_errors_are_apart():
    assert (
        len(
            {
                L.E_Q,
                L.E_V,
                L.E_X,
                L.TEMPORARY,
                L.TEMPORARY2,
                L.MULTIPLIED2,
            }
        )
        == 6
    )


def test_tolerance_of_the_model():
    """The default tolerance is used if neither the model nor the caller gives a Step or a Tolerance."""
    text = (MODELS / "rolling_disc.mbd").read_text(encoding="utf-8")
    assert "StopTime = 2 s)" in text
    scene = mbdsl.parse(text.replace("StopTime = 2 s)", "StopTime = 2 s, Tolerance = 1e-4)"))
    both = mbdsl.parse(text.replace("StopTime = 2 s)", "StopTime = 2 s, Tolerance = 1e-4, Step = 1 ms)"))
    said = []
    assert mbdsl.simulate(scene, announce=said.append).stats["tol"] == 1e-4
    assert not any("Tolerance" in line for line in said)
    assert mbdsl.simulate(scene, step=1e-2, announce=said.append).stats["tol"] is None
    assert mbdsl.simulate(both, announce=said.append).stats["h"] == 1e-3
    assert len([line for line in said if "Tolerance is not used" in line]) == 2
