"""Every model of the gallery has a page, a small film and a place in the index; it runs; driven loops stay closed."""

import io
import re
from pathlib import Path

import numpy as np
import pytest

from mbdsl.mechanism import graph

Image = pytest.importorskip("PIL.Image", reason="films need Pillow")

ROOT = Path(__file__).parents[2]
PAGES, MODELS = ROOT / "docs" / "gallery", ROOT / "models" / "gallery"
NAMES = sorted(path.stem for path in MODELS.glob("*.mbd"))


def is_driven(scene):
    """Whether the motion follows from drivers alone."""
    return graph.build(scene).mobility <= 0 and any("Driver" in c.kind.name for c in scene.components.values())


def test_models_pages_films_and_index_agree(draw):
    """After a change of a title or a new model: ``python docs/draw_gallery.py NAME``."""
    assert sorted(name for names in draw["GROUPS"].values() for name in names) == NAMES
    assert sorted(path.stem for path in PAGES.glob("*.md") if path.stem != "index") == NAMES
    assert sorted(path.stem for path in PAGES.glob("*.gif")) == NAMES
    assert (PAGES / "index.md").read_text(encoding="utf-8") == draw["index"]()


@pytest.mark.parametrize("name", NAMES)
def test_page_and_film(name, gallery, draw):
    scene, page = gallery(name), (PAGES / f"{name}.md").read_text(encoding="utf-8")
    assert re.match(rf"# .+\n\n!\[[^]]{{20,}}\]\({name}\.gif\)\n\n", page)
    frames = {*scene.frames, *scene.aliases}
    assert all(trace in frames or f"{trace}.c" in frames for trace in draw["option"](name, "--trace"))
    text = (MODELS / f"{name}.mbd").read_text(encoding="utf-8")
    assert scene.doc and scene.experiment.stop and len(text.splitlines()) <= 60
    content = (PAGES / f"{name}.gif").read_bytes()
    assert len(content) <= draw["LARGEST"]
    with Image.open(io.BytesIO(content)) as film:
        assert film.size in draw["SIZES"] and film.n_frames >= 16 and film.info["loop"] == 0
    # beside the picture, if and only if the model is driven
    assert bool(draw["RESIDUAL"].search(page)) == is_driven(scene)


@pytest.mark.parametrize("name", NAMES)
def test_run(name, gallery, turned, whole, draw):
    """The loops of driven models stay closed over 1,000 revolutions; the other models run to their end."""
    scene = gallery(name)
    if is_driven(scene):
        run = turned(name)
        assert draw["residual"](run) <= 1e-12
        page = (PAGES / f"{name}.md").read_text(encoding="utf-8")
        assert float(draw["RESIDUAL"].search(page)[0].split()[-2]) <= 1e-12
    else:
        run = whole(name)
    assert run.select(draw["option"](name, "--signals")) or "--signals" not in draw["page"](name)
    assert run.status == "done" and np.isfinite(run.q).all() and np.isfinite(run.v).all()
    assert np.ptp(run.q, axis=0).max() > 1e-3  # it moves
