"""Makes flexible_slider_crank_short.json: one bending and one axial mode, 5 ms to 50 ms.

Without mbdsl, by the equations of flexible_slider_crank.py: extrapolation in 80-bit arithmetic with two steps and
orders; how far DOP853 and Radau IIA, which solve the same problem by their own error control, are from it.
"""

import json
from pathlib import Path

import numpy as np
from flexible_slider_crank import HEAD, Crank, extrapolate, text
from scipy.integrate import solve_ivp

TIMES = [f"0.{k:03d}" for k in range(5, 51, 5)]


def by_extrapolation(model, per_second, k):
    y, states = model.start(), []
    for _ in TIMES:
        y = extrapolate(model.closed, y, per_second // 200, model.real(1) / per_second, k)
        states.append(y)
    return np.array(states)


def main():
    model, double = Crank(1, 1), Crank(1, 1, np.float64)
    y, other = by_extrapolation(model, 20000, 8), by_extrapolation(model, 16000, 9)
    scale = np.max(np.abs(y), axis=0)
    atol = np.array([1e-13, 1e-19, 1e-19, 1e-13, 1e-16, 1e-16])
    agreement = {"extrapolation with another step and order": other}
    for method, rates, rtol in (("DOP853", double.closed, 1e-13), ("Radau", double.nodes, 1e-11)):
        found = solve_ivp(
            lambda t, z, f=rates: f(z),
            (0, 0.05),
            model.start().astype(float),
            method=method,
            t_eval=[float(t) for t in TIMES],
            rtol=rtol,
            atol=atol,
        )
        agreement[f"{method}, rtol {rtol:g}"] = found.y.T
    rows = []
    for t, state in zip(TIMES, y, strict=True):
        out = model.closed(state, True)
        assert abs(out.pop("moment_balance_of_crank")) < 1e-12
        rows.append(dict(t=t) | text(out))
    data = dict(
        bending_modes=1,
        axial_modes=1,
        rows=rows,
        agreement={k: f"{float(np.max(np.abs(z - y) / scale)):.1e}" for k, z in agreement.items()},
    )
    head = {k: HEAD[k] for k in ("problem", "parameters", "shape_functions", "inertia", "constraint", "forces")}
    head["trusted_digits"] = "12, relative to the largest value of each quantity"
    head["verified_by"] = "agreement: largest differences of states, relative to the largest value of each"
    Path(__file__).with_suffix(".json").write_text(json.dumps(head | dict(data=data), indent=1) + "\n")


if __name__ == "__main__":
    main()
