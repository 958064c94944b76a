"""Models built from Python, with the names, checks and Scene of a model written as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mbdsl.elements import kinds
from mbdsl.errors import ModelError, UsageError
from mbdsl.lang import python_values
from mbdsl.lang import syntax as s
from mbdsl.lang.builder.handles import Handle, Number, Place, Vector
from mbdsl.lang.builder.kind_methods import known
from mbdsl.lang.builder.named_values import NamedValues
from mbdsl.lang.calls import CallLine
from mbdsl.lang.experiment import KEYS
from mbdsl.lang.unparse import write
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import did_you_mean

_FIELDS = {field: key for key, (field, _) in KEYS.items() if field}

NOT_GIVEN: Any = object()  #: an argument that is left out, where None has a meaning


class Builder(NamedValues):
    """Collects components and makes a ``Scene`` of them.

    Every component kind of the language is a method: ``b.Rod("rod", m=1.0, length=0.5)`` is
    ``b.add("Rod", "rod", m=1.0, length=0.5)``. A value is a number in SI units, a text in the syntax of the language
    (``"30 deg"``, ``"100 N/m*(s - 0.2 m)"``), a sequence for an array, or an ``Expr`` for a force law; None stands for
    the default.

    Each method checks kinds, names and the forms of its arguments. It raises ``ModelError`` or ``UsageError`` if one of
    them is invalid, and the Builder remains as it was. Names must be declared before they are used. ``scene`` evaluates
    the values; its errors show the line that gave the value.

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
        self.name = python_values.text(name, "the name of the model")
        self.doc = python_values.text(doc, "doc")
        super().__init__()

    def add(self, kind: str, name: str, *frames: Place, doc: str = "", replace: bool = False, **values: Any) -> Handle:
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
        replace : bool, optional
            True: if there is a component of this name, it is replaced. Its joints, initial values, shapes and handles
            remain; the names in them are checked again.
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
            If there is no such kind or parameter, the name is in use, or another name is not known.
        """
        of = known(self.spatial).get(python_values.text(kind, "kind"))
        if of is None:
            where = " in space" if self.spatial else ""
            hint = did_you_mean(kind, kinds(self.spatial))
            raise ModelError(f"there is no kind of component called `{kind}`{where}", hint=hint)
        return self._declare(name, kind, of, doc, frames, values, replace)

    def frame(
        self, name: str, base: Place, r: Vector = (0.0, 0.0), phi: Number = 0.0, *, replace: bool = False
    ) -> Handle:
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
        replace : bool, optional
            True: replaces the declaration of this name, if there is one.

        Returns
        -------
        Handle
        """
        return self._declare(name, "Frame", None, "", (base,), {"r": r, "phi": phi}, replace)

    def table(
        self,
        name: str,
        table: Any,
        smoothness: str = "linear",
        extrapolation: str = "hold",
        doc: str = "",
        *,
        replace: bool = False,
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
        replace : bool, optional
            True: replaces the declaration of this name, if there is one.

        Returns
        -------
        Handle
        """
        words = {"smoothness": smoothness, "extrapolation": extrapolation}
        values = {key: s.String(python_values.text(word, f"{name}.{key}")) for key, word in words.items()}
        return self._declare(name, "Table", None, doc, (), {"table": table, **values}, replace)

    def connect(self, first: Place, second: Place) -> None:
        """Connect two ports, or a port and a frame.

        Parameters
        ----------
        first, second : Handle or str
        """
        ends = self._place(first, "connect.first"), self._place(second, "connect.second")
        self._draft.connect(s.Connect(*ends, at=(CallLine(), 0, 0)))

    def shape(self, body: Place, *parts: str, replace: bool = False) -> None:
        """Give a body shapes for pictures, instead of those that follow from its frames.

        Parameters
        ----------
        body : Handle or str
            A body or the ground.
        *parts : str
            Shapes as texts of the language, such as ``"Circle(radius = 2 cm, fillColor = \\"red\\")"``. Without parts
            the body is not drawn.
        replace : bool, optional
            True: replaces the shapes that were given before; otherwise these are added to them.

        Raises
        ------
        ModelError
            If there is no such body, or a part is not written correctly.
        """
        name = self._root(body, "shape.body")
        self._draft.draw(name, self._shapes(name, parts), python_values.flag(replace, "replace"))

    def initial(
        self,
        target: Place | None = None,
        value: Number | None = NOT_GIVEN,
        fixed: bool = True,
        *,
        replace: bool = False,
        state: str | None = None,
    ) -> None:
        """Set the initial value of a position or a velocity, or the state at the start.

        Parameters
        ----------
        target : Handle or str, optional
            A signal at position or velocity level.
        value : number or str, optional
            Number in SI units, or text. None removes the initial value.
        fixed : bool, optional
            True: the value is kept exactly. False: it is a guess, which the assembly may change.
        replace : bool, optional
            True: replaces the initial value that was given for this target, if there is one.
        state : str, optional
            In place of a target: "steady", the static equilibrium that is reached from the initial positions, which
            then are guesses; "given", the initial values, as without it.

        Raises
        ------
        ModelError, UsageError
            If the target is not known, or the arguments do not fit together.
        """
        if state is not None:
            if target is not None or value is not NOT_GIVEN:
                raise UsageError("initial(state=...) has no target and no value", hint='write initial(state="steady")')
            goal = s.Reference((s.NamePart("state"),))
            return self._start("state", goal, self._node(state, "initial(state)"), True)
        if target is None or value is NOT_GIVEN:
            raise UsageError("initial needs a target and a value", hint='e.g. b.initial(rod.phi, "30 deg")')
        goal = self._place(target, "initial.target")
        if value is None:
            return self._draft.forget_initial(goal)
        mode = "fixed" if python_values.flag(fixed, "fixed") else "guess"
        return self._start(mode, goal, self._node(value, f"initial value of {write(goal)}"), replace)

    def experiment(
        self,
        stop: Number | None = None,
        start: Number | None = None,
        interval: Number | None = None,
        tolerance: Number | None = None,
        method: str | None = None,
        step: Number | None = None,
        without: str | Sequence[str] = (),
    ) -> None:
        """Set the defaults of a simulation of the model. What is not given remains as it is.

        Parameters
        ----------
        stop, start, interval, step : number or str, optional [s]
            Stop time, start time, output interval and fixed step size.
        tolerance : number, optional
            Limit of the global error.
        method : str, optional
            Name of an integration method. ``mbdsl.simulate`` checks it.
        without : sequence of str, optional
            Effects to leave out: "friction", "damping", "flexibility", "gravity".

        Raises
        ------
        ModelError, UsageError
            If a value is not written correctly, or a name in it is not known.
        """
        given = {"stop": stop, "start": start, "interval": interval, "tolerance": tolerance, "step": step}
        nodes = {key: self._node(value, key) for key, value in given.items() if value is not None}
        if method is not None:
            nodes["method"] = s.String(python_values.text(method, "method"))
        if without:
            nodes["without"] = self._effects(without)
        at = CallLine(), 0, 0
        self._draft.set_experiment({key: s.Argument(_FIELDS[key], node, at=at) for key, node in nodes.items()})

    def remove(self, name: Place, *, dependents: bool = False) -> tuple[str, ...]:
        """Remove a component, or another declaration.

        Its initial values, shapes and connections are removed, too.

        Parameters
        ----------
        name : Handle or str
            The component, frame, parameter, variable, input or table. The name of an array stands for all elements.
        dependents : bool, optional
            True: removes whatever refers to it as well, such as the joints of a body and what refers to these.

        Returns
        -------
        tuple of str
            Names of all that was removed. Their handles are refused from now on.

        Raises
        ------
        UsageError
            If there is no such name, or if other declarations refer to it; the message names them.
        """
        return self._draft.remove(self._root(name, "remove"), python_values.flag(dependents, "dependents"))

    def scene(self, parameters: Mapping[str, Any] | None = None, without: Sequence[str] = ()) -> Scene:
        """Check the model and return its Scene.

        Parameters
        ----------
        parameters : mapping, optional
            Values that replace those of the parameters, as numbers in SI units or as texts with units:
            ``{"L": "2 m", "rod.m": 4.0}``. The Builder keeps its own.
        without : sequence of str, optional
            Effects to leave out, in addition to those of ``experiment``.

        Returns
        -------
        Scene

        Raises
        ------
        ModelError
            If the model is invalid.
        """
        return self._draft.scene(self.name, self.doc, {} if parameters is None else parameters, without)
