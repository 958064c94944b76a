"""Signals of a component: formulas of its kind over the frames that it is attached to."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any

from mbdsl.elements import find
from mbdsl.elements.declaration import Touch
from mbdsl.elements.kind import JointKind, Kind
from mbdsl.expressions import formulas
from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.symbolic import Expr, const, expr, input_signal, is_const, multiplier, substitute
from mbdsl.mechanism import contacts, sticking
from mbdsl.mechanism.sticking import Sticking

#: signals of a rigid contact in formulas of a component that consists of several
OF_CONTACTS = ("force", "friction", "active", "impacts", "impulse", "sliding")
_WORD = re.compile(r"[A-Za-z_]\w*").findall


class ComponentFormulas:
    """The formulas of one component; every signal is evaluated once.

    In a force, a law replaces the signal of its name (``force``). In a joint, a law prescribes the measured signal
    (``phi`` of a driver), and both exist.

    Parameters
    ----------
    kind : Kind
        The kind of the component.
    name : str
        Its full name.
    value : callable
        Name of a parameter -> its value: a number in SI, a tuple of them, or an expression; None if it is not given.
    coordinate : callable
        (Port, or "c" for the body's own frame; key) -> the coordinate as an expression.
    """

    __slots__ = ("_contacts", "_found", "_sticking", "coordinate", "given", "kind", "name")

    def __init__(
        self,
        kind: Kind,
        name: str,
        value: Callable[[str], Any],
        coordinate: Callable[[str, str], Expr],
    ) -> None:
        self.kind, self.name, self.given, self.coordinate = kind, name, value, coordinate
        self._found: dict[str, Expr] = {}
        self._sticking: Sticking | None = None
        self._contacts: dict[int, ComponentFormulas] | None = None

    def signal(self, name: str) -> Expr:
        """One signal.

        Parameters
        ----------
        name : str
            Its name, without that of the component.

        Raises
        ------
        KeyError
            If the kind has no such signal.
        """
        found = self._found.get(name)
        if found is None:
            formula = self.kind.formulas.get(name, self.kind.terms.get(name))
            if name == "friction" and self.sticks:
                found = self._found[name] = self.resistance() + sticking.size(self.sticking.grips)
                return found
            law = None if formula is not None and isinstance(self.kind, JointKind) else self.law(name)
            if law is None and formula is None:
                raise KeyError(name)
            if law is None:
                law = formulas.evaluate(formula, self) if formula else self._reaction(name)
            found = self._found[name] = law
        return found

    def _reaction(self, name: str) -> Expr:
        """A reaction of a joint that follows from its rows."""
        from mbdsl.elements import row_derivatives

        def own(leaf: Expr) -> Expr | None:
            if leaf.op == "coordinate":
                return self.coordinate(*leaf.value)
            if leaf.op == "multiplier":
                return multiplier(self.name, leaf.value[1])
            if leaf.op == "input":
                name, _, index = str(leaf.value).partition("[")
                return expr(self.element(name, int(index[:-1])) if index else self.value(name))
            return None

        assert isinstance(self.kind, JointKind)
        return substitute(row_derivatives.reactions(self.kind)[name], own)

    @property
    def _multipliers(self) -> int | float:
        """How many multipliers it has, of a contact in space, whose slip may have one direction."""
        if not getattr(self.kind, "unilateral", False):
            return math.inf
        return 1 + sum(self.law(name) is not None for name in ("slip", "slip_2"))

    def row(self, formula: str) -> Expr:
        """One of the kind's ``relations`` or ``velocity_rows``; a name of both a law and a signal denotes the law."""
        return formulas.evaluate(formula, _LawsFirst(self))

    @property
    def sticks(self) -> bool:
        """Whether it is a joint whose friction sticks."""
        return self.kind.parameter("sticks") is not None and bool(self.given("sticks") and self.given("mu_s"))

    def resistance(self) -> Expr:
        """The friction of a joint as a force; that of one that sticks while it slides."""
        if not self.sticks:
            return self.signal("friction")
        assert isinstance(self.kind, JointKind)
        sense = input_signal(sticking.number(self.name, sticking.SLIDING))
        return sense * formulas.evaluate(f"mu*({self.kind.normal})", self)

    @property
    def sticking(self) -> Sticking:
        """What events need of a joint whose friction sticks."""
        if self._sticking is None:
            self._sticking = self._holding()
        return self._sticking

    def share(self, joints: Iterable[Sticking]) -> None:
        """Let the friction be that of this joint among ``joints``, which may hold the same motion."""
        self._sticking = next((x for x in joints if x.name == self.name), self.sticking)

    def _holding(self) -> Sticking:
        kind = self.kind
        assert isinstance(kind, JointKind)
        normal = expr(formulas.evaluate(kind.normal, self))
        rates = [formulas.evaluate(x, self) for x in kind.slides]
        used = [k for k, rate in enumerate(rates) if not is_const(rate, 0.0)]  # all but of shafts without a radius
        holds = kind.holds or [f"{kind.places[k]} - place[{k + 1}]" for k in used]
        return Sticking(
            self.name,
            float(self.given("mu_s")),
            tuple(rates[k] for k in used),
            tuple(formulas.evaluate(x, self) for x in (kind.places if kind.holds else [kind.places[k] for k in used])),
            tuple(formulas.evaluate(x, self) for x in holds),
            tuple(formulas.evaluate(x, self) for x in kind.grips or [f"grip[{i + 1}]" for i in range(len(used))]),
            normal,
        )

    def friction_rows(self) -> tuple[Expr, ...]:
        """The joint's ``friction_rows``, while it slides."""
        assert isinstance(self.kind, JointKind)
        if not self.kind.friction_rows:
            return ()
        names = _Sliding(self) if self.sticks else self
        return tuple(names.drag(k) for k in range(len(self.kind.friction_rows)))

    @property
    def contacts(self) -> dict[int, ComponentFormulas]:
        """The rigid contacts that it consists of, by their numbers in formulas."""
        if self._contacts is None:
            touching = enumerate(self.kind.contacts, 1)
            there = {i: x for i, x in touching if not x.limit or self.given(x.limit) is not None}
            self._contacts = {i: self._contact(x) for i, x in there.items()}
        return self._contacts

    def _contact(self, touch: Touch) -> ComponentFormulas:
        kind = find("Contact", self.kind.spatial)
        assert kind is not None
        own = {x: self.given(x) if self.kind.parameter(x) is not None else 0.0 for x in ("mu", "mu_s")}
        own |= {x: self.given(x) for x in ("e", "impacts")} | {"gap": formulas.evaluate(touch.gap, self)}
        own["aim"] = tuple(expr(formulas.evaluate(x, self)) for x in touch.aim)
        if own["mu_s"]:
            own |= {x: formulas.evaluate(y, self) for x, y in zip(("slip", "slip_2"), touch.slips, strict=False)}
        return ComponentFormulas(kind, f"{self.name}.{touch.key}", own.get, self.coordinate)

    def drag(self, k: int, names: formulas.FormulaNames | None = None) -> Expr:
        """The k-th of the joint's ``friction_rows``, from 0, with the friction of one that is held."""
        assert isinstance(self.kind, JointKind)
        rows = self.kind.friction_rows
        if self.sticks:
            rows = self.kind.sticking_rows or [f"rub[{i + 1}]" for i in range(len(rows))]
        return formulas.evaluate(rows[k], names or self)

    def rub(self, k: int) -> Expr:
        """Friction that sticks along the k-th rate of sliding, from 0, while the joint slides."""
        own = self.sticking
        return sticking.direction(own)[k] * self.resistance() if k < len(own.rates) else const(0.0)

    def energy(self) -> Expr:
        """The potential energy of a kind that has a formula for it."""
        return formulas.evaluate(self.kind.energy, self)

    def aligned(self) -> Expr:
        """The joint's ``aligned``, of a kind that has it."""
        assert isinstance(self.kind, JointKind)
        return formulas.evaluate(self.kind.placing.aligned, self)

    def law(self, name: str) -> Expr | None:
        """The law given for the parameter ``name``; None if none is given, or if this is not a law parameter."""
        known = name in self.kind.law_parameters or name in self.kind.computed
        given = self.given(name) if known else None
        return None if given is None else expr(given)

    # -- names in formulas -------------------------------------------------------------------------------------

    def value(self, name: str) -> Expr | float:
        parameter = self.kind.parameter(name)
        return self.signal(name) if parameter is None or parameter.law else self.given(name)

    def element(self, name: str, index: int) -> Expr | float:
        if name in OF_CONTACTS and self.kind.contacts:
            return self.contacts[index].signal(name) if index in self.contacts else 0.0
        if name == "lam":
            return multiplier(self.name, index - 1) if index <= self._multipliers else 0.0
        if name == "carried":  # of a rigid contact
            if self._multipliers == 1:
                return -multiplier(self.name, 0)
            return contacts.carried(self.name, index - 1) if index <= self._multipliers else 0.0
        if name == "grip":
            return multiplier(sticking.row_name(self.name, index - 1), 0)
        if name == "place":
            return input_signal(sticking.number(self.name, f"place[{index}]"))
        if name == "drag":
            return self.drag(index - 1)
        if name == "rub":
            grips = self.sticking.grips
            return self.rub(index - 1) + (grips[index - 1] if index <= len(grips) else 0.0)
        if name == "number":  # of a rigid contact, or of a joint that sticks
            of = contacts if isinstance(self.kind, JointKind) and self.kind.unilateral else sticking
            return input_signal(of.number(self.name, of.NUMBERS[index - 1]))
        if name == "slope" and isinstance(self.kind, JointKind):
            law, argument = [(f, x) for f, signals in self.kind.functions for x in signals][index - 1]
            return diff(expr(self.given(law)), self.signal(argument))[0]
        found = self.given(name)[index - 1]
        return input_signal(f"{self.name}.{name}[{index}]") if found is None else found

    def latches(self) -> Iterator[tuple[str, Expr, Expr]]:
        """Of each number that an event sets: its name, the condition, and its value then."""
        for latch in self.kind.latches:
            name, _, index = latch.target.rstrip("]").partition("[")
            if self.given(name)[int(index) - 1] is None:
                condition, value = (formulas.evaluate(x, self) for x in latch[1:])
                yield f"{self.name}.{latch.target}", condition, value


class _Sliding:
    """The names of a joint that sticks, while it slides."""

    def __init__(self, others: ComponentFormulas) -> None:
        self.others, self.value, self.coordinate = others, others.value, others.coordinate

    def element(self, name: str, index: int) -> Expr | float:
        return self.others.rub(index - 1) if name == "rub" else self.others.element(name, index)

    def drag(self, k: int) -> Expr:
        return self.others.drag(k, self)


class _LawsFirst:
    def __init__(self, others: ComponentFormulas) -> None:
        self.others, self.element, self.coordinate = others, others.element, others.coordinate

    def value(self, name: str) -> Expr | float:
        law = self.others.law(name)
        return self.others.value(name) if law is None else law


def names(kind: Kind, given: Iterable[str], friction: bool, sticks: bool = False) -> tuple[str, ...]:
    """Names of the signals of a component with the laws ``given``, and with or without ``friction`` that ``sticks``."""
    return _names(kind, tuple(given), friction, sticks)


@cache
def _names(kind: Kind, given: tuple[str, ...], friction: bool, sticks: bool) -> tuple[str, ...]:
    own = [name for name, formula in kind.formulas.items() if friction or "friction" not in (name, *_WORD(formula))]
    own = [name for name in own if sticks or name != sticking.SLIDING]
    results = {x.name for x in kind.results}
    before = [name for name in own if name not in results]
    return tuple(dict.fromkeys([*before, *given, *own]))
