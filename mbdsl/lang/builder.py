"""Models built from Python, with the names, checks and Scene of a model written as text."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from mbdsl.elements import kinds
from mbdsl.errors import ModelError, UsageError
from mbdsl.expressions.symbolic import COORDINATES, Expr
from mbdsl.lang import syntax as s
from mbdsl.lang.entities import Namespace
from mbdsl.lang.experiment import KEYS, check_effects, setting
from mbdsl.lang.flat_component import Part, is_body
from mbdsl.lang.flat_model import Assembly
from mbdsl.lang.foreign_names import KINDS as ALIASES
from mbdsl.lang.inheritance import Member
from mbdsl.lang.instantiate import Instance
from mbdsl.lang.library import Unit
from mbdsl.lang.load import deep
from mbdsl.lang.parser import parse_expression
from mbdsl.lang.unparse import indices, write, write_argument
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism.scene import Experiment, Scene
from mbdsl.messages import count, did_you_mean

#: a value: a number in SI units, a text of the language, an array, or an expression
Given = Any
_NAME = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(?:\[([0-9]+(?:, ?[0-9]+)*)\])?")


class Handle:
    """A component, frame or signal of a model under construction.

    Its attributes are its frames, ports and signals: ``rod.b``, ``rod.b.x``, ``pin.phi``. ``str()`` returns its full
    name. Handles are made by the methods of ``Builder``.

    Parameters
    ----------
    builder : Builder
        The model.
    name : str
        Full name.
    known : callable
        Returns the names of the attributes.
    """

    def __init__(self, builder: Builder, name: str, known: Callable[[], Sequence[str]]) -> None:
        self._builder, self._name, self._known = builder, name, known

    def __getattr__(self, name: str) -> Handle:
        if name.startswith("__"):
            raise AttributeError(name)
        known = self._known()
        if name not in known:
            hint = did_you_mean(name, known, "it has")
            raise AttributeError(f"`{self._name}` has no `{name}`" + (f"; {hint}" if hint else ""))
        return Handle(self._builder, f"{self._name}.{name}", lambda: COORDINATES)

    def __dir__(self) -> list[str]:
        return list(self._known())

    def __str__(self) -> str:
        return self._name

    def __repr__(self) -> str:
        return f"<{self._name} of {self._builder.name}>"


class Builder:
    """Collects components and makes a ``Scene`` of them.

    Every component kind of the language is a method: ``b.Rod("rod", m=1.0, length=0.5)`` is
    ``b.add("Rod", "rod", m=1.0, length=0.5)``. A value is a number in SI units, a text in the syntax of the language
    (``"30 deg"``, ``"100 N/m*(s - 0.2 m)"``), a sequence for an array, or an ``Expr`` for a force law. Methods raise
    ``ModelError`` or ``UsageError`` if the names or values are invalid.

    Parameters
    ----------
    name : str
        Name of the model.
    doc : str, optional
        Description, one line.

    Examples
    --------
    >>> b = Builder("Pendulum")
    >>> ground = b.Ground("ground")
    >>> rod = b.Rod("rod", m="2 kg", length="50 cm")
    >>> pin = b.Revolute("pin", ground, rod.a)
    >>> b.initial(rod.phi, "-30 deg")
    >>> b.scene().frames["rod.a"].x
    -0.25
    """

    def __init__(self, name: str, doc: str = "") -> None:
        self.name = name
        self.doc = doc
        self._assembly = Assembly()
        self._root = Namespace(self._assembly)
        self._unit = Unit(s.File("<library>", (), ()), "")
        self._instance = Instance(self._assembly, self._root, s.Model(name, doc, (), (), ()), self._unit, {})
        self._experiment: dict[str, Any] = {}
        self._declared: list[s.Declaration] = []

    def __repr__(self) -> str:
        return f"<Builder of {self.name}: {count(len(self._declared), 'declaration')}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.figures import Table
        from mbdsl.plotting.html_tables import fragment

        rows = [(d.name + indices(d.indices), _type(d), _arguments(d), d.doc) for d in self._declared]
        found = Table("", ("name", "kind", "frames and values", "description"), rows)
        return fragment(f"{self.name}: {self.doc}" if self.doc else self.name, (), [found])

    def __getattr__(self, name: str) -> Callable[..., Handle]:
        if name in kinds() or name in ALIASES:
            return partial(self.add, name)
        hint = did_you_mean(name, kinds())
        raise AttributeError(f"Builder has no `{name}`" + (f"; {hint}" if hint else ""))

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *kinds()]

    # -- declarations ------------------------------------------------------------------------------------------

    def add(self, kind: str, name: str, *frames: Handle | str, doc: str = "", **values: Given) -> Handle:
        """Add a component.

        Parameters
        ----------
        kind : str
            A component kind of the language, e.g. ``"Revolute"``.
        name : str
            Name of the component; ``"link[3]"`` makes it an element of an array.
        *frames : Handle or str
            Frames that the component is attached to, in the order of its ports; a joint stands for its two frames.
        doc : str, optional
            Description, one line.
        **values
            Parameters of the component. ``frames={"tip": (0.3, 0)}`` adds frames to a body, ``phi={"start": 0.1,
            "fixed": True}`` sets an initial value.

        Returns
        -------
        Handle
            Its attributes are the frames and signals of the component.

        Raises
        ------
        ModelError
            If there is no such kind, the name is in use, or a frame or value is invalid.
        """
        if kind not in kinds() and kind not in ALIASES:
            raise ModelError(f"there is no kind of component called `{kind}`", hint=did_you_mean(kind, kinds()))
        self._declare(name, kind, doc, [self._reference(f) for f in frames], values)
        part = self._part(name)
        return Handle(self, name, part.known_names)

    def parameter(self, name: str, value: Given, doc: str = "", type: str = "") -> Handle:
        """Declare a parameter, a named constant for use in texts.

        Parameters
        ----------
        name : str
        value : number or str
            Number in SI units, or text.
        doc : str, optional
            Description, one line.
        type : str, optional
            A quantity of the language, such as "Mass"; the unit of the value is checked against it.

        Returns
        -------
        Handle
        """
        declaration = s.Declaration(frozenset({"parameter"}), type, name, value=self._node(value, name), doc=doc)
        self._enter(declaration)
        return Handle(self, name, tuple)

    def input(self, name: str, start: Given = 0.0, unit: str = "", doc: str = "") -> Handle:
        """Declare an input, a value that the caller sets between the steps of a ``mbdsl.Simulation``.

        Parameters
        ----------
        name : str
        start : number or str, optional
            Value until the input is set.
        unit : str, optional
            Unit of the signal, such as "N.m".
        doc : str, optional
            Description, one line.

        Returns
        -------
        Handle
        """
        arguments = [s.Argument("start", self._node(start, f"{name}.start"))]
        if unit:
            arguments.append(s.Argument("unit", s.String(unit)))
        self._enter(s.Declaration(frozenset({"input"}), "Real", name, arguments=tuple(arguments), doc=doc))
        return Handle(self, name, tuple)

    def variable(self, name: str, value: Given, doc: str = "") -> Handle:
        """Declare a variable, a named expression of time and signals; it becomes a signal of the model.

        Parameters
        ----------
        name : str
        value : str, number or Expr
            The expression.
        doc : str, optional
            Description, one line.

        Returns
        -------
        Handle
        """
        self._enter(s.Declaration(frozenset(), "Real", name, value=self._node(value, name), doc=doc))
        return Handle(self, name, tuple)

    def frame(self, name: str, base: Handle | str, r: Given = (0.0, 0.0), phi: Given = 0.0) -> Handle:
        """Add a frame that is fixed to a body.

        Parameters
        ----------
        name : str
        base : Handle or str
            A body or a frame of a body.
        r : (2,) [m], optional
            Position of the origin, in the axes of ``base``.
        phi : number or str, optional [rad]
            Angle relative to ``base``.

        Returns
        -------
        Handle
        """
        self._declare(name, "Frame", "", [self._reference(base)], {"r": r, "phi": phi})
        return Handle(self, name, lambda: COORDINATES)

    def table(
        self, name: str, table: Given, smoothness: str = "linear", extrapolation: str = "hold", doc: str = ""
    ) -> Handle:
        """Declare a function of one variable by its points.

        Parameters
        ----------
        name : str
        table : sequence of (number, number), or str
            Points (u, y), in SI units or as a text ``"[0 s, 0 N; 1 s, 2 N]"``.
        smoothness : {"linear", "cubic", "monotone"}, optional
            Interpolation: piecewise linear, twice continuously differentiable spline, or shape-preserving cubic.
        extrapolation : {"hold", "linear", "periodic", "error"}, optional
        doc : str, optional
            Description, one line.

        Returns
        -------
        Handle
        """
        values = {"table": table, "smoothness": s.String(smoothness), "extrapolation": s.String(extrapolation)}
        self._declare(name, "Table", doc, [], values)
        return Handle(self, name, tuple)

    def connect(self, first: Handle | str, second: Handle | str) -> None:
        """Connect two ports, or a port and a frame.

        Parameters
        ----------
        first, second : Handle or str
        """
        self._assembly.connect(self._reference(first), self._reference(second), self._instance.scope, None)

    def shape(self, body: Handle | str, *parts: str) -> None:
        """Give a body shapes for pictures, instead of those that follow from its frames.

        Parameters
        ----------
        body : Handle or str
            A body or the ground.
        *parts : str
            Shapes as texts of the language, such as ``"Circle(radius = 2 cm, fillColor = \\"red\\")"``. Without parts
            the body is not drawn.

        Raises
        ------
        ModelError
            If there is no such body. An invalid part raises it in ``scene``.
        """
        name = self._name(body)
        part = self._assembly.parts.get(name.replace(" ", ""))
        if part is None or not is_body(part):
            raise ModelError(f"`{name}` is not a body", hint=did_you_mean(name, self._assembly.parts))
        graphics = s.Array(tuple(parse_expression(text, f"<shape of {name}>") for text in parts))
        whole = s.Argument("Shape", None, (s.Argument("graphics", graphics),))
        part.drawn.append(((whole,), self._instance.scope))

    def initial(self, target: Handle | str, value: Given, fixed: bool = True) -> None:
        """Set the initial value of a position or a velocity.

        Parameters
        ----------
        target : Handle or str
            A signal at position or velocity level.
        value : number or str
            Number in SI units, or text.
        fixed : bool, optional
            True: the value is kept exactly. False: it is a guess, which the assembly may change.
        """
        mode = "fixed" if fixed else "guess"
        item = s.Initial(mode, parse_expression(self._name(target), "<initial>"), self._node(value, str(target)))
        self._assembly.initial(item, self._instance.scope)

    def experiment(
        self,
        stop: Given = None,
        start: Given = None,
        interval: Given = None,
        tolerance: Given = None,
        method: str | None = None,
        step: Given = None,
        without: Sequence[str] = (),
    ) -> None:
        """Set the defaults of a simulation of the model.

        Parameters
        ----------
        stop, start, interval, step : number or str, optional [s]
            Stop time, start time, output interval and fixed step size.
        tolerance : number, optional
            Limit of the global error.
        method : str, optional
            Name of an integration method.
        without : sequence of str, optional
            Effects to leave out: "friction", "damping", "flexibility", "gravity".
        """
        given = {"stop": stop, "start": start, "interval": interval, "tolerance": tolerance, "step": step}
        for key, (field, unit) in KEYS.items():
            if given.get(field) is not None:
                self._experiment[field] = setting(key, field, unit, self._value(given[field], key))
        if method is not None:
            self._experiment["method"] = method
        if without:
            self._experiment["without"] = check_effects(without)

    def scene(self) -> Scene:
        """Check the model and return its Scene.

        Returns
        -------
        Scene

        Raises
        ------
        ModelError
            If the model is invalid.
        """
        with deep():
            return self._assembly.scene(self._root, self.name, self.doc, Experiment(**self._experiment))

    # -- conversion to syntax ----------------------------------------------------------------------------------

    def _declare(
        self, name: str, type_name: str, doc: str, frames: list[s.Expression], values: Mapping[str, Given]
    ) -> None:
        match = _NAME.fullmatch(name)
        if match is None:
            raise UsageError(f"{name!r} is no name", hint="a name is made of letters a-z, digits and `_`")
        indices = tuple(s.Number(int(i)) for i in match.group(2).split(",")) if match.group(2) else ()
        kind = kinds().get(type_name)
        for key, value in values.items():
            parameter = kind.parameter(key) if kind is not None else None
            if parameter is not None and value in parameter.choices:  # a choice is a text, not an expression
                values = {**values, key: f'"{value}"'}
        arguments = [s.Argument("", frame) for frame in frames]
        arguments += [self._argument(key, value, name) for key, value in values.items() if value is not None]
        self._enter(s.Declaration(frozenset(), type_name, match.group(1), indices, tuple(arguments), doc=doc))

    def _enter(self, d: s.Declaration) -> None:
        with deep():
            if not d.indices:
                self._root.declare(d.name, None)
            else:
                self._root.places[d.name] = None
            try:
                self._instance.declare(Member(d, self._unit, {}), d, self._instance.scope, bool(d.indices))
                self._declared.append(d)
            except ModelError:
                if not d.indices:
                    del self._root.places[d.name]
                raise

    def _part(self, name: str) -> Part:
        return self._assembly.parts[name.replace(" ", "")]

    def _value(self, given: Given, what: str) -> Value:
        from mbdsl.lang.evaluate import evaluate

        return evaluate(self._node(given, what), self._instance.scope)

    def _name(self, given: Handle | str) -> str:
        """The name of a handle; handles of another Builder are refused, as their names may denote other components."""
        if isinstance(given, Handle) and given._builder is not self:
            raise UsageError(
                f"`{given}` belongs to another Builder, of {given._builder.name}, and not to this one, of {self.name}",
                hint=f"use a handle from this Builder, or give the name as a string: {str(given)!r}",
            )
        return str(given)

    def _reference(self, frame: Handle | str) -> s.Expression:
        if not isinstance(frame, Handle | str):
            raise UsageError(f"found {frame!r}, expected a frame", hint="frames are attributes of components: `rod.b`")
        return parse_expression(self._name(frame), "<frame>")

    def _argument(self, name: str, value: Given, owner: str) -> s.Argument:
        if isinstance(value, Mapping):
            inner = tuple(self._argument(k, v, f"{owner}.{name}") for k, v in value.items())
            return s.Argument(name, None, inner)
        return s.Argument(name, self._node(value, f"{owner}.{name}"))

    def _node(self, value: Given, what: str) -> s.Expression:
        """The syntax tree of a value from Python."""
        if isinstance(value, s.Expression):
            return value
        if isinstance(value, str | Handle):
            return parse_expression(self._name(value), f"<{what}>")
        if isinstance(value, Expr):
            return s.Literal(Quantity(value))
        if hasattr(value, "tolist"):  # numpy's scalars and arrays
            value = value.tolist()
        if isinstance(value, bool):
            return s.Boolean(value)
        if isinstance(value, int | float):
            return s.Number(value)
        if isinstance(value, Sequence):
            return s.Array(tuple(self._node(v, what) for v in value))
        raise UsageError(f"`{what}`: found {value!r}, expected a number, a text or a sequence")


def _type(d: s.Declaration) -> str:
    return " ".join([*sorted(d.prefixes), d.type] if d.type else sorted(d.prefixes))


def _arguments(d: s.Declaration) -> str:
    """The frames and values of a declaration, as in a text."""
    given = [write_argument(a) for a in d.arguments] + ([f"= {write(d.value)}"] if d.value is not None else [])
    return ", ".join(given)
