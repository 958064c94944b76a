"""The errors and warnings of a model for an editor, found in a process of its own.

Reading a model is bounded (:mod:`mbdsl.lang.limits`), but a large model takes seconds. In another process the editor
does not wait, and a check is ended as soon as the text changes again. ``python -m mbdsl.editor.checking`` reads
requests from standard input and writes an answer to each to standard output, one line of JSON each.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from typing import Any

from mbdsl.editor import all_errors
from mbdsl.errors import MbdslError, ModelWarning, Span
from mbdsl.lang.library import Allowed, Library
from mbdsl.lang.load import read_scene
from mbdsl.lang.mistakes import unused
from mbdsl.mechanism import scene_tables
from mbdsl.mechanism.graph import build
from mbdsl.mechanism.scene import Scene


def check(text: str, file: str, texts: Mapping[str, str] = {}, allowed: Allowed | None = None) -> dict[str, Any]:
    """All errors and warnings of a file.

    Parameters
    ----------
    text : str
        The content of the file.
    file : str
        Its name; imports are relative to its folder.
    texts : mapping of str to str, optional
        Texts that are read instead of files.
    allowed : bool or path, optional
        Folders that imports may lead to, as for ``mbdsl.load``.

    Returns
    -------
    dict
        "problems": list of dict with "message", "hint", "severity", "span" and "notes"; "model": the main model;
        "values": its parameters and components in SI units. All are plain data for JSON.
    """
    answer: dict[str, Any] = {"problems": [], "model": "", "values": {}}
    if not text.strip():
        return answer
    problems, scene = all_errors.find(text, file, lambda left: read_scene(Library(allowed, unsaved=texts), left, file))
    if scene is not None:
        try:
            problems = [*scene.warnings, *build(scene).warnings, *unused.find(scene)]
        except MbdslError as problem:
            problems, scene = [problem], None
    if scene is not None:
        answer["model"], answer["values"] = scene.name, _values(scene)
    answer["problems"] = [_plain(problem) for problem in problems]
    return answer


def _values(scene: Scene) -> dict[str, str]:
    """Parameters, components and parameters of components -> their values, in SI units."""
    found = {}
    for p in scene.parameters.values():
        unit = "" if p.unit in ("", "1") else p.unit
        found[p.name] = f"{scene_tables.value(p.value, scene_tables.rounded)} {unit}".rstrip()
    for name, c in list(scene.components.items())[:2000]:
        values = {k: v for k, v in c.values.items() if v is not None and v != ()}
        shown = {k: scene_tables.with_unit(c, k, v, scene_tables.rounded) for k, v in values.items()}
        shown = {k: v if len(v) <= 200 else f"{v[:197]}..." for k, v in shown.items()}
        found.update({f"{name}.{k}": v for k, v in shown.items()})
        found[name] = ", ".join(f"{k} = {v}" for k, v in shown.items() if len(v) <= 60)
    return {name: value for name, value in found.items() if value}


def _plain(problem: MbdslError) -> dict[str, Any]:
    return {
        "message": problem.message,
        "hint": problem.hint or "",
        "severity": "warning" if isinstance(problem, ModelWarning) else problem.severity,
        "span": _span(problem.span),
        "notes": [(text, _span(span)) for text, span in problem.notes],
    }


def _span(span: Span | None) -> tuple[str, int, int, int] | None:
    return (span.file, span.line, span.column, span.length) if span is not None else None


def main() -> None:
    """Answer the requests on standard input."""
    answers = sys.stdout
    for request in sys.stdin:
        with redirect_stdout(None):  # what a library prints must not be mixed with the answer
            answer = _safely(json.loads(request))
        print(json.dumps(answer), file=answers, flush=True)


def _safely(request: dict[str, Any]) -> dict[str, Any]:
    """The answer to a request; an exception, which is a defect, becomes a warning in it."""
    try:
        return check(**request)
    except Exception as problem:
        return failed(f"internal error of the check: {type(problem).__name__}: {problem}")


def failed(message: str) -> dict[str, Any]:
    """The answer if a text could not be checked: a warning with the reason."""
    problem = {"message": message, "hint": "", "severity": "warning", "span": None, "notes": []}
    return {"problems": [problem], "model": "", "values": {}}


if __name__ == "__main__":
    main()
