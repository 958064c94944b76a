"""Settings of every test process, read before numpy is imported; orders and steps of methods, as declared."""

import gc
import os
import signal

# Modules and collected tests persist until the end of the process: no collection while they are created.
gc.disable()

# Tests run in parallel, one process a core: BLAS threads would compete for the cores. Workers of pytest-xdist inherit
# the setting.
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
# Most runs of tests are shorter than the compilation of their code. The bits of results are the same, see
# unit/compilation/test_optimisation.py.
os.environ.setdefault("MBDSL_OPTIMISATION", "0")

import numpy as np
import pytest

from mbdsl.integrators import declared


def pytest_collection_finish(session):
    gc.enable()


@pytest.fixture
def default_signals():
    """Signals have their default effect in this process and in those that it starts, as in a terminal.

    Tests may run in a background job of a shell, which ignores SIGINT, or under nohup, which ignores SIGHUP. Processes
    inherit that, unless the parent handles the signal.
    """
    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    defaults = {signal.SIGINT: signal.default_int_handler, **{getattr(signal, n): signal.SIG_DFL for n in names}}
    before = {number: signal.signal(number, handler) for number, handler in defaults.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


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
    """``slopes(method)``: the interval allowed for the slope over all steps, for the declared order.

    It is wider for order 8: two halvings are all that lies between rounding and steps for which terms of order 9 and 10
    are not negligible.
    """

    def find(method):
        order = declared(method).order
        off = min(0.05 + 0.05 * order, 0.25) if order < 8 else 0.9
        return order - off, order + max(off, 0.15)  # newmark with gamma = 0.6 comes out above 1.1

    return find


@pytest.fixture(scope="session")
def wrong_orders(order, slopes):
    """``wrong_orders(method, steps, errors)``: the entries of ``{name: errors}`` whose slope is not the method's order,
    each with its slope."""

    def find(method, steps, errors):
        low, high = slopes(method)
        found = {name: order(steps, values) for name, values in errors.items()}
        return {name: round(slope, 3) for name, slope in found.items() if not low <= slope <= high}

    return find


@pytest.fixture(scope="session")
def halved():
    """``halved(method, longest, times)``: steps, each half of the one before; the longest is that of hht-si2.

    Over all of them the error falls by 2^15 at most with order 5, and by 2^16 with order 8; with more halvings,
    rounding would be visible.
    """

    def find(method, longest, times=5):
        declaration = declared(method)
        count = 1 + min(times, max(2, 15 // declaration.order))
        return [longest * declaration.relative_step / 2**k for k in range(count)]

    return find
