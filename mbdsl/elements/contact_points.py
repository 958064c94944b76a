"""Contact of two bodies at points: common to all kinds of contact with friction, in the plane and in space.

Each point i has formulas of its gap g_i, of the unit normal n_i, from the body of frame_a to that of frame_b, and of
its arm p_i, from the origin of frame_b to the point; vectors are in world axes. They depend on positions only. At the
point

    N = k d^n max(0, 1 + alpha d'),  d = -g > 0,  d' = -n . u              see contact_law.py
    f = N n - N mu(u_t) u_t/|u_t|                                          see friction.py, sliding_friction.py

act on the body of frame_b, with the velocity u of its point there relative to that of the body of frame_a, and its part
u_t = u - (n . u) n along the surface; the opposite force acts on the body of frame_a, at the same point. The sum of the
forces, and their moment about the origin of frame_b, are the laws of the rows

    r_b' - r_a' - w_a x (r_b - r_a),   w_b - w_a
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from mbdsl.elements import contact_law, file_of, friction, sliding_friction
from mbdsl.elements.declaration import Parameter, Signal, Touch, power
from mbdsl.elements.kind import ForceKind
from mbdsl.elements.rigid_contact import specialised
from mbdsl.elements.row import Row
from mbdsl.elements.rows import X_A, Y_A, Z_A
from mbdsl.elements.vectors import Vector, W, cross, dot, slip, total

#: velocity of the origin of frame_b relative to the point of frame_a's body there, and relative angular velocity
SLIP = (
    "(frame_b.vx - frame_a.vx + frame_a.w*(frame_b.y - frame_a.y))",
    "(frame_b.vy - frame_a.vy - frame_a.w*(frame_b.x - frame_a.x))",
)
SPIN = "(frame_b.w - frame_a.w)"
ROWS = (*map(Row, slip(), (*SLIP, "")), *map(Row, W, ("", "", SPIN)))
#: axes of frame_a, as (x, y, z) of each, in which tangents are found: they have none where n is opposite to the last
BASIS = (0.8, 0.0, -0.6), (-0.36, 0.8, -0.48), (0.48, 0.6, 0.64)


class Point(NamedTuple):
    """Formulas of a point at which two bodies touch: gap [m], unit normal, and arm [m] from the origin of frame_b; in
    space also two tangents, if they are simpler than those for any normal."""

    gap: str
    normal: Sequence[str]
    arm: Sequence[str]
    tangents: Sequence[Vector] = ()


def contact(
    name: str,
    doc: str,
    parameters: tuple[Parameter, ...],
    points: Sequence[Point],
    spatial: bool = False,
    terms: Mapping[str, str] = {},
    one: bool = False,
    **more: Any,
) -> ForceKind:
    """The declaration of a kind.

    Parameters
    ----------
    name, doc, parameters, spatial
        As of a kind; ``parameters`` are those of the shapes.
    points : sequence of Point
        Where the bodies may touch.
    terms : mapping, optional
        Formulas that those of the points contain.
    one : bool, optional
        Whether it is one contact wherever it is: its damping is set where the first point touches, which is the
        nearest one, and only then there are forces.
    **more
        Further fields; ``signals``, ``check`` and ``derive`` are in addition to those of all contacts; ``aim`` is that
        of the first rigid contact, see :class:`mbdsl.elements.declaration.Touch`.
    """
    count, signals, check, derive = len(points), *(more.pop(x, None) for x in ("signals", "check", "derive"))
    touches = 1 if one else count
    touching = tuple(_touch(i, point, count, spatial) for i, point in enumerate(points, 1))
    aim = more.pop("aim", ())
    touching = tuple(x._replace(aim=aim) if x.key == "1" else x for x in touching)
    laws = contact_law.parameters("N/m", "v_0", "m/s"), friction.parameters("v", "m/s", 1e-3)
    more.setdefault("specialised", specialised(file_of(name)))
    each, own = dict(terms), {}
    for i, point in enumerate(points, 1):
        each |= _in_space(i, point) if spatial else _in_plane(i, point)
        own |= _law(i, min(i, touches))
    loads, total = _total(count, spatial, "lt(gap_1, 0)" if one else "")
    visible, forces = _one(count, each, own) if count == 1 else _several(count, each, own)
    active = Signal("active", "1", _sum(f"lt(gap_{i}, 0)" for i in _of(count)), "number of points that touch")
    return ForceKind(
        name,
        doc=doc,
        g=ROWS,
        parameters=(*parameters, *laws[0], *laws[1]),
        signals=(*(signals or ()), *visible, *forces, active),
        results=(*loads, power(total)),
        exerts={x.name: x.name for x in loads},
        laws=tuple(x.name for x in loads),
        sign=1.0,
        energy=_sum(contact_law.energy(f"(-gap_{i})") for i in _of(count)),
        terms={"overlap": _sum(f"max(0, -gap_{i})" for i in _of(count)), **each, **own},
        searched="overlap",
        latches=tuple(contact_law.latch(i, f"lt(gap_{i}, 0)", f"-rate_{i}", "v_0") for i in _of(touches)),
        check=lambda v: (check and check(v)) or contact_law.check(v, "v_0") or friction.check(v),
        derive=lambda v: {
            **contact_law.derive(v, "v_0", touches),
            **friction.derive(v),
            **(derive(v) if derive else {}),
        },
        effects={**contact_law.EFFECTS_OR_RIGID, **friction.EFFECTS},
        touching=touching,
        spatial=spatial,
        **more,
    )


def _touch(i: int, point: Point, count: int, spatial: bool) -> Touch:
    """The rigid contact at a point. In space its slips are along the tangents

    t = e_1 - (n . e_1)/(1 + n . e_3) (n + e_3), and the same with e_2, of the axes e in ``BASIS``: those turned by the
    rotation from e_3 to n.
    """
    slips = [f"slip_{i}"]
    if spatial:
        n, u = _vector("n", i), _vector("u", i)
        e1, e2, e3 = (total(*zip(map(str, e), (X_A, Y_A, Z_A), strict=True)) for e in BASIS)
        both = total(("1", n), ("1", e3))
        turned = [total(("1", e), (f"(-{dot(n, e)}/(1 + {dot(n, e3)}))", both)) for e in (e1, e2)]
        slips = [dot(t, u) for t in point.tangents or turned]
    return Touch(str(i) if count > 1 else "contact", f"gap_{i}", tuple(slips))


def _one(count: int, each: dict[str, str], own: dict[str, str]) -> tuple[tuple[Signal, ...], tuple[Signal, ...]]:
    """The signals of motion and of force of a contact with one point."""
    visible = (
        Signal("gap", "m", "gap_1", "distance of the surfaces; negative: depth"),
        Signal("slip", "m/s", "slip_1", "velocity of frame_b's body along the surface, there"),
    )
    forces = (
        Signal("force", "N", "force_1", "normal force"),
        Signal("friction_force", "N", "drag_1", "friction, against the slip"),
    )
    return visible, forces


def _several(count: int, each: dict[str, str], own: dict[str, str]) -> tuple[tuple[Signal, ...], tuple[Signal, ...]]:
    """Those of a contact with several points; their formulas are no terms then."""
    visible = tuple(Signal(f"gap_{i}", "m", each.pop(f"gap_{i}"), f"gap of point {i}") for i in _of(count))
    least = _least([f"gap_{i}" for i in _of(count)])
    forces = tuple(Signal(f"force_{i}", "N", own.pop(f"force_{i}"), f"normal force at point {i}") for i in _of(count))
    return (
        (Signal("gap", "m", least, "least distance of the surfaces; negative: depth"), *visible),
        (Signal("force", "N", _sum(f"force_{i}" for i in _of(count)), "sum of the normal forces"), *forces),
    )


def _of(count: int) -> range:
    return range(1, count + 1)


def _sum(terms: Iterable[str]) -> str:
    return " + ".join(terms)


def _least(of: list[str]) -> str:
    found, *others = of
    for x in others:
        found = f"min({found}, {x})"
    return found


def _law(i: int, touch: int) -> dict[str, str]:
    """The normal force and the friction of a point from its gap, the rate of it, and the speed of sliding; the damping
    is that of a ``touch``."""
    normal = f"{contact_law.spring(f'(-gap_{i})')}*max(0, 1 - alpha[{touch}]*rate_{i})"
    return {f"force_{i}": normal, f"drag_{i}": friction.formula(f"force_{i}", f"slip_{i}", "v")}


def _in_plane(i: int, point: Point) -> dict[str, str]:
    """The formulas of a point: n, p, the velocities along n and along the tangent t = (n_y, -n_x), and f."""
    n, p, u = ([f"{letter}{axis}_{i}" for axis in "xy"] for letter in "npu")
    return {
        f"gap_{i}": point.gap,
        **dict(zip(n, point.normal, strict=True)),
        **dict(zip(p, point.arm, strict=True)),
        u[0]: f"{SLIP[0]} - {SPIN}*{p[1]}",
        u[1]: f"{SLIP[1]} + {SPIN}*{p[0]}",
        f"rate_{i}": f"{n[0]}*{u[0]} + {n[1]}*{u[1]}",
        f"slip_{i}": f"{n[1]}*{u[0]} - {n[0]}*{u[1]}",
        f"fx_{i}": f"force_{i}*{n[0]} - drag_{i}*{n[1]}",
        f"fy_{i}": f"force_{i}*{n[1]} + drag_{i}*{n[0]}",
        f"tau_{i}": f"{p[0]}*fy_{i} - {p[1]}*fx_{i}",
    }


def _in_space(i: int, point: Point) -> dict[str, str]:
    """The formulas of a point: n, p, u, the velocity v along the surface, and f."""
    n, p, u, v, f = (_vector(letter, i) for letter in "npuvf")
    own: dict[str, str] = {f"gap_{i}": point.gap}
    own |= dict(zip(n, point.normal, strict=True)) | dict(zip(p, point.arm, strict=True))
    own |= {x: f"{a} + {b}" for x, a, b in zip(u, slip(), cross(W, p), strict=True)}
    own[f"rate_{i}"] = dot(n, u)
    own |= {x: f"{a} - rate_{i}*{b}" for x, a, b in zip(v, u, n, strict=True)}
    own[f"slip_{i}"] = sliding_friction.speed("v", *v)
    own |= {x: f"force_{i}*{a} - drag_{i}*{b}/slip_{i}" for x, a, b in zip(f, n, v, strict=True)}
    return own | dict(zip((f"t{axis}_{i}" for axis in "xyz"), cross(p, f), strict=True))


def _vector(letter: str, i: int) -> Vector:
    return f"{letter}x_{i}", f"{letter}y_{i}", f"{letter}z_{i}"


def _total(count: int, spatial: bool, condition: str) -> tuple[tuple[Signal, ...], str]:
    """The wrench on frame_b, zero unless a ``condition`` holds, and its power."""
    names = [f"f{x}" for x in "xyz"] + [f"t{x}" for x in "xyz"] if spatial else ["fx", "fy", "tau"]
    rates = (*slip(), *W) if spatial else (*SLIP, SPIN)
    loads = []
    for name in names:
        what, unit = ("force", "N") if name[0] == "f" else ("torque", "N.m")
        doc = f"{what} on frame_b" + (f", along {name[1]}" if name != "tau" else "")
        found = _sum(f"{name}_{i}" for i in _of(count))
        loads.append(Signal(name, unit, f"select({condition}, {found}, 0)" if condition else found, doc))
    return tuple(loads), _sum(f"{name}*{rate}" for name, rate in zip(names, rates, strict=True))
