"""Models in space, built from Python: the same Scene, bit for bit, as from text; wrong calls change nothing."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.elements import kinds
from mbdsl.errors import ModelError

SPACE = Path(__file__).parents[3] / "models" / "space"


def top():
    b = mbdsl.SpatialBuilder("HeavyTop", "A fast symmetric top under gravity, whose point is held by a ball joint")
    ground = b.Ground("ground", n=(0, 0, -1))
    body = b.Body("top", m="15 kg", I=(0.234375, 0.46875, 0.234375), frames={"foot": (0, -1, 0)})
    b.Spherical("ball", ground, body.foot)
    b.initial(body.y, "1 m")
    b.initial(body.wy, 150.0)
    b.initial(body.wz, "-4.61538 rad/s")
    b.experiment(stop="0.1 s", interval="1 ms")
    return b


def test_the_same_motion_as_from_text():
    one = mbdsl.simulate(top().scene(), step=1e-3)
    other = mbdsl.simulate(SPACE / "heavy_top.mbd", step=1e-3)
    for x in "tqv":
        assert np.array_equal(getattr(one, x), getattr(other, x))


def test_all_kinds_in_space_are_methods():
    b = mbdsl.SpatialBuilder("M")
    for name in kinds(spatial=True):
        assert getattr(b, name).__doc__.startswith("Add a")


@pytest.mark.parametrize("name", ["FlexibleBeam", "PlanarWorld"])
def test_kinds_of_the_plane_alone_are_no_methods(name):
    b = mbdsl.SpatialBuilder("M")
    assert hasattr(mbdsl.Builder("M"), name) and name in dir(mbdsl.Builder("M"))
    assert not hasattr(b, name) and name not in dir(b) and not hasattr(mbdsl.SpatialBuilder, name)
    with pytest.raises(AttributeError, match=f"^SpatialBuilder has no `{name}`") as caught:
        getattr(b, name)
    assert f"did you mean `{name}`" not in str(caught.value)
    with pytest.raises(ModelError, match=f"there is no kind of component called `{name}` in space"):
        b.add(name, "x")
    assert {"Ground", "World", "Spherical", "frame", "scene", "name"} <= set(dir(b))


def test_frames_turned_about_an_axis():
    b = mbdsl.SpatialBuilder("M")
    ground = b.Ground("ground")
    b.frame("f", ground, r=(1, 2, 3), n=(0, 0, 2), phi="90 deg")
    body = b.Body("body", m=1, I=((1, 0.1, 0), (0.1, 2, 0), (0, 0, 2)))
    b.Spherical("ball", "f", body.c)
    found = b.scene().frames["f"]
    assert found.pose[:3] == (1.0, 2.0, 3.0)
    assert found.axes == pytest.approx((0, 1, 0, -1, 0, 0, 0, 0, 1), abs=1e-15)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (
            lambda b: b.add("FlexibleBeam", "f", length=1),
            "there is no kind of component called `FlexibleBeam` in space",
        ),
        (lambda b: b.Revolute("j", "ground", "top.foot", axis=(0, 0, 1)), "Revolute `j` has no parameter `axis`"),
        (lambda b: b.Body("k", m=1, I=(1, 1, 1, 1)), "found an array of 4 values, expected an array of 3 values"),
        (lambda b: b.Revolute("j", "ground", "top.foot", n=(0, 0, 0)), "the axis n is zero"),
    ],
)
def test_wrong_calls_are_refused(wrong, message):
    b = top()
    before = b.scene()

    def build():
        wrong(b)
        b.scene()

    with pytest.raises(ModelError) as caught:
        build()
    assert message in str(caught.value)
    for name in {"j", "k"} & set(b._draft.content.entries):
        b.remove(name)
    assert b.scene() == before


def test_builders_of_the_plane_have_no_kinds_of_space():
    with pytest.raises(ModelError, match="there is no kind of component called `Spherical`"):
        mbdsl.Builder("M").add("Spherical", "ball")


def test_pickled_and_with_other_parameters():
    b = mbdsl.SpatialBuilder("Pendulum")
    length = b.parameter("L", "0.5 m")
    ground = b.Ground("ground")
    bob = b.PointMass("bob", m=1)
    b.Distance("rope", ground, bob, length=length)
    scene = pickle.loads(pickle.dumps(b)).scene()
    assert scene.components["rope"].values["length"] == 0.5
    assert scene.with_parameters(L=0.7).components["rope"].values["length"] == 0.7


@pytest.mark.parametrize("dependents", [False, True])
def test_after_a_removal_the_model_remains_in_space(dependents):
    """The same scene as of a Builder that never had the component."""
    b = top()
    b.Box("box", m=1, length=1, width=1, height=1)
    b.remove("box", dependents=dependents)
    assert b.scene() == top().scene() and b.scene().spatial
    with pytest.raises(ModelError, match="there is no kind of component called `FlexibleBeam` in space"):
        b.add("FlexibleBeam", "beam", length=1)


def test_replaced_the_model_remains_in_space():
    b = top()
    b.Body("top", m="15 kg", I=(0.234375, 0.46875, 0.234375), frames={"foot": (0, -1, 0)}, replace=True)
    b.initial("top.wy", 150.0, replace=True)
    assert {**b.scene().components} == {**top().scene().components} and b.scene().spatial


def test_what_is_connected_with_a_removed_body_refers_to_it():
    """A joint that exists in space only, and is connected by ``connect``."""
    b = mbdsl.SpatialBuilder("M")
    ground, body, ball = b.Ground("ground"), b.PointMass("body", m=1), b.Spherical("ball")
    b.connect(ball.frame_a, ground)
    b.connect(ball.frame_b, body)
    with pytest.raises(mbdsl.errors.UsageError, match="`body` cannot be removed: ball refers to it"):
        b.remove("body")
    assert b.remove("body", dependents=True) == ("body", "ball")
    assert list(b.scene().components) == ["ground"]
