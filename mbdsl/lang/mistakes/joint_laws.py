"""Checks of the laws of joints: positions depend on time only, velocities may depend on more, neither on reactions."""

from __future__ import annotations

from collections.abc import Mapping

from mbdsl.elements.kind import JointKind
from mbdsl.errors import ModelError
from mbdsl.expressions import symbolic
from mbdsl.expressions.printing import text
from mbdsl.expressions.symbolic import Expr


def check_law(name: str, law: Expr, kind: JointKind, owner: str) -> None:
    """Check that the law parameter ``name`` of the joint ``owner`` depends only on what is known without the joint."""
    what = f"`{name}` of {kind.name} `{owner}`"
    for leaf in symbolic.leaves(law):
        if leaf.op == "multiplier":
            raise ModelError(
                f"{what} depends on a reaction of `{leaf.value[0]}`, but reactions follow from the laws of joints",
                hint="forces, torques and variables may depend on reactions",
            )
        if kind.driver != name or leaf.op == "time":
            continue
        if leaf.op == "input":
            raise ModelError(
                f"{what} depends on the input `{leaf.value}`, whose rate is not known: an input may jump",
                hint="an input may prescribe a velocity (RotationalVelocityDriver, TranslationalVelocityDriver)",
            )
        if kind.coupled:
            raise ModelError(
                f"{what} may depend on time and parameters only, found `{text(leaf)}`",
                hint="the coordinates may be expressions of several coordinates",
            )
        raise ModelError(
            f"{what} depends on `{text(leaf)}`, but a driver prescribes a motion in time",
            hint="use `time`, parameters and tables; a force or torque may depend on signals",
        )


def check_coupling(name: str, law: Expr, arguments: Mapping[str, Expr], kind: JointKind, owner: str) -> None:
    """Check that the law parameter ``name`` is a function of the signals ``arguments``, {name: formula}, alone."""
    pending, seen = [law], set(arguments.values())
    *others, last = (f"`{argument}`" for argument in arguments)
    alone = f"{', '.join(others)} and {last}" if others else last
    example = "" if others else f", such as `{name} = profile({next(iter(arguments))})`"
    while pending:
        node = pending.pop()
        if node in seen:
            continue
        seen.add(node)
        if node.op in symbolic.LEAVES:
            raise ModelError(
                f"`{name}` of {kind.name} `{owner}` depends on `{text(node)}`, but it is a function of {alone} alone",
                hint=f"write it with {alone}, parameters and tables{example}",
            )
        pending.extend(node.args)


def check_row(name: str, row: Expr, kind: JointKind, owner: str) -> None:
    """Check that a row of velocities, which follows from the law parameter ``name``, depends on a velocity."""
    if not symbolic.is_velocity_level(row):
        raise ModelError(
            f"`{name}` of {kind.name} `{owner}` depends on no velocity",
            hint="a condition on positions is a joint or a driver, e.g. Distance or RotationalDriver; velocities are "
            "`rod.w`, `rod.b.vx`, `der(O.phi)`",
        )
