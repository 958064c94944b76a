"""The loops over the rows of the gradient table. They add the contributions of scalar coordinates g(z) of frame pairs
to f, Phi and the iteration matrix.

Kinds differ only in the dependence of g, its gradient G and its second derivative H on two frames. Therefore the loops
``fill`` and ``curve`` are compiled once for each kind; the others are the same for all constraints, springs and laws:

    constraint   Phi = g - u(t),  wrench -= G^T lam (and += G^T mu)
    spring       s = k (g - g0) + c dg/dt,  wrench -= G^T s
    law          s from an expression, wrench += sign G^T s

Nonholonomic constraints have no kernels of their own: Gam and its derivatives are expressions over frames.
"""

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, square


@kernel
def fill(block, rows, gradient, frames, gradients, numbers, layout):
    """Write g and G of all components of a kind to gradients. Reads frames, and parameters in numbers."""
    for e in range(layout[block]):
        r = layout[block + 1] + rows * e
        o = layout[L.PAIRS] + L.PAIR * r
        gradient(
            frames,
            layout[o + L.FRAME_A],
            layout[o + L.FRAME_B],
            numbers[layout[block + 2] + layout[block + 3] * e :],
            gradients[r:],
        )


@kernel
def curve(C, block, rows, hessian, frames, gradients, numbers, layout):
    """Write d^2g/dz^2 to numbers and w^T d^2g/dz^2 to gradients, for all components of a kind with varying gradient."""
    for e in range(layout[block]):
        for k in range(rows):
            r = layout[block + 1] + rows * e + k
            o = layout[L.PAIRS] + L.PAIR * r
            a, b, h = layout[o + L.FRAME_A], layout[o + L.FRAME_B], layout[o + L.SECOND_DERIVATIVE]
            if h < 0:
                continue
            H = square(numbers, h, C.PAIR_POSE)
            for j in range(C.SQUARE):
                numbers[h + j] = 0.0
            unit = gradients[r, C.GRADIENT_RATE :]
            for j in range(rows):
                unit[j] = 0.0
            unit[k] = 1.0
            hessian(frames, a, b, numbers[layout[block + 2] + layout[block + 3] * e :], unit, H)
            for j in range(C.PAIR_POSE):
                rate = 0.0
                for i in range(C.POSE):
                    rate += (
                        frames[a, C.RATE + i] * numbers[h + C.PAIR_POSE * i + j]
                        + frames[b, C.RATE + i] * numbers[h + C.PAIR_POSE * (C.POSE + i) + j]
                    )
                gradients[r, C.GRADIENT_RATE + j] = rate


@kernel
def start(C, vectors, frames, numbers, layout):
    """Write the constant generalised force to vectors[FORCE], 0 to vectors[FORCE2] and to the ground's wrenches."""
    for i in range(layout[L.N_Q]):
        vectors[L.FORCE, i] = numbers[layout[L.CONSTANT_FORCE] + i]
        vectors[L.FORCE2, i] = 0.0
    for f in range(layout[L.GROUND_FRAMES]):
        for j in range(C.POSE):
            frames[f, C.WRENCH + j], frames[f, C.MU_WRENCH + j] = 0.0, 0.0


@kernel
def carry(C, frames, numbers, layout):
    """Write pose and rates of the frames that drivers move from the registers, in numbers, to frames."""
    for k in range(layout[L.N_MOVING]):
        o = layout[L.MOVING] + C.MOVED * k
        for j in range(C.CARRIED):
            frames[layout[o], j] = numbers[layout[L.REGISTERS] + layout[o + 1 + j]]


@kernel
def couple(numbers, layout):
    """Write the functions of couplings and their derivatives from the registers to the parameters of components."""
    for k in range(layout[L.N_COUPLED]):
        o = layout[L.COUPLED] + L.COUPLING * k
        numbers[layout[o]] = numbers[layout[L.REGISTERS] + layout[o + 1]]


@kernel
def constraints(C, vectors, frames, gradients, numbers, layout):
    """Write Phi to vectors[FORCE] and Phi_q v + Phi_t to vectors[FORCE2]; WRENCH in frames -= Phi_q^T lam."""
    n, row = layout[L.N_Q], layout[L.LAM_ROW]
    for r in range(layout[L.N_PHI]):
        o = layout[L.PAIRS] + L.PAIR * r
        if layout[o + L.LEFT_OUT]:
            vectors[L.FORCE, n + r], vectors[L.FORCE2, n + r] = 0.0, 0.0
            continue
        a, b = layout[o + L.FRAME_A], layout[o + L.FRAME_B]
        lam = vectors[row, n + r]
        rate = 0.0
        for j in range(C.POSE):
            rate += gradients[r, j] * frames[a, C.RATE + j] + gradients[r, C.POSE + j] * frames[b, C.RATE + j]
            frames[a, C.WRENCH + j] -= gradients[r, j] * lam
            frames[b, C.WRENCH + j] -= gradients[r, C.POSE + j] * lam
        vectors[L.FORCE, n + r] = gradients[r, C.VALUE]
        vectors[L.FORCE2, n + r] = rate


@kernel
def drive(vectors, numbers, layout):
    """vectors[FORCE] -= u(t) and vectors[FORCE2] -= u'(t), that is Phi and Phi_q v + Phi_t, in the rows of drivers."""
    n = layout[L.N_Q]
    for r in range(layout[L.N_PHI]):
        o = layout[L.PAIRS] + L.PAIR * r
        u = layout[o + L.DETAIL]
        if u >= 0 and not layout[o + L.LEFT_OUT]:
            vectors[L.FORCE, n + r] -= numbers[layout[L.REGISTERS] + layout[u]]
            vectors[L.FORCE2, n + r] -= numbers[layout[L.REGISTERS] + layout[u + 1]]


@kernel
def constraints_with_mu(C, vectors, frames, gradients, numbers, layout):
    """As ``constraints``; also MU_WRENCH in frames += Phi_q^T mu. One loop costs half as much as two."""
    n, row, mu_row = layout[L.N_Q], layout[L.LAM_ROW], layout[L.MU_ROW]
    for r in range(layout[L.N_PHI]):
        o = layout[L.PAIRS] + L.PAIR * r
        if layout[o + L.LEFT_OUT]:
            vectors[L.FORCE, n + r], vectors[L.FORCE2, n + r] = 0.0, 0.0
            continue
        a, b = layout[o + L.FRAME_A], layout[o + L.FRAME_B]
        lam, mu = vectors[row, n + r], vectors[mu_row, n + r]
        rate = 0.0
        for j in range(C.POSE):
            g, k = gradients[r, j], gradients[r, C.POSE + j]
            rate += g * frames[a, C.RATE + j] + k * frames[b, C.RATE + j]
            frames[a, C.WRENCH + j] -= g * lam
            frames[b, C.WRENCH + j] -= k * lam
            frames[a, C.MU_WRENCH + j] += g * mu
            frames[b, C.MU_WRENCH + j] += k * mu
        vectors[L.FORCE, n + r] = gradients[r, C.VALUE]
        vectors[L.FORCE2, n + r] = rate


@kernel
def keep(C, vectors, frames, gradients, layout):
    """At the start of a step, store G and levers of the last evaluation (PAST_GRADIENT, PAST_LEVER). At every
    evaluation, set vectors[PAST_FORCE] and PAST_WRENCH in frames to zero."""
    if layout[L.KEEP]:
        layout[L.KEEP] = 0
        for r in range(layout[L.N_PHI]):
            for j in range(C.PAIR_POSE):
                gradients[r, C.PAST_GRADIENT + j] = gradients[r, j]
        for f in range(layout[L.N_FRAMES]):
            for j in range(C.LEVERS):
                frames[f, C.PAST_LEVER + j] = frames[f, C.LEVER + j]
    for i in range(layout[L.N_Q]):
        vectors[L.PAST_FORCE, i] = 0.0
    for f in range(layout[L.N_FRAMES]):
        for j in range(C.POSE):
            frames[f, C.PAST_WRENCH + j] = 0.0


@kernel
def remember(C, vectors, frames, gradients, layout):
    """PAST_WRENCH in frames += Phi_q^T psi with the Phi_q of the start of the step."""
    n, row = layout[L.N_Q], layout[L.PSI_ROW]
    for r in range(layout[L.N_PHI]):
        o = layout[L.PAIRS] + L.PAIR * r
        a, b = layout[o + L.FRAME_A], layout[o + L.FRAME_B]
        if layout[o + L.LEFT_OUT]:
            continue
        psi = vectors[row, n + r]
        for j in range(C.POSE):
            frames[a, C.PAST_WRENCH + j] += gradients[r, C.PAST_GRADIENT + j] * psi
            frames[b, C.PAST_WRENCH + j] += gradients[r, C.PAST_GRADIENT + C.POSE + j] * psi


@kernel
def gammas(C, vectors, frames, numbers, layout):
    """Write Gam to vectors[FORCE]; WRENCH in frames -= Gam_v^T nu. Records: see :mod:`mbdsl.system.nonholonomic`."""
    first = layout[L.N_Q] + layout[L.N_PHI]
    for k in range(layout[L.N_GAM]):
        o = layout[layout[L.GAMMAS] + k]
        vectors[L.FORCE, first + k], vectors[L.FORCE2, first + k] = numbers[layout[L.REGISTERS] + layout[o]], 0.0
        if layout[o + 3]:
            vectors[L.FORCE, first + k] = 0.0
            continue
        nu = vectors[layout[L.LAM_ROW], first + k]
        for l in range(layout[o + 4]):
            at = o + L.GAMMA + C.LEAF * l
            for j in range(C.POSE):
                frames[layout[at], C.WRENCH + j] -= numbers[layout[L.REGISTERS] + layout[at + 1 + j]] * nu


@kernel
def springs(C, frames, gradients, numbers, layout):
    """Linear springs and dampers: s = k (g - g0) + c dg/dt to gradients; WRENCH in frames -= G^T s.

    Rows with k = c = 0 are left out: their g need not exist, as the tilt of a bushing after half a turn.
    """
    for r in range(layout[L.N_PHI], layout[L.N_PHI] + layout[L.N_SPRINGS]):
        o = layout[L.PAIRS] + L.PAIR * r
        a, b, p = layout[o + L.FRAME_A], layout[o + L.FRAME_B], layout[o + L.DETAIL]
        if numbers[p] == 0.0 and numbers[p + 1] == 0.0:
            gradients[r, C.MAGNITUDE] = 0.0
            continue
        rate = 0.0
        for j in range(C.POSE):
            rate += gradients[r, j] * frames[a, C.RATE + j] + gradients[r, C.POSE + j] * frames[b, C.RATE + j]
        s = numbers[p] * (gradients[r, C.VALUE] - numbers[p + 2]) + numbers[p + 1] * rate
        gradients[r, C.MAGNITUDE] = s
        for j in range(C.POSE):
            frames[a, C.WRENCH + j] -= gradients[r, j] * s
            frames[b, C.WRENCH + j] -= gradients[r, C.POSE + j] * s


@kernel
def laws(C, frames, gradients, numbers, layout):
    """Forces by expression: WRENCH in frames += sign G^T s. The leaf list starts with the register of s and sign."""
    first = layout[L.N_PHI] + layout[L.N_SPRINGS]
    for r in range(first, first + layout[L.N_LAWS]):
        o = layout[L.PAIRS] + L.PAIR * r
        a, b = layout[o + L.FRAME_A], layout[o + L.FRAME_B]
        s = layout[layout[o + L.DETAIL] + 1] * numbers[layout[L.REGISTERS] + layout[layout[o + L.DETAIL]]]
        gradients[r, C.MAGNITUDE] = -s
        for j in range(C.POSE):
            frames[a, C.WRENCH + j] += gradients[r, j] * s
            frames[b, C.WRENCH + j] += gradients[r, C.POSE + j] * s


@kernel
def inertia(task, row, target, vectors, numbers, layout):
    """Tasks of the mass matrix: TIMES for the constant off-diagonal entries, INVERSE for bodies with a diagonal one."""
    if task == L.TIMES:
        for i in range(layout[L.N_Q]):
            vectors[target, i] = 0.0
        for k in range(layout[L.N_COUPLINGS]):
            o, value = layout[L.COUPLINGS] + 3 * k, numbers[layout[L.COUPLING_VALUES] + k]
            vectors[target, layout[o]] += value * vectors[row, layout[o + 1]]
            vectors[target, layout[o + 1]] += value * vectors[row, layout[o]]
    elif task == L.INVERSE:
        for i in range(layout[L.N_Q]):
            vectors[target, i] = vectors[row, i] / numbers[layout[L.MASS] + i]
