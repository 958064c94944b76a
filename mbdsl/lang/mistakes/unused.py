"""Parameters and inputs that no expression of their model uses: often a misspelt or forgotten name."""

from __future__ import annotations

from mbdsl.errors import ModelNote
from mbdsl.lang import syntax as s
from mbdsl.lang.inheritance import declarations, reachable
from mbdsl.lang.library import Library, SourceUnit
from mbdsl.lang.load import deep
from mbdsl.lang.parser import LONGEST
from mbdsl.lang.source import span_of
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import few


def find(scene: Scene) -> list[ModelNote]:
    """One note about all unused values of the models in the main file that a scene consists of; none for a Builder's.

    A value counts as used if an expression of its model, or of one that extends it, has its name, or if any expression
    reads it from outside, as in ``arm.L``. Texts that would have to be parsed again for it are not searched.
    """
    main = next(iter(scene.files), None)
    if main is None or len(scene.files[main]) > LONGEST:
        return []
    with deep():
        unit = Library(texts=scene.files).add(scene.files[main], main)
        found = unit.find(scene.name)
        unused = [] if found is None else _unused(*found)
    if not unused:
        return []
    first, *others = unused
    word = "parameter" if all("input" not in d.prefixes for d in unused) else "value"
    names = few([f"`{d.name}`" for d in unused])
    return [
        ModelNote(
            f"nothing uses the {word}{'s' if others else ''} {names}",
            span_of(first.at),
            "use or delete what is not needed; a name may be misspelt where it is used",
            tuple((f"`{d.name}` is declared here", span_of(d.at)) for d in others[:4]),
        )
    ]


def _unused(model: s.Model, unit: SourceUnit) -> list[s.Declaration]:
    models = reachable(model, unit)
    references = [[x for x in s.inside(m) if isinstance(x, s.Reference)] for m in models]
    read = {step.name for each in references for r in each for step in r.steps[1:]}
    used = [read.union(r.steps[0].name for r in each) for each in references]
    bases = [_bases(m, unit) for m in models]
    found = []
    for m in (m for m in models if any(m is x for x in unit.file.models)):
        names = set[str]().union(*(own for own, above in zip(used, bases, strict=True) if any(m is x for x in above)))
        values = (d for item in m.items for d in declarations(item) if d.prefixes & {"parameter", "constant", "input"})
        found += [d for d in values if d.name not in names]
    return found


def _bases(model: s.Model, unit: SourceUnit) -> list[s.Model]:
    """A model and all that it extends."""
    bases = [unit.find(item.base) for item in model.items if isinstance(item, s.Extends)]
    return [model, *(x for base in bases if base is not None for x in _bases(*base))]
