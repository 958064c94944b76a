"""What the elements of one declaration share: their kind, their modifiers, and the values if they are equal."""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.elements.kind import Kind
from mbdsl.errors import ModelError
from mbdsl.lang import modelica_names, orientations
from mbdsl.lang import syntax as s
from mbdsl.lang.argument_checks import is_vector
from mbdsl.lang.mistakes import members
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.modifiers import Modifier, Modifiers, refuse_inner
from mbdsl.lang.source import span_of
from mbdsl.messages import did_you_mean


class Template:
    """The data that the elements of one declaration share: kind, modifiers, and the values if they are equal."""

    __slots__ = ("kind", "modifiers", "shared")

    def __init__(self, kind: Kind, modifiers: Modifiers) -> None:
        self.kind = kind
        self.modifiers = modifiers
        self.shared: tuple[dict, dict, set[str]] | None = None

    def unknown(
        self,
        owner: str,
        attached: Callable[[], other_names.Attached] | None = None,
        passed: list[s.Passed] | None = None,
    ) -> None:
        """Raise an error for modifiers that the kind does not have.

        ``attached()`` is how it is declared, for advice about it.

        Modifiers of Modelica that have no effect on the motion are added to ``passed``, if it is given.
        """
        if not self.modifiers:
            return
        kind = self.kind
        measured = {signal.name for signal in kind.signals}
        known = [*(p.name for p in kind.parameters), *kind.ports]
        for name, modifier in self.modifiers.items():
            start = bool(modifier.inner) and modifier.value is None
            if (kind.parameter(name) and not (start and name in measured)) or name in kind.ports:
                if name == "frames" and kind.spatial:
                    for frame, inner in modifier.inner.items():
                        orientations.check(inner, f"frame `{frame}` of `{owner}`")
                elif name != "frames":
                    takes = f"{kind.name} takes: {', '.join(known)}"
                    refuse_inner(modifier, f"`{name}` of {kind.name} `{owner}`", takes)
                else:
                    for frame, inner in modifier.inner.items():
                        refuse_inner(inner, f"frame `{frame}` of `{owner}`", f"write `{frame} = {{x, y}}`")
                continue
            if start and name in measured:
                for attribute, inner in modifier.inner.items():
                    if attribute not in ("start", "fixed", *modelica_names.NO_EFFECT):
                        hint = did_you_mean(attribute, ("start", "fixed"), "attributes of a signal")
                        raise ModelError(f"a signal has no attribute `{attribute}`", span_of(inner.at), hint)
                    refuse_inner(inner, f"`{attribute}` of `{owner}.{name}`", f"write `{attribute} = ...`")
                    if passed is not None and attribute in modelica_names.NO_EFFECT[1:]:
                        passed.append(s.Passed(attribute, at=inner.at))
                continue
            if name in measured:
                message = f"`{name}` of `{owner}` is a signal; only its start can be given"
                raise ModelError(message, span_of(modifier.at), f"write `{name}(start = ..., fixed = true)`")
            if passed is not None and modelica_names.has_no_effect(name, modifier.value):
                passed.append(s.Passed(name, at=modifier.at))
                continue
            hint = self._axis(name, modifier, owner, attached)
            if hint == "":
                continue
            given = {key: m.value for key, m in self.modifiers.items() if m.value is not None}
            hint = hint or members.start(kind, owner, name, *modifier.start(), given)
            hint = hint or other_names.parameter(kind, known, name, given)
            hint = hint or did_you_mean(name, known, f"{kind.name} takes")
            raise ModelError(f"{kind.name} `{owner}` has no parameter `{name}`", span_of(modifier.at), hint)

    def _axis(
        self, name: str, modifier: Modifier, owner: str, attached: Callable[[], other_names.Attached] | None
    ) -> str | None:
        """The remedy if the modifier is the axis of a joint; "" if the joint has this axis."""
        if name not in ("n", "r") or modifier.value is None:
            return None
        given = modifier.evaluate()
        if not is_vector(given) or any(not x.number or x.varying for x in given):
            return None
        n = [x.known for x in given]
        joint = other_names.Attached() if attached is None else attached()
        return other_names.axis(self.kind.name, owner, n, joint)
