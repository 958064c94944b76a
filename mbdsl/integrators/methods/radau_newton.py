"""Newton's iteration for the stages of a step of Radau IIA.

``R``: the coefficients and rows of a method (:class:`mbdsl.integrators.methods.radau_coefficients.Scheme`).
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.newton import EPS, SINGULAR_NOISE, finite
from mbdsl.integrators.methods.radau_matrices import matrices
from mbdsl.integrators.methods.radau_stages import constraint_size, correct, predict, residuals
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

#: memory: length and error of the last step; step length of the matrices; last measured contraction; largest scaled
#: velocity so far
LAST, ERROR, OF_MATRICES, CONTRACTION, SPEED = range(5)
MAX_ITERATIONS = 25
#: contraction assumed of a first iteration, at least, if none was measured in the last OFTEN steps
ASSUMED, OFTEN = 0.05, 4
#: coefficients of the method: the tolerance of the embedded formula is FACTOR times that of the result to the power
#: POWER; the step size is proportional to the error of this formula to the power EXPONENT; a contraction is measured
#: where changes are above MEASURED times the smallest ones, and is regarded as known for KNOWN steps
FACTOR, POWER, EXPONENT, MEASURED, KNOWN = range(5)
#: error left by Newton's iteration, relative to the tolerance over the whole time: in the plane, and in space, where
#: small components of a change contract more slowly than its largest ones, as for a coin that rolls and spins
LEFT, LEFT_IN_SPACE = 0.2, 0.02
#: the same where rounding limits it, relative to the allowed error of a step
STALLED = 1e-3
#: degree that stands for that of the polynomial of the stages; number of an attempt that extrapolates by a parabola
FULL, PARABOLIC = 9, 3


@kernel
def strict(run):
    """The tolerance of the embedded formula."""
    return run.coefficients[FACTOR] * run.reals[S.TOL] ** run.coefficients[POWER]


@kernel
def sizes(length, run):
    """Size of the mechanism. memory[SPEED] becomes the largest scaled velocity so far, at least 1/length."""
    memory, vectors, layout = run.memory, run.vectors, run.layout
    size, speed = 1.0, 0.0
    for i in range(layout[L.N_Q]):
        size = max(size, abs(vectors[L.POSITION0, i]) * vectors[L.SCALE, i])
        speed = max(speed, abs(vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i])
    memory[SPEED] = max(memory[SPEED], speed, 1.0 / length)
    return size


@kernel
def renew_matrices(R, t, h, still, run):
    """New matrices of the stages; a status."""
    memory, integers = run.memory, run.integers
    integers[S.MATRICES] += 1
    integers[S.FACTORISATIONS] += 1
    if not matrices(R, t, h, still, run):
        return S.SINGULAR if finite(run) else S.NOT_FINITE
    integers[S.FRESH], memory[OF_MATRICES] = 1, h
    return S.RUNNING


@kernel
def newton(R, t, h, size, run):
    """Solve the stages of a step from t; a status."""
    memory, reals, integers, length = run.memory, run.reals, run.integers, run.reals[S.STOP] - run.reals[S.START]
    spatial = run.layout[L.N_ROTATIONS] > 0
    controlled = 0.0 < reals[S.TOL] < 1.0  # fixed steps that end at events have a tolerance that accepts them all
    tolerance = (LEFT_IN_SPACE if spatial else LEFT) * reals[S.TOL] * h / length if controlled else 0.0
    unit = 1.0 / memory[SPEED] if controlled else h
    # Errors of all steps add up: little more than half of the last digit is acceptable.
    floor = 0.5 * EPS * size
    # In space slow contraction may be due to spins instead of rounding.
    noise = max(1e3 * floor, tolerance if spatial else STALLED * strict(run) if controlled else 0.0)
    # The first change has no former one to be compared with.
    contraction, former = min(max(memory[CONTRACTION], ASSUMED if integers[S.UNSEEN] >= OFTEN else 1e-3), 0.9), 0.0
    integers[S.UNSEEN] += 1
    fresh = False
    for k in range(MAX_ITERATIONS):
        residuals(R, t, h, run)
        integers[S.ITERATIONS] += 1
        if integers[S.FRESH] == 0:
            status = renew_matrices(R, t, h, noise / unit, run)
            if status != S.RUNNING:
                return status
            fresh = True
        held = k > 4 and constraint_size(R, run) <= 1e3 * floor
        change = correct(R, h, unit, run)
        if not change < 1e100:
            return S.NOT_FINITE
        if k > 0:
            contraction = change / former if former > 0.0 else 0.0
            if former > run.coefficients[MEASURED] * floor:
                memory[CONTRACTION], integers[S.UNSEEN] = contraction, 0
        left = change * contraction / (1.0 - contraction) if contraction < 0.9 else change
        # the first change does not contain friction by a load that was zero, whose derivative is zero
        if k == 0 and run.layout[L.OF_MULTIPLIERS] > 0:
            former = change
            continue
        if left <= tolerance or change <= floor or (k > 2 and contraction > 0.3 and change <= noise):
            return S.RUNNING
        if held and contraction > 0.3 and change <= SINGULAR_NOISE * size:
            return S.RUNNING  # close to a singular pose, which magnifies rounding; the constraints hold
        if k > 0 and contraction > 0.3 and former > run.coefficients[MEASURED] * floor and (not fresh or k % 3 == 0):
            integers[S.FRESH] = 0
        if k > 2 and contraction > 0.9 and tolerance > 0.0 and change > SINGULAR_NOISE * size:
            return S.DIVERGED  # a shorter step is tried
        former = change
    return S.DIVERGED


@kernel
def solve_step(R, attempt, t, h, run):
    """Predict and solve the stages of a step from t; a status.

    Attempts after the first start from constant accelerations, or in an attempt PARABOLIC from a parabola, with
    matrices that are soft along nearly dependent constraints.
    """
    memory, integers = run.memory, run.integers
    size = sizes(run.reals[S.STOP] - run.reals[S.START], run)
    if memory[OF_MATRICES] != h:
        integers[S.FRESH] = 0
    degree = min(1 - attempt, 0)
    if integers[S.HISTORY] > 1 and (attempt == 0 or attempt == PARABOLIC):
        degree = FULL if attempt == 0 else 2
    integers[S.SOFT] = 1 if attempt == PARABOLIC else 0
    predict(R, h / memory[LAST] if integers[S.HISTORY] > 1 else 1.0, degree, h, run)
    return newton(R, t, h, size, run)
