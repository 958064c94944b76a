"""A model as one text that a result file can hold: its files, the values that replaced its parameters, its effects."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from mbdsl.errors import UsageError
from mbdsl.lang.load import load, parse_text
from mbdsl.mechanism.scene import Scene
from mbdsl.storage.output_files import write_text


def to_text(scene: Scene, overrides: Mapping[str, str | float] = {}) -> str:
    """A model as text, from which :func:`from_text` reads an equal scene.

    Parameters
    ----------
    scene : Scene
        A model that was read from files or from a text.
    overrides : mapping, optional
        The values that replaced those of its parameters.

    Returns
    -------
    str
        JSON; "" for a scene without source files.
    """
    if not scene.files:
        return ""
    said = {"model": scene.name, "set": dict(overrides), "without": list(scene.without), "files": dict(scene.files)}
    return json.dumps(said, ensure_ascii=False)


def from_text(text: str) -> Scene:
    """The scene of a text of :func:`to_text`.

    Parameters
    ----------
    text : str
        The text.

    Returns
    -------
    Scene
        The model. Files of the same names are not read.

    Raises
    ------
    UsageError
        If the text is damaged.
    MbdslError
        If the model is invalid.
    """
    try:
        said = json.loads(text)
        files = {str(name): str(content) for name, content in said["files"].items()}
        overrides = {str(name): x if isinstance(x, int | float) else str(x) for name, x in said["set"].items()}
        model, without = str(said["model"]), [str(effect) for effect in said["without"]]
        main = next(iter(files))
        whole = {name: os.path.abspath(name.replace("\0", "_")) for name in files}
        common = os.path.commonpath([os.path.dirname(path) for path in whole.values()])
    except (ValueError, KeyError, TypeError, AttributeError, StopIteration) as problem:
        raise UsageError(f"the stored model is damaged: {type(problem).__name__}: {problem}") from problem
    if len(files) == 1:
        return parse_text(files[main], main, overrides, model, without, allow_imports=False)
    with tempfile.TemporaryDirectory(prefix="mbdsl-") as folder:  # imports are relative to the files
        copies = {name: Path(folder, os.path.relpath(path, common)) for name, path in whole.items()}
        for name, copy in copies.items():
            copy.parent.mkdir(parents=True, exist_ok=True)
            write_text(copy, files[name])
        return load(copies[main], overrides, model, without, allow_imports=folder)
