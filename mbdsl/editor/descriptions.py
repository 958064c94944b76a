"""Descriptions of names as Markdown: the reference of the language, and the declarations of a model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mbdsl.editor import entities as e
from mbdsl.editor.entities import Entity, OfKind
from mbdsl.editor.vocabulary import CONSTANT_DOCS, FUNCTION_DOCS, KEYWORD_DOCS
from mbdsl.elements import kinds
from mbdsl.elements.kind import Kind
from mbdsl.expressions import spatial_coordinates
from mbdsl.lang import kind_reference, modelica_names, quantities, units
from mbdsl.lang import syntax as s
from mbdsl.lang.classify import FRAME_TYPES, VALUE_TYPES
from mbdsl.lang.experiment import KEYS
from mbdsl.lang.functions import FUNCTIONS
from mbdsl.lang.states import derived
from mbdsl.lang.unparse import write
from mbdsl.mechanism import wrenches
from mbdsl.mechanism.signal_meanings import ON_PORT
from mbdsl.mechanism.signal_names import UNITS

_TYPE_DOCS = {
    "Real": "a number, with any unit",
    "Integer": "a whole number",
    "Boolean": "true or false",
    "String": "a text",
    "Table": "a function of one variable, defined by points: `Table f(table = [0 s, 0 N; 1 s, 2 N]);`",
    "AssertionLevel": "of an `assert`: `AssertionLevel.error` ends the run, `AssertionLevel.warning` lets it go on",
    **dict.fromkeys(FRAME_TYPES, "a frame fixed to a body, another name of a frame, or a connector"),
}
#: settings of frames, tables and values
SETTING_DOCS = {
    "r": "position {x, y}, in space {x, y, z}, [m] relative to the given frame",
    "phi": "angle [rad] relative to the given frame; in space about n",
    "n": "axis of the rotation by phi",
    "n_x": "direction of the x axis",
    "n_y": "direction in the xy plane, on the side of the y axis",
    "angles": "angles [rad] of successive rotations, each about an axis of the frame turned so far",
    "sequence": "axes of the angles: {1, 2, 3} for x, y, z",
    "quaternion": "quaternion of the rotation, scalar part first",
    "table": "points: rows of two values, `[0 s, 0 N; 1 s, 2 N]`; the first column must be increasing",
    "file": "file of the points, beside the model or below: CSV whose first line is `s [m], z [mm]`, or npz of a run",
    "x": "name of the first column of the file",
    "y": "name of the second column of the file",
    "smoothness": 'interpolation: "linear", "cubic" or "monotone"',
    "extrapolation": 'beyond the points: "hold", "linear", "periodic" or "error"',
    "unit": 'unit of the value: `unit = "kg"`',
    "min": "smallest allowed value",
    "max": "largest allowed value",
    "start": "value at the start",
    "fixed": "whether the start is kept exactly",
}
_EXPERIMENT_DOCS = {
    "StartTime": "start of the simulation",
    "StopTime": "end of the simulation",
    "Interval": "time between results",
    "Tolerance": "relative tolerance of error-controlled steps",
    "Method": "integration method; `mbdsl methods` lists them",
    "Step": "fixed step",
    "NumberOfIntervals": "number of intervals between results, instead of Interval",
    "Without": 'effects to leave out: `{"friction"}`',
}


def of_kind(kind: Kind) -> str:
    """The reference of a kind."""
    return kind_reference.of_kind(kind)


def of_member(kind: Kind, name: str) -> str:
    """A parameter, signal, port or frame of a kind."""
    return f"`{kind.name}.{name}`\n\n" + "\n\n".join(_meanings(kind, name))


def _meanings(kind: Kind, name: str) -> Iterator[str]:
    parameter = kind.parameter(name)
    if parameter is not None:
        unit = kind_reference.unit_of(parameter)
        default = kind_reference.default_of(parameter)
        said = [kind_reference.notes(kind, parameter)]
        said += [] if default == "-" else ["required" if default == "required" else f"default {default}"]
        yield f"Parameter{_in(unit)}: {'; '.join(filter(None, said))}"
    own = {x.name: x for x in kind.signals}
    if parameter is None or name in own:
        unit, doc = (own[name].unit, own[name].doc) if name in own else e.signals(kind).get(name, ("", ""))
        unit = unit or e.accelerations(kind).get(name, "")
        if unit:
            doc = doc or ("a result, which laws cannot use" if name in e.accelerations(kind) else "")
            yield f"Signal{_in(unit)}" + (f": {doc}" if doc else "")
    if name in kind.ports:
        yield "Frame that the component is attached to" + (" (may be left out)" if name in kind.optional_ports else "")
    elif parameter is None and name in e.BODY_FRAMES:
        yield f"Frame: {e.BODY_FRAMES[name]}"


def _in(unit: str) -> str:
    return f" [{unit}]" if unit not in ("", "1") else ""


def of_coordinate(name: str) -> str:
    """A coordinate of a frame, or a component of the wrench on a port."""
    if name in ON_PORT:
        return f"`{name}`{_in(wrenches.UNITS_IN_SPACE[name])}: {ON_PORT[name]}"
    if name in UNITS:
        return f"`{name}` of a frame in world axes{_in(UNITS[name])}"
    return f"`{name}` of a frame{_in(spatial_coordinates.UNITS[name])}: {spatial_coordinates.MEANINGS[name]}"


def of_setting(name: str) -> str:
    """A setting of a simulation, or an attribute; "" if there is none of this name."""
    if name in KEYS:
        unit = KEYS[name][1]
        return f"`{name}`{_in(unit)}: {_EXPERIMENT_DOCS.get(name, '')}"
    return f"`{name}`: {SETTING_DOCS[name]}" if name in SETTING_DOCS else ""


def of_word(word: str) -> str:
    """A keyword, kind, type, function or constant; "" for other words."""
    name = modelica_names.kind(word)
    kind = kinds().get(name) or kinds(spatial=True).get(name)
    if kind is not None:
        return of_kind(kind)
    if word in KEYWORD_DOCS:
        return f"`{word}`\n\n{KEYWORD_DOCS[word]}"
    if word in FUNCTIONS or word in FUNCTION_DOCS:
        arguments, doc = FUNCTION_DOCS.get(word, ("...", ""))
        return f"`{word}({arguments})`\n\n{doc}".rstrip()
    if word in CONSTANT_DOCS:
        return f"`{word}`\n\n{CONSTANT_DOCS[word]}"
    return of_type(word)


def of_type(name: str) -> str:
    """A type of values; "" if there is none of this name."""
    unit = quantities.type_unit(name)
    if unit is not None:
        words = quantities.words(units.dimension(unit), unit)
        return f"`{name}`\n\nType of values: {words}"
    return f"`{name}`\n\n{_TYPE_DOCS[name]}" if name in (*VALUE_TYPES[1:], *_TYPE_DOCS) else ""


def of_unit(text: str) -> str:
    """A unit: what it measures, and its value in SI units."""
    unit = units.parse(text)
    if unit is None:
        return ""
    si = "rad" if unit.dimension == units.NUMBER else quantities.unit_text(unit.dimension)
    return f"`{text}`: {quantities.words(unit.dimension, si)}\n\n1 {text} = {unit.factor:.9g} {si}"


def of_number(value: str, unit: str) -> str:
    """A number with its unit, in SI units."""
    known = units.parse(unit)
    if known is None:
        return ""
    si = "rad" if known.dimension == units.NUMBER else quantities.unit_text(known.dimension)
    return f"{value} {unit} = {float(value) * known.factor:.9g} {si}"


def of_entity(found: Entity, values: Mapping[str, str]) -> str:
    """The declaration of a member of a model, and its value if that is known."""
    d = found.declaration
    shown = [f"```mbd\n{declaration(d)}\n```"]
    if d.doc:
        shown.append(d.doc)
    if (equation := derived(found.owner.equations).get(d.name)) is not None and equation.right is not None:
        shown.append(f"State: `{write(equation.left)} = {write(equation.right)}`")
    if d.name in values:
        shown.append(f"Value: {values[d.name]}" if found.form == e.VALUE else f"Values: {values[d.name]}")
    elif found.form == e.VALUE and isinstance(d.value, s.Number):
        shown.append(f"Value: {_si(d.value)}")
    if found.kind is not None:
        shown.append(found.kind.doc)
    if found.model is not None and found.model[0].doc:
        shown.append(found.model[0].doc)
    return "\n\n".join(shown)


def _si(number: s.Number) -> str:
    if number.unit is None:
        return f"{number.value:g}"
    unit = number.unit
    si = "rad" if unit.dimension == units.NUMBER else quantities.unit_text(unit.dimension)
    return f"{number.value * unit.factor:.9g} {si}"


def declaration(d: s.Declaration) -> str:
    """A declaration without its arguments, description and condition."""
    order = ("final", "inner", "outer", "parameter", "constant", "discrete", "input", "connector")
    words = [p for p in order if p in d.prefixes] + [d.type, d.name]
    indices = f"[{', '.join(write(i) for i in d.indices)}]" if d.indices else ""
    text = " ".join(filter(None, words)) + indices
    if d.value is not None and len(value := write(d.value)) <= 80:
        text += f" = {value}"
    return text


def of_own(found: OfKind, values: Mapping[str, str]) -> str:
    """A member of a component, and the value of a parameter if that is known."""
    name = f"{found.component.declaration.name}.{found.name}" if found.component is not None else found.name
    if found.argument is not None and found.argument.value is not None:
        return f"```mbd\n{name} = {write(found.argument.value)}\n```\n\nFrame that the body declares"
    shown = [of_member(found.kind, found.name)]
    if name in values:
        shown.append(f"Value of `{name}`: {values[name]}")
    return "\n\n".join(shown)


def of_model(model: s.Model, file: str) -> str:
    """A model."""
    partial = ("spatial " if model.spatial else "") + ("partial " if model.partial else "")
    doc = f"\n\n{model.doc}" if model.doc else ""
    return f"```mbd\n{partial}model {model.name}\n```{doc}\n\n{file}"
