"""Settings of every test process, read before numpy is imported; orders and steps of methods, as declared."""

import os

# Tests run side by side, one a core: threads of BLAS would wait for each other instead of computing. Workers of
# pytest-xdist take this over.
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np
import pytest

from mbdsl.integrators import declared


@pytest.fixture(scope="session")
def order():
    """``order(steps, errors)``: the slope of a straight line through log(error) over log(step)."""
    return lambda steps, errors: float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


@pytest.fixture(scope="session")
def order_of():
    """``order_of(method)``, as declared."""
    return lambda method: declared(method).order


@pytest.fixture(scope="session")
def slopes():
    """``slopes(method)``: between what the slope over all of the steps may be, for the order that is declared."""

    def find(method):
        order = declared(method).order
        off = min(0.05 + 0.05 * order, 0.25)
        return order - off, order + max(off, 0.15)  # newmark with gamma = 0.6 has more than 1.1

    return find


@pytest.fixture(scope="session")
def wrong_orders(order, slopes):
    """``wrong_orders(method, steps, errors)``: those of ``{name: errors}`` whose slope is not the method's, with it."""

    def find(method, steps, errors):
        low, high = slopes(method)
        found = {name: order(steps, values) for name, values in errors.items()}
        return {name: round(slope, 3) for name, slope in found.items() if not low <= slope <= high}

    return find


@pytest.fixture(scope="session")
def halved():
    """``halved(method, longest, times)``: steps, the longest one being that of hht-si2.

    Each halves the one before. Over all of them the error falls by 2^15 at most: with more, rounding would be seen.
    """

    def find(method, longest, times=5):
        declaration = declared(method)
        count = 1 + min(times, max(3, 15 // declaration.order))
        return [longest * declaration.relative_step / 2**k for k in range(count)]

    return find
