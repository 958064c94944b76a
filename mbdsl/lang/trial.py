"""The check of a model under construction: everything that can be evaluated so far is evaluated.

A Scene is made of a whole model only. Here each declaration is evaluated when it is added, so that a wrong value is
refused by the call that gives it. What needs a port that is not connected yet is evaluated once it is connected.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from mbdsl.errors import ModelError
from mbdsl.lang import syntax as s
from mbdsl.lang.connections import Node, NotConnected
from mbdsl.lang.draft_content import is_element
from mbdsl.lang.entities import Array, Disabled, Entity, FrameMember, Slot, TableMember
from mbdsl.lang.experiment import read_experiment
from mbdsl.lang.flat_component import Part, is_body
from mbdsl.lang.inheritance import Member
from mbdsl.lang.initial_values import InitialValues, is_steady
from mbdsl.lang.library import Unit
from mbdsl.lang.load import deep, instantiate

UNIT = Unit(s.File("<library>", (), ()), "")


class Trial:
    """A model, evaluated as far as it is known.

    After an error it may hold parts of what was refused, and is to be discarded.

    Parameters
    ----------
    model : Model
        The declarations so far.

    Raises
    ------
    ModelError
        If one of them is invalid.
    """

    def __init__(self, model: s.Model) -> None:
        with deep():
            self._instance = instantiate(model, UNIT)
            self._assembly = self._instance.assembly
            self._waiting: list[Callable[[], object]] = []
            self._fixed: set[str] = set()
            self._assembly.connect_new()
            for entity in self._instance.namespace.members.values():
                self._check(entity)
            for item in model.initial:
                if isinstance(item, s.Initial):
                    self._check_initial(item)
            read_experiment(self._instance.content.annotations, self._instance.scope)

    def part(self, name: str) -> Part:
        """The component with a full name."""
        return self._assembly.parts[name]

    def declare(self, d: s.Declaration) -> None:
        """Add a declaration; indices denote one element of an array."""
        with deep():
            namespace, instance = self._instance.namespace, self._instance
            if is_element(d):
                namespace.places.setdefault(d.name, None)
            else:
                namespace.declare(d.name, None)
            instance.declare(Member(d, UNIT, {}), d, instance.scope, is_element(d))
            self._assembly.connect_new()
            entity = namespace.members[d.name]
            if isinstance(entity, Array) and is_element(d):
                entity = entity.items[tuple(i.value for i in d.indices if isinstance(i, s.Number))]  # type: ignore[misc]
            self._check(entity)
            self._again()

    def connect(self, item: s.Connect) -> None:
        """Add a connection."""
        with deep():
            self._assembly.connect(item.first, item.second, self._instance.scope, item.at)
            self._assembly.connect_new()
            self._again()

    def initial(self, item: s.Initial) -> None:
        """Add an initial value."""
        with deep():
            self._check_initial(item)

    def draw(self, d: s.Declaration) -> None:
        """Check the shapes in the annotation of a body."""
        with deep():
            self._check_shapes(d.notes)

    def experiment(self, settings: s.Annotation) -> None:
        """Check the settings of simulations."""
        with deep():
            read_experiment([settings], self._instance.scope)

    # -- checks ------------------------------------------------------------------------------------------------

    def _check(self, entity: Entity) -> None:
        if isinstance(entity, Array):
            for item in entity.items.values():
                self._check(item)
        elif isinstance(entity, Part):
            self._check_part(entity)
        elif isinstance(entity, Slot):
            self._when_connected(entity.value)
        elif isinstance(entity, FrameMember):
            entity.target()
        elif isinstance(entity, TableMember):
            entity.made()
        else:
            assert isinstance(entity, Node | Disabled)

    def _check_part(self, part: Part) -> None:
        part.values  # noqa: B018  it raises an error if a value is wrong
        if is_body(part):
            part.frames  # noqa: B018
        for law in part.kind.law_parameters:
            self._when_connected(partial(part.law, law))
        self._when_connected(part.components)
        self._when_connected(lambda: self._fix(InitialValues([part], [], self._assembly.warn)))
        for arguments, _ in part.drawn:
            self._check_shapes(arguments)

    def _check_shapes(self, arguments: tuple[s.Argument, ...]) -> None:
        from mbdsl.lang.shapes import read_shapes

        read_shapes(arguments, self._instance.scope)

    def _check_initial(self, item: s.Initial) -> None:
        if item.mode == "state":
            is_steady(item)
            return
        self._when_connected(lambda: self._fix(InitialValues([], [(item, self._instance.scope)], self._assembly.warn)))

    def _fix(self, given: InitialValues) -> None:
        for initial in given.values():
            if initial.fixed and initial.name in self._fixed:
                raise ModelError(
                    f"the initial value of `{initial.name}` is fixed twice",
                    initial.span,
                    "to give another value instead: `initial(..., replace=True)`",
                )
            if initial.fixed:
                self._fixed.add(initial.name)

    def _when_connected(self, check: Callable[[], object]) -> None:
        try:
            check()
        except NotConnected:
            self._waiting.append(check)

    def _again(self) -> None:
        waiting, self._waiting = self._waiting, []
        for check in waiting:
            self._when_connected(check)
