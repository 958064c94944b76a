"""Settings of every test process, read before numpy is imported; which tests are deep; orders and steps of methods.

``pytest`` runs the default tests: every kind, method, command and message once. ``pytest -m "deep or not deep"`` runs
all; so does ``pytest tests/some/test_file.py`` with the tests of this file.
"""

import gc
import os
import re
import signal
import sys
import zlib
from collections import defaultdict
from fnmatch import fnmatch, translate
from pathlib import Path

try:
    import resource
except ImportError:  # Windows
    resource = None

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

TESTS = Path(__file__).parent
#: patterns of the tests with the mark ``deep``, relative to this folder; those behind ``!`` are default tests, the last
#: pattern that matches counts
DEEP = """
benchmarks/*
faults/*
gallery/*
!gallery/test_gears.py*
gallery/test_gears.py::test_woodpecker_by_time_stepping*
!gallery/test_rolling_in_space.py*
models/*
!models/test_command_line.py*
!models/test_counts.py*
!models/test_every_model.py*
verification/*
!verification/test_closed_forms.py*
!verification/test_compliant_joints_in_space.py*
!verification/test_condition.py*
!verification/test_default_steps.py*
!verification/test_double_pendulum.py*
!verification/test_event_costs.py*
verification/test_event_costs.py::test_many_samples*million*
!verification/test_doubts.py*
!verification/test_drift.py*
verification/test_drift.py*radau13*
verification/test_drift.py*radau9*
!verification/test_energy.py*
!verification/test_free_rotation.py*
!verification/test_friction_in_space.py*
!verification/test_gears_in_space.py*
!verification/test_how_to.py*
!verification/test_invariance.py*
!verification/test_joint_friction.py*
!verification/test_jumps_at_steps.py*
!verification/test_moreau_jean.py*
verification/test_moreau_jean.py::test_order*
verification/test_moreau_jean.py::test_verge_clock*
!verification/test_nonholonomic.py*
!verification/test_orders.py*
!verification/test_planar_mechanics.py*
!verification/test_point_masses.py*
!verification/test_point_on_curve_in_space.py*
!verification/test_redundant.py*
!verification/test_rigid_kinds.py::test_a_slider*
!verification/test_rigid_kinds.py::test_contacts_as*
!verification/test_screws_and_drivers_in_space.py*
!verification/test_singular_poses.py*
!verification/test_small_motions_in_space.py*
!verification/test_small_motions_of_vehicles.py*
verification/test_small_motions_of_vehicles.py::test_equilibrium_of_a_bicycle*
!verification/test_space.py*
verification/test_space.py::*bricard*
!verification/test_spinning_bodies.py*
!verification/test_stop_time.py*
!verification/test_sudden_forces.py*
!verification/test_unseen_fixed.py*
!verification/test_velocity_level.py*
unit/compilation/test_optimisation.py*
unit/editor/test_server.py::test_without_the_extra
unit/elements/test_new_kind.py*
unit/house/test_docs_commands.py::*cam-spring.md*
unit/house/test_docs_commands.py::*door-closer.md*
unit/house/test_docs_commands.py::*press-flywheel.md*
unit/house/test_docs_commands.py::*report.md*
unit/house/test_docs_commands.py::*space.md*
unit/house/test_docs_commands.py::*studies.md*
unit/house/test_docs_commands.py::*sweeps.md*
unit/house/test_docs_commands.py::*work-precision.md*
unit/house/test_reference.py::test_the_site_builds*
unit/integrators/test_backend_events.py*
unit/integrators/test_backends.py*
!unit/integrators/test_backends.py::test_reactions_are_those_of_the_motion*
unit/integrators/test_new_method.py*
unit/integrators/test_newton_in_space.py::test_corrections_are_newtons?generalized*
unit/integrators/test_no_allocation.py::test_no_memory_is_taken*
!unit/integrators/test_no_allocation.py::test_no_memory_is_taken?slider_crank?
unit/integrators/test_radau5.py::test_corrections_are_newtons*
unit/integrators/test_uncompiled.py*
unit/notebook/test_tutorials.py*
unit/plotting/test_table_files.py::test_commands_write_tables*
unit/simulation/test_hostile_states.py::test_no_integer*
unit/studies/test_accuracy.py*
!unit/studies/test_accuracy.py::test_the_error_is_what_was_asked_for*
unit/studies/test_budget.py*
unit/studies/test_fingerprint.py::test_every_number_of_a_shipped_model*hoist*
unit/studies/test_own_steps.py*
unit/studies/test_reference.py::test_runs_that_pass_over_a_pulse*
unit/studies/test_report.py*
unit/studies/test_runs.py*
!unit/studies/test_runs.py::test_everything_that_determines_a_run_is_in_its_key*
unit/simulation/test_method_choice.py::test_an_ordinary_machine_takes_few_steps?1e-5?
unit/simulation/test_method_choice.py::test_an_ordinary_machine_takes_few_steps?3e-5?
unit/simulation/test_method_choice.py::test_an_ordinary_machine_takes_few_steps?5e-5?
unit/simulation/test_method_choice.py::test_stiff_models_take_few_steps*
""".split()

#: (whether a name matches a pattern, whether it is then deep), the last pattern first
PATTERNS = [(re.compile(translate(p.removeprefix("!"))).match, not p.startswith("!")) for p in reversed(DEEP)]

peak = {"collected": 0.0}  #: of the memory of this process, when garbage was last collected


def peak_memory():
    """The largest memory that this process has had [bytes]; 0 on systems that do not say."""
    if resource is None:
        return 0.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1.0 if sys.platform == "darwin" else 1024.0)


def is_deep(name):
    """Whether the test ``name``, such as ``unit/lang/test_units.py::test_metres``, has the mark ``deep``."""
    return next((deep for matches, deep in PATTERNS if matches(name)), False)


def drawn(items):
    """Enough of the tests of one function that each value of each of its parameters occurs."""

    def parameters(item):
        call = getattr(item, "callspec", None)
        plain = (str, int, float, type, type(None))
        values = {} if call is None else {k: v if isinstance(v, plain) else None for k, v in call.params.items()}
        return {(k, call.indices[k] if v is None else repr(v)) for k, v in values.items()}

    pending = set().union(*map(parameters, items))
    order = sorted(items, key=lambda item: zlib.crc32(item.nodeid.encode()))
    found = order[:1] if not pending else []
    while pending:
        found.append(max(order, key=lambda item: len(pending & parameters(item))))
        pending -= parameters(found[-1])
    return found


def pytest_configure(config):
    config.addinivalue_line("markers", "deep: not part of the default run; tests/conftest.py has the list")
    if config.getoption("dist", "no") == "load":  # the default of -n
        config.option.dist = "worksteal"
    named = [a for a in config.args if "::" in a or a.endswith(".py")]
    if not config.option.markexpr and not named:
        config.option.markexpr = "not deep"


def pytest_ignore_collect(collection_path, config):
    """Modules with deep tests only are not imported for a default run."""
    name = collection_path.relative_to(TESTS).as_posix() if collection_path.is_relative_to(TESTS) else ""
    only = config.option.markexpr == "not deep" and collection_path.suffix == ".py" and is_deep(f"{name}::")
    return True if only and not any(fnmatch(p, f"!{name}*") for p in DEEP) else None


def pytest_itemcollected(item):
    if is_deep(item.nodeid.removeprefix("tests/")):
        item.add_marker("deep")


@pytest.hookimpl(tryfirst=True)  # before -m is applied
def pytest_collection_modifyitems(items):
    groups = defaultdict(list)
    for item in items:
        groups[item.nodeid.split("[")[0]].append(item)
    for group in groups.values():
        for item in set(group).difference(drawn(group)):
            item.add_marker("deep")


def pytest_collection_finish(session):
    gc.enable()


def pytest_runtest_teardown():
    """With the objects of so many tests, Python rarely collects garbage, and a process would grow to 3 GB."""
    now = peak_memory()
    if now > peak["collected"] + 200e6:
        gc.collect()
        peak["collected"] = now


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


@pytest.fixture
def optimised(monkeypatch):
    """Code is compiled as for users: for runs that would take many seconds with the code of most tests."""
    monkeypatch.setenv("MBDSL_OPTIMISATION", "3")


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
