"""One method of the Builder for each kind of component, with its signature and documentation.

The methods follow from the declarations of the kinds. Editors and type checkers read them from ``kind_methods.pyi``,
which is written when mbdsl is built or installed.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from textwrap import fill, indent
from typing import Any

from mbdsl.elements import kinds
from mbdsl.elements.declaration import REQUIRED, Parameter
from mbdsl.elements.kind import BodyKind, Kind
from mbdsl.errors import UsageError
from mbdsl.lang.builder.handles import Handle
from mbdsl.lang.kind_reference import notes
from mbdsl.lang.modelica_names import KINDS as ALIASES
from mbdsl.messages import did_you_mean

_WIDTH = 72  #: with the indents of `help`, 80 columns
_FRAMES = 'Further frames: ``{"tip": (x, y)}`` [m] or ``{"tip": (x, y, phi)}`` [m, rad], from the reference point.'
_FRAMES_IN_SPACE = (
    'Further frames: ``{"tip": (x, y, z)}`` [m], from the reference point, or with an orientation as of the method '
    '``frame``: ``{"tip": {"r": (x, y, z), "angles": (a, b, c)}}`` [m, rad].'
)


class KindMethods:
    """The methods of a Builder that add components."""

    def __getattr__(self, name: str) -> Any:
        hint = did_you_mean(name, [n for n in dir(self) if not n.startswith("_")])
        raise AttributeError(f"{type(self).__name__} has no `{name}`" + (f"; {hint}" if hint else ""))

    def __dir__(self) -> list[str]:
        return [n for n in super().__dir__() if not isinstance(inspect.getattr_static(type(self), n, None), _NoMethod)]


def known(spatial: bool = False) -> dict[str, Kind]:
    """Name of a method -> its kind."""
    found = kinds(spatial)
    aliases = {name: found[kind] for name, kind in ALIASES.items() if not (spatial and name == "PlanarWorld")}
    return dict(sorted({**found, **aliases}.items()))


def missing(spatial: bool) -> list[str]:
    """Names of the methods of the plane that a Builder of models in space does not have."""
    return [name for name in known() if name not in known(spatial)]


def signature(kind: Kind) -> inspect.Signature:
    """The signature of the method of a kind; annotations are texts."""
    named = inspect.Parameter.KEYWORD_ONLY
    found = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    found.append(inspect.Parameter("name", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation="str"))
    if kind.ports:
        found.append(inspect.Parameter("frames", inspect.Parameter.VAR_POSITIONAL, annotation="Place"))
        found += [inspect.Parameter(port, named, default=None, annotation="Place | None") for port in kind.ports]
    both = {x.name for x in kind.signals if kind.parameter(x.name)}
    for p in kind.parameters:
        start = " | StartValue" if p.name in both else ""
        optional = " | None" if p.default is None else ""
        default = inspect.Parameter.empty if p.default is REQUIRED else {} if p.name == "frames" else p.default
        way = inspect.Parameter.POSITIONAL_OR_KEYWORD if p.name in kind.coupled else named
        found.append(inspect.Parameter(p.name, way, default=default, annotation=_type(p) + start + optional))
    found += [
        inspect.Parameter(x.name, named, default=None, annotation="StartValue | None")
        for x in kind.signals
        if x.name not in both
    ]
    found.append(inspect.Parameter("doc", named, default="", annotation="str"))
    found.append(inspect.Parameter("replace", named, default=False, annotation="bool"))
    return inspect.Signature(found, return_annotation="Handle")


def _type(p: Parameter) -> str:
    if p.name == "frames":
        return "Frames"
    if p.name == "over":
        return "Places"
    if p.law:
        return "Law"
    if p.choices:
        return f"Literal[{', '.join(map(_quoted, p.choices))}] | Handle"
    if isinstance(p.default, bool):
        return "bool | str | Handle"
    return "Vector" if p.shape else "Number | Vector" if p.or_shapes else "Number"


def documentation(name: str, kind: Kind) -> str:
    """The docstring of the method of a kind."""
    article = "an" if name[0] in "AEIO" else "a"
    entries = [("name : str", "Name of the component.")]
    if kind.ports:
        ports = [f"``{port}``" + (" (optional)" if port in kind.optional_ports else "") for port in kind.ports]
        text = f"Frames, in this order: {', '.join(ports)}. A joint stands for its two frames."
        entries.append(("*frames : Handle or str", text))
        entries.append((f"{', '.join(kind.ports)} : Handle or str, optional", "The same frames by name."))
    for p in kind.parameters:
        optional = "" if p.default is REQUIRED else ", optional"
        meaning = _sentence(notes(kind, p)) if p.name != "frames" else _FRAMES_IN_SPACE if kind.spatial else _FRAMES
        entries.append((f"{p.name} : {_words(p)}{optional}{_unit(p.unit)}", meaning))
    starts = [x.name for x in kind.signals if kind.parameter(x.name) is None]
    if starts:
        text = 'Initial values of its signals: ``{"start": value, "fixed": True}``.'
        entries += [(f"{', '.join(names)} : mapping, optional", text) for names in _parts(starts, 12)]
    entries.append(("doc : str, optional", "Description, one line."))
    entries.append(("replace : bool, optional", "True: replaces the component of this name, if there is one."))
    has = [f"``{x.name}``{_unit(x.unit)}{f' ({x.doc})' if x.doc else ''}" for x in kind.signals]
    reactions = getattr(kind, "reactions", ())
    if reactions:
        has += [f"``{x.name}``{_unit(x.unit)} ({x.doc} on frame_b)" for x in reactions]
    has += [f"``{x.name}``{_unit(x.unit)} ({x.doc})" for x in kind.outputs if x not in reactions]
    first = "its frames, and its signals " if isinstance(kind, BodyKind) else "its ports, and its signals "
    result = f"The component; its attributes are {first}{', '.join(has)}." if has else "The component."
    lines = [f"Add {article} {name}: {kind.doc[:1].lower() + kind.doc[1:]}", "", "Parameters", "----------"]
    lines[0] = fill(lines[0], _WIDTH)
    for head, text in entries:
        lines += [head, indent(fill(text, _WIDTH), "    ")] if text else [head]
    lines += ["", "Returns", "-------", "Handle", indent(fill(result, _WIDTH), "    ")]
    lines += ["", "Raises", "------", "ModelError, UsageError", "    If a name is wrong; the model does not change."]
    return "\n".join(lines)


def _parts(names: list[str], size: int) -> list[list[str]]:
    return [names[k : k + size] for k in range(0, len(names), size)]


def _words(p: Parameter) -> str:
    if p.name in ("frames", "over"):
        return "mapping" if p.name == "frames" else "Handle, str or sequence of them"
    if p.choices or isinstance(p.default, bool):
        return "{" + ", ".join(map(_quoted, p.choices)) + "}" if p.choices else "bool"
    if p.law:
        return "number, str or Expr"
    sizes = ", ".join("n" if x is None else str(x) for x in p.shape)
    return f"({sizes},) numbers or str" if p.shape else "number or str"


def _quoted(word: str) -> str:
    return f'"{word}"'


def _unit(unit: str) -> str:
    return f" [{unit}]" if unit not in ("", "1") else ""


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".") if text else ""


def _method(name: str, kind: Kind) -> Callable[..., Handle]:
    def method(self, *given: Any, **values: Any) -> Handle:
        if not given and "name" not in values:
            raise UsageError(f"{name} needs a name", hint=f'the name comes first: `{name}("{name.lower()}", ...)`')
        return self.add(name, *given, **values)

    method.__name__, method.__qualname__ = name, f"Builder.{name}"
    method.__module__ = "mbdsl.lang.builder"
    method.__doc__ = documentation(name, kind)
    vars(method)["__signature__"] = signature(kind)
    return method


class _NoMethod:
    """In the place of an inherited method: there is no attribute of its name."""

    def __get__(self, instance: object, owner: type) -> Any:
        raise AttributeError(f"{owner.__name__} has no such method")  # of instances, __getattr__ names it


def add_methods(to: type, spatial: bool = False) -> None:
    """Add the methods of all kinds, of the plane or of space, to a class."""
    for name, kind in known(spatial).items():
        setattr(to, name, _method(name, kind))
    for name in missing(spatial):
        setattr(to, name, _NoMethod())


add_methods(KindMethods)
