"""The answers: ``python tests/verification/claims/reference.py [NAME ...]`` writes tests/data/claims/FAMILY.json.

Closed forms where they exist; otherwise SciPy's DOP853 at rtol 1e-13 in minimal coordinates, restarted at every output,
at every time that the model names and at every switch, which is located by integrating up to it, not by interpolation;
equations of motion from poses by hand, with second-order jets. A second solver, of another kind and at 1e-11, gives the
number of correct digits: ``agrees`` is the largest difference, positions over their largest, velocities likewise. mbdsl
takes no part.
"""

from __future__ import annotations

import json
import sys
from time import perf_counter

import numpy as np
from claim import DATA, Claim
from jets import Jet, jet
from scipy.integrate import DOP853, LSODA

from models import CLAIMS

GRAZE = 1e-15  #: in the unit of the switch: less does not count as a crossing


def accelerations(claim: Claim):
    """z''(t, z, z', on) of a mechanism: M z'' = J^T (F - m J' z')."""

    def rate(t, z, v, on):
        # one pass: along each coordinate alone, and last along the motion
        n = len(z)
        found = claim.pose([Jet(z[k], np.append(np.eye(n)[k], v[k]), 0.0) for k in range(n)], Jet(t, clock[n], 0.0))
        poses = {b: [jet(x) if x is not None else nothing for x in of] for b, of in found.items()}
        J = {b: np.array([x.d + zero[n] for x in of]) for b, of in poses.items()}
        M, Q = np.zeros((n, n)), np.zeros(n)
        if claim.loads:
            p = {b: [x.f for x in of] for b, of in poses.items()}
            for b, force in claim.loads(t, p, {b: J[b][:, n] for b in J}, on).items():
                Q += np.dot(force, J[b][:, :n])
        for b, (m, I) in claim.masses.items():
            inertia, columns = np.array([m, m, I]), J[b][:, :n]
            bias = np.array([(x.e + zero[n])[n] for x in poses[b]]) + [0.0, claim.g, 0.0]
            M += columns.T @ (inertia[:, None] * columns)
            Q -= columns.T @ (inertia * bias)
        return Q / M[0] if n == 1 else np.linalg.solve(M, Q)

    nothing = Jet(0.0)
    zero = {n: np.zeros(n + 1) for n in range(1, 9)}
    clock = {n: np.append(np.zeros(n), 1.0) for n in range(1, 9)}
    return rate


def first_crossing(values, on, t, y, run):
    """(switch, from, to) of the first crossing in the last step of ``run``, or None.

    Searched at eight points inside the step, and at the extremum between any three.
    """
    inside = run.dense_output()
    at = np.linspace(t, run.t, 9)
    at[-1] = run.t
    side = np.where(on, 1.0, -1.0)
    g = np.array([values(x, y if k == 0 else run.y if k == 8 else inside(x)) for k, x in enumerate(at)]) * side
    found = []
    for i in range(len(on)):
        for k in range(1, 9):
            if g[k, i] < -GRAZE:
                found.append((at[k - 1], i, at[k]))
                break
            if k < 8 and g[k, i] < g[k - 1, i] and g[k, i] <= g[k + 1, i]:
                bend = g[k - 1, i] - 2 * g[k, i] + g[k + 1, i]
                x = at[k] + 0.5 * (g[k - 1, i] - g[k + 1, i]) / bend * (at[1] - at[0])
                if values(x, inside(x))[i] * side[i] < -GRAZE:
                    found.append((at[k - 1], i, x))
                    break
    if not found:
        return None
    # the earliest, where several are in one interval
    finer = []
    for low, i, high in found:
        a, b = low, high
        for _ in range(50):
            mid = 0.5 * (a + b)
            a, b = (a, mid) if values(mid, inside(mid))[i] * side[i] < -GRAZE else (mid, b)
        finer.append((b, i, low, high))
    _, i, low, high = min(finer)
    return i, low, high


def integrate(claim: Claim, solver, rtol: float) -> tuple[np.ndarray, np.ndarray, list]:
    """z and z' at the outputs, and (t, z, z') at the largest value of each z': mostly between two outputs."""
    rate = claim.rate or accelerations(claim)
    n = len(claim.z)
    y = np.array([*claim.z, *claim.v], float)
    switches = claim.switches or (lambda t, z, v: ())
    on: list[bool] = [x > 0 for x in switches(0.0, y[:n], y[n:])]

    def fun(t, y):
        return np.concatenate([y[n:], np.atleast_1d(rate(t, y[:n], y[n:], on))])

    def values(t, y):
        return np.array(switches(t, y[:n], y[n:]))

    def advance(t, y, end, step=None):
        """From t to end without switches, by one or more steps."""
        if not end > t:
            return y
        run = solver(fun, t, y, end, rtol=rtol, atol=atol, first_step=step)
        while run.status == "running":
            run.step()
        if run.status == "failed":
            raise RuntimeError(f"{claim.name}: {solver.__name__} fails at {run.t}")
        return run.y

    found = []
    fastest = [(0.0, y)] * n
    times = claim.times
    corners = [b for b in claim.breaks if 0 < b < claim.stop and np.abs(times - b).min() > 1e-9]
    stops = np.unique(np.concatenate([times, corners]))
    atol = claim.atol * (1.0 if rtol < 1e-12 else 100.0)
    t, h = 0.0, None
    for end in stops:
        while t < end:
            run = solver(fun, t, y, end, rtol=rtol, atol=atol, first_step=min(h, end - t) if h else None)
            crossed = False
            while run.status == "running" and not crossed:
                t_before, was = run.t, run.y.copy()
                run.step()
                if run.status == "failed":
                    raise RuntimeError(f"{claim.name}: {solver.__name__} fails at {run.t}")
                h = run.step_size
                at = first_crossing(values, on, t_before, was, run) if on else None
                if at is None:
                    faster = np.abs(run.y[n:]) > [abs(y[n + k]) for k, (_, y) in enumerate(fastest)]
                    fastest = [(run.t, run.y) if more else x for x, more in zip(fastest, faster, strict=True)]
                    continue
                i, low, high = at
                # located by integration from the step's start: regula falsi (Illinois)
                fl, fh, side = (
                    values(low, advance(t_before, was, low))[i],
                    values(high, advance(t_before, was, high))[i],
                    0,
                )
                for _ in range(80):
                    mid = (low * fh - high * fl) / (fh - fl) if fh != fl else 0.5 * (low + high)
                    if (fl > 0) == (fh > 0) or not low < mid < high:
                        break
                    fm = values(mid, advance(t_before, was, mid))[i]
                    if (fm > 0) == (fh > 0):
                        high, fh = mid, fm
                        fl, side = (fl / 2, 1) if side == 1 else (fl, 1)
                    else:
                        low, fl = mid, fm
                        fh, side = (fh / 2, -1) if side == -1 else (fh, -1)
                t, y = high, advance(t_before, was, high)
                on[i] = not on[i]
                crossed, h = True, None
            if not crossed:
                t, y = end, run.y
        if (times == end).any():
            found.append(y.copy())
    found = np.array(found)
    return found[:, :n], found[:, n:], [(t, y[:n].tolist(), y[n:].tolist()) for t, y in fastest]


def answer(claim: Claim) -> dict:
    if claim.exact is not None:
        z, v = (np.array(x, float) for x in claim.exact(claim.times))
        z, v = (x[:, None] if x.ndim == 1 else x for x in (z, v))
        return {"source": "closed form", "agrees": claim.rounding, "z": z.tolist(), "v": v.tolist()}
    one, two = DOP853, LSODA
    z, v, fastest = integrate(claim, one, 1e-13)
    z2, v2, _ = integrate(claim, two, 1e-11)
    agrees = max(float(np.abs(a - b).max() / max(np.abs(a).max(), 1e-300)) for a, b in ((z, z2), (v, v2)))
    source = f"SciPy {one.__name__} at 1e-13 in minimal coordinates, checked by {two.__name__} at 1e-11"
    found = {"source": source, "agrees": float(f"{agrees:.1e}"), "z": z.tolist(), "v": v.tolist()}
    return {**found, "fastest": fastest}


def main(names: list[str]) -> None:
    DATA.mkdir(parents=True, exist_ok=True)
    for name, claim in CLAIMS.items():
        path = DATA / f"{claim.family}.json"
        known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        if names and name not in names and claim.family not in names:
            continue
        if not names and name in known:
            continue
        begun = perf_counter()
        try:
            known[name] = answer(claim)
        except Exception as problem:
            print(f"{name}: {type(problem).__name__}: {problem}", flush=True)
            continue
        text = ",\n".join(f"{json.dumps(key)}: {json.dumps(known[key])}" for key in sorted(known))
        path.write_text("{\n" + text + "\n}\n", encoding="utf-8")
        print(f"{name}: agrees to {known[name]['agrees']:.1e}, {perf_counter() - begun:.1f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
