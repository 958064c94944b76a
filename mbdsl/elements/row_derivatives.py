"""The rows of a kind as expressions, with their derivatives and the reactions that follow from them.

Derivatives are accumulated from the result backwards (A. Griewank, A. Walther, *Evaluating Derivatives*, 2008, section
3.2), with respect to the motions z of both frames.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import combinations_with_replacement
from typing import NamedTuple

from mbdsl.elements.kind import JointKind, Kind, PairKind
from mbdsl.expressions import formulas, spatial_coordinates, symbolic
from mbdsl.expressions.derivatives import PARTIALS
from mbdsl.expressions.symbolic import Expr, call, const, coordinate, expr, is_const, multiplier, walk

PORTS = ("frame_a", "frame_b")


class RowNames:
    """The meaning of names in formulas of a kind: parameters and laws are leaves of their names."""

    def __init__(self, kind: PairKind, laws: Sequence[str] = ()) -> None:
        self.kind, self.laws = kind, laws

    def value(self, name: str) -> Expr:
        if name in self.kind.formulas and name not in self.laws:
            return formulas.evaluate(self.kind.formulas[name], self)
        return symbolic.input_signal(name)

    def element(self, name: str, index: int) -> Expr:
        return symbolic.input_signal(f"{name}[{index}]")

    def coordinate(self, port: str, key: str) -> Expr:
        return spatial_coordinates.named(port, key) if self.kind.spatial else coordinate(port, key)


def rows(kind: PairKind) -> list[Expr]:
    """The rows of a kind as expressions over frames with the names of its ports."""
    return [formulas.evaluate(x, RowNames(kind)) for x in kind.held.formulas]


#: a function of coordinates in rows -> its arguments and its derivatives with respect to them
Links = Mapping[Expr, Sequence[tuple[Expr, Expr]]]


def functions(kind: PairKind) -> tuple[Links, list[Expr]]:
    """The functions of coordinates in the rows of a kind, ``law[1]``, ..., with their first derivatives ``slope[1]``,
    ... of all of them and the second ones; and all of these in the order in which kernels read them."""
    links: dict[Expr, list[tuple[Expr, Expr]]] = {}
    order: list[Expr] = []
    count = 0
    for k, (_, signals) in enumerate(getattr(kind, "functions", ()), 1):
        arguments = [RowNames(kind).value(name) for name in signals]
        slopes = [symbolic.input_signal(f"slope[{count + i}]") for i in range(1, len(signals) + 1)]
        law, count = symbolic.input_signal(f"law[{k}]"), count + len(signals)
        links[law] = list(zip(arguments, slopes, strict=True))
        order += [law, *slopes]
        second = {}
        for i, j in combinations_with_replacement(range(len(signals)), 2):
            second[i, j] = second[j, i] = symbolic.input_signal(f"curve[{len(order)}]")
            order.append(second[i, j])
        for i, slope in enumerate(slopes):
            links[slope] = [(argument, second[i, j]) for j, argument in enumerate(arguments)]
    return links, order


def partials(root: Expr, links: Links) -> dict[Expr, Expr]:
    """The derivatives of ``root`` with respect to all its leaves."""
    found: dict[Expr, Expr] = {root: const(1.0)}
    for n in reversed(walk(root)):
        mine = found.get(n)
        if mine is None or n.op not in PARTIALS:  # leaves, and what is constant piece by piece
            continue
        if n.op == "sqrt" and (parts := _squares(n.args[0])) is not None:
            own = [(x, call("ratio", x, n)) for x in parts]  # a length: without direction, its gradient is zero
        else:
            own = list(zip(n.args, map(expr, PARTIALS[n.op](n, *n.args)), strict=True))
        for argument, slope in own:
            term = mine * slope
            found[argument] = found[argument] + term if argument in found else term
    for function in [x for x in found if x in links]:
        for argument, slope in links[function]:
            for x, d in partials(argument, links).items():
                term = found[function] * slope * d
                found[x] = found[x] + term if x in found else term
    return found


def _squares(n: Expr) -> list[Expr] | None:
    """x, y, ... of x*x + y*y + ...; None of other expressions."""
    if n.op == "add":
        parts = [_squares(x) for x in n.args]
        return None if None in parts else [x for part in parts if part for x in part]
    return [n.args[0]] if n.op == "mul" and n.args[0] is n.args[1] else None


def by_motions(root: Expr, spatial: bool, links: Links, ports: Sequence[str] = PORTS) -> list[Expr]:
    """Derivatives with respect to the motions of frames: of each port 3 entries in the plane, 6 in space."""
    found, zero = partials(root, links), const(0.0)
    result: list[Expr] = []
    for port in ports:
        if not spatial:
            result += [found.get(coordinate(port, key), zero) for key in ("x", "y", "phi")]
            continue
        rotation = [zero] * 3
        for name in "xyz":
            a = [coordinate(port, name + i) for i in "xyz"]
            d = [found.get(x, zero) for x in a]
            for i in range(3):  # d . (e_i x a) = e_i . (a x d)
                j, k = (i + 1) % 3, (i + 2) % 3
                rotation[i] = rotation[i] + (a[j] * d[k] - a[k] * d[j])
        result += [*(found.get(coordinate(port, key), zero) for key in "xyz"), *rotation]
    return result


def by_rates(root: Expr, spatial: bool, ports: Sequence[str] = PORTS) -> list[Expr]:
    """Derivatives with respect to the rates of frames, as of ``by_motions``."""
    found, keys = partials(root, {}), spatial_coordinates.VELOCITIES if spatial else symbolic.COORDINATES[3:]
    return [found.get(coordinate(port, key), const(0.0)) for port in ports for key in keys]


class Freedom(NamedTuple):
    """The axes (0: x, 1: y, 2: z) along which a joint in space lets frame_b move, and about which it lets it turn."""

    slides: tuple[int, ...]
    turns: tuple[int, ...]


@cache
def freedom(kind: Kind) -> Freedom | None:
    """What a joint in space leaves free, where its frames have the same axes; None if its rows say more than that
    coordinates of frame_b along axes of frame_a, and angles of its axes with these, are constant."""
    if not (isinstance(kind, JointKind) and kind.spatial and kind.g) or kind.held.counted:
        return None
    if kind.functions or kind.driver or kind.velocity_rows:
        return None
    at = {coordinate(port, x + y): float(x == y) for port in PORTS for x in "xyz" for y in "xyz"}
    held: tuple[set[int], set[int]] = set(), set()
    for row in rows(kind):
        gradient = by_motions(row, True, {}, PORTS[1:])
        translates = not all(is_const(x, 0.0) for x in gradient[:3])
        part = gradient[:3] if translates else gradient[3:]
        turned = any(coordinate(PORTS[1], axis) in symbolic.leaves(row) for axis in spatial_coordinates.AXES)
        moved = any(coordinate(port, key) in symbolic.leaves(*part) for port in PORTS for key in "xyz")
        if translates and (turned or moved):
            return None
        found = [i for i, x in enumerate(symbolic.evaluate(part, at.__getitem__)) if x]
        if len(found) != 1:
            return None
        held[not translates].update(found)
    slides, turns = (tuple(i for i in range(3) if i not in axes) for axes in held)
    return Freedom(slides, turns)


def axes_in(kind: PairKind) -> set[str]:
    """The ports whose axes occur in the rows of a kind in space."""
    return {x.value[0] for x in symbolic.leaves(*rows(kind)) if x.op == "coordinate" and len(x.value[1]) > 1}


@cache
def reactions(kind: JointKind) -> Mapping[str, Expr]:
    """The wrench of the multipliers on frame_b, -G_b^T lam, by the names of its components."""
    keys = ("fx", "fy", "fz", "tx", "ty", "tz") if kind.spatial else ("fx", "fy", "tau")
    links, _ = functions(kind)
    gradients = [by_motions(row, kind.spatial, links, PORTS[1:]) for row in rows(kind)]
    laws = RowNames(kind, kind.law_parameters)
    gradients += [by_rates(formulas.evaluate(x, laws), kind.spatial, PORTS[1:]) for x in kind.velocity_rows]
    found = {}
    for key, column in zip(keys, zip(*gradients, strict=True), strict=True):
        found[key] = const(0.0)
        for k, g in enumerate(column):
            found[key] = found[key] - multiplier("", k) * g
    return found if "tz" not in found else found | {"tau": found["tz"]}
