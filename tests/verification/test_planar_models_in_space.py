"""Planar models with `spatial` in front: the same mechanism, and the numbers of the plane to rounding.

Every planar model of `models/` with bodies that exist in space, and every method. Exponentials about one axis add, so
that each equation in space is the planar one or 0 = 0. Newton's iteration goes on until rounding here; by default it
leaves errors below those of the method.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.elements import find
from mbdsl.integrators import available, compiled, modules, run_state
from mbdsl.integrators.loop import loop_state as S

MODELS = Path(__file__).parents[2] / "models"
#: the kinds that do not exist in space: planar beams, and contacts with a profile in the plane
PLANE_ONLY = re.compile(r"^[^/]*\b(FlexibleBeam|ProfileContact)\b", re.MULTILINE)
METHODS = [name for name in compiled() if name in available(True)]
#: models that every method runs
COMMON = ("four_bar", "rolling_disc", "seven_body", "slider_crank")
#: numbers of steps after which something happens, if more than 24
STEPS = {"geneva_drive": 80, "newtons_cradle": 300}
#: signals of constraints that hold
RESIDUAL = re.compile(r"(Phi|Gam)\[\d+\]$")
#: a link of 1e-9 kg between others, which magnifies rounding of positions by the ratio of stiffness and mass
MAGNIFIED = {"light_link": 100.0}


def text_of(path):
    """The text of a model with the texts that it imports."""
    text = path.read_text(encoding="utf-8")
    return re.sub(r'^import "(.+)";$', lambda found: text_of(path.parent / found[1]), text, flags=re.MULTILINE)


TEXTS = {
    f"{path.parent.name}/{path.stem}" if path.parent != MODELS else path.stem: text_of(path)
    for folder in (MODELS, MODELS / "gallery", MODELS / "hard")
    for path in sorted(folder.glob("*.mbd"))
    if not re.search("^spatial ", path.read_text(encoding="utf-8"), re.MULTILINE)
}
PLANAR = [name for name, text in TEXTS.items() if not PLANE_ONLY.search(text)]


def cases():
    """Every model with one of the methods, and the common ones with all."""
    for k, method in enumerate(METHODS):
        names = dict.fromkeys((*COMMON, *PLANAR[k :: len(METHODS)]))
        yield from ((method, name) for name in names if not refused(method, name))


def refused(method, name):
    """Whether a method is not for the model, in the plane, too: stiff springs, or no inertia by which it divides.

    The spring of 1e9 N/m of `bushing_joint` makes steps of an explicit method unstable, so that rounding grows.
    """
    of = {"dop853": ("double_pendulum", "hard/bushing_joint", "hard/stiff_knee", "hard/two_time_scales")}
    return name in (of | {"hht-add": ("hard/light_link", "hard/massless_rod", "hard/no_inertia")}).get(method, ())


@pytest.fixture(autouse=True)
def iterations_to_rounding(monkeypatch):
    allocate = run_state.RunState.allocate

    def tight(self):
        allocate(self)
        self.reals[S.RELATIVE_TOL] = 1e-12

    monkeypatch.setattr(run_state.RunState, "allocate", tight)


def in_space(text):
    return mbdsl.parse(re.sub(r"^(partial )?model", r"spatial \1model", text, flags=re.MULTILINE))


def thick(scene):
    """The scene with moments of inertia of rods about their axes, which thin ones do not have."""
    found = {}
    for name, c in scene.components.items():
        I = c.values.get("I")
        if isinstance(I, tuple) and I[0] == 0.0 < I[1]:
            c = replace(c, values={**c.values, "I": (I[1], *I[1:])})
        found[name] = c
    return replace(scene, components=found)


def scales(trajectory):
    """The largest value of each unit, at least that which follows from those of other units and the time of the run.

    A mechanism that rests, or a torque that is zero, contains rounding of larger quantities.
    """
    found = {}
    for name in trajectory.signals:
        unit = trajectory.unit(name)
        found[unit] = max(found.get(unit, 0.0), np.abs(trajectory[name]).max())
    size, time = found["m"] or 1.0, trajectory.t[-1]
    slow = 1e-3 * size / time
    least = {"rad": 1e-3, "m/s": slow, "rad/s": max(slow, found["m/s"]) / size, "m/s2": slow / time}
    least["rad/s2"] = max(least["m/s2"], found["m/s2"]) / size
    bodies = [c.values for c in trajectory.scene.bodies()]
    least["N"] = max(b["m"] for b in bodies) * slow / time
    inertia = max(b.get("I") or 0.0 for b in bodies)
    least["N.m"] = max(found.get("N", 0.0) * size, least["N"] * size, 1e-3 * inertia / time**2)
    least["J"] = max(found.get("N", 0.0), least["N"]) * size
    least["W"] = least["J"] / time
    return {unit: max(scale, least.get(unit, 0.0)) or 1.0 for unit, scale in found.items()}


def test_no_planar_model_is_left_out():
    """Only bodies that deform and contacts with profiles are not modelled in space."""
    assert len(PLANAR) > 70
    for name in set(TEXTS) - set(PLANAR):
        components = mbdsl.parse(TEXTS[name]).components.values()
        assert any(c.deforms or find(c.kind.name, True) is None for c in components), name


@pytest.mark.parametrize(("method", "name"), list(cases()))
def test_numbers_of_the_plane(method, name):
    """Positions and velocities, relative to the largest of their unit, to 1e-7; accelerations and reactions, which
    contain rounding of positions over the step squared, to 1e-5. Both are a hundred times what is found."""
    flat, solid = mbdsl.parse(TEXTS[name]), in_space(TEXTS[name])
    if modules()[method].METHOD.inverts_mass or name == "hard/bushing_joint":  # there, nothing holds the axis
        solid = thick(solid)
    given, short = flat.experiment, name.rpartition("/")[2]
    step = min(given.step or 1e-3, 1e-3 if short not in STEPS else 1.0, (given.stop or 1.0) / 1000)
    if short in STEPS:
        step = given.step or 1e-3
    stop = step * STEPS.get(short, 24)
    settings = {"method": method, "step": step, "stop": stop, "interval": stop / 6, "general": True}
    a, b = mbdsl.simulate(flat, **settings), mbdsl.simulate(solid, **settings)
    assert set(a.signals) <= set(b.signals)
    any_share = set(b.stats["not unique"]) if a.stats["redundant"] else set()
    scale = scales(a)
    for signal in a.signals:
        if RESIDUAL.search(signal) or signal in any_share:
            continue
        unit = a.unit(signal)
        kinematic = unit in ("m", "rad", "m/s", "rad/s", "J", "s", "")
        bound = (1e-7 if kinematic else 1e-5) * MAGNIFIED.get(short, 1.0)
        np.testing.assert_allclose(b[signal], a[signal], rtol=0, atol=bound * scale[unit], err_msg=signal)
