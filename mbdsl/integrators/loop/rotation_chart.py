"""Rotations of bodies in space within a step: charts at its start, and axes of linear systems.

The coordinates of a rotation are the rotation vector psi from the attitude at the start of the step, so that the
formulas of a method are the same in the plane and in space, and one exponential a step gives the new attitude. When a
step is accepted, its attitude becomes the origin of the chart.

Matrices are in world axes, and residuals and corrections in body axes (:mod:`mbdsl.bodies.spatial_rigid_body_kernels`).
All loops here are empty for models in the plane.

Source: O. Bruels, A. Cardona, M. Arnold, Mech. Mach. Theory 48 (2012) 121-137; the axes of the linear systems are our
own.
"""

from math import sqrt

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel
from mbdsl.numerics.rotation import (
    BASE,
    chart_acceleration,
    composed,
    logarithm,
    spin_acceleration,
    tangled,
    tangled_back,
    turned,
    turned_back,
    untangled,
    untangled_back,
)


@kernel
def turn_axes(function, y, run):
    """Apply ``function(R, ...)`` to the rotational entries of y, with the attitudes R of the bodies."""
    layout = run.layout
    for k in range(layout[L.N_ROTATIONS]):
        d, at = layout[layout[L.ROTATIONS] + 2 * k], layout[layout[L.ROTATIONS] + 2 * k + 1]
        y[d], y[d + 1], y[d + 2] = function(run.numbers[at:], y[d], y[d + 1], y[d + 2])


@kernel
def to_world(row, run):
    """Turn the rotational entries of a row of ``vectors`` from body to world axes."""
    turn_axes(turned, run.vectors[row], run)


@kernel
def to_body(row, run):
    """Turn the rotational entries of a row of ``vectors`` from world to body axes."""
    turn_axes(turned_back, run.vectors[row], run)


@kernel
def to_rates(row, run):
    """Convert small rotations in a row of ``vectors`` to changes of psi: multiply them by T(psi)^{-1}."""
    convert(untangled, run.vectors[L.POSITION], run.vectors[row], run)


@kernel
def convert(function, q, y, run):
    """Apply ``function(psi, ...)`` to the rotational entries of y, with the rotation vectors psi in q."""
    layout = run.layout
    for k in range(layout[L.N_ROTATIONS]):
        d = layout[layout[L.ROTATIONS] + 2 * k]
        y[d], y[d + 1], y[d + 2] = function(q[d:], y[d], y[d + 1], y[d + 2])


@kernel
def from_rates(q, v, run):
    """In the velocities v at the coordinates q, replace psi' by the angular velocity T(psi) psi'."""
    convert(tangled, q, v, run)


@kernel
def to_second_rates(row, run):
    """Convert the accelerations in a row of ``vectors``, at POSITION and VELOCITY: replace Omega' by psi''."""
    layout, y, q, v = run.layout, run.vectors[row], run.vectors[L.POSITION], run.vectors[L.VELOCITY]
    for k in range(layout[L.N_ROTATIONS]):
        d = layout[layout[L.ROTATIONS] + 2 * k]
        y[d], y[d + 1], y[d + 2] = chart_acceleration(q[d:], v[d:], y[d], y[d + 1], y[d + 2])


@kernel
def from_chart(run):
    """Convert POSITION, VELOCITY, UNKNOWN and UNKNOWN2 of a stage: replace psi' by the angular velocity Omega =
    T(psi) psi', psi'' by Omega', and a further rate w of psi by T(psi) w."""
    layout, vectors = run.layout, run.vectors
    q, v, a, w = vectors[L.POSITION], vectors[L.VELOCITY], vectors[L.UNKNOWN], vectors[L.UNKNOWN2]
    for k in range(layout[L.N_ROTATIONS]):
        d = layout[layout[L.ROTATIONS] + 2 * k]
        a[d], a[d + 1], a[d + 2] = spin_acceleration(q[d:], v[d:], a[d], a[d + 1], a[d + 2])
        v[d], v[d + 1], v[d + 2] = tangled(q[d:], v[d], v[d + 1], v[d + 2])
        w[d], w[d + 1], w[d + 2] = tangled(q[d:], w[d], w[d + 1], w[d + 2])


@kernel
def into_chart(row, run):
    """Convert generalised forces in a row of ``vectors`` to those on psi: multiply their torques by T(psi)^T."""
    convert(tangled_back, run.vectors[L.POSITION], run.vectors[row], run)


@kernel
def out_of_chart(row, run):
    """The inverse of ``into_chart``."""
    convert(untangled_back, run.vectors[L.POSITION], run.vectors[row], run)


@kernel
def with_rates(q, v, other, run):
    """The row with the velocities of row ``v`` at the coordinates of row ``q``, with psi' in the place of angular
    velocities: in the plane v itself, in space the row ``other``."""
    layout, vectors = run.layout, run.vectors
    if layout[L.N_ROTATIONS] == 0:
        return v
    for i in range(layout[L.N_Q]):
        vectors[other, i] = vectors[v, i]
    convert(untangled, vectors[q], vectors[other], run)
    return other


@kernel
def move_charts(run):
    """Make the attitude of the accepted step the origin of each chart."""
    layout, vectors = run.layout, run.vectors
    before = layout[L.PAST_POSITIONS]
    for k in range(layout[L.N_ROTATIONS]):
        d, at = layout[layout[L.ROTATIONS] + 2 * k], layout[layout[L.ROTATIONS] + 2 * k + 1]
        base, psi = run.numbers[at + BASE :], vectors[L.POSITION, d:]
        p0, p1, p2, p3 = composed(base, psi[0], psi[1], psi[2])
        size = sqrt(p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
        base[0], base[1], base[2], base[3] = p0 / size, p1 / size, p2 / size, p3 / size
        for j in range(3):
            if before > 0:
                # it is the start of this step by now: log(R_{n+1}^T R_n) = -psi
                vectors[before, d + j] = -psi[j]
            vectors[L.POSITION0, d + j] = 0.0
            psi[j] = 0.0


@kernel
def leave_chart(out, run):
    """In the coordinates ``out``, replace psi by the rotation vector of the attitude, of a length up to pi."""
    layout = run.layout
    for i in range(layout[L.N_ROTATIONS]):
        d, at = layout[layout[L.ROTATIONS] + 2 * i], layout[layout[L.ROTATIONS] + 2 * i + 1]
        p0, p1, p2, p3 = composed(run.numbers[at + BASE :], out[d], out[d + 1], out[d + 2])
        out[d], out[d + 1], out[d + 2] = logarithm(p0, p1, p2, p3)


@kernel
def attitudes(out, run):
    """In the coordinates ``out``, replace psi = 0 at the start of a step, by the rotation vector of the attitude."""
    layout = run.layout
    for i in range(layout[L.N_ROTATIONS]):
        d, base = layout[layout[L.ROTATIONS] + 2 * i], run.numbers[layout[layout[L.ROTATIONS] + 2 * i + 1] + BASE :]
        out[d], out[d + 1], out[d + 2] = logarithm(base[0], base[1], base[2], base[3])
