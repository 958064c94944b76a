"""Another kind in the library costs a scene without it nothing: not a byte of its code, and no compilation.

The tests run in processes of their own, since kinds are discovered once. The new kind lies in a folder that is added to
the path of the package of elements, as an installed file would be.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import mbdsl
from mbdsl import elements
from mbdsl.compilation import code_cache
from mbdsl.storage import cache_folder

ROOT = Path(mbdsl.__file__).parents[1]
SLIDER_CRANK = Path(__file__).parents[3] / "models" / "slider_crank.mbd"
KIND = '''
"""Tether: pulls two points together with a constant tension, in the plane and in space."""

from mbdsl.elements.kind import ForceKind, in_space
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.rows import LENGTH

KIND = ForceKind(
    "Tether",
    doc="A constant tension along the line between two points.",
    g=(LENGTH,),
    parameters=(Parameter("force", "N", doc="tension", law=True),),
    laws=("force",),
    drawing="spring",
)
IN_SPACE = in_space(KIND)
'''
#: a joint in space: its rows are all that it needs
JOINT = '''
"""Pointer: the x axis of frame_a points to the origin of frame_b, on a line of any length."""

from mbdsl.elements.kind import JointKind
from mbdsl.elements.rows import along

IN_SPACE = JointKind(
    "Pointer",
    doc="The x axis of frame_a points to frame_b.",
    g=(along("y"), along("z")),
    drawing="rod",
    spatial=True,
)
'''
NAME = "tether"
MODEL = """
model Tethered
  Ground ground;
  Frame hook(ground, r = {2 m, 0});
  PointMass weight(m = 1 kg);
  {kind}
initial equation
  weight.x = 0 m;
  weight.y = 0 m;
  annotation(experiment(StopTime = 0.5 s));
end Tethered;
"""
SCRIPT = """
import json, sys
import mbdsl.elements
if len(sys.argv) > 2:
    mbdsl.elements.__path__.append(sys.argv[2])
import mbdsl
from mbdsl.mechanism import graph
from mbdsl.compilation import code_cache
from mbdsl.storage import cache_folder
from mbdsl.system import build

scene = mbdsl.load(sys.argv[1])
system = build(scene, graph.build(scene))
names = [system.module_name(sets) for sets in (1, 2, 3)]
said = []
trajectory = mbdsl.simulate(scene, method="newmark", announce=said.append)  # which compiles in the least time
cache = cache_folder.own() / code_cache.version()
texts = [path.name for path in sorted(cache.glob("*.py"))]
json.dump({
    "kinds": len(mbdsl.elements.kinds()),
    "codes": [system.code],
    "names": names,
    "said": said,
    "cache": str(cache),
    "emitted": texts,
    "q": trajectory.q[-1].tolist(),
}, sys.stdout)
"""


def run(model, cache, *folder, root=ROOT):
    environment = {**os.environ, "PYTHONPATH": str(root), "MBDSL_CACHE_DIR": str(cache)}
    command = [sys.executable, "-c", SCRIPT, str(model), *map(str, folder)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=root, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "more"
    folder.mkdir()
    (folder / f"{NAME}.py").write_text(KIND, encoding="utf-8")
    return folder


def model(tmp_path, kind):
    path = tmp_path / "tethered.mbd"
    path.write_text(MODEL.replace("{kind}", kind), encoding="utf-8")
    return path


def test_a_scene_without_it_is_untouched(folder):
    """The code, its name and its cache are the same, and all is found compiled: nothing is announced, nothing is
    emitted."""
    cache = cache_folder.own()
    run(SLIDER_CRANK, cache)  # code that still has to be compiled
    before, after = run(SLIDER_CRANK, cache), run(SLIDER_CRANK, cache, folder)
    assert after["kinds"] == before["kinds"] + 1
    for key in ("codes", "names", "cache", "emitted", "said", "q"):
        assert after[key] == before[key], key
    assert after["said"] == []


def test_a_file_more_in_the_package(tmp_path):
    """One file, no list: it becomes a word of the language, and no other scene is compiled again."""
    shutil.copytree(ROOT / "mbdsl", tmp_path / "mbdsl", ignore=shutil.ignore_patterns("__pycache__"))
    cache, element = tmp_path / "cache", tmp_path / "mbdsl" / "elements" / f"{NAME}.py"
    before = run(SLIDER_CRANK, cache, root=tmp_path)
    assert before["said"] != [] or not code_cache.enabled()  # it was compiled
    element.write_text(KIND, encoding="utf-8")
    after = run(SLIDER_CRANK, cache, root=tmp_path)
    assert after["kinds"] == before["kinds"] + 1
    assert after["said"] == []
    for key in ("codes", "names", "cache", "emitted", "q"):
        assert after[key] == before[key], key
    with_it = run(model(tmp_path, "Tether t(hook, weight, force = 3 N);"), cache, root=tmp_path)
    assert f"{NAME}.fill" in with_it["codes"][0]
    element.write_text(KIND.replace("g=(LENGTH,)", "g=(LENGTH,),  # edited"), encoding="utf-8")
    assert run(model(tmp_path, "Tether t(hook, weight, force = 3 N);"), cache, root=tmp_path)["said"] != []


def test_a_scene_with_it_has_it(folder, tmp_path):
    """It needs no list: word of the language, kernels with exact derivatives, code of its own."""
    cache = cache_folder.own()
    found = run(model(tmp_path, "Tether t(hook, weight, force = 3 N);"), cache, folder)
    assert f"import mbdsl_kind_{NAME} as {NAME}" in found["codes"][0]
    assert f"{NAME}.fill" in found["codes"][0] and f"{NAME}.curve" in found["codes"][0]
    # the same force by an existing kind: a spring and damper whose law is the tension
    twin = run(model(tmp_path, "SpringDamper t(hook, weight, force = 3 N);"), cache)
    assert NAME not in twin["codes"][0]
    assert found["q"] == twin["q"]
    assert found["names"] != twin["names"]


def test_a_joint_in_space_is_one_file(folder, tmp_path):
    """Without kernels, reactions or a list: it is held like a bead by PointOnLine, whose rows it has."""
    (folder / "pointer.py").write_text(JOINT, encoding="utf-8")
    cache, ends = cache_folder.own(), []
    for kind in ("Pointer", "PointOnLine"):
        path = tmp_path / f"{kind}.mbd"
        text = MODEL.replace("model", "spatial model", 1).replace("{2 m, 0}", "{2 m, 0, 0}")
        text = text.replace("{kind}", f"Tether t(hook, weight, force = 3 N); {kind} p(ground, weight);")
        text = text.replace("weight.x = 0 m;\n  weight.y = 0 m;", "weight.x = 1 m;")
        path.write_text(text, encoding="utf-8")
        ends.append(run(path, cache, folder))
    assert ends[0]["q"] == ends[1]["q"] != [1.0, 0.0, 0.0]
    assert "mbdsl_kind_in_space_pointer" in ends[0]["codes"][0]
    assert "pointer" not in ends[1]["codes"][0]


def test_the_file_of_a_kind_has_its_name():
    """A model imports the files of its own kinds only; they are found by their names."""
    assert {name: module.__name__.rpartition(".")[2] for name, module in elements.modules().items()} == {
        name: elements.file_of(name) for name in elements.kinds()
    }
