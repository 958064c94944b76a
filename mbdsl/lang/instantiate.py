"""From models to components: processes declarations, sub-models, arrays and loops."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from math import prod

from mbdsl.elements import find
from mbdsl.elements.kind import BodyKind
from mbdsl.errors import ModelError
from mbdsl.lang import functions, limits, orientations, values
from mbdsl.lang import syntax as s
from mbdsl.lang.assertions import check as check_assertion
from mbdsl.lang.assertions import is_assertion
from mbdsl.lang.classify import attached, classify, is_frame_type, no_type, other_dimension
from mbdsl.lang.connections import PortNode
from mbdsl.lang.entities import TABLE_ARGUMENTS, ComponentArray, Disabled, Entity, FrameMember, Namespace, TableMember
from mbdsl.lang.evaluate import evaluate, loop, place
from mbdsl.lang.flat_component import FlatComponent, Template
from mbdsl.lang.flat_model import Assembly, Positional
from mbdsl.lang.frame_declarations import alias, fixed_frame
from mbdsl.lang.inheritance import Member, ModelContent, circle, declarations, declared_names
from mbdsl.lang.inputs import refuse_other_inputs
from mbdsl.lang.library import SourceUnit
from mbdsl.lang.mistakes import doubts, equations
from mbdsl.lang.modifiers import Contexts, Modifier, Modifiers, bind, coordinates_named, merge, refuse_inner
from mbdsl.lang.parameters import make_slot
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import At, span_of
from mbdsl.lang.unparse import write
from mbdsl.messages import did_you_mean

#: index of an element of an array -> its modifier
Elements = Mapping[tuple[int, ...], Modifier]


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
        self._classes: dict[int, str | tuple[s.Model, SourceUnit]] = {}  # of declarations, by their places in the tree
        self.looped = {name for item in blocks for name in declared_names(item)}

    def build(self) -> None:
        """Make all entities that the model declares."""
        self._refuse_loose_shapes()
        for member in self.members:
            self._announce(member)
        self._refuse_unknown_modifiers()
        for member in self.members:
            if isinstance(member.item, s.Declaration) and not self._is_piece(member.item):
                self.namespace.find(member.item.name)
            else:
                self._block(member, self.scope)
        self._refuse_unknown_elements()
        for item in self.content.equations:
            self._equation(item, self.scope)
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

    def _refuse_unknown_modifiers(self) -> None:
        for name, modifier in self.modifiers.items():
            if name not in self.namespace.places:
                owner = self.namespace.name or self.model.name
                hint = did_you_mean(name, self.namespace.places, f"{self.model.name} has")
                raise ModelError(f"`{owner}` has no `{name}`", span_of(modifier.at), hint)

    def _refuse_unknown_elements(self) -> None:
        for name, modifier in self.modifiers.items():
            items = getattr(self.namespace.members.get(name), "items", {})
            for index in modifier.elements:
                if index not in items:
                    shown = f"{name}[{', '.join(map(str, index))}]"
                    raise ModelError(f"there is no `{shown}` to modify", span_of(modifier.at))

    def _around(self) -> list[s.Item]:
        """Declarations and equations of the model."""
        return [*(member.item for member in self.members), *self.content.equations]

    # -- declarations ------------------------------------------------------------------------------------------

    def _block(self, member: Member, scope: Scope, item: s.Item | None = None) -> None:
        item = member.item if item is None else item
        if isinstance(item, s.For):
            for inner in loop(item.iterators, scope):
                for each in item.items:
                    self._block(member, inner, each)
        elif isinstance(item, s.If):
            for condition, items in item.branches:
                if condition is None or self._decide(condition, scope):
                    for each in items:
                        self._block(member, scope, each)
                    break
        elif isinstance(item, s.Declaration):
            self.declare(member, item, scope, block=True)

    def _decide(self, condition: s.Expression, scope: Scope) -> bool:
        value = evaluate(condition, scope)
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
            kind = self._classes[id(d)] = classify(d, member.unit, self._around, self.assembly.spatial)
        if d.notes:
            self._refuse_shapes(d, kind)
            doubts.misplaced_experiment(self.assembly.warn, d.notes, f"`{d.name}`")
        if "input" in d.prefixes:
            refuse_other_inputs(d, kind)
        looped = block and d.indices
        if block and kind == "value":
            raise ModelError(
                "parameters cannot be declared in a loop or `if`",
                span_of(d.at),
                "declare an array: `Real k[N] = {...}`",
            )
        if d.condition is not None and kind != "value" and not self._decide(d.condition, scope):
            self._enter(d, looped, scope, lambda name, c, i: Disabled(name, d.at))
            return
        if kind == "value":
            slot = make_slot(self.assembly, self.namespace, d, scope, given, self.level)
            self.namespace.members[d.name] = slot
            return
        if "outer" in d.prefixes:
            self._refuse_changes_of_outer(d, given)
            self.namespace.members[d.name] = self._outer(d)
            return
        if d.prefixes & {"parameter", "constant"}:
            raise no_type(d, member.unit, spatial=self.assembly.spatial)
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
            self._refuse_elements(d, elements)
            value = given.value if given is not None and given.value is not None else d.value
            where = given.scope if given is not None and given.value is not None else scope
            self._enter(
                d, looped, scope, lambda name, c, i: self._frame(name, c, d, arguments, modifiers, value, where)
            )
            return
        if d.value is not None:
            raise ModelError(
                f"`{d.name}` is a {d.type}, it has no single value",
                span_of(d.value.at),
                f"give its parameters in parentheses: `{d.type} {d.name}(...)`",
            )
        if kind == "table":
            self._check_table(d, positional, modifiers)
            self._refuse_elements(d, elements)
            self._enter(d, looped, scope, lambda name, c, i: TableMember(self.assembly, name, modifiers, d.at))
            return
        if isinstance(kind, str):
            self._enter(d, looped, scope, self._parts(d, kind, arguments, modifiers, elements, scope))
        else:
            self._enter(d, looped, scope, self._sub_models(d, *kind, arguments, modifiers, elements))

    def _check_table(self, d: s.Declaration, positional: Sequence[s.Expression], modifiers: Modifiers) -> None:
        if positional:
            raise ModelError("a Table takes `table = [...]`, or `file = ...`", span_of(positional[0].at))
        for name, modifier in modifiers.items():
            if name not in TABLE_ARGUMENTS:
                hint = did_you_mean(name, TABLE_ARGUMENTS, "a Table has")
                raise ModelError(f"a Table has no `{name}`", span_of(modifier.at), hint)
            refuse_inner(modifier, f"`{name}` of Table `{d.name}`", f"write `{name} = ...`")

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
        frames = lambda: attached(d, self._around())  # noqa: E731
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

    def _refuse_shapes(self, d: s.Declaration, kind: object) -> None:
        """Refuse a Shape of anything except a body or the ground at its declaration."""
        from mbdsl.lang.shapes import ICON, shapes_among

        known = find(kind, self.assembly.spatial) if isinstance(kind, str) else None
        if isinstance(known, BodyKind) and "outer" not in d.prefixes:
            return
        for shape in shapes_among(d.notes):
            if shape.name != ICON:
                what = "is declared in an enclosing model" if "outer" in d.prefixes else "is not a body"
                hint = "give it to a body or to the ground, after its declaration"
                raise ModelError(f"`{d.name}` {what}; a Shape belongs to a body", span_of(shape.at), hint)

    def _refuse_loose_shapes(self) -> None:
        """Refuse a Shape in the annotation of a model; its Icon is for diagrams and is ignored."""
        for annotation in self.content.annotations:
            for a in annotation.arguments:
                function = a.value.function if isinstance(a.value, s.Call) else None
                if "Shape" in (a.name, write(function)):
                    hint = "write it after the declaration of the body: `Rod rod(...) annotation(Shape(...));`"
                    raise ModelError("a Shape belongs to a body, not to a model", span_of(a.at), hint)

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

    def _enter(self, d: s.Declaration, looped: object, scope: Scope, make) -> None:
        """Make one entity or an array of them; in a loop the indices denote the element."""
        namespace, full = self.namespace, self.namespace.full(d.name)
        if looped:
            index = tuple(self._index(i, scope) for i in d.indices)
            array = namespace.members.get(d.name)
            if array is None:
                array = namespace.members[d.name] = ComponentArray(full, len(index), d.at)
            name = f"{full}[{','.join(map(str, index))}]"
            if not isinstance(array, ComponentArray) or len(array.sizes) != len(index) or index in array.items:
                what = (
                    "is declared twice"
                    if isinstance(array, ComponentArray) and index in array.items
                    else "is already declared"
                )
                raise ModelError(f"`{name}` {what}", span_of(d.at))
            array.add(index, make(name, namespace.contexts, index))
            return
        if not d.indices:
            if d.name in namespace.members:
                raise ModelError(
                    f"`{full}` is declared twice", span_of(d.at), "in a loop, components have indices: `J[i]`"
                )
            namespace.members[d.name] = make(full, namespace.contexts, ())
            return
        sizes = [self._index(i, scope, "the size of an array", 0) for i in d.indices]
        count = prod(sizes)
        if count > limits.COMPONENTS - len(self.assembly.parts):
            raise ModelError(
                f"`{full}` has {count} elements, but a model has at most {limits.COMPONENTS} components", span_of(d.at)
            )
        array = namespace.members[d.name] = ComponentArray(full, len(sizes), d.at)
        array.sizes = tuple(sizes)
        for index in _indices(sizes):
            contexts = (*namespace.contexts, *((i - 1, size) for i, size in zip(index, sizes, strict=True)))
            array.items[index] = make(f"{full}[{','.join(map(str, index))}]", contexts, index)

    def _index(self, e: s.Expression, scope: Scope, what: str = "an index", least: int = 1) -> int:
        if isinstance(e, s.Everything):
            raise ModelError("the size of an array of components must be given", span_of(e.at))
        try:
            n = functions.count(evaluate(e, scope), what)
            if n < least:
                raise ModelError(f"{what} is {n}, it must be at least {least}")
        except ModelError as problem:
            raise place(problem, e.at) from None
        return n

    # -- entities ----------------------------------------------------------------------------------------------

    def _frame(
        self,
        name: str,
        contexts: Contexts,
        d: s.Declaration,
        arguments: list[Positional],
        modifiers: Modifiers,
        value: s.Expression | None,
        scope: Scope,
    ) -> PortNode | FrameMember:
        if value is not None:
            if arguments or modifiers:
                where = arguments[0].e.at if arguments else next(iter(modifiers.values())).at
                raise ModelError(
                    f"`{name}` is an alias of `{write(value)}` and takes no arguments",
                    span_of(where),
                    f"write a frame with another pose as `Frame {d.name}({write(value)}, r = {{x, y}});`",
                )
            member = FrameMember(
                self.assembly, name, lambda: alias(Positional(value, scope, self.level), contexts), d.at
            )
            self.assembly.frames.append(member)
            return member
        if not arguments:
            if modifiers:
                first = next(iter(modifiers.values()))
                raise ModelError(
                    f"`{name}` is a connector, it has no parameters",
                    span_of(first.at),
                    f"a frame fixed to a body names it first: `Frame {d.name}(ground, r = {{x, y}});`",
                )
            node = PortNode(name, d.at)
            self.assembly.frames.append(node)
            return node
        if len(arguments) > 1:
            raise ModelError("a Frame is fixed to one body or frame", span_of(arguments[1].e.at))
        known = tuple(orientations.PARAMETERS) if self.assembly.spatial else ("r", "phi")
        for key, modifier in modifiers.items():
            if key not in known:
                hint = did_you_mean(key, known, "a Frame has")
                if key in orientations.PARAMETERS:
                    hint = "in a planar model a Frame has `r` and `phi`; models in space begin with `spatial model`"
                raise ModelError(f"a Frame has no `{key}`", span_of(modifier.at), hint)
            refuse_inner(modifier, f"`{key}` of Frame `{name}`", f"write `{key} = ...`")
        make = lambda: fixed_frame(name, arguments[0], modifiers, contexts, d.at)  # noqa: E731
        member = FrameMember(self.assembly, name, make, d.at, lambda: arguments[0].find(contexts))
        self.assembly.frames.append(member)
        return member

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

    def _refuse_elements(self, d: s.Declaration, elements: Elements) -> None:
        """Single elements of an array can be modified if they are components or sub-models."""
        for index, modifier in elements.items():
            shown = f"{d.name}[{', '.join(map(str, index))}]"
            raise ModelError(f"`{shown}` cannot be modified alone", span_of(modifier.at), f"modify all of `{d.name}`")

    def _refuse_changes_of_outer(self, d: s.Declaration, given: Modifier | None) -> None:
        """Refuse changes of an outer component, whose values are given where it is declared."""
        where = d.arguments[0].at if d.arguments else d.value.at if d.value is not None else None
        if given is not None:
            where = given.at
        elif not (d.arguments or d.value is not None or d.indices):
            return
        raise ModelError(
            f"`{d.name}` is declared in a model around this one and cannot be changed here",
            span_of(where or d.at),
            f"write `outer {d.type} {d.name};`, and give it its values where it is declared",
        )

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
        elif isinstance(item, s.Relation):
            if not is_assertion(item):
                raise _no_equation(item, equations.variable(item, self._around()))
            check_assertion(item, scope)
        else:
            self._repeat(item, scope, self._equation)

    def _initial(self, item: s.Item, scope: Scope) -> None:
        if isinstance(item, s.Initial):
            self.assembly.initial(item, scope)
        else:
            self._repeat(item, scope, self._initial)

    def _repeat(self, item: s.Item, scope: Scope, action) -> None:
        if isinstance(item, s.For):
            for inner in loop(item.iterators, scope):
                for each in item.items:
                    action(each, inner)
        elif isinstance(item, s.If):
            if (equation := equations.first_equation(item)) is not None:
                raise _no_equation(equation, equations.variable(item, self._around()), item.at)
            for condition, items in item.branches:
                if condition is None or self._decide(condition, scope):
                    for each in items:
                        action(each, scope)
                    break


def _indices(sizes: Iterable[int]) -> Iterator[tuple[int, ...]]:
    first, *rest = sizes
    for i in range(1, first + 1):
        if rest:
            for inner in _indices(rest):
                yield (i, *inner)
        else:
            yield (i,)


def _no_equation(item: s.Relation, remedy: str | None, at: At = None) -> ModelError:
    if item.right is None:
        return ModelError(
            f"found `{write(item.left)}`, expected `connect(a, b);`",
            span_of(item.left.at),
        )
    return ModelError(
        "mbdsl has no free equations: the equation section holds `connect(a, b);`",
        span_of(at or item.left.at),
        f"give a variable its value where it is declared, `{remedy or 'Real F = 2 N*sin(3*time);'}`; "
        "initial values go under `initial equation`",
    )
