"""Pictures of models in space: parallel projections."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.errors import UsageError
from mbdsl.viewing.projection import drawing, projected, view

MODELS = Path(__file__).parents[3] / "models"
SPACE = MODELS / "space"


@pytest.fixture(scope="module")
def top():
    return mbdsl.simulate(SPACE / "heavy_top.mbd", step=1e-3)


def test_isometric_view(top):
    """Seen from (1, -1, 1), the pictures of the axes have the length sqrt(2/3), 60 degrees apart; z points upwards."""
    seen = view(top.scene, "iso").of(np.eye(3))[:, :2]
    towards = np.array([1, -1, 1]) / np.sqrt(3)
    assert seen @ seen.T == pytest.approx(np.eye(3) - np.outer(towards, towards))
    assert seen[2] == pytest.approx([0, np.sqrt(2 / 3)])


@pytest.mark.parametrize(("name", "columns"), [("front", "xz"), ("side", "yz"), ("top", "xy")])
def test_principal_views(top, name, columns):
    motion = projected(top, name)
    found = motion.positions(motion.spot_of("top.foot"))
    centre = motion.positions(motion.spot_of("top"))
    assert found == pytest.approx(np.zeros((len(top.t), 2)), abs=1e-12)  # it is held at the origin
    assert centre == pytest.approx(np.stack([top[f"top.{i}"] for i in columns], axis=-1), abs=1e-12)


def test_gravity_points_downwards():
    """Along -y unless the ground says otherwise."""
    scene = mbdsl.load(SPACE / "bennett.mbd")
    for name in ("iso", "front", "side"):
        seen = view(scene, name).of(np.array([0.0, -9.81, 0.0]))
        assert abs(seen[0]) < 1e-12 and seen[1] < -8.0


def test_bodies_are_bars_and_discs():
    run = mbdsl.simulate(SPACE / "bicycle.mbd", stop=0.02)
    motion = projected(run, "side")
    drawn = [(shape.draw, shape.name) for shape in drawing(motion).shapes]
    assert {name for draw, name in drawn if draw == "wheel"} == {"rear", "front"}
    assert {"rider", "fork"} <= {name for draw, name in drawn if draw == "bar"}
    assert ("cylinder", "steer") in drawn
    # along the y axis, a wheel is a circle of its radius
    motion = projected(run, "front")
    wheel = next(shape for shape in drawing(motion).shapes if (shape.draw, shape.name) == ("wheel", "front"))
    edge = motion.places(wheel.items[0].at, 0)[:, :2]
    centre = motion.positions(motion.spot_of("front"))[0]
    assert np.hypot(*(edge - centre).T) == pytest.approx(0.35, abs=1e-4)


def test_page_and_film(top, tmp_path):
    page = top.animate(traces="top", view="side")
    page.save(tmp_path / "top.gif", (120, 90))
    assert (tmp_path / "top.gif").read_bytes()[:3] == b"GIF"
    assert "HeavyTop" in page.html


def test_wrong_views(top, capsys):
    with pytest.raises(UsageError, match="there is no view `frnt`"):
        top.animate(view="frnt")
    planar = mbdsl.simulate(MODELS / "pendulum.mbd", stop=0.1, step=0.01)
    with pytest.raises(UsageError, match="Pendulum is a planar model, and views are of models in space"):
        planar.animate(view="top")
    assert main(["animate", str(SPACE / "heavy_top.mbd"), "--view", "frnt"]) == 2
    assert "frnt" in capsys.readouterr().err


@pytest.mark.parametrize("path", sorted(SPACE.glob("*.mbd")), ids=lambda path: path.stem)
def test_every_model_has_a_picture_and_a_page(path):
    """On the page each body has a solid of a finite size on its own track."""
    scene = mbdsl.load(path)
    run = mbdsl.simulate(scene, stop=0.01, interval=0.005)
    motion = projected(run)
    assert {c.name for c in scene.bodies()} <= {shape.name for shape in drawing(motion).shapes}
    assert np.isfinite(motion.poses).all()
    data = json.loads(run.animate().html.partition('id="data">')[2].partition("</script>")[0])
    for name, at in data["bodies"].items():
        own = [s for s in data["solids"] if s["name"] == name and s["role"] == "body"]
        assert own, name
        assert all(spot[0] == at[0] for s in own for spot in s["at"])
    numbers = [x for s in data["solids"] for x in (*s["size"], *(y for spot in s["at"] for y in spot))]
    assert np.isfinite(numbers).all() and all(min(s["size"]) > 0.0 for s in data["solids"])
