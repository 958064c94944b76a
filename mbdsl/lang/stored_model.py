"""A model as one text that a result file can hold: its files, the values that replaced its parameters, its effects."""

from __future__ import annotations

import json
from collections.abc import Mapping

from mbdsl.errors import UsageError
from mbdsl.lang.load import TextOrigin
from mbdsl.mechanism.scene import Scene


def to_text(scene: Scene, overrides: Mapping[str, str | float] | None = None) -> str:
    """A model as text, from which :func:`from_text` reads an equal scene.

    Parameters
    ----------
    scene : Scene
        A model that was read from files or from a text.
    overrides : mapping, optional
        The values that replaced those of its parameters. Default: those that the scene was read with.

    Returns
    -------
    str
        JSON; "" for a scene without source files.
    """
    if not scene.files:
        return ""
    if overrides is None:
        overrides = scene.origin.overrides if scene.origin is not None else {}
    said = {"model": scene.name, "set": dict(overrides), "without": list(scene.without), "files": dict(scene.files)}
    return json.dumps(said, ensure_ascii=False)


def from_text(text: str) -> Scene:
    """The scene of a text of :func:`to_text`.

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
        next(iter(files))
    except (ValueError, KeyError, TypeError, AttributeError, StopIteration) as problem:
        raise UsageError(f"the stored model is damaged: {type(problem).__name__}: {problem}") from problem
    return TextOrigin(files, model, overrides, tuple(without)).scene({})
