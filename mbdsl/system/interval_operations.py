"""Operations of an expression's program on intervals: functions of one argument, and those that jump."""

from numpy import ceil, floor

from mbdsl.expressions import interval_arithmetic as bounds
from mbdsl.kernels.marks import kernel, rare
from mbdsl.system import expression_tape as tape


@kernel
def condition(place, a, notes):
    """A condition, or the truth of a number in its place."""
    lo, hi, d_lo, d_hi = a
    if notes[place] != 1:
        lo, hi, d_lo, d_hi = bounds.of_number((lo, hi))
    return (lo, hi), (d_lo, d_hi)


@rare
def smooth(op, a, da):
    """A function of one argument that has a derivative."""
    if op == tape.SIN:
        values, slope = bounds.of_sin(a), bounds.of_cos(a)
    elif op == tape.COS:
        values, slope = bounds.of_cos(a), bounds.neg(bounds.of_sin(a))
    elif op == tape.SQRT:
        values = bounds.of_sqrt(a)
        slope = bounds.mul((0.5, 0.5), bounds.inverse(values))
    elif op == tape.TAN:
        values = bounds.of_tan(a)
        slope = bounds.slope_of_tan(values)
    elif op == tape.ASIN:
        values, slope = bounds.of_asin(a), bounds.slope_of_asin(a)
    elif op == tape.ACOS:
        values, slope = bounds.of_acos(a), bounds.neg(bounds.slope_of_asin(a))
    elif op == tape.ATAN:
        values, slope = bounds.of_atan(a), bounds.inverse(bounds.one_plus_square(a))
    elif op == tape.SINH:
        values, slope = bounds.of_sinh(a), bounds.of_cosh(a)
    elif op == tape.COSH:
        values, slope = bounds.of_cosh(a), bounds.of_sinh(a)
    elif op == tape.TANH:
        values = bounds.of_tanh(a)
        slope = bounds.one_minus_square(values)
    elif op == tape.EXP:
        values = bounds.of_exp(a)
        slope = values
    elif op == tape.LOG:
        values, slope = bounds.of_log(a), bounds.inverse((max(a[0], 0.0), a[1]))
    else:
        slope = bounds.mul((1.0 / bounds.LN10, 1.0 / bounds.LN10), bounds.inverse((max(a[0], 0.0), a[1])))
        values = bounds.of_log10(a)
    return bounds.jet(values, bounds.scaled(da, slope))


@rare
def jumping(op, a, da, b, db):
    """A function whose values are steps, of one or two arguments."""
    if op == tape.SIGN:
        return bounds.step(bounds.sign(a[0]), bounds.sign(a[1]), da)
    if op == tape.FLOOR:
        return bounds.step(floor(a[0]), floor(a[1]), da)
    if op == tape.CEIL:
        return bounds.step(ceil(a[0]), ceil(a[1]), da)
    growth = bounds.add(db, bounds.neg(da))
    if op == tape.LT:
        return bounds.truth(a[1] < b[0], a[0] >= b[1], growth)
    if op == tape.LE:
        return bounds.truth(a[1] <= b[0], a[0] > b[1], growth)
    equal = a[0] == a[1] and b[0] == b[1] and a[0] == b[0]
    found = 1.0 if equal == (op == tape.EQ) else 0.0
    return found, found, 0.0, 0.0
