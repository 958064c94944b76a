"""The errors and warnings of a model for an editor, found in a process of its own.

Reading a model is bounded (:mod:`mbdsl.lang.limits`), but a large model takes seconds. In another process the editor
does not wait, and a check is ended as soon as the text changes again. ``python -m mbdsl.editor.checking`` reads one
request from standard input and writes one answer to standard output, both as JSON.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from typing import Any

from mbdsl.editor import entities as e
from mbdsl.editor.library import LooseLibrary
from mbdsl.editor.names import Names
from mbdsl.editor.positions import Places
from mbdsl.editor.repair import repaired, statements
from mbdsl.errors import MbdslError, Span
from mbdsl.lang.library import Allowed, Library, key_of
from mbdsl.lang.load import read_scene
from mbdsl.mechanism import scene_tables
from mbdsl.mechanism.graph import build
from mbdsl.mechanism.scene import Scene

ERRORS = 10  #: errors of the model, after those of the syntax


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
    problems: list[MbdslError] = list(repaired(text, file).problems)
    if not problems:
        problems, scene = _errors_of_model(text, file, texts, allowed)
        if scene is not None:
            answer["model"], answer["values"] = scene.name, _values(scene)
    answer["problems"] = [_plain(problem) for problem in problems]
    return answer


def _errors_of_model(
    text: str, file: str, texts: Mapping[str, str], allowed: Allowed | None
) -> tuple[list[MbdslError], Scene | None]:
    """Errors, or warnings and the scene.

    Reading a model ends at its first error. If nothing else depends on the statement with the error, it is left out,
    and the model is read again.
    """
    problems: list[MbdslError] = []
    for _ in range(ERRORS):
        try:
            scene = read_scene(Library(allowed, unsaved=texts), text, file)
            return (problems, None) if problems else ([*scene.warnings, *build(scene).warnings], scene)
        except MbdslError as problem:
            problems.append(problem)
            left = _without(text, file, problem.span) if problem.span is not None else None
            if left is None:
                break
            text = left
    return problems, None


def _without(text: str, file: str, span: Span) -> str | None:
    """The text without a statement, if no other statement can have an error because of that."""
    if key_of(span.file) != key_of(file):
        return None
    at = Places(text).of_span(span)[0]
    start, end = next(((x.start, x.end) for x in statements(text) if x.start <= at < x.end), (0, 0))
    names = Names(LooseLibrary(False).add(text, file))
    declared = [o for o in names.occurrences if start <= o.start < end and o.declares]
    if any(not _is_optional(o.found) for o in declared):
        return None
    elsewhere = (o for o in names.occurrences if not start <= o.start < end)
    if {o.symbol for o in declared} & {o.symbol for o in elsewhere}:
        return None
    others = r"(connect|extends|import|model|spatial|partial|end|for|if|else|elseif)\b"
    if not declared and re.match(others, text[start:end]):
        return None
    return text[:start] + re.sub(r"[^\n]", " ", text[start:end]) + text[end:] if end else None


def _is_optional(found: object) -> bool:
    """Whether a model can be without a declaration that nothing refers to; it needs a ground."""
    if isinstance(found, e.OfKind):
        return True
    return isinstance(found, e.Entity) and found.form != e.UNKNOWN and getattr(found.kind, "name", "") != "Ground"


def _values(scene: Scene) -> dict[str, str]:
    """Parameters, components and parameters of components -> their values, in SI units."""
    found = {}
    for p in scene.parameters.values():
        unit = "" if p.unit in ("", "1") else p.unit
        found[p.name] = f"{scene_tables.value(p.value, scene_tables.rounded)} {unit}".rstrip()
    for name, c in list(scene.components.items())[:2000]:
        values = {k: v for k, v in c.values.items() if v is not None and v != ()}
        shown = {k: scene_tables.with_unit(c.kind, k, v, scene_tables.rounded) for k, v in values.items()}
        shown = {k: v if len(v) <= 200 else f"{v[:197]}..." for k, v in shown.items()}
        found.update({f"{name}.{k}": v for k, v in shown.items()})
        found[name] = ", ".join(f"{k} = {v}" for k, v in shown.items() if len(v) <= 60)
    return {name: value for name, value in found.items() if value}


def _plain(problem: MbdslError) -> dict[str, Any]:
    return {
        "message": problem.message,
        "hint": problem.hint or "",
        "severity": problem.severity,
        "span": _span(problem.span),
        "notes": [(text, _span(span)) for text, span in problem.notes],
    }


def _span(span: Span | None) -> tuple[str, int, int, int] | None:
    return (span.file, span.line, span.column, span.length) if span is not None else None


def main() -> None:
    """Answer the request on standard input."""
    request = json.load(sys.stdin)
    with redirect_stdout(None):  # what a library prints must not be mixed with the answer
        answer = check(**request)
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main()
