"""Declarations are replaced and removed, handles belong to one component of one Builder, parameters get new values."""

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import pytest

import mbdsl
from mbdsl import Builder, MbdslError, UsageError
from mbdsl.expressions import symbolic as ex
from mbdsl.simulation.simulate import as_scene

MODELS = Path(__file__).parents[3] / "models"


def chain(length="L"):
    """A pendulum with a second rod, a spring whose length is called `s`, and a component called `s`."""
    b = Builder("Chain")
    b.parameter("L", "1 m", type="Length")
    b.parameter("half", "L/2")
    g = b.Ground("g")
    rod = b.Rod("rod", m=2, length=length, frames={"tip": ("half/2", 0)})
    arm = b.Rod("arm", m=1, length="half")
    pin = b.Revolute("pin", g, rod.a)
    b.Revolute("elbow", rod.b, arm.a)
    b.Torque("motor", pin, tau="1 N.m*sin(2*time)")
    b.SpringDamper("s", g, arm.b, k=10, s0="L")
    b.SpringDamper("q", g, "arm.b", force="3 N/m*s")
    b.variable("x", "arm.phi - rod.phi")
    b.initial(rod.phi, "30 deg")
    b.initial(arm.phi, "10 deg*L/half")
    b.shape(arm, "Circle(radius = half/10)")
    b.experiment(stop="2 s/m*L")
    return b


def names(b):
    scene = b.scene()
    return [*scene.components, *scene.variables, *scene.parameters]


# -- removing -------------------------------------------------------------------------------------------------------


def test_what_is_used_cannot_be_removed():
    b = chain()
    before = b.scene()
    for name, users in {
        "rod": "pin, elbow, motor, x refer to it",
        "pin": "motor refers to it",
        "half": "rod, arm, pin, elbow, motor, s, ... (8 in all) refer to it",
        "g": "pin, motor, s, q refer to it",
    }.items():
        with pytest.raises(UsageError) as caught:
            b.remove(name)
        assert caught.value.message == f"`{name}` cannot be removed: {users}"
    assert b.scene() == before


def test_what_is_removed_leaves_the_model_that_never_had_it():
    b, other = chain(), Builder("Chain")
    assert b.remove("arm", dependents=True) == ("arm", "elbow", "s", "q", "x")
    other.parameter("L", "1 m", type="Length")
    other.parameter("half", "L/2")
    g = other.Ground("g")
    rod = other.Rod("rod", m=2, length="L", frames={"tip": ("half/2", 0)})
    other.Torque("motor", other.Revolute("pin", g, rod.a), tau="1 N.m*sin(2*time)")
    other.initial(rod.phi, "30 deg")
    other.experiment(stop="2 s/m*L")
    assert b.scene() == other.scene()
    b.Rod("arm", m=3, length=1)  # the name is free
    assert b.scene().components["arm"].values["m"] == 3.0


def test_a_name_with_another_meaning_is_not_a_reference():
    """In the law of the spring `q`, `s` is its length, and not the component `s`."""
    b = chain()
    law = b.scene().components["q"].values["force"]
    assert b.remove("s") == ("s",)
    assert b.scene().components["q"].values["force"] is law


def test_everything_that_refers_is_found():
    b = Builder("M")
    g = b.Ground("g")
    for i in (1, 2):
        b.Rod(f"link[{i}]", m=1, length=1)
    b.frame("tip", "link[1]", r=(0.5, 0))
    b.RotationalSpringDamper("s", k=1)
    b.connect("s.frame_a", g)
    b.connect("link[2].b", "s.frame_b")
    b.input("u", unit="N.m")
    b.Torque("t", "link[2].a", tau=ex.coordinate("link[1].a", "phi") * 2.0)
    b.variable("v", "u + 1 N.m")
    b.parameter("T", "3 s")
    b.experiment(stop="2*T")
    b.initial("link[2].phi", "1 rad/s*T")
    for name, users in {
        "link[1]": "tip, t refer to it",
        "link[2]": "s, t refer to it",  # `s` is connected with it
        "link": "tip, s, t refer to it",
        "u": "v refers to it",
        "T": "the initial value of link[2].phi, experiment(stop) refer to it",
    }.items():
        with pytest.raises(UsageError, match="cannot be removed") as caught:
            b.remove(name)
        assert caught.value.message.endswith(f": {users}")
    assert b.remove("link[1]", dependents=True) == ("link[1]", "tip", "t")
    assert b.remove("link[2]", dependents=True) == ("link[2]", "s")
    assert b.remove("T", dependents=True) == ("T",)
    assert b.scene().experiment.stop is None and not b.scene().initial


# -- replacing ------------------------------------------------------------------------------------------------------


def test_a_replaced_component_is_in_the_place_of_the_first():
    b = chain()
    for length in ("L", "2*L"):  # as when a cell is run again
        rod = b.Rod("rod", m=2, length=length, frames={"tip": ("half/2", 0)}, replace=True)
    assert b.scene() == chain("2*L").scene()
    b.parameter("later", "3 m")
    b.Rod("rod", m=2, length="later", frames={"tip": ("half/2", 0)}, replace=True)
    assert b.scene().frames[str(rod.b)].x == 1.5


def test_every_declaration_can_be_replaced():
    b = chain()
    b.parameter("L", "3 m", type="Length", replace=True)
    b.variable("x", "rod.phi", replace=True)
    b.frame("stop", "rod.b", replace=True)
    b.frame("stop", "rod.a", replace=True)
    b.initial("rod.phi", "40 deg", replace=True)
    b.initial("arm.phi", None)
    b.shape("arm", replace=True)
    scene = b.scene()
    assert scene.parameters["half"].value == 1.5 and scene.experiment.stop == 6.0
    assert scene.variables["x"] is ex.coordinate("rod.c", "phi")
    assert scene.frames["stop"].x == -1.5 and scene.shapes["arm"] == ()
    assert [(i.name, round(i.value, 6)) for i in scene.initial] == [("rod.phi", 0.698132)]


def test_a_replacement_that_does_not_fit_is_refused():
    b = chain()
    before = b.scene()
    with pytest.raises(MbdslError, match="unknown name `lenght`") as caught:
        b.Rod("rod", m=1, length="lenght", replace=True)
    assert "note: `rod` is not replaced" in str(caught.value)
    assert b.scene() == before
    b.Body("rod", m=1, I=1, replace=True)
    with pytest.raises(MbdslError, match=r"<pin\.frame_b>:1:5: Body `rod` has no `a`"):
        b.scene()


# -- handles --------------------------------------------------------------------------------------------------------


def test_handles_of_removed_components_are_refused():
    b = chain()
    arm = b.Rod("new", m=1, length=1)
    tip = arm.b
    b.remove(arm)
    for use in (
        lambda: b.Revolute("p", "g", tip),
        lambda: b.variable("v", arm.phi),
        lambda: b.initial(tip.x, 0),
        lambda: b.shape(arm),
        lambda: b.remove(arm),
        lambda: arm.b,
        lambda: dir(arm),
    ):
        with pytest.raises(UsageError, match="`new` was removed from Chain"):
            use()
    b.Rod("new", m=1, length=1)
    with pytest.raises(UsageError, match="`new` was removed from Chain\n  = use the handle"):
        b.Revolute("p", "g", tip)


def test_a_builder_is_copied_with_its_content():
    b = chain()
    for again in (copy.deepcopy(b), pickle.loads(pickle.dumps(b))):
        again.Rod("other", m=1, length=1)
        assert "other" in again.scene().components and "other" not in b.scene().components
        again.remove("other")
        assert again.scene() == b.scene()


# -- new parameters -------------------------------------------------------------------------------------------------


def test_new_parameters_give_the_model_that_was_built_with_them():
    """Values that depend on them, in bodies, laws, initial values, shapes and the experiment, are evaluated again."""
    b, other = chain(), chain()
    other.parameter("L", "3 m", type="Length", replace=True)
    assert b.scene({"L": "300 cm"}) == b.scene().with_parameters(L=3) == other.scene()
    other.Rod("arm", m=5, length="half", replace=True)
    both = other.scene()
    assert b.scene({"L": 3, "arm.m": "5 kg"}) == b.scene({"L": 3}).with_parameters({"arm.m": 5.0}) == both
    assert both.experiment.stop == 6.0 and both.shapes["arm"][0].axes[0] == 0.15
    assert b.scene() == chain().scene()  # the Builder keeps its own


def test_elements_of_arrays_have_parameters():
    b = Builder("M")
    b.Ground("g")
    for i in (1, 2):
        b.Rod(f"link[{i}]", m=1, length=1)
    found = b.scene({"link[2].m": 4})
    assert [c.values["m"] for c in found.bodies()] == [1.0, 4.0]
    b.parameter("k", [1, 2, 3], type="Length")
    assert b.scene().parameters["k"].value == (1, 2, 3)
    assert b.scene({"k": [4, 5, 6]}).parameters["k"].value == (4, 5, 6)


def test_a_scene_of_a_text_takes_new_parameters(tmp_path, monkeypatch):
    """It is read from its own texts; the files may be gone. Values and effects that were given before are kept."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.mbd").write_text("model Arm Frame tip; Rod rod(m = 1 kg, length = 1 m); end Arm;")
    main = tmp_path / "a.mbd"
    main.write_text(
        'import "parts/arm.mbd"; model A parameter Length L = 1 m; parameter Length h = 2*L; Ground g; Arm arm;'
        "Rod rod(m = 1 kg, length = h); end A;"
    )
    monkeypatch.chdir(tmp_path)
    expected = mbdsl.load("a.mbd", {"arm.rod.m": 7, "L": "3 m"}, without=["gravity"])
    scene = mbdsl.load("a.mbd", {"arm.rod.m": 7}, without=["gravity"])
    main.unlink(), (tmp_path / "parts" / "arm.mbd").unlink()
    assert expected.components["rod"].values["length"] == 6.0
    for found in (scene, pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert found.with_parameters(L="3 m") == expected


def test_every_model_takes_parameters_alike():
    """A path, its Scene, and a Builder, as the argument of the functions that simulate and analyse."""
    path = MODELS / "slider_crank.mbd"
    given = {"L1": "0.25 m", "spring.k": 120.0}
    expected = mbdsl.load(path, given)
    assert as_scene(path, given) == as_scene(mbdsl.load(path), given) == expected
    b = chain()
    assert as_scene(b, {"L": 2}, ["gravity"]) == as_scene(b.scene(), {"L": 2}, ["gravity"])
    assert list(as_scene(b, {"L": 2}, ["gravity"]).without) == ["gravity"]


def test_a_scene_that_was_changed_takes_no_parameters():
    """It could differ from the text that the parameters would be inserted in."""
    changed = replace(chain().scene(), initial=())
    with pytest.raises(UsageError, match="made neither from a text nor by a Builder"):
        changed.with_parameters(L=2)


def test_a_run_of_a_scene_with_parameters_is_resumed(tmp_path, monkeypatch):
    """With the parameters of the run, and not with those of the scene."""
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 7)
    scene, file, seen = mbdsl.load(MODELS / "pendulum.mbd"), tmp_path / "run.checkpoint", []

    def stop(progress):
        seen.append(progress)
        if len(seen) == 2:
            raise KeyboardInterrupt

    given = {"parameters": {"L": "0.7 m"}, "stop": 0.1, "step": 1e-3}
    whole = mbdsl.simulate(scene, **given)
    with pytest.raises(mbdsl.Interrupted):
        mbdsl.simulate(scene, checkpoint=mbdsl.Checkpoint(file, 0.0), progress=stop, **given)
    assert (mbdsl.resume(file, scene).q == whole.q).all()
