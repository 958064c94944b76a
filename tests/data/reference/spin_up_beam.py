"""Spin-up of a beam (Simo and Vu-Quoc): writes spin_up_beam.json."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
from exudyn_cable import exudyn_cable
from large_rotation_beam import Beam
from scipy.interpolate import make_interp_spline

L, EA, EI, RHO_A, RHO_I = 10.0, 2.8e7, 1.4e4, 1.2, 6e-4
END, EACH = 20, 20  #: seconds, samples a second


def spin(t):
    """Angle of the hub, its rate and acceleration."""
    if t >= 15:
        return 6 * t - 45, 6.0, 0.0
    a = 2 * np.pi / 15
    return 0.4 * (t * t / 2 + (np.cos(a * t) - 1) / a**2), 0.4 * (t - np.sin(a * t) / a), 0.4 * (1 - np.cos(a * t))


def polynomials(degree, inertia, rtol):
    """Rows t, u1, u2, rotation of the tip."""
    beam = Beam(L, EA, EI, RHO_A, degree, rhoI=inertia, spin=spin)
    times = np.arange(END * EACH + 1) / EACH
    u, angle = beam.tip(beam.run(END, times, rtol=rtol, atol=rtol / 100))
    return np.column_stack([times, u.real, u.imag, angle])


def cables(n, step):
    """The same from n elements in Exudyn, each second."""
    t, z, slope = exudyn_cable(n, L, EA, EI, RHO_A, step, END, spin=spin, write=1.0)
    assert np.max(np.abs(t - np.arange(END + 1))) < 1e-9
    turn = np.exp(-1j * np.array([spin(x)[0] for x in t]))
    return np.column_stack([t, (z * turn).real - L, (z * turn).imag, np.angle(slope * turn)])


def largest(a, b):
    return [f"{e:.1e}" for e in np.max(np.abs(a - b), axis=0)[1:]]


def main():
    best, other = polynomials(12, RHO_I, 1e-9), polynomials(10, RHO_I, 1e-9)
    plain = polynomials(10, 0.0, 1e-9)
    seconds = best[::EACH]
    curve = make_interp_spline(best[:, 0], best[:, 2], 7)
    turning = curve.derivative()
    extreme = min((x for x in _zeros(turning, 6, 8)), key=curve)
    k = np.sqrt(RHO_A * 36 / EA)
    data = dict(
        problem="Spin-up of a beam clamped radially to the axis of a hub (Simo and Vu-Quoc, J. Appl. Mech. 53 (1986))",
        parameters=dict(
            L=L,
            EA=EA,
            EI=EI,
            rhoA=RHO_A,
            rotary_inertia=RHO_I,
            psi="6/15 (t^2/2 + (15/(2 pi))^2 (cos(2 pi t/15) - 1)) up to 15 s, then 6 t - 45",
            beam="shear-rigid, strain |r'| - 1, moment EI times the arc angle's derivative by x; no gravity or damping",
        ),
        columns=[
            "t",
            "u1 (along the turning axis)",
            "u2 (across, counterclockwise)",
            "rotation of the tip against the hub",
        ],
        rows=seconds[1:].tolist(),
        without_rotary_inertia=plain[::EACH][1:].tolist(),
        extreme_u2=dict(t=float(extreme), u2=float(curve(extreme))),
        steady_u1=dict(value=float(np.tan(k * L) / k - L), formula="tan(k L)/k - L, k^2 = rhoA 36/EA, straight beam"),
        agreement=dict(
            columns="largest differences of u1, u2, rotation over t = 1, 2, .. 20 s",
            polynomials_of_degree_12_and_10=largest(seconds, other[::EACH]),
            without_rotary_inertia_exudyn_16_elements_step_1e_3=largest(plain[::EACH], cables(16, 1e-3)),
            without_rotary_inertia_exudyn_16_elements_step_5e_4=largest(plain[::EACH], cables(16, 5e-4)),
            without_rotary_inertia_exudyn_8_elements_step_5e_4=largest(plain[::EACH], cables(8, 5e-4)),
            effect_of_rotary_inertia=largest(other[::EACH], plain[::EACH]),
        ),
        trusted_digits="u2 and rotation 1e-8 absolute, u1 1e-9 absolute, by the two degrees; 1e-5 confirmed by Exudyn",
        verified_by=(
            "spin_up_beam.py: one polynomial over the beam in the turning frame (large_rotation_beam.py), DOP853; "
            "Exudyn 1.13.6, ObjectANCFCable2D in the inertial frame, which has no rotary inertia (exudyn_cable.py)"
        ),
    )
    Path(__file__).with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n")


def _zeros(f, a, b):
    x = np.linspace(a, b, 2001)
    for lo, hi in pairwise(x):
        if f(lo) <= 0 < f(hi):
            yield lo - f(lo) * (hi - lo) / (f(hi) - f(lo))


if __name__ == "__main__":
    main()
