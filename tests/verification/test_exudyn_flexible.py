"""The flexible slider crank with a rod of ANCF cable elements, in another program: the same equations, other methods.

Values and their error bounds: exudyn_flexible_slider_crank.json, whose results with different steps and elements differ
by less. Differences at 0.1 s are those of the deflection's vibration, at 0.5 s the error of phi1 due to Exudyn's Newton
tolerance.
"""

import numpy as np
import pytest

import mbdsl

ROD = "modes = modes,\n                   stiffening = false"
#: t -> trusted: phi1 [rad], phi1' [rad/s], deflection [m]
TRUSTED = {0.1: (1e-7, 1e-3, 1e-7), 0.25: (5e-6, 1e-3, 5e-7), 0.5: (5e-6, 1e-3, 5e-7)}


@pytest.fixture(scope="module")
def cable(model, tmp_path_factory):
    """``cable(elements)``: times (3,) of phi1, phi1', the deflection and x of B."""
    text = model("flexible_slider_crank").read_text(encoding="utf-8")
    assert ROD in text

    def find(elements, h):
        path = tmp_path_factory.mktemp("cable") / "cable.mbd"
        path.write_text(text.replace(ROD, f'formulation = "ancf", elements = {elements}'), encoding="utf-8")
        run = mbdsl.simulate(path, method="hht-si2", step=h, stop=0.5, interval=0.05, options={"alpha": -0.05})
        k = [int(np.abs(run.t - t).argmin()) for t in TRUSTED]
        ax, ay, bx, by = (run[f"rod.{f}.{x}"][k] for f in "ab" for x in "xy")
        deflection = ((bx - ax) * (run["rod.y"][k] - ay) - (by - ay) * (run["rod.x"][k] - ax)) / np.hypot(
            bx - ax, by - ay
        )
        return np.stack([run["crank.phi"][k], run["crank.w"][k], deflection, bx], axis=1)

    return find


def rows(reference, elements, step):
    (run,) = (
        r for r in reference("exudyn_flexible_slider_crank")["runs"] if (r["elements"], r["step"]) == (elements, step)
    )
    return np.array(run["rows"])[: len(TRUSTED), 1:]


@pytest.mark.parametrize("elements", [8, 16])
def test_agrees(cable, reference, elements):
    difference = np.abs(cable(elements, 1e-5) - rows(reference, elements, 2e-5))[:, :3]
    assert (difference < np.array(list(TRUSTED.values()))).all(), difference


def test_trust_is_what_the_other_programs_own_runs_differ_by(reference):
    """Between its two finest steps with 16 elements; the bounds above are not much more."""
    own = np.abs(rows(reference, 16, 5e-5) - rows(reference, 16, 2e-5))[:, :3]
    assert (own < np.array(list(TRUSTED.values()))).all()
    assert (own.max(axis=0) > np.array(list(TRUSTED.values())).max(axis=0) / 50).all()
