"""Bodies fulfil their contract; all violations are listed when a body is first used."""

from types import SimpleNamespace

import pytest

from mbdsl.bodies import ancf_cable_kernels, floating_beam_kernels, point_mass_kernels, rigid_body_kernels
from mbdsl.bodies.contract import UndeformedModel, model_class
from mbdsl.bodies.rigid_body import Rigid
from mbdsl.elements import modules
from mbdsl.elements.kind import BodyKind
from mbdsl.kernels.marks import kernel
from mbdsl.system import body_models

ALL = (ancf_cable_kernels, floating_beam_kernels, point_mass_kernels, rigid_body_kernels)


def changed(module, **changes):
    """A module with these changes; a name set to None is missing."""
    return SimpleNamespace(**{k: v for k, v in (vars(module) | changes).items() if v is not None and k[:2] != "__"},
                           __name__="broken_kernels")  # fmt: skip


def reason(module):
    # a namespace has no hash, as the cache wants it
    with pytest.raises(TypeError) as caught:
        model_class.__wrapped__(module)
    head, _, reasons = str(caught.value).partition(": ")
    assert head == "broken_kernels breaks the contract in mbdsl.bodies.contract"
    return reasons.split("; ")


def test_all_bodies_keep_it():
    kinds = [module for module in modules().values() if isinstance(module.KIND, BodyKind) and module.KIND.coordinates]
    used = {kernels for module in kinds for kernels in body_models.motion_modules(module)}
    assert used == set(ALL)
    assert [model_class(kernels).deforms for kernels in ALL] == [True, True, False, False]


def test_kernels_that_break_it():
    @kernel
    def move(block, vectors, frames):
        pass

    def jacobians(block, vectors, frames, numbers, layout):
        pass

    assert reason(changed(rigid_body_kernels, move=move, gather=None, jacobians=jacobians)) == [
        "the kernel move takes (block, vectors, frames), expected (block, vectors, frames, numbers, layout)",
        "the kernel gather(block, wrench, lever, row, vectors, frames, layout) is missing",
        "jacobians is not marked as a kernel",
    ]
    assert reason(changed(rigid_body_kernels, MASS=3, MODEL=None)) == [
        "MASS is 3, expected 0, 1 or 2",
        "MODEL is missing: the name of the module of its model",
    ]
    # a body that deforms needs more: kernels of its own, and the float table in others
    reasons = reason(changed(rigid_body_kernels, MASS=2))
    assert "the kernel inertia(block, task, row, target, vectors, numbers, layout) is missing" in reasons
    assert "the kernel carry_over(block, vectors, numbers, layout) is missing" in reasons
    expected = "expected (block, cK, frames, numbers, layout, matrix)"
    assert f"the kernel stiffness takes (block, cK, frames, layout, matrix), {expected}" in reasons
    # optional
    assert model_class.__wrapped__(changed(rigid_body_kernels, stiffness=None)) is Rigid


def test_models_that_break_it(monkeypatch):
    assert reason(changed(rigid_body_kernels, MODEL="mbdsl.bodies.beam_stations")) == [
        "mbdsl.bodies.beam_stations has no class MODEL"
    ]
    monkeypatch.delattr(UndeformedModel, "deforms")
    monkeypatch.delattr(UndeformedModel, "bend")
    monkeypatch.setattr(Rigid, "weight", lambda self, gravity: gravity)
    assert reason(changed(rigid_body_kernels)) == [
        "Rigid.deforms is missing: True or False",
        "Rigid.weight takes (self, gravity), expected (self, g)",
        "Rigid has no method bend(self, q)",
    ]


def test_a_scene_meets_it(monkeypatch):
    """before any of its code is compiled"""
    monkeypatch.delattr(rigid_body_kernels, "gather")
    model_class.cache_clear()
    from mbdsl.lang.load import parse_text
    from mbdsl.mechanism import graph
    from mbdsl.system import build

    scene = parse_text("model M Body b(m = 1, I = 1); Ground g; FreeMotion f(g, b.c); end M;")
    try:
        with pytest.raises(TypeError, match=r"the kernel gather\(block, .*, layout\) is missing"):
            build(scene, graph.build(scene))
    finally:
        model_class.cache_clear()
