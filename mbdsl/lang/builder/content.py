"""The content of a model under construction from Python."""

from __future__ import annotations

from dataclasses import dataclass, field

from mbdsl.lang import syntax as s
from mbdsl.lang.unparse import indices


@dataclass(frozen=True)
class DraftEntry:
    """A declaration; ``serial`` is its number, which its replacement keeps."""

    declaration: s.Declaration
    serial: int


@dataclass
class DraftContent:
    """All that was declared."""

    entries: dict[str, DraftEntry] = field(default_factory=dict)  #: by full name: ``link[3]``
    connections: list[s.Connect] = field(default_factory=list)
    rates: list[s.Relation] = field(default_factory=list)  #: equations of states
    events: list[s.When | s.Relation] = field(default_factory=list)  #: when-equations and assertions
    initial: list[s.Initial] = field(default_factory=list)
    settings: dict[str, s.Argument] = field(default_factory=dict)  #: of the experiment
    spatial: bool = False  #: whether it is a model in space

    def model(self, name: str, doc: str) -> s.Model:
        """The content as the syntax tree of a model."""
        # Elements of an array are declared one by one, as in a loop; an `If` without condition is such a block.
        items: list[s.Item] = [
            s.If(((None, (d,)),)) if is_element(d) else d for d in (e.declaration for e in self.entries.values())
        ]
        items.append(s.Annotation((s.Argument("experiment", None, tuple(self.settings.values())),)))
        equations = (*self.connections, *self.rates, *self.events)
        return s.Model(name, doc, tuple(items), equations, tuple(self.initial), spatial=self.spatial)


def is_element(d: s.Declaration) -> bool:
    """Whether the indices denote one element of an array; those of parameters are sizes."""
    return bool(d.indices) and all(isinstance(i, s.Number) for i in d.indices)


def full_name(d: s.Declaration) -> str:
    """``link[1,2]``, as components are called in a Scene."""
    return d.name + indices(d.indices).replace(" ", "") if is_element(d) else d.name
