"""From models to components: processes declarations, sub-models, arrays and loops."""

from __future__ import annotations

from functools import partial

from mbdsl.elements import find
from mbdsl.errors import ModelError
from mbdsl.lang import instance_checks as checks
from mbdsl.lang import limits, values
from mbdsl.lang import syntax as s
from mbdsl.lang.array_entities import Make, enter
from mbdsl.lang.assertions import check as check_assertion
from mbdsl.lang.assertions import is_assertion
from mbdsl.lang.classify import attached, classify, is_frame_type, no_type, other_dimension
from mbdsl.lang.component_template import Template
from mbdsl.lang.connections import PortNode
from mbdsl.lang.entities import Disabled, Entity, Namespace, TableMember
from mbdsl.lang.evaluate import evaluate, loop
from mbdsl.lang.events import assigned
from mbdsl.lang.flat_component import FlatComponent
from mbdsl.lang.flat_model import Assembly
from mbdsl.lang.frame_declarations import declared_frame
from mbdsl.lang.inheritance import Member, ModelContent, circle, declarations, declared_names
from mbdsl.lang.inputs import refuse_other_inputs
from mbdsl.lang.instance_checks import Elements
from mbdsl.lang.library import SourceUnit
from mbdsl.lang.mistakes import doubts, equations, events
from mbdsl.lang.modifiers import Contexts, Modifier, Modifiers, bind, coordinates_named, merge, refuse_inner
from mbdsl.lang.parameters import make_slot
from mbdsl.lang.positional import Positional
from mbdsl.lang.scope import Scope, Varies
from mbdsl.lang.source import At, span_of
from mbdsl.lang.states import derived, target_of

Class = str | tuple[s.Model, SourceUnit]  #: of a declaration: see :func:`mbdsl.lang.classify.classify`


class Instance:
    """A model that is being instantiated under a name."""

    def __init__(
        self,
        assembly: Assembly,
        namespace: Namespace,
        model: s.Model,
        unit: SourceUnit,
        modifiers: Modifiers,
        chain: tuple[s.Model, ...] = (),
        at: At = None,
    ) -> None:
        assembly.budget.spend(100)  # sub-models without components have to be limited as well
        self.assembly = assembly
        self.namespace = namespace
        self.model = model
        self.modifiers = modifiers
        self.chain = (*chain, model)
        self.scope = Scope(namespace)
        self.level = len(namespace.contexts)
        if any(m is model for m in chain):
            raise ModelError(f"`{model.name}` contains itself: {circle(chain, model)}", span_of(at))
        if len(self.chain) > limits.INSTANCE_DEPTH:
            raise ModelError(f"sub-models more than {limits.INSTANCE_DEPTH} deep", span_of(at))
        self.content = ModelContent(self.scope)
        self.content.add(model, unit, {})
        self.members = self.content.members
        blocks = (m.item for m in self.members if not isinstance(m.item, s.Declaration))
        self._classes: dict[int, Class] = {}  # of declarations, by their places in the tree
        self.looped = {name for item in blocks for name in declared_names(item)}
        self._derivatives: list[tuple[s.Relation, Scope]] = []
        self._derived = derived(self.content.equations)
        self._set = assigned(self.content.equations)

    def build(self) -> None:
        """Make all entities that the model declares."""
        checks.refuse_loose_shapes(self)
        for member in self.members:
            self._announce(member)
        checks.refuse_unknown_modifiers(self)
        for member in self.members:
            if isinstance(member.item, s.Declaration) and not self._is_piece(member.item):
                self.namespace.find(member.item.name)
            else:
                self._block(member, self.scope)
        checks.refuse_unknown_elements(self)
        for item in self.content.equations:
            self._equation(item, self.scope)
        for relation, scope in self._derivatives:
            self.assembly.states.define(relation, scope)
        for item in self.content.initial:
            self._initial(item, self.scope)

    # -- names -------------------------------------------------------------------------------------------------

    def _announce(self, member: Member) -> None:
        """Register names before any entity is made, so that the order of declarations does not matter."""
        d = member.item
        if isinstance(d, s.Declaration) and not self._is_piece(d):
            self.namespace.declare(d.name, d.at)
            self.namespace.pending[d.name] = partial(self.declare, member, d, self.scope)
            return
        for d in declarations(member.item):
            if d.name in self.namespace.pending:
                self.namespace.declare(d.name, d.at)  # an error: only pieces of one array may share a name
            self.namespace.places.setdefault(d.name, d.at)

    def _is_piece(self, d: s.Declaration) -> bool:
        """Whether the indices denote one element, because a loop declares others of the same name."""
        return bool(d.indices) and d.name in self.looped

    def around(self) -> list[s.Item]:
        """Declarations and equations of the model."""
        return [*(member.item for member in self.members), *self.content.equations]

    # -- declarations ------------------------------------------------------------------------------------------

    def _block(self, member: Member, scope: Scope, item: s.Item | None = None) -> None:
        item = member.item if item is None else item
        if isinstance(item, s.Declaration):
            self.declare(member, item, scope, block=True)
        else:
            self._repeat(item, scope, lambda each, inner: self._block(member, inner, each))

    def _decide(self, condition: s.Expression, scope: Scope, choice: s.If | None = None) -> bool:
        """Whether a condition is true; it is that of ``choice``, if this is given."""
        try:
            value = evaluate(condition, scope)
        except Varies as problem:
            if choice is not None:
                problem.hint = events.varying_branches(choice)
            raise
        if isinstance(value, tuple) or not isinstance(value.value, bool):
            raise ModelError(f"a condition is true or false, found {values.describe(value)}", span_of(condition.at))
        return value.value

    def declare(self, member: Member, d: s.Declaration, scope: Scope, block: bool = False) -> None:
        """Make the entity that ``d`` declares and register it under its name."""
        given = self.modifiers.get(d.name)
        outside = member.modifiers.get(d.name)
        if outside is not None:
            given = merge({d.name: given}, {d.name: outside})[d.name] if given is not None else outside
        kind = self._classes.get(id(d))  # loops declare the same again and again
        if kind is None:
            defined = d.name in self._derived or d.name in self._set
            kind = self._classes[id(d)] = classify(d, member.unit, self.around, self.assembly.spatial, defined)
        self._check_declared(d, kind, block)
        looped = block and d.indices
        if d.condition is not None and kind != "value" and not self._decide(d.condition, scope):
            self._enter(d, looped, scope, lambda name, c, i: Disabled(name, d.at))
            return
        if kind == "value":
            slot = make_slot(
                self.assembly, self.namespace, d, scope, given, self.level, d.name in self._derived, d.name in self._set
            )
            self.namespace.members[d.name] = slot
            return
        if "outer" in d.prefixes:
            checks.refuse_changes_of_outer(d, given)
            self.namespace.members[d.name] = self._outer(d)
            return
        if d.prefixes & {"parameter", "constant"}:
            raise no_type(d, member.unit, spatial=self.assembly.spatial)
        self._declare_part(d, kind, given, scope, looped)

    def _check_declared(self, d: s.Declaration, kind: Class, block: bool) -> None:
        """Check what a declaration has besides its arguments."""
        if d.notes:
            checks.refuse_shapes(self, d, kind)
            doubts.misplaced_experiment(self.assembly.warn, d.notes, f"`{d.name}`")
        if "input" in d.prefixes:
            refuse_other_inputs(d, kind)
        if block and kind == "value":
            raise ModelError(
                "parameters cannot be declared in a loop or `if`",
                span_of(d.at),
                "declare an array: `Real k[N] = {...}`",
            )

    def _declare_part(
        self, d: s.Declaration, kind: Class, given: Modifier | None, scope: Scope, looped: object
    ) -> None:
        """Make a frame, a table, a component or a model."""
        positional, own = bind(d.arguments, scope, self.level)
        if isinstance(kind, str) and positional:
            declared = find(kind, self.assembly.spatial)
            if declared is not None and declared.coupled:
                own, positional = coordinates_named(declared, d.name, positional, own, scope, self.level), []
        modifiers = merge(given.inner, own) if given is not None and given.inner else own
        if given is not None and given.value is not None and kind != "frame":
            raise ModelError(f"`{d.name}` is a {d.type}, it has no single value", given.value_span())
        arguments = [Positional(e, scope, self.level) for e in positional]
        elements = given.elements if given is not None else {}
        if kind == "frame":
            checks.refuse_elements(d, elements)
            value = Positional(d.value, scope, self.level) if d.value is not None else None
            if given is not None and given.value is not None:
                value = Positional(given.value, given.scope, self.level)
            self._enter(
                d,
                looped,
                scope,
                lambda name, c, i: declared_frame(self.assembly, name, c, d, arguments, modifiers, value),
            )
            return
        if d.value is not None:
            raise ModelError(
                f"`{d.name}` is a {d.type}, it has no single value",
                span_of(d.value.at),
                f"give its parameters in parentheses: `{d.type} {d.name}(...)`",
            )
        if kind == "table":
            checks.check_table(d, positional, modifiers)
            checks.refuse_elements(d, elements)
            self._enter(d, looped, scope, lambda name, c, i: TableMember(self.assembly, name, modifiers, d.at))
            return
        if isinstance(kind, str):
            self._enter(d, looped, scope, self._parts(d, kind, arguments, modifiers, elements, scope))
        else:
            self._enter(d, looped, scope, self._sub_models(d, *kind, arguments, modifiers, elements))

    def _parts(
        self,
        d: s.Declaration,
        kind: str,
        arguments: list[Positional],
        modifiers: Modifiers,
        elements: Elements,
        scope: Scope,
    ):
        """The function that makes a component of a kind."""
        declared = find(kind, self.assembly.spatial)
        if declared is None:
            raise other_dimension(kind, self.assembly.spatial, d)
        template = Template(declared, modifiers)
        frames = lambda: attached(d, self.around())  # noqa: E731
        template.unknown(d.name, frames, self.assembly.passed)

        def part(name: str, contexts: Contexts, index: tuple[int, ...]) -> FlatComponent:
            own = template
            if index in elements:
                own = Template(template.kind, merge(elements[index].inner, modifiers))
                own.unknown(name, frames, self.assembly.passed)
            made = FlatComponent(self.assembly, name, own, contexts, d.at, d.doc)
            if d.notes:
                made.drawn.append((d.notes, scope))
            self.assembly.add(made, arguments)
            return made

        return part

    def _sub_models(
        self,
        d: s.Declaration,
        model: s.Model,
        unit: SourceUnit,
        arguments: list[Positional],
        modifiers: Modifiers,
        elements: Elements,
    ):
        """The function that makes a sub-model."""
        if model.spatial and not self.assembly.spatial:
            raise ModelError(
                f"`{model.name}` is a model in space, and this model is in the plane",
                span_of(d.type_at),
                "write `spatial model` at its beginning, too",
            )
        if model.partial:
            raise ModelError(
                f"`{model.name}` is partial: it can be extended, but not used as it is", span_of(d.type_at)
            )

        def sub(name: str, contexts: Contexts, index: tuple[int, ...]) -> Namespace:
            own = merge(elements[index].inner, modifiers) if index in elements else modifiers
            return self._sub(name, contexts, model, unit, own, arguments, d)

        return sub

    def _enter(self, d: s.Declaration, looped: object, scope: Scope, make: Make) -> None:
        """Make one entity, or an array of them."""
        enter(self.namespace, d, make, scope, limits.COMPONENTS - len(self.assembly.parts), bool(looped))

    # -- entities ----------------------------------------------------------------------------------------------

    def _sub(
        self,
        name: str,
        contexts: Contexts,
        model: s.Model,
        unit: SourceUnit,
        modifiers: Modifiers,
        arguments: list[Positional],
        d: s.Declaration,
    ) -> Namespace:
        namespace = Namespace(self.assembly, name, self.namespace, contexts)
        instance = Instance(self.assembly, namespace, model, unit, modifiers, self.chain, d.at)
        connectors = [
            m.item.name
            for m in instance.members
            if isinstance(m.item, s.Declaration)
            and is_frame_type(m.item.type)
            and not m.item.arguments
            and m.item.value is None
        ]
        if len(arguments) > len(connectors):
            raise ModelError(
                f"{model.name} `{name}` takes {len(connectors)} frames, found {len(arguments)}",
                span_of(arguments[len(connectors)].e.at),
                "its connectors are those declared `Frame name;`",
            )
        for c in connectors:
            if c in modifiers and modifiers[c].value is not None:
                refuse_inner(modifiers[c], f"connector `{c}` of `{name}`", f"write `{c} = ...`")
        taken = [c for c in connectors if c in modifiers and modifiers[c].value is not None]
        instance.modifiers = {k: m for k, m in modifiers.items() if k not in taken}
        instance.build()
        free = [c for c in connectors if c not in taken]
        for connector, argument in zip(free, arguments, strict=False):
            self._bind(namespace, connector, argument, contexts)
        for connector in taken:
            modifier = modifiers[connector]
            assert modifier.value is not None
            self._bind(namespace, connector, Positional(modifier.value, modifier.scope, modifier.level), contexts)
        return namespace

    def _bind(self, namespace: Namespace, connector: str, argument: Positional, contexts: Contexts) -> None:
        node = namespace.members.get(connector)
        if isinstance(node, PortNode):
            self.assembly.attach_connector(node, argument, contexts)

    def _outer(self, d: s.Declaration) -> Entity:
        above = self.namespace.parent
        while above is not None:
            found = above.find(d.name)
            if found is not None:
                return found
            above = above.parent
        raise ModelError(
            f"`{self.namespace.name or self.model.name}` expects `{d.name}` from a model around it, but there is none",
            span_of(d.at),
            f"declare it there: `{d.type} {d.name};`",
        )

    # -- equations ---------------------------------------------------------------------------------------------

    def _equation(self, item: s.Item, scope: Scope) -> None:
        if isinstance(item, s.Connect):
            doubts.misplaced_experiment(self.assembly.warn, item.notes, "the connection")
            self.assembly.connect(item.first, item.second, scope, item.at)
        elif isinstance(item, s.When):
            self.assembly.events.enter(item, scope)
        elif isinstance(item, s.Relation):
            if target_of(item) is not None:
                self._derivatives.append((item, scope))
                return
            if not is_assertion(item):
                raise checks.no_equation(item, equations.variable(item, self.around()))
            if not check_assertion(item, scope):
                self.assembly.events.watch(item, scope)
        else:
            self._check_branches(item)
            self._repeat(item, scope, self._equation)

    def _initial(self, item: s.Item, scope: Scope) -> None:
        if isinstance(item, s.Initial):
            self.assembly.initial(item, scope)
        else:
            self._check_branches(item)
            self._repeat(item, scope, self._initial)

    def _check_branches(self, item: s.Item) -> None:
        if isinstance(item, s.If) and (problem := events.if_at_start(item)) is not None:
            raise problem
        if isinstance(item, s.If) and (equation := equations.first_equation(item)) is not None:
            raise checks.no_equation(equation, equations.variable(item, self.around()), item.at)

    def _repeat(self, item: s.Item, scope: Scope, action) -> None:
        """Call ``action`` with the items of a loop, or of the first branch whose condition is true."""
        if isinstance(item, s.For):
            for inner in loop(item.iterators, scope):
                for each in item.items:
                    action(each, inner)
        elif isinstance(item, s.If):
            for condition, items in item.branches:
                if condition is None or self._decide(condition, scope, item):
                    for each in items:
                        action(each, scope)
                    break
